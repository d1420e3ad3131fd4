// The energy table of a run against closed forms and laws.
#include "palpa/study/energy_table.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "palpa/data/analytic.h"
#include "palpa/loop/loop.h"
#include "palpa/mode/modes.h"
#include "palpa/study/summary.h"

namespace palpa {
namespace energy_table_test {

using std::numbers::pi;
using Hand = std::function<Probe(double t_s)>;

constexpr double k = 800.0;

/// A half space below z = 0 with break-through at `strength_n`.
Scene plane(double strength_n, double friction_n = 0.0, double max_force_n = 100.0) {
  Scene scene({.stiffness_n_per_m = k, .max_force_n = max_force_n});
  const FieldRef depth = scene.add("wall", plane_field());
  scene.add("wall",
            SurfaceAndFriction{.field = depth, .levels = {{.value = 0.0, .strength_n = strength_n, .friction_n = friction_n}}});
  return scene;
}

/// Every mode that can hold a hand, and a wind that drives it.
Scene everything() {
  Scene scene({.stiffness_n_per_m = k, .damping_ns_per_m = 0.5, .max_force_n = 2.0});
  const FieldRef head = scene.add("head", head_phantom());
  const FieldRef flow = scene.add("flow", burgers_vortex(), {.scale = 2.5});
  scene.add("skin", SurfaceAndFriction{.field = head,
                                       .levels = {{.value = -300, .strength_n = 0.8, .friction_coefficient = 0.3},
                                                  {.value = 300, .strength_n = 4.0, .friction_n = 0.2}}});
  scene.add("spring", Viscosity{.field = head, .strength_n = {0.05}, .drag_ns_per_m = 0.2});
  scene.add("wind", VectorForce{.field = flow, .strength_n = {0.3}});
  return scene;
}

struct Felt {
  Summary summary;
  EnergyTable table;
  double entry(const std::vector<EnergyEntry>& side, const std::string& key) const {
    for (const EnergyEntry& entry : side) {
      if (entry.key == key) return entry.energy_j;
    }
    ADD_FAILURE() << "no entry " << key;
    return std::numeric_limits<double>::quiet_NaN();
  }
  double in(const std::string& key) const { return entry(table.in, key); }
  double out(const std::string& key) const { return entry(table.out, key); }
  double largest_j() const {
    double largest = 0.0;
    for (const auto* side : {&table.in, &table.out}) {
      for (const EnergyEntry& entry : *side) largest = std::max(largest, std::abs(entry.energy_j));
    }
    return largest;
  }
};

/// `each` gets every tick, and may disturb the session before the next.
Felt feel(const Scene& scene, const Hand& hand, double duration_s, double rate_hz = 1000.0,
          const std::function<void(const TickFrame&, Session&)>& each = {}) {
  Session session(scene);
  GuardedSession guarded(session, std::numeric_limits<double>::infinity());
  SummaryBuilder builder(scene);
  const auto ticks = static_cast<std::int64_t>(duration_s * rate_hz);
  for (std::int64_t i = 0; i < ticks; ++i) {
    const double t_s = static_cast<double>(i) / rate_hz;
    const TickFrame frame = guarded.tick(i, t_s, 1.0 / rate_hz, hand(t_s));
    builder.add(frame, session);
    if (each) each(frame, session);
  }
  Felt felt{builder.finish(1.0), {}};
  felt.table = energy_table(felt.summary);
  return felt;
}

void expect_closed(const Felt& felt) {
  EXPECT_NEAR(felt.table.in_j(), felt.table.out_j(), 1e-9 + 1e-6 * felt.largest_j());
  EXPECT_NEAR(felt.table.in_j(), felt.table.out_j(), 1e-13 + 1e-12 * felt.largest_j());
}

Probe wander(double t_s) {
  return {.position_m = {0.05 * std::sin(7.1 * t_s), 0.06 * std::sin(5.3 * t_s + 1.0), 0.06 * std::sin(3.7 * t_s + 2.0)}};
}

// ---- zeros ----

TEST(EnergyTable, OfFreeAirIsZeros) {
  const Felt felt = feel(
      plane(1.0),
      [](double t_s) {
        return Probe{.position_m = {0.05 * std::sin(9 * t_s), 0.05 * std::cos(7 * t_s), 0.03}};
      },
      3.0);
  EXPECT_LT(felt.largest_j(), 1e-15);
  EXPECT_GT(felt.table.sampling_bound_j, 1e-3) << "k/2 of every step, squared, is no loss";
  const std::string text = to_table(felt.table);
  EXPECT_EQ(text.find_first_of("123456789"), std::string::npos) << text;
  EXPECT_EQ(text.find("-0"), std::string::npos) << text;
}

TEST(EnergyTable, OfAStillHandIsZerosOnceItHasComeToRest) {
  const Scene scene = everything();
  const Vec3 held = wander(1.3).position_m;
  Session session(scene);
  GuardedSession guarded(session, 100.0);
  SummaryBuilder builder(scene);
  for (int i = 0; i < 2000; ++i) {
    const double t_s = 1e-3 * std::min(i, 300);
    const TickFrame frame = guarded.tick(i, 1e-3 * i, 1e-3, {.position_m = i < 300 ? wander(1.0 + t_s).position_m : held});
    if (i >= 1000) builder.add(frame, session);
  }
  const EnergyTable table = energy_table(builder.finish(1.0));
  for (const EnergyEntry& entry : table.in) EXPECT_NEAR(entry.energy_j, 0.0, 1e-12) << entry.key;
  for (const EnergyEntry& entry : table.out) {
    if (entry.label != "stored in the spring") {
      EXPECT_NEAR(entry.energy_j, 0.0, 1e-12) << entry.key;
    }
  }
}

// ---- closed forms ----

TEST(EnergyTable, OfAShellPressedThroughIsTheSpringAtItsStrength) {
  for (const double strength_n : {0.5, 1.0, 3.0}) {
    for (const double rate_hz : {500.0, 1000.0, 4000.0}) {
      const double speed_m_per_s = 0.04;
      const Felt felt = feel(
          plane(strength_n),
          [&](double t_s) {
            return Probe{.position_m = {0.01, 0.0, 0.005 - speed_m_per_s * t_s}};
          },
          0.5, rate_hz);
      const double held_j = strength_n * strength_n / (2.0 * k);
      EXPECT_EQ(felt.summary.modes[0].break_throughs, 1);
      EXPECT_NEAR(felt.out("let_go"), held_j, 0.05 * strength_n * speed_m_per_s / rate_hz)
          << strength_n << " N, " << rate_hz << " Hz";
      EXPECT_NEAR(felt.in("hand") + felt.in("guard_held_back"), held_j, strength_n * speed_m_per_s / rate_hz)
          << "as at once, to the way of one tick";
      const double fall_s = std::clamp(strength_n / 500.0, 0.005, 0.020);
      EXPECT_NEAR(felt.in("guard_held_back"), -0.5 * strength_n * speed_m_per_s * fall_s, strength_n * speed_m_per_s / rate_hz)
          << "what the fall of the force takes besides";
      EXPECT_GE(felt.out("wall"), -1e-12);
      EXPECT_LE(felt.out("wall"), strength_n * speed_m_per_s / rate_hz + 1e-12) << "it lets go at the end of its tick";
      EXPECT_NEAR(felt.out("spring"), 0.0, 1e-15);
      expect_closed(felt);
    }
  }
}

TEST(EnergyTable, OfFrictionIsItsForceTimesTheWay) {
  const double friction_n = 0.4, depth_m = 0.002, way_m = 0.05;
  const Felt felt = feel(
      plane(10.0, friction_n),
      [&](double t_s) {
        return Probe{
            .position_m = {way_m * std::clamp(t_s - 0.5, 0.0, 1.0), 0.0, 0.001 - (0.001 + depth_m) * std::min(1.0, 2 * t_s)}};
      },
      2.0);
  const double trailing_m = friction_n / k;
  EXPECT_NEAR(felt.out("wall"), friction_n * (way_m - trailing_m), 0.01 * friction_n * way_m);
  EXPECT_NEAR(felt.out("spring"), 0.5 * k * (depth_m * depth_m + trailing_m * trailing_m), 1e-9);
  EXPECT_NEAR(felt.out("let_go"), 0.0, 1e-12);
  expect_closed(felt);
}

// An unbreakable wall returns more than it got: a held force lags, by k/2 |Δp|² per tick. That is the whole leak, covered by a
// hand's damping of kT/2 (docs/theory.md, 7.3).
TEST(EnergyTable, OfAHeldWallIsTheLeakOfTheHold) {
  for (const double rate_hz : {1000.0, 4000.0}) {
    const double depth_m = 0.002;
    const Felt felt = feel(
        plane(50.0),
        [&](double t_s) {
          return Probe{.position_m = {0.0, 0.0, 1e-6 - depth_m * std::sin(pi * t_s)}};
        },
        3.0, rate_hz);
    const double speed_m_per_s = depth_m * pi;
    const double leak_j = 0.5 * k / rate_hz * 0.5 * speed_m_per_s * speed_m_per_s * 2.0;
    EXPECT_NEAR(felt.in("ticks"), leak_j, 0.01 * leak_j);
    EXPECT_NEAR(felt.in("hand"), -leak_j, 0.01 * leak_j);
    EXPECT_NEAR(felt.table.covering_damping_ns_per_m, 0.5 * k / rate_hz, 1e-3 * k / rate_hz);
    expect_closed(felt);
  }
}

// ---- laws ----

TEST(EnergyTable, OfTicksVanishesInProportionToTheirLength) {
  const Hand press_and_slide = [](double t_s) {
    const double depth_m = 0.001 * (1.0 - 2.0 * std::cos(2 * pi * t_s));
    return Probe{.position_m = (0.05 - depth_m) * normalized(Vec3{0.6 * std::sin(1.7 * t_s), 0.4 * std::sin(2.9 * t_s), 1.0})};
  };
  Scene scene({.stiffness_n_per_m = k});
  const FieldRef ball = scene.add("ball", sphere_field(0.05));
  scene.add("ball", SurfaceAndFriction{.field = ball, .levels = {{.value = 0.0, .strength_n = 20.0, .friction_n = 0.2}}});
  double before_j = 0.0;
  for (const double rate_hz : {1000.0, 2000.0, 4000.0, 8000.0}) {
    const Felt felt = feel(scene, press_and_slide, 4.0, rate_hz);
    expect_closed(felt);
    EXPECT_GT(felt.in("hand"), 1e-3);
    if (before_j != 0.0) {
      EXPECT_NEAR(felt.in("ticks"), 0.5 * before_j, 0.05 * std::abs(before_j)) << rate_hz << " Hz";
    }
    before_j = felt.in("ticks");
  }
}

TEST(EnergyTable, OneBalanceBringsInNoMoreThanItsBound) {
  int single = 0;
  feel(everything(), wander, 20.0, 1000.0, [&](const TickFrame& frame, const Session& session) {
    const Energy& e = frame.result.energy;
    for (const SubStep& step : session.sub_steps()) {
      if (step.probe_m != frame.result.probe_m) return;
    }
    ++single;
    // A balance is as exact as its proof, and forces do work over the whole path.
    const double rounding_j = 1e-15 + 1e-9 * norm(frame.result.force_n);
    ASSERT_LE(e.sampling_j, e.sampling_bound_j + rounding_j) << "tick " << frame.tick;
  });
  EXPECT_GT(single, 1000);
}

TEST(EnergyTable, ClosesUnderEveryLaw) {
  for (const char* law : {"exact", "paper-2005", "ikits-2003", "ikits-2003-sequential", "no-proxy"}) {
    Scene scene = everything();
    scene.set_law(law);
    const Felt felt = feel(scene, wander, 5.0);
    EXPECT_GT(felt.largest_j(), 1e-3) << law;
    expect_closed(felt);
  }
}

TEST(EnergyTable, ClosesWhateverTheDeviceShowsAndWhoeverStartsAnew) {
  const Hand unsteady = [](double t_s) {
    const auto tick = static_cast<int>(std::lround(1000 * t_s));
    Probe probe = wander(t_s);
    probe.valid = tick % 200 < 180;
    if (tick % 350 == 100) probe.position_m.x = std::numeric_limits<double>::quiet_NaN();
    if (tick % 350 == 200) probe.velocity_m_per_s = Vec3{std::numeric_limits<double>::infinity(), 0, 0};
    if (tick % 350 >= 300) probe.position_m += Vec3{0.0, 0.0, 0.03};  // a jump, walked in several ticks
    return probe;
  };
  const Felt felt = feel(everything(), unsteady, 10.0, 1000.0, [](const TickFrame& frame, Session& session) {
    if (frame.tick % 777 == 500) session.reset();
  });
  EXPECT_GT(felt.summary.invalid_probe_ticks, 100);
  EXPECT_GT(felt.summary.bad_input_ticks, 10);
  EXPECT_GT(felt.summary.waiting_ticks, 0);
  EXPECT_GT(felt.out("let_go"), 0.0);
  expect_closed(felt);
}

TEST(EnergyTable, SaysWhatTheGuardHeldBackAndWhatWasAsked) {
  const double max_force_n = 2.0, depth_m = 0.005;
  const Felt felt = feel(
      plane(20.0, 0.0, max_force_n),
      [&](double t_s) {
        return Probe{.position_m = {0.0, 0.0, 1e-6 - depth_m * t_s}};
      },
      1.0);
  const double soft_m = max_force_n / k, cut_m = depth_m - soft_m;
  EXPECT_NEAR(felt.in("hand"), 0.5 * k * soft_m * soft_m + max_force_n * cut_m, 1e-4);
  EXPECT_NEAR(felt.in("guard_held_back"), 0.5 * k * cut_m * cut_m, 1e-4);
  EXPECT_NEAR(felt.out("spring"), 0.5 * k * depth_m * depth_m, 1e-4);
  EXPECT_NEAR(felt.summary.force_max_n, max_force_n, 1e-12);
  EXPECT_NEAR(felt.summary.asked_force_max_n, k * depth_m, 0.01);
  EXPECT_NE(to_table(felt.summary).find("max 2.000 N (requested 3.995 N; the guard limited"), std::string::npos)
      << to_table(felt.summary);
  expect_closed(felt);
}

TEST(EnergyTable, AModeMayBeCalledLikeAnotherEntry) {
  const Felt felt = feel(everything(), wander, 5.0);
  const nlohmann::json json = nlohmann::json::parse(to_json(felt.table));
  EXPECT_EQ(json["out"].size(), 3u + 3u);
  EXPECT_EQ(json["out"]["mode.spring"].get<double>(), felt.summary.modes[1].dissipated_j - felt.summary.modes[1].injected_j);
  EXPECT_EQ(json["out"]["spring"].get<double>(), felt.summary.energy.stored_j);
  EXPECT_LT(felt.out("wind"), felt.summary.modes[2].dissipated_j) << "a wind drives";
}

TEST(EnergyTableForAPerson, HasNoNegativeEntryAndTheSameDifference) {
  EnergyTable table{
      .in = {{"hand", "hand", 0.089}, {"guard_held_back", "withheld by the guard", -0.0027}, {"ticks", "ticks", 0.0002}},
      .out = {{"wind", "wind", -0.012}, {"skin", "skin", 0.0985}}};
  const EnergyTable shown = without_negative_entries(table);
  for (const auto* side : {&shown.in, &shown.out}) {
    for (const EnergyEntry& entry : *side) EXPECT_GE(entry.energy_j, 0.0) << entry.label;
  }
  EXPECT_EQ(shown.in.size() + shown.out.size(), 5u);
  EXPECT_NEAR(shown.in_j() - shown.out_j(), table.in_j() - table.out_j(), 1e-15);
  EXPECT_NEAR(shown.in_j(), 0.089 + 0.0002 + 0.012, 1e-15);
  EXPECT_EQ(to_table(table).find('-'), std::string::npos) << to_table(table);
}

}  // namespace energy_table_test
}  // namespace palpa
