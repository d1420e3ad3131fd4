// Several hands on one clock, in simulated time: each as if alone, and a fault of one lets all fall.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "palpa/device/hand.h"
#include "palpa/loop/loop.h"
#include "tests/loop/scenes.h"

namespace palpa {
namespace two_hands_test {

/// Time advances in waits, and with it some hands.
class SharedTime final : public LoopClock {
 public:
  double now_s() noexcept override { return now_s_; }
  void wait_until_s(double time_s) noexcept override {
    if (time_s <= now_s_) return;
    if (on_step) on_step(time_s - now_s_);
    now_s_ = time_s;
  }
  std::function<void(double)> on_step;

 private:
  double now_s_ = 100.0;
};

/// A hand on a short stroke onto the bone of the head, with faults on request, and the commands that it got.
class FaultyHand final : public Device {
 public:
  explicit FaultyHand(double phase) : phase_(phase) {}
  std::string name() const override { return "faulty"; }
  DeviceLimits limits() const override { return {.max_force_n = 4.0, .senses_turn = true, .max_torque_nm = 0.2}; }
  DeviceState read() noexcept override {
    DeviceState state{.valid = !is_lost};
    const double angle = 6.0 * time_s + phase_;
    state.position_m = {0.002 * std::sin(angle), 0.064 + 0.0015 * std::sin(1.3 * angle), way_m};
    state.fault = has_fault ? "a fault" : nullptr;
    state.turn = turn;
    state.time_s = time_s;
    return state;
  }
  bool write(const Vec3& force_n) noexcept override { return write(force_n, {}); }
  bool write(const Vec3& force_n, const Vec3& torque_nm) noexcept override {
    written_n = force_n;
    written_nm = torque_nm;
    return !is_unplugged;
  }

  double time_s = 0.0, way_m = 0.0;
  bool has_fault = false, is_lost = false, is_unplugged = false;
  Turn turn;
  Vec3 written_n, written_nm;

 private:
  double phase_;
};

/// Two hands in a live loop; `meanwhile` after each tick of the second.
struct TwoHands {
  void run(double duration_s, const std::function<void(std::int64_t)>& meanwhile) {
    LiveScene first(scene), second(scene);
    const auto options = [&](const Device& device) {
      LiveOptions made{.duration_s = duration_s, .rehearse = true, .guard = guard_options_for(device.limits(), 4.0)};
      made.guard.ramp_s = 0.05;
      return made;
    };
    const LiveHand hands[] = {{&first, &devices[0], options(devices[0])}, {&second, &devices[1], options(devices[1])}};
    time.on_step = [&](double step_s) {
      for (FaultyHand& device : devices) device.time_s += step_s;
    };
    LiveLoop live(hands, &time);
    loop = &live;
    const std::atomic<bool> never{false};
    live.run_hands(never, [&](std::size_t hand, const TickFrame& frame, const Session&) {
      frames[hand].push_back(frame);
      if (hand == 1) meanwhile(frame.tick);
    });
  }
  const TickFrame& last(std::size_t hand) const { return frames[hand].back(); }

  Scene scene = test::head_scene();
  SharedTime time;
  FaultyHand devices[2] = {FaultyHand(0.0), FaultyHand(0.7)};
  std::vector<TickFrame> frames[2];
  LiveLoop* loop = nullptr;
};

TEST(TwoHands, SimulatedTogetherFeelWhatEachFeelsAlone) {
  const char* const descriptions[] = {"sim:stroke,depth_m=0.03", "sim:press,depth_m=0.02"};
  std::vector<TickFrame> alone[2], together[2];
  for (std::size_t h = 0; h < 2; ++h) {
    Session session(test::head_scene());
    const auto device = open_hand(descriptions[h], Hold::relaxed);
    run_simulated(session, *device, {.duration_s = 1.5, .time_ticks = false}, nullptr,
                  [&](const TickFrame& frame, const Session&) { alone[h].push_back(frame); });
  }
  Session first(test::head_scene()), second(test::head_scene());
  const auto one = open_hand(descriptions[0], Hold::relaxed), other = open_hand(descriptions[1], Hold::relaxed);
  const SimulatedHand hands[] = {{&first, one.get()}, {&second, other.get()}};
  EXPECT_EQ(run_simulated(hands, {.duration_s = 1.5, .time_ticks = false},
                          [&](std::size_t hand, const TickFrame& frame, const Session&) { together[hand].push_back(frame); }),
            1500);
  double most_n = 0.0;
  for (std::size_t h = 0; h < 2; ++h) {
    ASSERT_EQ(together[h].size(), alone[h].size());
    for (std::size_t i = 0; i < alone[h].size(); ++i) {
      ASSERT_EQ(together[h][i].result.probe_m, alone[h][i].result.probe_m) << i;
      ASSERT_EQ(together[h][i].command.force_n, alone[h][i].command.force_n) << i;
      most_n = std::max(most_n, norm(alone[h][i].command.force_n));
    }
  }
  EXPECT_GT(most_n, 0.3);
}

TEST(TwoHands, ShareOneClockAndFeelForThemselves) {
  TwoHands hands;
  bool differs = false;
  double most_n[2] = {};
  hands.run(1.5, [&](std::int64_t tick) {
    ASSERT_EQ(hands.last(0).tick, tick);
    ASSERT_EQ(hands.last(1).tick, tick);
    ASSERT_EQ(hands.last(0).t_s, hands.last(1).t_s);
    for (std::size_t h = 0; h < 2; ++h) most_n[h] = std::max(most_n[h], norm(hands.last(h).command.force_n));
    differs = differs || hands.last(0).command.force_n != hands.last(1).command.force_n;
  });
  EXPECT_EQ(hands.frames[0].size(), 1500u);
  EXPECT_GT(most_n[0], 0.2);
  EXPECT_GT(most_n[1], 0.2);
  EXPECT_TRUE(differs);
  for (std::size_t h = 0; h < 2; ++h) EXPECT_EQ(hands.devices[h].written_n, Vec3{}) << "both end at no force";
}

// A view turned by half about the vertical: right is left, and towards the user is away, of the hand that is looked along.
TEST(TwoHands, TheViewTurnsOneOfThem) {
  TwoHands hands;
  Vec3 device_m[2], probe_m[2];
  hands.run(0.2, [&](std::int64_t tick) {
    if (tick == 0) hands.loop->set_view_rotation({{{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}}}, 1);
    for (std::size_t h = 0; h < 2; ++h) {
      const Vec3 now_m = hands.devices[h].read().position_m, way_m = now_m - std::exchange(device_m[h], now_m);
      const Vec3 seen_m = h == 0 ? way_m : Vec3{-way_m.x, way_m.y, -way_m.z};
      const Vec3 probe_now_m = hands.last(h).result.probe_m, step_m = probe_now_m - std::exchange(probe_m[h], probe_now_m);
      if (tick < 3) continue;
      ASSERT_LT(distance(step_m, seen_m), 1e-12) << h;
    }
  });
}

TEST(TwoHands, EveryFaultOfOneLetsTheOtherFallAndBothComeBackByTheirRamps) {
  struct Way {
    const char* name;
    std::function<void(FaultyHand&, bool)> is;
    GuardCause cause;
  };
  const Way ways[] = {
      {"device fault", [](FaultyHand& hand, bool on) { hand.has_fault = on; }, GuardCause::device_fault},
      {"no position", [](FaultyHand& hand, bool on) { hand.is_lost = on; }, GuardCause::no_position},
      {"link lost", [](FaultyHand& hand, bool on) { hand.is_unplugged = on; }, GuardCause::link_lost},
      {"no rotation",
       [](FaultyHand& hand, bool on) {
         hand.turn = on ? Turn{0, 0, 0, 0} : Turn{};
       },
       GuardCause::no_position},
  };
  for (std::size_t faulty = 0; faulty < 2; ++faulty) {
    for (const Way& way : ways) {
      SCOPED_TRACE(way.name);
      const std::size_t other = 1 - faulty;
      TwoHands hands;
      // A tool, so that the turn counts.
      hands.scene.set(ToolOptions{.shape = ToolOptions::Shape::points, .points_m = {{0.005, 0, 0}}});
      constexpr std::int64_t begins = 1000, ends = 1100;
      int falls = 0, with_force = 0;
      bool told = false, comes_back = false, without_ramp = false;
      bool was_pushing = false;
      double most_nm = 0.0;
      hands.run(2.5, [&](std::int64_t tick) {
        if (tick == begins - 1) was_pushing = hands.last(other).command.guard == GuardState::pass;
        if (tick == begins) way.is(hands.devices[faulty], true);
        if (tick == ends) way.is(hands.devices[faulty], false);
        const Command& command = hands.last(other).command;
        ASSERT_EQ(hands.devices[other].written_nm, command.torque_nm) << "in a view that is not turned";
        most_nm = std::max(most_nm, norm(command.torque_nm));
        const bool pushes = command.force_n != Vec3{} || command.torque_nm != Vec3{};
        if (tick > begins && tick <= ends) {
          falls += command.guard == GuardState::falling;
          told = told || command.cause == GuardCause::other_hand;
          // One tick until it is seen, one where only the tick finds it, three to fall.
          with_force += tick > begins + 5 && pushes;
          EXPECT_TRUE(tick < begins + 3 || hands.last(faulty).command.cause == way.cause) << tick;
        }
        if (tick > ends + 2 && pushes) {
          without_ramp = without_ramp || (!comes_back && command.guard != GuardState::ramp);
          comes_back = true;
        }
      });
      EXPECT_TRUE(was_pushing);
      EXPECT_GT(most_nm, 1e-5);
      EXPECT_EQ(with_force, 0);
      EXPECT_GE(falls, 1);
      EXPECT_TRUE(told);
      EXPECT_TRUE(comes_back);
      EXPECT_FALSE(without_ramp);
      // Not for the fault of its own that it did not have.
      for (const TickFrame& frame : hands.frames[other]) ASSERT_NE(frame.command.cause, GuardCause::device_fault) << frame.tick;
    }
  }
}

TEST(TwoHands, AHandThatIsTooFastLetsTheOtherFall) {
  TwoHands hands;
  bool told = false;
  int with_force = 0;
  hands.run(1.5, [&](std::int64_t tick) {
    if (tick >= 1000 && tick < 1100) hands.devices[0].way_m += 3e-3;  // 3 m/s
    told = told || hands.last(1).command.cause == GuardCause::other_hand;
    with_force += tick > 1030 && tick < 1095 && hands.last(1).command.force_n != Vec3{};
  });
  EXPECT_TRUE(told);
  EXPECT_EQ(with_force, 0);
}

TEST(TwoHands, APanicIsOfBothUntilAPersonResumes) {
  TwoHands hands;
  int with_force = 0;
  double after_n[2] = {};
  hands.run(3.0, [&](std::int64_t tick) {
    if (tick == 1000) hands.loop->panic();
    if (tick == 1500) hands.loop->resume();
    for (std::size_t h = 0; h < 2; ++h) {
      with_force += tick > 1004 && tick <= 1500 && hands.last(h).command.force_n != Vec3{};
      if (tick > 1500) after_n[h] = std::max(after_n[h], norm(hands.last(h).command.force_n));
    }
  });
  EXPECT_EQ(with_force, 0);
  EXPECT_GT(after_n[0], 0.1);
  EXPECT_GT(after_n[1], 0.1);
}

}  // namespace two_hands_test
}  // namespace palpa
