// Links that lose, delay, close: the guard, reports that repeat samples, traces that replay.
#include <algorithm>
#include <array>
#include <cmath>

#include "palpa/loop/loop.h"
#include "tests/serve/far_scenes.h"
#include "tests/solver/random_problems.h"

namespace palpa {
namespace far_link_test {

constexpr double dt = 1e-3;

Vec3 pressed_m(double t_s) { return {0.01 * std::sin(2.0 * t_s), 0.0, 0.01 * std::exp(-3.0 * t_s) - 0.003}; }

// Of hands with motors and without: no force 150 ms after the usual age of a model, for outages at any time.
TEST(FarLinks, LetGoWhereModelsAreLate) {
  const Scene scene = test::flat_wall(0.2);
  test::Random random(4);
  for (int i = 0; i < 24; ++i) {
    const double delay_s = 0.05 * random.uniform(0.0, 1.0), cut_s = random.uniform(1.5, 2.0);
    LinkedHand linked(scene, {.delay_s = delay_s, .jitter_s = 0.2 * delay_s}, {.motors = i % 2 == 0});
    double usual_s = 0.0, largest_n = 0.0;
    for (int n = 0; n * dt < cut_s + 0.6; ++n) {
      const double t_s = n * dt;
      linked.is_up = t_s < cut_s;
      const HandTick tick = linked.tick({.position_m = pressed_m(t_s)}, dt);
      if (linked.is_up && t_s > cut_s - 0.5) {
        usual_s = std::max(usual_s, tick.model_age_s);
        largest_n = std::max(largest_n, norm(tick.command_n));
      }
      if (!linked.is_up && tick.model_age_s > usual_s + 0.15) {
        EXPECT_EQ(tick.command_n, Vec3{}) << i << " at " << t_s << ", delay " << delay_s;
        EXPECT_EQ(tick.link, LinkState::stale);
      }
    }
    EXPECT_GT(largest_n, 0.5);
    // Back again: the force returns.
    linked.is_up = true;
    HandTick tick;
    for (int n = 0; n < 1500; ++n) tick = linked.tick({.position_m = pressed_m(5.0 + n * dt)}, dt);
    EXPECT_EQ(tick.link, LinkState::up);
  }
}

TEST(FarLinks, LetGoAtOnceWhereTheConnectionCloses) {
  const Scene scene = test::flat_wall();
  for (const bool motors : {false, true}) {
    LinkedHand linked(scene, {.delay_s = 0.005}, {.motors = motors});
    for (int n = 0; n < 2500; ++n) linked.tick({.position_m = pressed_m(n * dt)}, dt);
    linked.is_up = false;
    linked.hand.set_connected(false);
    HandTick tick;
    for (int n = 0; n < 3; ++n) tick = linked.tick({.position_m = pressed_m(2.5)}, dt);
    EXPECT_EQ(tick.command_n, Vec3{}) << motors;
    EXPECT_EQ(tick.link, LinkState::closed);
    if (motors) {
      EXPECT_EQ(tick.cause, GuardCause::link_closed);
    }
  }
}

// On a short link three lost messages in a row lose no sample; more make one longer tick.
TEST(FarLinks, RepeatSamplesAgainstLoss) {
  LinkedHand linked(test::flat_wall(), {.delay_s = 0.002, .loss = 0.2, .seed = 7});
  std::int64_t ticks = 0, first = -1, last = 0;
  double time_s = 0.0;
  linked.data.record(nullptr, [&](const TickFrame& frame, const Session&, const ProbeReport& report) {
    if (first < 0) first = static_cast<std::int64_t>(report.newest - report.count);
    ++ticks;
    time_s += frame.dt_s;
    last = static_cast<std::int64_t>(report.newest);
  });
  for (int n = 0; n < 20'000; ++n) linked.tick({.position_m = pressed_m(n * dt)}, dt);
  const auto samples = static_cast<double>(last - first);
  EXPECT_GT(static_cast<double>(ticks), (1.0 - 2.0 * std::pow(0.2, 4)) * samples);
  EXPECT_LT(static_cast<double>(ticks), samples);
  EXPECT_NEAR(time_s, samples * dt, 1e-3);
}

// A report of several samples: the model is that of the last sub-step.
TEST(FarLinks, TakeRowsOfTheLastSampleOfAReport) {
  DataSide data(test::flat_wall());
  std::array<std::byte, most_message_bytes> room;
  data.take({room.data(),
             write_message(HandHello{.max_force_n = 20.0, .max_stiffness_n_per_m = 1e4, .max_damping_ns_per_m = 9.0}, 0, room)},
            0.0);
  double now_s = 0.0;
  std::uint64_t newest = 0;
  // Rows of the model that are not ahead, after samples at these heights.
  const auto rows_after = [&](std::array<double, 3> heights_m) {
    ProbeReport report{.newest = newest += 3, .count = 3};
    for (std::size_t n = 0; n < 3; ++n)
      report.samples[n] = {.position_m = {0.0, 0.0, heights_m[n]}, .time_step_s = 1e-3f, .valid = true};
    data.take({room.data(), write_message(report, newest, room)}, now_s += 0.1);
    ModelUpdate model;
    while (const std::size_t bytes = data.give(room, now_s)) read_message({room.data(), bytes}, model);
    EXPECT_EQ(model.answers, newest);
    return std::count_if(model.rows.begin(), model.rows.begin() + model.count, [](const ModelRow& row) { return !row.ahead; });
  };
  EXPECT_EQ(rows_after({0.004, 0.003, 0.003}), 0);
  EXPECT_EQ(rows_after({-0.001, -0.001, -0.001}), 1);
  EXPECT_EQ(rows_after({0.003, 0.003, 0.003}), 0);
}

// The ticks of the data's side, by the samples that arrived, are those of an ordinary session, to the bit.
TEST(FarLinks, LeaveAnOrdinarySession) {
  const Scene scene = test::phantom("head_phantom");
  LinkedHand linked(scene, {.delay_s = 0.008, .jitter_s = 0.004, .loss = 0.05});
  Session again(scene);
  GuardedSession guarded(again, HandSideOptions{}.device.max_force_n);
  linked.data.record(nullptr, [&](const TickFrame& frame, const Session&, const ProbeReport&) {
    const Tick& felt = frame.result;
    const TickFrame replayed = guarded.tick(frame.tick, frame.t_s, frame.dt_s,
                                            {.position_m = felt.probe_m, .valid = felt.probe_valid, .buttons = frame.buttons});
    EXPECT_EQ(replayed.result.proxy_m, felt.proxy_m);
    EXPECT_EQ(replayed.command.force_n, frame.command.force_n);
  });
  for (const Vec3& probe_m : test::positions_m("sim:random,seed=2", 4.0)) linked.tick({.position_m = probe_m}, dt);
}

// The work on the hand is that of model, link and zero-order hold, less what is stored (docs/theory.md 11).
TEST(FarLinks, BookAllEnergy) {
  for (const char* name : {"head_phantom", "flow_phantom"}) {
    LinkedHand linked(test::phantom(name), {.delay_s = 0.015, .jitter_s = 0.01, .loss = 0.02});
    double work_j = 0.0, given_j = 0.0, stored_j = 0.0;
    for (const Vec3& probe_m : test::positions_m("sim:random,seed=5", 4.0)) {
      const HandTick tick = linked.tick({.position_m = probe_m}, dt);
      work_j += tick.work_j;
      given_j += tick.sampling_j + tick.model_j + tick.link_j - tick.released_j;
      stored_j = tick.stored_j;
      EXPECT_NEAR(work_j, given_j - stored_j, 1e-9);
    }
  }
}

TEST(FarLinks, GoOnInAChangedScene) {
  LinkedHand linked(test::flat_wall(0.0, 500.0), {.delay_s = 0.01});
  Vec3 last_n, last_m;
  for (int n = 0; n < 6000; ++n) {
    if (n == 3000) linked.data.change(test::flat_wall(0.3, 800.0));
    const Vec3 probe_m = pressed_m(n * dt);
    const HandTick tick = linked.tick({.position_m = probe_m}, dt);
    // The hand's own motion, and the spread of an update.
    if (n > 1000) {
      EXPECT_LE(distance(tick.force_n, last_n), 800.0 * 2.0 * distance(probe_m, last_m) + 0.11) << n;
    }
    last_n = tick.force_n, last_m = probe_m;
  }
  EXPECT_EQ(linked.hand.welcome().scene, 2u);
  EXPECT_EQ(linked.hand.welcome().stiffness_n_per_m, 800.0);
  EXPECT_NEAR(last_n.z, 800.0 * 0.003, 0.01);
}

TEST(FarLinks, AreRefusedForToolsAndEarlierLaws) {
  Scene tool = test::flat_wall();
  tool.set(ToolOptions{.shape = ToolOptions::Shape::pad, .radius_m = 0.01});
  EXPECT_THROW(DataSide{tool}, SceneError);
  std::array<std::byte, most_message_bytes> hello;
  const std::size_t bytes = write_message(HandHello{.max_force_n = 3.0}, 0, hello);
  DataSide data(test::flat_wall());
  EXPECT_THROW(data.take({hello.data(), bytes}, 0.0), SceneError);
  EXPECT_THROW(link_options("delay_s=20"), LoadError);
  EXPECT_EQ(link_options("delay=20,jitter=3").jitter_s, 0.003);
  EXPECT_THROW(link_options("loss=2"), LoadError);
  EXPECT_EQ(link_options("delay_ms=20,loss=0.5").delay_s, 0.02);
}

}  // namespace far_link_test
}  // namespace palpa
