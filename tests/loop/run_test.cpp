// The loop on a simulated clock: repeatability, exact clock, works, invalid probes.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "palpa/device/hand.h"
#include "palpa/loop/loop.h"
#include "tests/loop/scenes.h"

namespace palpa {
namespace run_test {

class Run : public test::InFolder {
 protected:
  std::vector<TickFrame> frames_of(SimulatedDevice& device, const LoopOptions& options) {
    Session session(test::head_scene());
    std::vector<TickFrame> frames;
    run_simulated(session, device, options, nullptr, [&](const TickFrame& frame, const Session&) { frames.push_back(frame); });
    return frames;
  }
  void record(const std::string& name, SimulatedDevice& device, double rate_hz, double duration_s) {
    Session session(test::head_scene());
    TraceWriter writer(folder(name), {.dt_s = 1 / rate_hz, .primitives = true}, "", {"skin", "syrup"});
    Recorder recorder(writer);
    run_simulated(session, device, {.rate_hz = rate_hz, .duration_s = duration_s}, &recorder, {});
    recorder.finish();
    writer.finish();
  }
};

// A rigid hand with occasional losses, invalid positions and button presses, on its way into the head.
class Unsteady final : public SimulatedDevice {
 public:
  std::string name() const override { return "unsteady"; }
  DeviceLimits limits() const override { return {.max_force_n = 2.0}; }
  DeviceState read() noexcept override {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    DeviceState state{.position_m = {0.001 * std::sin(40 * t_s_), 0, 0.09 - 0.05 * t_s_}, .valid = true, .time_s = t_s_};
    const int tick = static_cast<int>(t_s_ * 1000 + 0.5);
    if (tick % 200 >= 190) state.valid = false;
    if (tick % 200 == 195) state.position_m.x = nan;
    if (tick % 500 == 250) state.position_m = {nan, std::numeric_limits<double>::infinity(), 0};
    if (tick % 500 == 350) state.position_m = {1e300, 0, 0};
    if (tick % 3 == 0) state.velocity_m_per_s = Vec3{tick % 400 == 300 ? nan : 0.0, 0, -0.05};
    state.buttons = static_cast<std::uint32_t>(tick / 100);
    return state;
  }
  bool write(const Vec3& force_n) noexcept override {
    written_n.push_back(force_n);
    return true;
  }
  void advance(double time_step_s) noexcept override { t_s_ += time_step_s; }
  double duration_s() const noexcept override { return 1; }

  std::vector<Vec3> written_n;

 private:
  double t_s_ = 0.0;
};

TEST_F(Run, TicksBeginExactlyAtMultiplesOfThePeriodAndLastTheDuration) {
  for (const auto& [rate, duration, count] :
       {std::tuple{1000.0, 0.5, 500u}, {4000.0, 0.01, 40u}, {333.0, 0.1, 34u}, {1000.0, 1e-9, 1u}}) {
    const auto hand = open_hand("sim:press", Hold::rigid);
    const std::vector<TickFrame> frames = frames_of(*hand, {.rate_hz = rate, .duration_s = duration});
    ASSERT_EQ(frames.size(), count);
    for (std::size_t n = 0; n < frames.size(); ++n) {
      EXPECT_EQ(frames[n].tick, static_cast<std::int64_t>(n));
      EXPECT_EQ(frames[n].t_s, static_cast<double>(n) / rate);
      EXPECT_EQ(frames[n].dt_s, 1 / rate);
    }
  }
}

TEST_F(Run, ARigidHandShowsItsTargetAtTheTimeOfEveryTick) {
  const auto target = simulated_target("sim:circle");
  const auto hand = open_hand("sim:circle", Hold::rigid);
  for (const TickFrame& frame : frames_of(*hand, {.rate_hz = 3000, .duration_s = 0.7})) {
    EXPECT_EQ(frame.result.probe_m, target->at(frame.t_s).position_m);
  }
}

TEST_F(Run, SameSceneAndHandSameBytes) {
  for (const char* name : {"a", "b"}) {
    const auto hand = open_hand("sim:stroke,depth_m=0.03", Hold::relaxed);
    record(name, *hand, 1000, 2);
  }
  const TraceDifference difference = compare_traces(folder("a"), folder("b"));
  EXPECT_TRUE(difference.same) << difference.where;
  EXPECT_EQ(difference.ticks, 2000);
}

TEST_F(Run, ATraceIsAHandThatFeelsTheSame) {
  const auto hand = open_hand("sim:stroke,depth_m=0.03", Hold::relaxed);
  record("felt", *hand, 1000, 2);
  const auto again = open_hand((folder("felt") / "ticks.csv").string(), std::nullopt);
  record("again", *again, 1000, 2);
  const TraceDifference difference = compare_traces(folder("felt"), folder("again"));
  EXPECT_TRUE(difference.same) << difference.where;
}

TEST_F(Run, ARecordingFeltAgainIsTheSameToTheByteWhateverTheDeviceShowed) {
  Unsteady hand;
  record("felt", hand, 1000, 1);
  Session session(test::head_scene());
  TraceWriter writer(folder("again"), {.primitives = true}, "", {"skin", "syrup"});
  GuardedSession guarded(session, hand.limits().max_force_n);
  for (const auto& [frame] : TraceReader(folder("felt")).ticks()) {
    const TickFrame again = guarded.tick(frame.tick, frame.t_s, frame.dt_s,
                                         {.position_m = frame.result.probe_m,
                                          .velocity_m_per_s = frame.result.probe_velocity_m_per_s,
                                          .valid = frame.result.probe_valid,
                                          .buttons = frame.buttons});
    writer.append(again, session.modes(), session.sub_steps(), session.primitives(), session.events());
  }
  writer.finish();
  const TraceDifference difference = compare_traces(folder("felt"), folder("again"));
  EXPECT_TRUE(difference.same) << difference.where;
  EXPECT_EQ(difference.ticks, 1000);
}

TEST_F(Run, NoForceWhereTheProbeIsNotKnownAndNeverAboveAnyLimit) {
  Unsteady hand;
  const std::vector<TickFrame> frames = frames_of(hand, {.duration_s = 1});
  ASSERT_EQ(hand.written_n.size(), frames.size());
  int pushed = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const TickFrame& frame = frames[i];
    EXPECT_EQ(frame.command.force_n, hand.written_n[i]);
    EXPECT_TRUE(is_finite(frame.command.force_n));
    EXPECT_LE(norm(frame.command.force_n), 2.0);
    if (i % 200 >= 190 || i % 500 == 250 || i % 500 == 350) {
      EXPECT_EQ(frame.command.force_n, Vec3{}) << i;
    }
    EXPECT_EQ(frame.buttons, i / 100);
    pushed += frame.command.force_n != Vec3{};
  }
  EXPECT_GT(pushed, 100);
}

TEST_F(Run, WorkOnTheHandIsThatOfTheHeldCommand) {
  const auto hand = open_hand("sim:press,depth_m=0.05", Hold::firm);
  const std::vector<TickFrame> frames = frames_of(*hand, {.duration_s = 3});
  EXPECT_EQ(frames[0].command.work_on_hand_j, 0.0);
  double worked_j = 0.0;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    EXPECT_EQ(frames[i].command.work_on_hand_j,
              dot(frames[i - 1].command.force_n, frames[i].result.probe_m - frames[i - 1].result.probe_m));
    worked_j += std::abs(frames[i].command.work_on_hand_j);
  }
  EXPECT_GT(worked_j, 1e-3);
}

TEST_F(Run, NoWorkIsBookedAcrossTicksWithoutAProbe) {
  Unsteady hand;
  const std::vector<TickFrame> frames = frames_of(hand, {.duration_s = 1});
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const auto unknown = [](std::size_t n) { return n % 200 >= 190 || n % 500 == 250 || n % 500 == 350; };
    EXPECT_TRUE(std::isfinite(frames[i].command.work_on_hand_j)) << i;
    if (unknown(i) || unknown(i - 1)) {
      EXPECT_EQ(frames[i].command.work_on_hand_j, 0.0) << i;
    }
  }
}

TEST_F(Run, TheLimitIsTheLowerOfSceneAndDevice) {
  const auto largest_command = [&](double device_limit_n) {
    DevicePlant plant;
    plant.limits.max_force_n = device_limit_n;
    const auto hand = open_hand("sim:press,depth_m=0.06,speed_m_per_s=0.3", Hold::rigid, {}, plant);
    double largest = 0.0;
    for (const TickFrame& frame : frames_of(*hand, {.duration_s = 1})) {
      largest = std::max(largest, norm(frame.command.force_n));
      EXPECT_EQ(frame.command.guard == GuardState::limited, norm(frame.result.force_n) > std::min(device_limit_n, 3.3));
    }
    return largest;
  };
  EXPECT_NEAR(largest_command(10.0), 3.3, 1e-12);
  EXPECT_NEAR(largest_command(0.5), 0.5, 1e-12);
}

TEST_F(Run, StopEndsItAfterTheTickUnderWay) {
  const auto hand = open_hand("sim:press", std::nullopt);
  Session session(test::head_scene());
  std::atomic<bool> stop = false;
  const std::int64_t ticks = run_simulated(
      session, *hand, {.duration_s = std::numeric_limits<double>::infinity()}, nullptr,
      [&](const TickFrame& frame, const Session&) { stop = frame.tick == 41; }, &stop);
  EXPECT_EQ(ticks, 42);
}

TEST_F(Run, TimesAreMeasuredWhereAskedFor) {
  const auto hand = open_hand("sim:press", std::nullopt);
  for (const TickFrame& frame : frames_of(*hand, {.duration_s = 0.1, .time_ticks = false})) {
    EXPECT_EQ(frame.tick_us, 0.0);
    EXPECT_EQ(frame.device_us, 0.0);
  }
  double sum_us = 0.0;
  for (const TickFrame& frame : frames_of(*hand, {.duration_s = 0.1})) sum_us += frame.tick_us;
  EXPECT_GT(sum_us, 0.0);
}

// A limit that is none lets nothing through, for any scene.
TEST(GuardedSession, WithALimitThatIsNoneLetsNothingThrough) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {nan, -1.0, 0.0}) {
    EXPECT_FALSE(guard_options_for({.max_force_n = bad}, 3.3).max_force_n > 0.0);
    Session session(test::head_scene());
    GuardedSession guarded(session, bad);
    double most_n = 0.0;
    for (int i = 0; i < 200; ++i) {
      const TickFrame frame = guarded.tick(i, 1e-3 * i, 1e-3, {.position_m = {0, 0.09 - 2e-4 * i, 0}});
      EXPECT_EQ(frame.command.force_n, Vec3{});
      most_n = std::max(most_n, norm(frame.result.force_n));
    }
    EXPECT_GT(most_n, 0.5) << "the skin is felt";
  }
}

}  // namespace run_test
}  // namespace palpa
