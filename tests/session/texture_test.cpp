// Texture: friction modulated by the detail that a smoothing filter removes.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "palpa/data/filter.h"
#include "palpa/data/fine_detail.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "palpa/scene/mode_inputs.h"
#include "palpa/session/session.h"
#include "tests/mode/resolved.h"
#include "tests/session/friction_work.h"
#include "tests/session/hands.h"

namespace palpa {
namespace texture_test {

constexpr double dt = 1e-3;
constexpr double stiffness_n_per_m = 800.0;

/// A ball (or, of radius 0, the half space below z = 0) of 64³ voxels of noise about the distance to its surface.
Volume rough(double radius_m, double noise_m, Filter filter) {
  constexpr int n = 64;
  constexpr double step_m = 0.16 / (n - 1);
  test::Random random(77);
  auto values = std::make_shared<std::vector<double>>();
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const Vec3 x{step_m * i - 0.08, step_m * j - 0.08, step_m * k - 0.08};
        const double depth_m = radius_m > 0.0 ? radius_m - norm(x) : -x.z;
        values->push_back(depth_m + random.uniform(-noise_m, noise_m));
      }
    }
  }
  const GridGeometry geometry{{n, n, n}, {{{step_m, 0, 0}, {0, step_m, 0}, {0, 0, step_m}}}, {-0.08, -0.08, -0.08}};
  Volume volume;
  const Voxels voxels{VoxelType::float64, 1, std::shared_ptr<const void>(values, values->data())};
  volume.fields.push_back({"depth", "m", filtered(grid_field(geometry, voxels), filter)});
  return volume;
}

Scene scene_of(const Volume& data, SurfaceAndFriction mode, Filter filter = Filter::smooth, const Similarity& pose = {}) {
  Scene scene({.stiffness_n_per_m = stiffness_n_per_m});
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}, .towards_user = "+z", .up = "+y"});
  mode.field = scene.add("data", data, pose, filter);
  scene.add("surface", mode);
  return scene;
}

SurfaceAndFriction skin(double friction_n, double coefficient, double texture) {
  return {.levels = {{.value = 0.0, .strength_n = 8.0}},
          .friction_n = friction_n,
          .friction_coefficient = coefficient,
          .texture_ratio = texture};
}

/// Expects bit-identical ticks in two sessions under any hand; returns the number of ticks in contact.
int expect_the_same(const Scene& one, const Scene& other) {
  Session a(one), b(other);
  test::Random random(5);
  const test::Wander hand(random, 0.08);
  int in_contact = 0;
  for (int i = 0; i < 3000; ++i) {
    const Tick ta = a.tick({.position_m = hand.at(dt * i)}, dt), tb = b.tick({.position_m = hand.at(dt * i)}, dt);
    EXPECT_EQ(ta.proxy_m, tb.proxy_m) << i;
    EXPECT_EQ(ta.force_n, tb.force_n) << i;
    if (testing::Test::HasFailure()) break;
    in_contact += norm(ta.force_n) > 1e-3;
  }
  return in_contact;
}

TEST(Texture, ChangesNoBitWhereThereIsNoDetailOrNoFriction) {
  for (const Filter filter : {Filter::trilinear, Filter::cubic}) {
    const Volume data = rough(0.05, 2e-4, filter);
    EXPECT_GT(expect_the_same(scene_of(data, skin(0.0, 0.3, 0.0), filter), scene_of(data, skin(0.0, 0.3, 1.0), filter)), 100);
  }
  // Quantities without friction are unchanged: the surface and its normal force are the field's own.
  const Volume data = rough(0.05, 2e-4, Filter::smooth);
  SurfaceAndFriction off = skin(0.0, 0.3, 0.0), on = skin(0.0, 0.3, 1.0);
  off.levels[0].friction_coefficient = on.levels[0].friction_coefficient = 0.0;
  EXPECT_GT(expect_the_same(scene_of(data, off), scene_of(data, on)), 100);
}

TEST(Texture, IsLookedAtOnlyWhereItIsOn) {
  for (const double texture : {0.0, 0.5}) {
    const Scene scene = scene_of(rough(0.05, 2e-4, Filter::smooth), skin(0.0, 0.3, texture));
    SceneMode mode = scene.modes()[0];
    std::vector<FieldPtr> fields{scene.volumes()[0].volume.fields[0].field};
    EXPECT_EQ(resolve(mode, scene, fields).fields.size(), texture > 0.0 ? 2u : 1u);
    EXPECT_EQ(fields.size(), texture > 0.0 ? 2u : 1u);
  }
}

// Placed friction: 1 + texture · t times the friction without, t at the step's start, or at the footing on an elastic level.
TEST(Texture, IsAFactorOnWhatIsPlaced) {
  const FieldPtr field = rough(0.05, 2e-4, Filter::smooth).fields[0].field;
  const std::vector<FieldPtr> fields{field, derived(Derivation::detail, field)};
  Samples samples(fields, {});
  test::Random random(12);
  for (int i = 0; i < 500; ++i) {
    const Vec3 at = (0.05 + random.uniform(-1e-3, 1e-3)) * random.direction();
    const double texture = random.uniform(0.0, 1.0), ratio = random.uniform(1.0, 2.0);
    ModeContext here(samples, at + 1e-4 * random.direction(), {}, {});
    here.proxy_m = here.probe_m = at;
    here.stiffness_n_per_m = stiffness_n_per_m;
    for (const bool coulomb : {false, true}) {
      SurfaceAndFriction mode = skin(coulomb ? 0.0 : 0.2, coulomb ? 0.3 : 0.0, texture);
      const Contact footing{.offset_m = coulomb ? 2e-3 * random.direction() : Vec3{}};
      if (coulomb) mode.levels[0].stiffness_n_per_m = 300.0;
      here.contacts = {&footing, coulomb ? 1u : 0u};
      mode.field = test::resolved("data", 0, 1);
      mode.static_friction_ratio = ratio;
      mode.friction_ns_per_m = 0.7;
      SurfaceAndFriction::Memory memory;
      memory.shells[0].level = 0;
      PrimitiveSet with, without;
      with.clear(at);
      without.clear(at);
      mode.place(here, memory, with);
      mode.texture_ratio = 0.0;
      mode.place(here, memory, without);
      ASSERT_EQ(with.size(), 2u);
      ASSERT_EQ(without.size(), 2u);
      EXPECT_EQ(with[0].position_m, without[0].position_m);
      EXPECT_EQ(with[0].direction, without[0].direction);
      EXPECT_EQ(with[0].strength_n, without[0].strength_n);
      EXPECT_EQ(with[1].direction, without[1].direction);
      EXPECT_EQ(with[1].drag_ns_per_m, without[1].drag_ns_per_m);
      EXPECT_NEAR(with[1].strength_n, (1.0 + texture * fields[1]->scalar(at + footing.offset_m).value) * without[1].strength_n,
                  1e-12);
    }
  }
}

// The line's strength, at every sub-step, is the friction times 1 + texture · t.
TEST(Texture, KeepsFrictionBetweenOneMinusAndOnePlusItself) {
  for (const double texture : {0.3, 1.0}) {
    for (const bool coulomb : {false, true}) {
      Session session(scene_of(rough(0.05, 2e-4, Filter::smooth), skin(coulomb ? 0.0 : 0.2, coulomb ? 0.3 : 0.0, texture)));
      test::Random random(6);
      const test::Wander hand(random, 0.08);
      double least = 1e9, most = 0.0;
      for (int i = 0; i < 4000; ++i) {
        session.tick({.position_m = hand.at(dt * i)}, dt);
        for (const SubStep& step : session.sub_steps()) {
          double pressed_n = 0.0;
          const auto placed = session.primitives().subspan(step.first_primitive, step.primitives);
          for (const PlacedPrimitive& row : placed) {
            if (row.primitive.kind != PrimitiveKind::line) pressed_n += norm(row.force_n);
          }
          for (const PlacedPrimitive& row : placed) {
            if (row.primitive.kind != PrimitiveKind::line) continue;
            ASSERT_GE(row.primitive.strength_n, 0.0);
            const double friction_n = coulomb ? 0.3 * pressed_n : 0.2;
            // Facets of a corner share its force: their lengths add up to it or more.
            ASSERT_LE(row.primitive.strength_n, (1.0 + texture) * friction_n + 1e-9);
            if (coulomb && (placed.size() != 2 || pressed_n < 0.05)) continue;
            const double ratio = row.primitive.strength_n / friction_n;
            ASSERT_GE(ratio, 1.0 - texture - 1e-6);
            least = std::min(least, ratio);
            most = std::max(most, ratio);
          }
        }
      }
      EXPECT_LT(least, 1.0 - 0.25 * texture);
      EXPECT_GT(most, 1.0 + 0.25 * texture);
    }
  }
}

// A slide over many voxels of noise: the friction on average, and rougher with more texture.
TEST(Texture, LeavesTheMeanOfFrictionAndRoughensIt) {
  constexpr double friction_n = 0.3, speed_m_per_s = 0.05;
  double spread[3] = {};
  for (int level = 0; level < 3; ++level) {
    double sum = 0.0, squares = 0.0;
    int ticks = 0;
    for (int row = 0; row < 8; ++row) {
      Session session(scene_of(rough(0.0, 3e-4, Filter::smooth), skin(friction_n, 0.0, 0.5 * level)));
      const double y_m = 0.05 - 0.013 * row;
      for (int i = 0; i <= 200; ++i) session.tick({.position_m = {-0.06, y_m, 0.004 - 2.5e-5 * i}}, dt);
      for (int i = 0; i < 2000; ++i) {
        const Tick tick = session.tick({.position_m = {-0.06 + speed_m_per_s * dt * i, y_m, -0.001}}, dt);
        if (i < 100) continue;
        sum += -tick.force_n.x;
        squares += tick.force_n.x * tick.force_n.x;
        ++ticks;
      }
    }
    const double mean_n = sum / ticks;
    EXPECT_NEAR(mean_n, friction_n, 0.1 * friction_n) << level;
    spread[level] = std::sqrt(squares / ticks - mean_n * mean_n);
  }
  EXPECT_GT(spread[1], 1.3 * spread[0]);
  EXPECT_GT(spread[2], 1.3 * spread[1]);
}

TEST(Texture, LeavesTheSurfaceWhereItIs) {
  const Volume data = rough(0.05, 2e-4, Filter::smooth);
  for (const double texture : {0.0, 1.0}) {
    Session session(scene_of(data, skin(0.2, 0.0, texture)));
    test::Random random(8);
    const test::Wander hand(random, 0.06);
    int held = 0;
    for (int i = 0; i < 3000; ++i) {
      const Tick tick = session.tick({.position_m = hand.at(dt * i)}, dt);
      if (norm(tick.force_n) < 1e-3 || norm(tick.force_n) > 7.9) continue;
      const ScalarSample at = data.fields[0].field->scalar(tick.proxy_m);
      EXPECT_LT(at.value, 1e-6) << i << ": never below it";
      ++held;
    }
    EXPECT_GT(held, 100);
  }
}

TEST(Texture, NeverBringsEnergyIn) {
  test::Random random(9);
  for (int run = 0; run < 24; ++run) {
    const bool coulomb = run % 2 == 0;
    SurfaceAndFriction surface = skin(coulomb ? 0.0 : 0.3, coulomb ? 0.3 : 0.0, run < 16 ? 1.0 : 0.4);
    surface.static_friction_ratio = run % 3 == 0 ? 1.8 : 1.0;
    if (run % 4 == 1) surface.levels[0].stiffness_n_per_m = 500.0;
    Session session(scene_of(rough(0.05, 2e-4, Filter::smooth), surface));
    const test::Wander hand(random, 0.08);
    SCOPED_TRACE(run);
    test::expect_that_friction_takes(session, hand);
  }
}

// A quarter turn of data and hand together turns the force.
TEST(Texture, TurnsWithTheWorldAndTheHand) {
  const Volume data = rough(0.05, 2e-4, Filter::smooth);
  const SurfaceAndFriction surface = skin(0.0, 0.4, 1.0);
  for (const Mat3& rotation : {Mat3{{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}}, Mat3{{{1, 0, 0}, {0, 0, -1}, {0, 1, 0}}}}) {
    Session a(scene_of(data, surface)), b(scene_of(data, surface, Filter::smooth, {.rotation = rotation}));
    test::Random random(10);
    const test::Wander hand(random, 0.08);
    int in_contact = 0;
    for (int i = 0; i < 2000; ++i) {
      const Tick ta = a.tick({.position_m = hand.at(dt * i)}, dt);
      const Tick tb = b.tick({.position_m = rotation * hand.at(dt * i)}, dt);
      ASSERT_NEAR(distance(tb.force_n, rotation * ta.force_n), 0.0, 1e-6) << i;
      in_contact += norm(ta.force_n) > 1e-3;
    }
    EXPECT_GT(in_contact, 100);
  }
}

// Samples share the position with the field, and equal the detail's own.
TEST(Texture, SamplesOfDetailAreItsOwn) {
  const FieldPtr field = rough(0.05, 2e-4, Filter::smooth).fields[0].field;
  const FieldPtr detail = derived(Derivation::detail, field);
  const std::vector<FieldPtr> fields{field, detail, posed(detail, {.scale = 2.0})};
  test::Random random(11);
  const Similarity map{random.rotation(), 0.5, {0.002, -0.001, 0}};
  Samples samples(fields, map);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 hand_m = map.to_hand(random.in_cube(0.1)), world_m = map.to_world(hand_m);
    for (const std::int32_t f : {1, 0, 2}) {
      const ScalarSample own = fields[static_cast<std::size_t>(f)]->scalar(world_m), seen = samples.scalar(f, hand_m);
      EXPECT_EQ(seen.inside, own.inside);
      EXPECT_EQ(seen.value, own.value);
    }
    EXPECT_EQ(samples.depth_m(1, hand_m), samples.depth_m(0, hand_m));
    EXPECT_EQ(samples.lipschitz_bound(1, hand_m).radius_m, 0.0);
  }
}

TEST(Texture, OfNothingIsTold) {
  EXPECT_NE(skin(0.0, 0.0, 0.5).problem(), "");
  EXPECT_EQ(skin(0.0, 0.3, 0.5).problem(), "");
  const auto warnings = [](Filter filter, double texture) {
    return scene_of(rough(0.05, 2e-4, filter), skin(0.0, 0.3, texture), filter).check();
  };
  EXPECT_TRUE(warnings(Filter::smooth, 0.5).empty());
  EXPECT_TRUE(warnings(Filter::cubic, 0.0).empty());
  ASSERT_EQ(warnings(Filter::cubic, 0.5).size(), 1u);
  EXPECT_NE(warnings(Filter::cubic, 0.5)[0].find("'texture_ratio' in mode 'surface' is not felt"), std::string::npos);
}

}  // namespace texture_test
}  // namespace palpa
