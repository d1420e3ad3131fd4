#include "palpa/study/run.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "palpa/base/limits.h"
#include "study_fixture.h"

namespace palpa {
namespace run_test {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Run : public StudyTest {
 protected:
  /// The error of a run; empty: none.
  std::string error_of(const RunOptions& o) const {
    try {
      run(o);
    } catch (const LoadError& error) {
      return error.what();
    }
    return {};
  }
};

TEST_F(Run, TwiceGivesTheSameBytesInEveryCsvButTheTimes) {
  RunOptions once = options("once"), twice = options("twice");
  once.primitives = twice.primitives = true;
  const RunResult a = run(once), b = run(twice);
  const auto files = reproducible_files(once.out);
  EXPECT_EQ(files.size(), 5u) << "ticks, modes, balances, primitives, events";
  EXPECT_EQ(files, reproducible_files(twice.out));
  EXPECT_EQ(a.summary.contact_share, b.summary.contact_share);
  EXPECT_GT(a.summary.contact_share, 0.0) << "a run that touches nothing shows nothing";
}

TEST_F(Run, IsTheSameWithAndWithoutATrace) {
  const Summary recorded = run(options("trace")).summary;
  const Summary felt = run(options("")).summary;
  EXPECT_EQ(recorded.ticks, felt.ticks);
  EXPECT_EQ(recorded.force_max_n, felt.force_max_n);
  EXPECT_EQ(recorded.energy.dissipated_j, felt.energy.dissipated_j);
}

TEST_F(Run, RecordsTheSeedAlsoWhereNoneWasNamed) {
  RunOptions named = options("named", 0.2), unnamed = options("unnamed", 0.2);
  unnamed.hand = "sim:random";
  run(unnamed);
  const std::vector<std::uint64_t> seeds = TraceReader(unnamed.out).header().seeds;
  ASSERT_EQ(seeds.size(), 1u);
  named.hand = "sim:random,seed=" + std::to_string(seeds.front());
  run(named);
  EXPECT_TRUE(compare_traces(named.out, unnamed.out).same);
}

// The device limits the force, rounds the read positions of either hand, and is named in the output.
TEST_F(Run, IsFeltThroughTheDeviceThatTheHandHolds) {
  int n = 0;
  for (const Hold hold : {Hold::rigid, Hold::relaxed}) {
    RunOptions o = options("trace" + std::to_string(n++), 1.5);
    o.hold = hold;
    o.device = "touch,max_force_n=0.7,encoder_step_m=1e-4";
    const RunResult felt = run(o);
    const TraceReader reader(o.out);
    EXPECT_EQ(reader.header().device_name, o.device);
    EXPECT_EQ(reader.header().device_max_force_n, 0.7);
    EXPECT_EQ(reader.header().device_encoder_step_m, 1e-4);
    EXPECT_LE(felt.summary.force_max_n, 0.7 * (1 + 1e-12));
    EXPECT_GT(felt.summary.force_max_n, 0.0);
    EXPECT_THAT(felt.summary.notes, testing::Contains(HasSubstr(o.device)));
    EXPECT_THAT(felt.warnings, testing::Contains(HasSubstr("is rated for up to 400 N/m")));
    for (const TraceTick& tick : reader.ticks()) {
      const Vec3 steps = tick.frame.result.probe_m / 1e-4;
      EXPECT_NEAR(steps.z, std::round(steps.z), 1e-6);
    }
  }
  RunOptions wrong = options("", 0.1);
  wrong.device = "phantom";
  EXPECT_THAT(error_of(wrong), HasSubstr("device: no preset 'phantom'; there are touch"));
}

// One sentence for each level stronger than the output limit: named levels never break, others do.
TEST_F(Run, NamesTheLevelsThatAreStrongerThanWhatReachesTheHand) {
  const auto named = [](const std::vector<std::string>& notes, const std::string& level) {
    return std::ranges::count_if(notes, [&](const std::string& note) {
      return note.starts_with("The level " + level + " of 'skin'") &&
             note.find("cannot be pressed through") != std::string::npos;
    });
  };
  RunOptions o = options("");
  const std::vector<std::string> notes = prepare(o).notes;
  EXPECT_EQ(named(notes, "skin"), 0);
  EXPECT_EQ(named(notes, "bone"), 1);
  EXPECT_THAT(notes, testing::Contains(
                         testing::AllOf(HasSubstr("holds up to 4 N"), HasSubstr("3.3 N reach"), HasSubstr("coupling.max_"))));

  o.scene_options.sets = {{"coupling.max_force_n", "4"}};
  EXPECT_EQ(named(prepare(o).notes, "bone"), 0) << "what reaches the hand is enough";

  o.device = "touch,max_force_n=0.7";
  const std::vector<std::string> of_device = prepare(o).notes;
  EXPECT_EQ(named(of_device, "skin"), 1);
  EXPECT_EQ(named(of_device, "bone"), 1);
  EXPECT_THAT(of_device, testing::Contains(HasSubstr("0.7 N reach the hand (the device's limit)")));
  o.scene_options.sets = {{"coupling.max_force_n", "4"}, {"mode.skin.enabled", "false"}};
  const std::vector<std::string> of_off = prepare(o).notes;
  EXPECT_EQ(named(of_off, "skin") + named(of_off, "bone"), 0) << "a mode that is not felt";

  RunOptions pressed = options("", 3.0);
  pressed.hand = "sim:press,depth_m=0.02";
  pressed.hold = Hold::rigid;
  for (const char* limit_n : {"0.7", "0.9"}) {
    pressed.scene_options.sets = {{"coupling.max_force_n", limit_n}};
    const Summary felt = run(pressed).summary;
    EXPECT_EQ(felt.first_break_through_s < 0.0, named(felt.notes, "skin") == 1) << limit_n;
  }
}

TEST_F(Run, LeavesACompleteTraceThatSaysWhatWasFelt) {
  RunOptions o = options("trace", 0.2);
  o.hand = "sim:random,seed=17";
  o.rate_hz = 2000;
  o.scene_options.sets = {{"mode.skin.friction_n", "0.2"}};
  const RunResult result = run(o);
  EXPECT_EQ(result.summary.ticks, 400);
  const TraceReader reader(o.out);
  EXPECT_TRUE(reader.header().complete);
  EXPECT_EQ(reader.header().seeds, std::vector<std::uint64_t>{17});
  EXPECT_EQ(reader.header().sets, o.scene_options.sets);
  EXPECT_EQ(reader.header().arguments, o.arguments);
  EXPECT_EQ(reader.header().dt_s, 1.0 / 2000);
  EXPECT_EQ(reader.scene_text(), phantom_scene);
  EXPECT_EQ(reader.ticks().size(), 400u);
}

TEST_F(Run, AnInterruptLeavesACompleteTrace) {
  RunOptions o = options("trace", 1e6);
  std::atomic<bool> stop = false;
  o.progress = [&](double) { stop = true; };
  const RunResult result = run(o, &stop);
  EXPECT_TRUE(result.interrupted);
  EXPECT_GT(result.summary.ticks, 0);
  const TraceReader reader(o.out);
  EXPECT_TRUE(reader.header().complete);
  EXPECT_EQ(static_cast<std::int64_t>(reader.ticks().size()), result.summary.ticks);
}

TEST_F(Run, ProgressNeverFallsAndStaysBetweenNothingAndAll) {
  RunOptions o = options("", 3.0);
  std::vector<double> shares;
  o.progress = [&](double share) { shares.push_back(share); };
  run(o);
  ASSERT_GE(shares.size(), 3u);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_GE(shares.front(), 0.0);
  EXPECT_LE(shares.back(), 1.0);
}

TEST_F(Run, RefusesNumbersThatCannotBeUsed) {
  for (const double rate_hz : {0.0, -1.0, 0.5, 1e9, std::numeric_limits<double>::quiet_NaN()}) {
    RunOptions o = options("trace");
    o.rate_hz = rate_hz;
    EXPECT_THAT(error_of(o), HasSubstr("; a rate lies between")) << rate_hz;
  }
  for (const double duration_s :
       {0.0, -1.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    RunOptions o = options("trace");
    o.duration_s = duration_s;
    EXPECT_THAT(error_of(o), HasSubstr("; a duration is finite")) << duration_s;
  }
  EXPECT_FALSE(fs::exists(folder / "trace"));
}

TEST_F(Run, WrongInputLeavesNothingBehind) {
  RunOptions no_scene = options("trace");
  no_scene.scene = folder / "none.toml";
  EXPECT_THAT(error_of(no_scene), HasSubstr("none.toml"));

  RunOptions no_hand = options("trace");
  no_hand.hand = "";
  EXPECT_THAT(error_of(no_hand), HasSubstr("hand: "));

  RunOptions bad_hand = options("trace");
  bad_hand.hand = "sim:jump";
  EXPECT_THAT(error_of(bad_hand), HasSubstr("jump"));

  write("hand.csv", "a,b,c\n1,2,3\n");
  RunOptions bad_file = options("trace");
  bad_file.hand = folder / "hand.csv";
  EXPECT_THAT(error_of(bad_file), HasSubstr("hand.csv"));
  EXPECT_FALSE(fs::exists(folder / "trace"));
}

TEST_F(Run, EndsWithinADayAndFitsOnItsDisk) {
  write("hand.csv", "t_s,x_m,y_m,z_m\n0,0,0,0\n1e15,0,0,0.01\n");
  RunOptions o = options("trace");
  o.hand = (folder / "hand.csv").string();
  o.duration_s.reset();
  EXPECT_EQ(error_of(o), "duration: 1e+15 s are " + more_than(limit::run_s));
  write("hand.csv", "t_s,x_m,y_m,z_m\n0,0,0,0\n86400,0,0,0.01\n");
  o.rate_hz = 1e5;  // a trace of more than a terabyte
  if (fs::space(folder).available < 1'000'000'000'000U) {
    EXPECT_THAT(error_of(o), testing::AllOf(HasSubstr("a trace of 86400 s takes "), HasSubstr("are free on its disk; ")));
  }
  EXPECT_FALSE(fs::exists(o.out));
  o.duration_s = 0.1;
  o.rate_hz = 1000.0;
  EXPECT_EQ(error_of(o), "");
}

TEST_F(Run, NeverWritesIntoWhatIsThere) {
  fs::create_directory(folder / "trace");
  EXPECT_THAT(error_of(options("trace")), HasSubstr("exists already"));
  EXPECT_TRUE(fs::is_empty(folder / "trace"));
  write("file", "mine");
  EXPECT_THAT(error_of(options("file")), HasSubstr("exists already"));
  EXPECT_EQ(read(folder / "file"), "mine");
  fs::create_symlink("nowhere", folder / "link");
  EXPECT_THAT(error_of(options("link")), HasSubstr("exists already"));
  EXPECT_THAT(error_of(options("no/such/folder")), HasSubstr("does not exist"));
}

TEST_F(Run, PreparingMakesNothing) {
  const PreparedRun prepared = prepare(options("trace", 2.5));
  EXPECT_FALSE(fs::exists(folder / "trace"));
  EXPECT_EQ(prepared.duration_s, 2.5);
  EXPECT_EQ(prepared.loaded.scene.modes().size(), 2u);
}

TEST_F(Run, LastsAsLongAsTheRecordingUnlessToldOtherwise) {
  write("hand.csv", "t_s,x_m,y_m,z_m\n0,0,0,0.1\n0.05,0,0,0.09\n0.1,0,0,0.08\n0.15,0,0,0.07\n");
  RunOptions o = options("");
  o.hand = folder / "hand.csv";
  o.duration_s.reset();
  EXPECT_NEAR(prepare(o).duration_s, 0.15, 1e-12);
  o.hand = "sim:press";
  EXPECT_EQ(prepare(o).duration_s, 10.0);
}

TEST_F(Run, FeelsATickForEachRowOfARecording) {
  for (const double begin_s : {0.0, 5.0, 1723456.789}) {
    for (const int rows : {1, 2, 100, 2000}) {
      std::string text = "t_s,x_m,y_m,z_m\n";
      char row[120];
      for (int n = 0; n < rows; ++n) {
        std::snprintf(row, sizeof row, "%.6f,%.9f,0.001,%.9f\n", begin_s + 0.001 * n, 1e-5 * n, 0.08 - 3e-5 * n);
        text += row;
      }
      write("hand.csv", text);
      const std::string trace = "trace" + std::to_string(rows) + "-" + std::to_string(begin_s);
      RunOptions o = options(trace);
      o.hand = folder / "hand.csv";
      o.duration_s.reset();
      o.place = Place::as_recorded;
      run(o);
      const TraceReader reader(o.out);
      ASSERT_EQ(std::ssize(reader.ticks()), rows) << trace;
      const Tick last = reader.ticks().back().frame.result;
      EXPECT_TRUE(last.probe_valid) << trace;
      EXPECT_NEAR(distance(last.probe_m, {1e-5 * (rows - 1), 0.001, 0.08 - 3e-5 * (rows - 1)}), 0.0, 1e-8) << trace;
    }
  }
}

TEST_F(Run, LaysARecordingWhereItIsToldTo) {
  const std::string rows = "0,0.3,0.2,0.1\n0.05,0.3,0.2,0.09\n0.1,0.3,0.2,0.08\n";
  for (const bool is_own : {false, true}) {
    write("hand.csv", (is_own ? "t_s,probe_x_m,probe_y_m,probe_z_m\n" : "t_s,x_m,y_m,z_m\n") + rows);
    RunOptions o = options("");
    o.hand = folder / "hand.csv";
    const auto first_m = [&](std::optional<Place> place) {
      o.place = place;
      return prepare(o).target->at(0.0).position_m;
    };
    const Vec3 recorded_m{0.3, 0.2, 0.1}, centred_m{0.0, 0.0, 0.01};
    EXPECT_EQ(first_m(Place::as_recorded), recorded_m);
    EXPECT_FALSE(prepare(o).laid);
    EXPECT_NEAR(distance(first_m(Place::centred), centred_m), 0.0, 1e-15);
    EXPECT_FALSE(prepare(o).laid);
    first_m(Place::fitted);
    EXPECT_TRUE(prepare(o).laid);
    EXPECT_THAT(prepare(o).notes, testing::Contains(HasSubstr("The recording was moved by")));
    EXPECT_EQ(first_m({}) == recorded_m, is_own) << "the columns of our own ticks.csv stay where they were";
    EXPECT_EQ(place_by_fit(o, true), is_own ? Place::as_recorded : Place::fitted);
    EXPECT_EQ(place_by_fit(o, false), is_own ? Place::as_recorded : Place::centred);
  }
}

TEST_F(Run, FeelsGivenPositionsAsASessionDoes) {
  std::vector<Vec3> path_m;
  for (int n = 0; n < 3000; ++n) path_m.push_back({0.01 * std::sin(0.003 * n), 0.02, 0.08 - 2e-5 * n});
  for (const double dt_s : {1e-3, 1.0 / 3000.0, 2e-3}) {
    RunOptions o = options("given" + std::to_string(1.0 / dt_s));
    o.hand.clear();
    o.duration_s.reset();
    o.rate_hz = 1.0 / dt_s;
    o.target = sampled_target(path_m, dt_s);
    PreparedRun prepared = prepare(o);
    Session session(prepared.loaded.scene);
    session.set_force_limit(force_limit_n(prepared.loaded.scene, prepared.hand->limits().max_force_n));
    run(std::move(prepared), o);
    const std::vector<TraceTick> ticks = TraceReader(o.out).ticks();
    ASSERT_EQ(ticks.size(), path_m.size());
    double most_n = 0.0;
    for (std::size_t n = 0; n < path_m.size(); ++n) {
      const Tick& felt = ticks[n].frame.result;
      EXPECT_EQ(felt.probe_m, path_m[n]) << n;
      const Tick own = session.tick({.position_m = path_m[n]}, 1.0 / o.rate_hz);
      EXPECT_NEAR(distance(felt.force_n, own.force_n), 0.0, 1e-9) << n;
      most_n = std::max(most_n, norm(own.force_n));
    }
    EXPECT_GT(most_n, 0.5) << "nothing was felt";
  }
}

}  // namespace run_test
}  // namespace palpa
