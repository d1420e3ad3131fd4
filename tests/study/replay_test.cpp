#include <gmock/gmock.h>

#include <tuple>

#include "palpa/study/run.h"
#include "study_fixture.h"

namespace palpa {
namespace replay_test {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Replay : public StudyTest {
 protected:
  fs::path recorded(double duration_s = 1.5) const {
    RunOptions o = options("trace", duration_s);
    o.primitives = true;
    run(o);
    return o.out;
  }
  /// Replaces the first `from` in a file of the trace.
  void edit(const fs::path& file, const std::string& from, const std::string& to) const {
    std::string text = read(file);
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    std::ofstream(file, std::ios::binary) << text.replace(at, from.size(), to);
  }
  void say_incomplete(const fs::path& trace) const { edit(trace / "trace.toml", "complete = true", "complete = false"); }
  void cut(const fs::path& file, double share) const {
    fs::resize_file(file, static_cast<std::uintmax_t>(share * static_cast<double>(fs::file_size(file))));
  }
  std::string error_of(const fs::path& trace) const {
    try {
      replay(trace);
    } catch (const LoadError& error) {
      return error.what();
    }
    return {};
  }
};

TEST_F(Replay, IsTheSameForEveryKindOfHand) {
  int n = 0;
  for (const char* hand : {"sim:press", "sim:stroke", "sim:random,seed=3"}) {
    RunOptions o = options("trace" + std::to_string(n++), 1.5);
    o.primitives = true;
    o.hand = hand;
    run(o);
    const ReplayResult again = replay(o.out);
    EXPECT_TRUE(again.difference.same) << hand << ": " << again.difference.where;
    EXPECT_EQ(again.difference.ticks, 1500);
  }
}

TEST_F(Replay, IsTheSameWithADeviceInTheHand) {
  int n = 0;
  for (const char* device : {"touch", "omega,delay_ticks=2", "desktop,encoder_step_m=1e-4,max_force_n=0.7"}) {
    RunOptions o = options("trace" + std::to_string(n++), 1.5);
    o.primitives = true;
    o.device = device;
    o.scene_options.sets = {{"coupling.damping_ns_per_m", "1"}};
    run(o);
    const ReplayResult again = replay(o.out);
    EXPECT_TRUE(again.difference.same) << device << ": " << again.difference.where;
    EXPECT_EQ(again.difference.ticks, 1500);
  }
}

// Of tools, by hands that turn them on ideal devices, on those that cannot push against turning, and on those that can.
TEST_F(Replay, IsTheSameWithATool) {
  using Sets = std::vector<std::pair<std::string, std::string>>;
  const Sets rod{{"tool.shape", "rod"}, {"tool.length_m", "0.04"}, {"tool.points", "6"}, {"tool.centre_m", "[0, 0, 0.02]"}};
  const Sets pad{{"tool.shape", "pad"}, {"tool.radius_m", "0.01"}, {"tool.points", "16"}, {"tool.share", "0.0625"}};
  const Sets points{{"tool.points_m", "[[0, 0, 0], [0.01, 0, -0.01], [-0.01, 0.01, 0]]"}, {"mode.syrup.feet", "all"}};
  int n = 0;
  for (const auto& [sets, hand, device] :
       {std::tuple{rod, "sim:stroke,tilt_rad=0.4", ""}, std::tuple{points, "sim:press", "touch"},
        std::tuple{pad, "sim:press,tilt_rad=0.2", "touch"},
        std::tuple{points, "sim:random,seed=3,tilt_rad=1", "omega,max_torque_nm=0.05"}}) {
    RunOptions o = options("trace" + std::to_string(n++));
    o.primitives = true;
    o.hand = hand;
    o.device = device;
    o.scene_options.sets = sets;
    o.scene_options.sets.emplace_back("coupling.damping_ns_per_m", "1");
    o.scene_options.sets.emplace_back("volume.head.sampled", "64");
    run(o);
    const ReplayResult again = replay(o.out);
    EXPECT_TRUE(again.difference.same) << hand << ": " << again.difference.where;
    EXPECT_EQ(again.difference.ticks, 1000);
    double torque_nm = 0.0, command_nm = 0.0;
    for (const auto& [tick] : TraceReader(o.out).ticks()) {
      torque_nm = std::max(torque_nm, norm(tick.result.torque_nm));
      command_nm = std::max(command_nm, norm(tick.command.torque_nm));
    }
    EXPECT_GT(torque_nm, 1e-4) << hand << ": it is felt";
    const std::string kind = device;
    EXPECT_LE(command_nm, kind == "touch" || std::string(hand) == "sim:press" ? 0.0 : kind.empty() ? 0.3 : 0.05) << hand;
  }
}

TEST_F(Replay, IsTheSameWhereATraceOfAToolIsTheHand) {
  RunOptions o = options("trace");
  o.hand = "sim:stroke,tilt_rad=0.4";
  o.hold = Hold::rigid;
  o.scene_options.sets = {{"tool.shape", "ball"}, {"tool.radius_m", "0.005"}, {"volume.head.sampled", "64"}};
  run(o);
  RunOptions second = o;
  second.hand = (o.out / "ticks.csv").string();
  second.out = o.out.string() + "-again";
  run(second);
  const TraceDifference difference = compare_traces(o.out, second.out);
  EXPECT_TRUE(difference.same) << difference.where;
  EXPECT_EQ(difference.ticks, 1000);
}

TEST_F(Replay, IsTheSameAtRatesWhosePeriodIsNoRoundNumber) {
  int n = 0;
  for (const double rate_hz : {49.0, 333.0, 1234.5, 3000.0}) {
    RunOptions o = options("trace" + std::to_string(n++), 0.5);
    o.rate_hz = rate_hz;
    run(o);
    const ReplayResult again = replay(o.out);
    EXPECT_TRUE(again.difference.same) << rate_hz << ": " << again.difference.where;
  }
}

TEST_F(Replay, IsTheSameWhereTheProbeWasLostForAWhile) {
  write("hand.csv",
        "t_s,x_m,y_m,z_m,buttons\n0,0,0,0.08,0\n0.05,0,0,0.07,1\n0.1,0,0,0.06,1\n0.4,0.001,0,0.06,0\n0.45,0.01,0,0.06,2\n0.5,0."
        "02,0,0.06,0\n");
  RunOptions o = options("trace");
  o.hand = folder / "hand.csv";
  o.duration_s.reset();
  const RunResult result = run(o);
  EXPECT_GT(result.summary.invalid_probe_ticks, 0);
  const ReplayResult again = replay(o.out);
  EXPECT_TRUE(again.difference.same) << again.difference.where;
}

TEST_F(Replay, TakesTheSettingsOfTheRun) {
  RunOptions o = options("trace", 0.5);
  o.scene_options.sets = {{"coupling.stiffness_n_per_m", "321"}};
  run(o);
  const ReplayResult again = replay(o.out);
  EXPECT_TRUE(again.difference.same) << again.difference.where;
}

TEST_F(Replay, SaysWhereATraceWasChanged) {
  const fs::path trace = recorded();
  edit(trace / "scene.toml", "friction_n = 0.1", "friction_n = 0.3");
  const ReplayResult again = replay(trace);
  EXPECT_FALSE(again.difference.same);
  EXPECT_THAT(again.difference.where, HasSubstr(".csv:"));
}

TEST_F(Replay, ComparesAKilledRecordingAsFarAsItGoes) {
  for (const double share : {0.9, 0.5, 0.1, 0.02}) {
    const fs::path trace = recorded();
    say_incomplete(trace);
    for (const char* file : {"ticks.csv", "modes.csv", "balances.csv", "primitives.csv", "events.csv"})
      cut(trace / file, share);
    const ReplayResult again = replay(trace);
    EXPECT_TRUE(again.difference.same) << share << ": " << again.difference.where;
    EXPECT_LT(again.difference.ticks, 1500);
    fs::remove_all(trace);
  }
}

TEST_F(Replay, TakesFilesThatEndAtDifferentTicks) {
  const fs::path trace = recorded();
  say_incomplete(trace);
  cut(trace / "ticks.csv", 0.7);
  cut(trace / "modes.csv", 0.4);
  cut(trace / "balances.csv", 0.9);
  const ReplayResult again = replay(trace);
  EXPECT_TRUE(again.difference.same) << again.difference.where;
}

TEST_F(Replay, TakesARecordingThatEndsBeforeItsFirstTick) {
  const fs::path trace = recorded();
  say_incomplete(trace);
  for (const char* file : {"ticks.csv", "modes.csv", "balances.csv", "primitives.csv", "events.csv", "timing.csv"}) {
    const std::string text = read(trace / file);
    fs::resize_file(trace / file, text.find('\n') + 1);
  }
  const ReplayResult again = replay(trace);
  EXPECT_TRUE(again.difference.same) << again.difference.where;
  EXPECT_EQ(again.difference.ticks, 0);
}

TEST_F(Replay, RefusesDataThatWereNotFelt) {
  const fs::path trace = recorded();
  std::string header = read(trace / "trace.toml");
  if (const std::size_t at = header.find("[[data_file"); at != std::string::npos) FAIL() << "the phantom has no files";
  write("trace/trace.toml", header + "\n[[data_file]]\npath = \"/data/head.nrrd\"\nbytes = 5\nsha256 = \"00ff\"\n");
  EXPECT_THAT(error_of(trace), testing::AllOf(HasSubstr("/data/head.nrrd"), HasSubstr("; ")));
}

TEST_F(Replay, RefusesWhatIsNoTrace) {
  EXPECT_THAT(error_of(folder / "none"), HasSubstr("none"));
  EXPECT_THAT(error_of(folder / "scene.toml"), HasSubstr("scene.toml"));
  fs::create_directory(folder / "empty");
  EXPECT_THAT(error_of(folder / "empty"), HasSubstr("empty"));
}

TEST_F(Replay, LeavesNothingInTheTemporaryFolder) {
  const fs::path trace = recorded(0.1);
  const fs::path temporary = folder / "temporary";
  fs::create_directory(temporary);
  const char* before = ::getenv("TMPDIR");
  const std::string saved = before ? before : "";
  ::setenv("TMPDIR", temporary.c_str(), 1);
  replay(trace);
  say_incomplete(trace);
  edit(trace / "scene.toml", "friction_n = 0.1", "friction_n = \"much\"");
  EXPECT_THAT(error_of(trace), HasSubstr("friction_n"));
  before ? ::setenv("TMPDIR", saved.c_str(), 1) : ::unsetenv("TMPDIR");
  EXPECT_TRUE(fs::is_empty(temporary));
}

}  // namespace replay_test
}  // namespace palpa
