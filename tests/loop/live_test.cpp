// The live loop on a simulated clock: deadlines, scene changes, and a tick's prohibitions.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "palpa/device/hand.h"
#include "palpa/device/paced_hand.h"
#include "palpa/loop/clutch_mapping.h"
#include "palpa/loop/loop.h"
#include "tests/loop/scenes.h"
#include "tests/solver/counted_allocations.h"
#include "tests/solver/counted_locks.h"

namespace palpa {
namespace live_test {

/// Time advances in waits, and the hand moves with it. `late_s`: delay of a wait.
class SimulatedTime final : public LoopClock {
 public:
  explicit SimulatedTime(SimulatedDevice* hand = nullptr) : hand_(hand) {}
  double now_s() noexcept override { return now_s_; }
  void wait_until_s(double time_s) noexcept override {
    double next_s = time_s;
    if (late) next_s += late(time_s);
    if (next_s <= now_s_) return;
    if (hand_) hand_->advance(next_s - now_s_);
    now_s_ = next_s;
  }
  std::function<double(double)> late;

 private:
  SimulatedDevice* hand_;
  double now_s_ = 100.0;
};

std::unique_ptr<SimulatedDevice> stroking_hand(Hold hold = Hold::relaxed) { return open_hand("sim:stroke,depth_m=0.03", hold); }

/// A hand that records its commands, as a mouse's: it moves freely, and has no motors.
class HandWithoutMotors final : public Device {
 public:
  explicit HandWithoutMotors(Device& hand) : hand_(hand) {}
  std::string name() const override { return "without motors"; }
  DeviceLimits limits() const override {
    DeviceLimits limits = hand_.limits();
    limits.has_motors = false;
    return limits;
  }
  DeviceState read() noexcept override { return hand_.read(); }
  bool write(const Vec3&) noexcept override { return true; }

 private:
  Device& hand_;
};

std::vector<TickFrame> run_live(const Scene& scene, LiveOptions options, const std::function<double(double)>& late = {},
                                const std::function<void(LiveScene&, LiveLoop&, std::int64_t)>& meanwhile = {}) {
  LiveScene live(scene);
  const auto hand = stroking_hand();
  SimulatedTime clock(hand.get());
  clock.late = late;
  LiveLoop loop(live, *hand, options, nullptr, &clock);
  std::vector<TickFrame> frames;
  const std::atomic<bool> never{false};
  loop.run(never, [&](const TickFrame& frame, const Session&) {
    frames.push_back(frame);
    if (meanwhile) meanwhile(live, loop, frame.tick);
  });
  return frames;
}

GuardOptions limit_alone() { return {.max_force_n = 10.0, .motors = false}; }

TEST(LiveLoop, FeelsWhatASimulatedRunFeelsWhereItIsInTime) {
  const auto live = run_live(test::head_scene(), {.duration_s = 3.0, .guard = limit_alone()});
  Session session(test::head_scene());
  GuardedSession guarded(session, 10.0);
  ASSERT_EQ(live.size(), 3000u);
  int felt = 0;
  for (const TickFrame& frame : live) {
    const Probe probe{frame.result.probe_m, {}, true, 0};
    ASSERT_EQ(guarded.tick(frame.tick, frame.t_s, frame.dt_s, probe).command.force_n, frame.command.force_n) << frame.tick;
    felt += frame.command.force_n != Vec3{};
  }
  EXPECT_GT(felt, 500);
}

// Probes of a hand without force, equal in both runs but for the clock's rounding.
TEST(LiveLoop, ARehearsalIsNeverFelt) {
  std::vector<TickFrame> frames[2];
  for (const bool rehearse : {false, true}) {
    LiveScene live(test::head_scene());
    const auto hand = stroking_hand(Hold::rigid);
    SimulatedTime clock(hand.get());
    LiveLoop loop(live, *hand, {.duration_s = 2.0, .rehearse = rehearse, .guard = limit_alone()}, nullptr, &clock);
    const std::atomic<bool> never{false};
    loop.run(never, [&](const TickFrame& frame, const Session&) { frames[rehearse].push_back(frame); });
    if (rehearse) {
      EXPECT_GT(loop.statistics().modes.at(0).mean_us, 0.0);
    }
  }
  ASSERT_EQ(frames[0].size(), frames[1].size());
  for (std::size_t i = 0; i < frames[0].size(); ++i)
    ASSERT_LT(norm(frames[0][i].command.force_n - frames[1][i].command.force_n), 1e-6) << i;
}

TEST(LiveLoop, MissedTicksAreSkippedAndCountedAndNeverBunched) {
  LiveScene live(test::head_scene());
  const auto hand = stroking_hand();
  SimulatedTime clock(hand.get());
  int waits = 0;
  clock.late = [&](double) { return ++waits % 50 == 0 ? 5.4e-3 : 0.1e-3; };
  LiveLoop loop(live, *hand, {.duration_s = 1.0, .rehearse = false, .guard = limit_alone()}, nullptr, &clock);
  std::vector<TickFrame> frames;
  const std::atomic<bool> never{false};
  loop.run(never, [&](const TickFrame& frame, const Session&) { frames.push_back(frame); });
  std::int64_t missed = 0, last = -1;
  for (const TickFrame& frame : frames) {
    ASSERT_GT(frame.tick, last);
    ASSERT_NEAR(frame.dt_s, 1e-3 * static_cast<double>(frame.tick - last), 1e-12) << "the whole time, in whole periods";
    missed += frame.tick - last - 1;
    last = frame.tick;
  }
  EXPECT_GT(missed, 50);
  EXPECT_EQ(loop.statistics().missed, missed);
  EXPECT_EQ(loop.statistics().ticks, static_cast<std::int64_t>(frames.size()));
  EXPECT_NEAR(loop.statistics().late.p50_us, 100.0, 2.0);
}

/// A handle that records and keeps its last command.
class HandleWithAMemory final : public Device {
 public:
  explicit HandleWithAMemory(Device& hand) : hand_(hand) {}
  std::string name() const override { return "with a memory"; }
  DeviceLimits limits() const override { return hand_.limits(); }
  DeviceState read() noexcept override { return hand_.read(); }
  bool write(const Vec3& force_n) noexcept override {
    last_word_n = force_n;
    return hand_.write(force_n);
  }
  bool rests() const noexcept override { return last_word_n == Vec3{}; }
  Vec3 last_word_n;

 private:
  Device& hand_;
};

// At its duration, on a stop, or by an observer's exception that the program catches.
TEST(LiveLoop, EndsAtNoForceHoweverItEnds) {
  enum class End { duration, stop, exception };
  for (const End end : {End::duration, End::stop, End::exception}) {
    LiveScene live(test::head_scene());
    const auto hand = stroking_hand();
    HandleWithAMemory device(*hand);
    SimulatedTime clock(hand.get());
    LiveLoop loop(live, device, {.duration_s = 2.0, .guard = limit_alone()}, nullptr, &clock);
    std::atomic<bool> stop{false};
    double felt_n = 0.0;
    try {
      loop.run(stop, [&](const TickFrame& frame, const Session&) {
        if (norm(frame.command.force_n) < 0.5 && felt_n == 0.0) return;
        felt_n = norm(device.last_word_n);
        stop = end == End::stop;
        if (end == End::exception) throw std::runtime_error("of the observer");
      });
      EXPECT_NE(end, End::exception);
    } catch (const std::runtime_error&) {
      EXPECT_EQ(end, End::exception);
    }
    EXPECT_GT(felt_n, 0.0);
    EXPECT_EQ(device.last_word_n, Vec3{}) << static_cast<int>(end);
  }
}

TEST(LiveLoop, ThreeMissedTicksTakeTheForceAway) {
  int waits = 0;
  const auto frames = run_live(test::head_scene(), {.duration_s = 3.0, .rehearse = false, .guard = {.max_force_n = 10.0}},
                               [&](double) { return ++waits == 2000 ? 3.5e-3 : 0.0; });
  const auto late = std::find_if(frames.begin(), frames.end(),
                                 [](const TickFrame& f) { return f.circumstances & bit_of(Circumstance::late); });
  ASSERT_NE(late, frames.end());
  ASSERT_NE((late - 1)->command.force_n, Vec3{}) << "nothing is shown where nothing was felt";
  EXPECT_LE(norm(late->command.force_n), norm((late - 1)->command.force_n) / 4 + 1e-12);
  EXPECT_EQ((late + 2)->command.force_n, Vec3{});
  EXPECT_EQ((late + 3)->command.cause, GuardCause::late);
}

// No motor held an old force meanwhile, so a mouse on a busy desktop loses no force.
TEST(LiveLoop, MissedTicksTakeNothingFromAHandWithoutMotors) {
  LiveScene live(test::head_scene());
  const auto stroking = stroking_hand(Hold::rigid);
  HandWithoutMotors hand(*stroking);
  SimulatedTime clock(stroking.get());
  int waits = 0;
  clock.late = [&](double) { return ++waits % 20 == 0 ? 12.5e-3 : 0.0; };
  LiveLoop loop(live, hand, {.duration_s = 4.0, .rehearse = false, .guard = {.max_force_n = 10.0}}, nullptr, &clock);
  std::vector<TickFrame> frames;
  const std::atomic<bool> never{false};
  loop.run(never, [&](const TickFrame& frame, const Session&) { frames.push_back(frame); });
  EXPECT_GT(loop.statistics().missed, 1000);
  int felt = 0;
  bool is_on = false;
  for (const TickFrame& frame : frames) {
    is_on = is_on || frame.command.guard == GuardState::pass;
    if (!is_on) continue;
    ASSERT_TRUE(frame.command.guard == GuardState::pass || frame.command.guard == GuardState::limited ||
                frame.command.guard == GuardState::damped)
        << name_of(frame.command.guard) << " at " << frame.t_s << " s";
    felt += norm(frame.command.force_n) > 0.1;
  }
  EXPECT_GT(felt, 300);
}

TEST(LiveLoop, ManyChangesOfASceneMakeNoStepBeyondTheRamps) {
  GuardOptions guard = limit_alone();
  const double ramp_n = guard.max_force_n * 1e-3 / guard.ramp_s;
  const double k = test::head_scene().coupling().stiffness_n_per_m;
  const auto steady = run_live(test::head_scene(), {.duration_s = 4.0, .guard = guard});
  const auto changed =
      run_live(test::head_scene(), {.duration_s = 4.0, .guard = guard}, {}, [](LiveScene& live, LiveLoop&, std::int64_t tick) {
        if (tick % 5 != 0) return;
        live.change([&](Scene& scene) {
          scene.edit<SurfaceAndFriction>("skin",
                                         [&](auto& skin) { skin.levels[0].friction_coefficient = tick % 10 == 0 ? 0.1 : 0.6; });
          scene.edit<CouplingOptions>([&](auto& coupling) {
            coupling.stiffness_n_per_m = tick % 20 == 0 ? 500.0 : 800.0;
            coupling.damping_ns_per_m = tick % 15 == 0 ? 0.0 : 0.5;
          });
        });
      });
  const auto jump = [&](const std::vector<TickFrame>& frames) {
    double most = 0;
    for (std::size_t i = 1; i < frames.size(); ++i) {
      const double by_hand_n = k * norm(frames[i].result.probe_step_m);
      most = std::max(most, norm(frames[i].command.force_n - frames[i - 1].command.force_n) - by_hand_n);
    }
    return most;
  };
  int swaps = 0, felt = 0;
  for (const TickFrame& frame : changed) {
    swaps += (frame.circumstances & bit_of(Circumstance::new_scene)) != 0;
    felt += frame.command.force_n != Vec3{};
  }
  EXPECT_GT(swaps, 790);
  EXPECT_GT(felt, 1000);
  EXPECT_LE(jump(changed), jump(steady) + ramp_n) << "a change of scene is no jolt";
}

TEST(LiveLoop, AnotherSceneIsTakenOverWhereTheHandIs) {
  Scene other = test::head_scene();
  other.edit_mode("skin", [](SceneMode& skin) { skin.mode = Viscosity{.field = {"head"}, .strength_n = {0.5}}; });
  const auto frames = run_live(test::head_scene(), {.duration_s = 2.0, .guard = limit_alone()}, {},
                               [&](LiveScene& live, LiveLoop&, std::int64_t tick) {
                                 if (tick == 1500) live.set(other);
                               });
  ASSERT_EQ(frames.size(), 2000u);
  const TickFrame &before = frames[1500], &after = frames[1501];
  EXPECT_TRUE(after.circumstances & bit_of(Circumstance::new_scene));
  EXPECT_LT(distance(after.result.proxy_m, before.result.proxy_m), 0.03);
}

TEST(LiveLoop, ALevelThatMovesUnderAPressingHandMakesNoJump) {
  GuardOptions guard = limit_alone();
  const auto frames =
      run_live(test::head_scene(), {.duration_s = 3.0, .guard = guard}, {}, [](LiveScene& live, LiveLoop&, std::int64_t tick) {
        if (tick % 50 != 0) return;
        live.change([&](Scene& scene) {
          scene.edit<SurfaceAndFriction>(
              "skin", [&](auto& skin) { skin.levels[0].value = -300.0 + 100.0 * static_cast<double>((tick / 50) % 3); });
        });
      });
  const double k = test::head_scene().coupling().stiffness_n_per_m;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const double by_hand_n = k * norm(frames[i].result.probe_step_m);
    const double step_n = norm(frames[i].command.force_n - frames[i - 1].command.force_n) - by_hand_n;
    ASSERT_LE(step_n, 0.5 + 1e-3 * guard.max_force_n / guard.ramp_s) << i;
  }
}

TEST(LiveLoop, TicksWithScenesThatChangeAllocateNothingInItsThread) {
  LiveScene live(test::head_scene());
  const auto hand = stroking_hand();
  SimulatedTime clock(hand.get());
  LiveLoop loop(live, *hand, {.duration_s = 1.0, .guard = {.max_force_n = 10.0}}, nullptr, &clock);
  const std::atomic<bool> never{false};
  long before = 0, in_ticks = 0;
  loop.run(never, [&](const TickFrame& frame, const Session&) {
    if (frame.tick > 0) in_ticks += test::allocations - before;
    if (frame.tick % 10 == 0)
      live.change([&](Scene& scene) {
        scene.edit<CouplingOptions>(
            [&](auto& coupling) { coupling.damping_ns_per_m = 0.1 + 1e-4 * static_cast<double>(frame.tick); });
      });
    before = test::allocations;
  });
  EXPECT_EQ(in_ticks, 0);
}

class LiveLoopInFolder : public test::InFolder {};

// All of a thread's time in the loop: clock, device, ticks, recorder, rehearsals, scenes from another thread.
TEST_F(LiveLoopInFolder, NeitherAllocatesNorLocksInItsThreadWhileItIsRecordedAndChanged) {
  {
    std::mutex counted;
    const long before = test::locks;
    const std::lock_guard lock(counted);
    ASSERT_EQ(test::locks, before + 1) << "the hook counts";
  }
  TraceWriter writer(folder("trace"), {.motors = true}, "", {"skin", "syrup"});
  Recorder recorder(writer);
  LiveScene live(test::head_scene());
  const auto hand = stroking_hand();
  PacedHand paced(*hand);
  LiveLoop loop(live, paced, {.duration_s = 1.0, .guard = {.max_force_n = 10.0}}, &recorder);
  std::atomic<bool> ended{false};
  long allocations = -1, locks = -1, first_allocations = 0, first_locks = 0;
  std::thread felt([&] {
    const std::atomic<bool> never{false};
    bool has_begun = false;
    loop.run(never, [&](const TickFrame&, const Session&) {
      if (!std::exchange(has_begun, true)) {
        first_allocations = test::allocations;
        first_locks = test::locks;
      }
      allocations = test::allocations - first_allocations;
      locks = test::locks - first_locks;
    });
    ended = true;
  });
  for (int n = 0; !ended; ++n) {
    live.change([&](Scene& scene) {
      scene.edit<CouplingOptions>([&](auto& coupling) { coupling.damping_ns_per_m = 0.1 + 0.01 * (n % 10); });
    });
    loop.statistics();
    loop.latest();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  felt.join();
  EXPECT_EQ(allocations, 0);
  EXPECT_EQ(locks, 0);
  EXPECT_GT(loop.statistics().scenes, 10);
}

TEST(LiveLoop, ThreadsThatChangeAndLookDoNotDisturbIt) {
  LiveScene live(test::head_scene());
  const auto hand = stroking_hand();
  LiveLoop loop(live, *hand, {.rate_hz = 2000, .duration_s = 0.5, .guard = {.max_force_n = 10.0}});
  const std::atomic<bool> never{false};
  std::atomic<bool> done{false};
  std::thread changing([&] {
    for (int i = 0; !done; ++i) {
      live.change(
          [&](Scene& scene) { scene.edit<CouplingOptions>([&](auto& coupling) { coupling.max_force_n = 1.0 + i % 3; }); });
      if (i % 7 == 0) loop.panic();
      if (i % 7 == 2) loop.resume();
      loop.hold_while_view_moves(i % 5 == 0);
    }
  });
  std::thread looking([&] {
    while (!done) {
      const LiveView& view = loop.latest();
      ASSERT_TRUE(is_finite(view.frame.command.force_n));
      loop.set_view_rotation(Mat3::identity());
      loop.statistics();
      std::this_thread::yield();
    }
  });
  std::int64_t ticks = 0;
  loop.run(never, [&](const TickFrame& frame, const Session&) {
    ++ticks;
    EXPECT_LE(norm(frame.command.force_n), 3.3);
  });
  done = true;
  changing.join();
  looking.join();
  EXPECT_EQ(loop.statistics().ticks, ticks);
  EXPECT_GT(loop.statistics().scenes, 0);
}

TEST(ClutchMapping, TheClutchMovesTheHandleAndNotTheProbe) {
  ClutchMapping grip({.clutch_buttons = 1});
  const Vec3 here = grip.hold({.position_m = {0.01, 0.02, 0.03}, .valid = true}, 1e-3).probe.position_m;
  const ClutchMapping::Held held = grip.hold({.position_m = {0.05, 0, 0}, .valid = true, .buttons = 1}, 1e-3);
  EXPECT_TRUE(held.moves);
  EXPECT_LT(distance(held.probe.position_m, here), 1e-15);
  const ClutchMapping::Held after = grip.hold({.position_m = {0.06, 0, 0}, .valid = true}, 1e-3);
  EXPECT_FALSE(after.moves);
  EXPECT_LT(distance(after.probe.position_m, here + Vec3{0.01, 0, 0}), 1e-15) << "lengths at the hand are lengths at the probe";
}

TEST(ClutchMapping, ATurnedViewTurnsMotionAndForceAlike) {
  ClutchMapping grip({});
  grip.hold({.position_m = {0.01, 0, 0}, .valid = true}, 1e-3);
  const Mat3 quarter{{{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}}};
  grip.turn(quarter);
  EXPECT_TRUE(grip.hold({.position_m = {0.01, 0, 0}, .valid = true}, 1e-3).moves);
  const Vec3 a = grip.hold({.position_m = {0.01, 0, 0}, .valid = true}, 1e-3).probe.position_m;
  const Vec3 b = grip.hold({.position_m = {0.03, 0.01, 0}, .valid = true}, 1e-3).probe.position_m;
  const Vec3 force_n{0.3, -0.2, 0.7};
  EXPECT_NEAR(dot(force_n, b - a), dot(grip.at_device({force_n, {}}).force_n, Vec3{0.02, 0.01, 0}), 1e-15) << "work is work";
  EXPECT_LT(distance(b - a, quarter * Vec3{0.02, 0.01, 0}), 1e-15);
  grip.turn(2.0 * quarter);
  EXPECT_FALSE(grip.hold({.position_m = {0.03, 0.01, 0}, .valid = true}, 1e-3).moves) << "what is no rotation is left out";
}

TEST(ClutchMapping, AHandleAtTheBorderTakesTheProbeFurther) {
  ClutchMapping grip({.workspace_radius_m = 0.1, .goes_on_at_border = true});
  Vec3 last_m;
  for (int i = 0; i < 1000; ++i) last_m = grip.hold({.position_m = {0.1, 0, 0}, .valid = true}, 1e-3).probe.position_m;
  EXPECT_NEAR(last_m.x, 0.18, 1e-3);
  for (int i = 0; i < 1000; ++i) last_m = grip.hold({.position_m = {0.05, 0, 0}, .valid = true}, 1e-3).probe.position_m;
  EXPECT_NEAR(last_m.x, 0.13, 1e-3) << "inside it stays";
}

TEST(LiveScene, IsNoStifferThanTheDeviceBearsWhateverItIsChangedTo) {
  const DeviceLimits limits{.max_stiffness_n_per_m = 300, .max_damping_ns_per_m = 0.1};
  const auto felt_n = [&](LiveScene& live) {
    const auto hand = stroking_hand(Hold::rigid);
    SimulatedTime clock(hand.get());
    LiveLoop loop(live, *hand, {.duration_s = 2.0, .guard = limit_alone()}, nullptr, &clock);
    std::vector<double> forces_n;
    const std::atomic<bool> never{false};
    loop.run(never, [&](const TickFrame& frame, const Session&) { forces_n.push_back(norm(frame.command.force_n)); });
    return forces_n;
  };
  Scene soft = test::head_scene(), stiff = test::head_scene();
  soft.set(CouplingOptions{.stiffness_n_per_m = 300, .damping_ns_per_m = 0.1});
  stiff.set(CouplingOptions{.stiffness_n_per_m = 5000, .damping_ns_per_m = 20});
  LiveScene as_it_is(soft), held(stiff, limits), changed(soft, limits);
  changed.set(stiff);
  const auto wanted_n = felt_n(as_it_is);
  EXPECT_GT(*std::max_element(wanted_n.begin(), wanted_n.end()), 0.5);
  EXPECT_EQ(felt_n(held), wanted_n);
  EXPECT_EQ(felt_n(changed), wanted_n);
  EXPECT_EQ(changed.scene().coupling().stiffness_n_per_m, 5000) << "as it was set";
}

}  // namespace live_test
}  // namespace palpa
