// Bounded work of a tick; pending motion without a pull.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "palpa/data/analytic.h"
#include "palpa/data/derived.h"
#include "palpa/data/field.h"
#include "palpa/data/grid.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/timed_field.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "palpa/mode/tick_work.h"
#include "palpa/session/probe_queue.h"
#include "palpa/session/session.h"
#include "palpa/session/sub_step.h"
#include "palpa/solver/law.h"
#include "tests/session/busy_scene.h"
#include "tests/session/hands.h"
#include "tests/session/hostile_scene.h"

namespace palpa {
namespace work_test {

constexpr double tick_s = 1e-3;
constexpr double k = 400.0;

// Under hostile input: within the bound, with the last balance, and finite. Some ticks have pending motion.
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

// A tick with exhausted work ends at a free point: no constraint stronger than the hand is passed.
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

class Counted final : public Field {
 public:
  Counted(FieldPtr of, std::int64_t& values) : of_(std::move(of)), values_(values) {}
  int components() const noexcept override { return 3; }
  int values_per_sample() const noexcept override { return of_->values_per_sample(); }
  VectorSample vector(const Vec3& at_m) const noexcept override { return count(), of_->vector(at_m); }
  PolynomialPiece piece_along(const Vec3& from_m, const Vec3& to_m, double begin,
                              const ValueRange& quiet) const noexcept override {
    return count(), of_->piece_along(from_m, to_m, begin, quiet);
  }
  double spacing_m() const noexcept override { return of_->spacing_m(); }
  Box bounds_m() const noexcept override { return of_->bounds_m(); }
  double depth_m(const Vec3& at_m) const noexcept override { return of_->depth_m(at_m); }
  std::vector<ValueRange> value_ranges() const override { return of_->value_ranges(); }

 private:
  void count() const noexcept { values_ += of_->values_per_sample(); }
  FieldPtr of_;
  std::int64_t& values_;
};

// A tick's read values are bounded for any kind of data: larger samples mean fewer of them. A unit is at most two samples, the
// ends of a piece, and up to twice `values_each`, as units are whole.
TEST(Work, IsWhatIsReadOfTheDataOfAnyKind) {
  enum { linear, smooth, signless_smooth, between_frames, kinds };
  for (int kind = linear; kind < kinds; ++kind) {
    test::Random random(7);
    std::int64_t values = 0;
    const auto counted = [&](const FieldPtr& field) -> FieldPtr { return std::make_shared<Counted>(field, values); };
    FieldPtr field = test::noise(random, 3, 5e-4, kind != linear);
    if (kind >= signless_smooth) field = signless(field);
    field = kind == between_frames ? time_series({counted(field), counted(field)}, 0.1) : counted(field);
    Volume data;
    data.fields.push_back({"velocity", "m/s", field});
    Scene scene({.stiffness_n_per_m = k});
    const FieldRef u = scene.add("data", data), length{"magnitude(data)"};
    scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
    scene.edit<TimeOptions>([&](auto& time) { time.play = TimeOptions::Play::loop; });
    scene.add("rail", Follow{.field = u, .strength_n = 1.0, .drag_ns_per_m = 0.5});
    scene.add("push", VectorForce{.field = u, .strength_n = {length, TransferFunction({{0.0, 0.0}, {1.0, 2.0}})}});
    for (int n = 0; n < 3; ++n) {
      scene.add("length" + std::to_string(n),
                SurfaceAndFriction{.field = length, .levels = {{.value = 0.5 + 0.2 * n, .strength_n = 0.5}}});
    }
    Session session(scene);
    test::HostileHand hand(random);
    int waiting = 0;
    for (int i = 0; i < 600; ++i) {
      values = 0;
      const Tick t = session.tick({.position_m = hand.next()}, tick_s);
      ASSERT_LE(values, 2 * 2 * tick_work::values_each * t.work) << kind << ", " << i;
      waiting += t.status == TickStatus::waiting;
    }
    EXPECT_GT(waiting, 50) << kind;
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
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  scene.add("rail", Follow{.field = {"flow"}, .strength_n = 0.4});
  return scene;
}

// A hand too fast for these voxels gets at most the rail's force, no pull of the pending path, and no force once caught up; the
// event is logged once.
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
  EXPECT_EQ(t.status, TickStatus::complete);
  EXPECT_NEAR(norm(t.force_n), 0.4, 1e-6) << "felt again";
}

// The ledger closes in every tick, with any pending motion: force₀·Δp = S₀ − S + k/2|Δp|² + works + path, and the pending part
// is the damper's.
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
      const double lost_j = before.energy.stored_j - e.stored_j + e.sampling_bound_j + e.injected_j - e.dissipated_j +
                            e.data_motion_j + e.path_and_release_j + before.energy.elastic_j - e.elastic_j + e.damper_j;
      const double all_j = std::abs(before.energy.stored_j) + e.stored_j + e.sampling_bound_j + std::abs(e.path_and_release_j);
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

// With pending motion the hand gets at most the energy of its own extension of the spring.
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

// A hand at rest is followed to the end, at any depth: below a level that bends more than the spring is long, samples at the
// proxy lead back and forth. Else its force would fade with the pending motion.
TEST(Waiting, EndsWhereTheHandRests) {
  Scene scene({.stiffness_n_per_m = 600.0});
  scene.edit<Workspace>([&](auto& workspace) {
    workspace.towards_user = "-y";
    workspace.up = "+z";
  });
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
      rests.copy_state_from(comes);
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

/// Cells about the z axis, down to `low_m` [m]: no cell on the axis contains the level, as only a visit of each shows.
constexpr double cell_m = 1e-5;
void add_corridor(Scene& scene, const std::string& name, double low_m, int cells) {
  const auto voxels = std::make_shared<std::vector<float>>();
  for (int v = 0; v < 9 * (cells + 1); ++v) voxels->push_back(v % 3 == 2 || v / 3 % 3 == 2 ? 1.0f : 0.0f);
  const GridGeometry grid{{3, 3, cells + 1}, cell_m * Mat3::identity(), {-0.5 * cell_m, -0.5 * cell_m, low_m}};
  Volume volume;
  volume.format = "grid";
  volume.fields.push_back({"value", "", grid_field(grid, {VoxelType::float32, 1, {voxels, voxels->data()}})});
  scene.add("sides_" + name,
            SurfaceAndFriction{.field = scene.add(name, volume), .levels = {{.value = 0.5, .strength_n = 0.5}}});
}

// A path through air with more cells than a tick's budget takes several ticks: none passes or reports the wall behind them, and
// the air does not pull. Then the wall has its normal force.
TEST(Waiting, AFlightGoesOnWhereTheWorkEnded) {
  Scene scene({.stiffness_n_per_m = k});
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  add_corridor(scene, "corridor", 0.012, 9000);
  const FieldRef ground = scene.add("ground", plane_field(0.02));
  scene.add("wall", SurfaceAndFriction{.field = ground, .levels = {{.value = 0.0, .strength_n = 1000.0}}});
  Session session(scene);
  session.tick({.position_m = {0, 0, 0.11}}, tick_s);
  int waiting = 0;
  Tick t;
  for (int i = 0; i < 6; ++i) {
    t = session.tick({.position_m = {0, 0, -0.005}}, tick_s);
    EXPECT_LE(t.work, Session::most_work + 16) << i;
    EXPECT_EQ(t.status == TickStatus::waiting, t.work >= Session::most_work) << i;
    EXPECT_GE(t.proxy_m.z, -1e-9) << i;
    if (t.status == TickStatus::waiting) {
      EXPECT_EQ(t.force_n, Vec3{}) << i;
    }
    waiting += t.status == TickStatus::waiting;
  }
  EXPECT_EQ(waiting, 2);
  EXPECT_NEAR(t.proxy_m.z, 0.0, 1e-9);
  for (int i = 0; i < 20; ++i) t = session.tick({.position_m = {0, 0, -0.005}}, tick_s);
  EXPECT_NEAR(t.force_n.z, 0.005 * k, 1e-6);
  for (int i = 1; i <= 60; ++i)
    t = session.tick({.position_m = {0, 0, -0.005 + (i < 30 ? 2e-4 * i : 2e-4 * (60 - i))}}, tick_s);
  EXPECT_NEAR(t.force_n.z, 0.005 * k, 1e-6);
}

TEST(Waiting, FieldsShareTheWork) {
  constexpr int cells = 9000, fields = 3;
  Scene scene({.stiffness_n_per_m = k});
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  for (int f = 0; f < fields; ++f) add_corridor(scene, "corridor" + std::to_string(f), 0.012, cells);
  Session session(scene);
  session.tick({.position_m = {0, 0, 0.11}}, tick_s);
  int waiting = 0;
  while (session.tick({.position_m = {0, 0, 0.0}}, tick_s).status == TickStatus::waiting && waiting < 100) ++waiting;
  EXPECT_GE(waiting, cells * fields / Session::most_work);
  EXPECT_LE(waiting, cells * fields / Session::most_work + 2);
}

// For any end of a tick's work a level breaks where k·depth is its strength, or later by a segment, never before; that search
// keeps work for a balance. Twelve modes make the balances long.
TEST(Work, ThatEndsLetsNothingGoBefore) {
  constexpr double strength_n = 1.0;
  constexpr int modes = 12;
  Scene scene({.stiffness_n_per_m = k});
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  add_corridor(scene, "corridor", 0.012, 9000);
  const FieldRef ground = scene.add("ground", plane_field(0.02));
  for (int m = 0; m < modes; ++m) {
    scene.add("wall" + std::to_string(m),
              SurfaceAndFriction{
                  .field = ground, .levels = {{.value = 0.0, .strength_n = strength_n / modes}}, .friction_coefficient = 0.3});
  }
  int spent = 0;
  for (int cells = 7496; cells < 7646; cells += 3) {  // of the second tick these leave all, or nothing, for the wall
    Session session(scene);
    session.tick({.position_m = {0, 0, 0.012 + cell_m * (cells + 0.5)}}, tick_s);
    int broken = 0;
    for (int i = 0; i < 6; ++i) {
      const Tick t = session.tick({.position_m = {0, 0, i == 0 ? -0.002 : -0.003}}, tick_s);
      ASSERT_LE(t.work, Session::most_work + 64) << cells;
      ASSERT_EQ(t.status == TickStatus::waiting, t.work >= Session::most_work) << cells;
      spent += i > 0 && t.work >= Session::most_work;
      for (const SessionEvent& event : session.events()) {
        if (event.kind != SessionEventKind::break_through) continue;
        ASSERT_GE(k * event.depth_m, strength_n - k * 2.1e-8) << cells;
        ASSERT_LE(k * event.depth_m, strength_n + k * 0.5 * 0.02 / 64) << cells;
        ++broken;
      }
    }
    ASSERT_GT(broken, 0) << cells;
  }
  EXPECT_GT(spent, 30);
}

// Twenty-one modes with friction on one rough wall: their balances exhaust the work, and friction is corrected no more.
TEST(Work, ThatEndsCorrectsNoFriction) {
  test::Random random(5);
  Volume values;
  values.format = "grid";
  values.fields.push_back({"value", "", test::noise(random, 1, 1e-3, false)});
  Scene scene({.stiffness_n_per_m = k});
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  const FieldRef rough = scene.add("rough", values);
  for (int m = 0; m < 21; ++m) {
    scene.add("wall" + std::to_string(m),
              SurfaceAndFriction{.field = rough, .levels = {{.value = 0.1, .strength_n = 100.0}}, .friction_coefficient = 0.8});
  }
  Session session(scene);
  test::Wander wander(random, 0.01);
  int spent = 0;
  for (int i = 0; i < 150; ++i) {
    const Tick t = session.tick({.position_m = wander.at(0.01 * i)}, tick_s);
    ASSERT_LE(t.work, Session::most_work + Session::most_work / 3) << i;
    spent += t.work >= Session::most_work;
  }
  EXPECT_GT(spent, 40);
}

/// A washboard whose gradient always leads further into it: samples there do not help.
class Misleading final : public Field {
 public:
  int components() const noexcept override { return 1; }
  ScalarSample scalar(const Vec3& at_m) const noexcept override {
    const double value = height_m * std::sin(at_m.x / wave_m) - at_m.z, sign = value > 1e-7 ? -1.0 : 1.0;
    return {value, sign * Vec3{height_m / wave_m * std::cos(at_m.x / wave_m), 0.0, -1.0}, true};
  }
  double spacing_m() const noexcept override { return 1e-3; }
  Box bounds_m() const noexcept override { return {{-1, -1, -1}, {1, 1, 1}}; }
  double depth_m(const Vec3&) const noexcept override { return 1.0; }
  std::vector<ValueRange> value_ranges() const override { return {{-2.0, 2.0}}; }

 private:
  static constexpr double height_m = 3e-5, wave_m = 1e-4;
};

// If no end of a move is free, each tried end is searched in a hundred other fields. With exhausted work no other end is tried;
// the motion stays pending, and the force is at most that of the last processed position, however far the hand goes on.
TEST(Work, ThatEndsTriesNoOtherEnd) {
  constexpr int others = 100;
  Scene scene({.stiffness_n_per_m = k});
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  Volume washboard;
  washboard.fields.push_back({"value", "", std::make_shared<Misleading>()});
  scene.add("wall",
            SurfaceAndFriction{.field = scene.add("washboard", washboard), .levels = {{.value = 0.0, .strength_n = 100.0}}});
  for (int m = 0; m < others; ++m) {
    const FieldRef far = scene.add("far" + std::to_string(m), plane_field(0.02), {.translation_m = {1.0, 0.0, 0.0}});
    scene.add("idle" + std::to_string(m), SurfaceAndFriction{.field = far, .levels = {{.value = 0.0, .strength_n = 1.0}}});
  }
  Session session(scene);
  Vec3 followed_m;
  int waiting = 0;
  for (int i = 0; i < 60; ++i) {
    const Tick t = session.tick({.position_m = {1e-4 * i, 0, i < 2 ? 0.001 : -0.001}}, tick_s);
    ASSERT_LE(t.work, Session::most_work + others + 16) << i;
    ASSERT_EQ(t.status == TickStatus::waiting, t.work >= Session::most_work) << i;
    if (t.status != TickStatus::waiting) followed_m = t.probe_m;
    ASSERT_LE(norm(t.force_n), k * distance(t.proxy_m, followed_m) + 1e-9) << i;
    waiting += t.status == TickStatus::waiting;
  }
  EXPECT_GT(waiting, 50);
}

// Any valid time step has a balance with a bound, and a force, though drags over it are walls.
TEST(TimeStep, HasABoundHoweverShort) {
  for (const double dt_s : {1e-6, 1e-9, 1e-12, 1e-15, 1e-18, 1e-100, 1e-310, std::numeric_limits<double>::denorm_min()}) {
    Scene scene({.stiffness_n_per_m = k, .damping_ns_per_m = 0.5});
    const FieldRef ball = scene.add("ball", sphere_field(0.05));
    scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
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

// Time steps below the shortest, by rounding or in a law's input, count as the shortest.
TEST(TimeStep, IsNoShorterThanTheShortest) {
  ProbeQueue queue;
  queue.start({});
  queue.push({{1.0, 0.0, 0.0}, {}}, tick_s, Tool());
  queue.pop(queue.front().first(std::nextafter(1.0, 0.0), Tool()), Tool());
  ASSERT_FALSE(queue.empty());
  EXPECT_GE(queue.front().time_s, shortest_time_s);
  const Primitive drag{.strength_n = 1.0, .drag_ns_per_m = 2.0};
  EXPECT_EQ(fall_j(drag, {1e-3, 0, 0}, {}, 1e-30), fall_j(drag, {1e-3, 0, 0}, {}, shortest_time_s));
}

// Without a bound the record has the largest finite number, which readers of traces accept.
TEST(RecordedBound, IsFiniteWhereThereIsNone) {
  const Balance unproven{.error_bound_m = std::numeric_limits<double>::max(), .status = BalanceStatus::bad_input};
  EXPECT_EQ(recorded_bound_m({}, unproven, k, 1e-3), std::numeric_limits<double>::max());
}

}  // namespace work_test
}  // namespace palpa
