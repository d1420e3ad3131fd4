// No data and no hand make a tick longer than its bound: what it does is counted, and what is left waits, without a pull.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "palpa/core/law.h"
#include "palpa/core/probe_queue.h"
#include "palpa/core/sub_step.h"
#include "palpa/grid/derived.h"
#include "palpa/grid/grid.h"
#include "palpa/grid/smooth_grid.h"
#include "palpa/mode/modes.h"
#include "palpa/tick/session.h"
#include "palpa/volume/analytic.h"
#include "palpa/volume/volume.h"
#include "tests/tick/busy_scene.h"
#include "tests/tick/hands.h"
#include "tests/tick/hostile_scene.h"

namespace palpa {
namespace {

constexpr double tick_s = 1e-3;
constexpr double k = 400.0;

// However hostile: within the bound, with the balance that takes the last of it, and finite. Ticks do wait here.
TEST(Work, OfATickIsBounded) {
  test::Random random(1);
  int waiting = 0, most = 0;
  for (int scene = 0; scene < 8; ++scene) {
    Session session(test::hostile_scene(random, k));
    test::HostileHand hand(random);
    for (int i = 0; i < 150; ++i) {
      const Tick t = session.tick({.position_m = hand.next()}, tick_s);
      ASSERT_GT(t.work, 0);
      ASSERT_LE(t.work, Session::most_work + Session::most_work / 2);
      ASSERT_TRUE(is_finite(t.force_n) && is_finite(t.proxy_m) && std::isfinite(t.error_bound_m));
      waiting += t.status == TickStatus::waiting;
      most = std::max(most, t.work);
    }
  }
  EXPECT_GT(waiting, 100);
  EXPECT_GT(most, Session::most_work / 2);
}

// A tick without work left ends at a free place: nothing passes what is stronger than the hand, whatever else takes the work.
TEST(Work, SpentLetsNothingThrough) {
  test::Random random(8);
  int waiting = 0, pressed = 0;
  for (int scene = 0; scene < 4; ++scene) {
    Scene all = test::hostile_scene(random, k);
    const FieldRef ground = all.add("ground", plane_field(0.6));
    all.add("wall", SurfaceAndFriction{.field = ground, .levels = {{.value = 0.0, .strength_n = 1000.0}}});
    Session session(all);
    test::HostileHand hand(random);
    session.tick({.position_m = {0, 0, 0.04}}, tick_s);
    for (int i = 0; i < 200; ++i) {
      const Tick t = session.tick({.position_m = hand.next()}, tick_s);
      ASSERT_GE(t.proxy_m.z, -1e-5) << i;
      waiting += t.status == TickStatus::waiting;
      pressed += t.probe_m.z < 0.0 && t.proxy_m.z < 1e-5;
    }
  }
  EXPECT_GT(waiting, 100);
  EXPECT_GT(pressed, 20);
}

// The same hand is the same work, to the unit: nothing of it is timed.
TEST(Work, IsCounted) {
  for (const bool as_grid : {false, true}) {
    Session one(test::busy_moving_scene(as_grid)), other(test::busy_moving_scene(as_grid));
    test::Random random(2);
    test::HostileHand hand(random);
    for (int i = 0; i < 500; ++i) {
      const Vec3 at_m = hand.next();
      const Tick a = one.tick({.position_m = at_m}, tick_s), b = other.tick({.position_m = at_m}, tick_s);
      ASSERT_EQ(a.work, b.work) << i;
      ASSERT_EQ(a.proxy_m, b.proxy_m) << i;
      ASSERT_EQ(a.force_n, b.force_n) << i;
    }
  }
}

/// A rail of 0.4 N in a flow that is sampled every tenth of a millimetre.
Scene fine_rail() {
  test::Random random(3);
  Volume flow;
  flow.format = "grid";
  constexpr int n = 200;
  const auto voxels = std::make_shared<std::vector<float>>();
  for (int i = 0; i < n * n * n; ++i) voxels->insert(voxels->end(), {0.0f, 0.0f, 1.0f});
  const GridGeometry grid{{n, n, n}, 1e-4 * Mat3::identity(), {-0.01, -0.01, -0.01}};
  flow.fields.push_back({"velocity", "m/s", grid_field(grid, {VoxelType::float32, 3, {voxels, voxels->data()}})});
  Scene scene({.stiffness_n_per_m = k});
  scene.add("flow", flow);
  scene.workspace = {.scale = 1.0, .center_m = Vec3{}};
  scene.add("rail", Follow{.field = {"flow"}, .strength_n = 0.4});
  return scene;
}

// A hand too fast for such voxels feels the rail at most, never the way that waits; kept up, nothing; it is told once.
TEST(Waiting, DoesNotPull) {
  Session session(fine_rail());
  int waiting = 0, silent = 0, told = 0;
  double lags_m = 0.0;
  for (int i = 0; i < 400; ++i) {
    const double x_m = 0.008 * std::sin(2.0 * std::numbers::pi * 100.0 * tick_s * i / (i < 200 ? 0.7 : 1e3));
    const Tick t = session.tick({.position_m = {x_m, 0.001 * std::sin(0.05 * i), 0}}, tick_s);
    EXPECT_LE(norm(t.force_n), 0.4 + 1e-6) << i;
    lags_m = std::max(lags_m, distance(t.proxy_m, t.probe_m));
    waiting += t.status == TickStatus::waiting;
    silent += t.status == TickStatus::waiting && t.force_n == Vec3{};
    for (const SessionEvent& event : session.events()) told += event.kind == SessionEventKind::warning && event.mode == -1;
  }
  EXPECT_GT(lags_m, 3 * 0.4 / k) << "nothing lags";
  EXPECT_GT(waiting, 50);
  EXPECT_GT(silent, 20);
  EXPECT_GE(told, 1);
  EXPECT_LE(told, 3);
  Tick t;
  for (int i = 0; i < 300; ++i) t = session.tick({.position_m = {1e-5 * i, 0, 0}}, tick_s);
  EXPECT_EQ(t.status, TickStatus::resting);
  EXPECT_NEAR(norm(t.force_n), 0.4, 1e-6) << "felt again";
}

// The books close in every tick, whatever waits: force₀·Δp = S₀ − S + k/2|Δp|² + works + path, and what waits is the damper's.
TEST(Waiting, TheLedgerCloses) {
  test::Random random(4);
  int waiting = 0;
  for (int scene = 0; scene < 6; ++scene) {
    Session session(test::hostile_scene(random, k));
    test::HostileHand hand(random);
    Tick before;
    double waits_j = 0.0;
    for (int i = 0; i < 150; ++i) {
      const Tick t = session.tick({.position_m = hand.next()}, tick_s);
      const Energy& e = t.energy;
      const double given_j = dot(before.force_n, t.probe_step_m);
      const double lost_j = before.energy.stored_j - e.stored_j + e.ticks_bound_j + e.injected_j - e.dissipated_j + e.moved_j +
                            e.path_j + before.energy.elastic_j - e.elastic_j + e.damper_j;
      const double all_j = std::abs(before.energy.stored_j) + e.stored_j + e.ticks_bound_j + std::abs(e.path_j);
      if (i > 0) {
        ASSERT_NEAR(given_j, lost_j, 1e-12 * all_j + 1e-15) << i;
      }
      waiting += t.status == TickStatus::waiting;
      waits_j += std::abs(e.damper_j);
      before = t;
    }
    EXPECT_GT(waits_j, 0.0);
  }
  EXPECT_GT(waiting, 50);
}

// In a tick that waits the hand gets no more than what it has stretched the spring with.
TEST(Waiting, BringsInNoMoreThanTheHold) {
  Session session(fine_rail());
  test::Random random(5);
  test::Wander wander(random, 0.009);
  Tick before;
  int waiting = 0;
  for (int i = 0; i < 3000; ++i) {
    const Tick t = session.tick({.position_m = wander.at(20.0 * tick_s * i)}, tick_s);
    if (i > 0 && t.status == TickStatus::waiting) {
      const double work_j = dot(before.force_n, t.probe_step_m);
      const double lost_j = 0.5 / k * (norm_squared(before.force_n) - norm_squared(t.force_n));
      ASSERT_LE(work_j, lost_j + 0.5 * k * norm_squared(t.probe_step_m) + 1e-15) << i;
      ++waiting;
    }
    before = t;
  }
  EXPECT_GT(waiting, 100);
}

/// The phantom of a head as a scan has it.
Volume scanned_head() {
  constexpr int n = 64;
  const Volume whole = head_phantom();
  const Field& head = *whole.fields[0].field;
  const Vec3 low_m = head.bounds_m().low_m, step_m = head.bounds_m().size_m() / (n - 1.0);
  auto values = std::make_shared<std::vector<float>>();
  for (int v = 0; v < n * n * n; ++v) {
    const Vec3 at{static_cast<double>(v % n), static_cast<double>(v / n % n), static_cast<double>(v / n / n)};
    values->push_back(static_cast<float>(head.scalar(low_m + Vec3{at.x * step_m.x, at.y * step_m.y, at.z * step_m.z}).value));
  }
  const GridGeometry geometry{{n, n, n}, {{{step_m.x, 0, 0}, {0, step_m.y, 0}, {0, 0, step_m.z}}}, low_m};
  Volume volume;
  volume.fields = {{"head", "", smooth_grid_field(geometry, {VoxelType::float32, 1, {values, values->data()}})}};
  return volume;
}

// A hand that rests is followed to the end, wherever it rests and however deep: below a level that bends more than the spring
// is long, looks at where the proxy is lead back and forth. Else its force would fade with what waits.
TEST(Waiting, EndsWhereTheHandRests) {
  Scene scene({.stiffness_n_per_m = 600.0});
  scene.workspace.towards_user = "-y";
  scene.workspace.up = "+z";
  scene.add("bone", SurfaceAndFriction{.field = scene.add("head", scanned_head()),
                                       .levels = {{.value = 300.0, .strength_n = 90.0, .friction_coefficient = 0.15}}});
  int felt = 0;
  for (int way = 0; way < 13; ++way) {
    const double y_m = -0.09 + 0.18 * 10 * way / 127;
    Session comes(scene), rests(scene);
    Vec3 at_m{0, y_m, 0.1};
    comes.tick({.position_m = at_m}, tick_s);
    for (int place = 0; place < 36; ++place) {
      for (int i = 0; i < 25; ++i) comes.tick({.position_m = at_m -= Vec3{0, 0, 0.0002}}, tick_s);
      rests.continue_from(comes);
      Tick t;
      int waiting = 0;
      for (int i = 0; i < 60; ++i) {
        t = rests.tick({.position_m = at_m}, tick_s);
        waiting += i >= 30 && t.status == TickStatus::waiting;
      }
      EXPECT_EQ(waiting, 0) << "at y = " << y_m << " m, z = " << at_m.z << " m";
      felt += norm(t.force_n) > 0.1;
    }
  }
  EXPECT_GT(felt, 100);
}

// Any time step that is one has a balance with a bound, and a force, though drags over it are walls.
TEST(TimeStep, HasABoundHoweverShort) {
  for (const double dt_s : {1e-6, 1e-9, 1e-12, 1e-15, 1e-18, 1e-100, 1e-310, std::numeric_limits<double>::denorm_min()}) {
    Scene scene({.stiffness_n_per_m = k, .damping_ns_per_m = 0.5});
    const FieldRef ball = scene.add("ball", sphere_field(0.05));
    scene.workspace = {.scale = 1.0, .center_m = Vec3{}};
    scene.add("surface",
              SurfaceAndFriction{.field = ball, .levels = {{.value = 0.0, .strength_n = 3.0}}, .friction_ns_per_m = 1.0});
    scene.add("thick", Viscosity{.field = ball, .strength_n = 0.1, .drag_ns_per_m = 2.0});
    Session session(scene);
    test::Random random(6);
    for (int i = 0; i < 200; ++i) {
      const Vec3 at_m = i % 20 == 0 ? random.in_cube(0.04) : Vec3{0.001 * std::sin(0.1 * i), 0.0, 0.06 - 1e-4 * i};
      const Tick t = session.tick({.position_m = at_m}, dt_s);
      ASSERT_NE(t.status, TickStatus::bad_input) << dt_s << " s, tick " << i;
      ASSERT_LT(t.error_bound_m, 1e-3) << dt_s << " s, tick " << i;
      ASSERT_TRUE(is_finite(t.force_n) && is_finite(t.proxy_velocity_m_per_s) && is_finite(t.probe_velocity_m_per_s));
    }
  }
}

// What rounding leaves of a time step, and what a law is asked about less than the shortest, counts as the shortest.
TEST(TimeStep, IsNoShorterThanTheShortest) {
  ProbeQueue queue;
  queue.start({});
  queue.push({1.0, 0.0, 0.0}, tick_s);
  queue.pop(queue.front().first(std::nextafter(1.0, 0.0)));
  ASSERT_FALSE(queue.empty());
  EXPECT_GE(queue.front().time_s, shortest_time_s);
  const Primitive drag{.strength_n = 1.0, .drag_ns_per_m = 2.0};
  EXPECT_EQ(fall_j(drag, {1e-3, 0, 0}, {}, 1e-30), fall_j(drag, {1e-3, 0, 0}, {}, shortest_time_s));
}

// A balance may have no bound; its record then says the largest number, which readers of traces can read.
TEST(RecordedBound, IsFiniteWhereThereIsNone) {
  const Balance unproven{.error_bound_m = std::numeric_limits<double>::max(), .status = BalanceStatus::bad_input};
  EXPECT_EQ(recorded_bound_m({}, unproven, k), std::numeric_limits<double>::max());
}

}  // namespace
}  // namespace palpa
