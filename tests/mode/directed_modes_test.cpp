// Gradient, vector and vortex modes: directions, strengths, silent regions.
#include <gtest/gtest.h>

#include <cmath>

#include "palpa/data/analytic.h"
#include "palpa/data/grid.h"
#include "palpa/data/sampled.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "tests/mode/placed.h"
#include "tests/mode/resolved.h"
#include "tests/solver/random_problems.h"

namespace palpa {
namespace directed_modes_test {

using test::Place;
constexpr double k = Place::stiffness_n_per_m;

const FieldRef first = test::resolved("first", 0);

TEST(GradientForce, PullsUphillOrDownhillByItsStrength) {
  const FieldPtr ball = sphere_field(0.05).fields[0].field;
  test::Random random(1);
  for (int i = 0; i < 300; ++i) {
    const Vec3 x = random.uniform(0.02, 0.06) * random.direction();
    Place up(ball, x), down(ball, x);
    const PrimitiveSet& inwards = up.of(GradientForce{.field = first, .strength_n = 0.7});
    ASSERT_EQ(inwards.size(), 1u);
    EXPECT_EQ(inwards[0].kind, PrimitiveKind::directed);
    EXPECT_NEAR(inwards[0].strength_n, 0.7, 1e-12);
    EXPECT_LT(norm(inwards[0].direction + normalized(x)), 1e-9) << "towards the middle of the ball, where the value is high";
    const PrimitiveSet& outwards =
        down.of(GradientForce{.field = first, .strength_n = 0.7, .towards = GradientForce::Towards::low});
    EXPECT_LT(norm(outwards[0].direction - normalized(x)), 1e-9);
  }
}

// φ = R − |x|: the direction turns by 1/r per metre, so a pull s may have s/r ≤ k/2; ‖∂g/∂x‖ is √2/r.
TEST(GradientForce, FadesLinearlyWhereTheDirectionTurns) {
  const FieldPtr ball = sphere_field(0.05).fields[0].field;
  for (const double r : {0.02, 0.01, 0.005, 0.0025}) {
    Place place(ball, {0, r, 0});
    const PrimitiveSet& set = place.of(GradientForce{.field = first, .strength_n = 1000.0});
    ASSERT_EQ(set.size(), 1u);
    EXPECT_NEAR(set[0].strength_n, 0.5 * k * r / std::sqrt(2.0), 0.02 * k * r);
  }
}

TEST(VectorForce, GoesWithTheFlowAndFadesAtItsCore) {
  const FieldPtr vortex = lamb_oseen_vortex(0.02, 0.01).fields[0].field;
  for (const double r : {0.03, 0.02, 0.005, 1e-3, 1e-4}) {
    Place place(vortex, {r, 0, 0});
    const PrimitiveSet& set = place.of(VectorForce{.field = first, .strength_n = 0.5});
    ASSERT_EQ(set.size(), 1u);
    EXPECT_NEAR(set[0].direction.y, 1.0, 1e-9) << "round the axis";
    EXPECT_LE(set[0].strength_n, std::min(0.5, 0.5 * k * r) + 1e-12);
    if (r > 0.01) {
      EXPECT_DOUBLE_EQ(set[0].strength_n, 0.5);
    }
  }
}

TEST(VortexForce, PointsToTheCoreWhoeverMovesAlongAndIsSilentOutside) {
  const double core = 0.01;
  const FieldPtr velocity = sampled(*lamb_oseen_vortex(0.02, core).fields[0].field, 100);
  const FieldPtr q = derived(Derivation::q, velocity);
  test::Random random(2);
  int felt = 0;
  for (int i = 0; i < 2000; ++i) {
    const double r = random.uniform(0.3, 5.5) * core, angle = random.uniform(0, 6.28);
    const Vec3 x{r * std::cos(angle), r * std::sin(angle), random.uniform(-0.02, 0.02)};
    Place place(q, x);
    const PrimitiveSet& set = place.of(VortexForce{.field = first, .strength_n = 0.5});
    // Q of a Lamb-Oseen vortex is negative from 1.13 r_c on; smoothing moves that outwards a little.
    if (r > 1.5 * core) {
      EXPECT_EQ(set.size(), 0u) << "at " << r / core << " core radii";
    }
    if (r < core) {
      ASSERT_EQ(set.size(), 1u) << "at " << r / core << " core radii";
    }
    if (set.empty()) continue;
    ++felt;
    const Vec3 to_axis = normalized(Vec3{-x.x, -x.y, 0});
    EXPECT_GT(dot(set[0].direction, to_axis), std::cos(2.0 * 3.14159265 / 180.0)) << "at " << r / core << " core radii";
    EXPECT_LE(set[0].strength_n, 0.5);
  }
  EXPECT_GT(felt, 200);
}

TEST(VortexPlane, StandsOnTheLevelItWasCapturedOnAndFacesTheCore) {
  const double core = 0.01;
  const FieldPtr q = derived(Derivation::q, sampled(*lamb_oseen_vortex(0.02, core).fields[0].field, 100));
  const VortexPlane mode{.field = first, .strength_n = 0.5};
  Place inner(q, {0.5 * core, 0, 0});
  const double level = inner.here().scalar(first).value;
  // A little further out, with the level in memory: the plane is back at the level.
  Place outer(q, {0.52 * core, 0, 0});
  const PrimitiveSet& set = outer.of(mode, VortexPlane::Memory{true, level});
  ASSERT_EQ(set.size(), 1u);
  EXPECT_EQ(set[0].kind, PrimitiveKind::plane);
  EXPECT_LT(norm(set[0].direction - Vec3{-1, 0, 0}), 1e-3);
  EXPECT_NEAR(set[0].position_m.x, 0.5 * core, 0.02 * core * 0.1);
  EXPECT_EQ(set.captured(0).value, level);
  // Without memory it is at the proxy.
  Place fresh(q, {0.52 * core, 0, 0});
  EXPECT_LT(distance(fresh.of(mode, VortexPlane::Memory{})[0].position_m, {0.52 * core, 0, 0}), 1e-15);
}

TEST(DirectedModes, AreTheSameInAnyWorld) {
  const Volume still = sphere_field(0.05);
  test::Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Similarity pose{random.rotation(), std::exp(random.uniform(-8, 8)), random.in_cube(1.0)};
    const Vec3 x = random.uniform(0.004, 0.06) * random.direction();
    const GradientForce mode{.field = first, .strength_n = 1.5};
    Place here_now(still.fields[0].field, x);
    Place there(posed(still, pose).fields[0].field, x, pose);
    const PrimitiveSet& a = here_now.of(mode);
    const PrimitiveSet& b = there.of(mode);
    ASSERT_EQ(a.size(), b.size());
    EXPECT_LT(norm(a[0].direction - b[0].direction), 1e-9);
    EXPECT_NEAR(a[0].strength_n, b[0].strength_n, 1e-4);
  }
}

}  // namespace directed_modes_test
}  // namespace palpa
