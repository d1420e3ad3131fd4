// Sessions felt with the laws of earlier systems.
#include "palpa/tick/session.h"

#include <gtest/gtest.h>

#include <limits>

#include "palpa/baseline/law.h"
#include "palpa/field/analytic.h"
#include "palpa/mode/follow.h"
#include "palpa/mode/surface_and_friction.h"
#include "palpa/mode/viscosity.h"
#include "tests/tick/hands.h"

namespace palpa {
namespace {

Scene scene_of_many(const std::string& law) {
  Scene scene({.stiffness_n_per_m = 800, .damping_ns_per_m = 0.5});
  const FieldRef ball = scene.add("ball", sphere_field());
  const FieldRef flow = scene.add("flow", burgers_vortex());
  scene.add("surface", SurfaceAndFriction{.field = ball,
                                          .strength_n = {ball, TransferFunction({{-0.01, 0.0}, {0.0, 1.0}, {0.05, 3.0}})},
                                          .friction_coefficient = 0.3});
  scene.add("rail", Follow{.field = flow, .strength_n = 0.4, .drag_ns_per_m = 1.0});
  scene.add("air", Viscosity{.strength_n = 0.05, .drag_ns_per_m = 0.5});
  scene.law = law;
  return scene;
}

class BaselineSession : public testing::TestWithParam<const char*> {};

TEST_P(BaselineSession, TicksStayFiniteUnderEveryHand) {
  const Scene scene = scene_of_many(GetParam());
  Session session(scene, baseline::law(scene));
  test::Random random(1);
  const test::Wander hand(random, 0.09);
  for (int i = 0; i < 20000; ++i) {
    Probe probe{.position_m = hand.at(i * 1e-3)};
    double dt = 1e-3;
    if (i % 97 == 0) probe.position_m = random.in_cube(1.0);
    if (i % 331 == 0) probe.position_m.x = std::numeric_limits<double>::quiet_NaN();
    if (i % 701 == 0) probe.valid = false;
    if (i % 503 == 0) dt = random.below(2) ? 0.0 : 1e-12;
    const Tick tick = session.tick(probe, dt);
    ASSERT_TRUE(is_finite(tick.proxy_m) && is_finite(tick.force_n) && std::isfinite(tick.error_bound_m)) << i;
    ASSERT_LE(tick.sub_steps, 1);
    for (const ModeTick& mode : session.modes()) ASSERT_TRUE(is_finite(mode.force_n)) << i;
  }
}

TEST_P(BaselineSession, IsFelt) {
  const Scene scene = scene_of_many(GetParam());
  Session session(scene, baseline::law(scene));
  test::Random random(2);
  const test::Wander hand(random, 0.05);
  double felt_n[3] = {};
  for (int i = 0; i < 5000; ++i) {
    session.tick({.position_m = hand.at(i * 1e-3)}, 1e-3);
    for (int m = 0; m < 3; ++m) felt_n[m] += norm(session.modes()[m].force_n) / 5000;
  }
  for (int m = 0; m < 3; ++m) EXPECT_GT(felt_n[m], 0.01) << scene.modes()[m].name;
}

INSTANTIATE_TEST_SUITE_P(Laws, BaselineSession,
                         testing::Values("paper-2005", "ikits-2003", "ikits-2003-sequential", "no-proxy"), [](const auto& i) {
                           std::string name = i.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace palpa
