// The recorder: complete, ordered, exact traces; no waits for the disk; survival of kills.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <random>
#include <sstream>
#include <thread>

#include "palpa/device/hand.h"
#include "palpa/loop/loop.h"
#include "tests/loop/scenes.h"
#include "tests/solver/counted_allocations.h"

namespace palpa {
namespace recorder_test {

namespace fs = std::filesystem;
using testing::HasSubstr;

class RecorderTest : public test::InFolder {};

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

// Tick number `i` with parts of varying size, for any offset in a ring.
struct MadeTick {
  explicit MadeTick(std::int64_t i) {
    const double v = static_cast<double>(i);
    frame.tick = i;
    frame.t_s = v / 1000;
    frame.result.proxy_m = {v, -v, v / 3};
    modes.resize(static_cast<std::size_t>(i % 4), ModeForce{.force_n = {v, 0, 0}});
    for (std::uint32_t s = 0; s < static_cast<std::uint32_t>(i % 5); ++s) {
      steps.push_back(
          {.start_m = {v, s + 0.5, 0}, .first_primitive = static_cast<std::uint32_t>(placed.size()), .primitives = s});
      for (std::uint32_t p = 0; p < s; ++p)
        placed.push_back({.primitive = {.id = {0, static_cast<std::uint16_t>(p)}, .strength_n = v}});
    }
    if (i % 7 == 0) events.push_back({.kind = SessionEventKind::onset, .mode = 0, .value = v});
  }
  bool offer_to(Recorder& recorder) const { return recorder.offer(frame, modes, steps, placed, events); }
  void append_to(TraceWriter& writer) const { writer.append(frame, modes, steps, placed, events); }

  TickFrame frame;
  std::vector<ModeForce> modes;
  std::vector<SubStep> steps;
  std::vector<PlacedPrimitive> placed;
  std::vector<SessionEvent> events;
};

TEST_F(RecorderTest, TheTraceIsTheOneThatTheWriterWouldHaveWrittenAlone) {
  const std::vector<std::string> modes{"a", "b", "c", "d"};
  TraceWriter alone(folder("alone"), {.primitives = true}, "", modes);
  TraceWriter behind(folder("behind"), {.primitives = true}, "", modes);
  // Small enough for frequent wraps, at every offset.
  Recorder recorder(behind, 20'011);
  for (std::int64_t i = 0; i < 5000; ++i) {
    const MadeTick tick(i);
    tick.append_to(alone);
    while (!tick.offer_to(recorder)) recorder.keep_up(0);
  }
  recorder.finish();
  alone.finish();
  behind.finish();
  for (const char* file : {"ticks.csv", "modes.csv", "balances.csv", "primitives.csv", "events.csv", "timing.csv"}) {
    EXPECT_EQ(text_of(folder("alone") / file), text_of(folder("behind") / file)) << file;
  }
}

TEST_F(RecorderTest, WhereTheRingIsFullWholeTicksAreRefusedAndTheOthersStandInOrder) {
  TraceWriter writer(folder("trace"), {}, "", {"a", "b", "c", "d"});
  Recorder recorder(writer, 4096);
  std::int64_t taken = 0;
  for (std::int64_t i = 0; i < 20'000; ++i) taken += MadeTick(i).offer_to(recorder);
  recorder.finish();
  writer.finish();
  const std::vector<TraceTick> ticks = TraceReader(folder("trace")).ticks();
  EXPECT_EQ(static_cast<std::int64_t>(ticks.size()), taken);
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const TickFrame& frame = ticks[i].frame;
    const double v = static_cast<double>(frame.tick);
    EXPECT_EQ(frame.result.proxy_m, (Vec3{v, -v, v / 3}));
    if (i > 0) {
      EXPECT_GT(frame.tick, ticks[i - 1].frame.tick);
    }
  }
}

TEST_F(RecorderTest, WhatItTookReachesTheFilesWithoutBeingAsked) {
  TraceWriter writer(folder("trace"), {}, "", {});
  Recorder recorder(writer);
  for (std::int64_t i = 0; i < 10; ++i) ASSERT_TRUE(recorder.offer({.tick = i}, {}, {}, {}, {}));
  // No test of time, only of its occurrence.
  std::size_t found = 0;
  for (int look = 0; look < 3000 && found < 10; ++look) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    found = TraceReader(folder("trace")).ticks().size();
  }
  EXPECT_EQ(found, 10u);
}

TEST_F(RecorderTest, OfferAndGuardedTicksAllocateNothing) {
  TraceWriter writer(folder("trace"), {.primitives = true}, "", {"skin", "syrup"});
  Recorder recorder(writer);
  Session session(test::head_scene());
  GuardedSession guarded(session, 10.0);
  const auto hand = open_hand("sim:stroke,depth_m=0.03", Hold::relaxed);
  const long before = test::allocations;
  int in_contact = 0;
  for (int i = 0; i < 3000; ++i) {
    const DeviceState state = hand->read();
    const TickFrame frame = guarded.tick(i, i / 1000.0, 1e-3, {.position_m = state.position_m});
    hand->write(frame.command.force_n);
    recorder.offer(frame, session);
    hand->advance(1e-3);
    in_contact += frame.command.force_n != Vec3{};
  }
  EXPECT_EQ(test::allocations, before);
  EXPECT_GT(in_contact, 300);
}

TEST_F(RecorderTest, AFullDiskStopsARunAndIsSaid) {
  void (*old_handler)(int) = ::signal(SIGXFSZ, SIG_IGN);
  rlimit old{};
  ::getrlimit(RLIMIT_FSIZE, &old);
  TraceWriter writer(folder("trace"), {}, "", {"skin", "syrup"});
  Recorder recorder(writer);
  Session session(test::head_scene());
  const auto hand = open_hand("sim:press", Hold::relaxed);
  std::int64_t last_tick = 0;
  std::string said;
  const rlimit small{100'000, old.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &small);
  try {
    run_simulated(session, *hand, {.duration_s = 1000}, &recorder,
                  [&](const TickFrame& frame, const Session&) { last_tick = frame.tick; });
  } catch (const LoadError& error) {
    said = error.what();
  }
  std::string said_at_finish;
  try {
    recorder.finish();
  } catch (const LoadError& error) {
    said_at_finish = error.what();
  }
  ::setrlimit(RLIMIT_FSIZE, &old);
  ::signal(SIGXFSZ, old_handler);
  EXPECT_THAT(said, HasSubstr("cannot be written"));
  EXPECT_EQ(said_at_finish, said);
  EXPECT_LT(last_tick, 20'000);
  EXPECT_THROW(writer.finish(), LoadError);
  const TraceReader reader(folder("trace"));
  EXPECT_FALSE(reader.header().complete);
  EXPECT_GT(reader.ticks().size(), 50u);
}

TEST_F(RecorderTest, ATickThatNoRingOfThisSizeCanHoldIsSaidNotWaitedForForEver) {
  TraceWriter writer(folder("trace"), {}, "", {"skin", "syrup"});
  Recorder recorder(writer, 64);
  Session session(test::head_scene());
  const auto hand = open_hand("sim:press", Hold::relaxed);
  EXPECT_THROW(run_simulated(session, *hand, {.duration_s = 1}, &recorder, {}), std::length_error);
}

TEST_F(RecorderTest, AKilledRunIsReadableUpToItsLast100Ticks) {
  // Counts, visibly to both processes, the child's ticks.
  auto* felt = static_cast<std::atomic<std::int64_t>*>(
      ::mmap(nullptr, sizeof(std::atomic<std::int64_t>), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  ASSERT_NE(static_cast<void*>(felt), MAP_FAILED);
  new (felt) std::atomic<std::int64_t>(0);
  const std::vector<std::string> modes{"skin", "syrup"};
  for (const std::int64_t enough : {1, 50, 333, 4000}) {
    const fs::path killed = folder("killed" + std::to_string(enough));
    felt->store(0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      try {
        TraceWriter writer(killed, {.primitives = true}, "", modes);
        Recorder recorder(writer);
        Session session(test::head_scene());
        const auto hand = open_hand("sim:stroke,depth_m=0.03", Hold::relaxed);
        run_simulated(session, *hand, {.duration_s = 1e9}, &recorder,
                      [&](const TickFrame& frame, const Session&) { felt->store(frame.tick + 1); });
      } catch (...) {
      }
      ::_exit(1);
    }
    int status = 0;
    while (felt->load() < enough && ::waitpid(child, &status, WNOHANG) == 0) std::this_thread::yield();
    ::kill(child, SIGKILL);
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status)) << "the child ended by itself";

    const TraceReader reader(killed);
    EXPECT_FALSE(reader.header().complete);
    const std::vector<TraceTick> ticks = reader.ticks();
    EXPECT_GE(static_cast<std::int64_t>(ticks.size()), felt->load() - 100);
    for (std::size_t i = 0; i < ticks.size(); ++i) ASSERT_EQ(ticks[i].frame.tick, static_cast<std::int64_t>(i));

    // Replayed from the remains, every file is equal up to its end.
    TraceWriter writer(folder("again" + std::to_string(enough)), {.primitives = true}, "", modes);
    Session session(test::head_scene());
    GuardedSession guarded(session, 10.0);
    for (const auto& [frame] : ticks) {
      const TickFrame again = guarded.tick(frame.tick, frame.t_s, frame.dt_s,
                                           {.position_m = frame.result.probe_m,
                                            .velocity_m_per_s = frame.result.probe_velocity_m_per_s,
                                            .valid = frame.result.probe_valid,
                                            .buttons = frame.buttons});
      writer.append(again, session.modes(), session.sub_steps(), session.primitives(), session.events());
    }
    writer.finish();
    const TraceDifference difference = compare_traces(killed, folder("again" + std::to_string(enough)));
    EXPECT_TRUE(difference.same) << difference.where;
    EXPECT_EQ(difference.ticks, static_cast<std::int64_t>(ticks.size()));
  }
  ::munmap(felt, sizeof *felt);
}

/// A number of the environment, for more repetitions than a test has time for.
int times(const char* name, int otherwise) {
  const char* text = std::getenv(name);
  return text ? std::atoi(text) : otherwise;
}

// As above, but in real time: PALPA_KILLS=200 kills it at 200 random moments.
TEST_F(RecorderTest, ALiveRunThatIsKilledAtAnyMomentIsReadableUpToItsLastTenthOfASecond) {
  auto* felt = static_cast<std::atomic<std::int64_t>*>(
      ::mmap(nullptr, sizeof(std::atomic<std::int64_t>), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  ASSERT_NE(static_cast<void*>(felt), MAP_FAILED);
  new (felt) std::atomic<std::int64_t>(0);
  const std::vector<std::string> modes{"skin", "syrup"};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> moment_s(0.002, 0.5);
  std::int64_t most_lost = 0;
  const int kills = times("PALPA_KILLS", 10);
  for (int n = 0; n < kills; ++n) {
    const fs::path killed = folder("live" + std::to_string(n));
    felt->store(0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      try {
        TraceWriter writer(killed, {.motors = true}, "", modes);
        Recorder recorder(writer);
        LiveScene scene(test::head_scene());
        const auto hand = open_hand("sim:stroke,depth_m=0.03", Hold::relaxed);
        LiveOptions options;
        options.guard = guard_options_for({}, 10.0);
        LiveLoop loop(scene, *hand, options, &recorder);
        const std::atomic<bool> never{false};
        loop.run(never, [&](const TickFrame& frame, const Session&) {
          felt->store(frame.tick + 1);
          hand->advance(1e-3);
        });
      } catch (...) {
      }
      ::_exit(1);
    }
    int status = 0;
    while (felt->load() == 0 && ::waitpid(child, &status, WNOHANG) == 0) std::this_thread::yield();
    std::this_thread::sleep_for(std::chrono::duration<double>(moment_s(random)));
    ::kill(child, SIGKILL);
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status)) << "the child ended by itself";
    const TraceReader reader(killed);
    const std::vector<TraceTick> ticks = reader.ticks();
    const std::int64_t last = ticks.empty() ? -1 : ticks.back().frame.tick;
    most_lost = std::max(most_lost, felt->load() - 1 - last);

    Session session(test::head_scene());
    GuardedSession guarded(session, guard_options_for({}, 10.0));
    for (const auto& [frame] : ticks) {
      const TickFrame again = guarded.tick(frame.tick, frame.t_s, frame.dt_s,
                                           {.position_m = frame.result.probe_m,
                                            .velocity_m_per_s = frame.result.probe_velocity_m_per_s,
                                            .valid = frame.result.probe_valid,
                                            .buttons = frame.buttons},
                                           frame.circumstances);
      ASSERT_EQ(again.command.force_n, frame.command.force_n) << "tick " << frame.tick;
    }
    fs::remove_all(killed);
  }
  EXPECT_LE(most_lost, 100) << "ticks, of a millisecond each";
  std::printf("%d kills: at most %lld ticks of 1 ms were lost\n", kills, static_cast<long long>(most_lost));
  ::munmap(felt, sizeof *felt);
}

}  // namespace recorder_test
}  // namespace palpa
