// Fade of a level at break-through; levels stronger than the output limit.
#include "palpa/guard/break_through_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "palpa/data/analytic.h"
#include "palpa/loop/loop.h"
#include "palpa/mode/modes.h"
#include "tests/solver/random_problems.h"

namespace palpa {
namespace release_test {

using test::Random;

constexpr double dt_s = 1e-3;

/// The filter of a force without a torque.
class ForceFilter {
 public:
  Vec3 shape(const Vec3& command_n, bool is_released, double by_hand_n, double time_step_s, bool springs_released = false) {
    return filter_.shape({command_n, {}}, is_released, by_hand_n, time_step_s, springs_released, 1.0).force_n;
  }
  double snap_n() const { return filter_.snap_n(); }
  void reset() { filter_.reset(); }

 private:
  BreakThroughFilter filter_;
};

// A torque falls with the force, on one line, as a force at the turning radius.
TEST(BreakThroughFilter, LetsForceAndTorqueFallTogether) {
  Random random(9);
  for (int run = 0; run < 200; ++run) {
    const double radius_m = random.uniform(1e-3, 0.3);
    const Wrench before{random.in_cube(8.0), radius_m * random.in_cube(8.0)}, after{random.in_cube(2.0), {}};
    BreakThroughFilter filter;
    filter.shape(before, false, 0.0, dt_s, false, radius_m);
    const Wrench whole = after - before;
    const double apart_n = size_n(whole, radius_m);
    EXPECT_NEAR(apart_n, std::hypot(norm(whole.force_n), norm(whole.torque_nm) / radius_m), 1e-12 * apart_n);
    for (int i = 1; i <= 25; ++i) {
      const Wrench sent = filter.shape(after, i == 1, 0.0, dt_s, false, radius_m);
      const double share = std::min(1.0, i * dt_s / std::clamp(apart_n / 500.0, 0.005, 0.020));
      EXPECT_NEAR(size_n(sent - (before + share * whole), radius_m), 0.0, 1e-9 * apart_n) << i;
    }
  }
}

TEST(BreakThroughFilter, LeavesACommandAsItIsWhileNothingLetsGo) {
  Random random(1);
  ForceFilter release;
  for (int i = 0; i < 1000; ++i) {
    const Vec3 command_n = random.in_cube(5.0);
    EXPECT_EQ(release.shape(command_n, false, 0.0, dt_s), command_n);
  }
}

// Between any two forces, at any rate: in a straight line, in 5 to 20 ms, at 0.5 N/ms where that allows it.
TEST(BreakThroughFilter, FallsInAStraightLineInItsTime) {
  Random random(2);
  for (int run = 0; run < 500; ++run) {
    const double step_s = random.uniform(1e-4, 2e-3);
    const Vec3 before_n = random.in_cube(8.0), after_n = random.below(2) == 0 ? Vec3{} : random.in_cube(2.0);
    const double apart_n = distance(before_n, after_n);
    const double whole_s = std::clamp(apart_n / 500.0, 0.005, 0.020);
    ForceFilter release;
    release.shape(before_n, false, 0.0, step_s);
    Vec3 last_n = before_n;
    double t_s = 0.0;
    for (bool first = true; t_s < 0.03; first = false) {
      const Vec3 sent_n = release.shape(after_n, first, 0.0, step_s);
      t_s += step_s;
      EXPECT_LE(distance(sent_n, last_n), apart_n * step_s / whole_s + 1e-12);
      EXPECT_NEAR(distance(sent_n, after_n), apart_n * std::max(0.0, 1.0 - t_s / whole_s), 1e-9);
      if (t_s > whole_s + 1e-9) {
        EXPECT_EQ(sent_n, after_n);
      }
      last_n = sent_n;
    }
  }
}

// A proxy that snaps over an edge: steps above the tactile threshold take 20 ms, others none.
TEST(BreakThroughFilter, SpreadsWhatAProxyLetsGo) {
  Random random(11);
  for (int run = 0; run < 500; ++run) {
    const Vec3 before_n = random.in_cube(2.0),
               after_n = before_n + random.uniform(0.0, run % 2 ? 1.0 : 8.0) * random.direction();
    const double apart_n = distance(before_n, after_n), by_hand_n = random.below(2) ? 0.0 : random.uniform(0.0, 0.02);
    ForceFilter release;
    release.shape(before_n, false, 0.0, dt_s);
    Vec3 last_n = before_n;
    for (int i = 0; i < 25; ++i) {
      const Vec3 sent_n = release.shape(after_n, false, by_hand_n, dt_s, i == 0);
      EXPECT_EQ(release.snap_n(), i == 0 && apart_n > by_hand_n + 0.05 ? apart_n : 0.0);
      if (apart_n <= by_hand_n + 0.05) {
        ASSERT_EQ(sent_n, after_n);
      } else {
        EXPECT_LE(distance(sent_n, last_n), std::max(by_hand_n, apart_n / 20) + 1e-12);
      }
      last_n = sent_n;
    }
    EXPECT_EQ(last_n, after_n) << "it has arrived";
  }
}

// A further step during the fade has 20 ms again, also without a release.
TEST(BreakThroughFilter, SpreadsWhatStepsWhileAProxyLetsGo) {
  Random random(13);
  int begun_again = 0;
  for (int run = 0; run < 500; ++run) {
    const double by_hand_n = random.uniform(0.0, 0.02);
    ForceFilter release;
    Vec3 command_n = random.in_cube(2.0), last_n = release.shape(command_n, false, 0.0, dt_s);
    command_n += random.uniform(0.1, run % 2 ? 1.0 : 8.0) * random.direction();
    double furthest_n = 0.0;
    for (int i = 0; i < 60; ++i) {
      if (i > 0 && i < 20 && random.below(4) == 0) command_n += random.uniform(0.0, 1.0) * random.direction();
      const double apart_n = distance(command_n, last_n);
      furthest_n = std::max(furthest_n, apart_n);
      const Vec3 sent_n = release.shape(command_n, false, by_hand_n, dt_s, i == 0);
      ASSERT_LE(distance(sent_n, last_n), by_hand_n + std::max(0.05, furthest_n / 20) + 1e-8) << i;
      begun_again += i > 0 && release.snap_n() > 0.0;
      last_n = sent_n;
    }
    EXPECT_EQ(last_n, command_n) << "it has arrived";
  }
  EXPECT_GT(begun_again, 100);
}

// For any motion of the hand: at most the energy of the spring's loss in this step, with the force held for a tick.
TEST(BreakThroughFilter, GivesNoMoreThanTheSpringLetGo) {
  Random random(12);
  for (int run = 0; run < 2000; ++run) {
    const double k = random.uniform(200.0, 2000.0), speed = random.uniform(0.0, 0.3);
    const Vec3 before_n = random.in_cube(2.0), after_n = random.in_cube(2.0);
    const bool is_level = random.below(2);
    ForceFilter release;
    release.shape(before_n, false, 0.0, dt_s);
    double given_j = 0.0, held_j = 0.0;
    Vec3 lag_n = before_n - after_n;  // the force of the tick before acts until this tick
    const Vec3 along = normalized(lag_n);
    for (int i = 0; i < 25; ++i) {
      const Vec3 step_m = dt_s * speed * (random.below(4) ? along : random.direction());
      if (i > 0) given_j += dot(lag_n, step_m);
      held_j += 0.5 * k * norm_squared(step_m);
      lag_n = release.shape(after_n, is_level && i == 0, k * norm(step_m), dt_s, i == 0) - after_n;
    }
    EXPECT_LE(given_j, norm_squared(before_n - after_n) / (2.0 * k) + held_j) << speed;
  }
}

// As where drags hold the proxy after a break-through: the spring's own fall is a part of the half newton.
TEST(BreakThroughFilter, IsAllOfTheChangeOfATickWhateverTheSpringDoesMeanwhile) {
  Random random(3);
  for (int run = 0; run < 500; ++run) {
    const Vec3 before_n = random.in_cube(3.0);
    const double relaxes_s = random.uniform(2e-4, 5e-3);
    ForceFilter release;
    release.shape(before_n, false, 0.0, dt_s);
    Vec3 last_n = before_n;
    for (int i = 0; i < 25; ++i) {
      const Vec3 command_n = std::exp(-dt_s * (i + 1) / relaxes_s) * before_n;
      const Vec3 sent_n = release.shape(command_n, i == 0, 0.0, dt_s);
      EXPECT_LE(distance(sent_n, last_n), 0.5 + 1e-9) << "N in a millisecond";
      EXPECT_GE(norm(sent_n), norm(command_n) - 1e-12);
      last_n = sent_n;
    }
  }
}

// For any input: never longer than the force at the start, over in 20 ms, and no further behind than the spring's change beyond
// the hand's own.
TEST(BreakThroughFilter, AddsNoForceOfItsOwnAndEnds) {
  Random random(4);
  for (int run = 0; run < 500; ++run) {
    ForceFilter release;
    Vec3 last_n = random.in_cube(8.0), last_command_n = last_n;
    release.shape(last_n, false, 0.0, dt_s);
    for (int i = 0; i < 40; ++i) {
      const Vec3 command_n = random.below(3) == 0 ? random.in_cube(8.0) : last_command_n + random.in_cube(0.3);
      const double by_hand_n = random.below(2) == 0 ? 0.0 : random.uniform(0.0, 2.0);
      const Vec3 sent_n = release.shape(command_n, i == 0, by_hand_n, dt_s);
      EXPECT_LE(norm(sent_n), std::max(norm(last_n), norm(command_n)) + 1e-12);
      EXPECT_LE(distance(sent_n, command_n),
                std::max(0.0, distance(last_n, last_command_n) + distance(command_n, last_command_n) - by_hand_n) + 1e-12);
      if (i >= 20) {
        EXPECT_EQ(sent_n, command_n);
      }
      last_n = sent_n;
      last_command_n = command_n;
    }
  }
}

TEST(BreakThroughFilter, BeginsAnewWhereTheNextLevelLetsGo) {
  ForceFilter release;
  release.shape({0, 0, 5}, false, 0.0, dt_s);
  Vec3 last_n{0, 0, 5};
  for (int i = 0; i < 40; ++i) {
    const Vec3 sent_n = release.shape({}, i == 0 || i == 4, 0.0, dt_s);
    EXPECT_LE(last_n.z - sent_n.z, 0.5 + 1e-9);
    last_n = sent_n;
  }
  EXPECT_EQ(last_n, Vec3{});
  release.shape({0, 0, 5}, false, 0.0, dt_s);
  release.shape({}, true, 0.0, dt_s);
  release.reset();
  EXPECT_EQ(release.shape({0, 0, 1}, false, 0.0, dt_s), (Vec3{0, 0, 1}));
}

/// A half space below z = 0 with one level there.
Scene wall(double strength_n, double max_force_n, bool material = false) {
  Scene scene({.stiffness_n_per_m = 500.0, .damping_ns_per_m = 0.0, .max_force_n = max_force_n});
  const FieldRef field = scene.add("wall", plane_field());
  SurfaceAndFriction surface{.field = field};
  if (material) {
    surface.strength_n = Strength{strength_n};
  } else {
    surface.levels = {{.name = "wall", .value = 0.0, .strength_n = Strength{strength_n}}};
  }
  scene.add("surface", surface);
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  return scene;
}

/// A hand straight down to `depth_m` and up again.
struct Pressed {
  int breaks = 0;
  double deepest_proxy_m = 0.0;
  double largest_command_n = 0.0;
  double fastest_fall_n = 0.0;
  double unbooked_j = 0.0;  ///< largest difference between work on the hand, withheld energy and force × path
};
Pressed press(const Scene& scene, double depth_m, double device_max_force_n) {
  Session session(scene);
  GuardedSession guarded(session, device_max_force_n);
  Pressed pressed;
  constexpr int ticks = 2000;
  TickFrame before{};
  for (int i = 0; i <= ticks; ++i) {
    const double share = 1.0 - std::abs(2.0 * i / ticks - 1.0);
    const Probe probe{.position_m = {0.001, 0.0, 0.002 - share * (depth_m + 0.002)}};
    const TickFrame frame = guarded.tick(i, dt_s * i, dt_s, probe);
    for (const SessionEvent& event : session.events()) pressed.breaks += event.kind == SessionEventKind::break_through;
    pressed.deepest_proxy_m = std::max(pressed.deepest_proxy_m, -frame.result.proxy_m.z);
    pressed.largest_command_n = std::max(pressed.largest_command_n, norm(frame.command.force_n));
    pressed.fastest_fall_n = std::max(pressed.fastest_fall_n, before.command.force_n.z - frame.command.force_n.z);
    const double given_j = dot(before.result.force_n, frame.result.probe_step_m);
    pressed.unbooked_j =
        std::max(pressed.unbooked_j, std::abs(given_j - frame.command.work_on_hand_j - frame.command.withheld_j));
    before = frame;
  }
  return pressed;
}

TEST(BreakThroughFilter, OfALevelIsAFallOfHalfANewtonAMillisecondAndBooked) {
  for (const double strength_n : {0.5, 2.0, 5.0, 9.0}) {
    for (const double drag_ns_per_m : {0.0, 0.2, 1.0, 3.0}) {
      Scene scene = wall(strength_n, 10.0);
      if (drag_ns_per_m > 0.0) scene.add("syrup", Viscosity{.drag_ns_per_m = drag_ns_per_m});
      const Pressed pressed = press(scene, 0.025, 20.0);
      EXPECT_EQ(pressed.breaks, 1) << strength_n;
      EXPECT_LE(pressed.fastest_fall_n, 0.5 + 1e-9) << strength_n << " N, " << drag_ns_per_m << " N·s/m";
      EXPECT_NEAR(pressed.largest_command_n, strength_n, 0.05 + drag_ns_per_m * 0.05) << strength_n;
      EXPECT_LE(pressed.unbooked_j, 1e-15);
    }
  }
}

// Its break-through would be hidden: the hand would get the limit before and after it.
TEST(BreakThroughFilter, NeverIsOfALevelStrongerThanWhatReachesTheHand) {
  for (const double strength_n : {3.5, 5.0, 12.0, 60.0}) {
    for (const bool by_device : {false, true}) {
      const Pressed pressed = press(wall(strength_n, by_device ? 20.0 : 3.3), 0.20, by_device ? 3.3 : 20.0);
      EXPECT_EQ(pressed.breaks, 0) << strength_n;
      EXPECT_LE(pressed.deepest_proxy_m, 1e-9);
      EXPECT_LE(pressed.largest_command_n, 3.3);
    }
  }
  EXPECT_EQ(press(wall(3.2, 3.3), 0.20, 20.0).breaks, 1);
}

TEST(BreakThroughFilter, IsOfNoMaterialThatYields) {
  const Pressed pressed = press(wall(1.0, 10.0, true), 0.02, 20.0);
  EXPECT_EQ(pressed.breaks, 0);
  EXPECT_GT(pressed.deepest_proxy_m, 0.01);
  EXPECT_NEAR(pressed.largest_command_n, 1.0, 1e-3);
}

// A strength that rises and falls within the hand's path of a tick, as at the edge of a wing's boundary layer: the release is
// faded and reported, with no step above the tactile threshold beyond the hand's own.
TEST(BreakThroughFilter, LeavesNoStepOfAStrengthThatIsSteepInSpace) {
  constexpr double k = 600.0, step_m = 5e-5;
  const auto scene_of = [](auto mode, double edge_m) {
    Scene scene({.stiffness_n_per_m = k, .damping_ns_per_m = 0.0});
    scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
    const FieldRef depth = scene.add("plane", plane_field(0.2)), flow = scene.add("vortex", lamb_oseen_vortex());
    mode.field = std::is_same_v<decltype(mode), SurfaceAndFriction> ? depth : flow;
    mode.strength_n = Strength(depth, TransferFunction({{-1.0, 0.0}, {-edge_m, 0.0}, {edge_m, 1.0}, {1.0, 1.0}}));
    scene.add("mode", mode);
    return scene;
  };
  Random random(17);
  int steps_of_force = 0, told = 0;
  for (int run = 0; run < 400; ++run) {
    const double edge_m = run % 2 ? 0.0 : random.uniform(0.0, 2e-4);
    const Scene scene = run % 8 < 2   ? scene_of(Viscosity{}, edge_m)
                        : run % 8 < 4 ? scene_of(Follow{}, edge_m)
                        : run % 8 < 6 ? scene_of(VectorForce{}, edge_m)
                                      : scene_of(SurfaceAndFriction{}, edge_m);
    Session session(scene);
    GuardedSession guarded(session, 20.0);
    const Vec3 direction = random.direction(), middle_m = 0.02 * random.direction();
    TickFrame before;
    int told_at = -100;
    for (int i = 0; i < 1200; ++i) {
      const TickFrame frame = guarded.tick(i, dt_s * i, dt_s, {.position_m = middle_m + (i - 600) * step_m * direction});
      for (const SessionEvent& event : session.events()) {
        if (event.kind == SessionEventKind::onset || event.kind == SessionEventKind::break_through) told_at = i;
      }
      told += frame.command.snap_n > 0.0;
      if (frame.command.snap_n > 0.0) told_at = i;
      const auto beyond_hand_n = [&](const Vec3& now_n, const Vec3& before_n) {
        return distance(now_n, before_n) - k * step_m;
      };
      if (i > 0) steps_of_force += beyond_hand_n(frame.result.force_n, before.result.force_n) > 0.5;
      if (i > 0 && i > told_at + 20) {
        ASSERT_LE(beyond_hand_n(frame.command.force_n, before.command.force_n), 0.05) << run << ", " << i;
      }
      before = frame;
    }
  }
  EXPECT_GT(steps_of_force, 30);
  EXPECT_GE(told, steps_of_force);
}

}  // namespace release_test
}  // namespace palpa
