// Laws of surfaces: nothing drifts, the bumpy sphere is where it is, grooves let a hand rest.
#include "tests/path/surfaces.h"

#include <gtest/gtest.h>

#include "palpa/field/analytic.h"

namespace palpa::test {
namespace {

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

struct GrooveKind {
  Filter filter;
  bool binary;
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
    EXPECT_EQ(groove.lost_ticks, 0) << opening << "°";
  }
}

INSTANTIATE_TEST_SUITE_P(Filters, SampledSphere, testing::Values(Filter::trilinear, Filter::smooth, Filter::cubic),
                         [](const auto& one) { return name_of(one.param); });
INSTANTIATE_TEST_SUITE_P(Voxels, BumpySphereIsFelt, testing::Values(128, 256),
                         [](const auto& one) { return "of" + std::to_string(one.param); });
INSTANTIATE_TEST_SUITE_P(Kinds, Grooves,
                         // The trilinear's own facets make hollows of every groove: docs/path.md says how it does there.
                         testing::Values(GrooveKind{Filter::smooth, false}, GrooveKind{Filter::smooth, true}),
                         [](const auto& one) {
                           return std::string(name_of(one.param.filter)) + (one.param.binary ? "_binary" : "_smooth_edge");
                         });

}  // namespace
}  // namespace palpa::test
