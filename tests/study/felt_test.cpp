// Force steps and their causes: on made-up runs, and on a wall that breaks.
#include "palpa/study/felt.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "palpa/data/analytic.h"
#include "palpa/loop/loop.h"
#include "palpa/mode/modes.h"

namespace palpa {
namespace felt_test {

using testing::IsEmpty;
using testing::SizeIs;

/// A hand at rest with a steady newton from its first mode.
FeltRun quiet(std::size_t ticks = 100) {
  FeltRun run{.stiffness_n_per_m = 500.0};
  run.modes = {{.name = "wall"}, {.name = "pull", .is_directed = true}};
  for (std::size_t i = 0; i < ticks; ++i) {
    run.ticks.push_back({.t_s = 1e-3 * static_cast<double>(i), .dt_s = 1e-3, .command_n = {0, 0, 1}, .usable = true});
    run.modes[0].force_n.push_back({0, 0, 1});
    run.modes[1].force_n.push_back({});
  }
  return run;
}
/// From tick 50 on another force, of a mode and on the hand.
FeltRun with_step(const Vec3& command_n, std::size_t mode, const Vec3& force_n) {
  FeltRun run = quiet();
  for (std::size_t i = 50; i < run.ticks.size(); ++i) {
    run.ticks[i].command_n = command_n;
    run.modes[mode].force_n[i] = force_n;
  }
  return run;
}
StepCause only_cause(const FeltRun& run, const EdgesOfData* edges = nullptr) {
  const std::vector<ExcessStep> steps = excess_steps(run, edges);
  EXPECT_THAT(steps, SizeIs(1));
  return steps.empty() ? StepCause::unknown : steps.front().cause;
}

TEST(ExcessSteps, OfASteadyForceAreNone) { EXPECT_THAT(excess_steps(quiet(), nullptr), IsEmpty()); }

TEST(ExcessSteps, AreWhatTheSpringDoesNotMakeOfTheHand) {
  FeltRun run = with_step({0, 0, 1.3}, 0, {0, 0, 1.3});
  run.ticks[50].probe_m = run.ticks[51].probe_m = {0, 0, -4e-4};  // the spring makes 0.2 N of it
  for (std::size_t i = 52; i < run.ticks.size(); ++i) run.ticks[i].probe_m = run.ticks[51].probe_m;
  const std::vector<ExcessStep> steps = excess_steps(run, nullptr);
  ASSERT_THAT(steps, SizeIs(1));
  EXPECT_EQ(steps[0].tick, 50u);
  EXPECT_NEAR(steps[0].step_n, 0.3, 1e-12);
  EXPECT_NEAR(steps[0].excess_n, 0.1, 1e-12);
  EXPECT_THAT(excess_steps(run, nullptr, 0.11), IsEmpty());
}

TEST(ExcessSteps, AreNotThoseOfAHandThatIsPutSomewhereElse) {
  FeltRun run = with_step({0, 0, 2}, 0, {0, 0, 2});
  run.ticks[49].usable = false;
  EXPECT_THAT(excess_steps(run, nullptr), IsEmpty());
}

TEST(ExcessSteps, HaveTheirCauseFromTheModeThatChanged) {
  EXPECT_EQ(only_cause(with_step({0, 0, 1.5}, 0, {0, 0, 1.5})), StepCause::strength);
  EXPECT_EQ(only_cause(with_step({0.3, 0, 0.95}, 0, {0.3, 0, 0.95})), StepCause::turn);
  EXPECT_EQ(only_cause(with_step({}, 0, {})), StepCause::release);
  EXPECT_EQ(only_cause(with_step({0.4, 0, 1}, 1, {0.4, 0, 0})), StepCause::directed);
  EXPECT_EQ(only_cause(with_step({0.4, 0, 1}, 0, {0, 0, 1})), StepCause::unknown) << "no mode changed";
  EXPECT_EQ(excess_steps(with_step({0.4, 0, 1}, 1, {0.4, 0, 0}), nullptr).front().mode, 1);
}

TEST(ExcessSteps, HaveTheirCauseFromEventsBeforeAllElse) {
  FeltRun run = with_step({}, 0, {});
  run.ticks[50].other_event = true;
  EXPECT_EQ(only_cause(run), StepCause::other_event);
  run.ticks[49].onset = true;
  EXPECT_EQ(only_cause(run), StepCause::onset) << "met in the tick before";
  run.ticks[35].broke_through = true;
  EXPECT_EQ(only_cause(run), StepCause::break_through) << "its fall may last 20 ms";
  EXPECT_TRUE(has_event(only_cause(run)));
  run.ticks[35].broke_through = false;
  run.ticks[20].broke_through = true;
  EXPECT_EQ(only_cause(run), StepCause::onset) << "that was 30 ms ago";
}

TEST(ExcessSteps, AtTheEndOfDataSaySo) {
  Scene scene({.stiffness_n_per_m = 500.0});
  scene.add("wall", plane_field(0.2));
  scene.set(Workspace{.scale = 1.0, .center_m = Vec3{}});
  const EdgesOfData edges(scene);
  const Vec3 centre_m = scene.hand_to_world().to_hand({});
  FeltRun run = with_step({}, 0, {});
  for (FeltTick& tick : run.ticks) tick.proxy_m = centre_m;
  EXPECT_FALSE(edges.is_near(centre_m));
  EXPECT_EQ(only_cause(run, &edges), StepCause::release);
  EXPECT_EQ(steepest_at_edges_n_per_ms(run, edges), 0.0);
  for (FeltTick& tick : run.ticks) tick.proxy_m = scene.hand_to_world().to_hand({0.0999, 0, 0});
  EXPECT_TRUE(edges.is_near(run.ticks[0].proxy_m));
  EXPECT_EQ(only_cause(run, &edges), StepCause::edge);
  EXPECT_NEAR(steepest_at_edges_n_per_ms(run, edges), 1.0, 1e-12);
  EXPECT_TRUE(edges.has_data(centre_m));
  EXPECT_FALSE(edges.has_data(scene.hand_to_world().to_hand({0.2, 0, 0})));
}

TEST(FeltRun, ATickIsUsableOnlyWhereItsProbeIs) {
  TickFrame frame{.dt_s = 1e-3, .command = {.force_n = {1, 2, 3}, .guard = GuardState::limited}};
  frame.result.probe_m = {1, 2, 3};
  EXPECT_TRUE(felt_tick(frame).usable);
  EXPECT_TRUE(felt_tick(frame).limited);
  EXPECT_EQ(felt_tick(frame).command_n, frame.command.force_n);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    TickFrame lost = frame;
    lost.result.probe_m.y = bad;
    EXPECT_FALSE(felt_tick(lost).usable);
  }
  frame.result.probe_valid = false;
  EXPECT_FALSE(felt_tick(frame).usable);
  frame.result.probe_valid = true;
  frame.result.status = TickStatus::bad_input;
  EXPECT_FALSE(felt_tick(frame).usable);
}

TEST(FeltRun, SignalsEndWhereTheProbeIsLost) {
  FeltRun run = quiet(10);
  run.ticks[4].usable = false;
  for (FeltTick& tick : run.ticks) tick.probe_m = {0.01, 0, 0};
  const FeltSignals signals = signals_of(run, 0.001, 0.009);
  ASSERT_THAT(signals.command_n, SizeIs(2));
  EXPECT_THAT(signals.command_n[0], SizeIs(3));
  EXPECT_THAT(signals.command_n[1], SizeIs(4));
  EXPECT_EQ(signals.spring_n[1][0], (Vec3{5.0, 0, 0}));
}

TEST(FeltRun, QuietSignalsLeaveOutEventsAndWhatIsNotTouched) {
  FeltRun run = quiet(100);
  run.ticks[50].onset = true;
  for (std::size_t i = 90; i < 100; ++i) run.ticks[i].command_n = {};
  const FeltSignals signals = quiet_signals_of(run, 0.0, 1.0);
  ASSERT_THAT(signals.command_n, SizeIs(2));
  EXPECT_THAT(signals.command_n[0], SizeIs(testing::AllOf(testing::Ge(29u), testing::Le(31u))));
  EXPECT_THAT(signals.command_n[1], SizeIs(testing::AllOf(testing::Ge(19u), testing::Le(21u))));
}

// A wall of 1 N, pressed by a rigid hand from 1 mm before it with 10 N/s: met and broken; then the command falls to 0.
FeltRun run_into_a_wall(double max_force_n) {
  Scene scene({.stiffness_n_per_m = 500.0, .damping_ns_per_m = 0.0, .max_force_n = max_force_n});
  const FieldRef wall = scene.add("wall", plane_field());
  scene.add("wall", SurfaceAndFriction{.field = wall, .levels = {{.value = 0.0, .strength_n = 1.0}}});
  Session session(scene);
  GuardedSession guarded(session, 10.0);
  FeltRun run = felt_run(scene);
  for (int i = 0; i < 200; ++i) {
    const double t_s = 1e-3 * i;
    add_tick(run, guarded.tick(i, t_s, 1e-3, {.position_m = {0, 0, 1e-3 - 0.02 * t_s}}), session);
  }
  return run;
}

TEST(FeltRun, OfAWallThatBreaksTellsItsForceAndItsFall) {
  const FeltRun run = run_into_a_wall(1.2);
  int onsets = 0, breaks = 0;
  double broke_n = 0.0;
  for (const FeltTick& tick : run.ticks) {
    onsets += tick.onset;
    breaks += tick.broke_through;
    broke_n = std::max(broke_n, tick.broke_force_n);
  }
  EXPECT_EQ(onsets, 1);
  EXPECT_EQ(breaks, 1);
  EXPECT_NEAR(broke_n, 1.0, 1e-3);
  EXPECT_GT(steepest_fall_n_per_ms(run), 0.0);
  EXPECT_LE(steepest_fall_n_per_ms(run), 0.5 + 1e-9) << "it falls in milliseconds";
  EXPECT_EQ(saturated_share(run), 0.0);
  for (const ExcessStep& step : excess_steps(run, nullptr)) EXPECT_TRUE(has_event(step.cause)) << name_of(step.cause);
  EXPECT_NEAR(duration_s(run), 0.2, 1e-9);
}

// A level beyond the limit holds: the command stays at the limit while the hand presses that far.
TEST(FeltRun, OfAWallBeyondTheLimitTellsHowLongItWasCut) {
  const FeltRun run = run_into_a_wall(0.8);
  EXPECT_EQ(std::ranges::count_if(run.ticks, [](const FeltTick& tick) { return tick.broke_through; }), 0);
  EXPECT_NEAR(saturated_share(run), 0.07 / 0.2, 0.006) << "from 0.8 N, after 0.13 s, on";
}

}  // namespace felt_test
}  // namespace palpa
