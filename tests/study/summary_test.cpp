// A summary's sums, shares and extremes, on made-up ticks.
#include "palpa/study/summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "palpa/data/analytic.h"
#include "palpa/mode/modes.h"

namespace palpa {
namespace summary_test {

Scene two_modes() {
  Scene scene;
  const FieldRef wall = scene.add("wall", plane_field());
  scene.add("skin", SurfaceAndFriction{.field = wall, .levels = {{.value = 0.0}}});
  scene.add("syrup", Viscosity{.field = wall, .strength_n = 0.1});
  return scene;
}

struct MadeTick {
  TickFrame frame;
  std::vector<ModeForce> modes{2};
  std::vector<SessionEvent> events;
};

Summary summary_of(const std::vector<MadeTick>& ticks, double wall_s = 1.0) {
  SummaryBuilder builder(two_modes());
  for (const MadeTick& tick : ticks) builder.add(tick.frame, tick.modes, tick.events);
  return builder.finish(wall_s);
}

MadeTick random_tick(std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  MadeTick made;
  made.frame.dt_s = 1e-3;
  made.frame.tick_us = 1.0 + 100.0 * unit(random);
  made.frame.command.force_n = {unit(random), 0, 0};
  made.frame.result.sub_steps = static_cast<int>(1 + 5 * unit(random));
  made.frame.result.error_bound_m = 1e-10 * unit(random);
  made.frame.result.energy = {.stored_j = unit(random), .dissipated_j = unit(random), .injected_j = unit(random)};
  for (ModeForce& mode : made.modes) {
    mode.force_n = {0, unit(random) < 0.5 ? 0.0 : unit(random), 0};
    mode.dissipated_j = unit(random);
  }
  return made;
}

TEST(Summary, OfNothingIsZero) {
  const Summary s = summary_of({}, 0.0);
  EXPECT_EQ(s.ticks, 0);
  EXPECT_EQ(s.ticks_per_s, 0.0);
  EXPECT_EQ(s.contact_share, 0.0);
  EXPECT_EQ(s.tick_p99_us, 0.0);
  EXPECT_LT(s.first_break_through_s, 0.0);
  EXPECT_FALSE(to_table(s).empty());
  EXPECT_TRUE(nlohmann::json::parse(to_json(s))["first_break_through_s"].is_null());
}

TEST(Summary, ContactIsMoreThanOneMillinewtonOfAMode) {
  std::vector<MadeTick> ticks(4);
  ticks[0].modes[0].force_n = {1e-3, 0, 0};  // exactly 1 mN: not yet
  ticks[1].modes[0].force_n = {0, 1.0000001e-3, 0};
  ticks[2].modes[1].force_n = {0, 0, -2.0};
  ticks[3].frame.command.force_n = {3, 0, 0};  // force on the hand, but by no mode
  const Summary s = summary_of(ticks);
  EXPECT_DOUBLE_EQ(s.contact_share, 0.5);
  EXPECT_DOUBLE_EQ(s.modes[0].contact_share, 0.25);
  EXPECT_DOUBLE_EQ(s.modes[1].contact_share, 0.25);
  EXPECT_DOUBLE_EQ(s.modes[1].force_mean_n, 2.0);
  EXPECT_DOUBLE_EQ(s.modes[1].force_max_n, 2.0);
  EXPECT_DOUBLE_EQ(s.force_max_n, 3.0);
  EXPECT_DOUBLE_EQ(s.force_mean_n, 0.0) << "the mean is over ticks in contact";
}

TEST(Summary, PercentilesOfTickTimesAreGoodToOnePercentInAnyOrder) {
  std::vector<MadeTick> ticks(10000);
  for (std::size_t i = 0; i < ticks.size(); ++i) ticks[i].frame.tick_us = 0.01 * static_cast<double>(i + 1);
  for (int order = 0; order < 2; ++order) {
    const Summary s = summary_of(ticks);
    EXPECT_NEAR(s.tick_p50_us, 50.0, 0.51);
    EXPECT_NEAR(s.tick_p99_us, 99.0, 1.0);
    EXPECT_DOUBLE_EQ(s.tick_max_us, 100.0);
    std::shuffle(ticks.begin(), ticks.end(), std::mt19937_64(3));
  }
}

TEST(Summary, PercentilesNeverExceedTheMaximumAndTakeAbsurdTimes) {
  for (const double time_us : {0.0, 1e-9, 3.0, 1e12}) {
    std::vector<MadeTick> ticks(3);
    for (MadeTick& tick : ticks) tick.frame.tick_us = time_us;
    const Summary s = summary_of(ticks);
    EXPECT_LE(s.tick_p50_us, s.tick_max_us);
    EXPECT_LE(s.tick_p50_us, s.tick_p99_us);
    EXPECT_DOUBLE_EQ(s.tick_max_us, time_us);
  }
}

TEST(Summary, OfTwoRunsInARowFollowsFromTheirSummaries) {
  std::mt19937_64 random(5);
  std::vector<MadeTick> first, second;
  for (int i = 0; i < 300; ++i) first.push_back(random_tick(random));
  for (int i = 0; i < 500; ++i) second.push_back(random_tick(random));
  std::vector<MadeTick> both = first;
  both.insert(both.end(), second.begin(), second.end());

  const Summary a = summary_of(first), b = summary_of(second), ab = summary_of(both);
  EXPECT_EQ(ab.ticks, a.ticks + b.ticks);
  EXPECT_NEAR(ab.duration_s, a.duration_s + b.duration_s, 1e-12);
  EXPECT_NEAR(ab.contact_share, (300 * a.contact_share + 500 * b.contact_share) / 800, 1e-12);
  EXPECT_NEAR(ab.sub_steps_mean, (300 * a.sub_steps_mean + 500 * b.sub_steps_mean) / 800, 1e-12);
  EXPECT_NEAR(ab.energy.dissipated_j, a.energy.dissipated_j + b.energy.dissipated_j, 1e-9);
  EXPECT_NEAR(ab.energy.injected_j, a.energy.injected_j + b.energy.injected_j, 1e-9);
  EXPECT_EQ(ab.energy.stored_j, b.energy.stored_j) << "what is stored at the end";
  EXPECT_EQ(ab.error_bound_max_m, std::max(a.error_bound_max_m, b.error_bound_max_m));
  EXPECT_EQ(ab.sub_steps_max, std::max(a.sub_steps_max, b.sub_steps_max));
  for (std::size_t m = 0; m < 2; ++m) {
    EXPECT_NEAR(ab.modes[m].dissipated_j, a.modes[m].dissipated_j + b.modes[m].dissipated_j, 1e-9);
    EXPECT_EQ(ab.modes[m].force_max_n, std::max(a.modes[m].force_max_n, b.modes[m].force_max_n));
  }
}

TEST(Summary, CountsEventsByModeAndRemembersTheFirstBreakThrough) {
  std::vector<MadeTick> ticks(3);
  ticks[0].events = {{SessionEventKind::onset, 1, 0.0, nullptr}};
  ticks[1].frame.t_s = 0.25;
  ticks[1].events = {{SessionEventKind::break_through, 1, 0.0, nullptr}, {SessionEventKind::fault, 0, 0.0, "planted"}};
  ticks[2].frame.t_s = 0.5;
  ticks[2].events = {{SessionEventKind::break_through, 0, 0.0, nullptr}, {SessionEventKind::warning, -1, 0.0, "planted"}};
  ticks[2].frame.command.guard = GuardState::fault;
  const Summary s = summary_of(ticks);
  EXPECT_EQ(s.modes[0].onsets, 0);
  EXPECT_EQ(s.modes[1].onsets, 1);
  EXPECT_EQ(s.modes[0].break_throughs, 1);
  EXPECT_EQ(s.modes[1].break_throughs, 1);
  EXPECT_DOUBLE_EQ(s.first_break_through_s, 0.25);
  EXPECT_EQ(s.faults, 2);
}

TEST(Summary, CountsWhatEachTickWas) {
  std::vector<MadeTick> ticks(5);
  ticks[0].frame.result.status = TickStatus::waiting;
  ticks[1].frame.result.status = TickStatus::capped;
  ticks[2].frame.result.status = TickStatus::bad_input;
  ticks[3].frame.result.probe_valid = false;
  ticks[4].frame.command.guard = GuardState::limited;
  ticks[4].frame.result.dropped = 7;
  const Summary s = summary_of(ticks);
  EXPECT_EQ(s.waiting_ticks, 1);
  EXPECT_EQ(s.capped_ticks, 1);
  EXPECT_EQ(s.bad_input_ticks, 1);
  EXPECT_EQ(s.invalid_probe_ticks, 1);
  EXPECT_EQ(s.guard_limited_ticks, 1);
  EXPECT_EQ(s.dropped_primitives, 7);
}

TEST(Summary, AForceThatNoStrengthBalancesLastsFromTwentyMillisecondsOn) {
  const auto felt_n = [](int ticks, int every_waits) {
    std::vector<MadeTick> made(static_cast<std::size_t>(ticks));
    for (int i = 0; i < ticks; ++i) {
      TickFrame& frame = made[static_cast<std::size_t>(i)].frame;
      frame.dt_s = 1e-3;
      const bool waits = every_waits > 0 && i % every_waits == 1;  // an incomplete tick has no such force
      frame.result.status = waits ? TickStatus::waiting : TickStatus::complete;
      frame.result.unborne_n = waits ? 0.0 : 1e-3 * (60 + i);
    }
    made.emplace_back().frame.dt_s = 1e-3;
    const Summary whole = summary_of(made);
    EXPECT_GT(whole.unborne_ticks, 0);
    return whole.unborne_lasting_n;
  };
  EXPECT_EQ(felt_n(1, 0), 0.0);
  EXPECT_EQ(felt_n(19, 0), 0.0);
  EXPECT_NEAR(felt_n(25, 0), 0.084, 1e-12);
  EXPECT_NEAR(felt_n(50, 3), 0.108, 1e-12);
}

TEST(Summary, TableNamesEveryModeAndJsonReadsBackTheSame) {
  std::mt19937_64 random(9);
  std::vector<MadeTick> ticks;
  for (int i = 0; i < 100; ++i) ticks.push_back(random_tick(random));
  const Summary s = summary_of(ticks, 0.125);
  const std::string table = to_table(s);
  EXPECT_THAT(table,
              testing::AllOf(testing::HasSubstr("skin"), testing::HasSubstr("syrup"), testing::HasSubstr("800 ticks/s")));

  const nlohmann::json json = nlohmann::json::parse(to_json(s));
  EXPECT_EQ(json["ticks"], 100);
  EXPECT_EQ(json["ticks_per_s"].get<double>(), s.ticks_per_s);
  EXPECT_EQ(json["contact_share"].get<double>(), s.contact_share);
  EXPECT_EQ(json["energy_j"]["out"]["spring"].get<double>(), s.energy.stored_j);
  EXPECT_EQ(json["energy_j"]["out"]["skin"].get<double>(), s.modes[0].dissipated_j - s.modes[0].injected_j);
  EXPECT_EQ(json["modes"][1]["force_mean_n"].get<double>(), s.modes[1].force_mean_n);
}

TEST(Summary, EveryNumberOfTheJsonCarriesItsUnitOrIsACount) {
  const nlohmann::json json = nlohmann::json::parse(to_json(summary_of({MadeTick{}})));
  const auto has_unit = [](const std::string& name) {
    for (const char* unit : {"_s", "_us", "_m", "_n", "_j", "_share"}) {
      if (name.size() > std::string(unit).size() && name.ends_with(unit)) return true;
    }
    return false;
  };
  const std::function<void(const nlohmann::json&)> check = [&](const nlohmann::json& node) {
    for (const auto& [name, value] : node.items()) {
      if (name == "energy_j") continue;
      if (value.is_structured()) check(value);
      const bool dimensionless = name == "sub_steps_mean";
      EXPECT_TRUE(!value.is_number_float() || has_unit(name) || dimensionless) << name;
    }
  };
  check(json);
}

}  // namespace summary_test
}  // namespace palpa
