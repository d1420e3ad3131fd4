// Samples: cached and shared values equal each field's own, after any earlier samples.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>

#include "palpa/data/analytic.h"
#include "palpa/data/derived.h"
#include "palpa/data/grid.h"
#include "palpa/data/sampled.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/timed_field.h"
#include "palpa/mode/mode_context.h"
#include "tests/solver/random_problems.h"

namespace palpa {
namespace samples_test {

/// Two scalar fields and a vector field on one grid with their derived fields, a field on another grid, a posed field, a
/// formula.
std::vector<FieldPtr> any_fields() {
  const FieldPtr flow = sampled(*lamb_oseen_vortex(0.02, 0.01).fields[0].field, 24);
  const FieldPtr q = derived(Derivation::q, flow), ball = sphere_field(0.05).fields[0].field;
  const GridView grid = *grid_behind(*sampled(*ball, 20));
  return {q,
          derived(Derivation::lambda2, flow),
          derived(Derivation::magnitude, flow),
          derived(Derivation::component_y, flow),
          flow,
          smooth_grid_field(grid.geometry, grid.voxels),
          posed(q, {test::Random(5).rotation(), 1.5, {0.001, 0, 0}}),
          ball,
          grid_field(grid.geometry, grid.voxels)};
}

/// A sample of one field at one position.
struct Asked {
  std::int32_t field;
  Vec3 hand_m;
  int what;
};

class SamplesOfFields : public testing::Test {
 protected:
  void expect_as_by_itself(Samples& samples, const Asked& asked) const {
    const Field& field = *fields_[static_cast<std::size_t>(asked.field)];
    const Vec3 world_m = map_.to_world(asked.hand_m);
    switch (asked.what) {
      case 0: {
        const ScalarSample own = field.scalar(world_m), seen = samples.scalar(asked.field, asked.hand_m);
        EXPECT_EQ(seen.inside, own.inside);
        EXPECT_EQ(seen.value, own.value);
        EXPECT_EQ(seen.gradient, map_.gradient_to_hand(own.gradient));
        return;
      }
      case 1: {
        const VectorSample own = field.vector(world_m), seen = samples.vector(asked.field, asked.hand_m);
        EXPECT_EQ(seen.inside, own.inside);
        EXPECT_EQ(seen.value, map_.direction_to_hand(own.value));
        EXPECT_EQ(seen.jacobian, map_.jacobian_to_hand(own.jacobian));
        return;
      }
      case 2:
        EXPECT_EQ(samples.hessian(asked.field, asked.hand_m), map_.scale * map_.jacobian_to_hand(field.hessian(world_m)));
        return;
      default: EXPECT_EQ(samples.depth_m(asked.field, asked.hand_m), map_.length_to_hand(field.depth_m(world_m)));
    }
  }
  Asked any(test::Random& random, const std::array<Vec3, 6>& places) const {
    return {static_cast<std::int32_t>(random.uniform(0, static_cast<double>(fields_.size()) - 0.01)),
            places[static_cast<std::size_t>(random.uniform(0, 5.99))], static_cast<int>(random.uniform(0, 3.99))};
  }

  std::vector<FieldPtr> fields_ = any_fields();
  Similarity map_{test::Random(3).rotation(), 0.5, {0.002, -0.001, 0}};
};

TEST_F(SamplesOfFields, AreThoseOfEachFieldInAnyOrder) {
  test::Random random(11);
  Samples samples(fields_, map_);
  for (int round = 0; round < 200; ++round) {
    std::array<Vec3, 6> places;
    for (Vec3& place : places) place = map_.to_hand(random.in_cube(0.03));
    for (int n = 0; n < 40; ++n) expect_as_by_itself(samples, any(random, places));
  }
}

/// Series of grids at a frame and between, moved ones, and magnitudes and components of them.
std::vector<FieldPtr> any_timed_fields() {
  const auto smooth = [](const FieldPtr& grid) { return filtered(grid, Filter::smooth); };
  const FieldPtr flow = smooth(sampled(*lamb_oseen_vortex(0.02, 0.01).fields[0].field, 24));
  const FieldPtr later = smooth(sampled(*lamb_oseen_vortex(0.03, 0.01).fields[0].field, 24));
  const FieldPtr flows = time_series({flow, later}, 1.0), q = derived(Derivation::q, flows);
  const FieldPtr moved = moving(flows, {{0.0, {}}, {2.0, {test::Random(5).rotation(), 1.5, {0.001, 0, 0}}}});
  return {q,
          derived(Derivation::lambda2, flows),
          derived(Derivation::magnitude, flows),
          derived(Derivation::component_y, flows),
          flows,
          moved,
          derived(Derivation::magnitude, moved),
          derived(Derivation::q, flow),
          time_series({flow, later}, 0.7, BetweenFrames::nearest)};
}

TEST(SamplesOfTimedFields, AreThoseOfEachFieldAtItsMoment) {
  test::Random random(14);
  const std::vector<FieldPtr> fields = any_timed_fields();
  const Similarity map{test::Random(3).rotation(), 0.5, {0.002, -0.001, 0}};
  Samples samples(fields, map);
  for (int round = 0; round < 400; ++round) {
    const DataTime at{round % 3 == 0 ? static_cast<double>(round % 2) : random.uniform(0.0, 1.2)};
    samples.set_time(at);
    for (int n = 0; n < 20; ++n) {
      const auto i = static_cast<std::int32_t>(random.uniform(0, static_cast<double>(fields.size()) - 0.01));
      const FieldPtr now = frozen(fields[static_cast<std::size_t>(i)], at);
      const Vec3 hand_m = map.to_hand(random.in_cube(0.02)), world_m = map.to_world(hand_m);
      if (n % 3 == 0) {
        EXPECT_EQ(samples.hessian(i, hand_m), map.scale * map.jacobian_to_hand(now->hessian(world_m)));
      }
      const ScalarSample own = now->scalar(world_m), seen = samples.scalar(i, hand_m);
      EXPECT_EQ(seen.inside, own.inside);
      EXPECT_EQ(seen.value, own.value);
      EXPECT_EQ(seen.gradient, map.gradient_to_hand(own.gradient));
      EXPECT_EQ(samples.vector(i, hand_m).value, map.direction_to_hand(now->vector(world_m).value));
      EXPECT_EQ(samples.depth_m(i, hand_m), map.length_to_hand(now->depth_m(world_m)));
    }
  }
}

TEST(SamplesOfTimedFields, CountTheirMoments) {
  const std::vector<FieldPtr> fields = any_timed_fields();
  Samples samples(fields, {});
  const std::uint64_t first = samples.moment_of(0);
  samples.set_time(0.5);
  EXPECT_NE(samples.moment_of(0), first);
  const std::uint64_t second = samples.moment_of(0);
  samples.set_time(0.5, 0.3);
  EXPECT_EQ(samples.moment_of(0), second);
  samples.set_time(0.0);
  EXPECT_NE(samples.moment_of(0), first);
  EXPECT_EQ(samples.moment_of(7), 0U) << "it does not change with time";
  // Between frames two values are summed for each one of a frame.
  const int at_frame = samples.work_of_look(4);
  samples.set_time(0.5);
  EXPECT_GE(samples.work_of_look(4), 2 * at_frame);
}

TEST_F(SamplesOfFields, HoldUntilThreeOtherPositionsWereAskedFor) {
  test::Random random(12);
  Samples samples(fields_, map_);
  for (int n = 0; n < 100; ++n) {
    const auto place = [&] { return map_.to_hand(random.in_cube(0.02)); };
    const ScalarSample& held = samples.scalar(0, place());
    const ScalarSample copy = held;
    for (std::size_t other = 1; other < Samples::remembered; ++other) samples.scalar(0, place());
    EXPECT_EQ(held.value, copy.value);
    EXPECT_EQ(held.gradient, copy.gradient);
  }
}

TEST_F(SamplesOfFields, CertificatesBoundThemInTheHandFrame) {
  test::Random random(13);
  Samples samples(fields_, map_);
  int certified = 0, bent = 0;
  for (int n = 0; n < 2000; ++n) {
    const auto field = static_cast<std::int32_t>(n % 4);
    const Vec3 x = map_.to_hand(random.in_cube(0.02));
    const LipschitzBound c = samples.lipschitz_bound(field, x);
    if (c.radius_m == 0.0) continue;
    ++certified;
    const Vec3 y = x + random.uniform(0, 0.999) * c.radius_m * random.direction();
    const ScalarSample at_x = samples.scalar(field, x), at_y = samples.scalar(field, y);
    EXPECT_EQ(at_x.inside, at_y.inside);
    EXPECT_LE(std::abs(at_y.value - at_x.value), c.change(distance(x, y)));
    if (!std::isfinite(c.bend_per_m2)) continue;
    ++bent;
    EXPECT_LE(std::abs(at_y.value - at_x.value - dot(at_x.gradient, y - x)), c.off_tangent(distance(x, y)));
  }
  EXPECT_GT(certified, 1000);
  EXPECT_GT(bent, 300);
}

TEST_F(SamplesOfFields, SpacingsAreOfTheHandFrame) {
  const Samples samples(fields_, map_);
  EXPECT_EQ(samples.spacing_m(0), map_.length_to_hand(fields_[0]->spacing_m()));
  EXPECT_EQ(samples.local_spacing_m(0, Vec3{}), samples.spacing_m(0));
  EXPECT_EQ(samples.spacing_m(-1), 0.0);
  EXPECT_EQ(samples.local_spacing_m(99, Vec3{}), 0.0);
}

}  // namespace samples_test
}  // namespace palpa
