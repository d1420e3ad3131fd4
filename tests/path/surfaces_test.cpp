// Surfaces: no drift, a bumpy sphere at its true position, rest in grooves.
#include "tests/path/surfaces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "palpa/data/analytic.h"

namespace palpa::test {
namespace surfaces_test {

TEST(SurfacePath, DriftsNowhereOnASphereFromAFormula) {
  const Drift drift = measure_drift(sphere_field(drift_sphere_m).fields.front().field, {.planes = 2, .turns = 5});
  EXPECT_LT(drift.per_turn_m, 1e-9);
}

// A surface of curvatures κ₁ and κ₂ between smoothed voxels moves inwards by h²(κ₁ + κ₂)/6.
double farthest_off_m(Filter filter) {
  const double shift_m = 1e-3 * 1e-3 * (2.0 / drift_sphere_m) / 6.0;
  switch (filter) {
    case Filter::trilinear: return 20e-6;
    case Filter::smooth: return shift_m + 7e-6;
    case Filter::cubic: return 3e-6;
  }
  return 0.0;
}

class SampledSphere : public testing::TestWithParam<Filter> {};

TEST_P(SampledSphere, IsFeltWhereItIsAndDoesNotDrift) {
  const Drift drift = measure_drift(sampled_sphere(GetParam()), {.planes = 5, .turns = 5});
  EXPECT_LT(drift.off_p99_m, farthest_off_m(GetParam()));
  EXPECT_LT(drift.per_turn_m, 0.02e-6);
}

class BumpySphereIsFelt : public testing::TestWithParam<int> {};

TEST_P(BumpySphereIsFelt, WhereItIsWithItsOwnNormal) {
  for (const double speed : {0.05, 0.20}) {
    const Bumpy bumpy = measure_bumpy({.voxels = GetParam(), .speed_m_per_s = speed, .ticks = 6000});
    EXPECT_GT(bumpy.contact_ticks, 3000);
    EXPECT_LT(bumpy.surface_p99_voxels, 0.05);
    EXPECT_LT(bumpy.direction_p99_deg, speed < 0.1 ? 2.0 : 2.5);
    EXPECT_LT(bumpy.ideal_direction_p99_deg, speed < 0.1 ? 2.0 : 2.5);
    EXPECT_EQ(bumpy.stray_ticks, 0);
  }
}

// A groove of 60° with 1 mm voxels: the bottom is nearest to a probe straight below it, a flank is not.
TEST(Audit, FindsANearerPlaceWhereThereIsOne) {
  constexpr double voxel_m = 1e-3;
  const Depth solid = groove(std::numbers::pi / 3.0);
  const FieldPtr field = formula([&](const Vec3& x) { return ScalarSample{solid(x), {}, true}; }, 0.04, voxel_m);
  const Vec3 probe{0, -2e-3, 0};
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    EXPECT_FALSE(could_be_nearer(*field, voxel_m, {}, probe, random));
    const double up_m = random.uniform(0.1, 3.0) * voxel_m;
    const Vec3 on_flank{up_m * std::tan(std::numbers::pi / 6.0), up_m, 0};
    EXPECT_TRUE(could_be_nearer(*field, voxel_m, on_flank, probe, random)) << up_m;
    const Vec3 into_flank = on_flank + 2e-3 * Vec3{std::cos(std::numbers::pi / 6.0), -0.5, 0};
    EXPECT_FALSE(could_be_nearer(*field, voxel_m, on_flank, into_flank, random)) << up_m;
  }
}

struct GrooveKind {
  Filter filter;
  bool binary;
  // With `trilinear` over a ramp edge some ticks end in motion, in one orientation a few with a still hand: docs/path.md,
  // section 9.
  bool always_rests() const { return filter != Filter::trilinear || binary; }
  friend std::ostream& operator<<(std::ostream& out, const GrooveKind& kind) {
    return out << name_of(kind.filter) << (kind.binary ? ", binary" : ", smooth edge");
  }
};
class Grooves : public testing::TestWithParam<GrooveKind> {};

TEST_P(Grooves, LetAHandRestAndHoldIt) {
  for (const double opening : {20.0, 30.0, 40.0, 50.0, 60.0}) {
    const Groove groove =
        measure_groove({.opening_deg = opening, .binary = GetParam().binary, .filter = GetParam().filter, .orientations = 3});
    EXPECT_LT(groove.never_rest_share, 0.01) << opening << "°";
    EXPECT_LE(groove.sub_steps_p99, 10) << opening << "°";
    // The trilinear's own facets make pits, through which a hand may press a proxy at its nearest point.
    if (GetParam().filter != Filter::trilinear) {
      EXPECT_EQ(groove.lost_ticks, 0) << opening << "°";
    }
  }
}

TEST_P(Grooves, RestIsRest) {
  int audited = 0, false_rests = 0;
  for (const double opening : {20.0, 30.0, 40.0, 50.0, 60.0, 90.0, 120.0}) {
    // A share: of few orientations one dominates, in which the level pinches at the pressed proxy.
    const Groove groove =
        measure_groove({.opening_deg = opening, .binary = GetParam().binary, .filter = GetParam().filter, .orientations = 20});
    EXPECT_LE(groove.never_rest_share, GetParam().always_rests() ? 0.003 : 0.03) << opening << "°";
    EXPECT_LE(groove.restless_still_share, GetParam().always_rests() ? 0.0 : 0.05) << opening << "°";
    EXPECT_EQ(groove.false_break_throughs, 0) << opening << "°, of " << groove.break_throughs;
    audited += groove.audited;
    false_rests += groove.false_rests;
  }
  EXPECT_GT(audited, 2000);
  EXPECT_LT(false_rests, 1e-3 * audited);
}

INSTANTIATE_TEST_SUITE_P(Filters, SampledSphere, testing::Values(Filter::trilinear, Filter::smooth, Filter::cubic),
                         [](const auto& one) { return name_of(one.param); });
INSTANTIATE_TEST_SUITE_P(Voxels, BumpySphereIsFelt, testing::Values(128, 256),
                         [](const auto& one) { return "of" + std::to_string(one.param); });
INSTANTIATE_TEST_SUITE_P(Kinds, Grooves,
                         testing::Values(GrooveKind{Filter::trilinear, false}, GrooveKind{Filter::trilinear, true},
                                         GrooveKind{Filter::smooth, false}, GrooveKind{Filter::smooth, true}),
                         [](const auto& one) {
                           return std::string(name_of(one.param.filter)) + (one.param.binary ? "_binary" : "_smooth_edge");
                         });

}  // namespace surfaces_test
}  // namespace palpa::test
