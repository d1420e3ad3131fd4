// Runs and replays of several hands, by the program.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/app/program.h"

namespace palpa {
namespace hands_command_test {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;
using testing::StartsWith;

class TwoHands : public ProgramTest {
 protected:
  TwoHands() {
    write_scene("two.toml", "[volume.head]",
                "[[hand]]\nname = \"left\"\nat_m = [-0.02, 0, 0]\n[hand.tool]\nshape = \"pad\"\nradius_m = 0.006\npoints = 8\n"
                "[[hand]]\nname = \"right\"\nat_m = [0.02, 0, 0]\n[volume.head]");
  }
};

TEST_F(TwoHands, RunRecordAndReplayTogether) {
  const Ended run =
      palpa({"run", "two.toml", "--hand", "sim:press", "--hand", "sim:stroke", "--duration-s", "0.5", "--out", "trace"});
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, testing::AllOf(StartsWith("left\n"), HasSubstr("\nright\n"), HasSubstr("Recorded in trace\n")));
  const Ended same = palpa({"replay", "trace"});
  EXPECT_EQ(same.out, "left: identical in all 500 ticks\nright: identical in all 500 ticks\n") << same.err;
  EXPECT_EQ(same.code, 0);
  EXPECT_EQ(palpa({"replay", "trace/right"}).out, "identical in all 500 ticks\n");
  const json answers = json::parse(palpa({"replay", "trace", "--json"}).out);
  EXPECT_EQ(answers["left"]["same"], true);
  EXPECT_EQ(answers["right"]["ticks"], 500);

  std::string ticks = read(folder / "trace/right/ticks.csv");
  ticks.replace(ticks.rfind('\n', ticks.size() - 2) + 1, 3, "999");
  write("trace/right/ticks.csv", ticks);
  const Ended differs = palpa({"replay", "trace"});
  EXPECT_EQ(differs.code, 1);
  EXPECT_THAT(differs.out, testing::AllOf(StartsWith("left: identical"), HasSubstr("right: differs at ")));
}

TEST_F(TwoHands, AreSummedUpByName) {
  const std::vector<std::string> by_name{"run",          "two.toml", "--hand", "right=sim:press", "--hand", "left=sim:stroke",
                                         "--duration-s", "0.1",      "--json"};
  const Ended run = palpa(by_name);
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(json::parse(run.out)["left"]["ticks"], 100);
  EXPECT_EQ(json::parse(run.out)["right"]["ticks"], 100);
  const Ended dry = palpa(
      {"run", "two.toml", "--hand", "sim:press", "--hand", "sim:stroke", "--device", "right=touch", "--dry-run", "--json"});
  ASSERT_EQ(dry.code, 0) << dry.err;
  EXPECT_EQ(json::parse(dry.out)["left"]["device"], "");
  EXPECT_THAT(json::parse(dry.out)["right"]["device"].get<std::string>(), StartsWith("touch"));
}

TEST_F(TwoHands, AreReportedTogether) {
  ASSERT_EQ(
      palpa({"run", "two.toml", "--hand", "sim:press", "--hand", "sim:press", "--duration-s", "0.1", "--out", "trace"}).code,
      0);
  const Ended report = palpa({"report", "trace"});
  if (report.err.find("was built without pictures") != std::string::npos) GTEST_SKIP() << report.err;
  EXPECT_EQ(report.code, 0) << report.err;
  EXPECT_EQ(report.out, "trace/report.html\n");
  for (const char* file : {"trace/report.html", "trace/left/report.html", "trace/right/report.html"})
    EXPECT_TRUE(fs::exists(folder / file)) << file;
  expect_refusal({"report", "trace", "--out", "page.html"},
                 {"trace: holds a trace of each hand, and --out", "as in trace/left"});
}

// Of a pad of radius r held at its middle by a coupling of stiffness k: the spring against turning is k ρ².
TEST_F(TwoHands, HaveTheirToolsDescribedByADryRun) {
  const std::vector<std::string> dry{"run",      "two.toml",
                                     "--hand",   "sim:press,tilt_rad=0.1",
                                     "--hand",   "sim:press",
                                     "--device", "left=touch",
                                     "--set",    "hand.left.tool.turning_radius_m=0.02",
                                     "--set",    "coupling.max_torque_nm=0.05",
                                     "--dry-run"};
  std::vector<std::string> with_json = dry;
  with_json.push_back("--json");
  const json what = json::parse(palpa(with_json).out);
  EXPECT_TRUE(what["right"]["tool"].is_null()) << "a point";
  const json& pad = what["left"]["tool"];
  EXPECT_EQ(pad["shape"], "pad");
  EXPECT_EQ(pad["feet"], 8);
  EXPECT_EQ(pad["share"], 1.0);
  EXPECT_EQ(pad["turning_radius_m"], 0.02);
  EXPECT_NEAR(pad["turn_stiffness_nm_per_rad"].get<double>(), what["left"]["stiffness_n_per_m"].get<double>() * 0.02 * 0.02,
              1e-12);
  EXPECT_NEAR(pad["turn_damping_nms_per_rad"].get<double>(), what["left"]["damping_ns_per_m"].get<double>() * 0.02 * 0.02,
              1e-12);
  for (int axis = 0; axis < 2; ++axis) EXPECT_LE(pad["size_m"][axis].get<double>(), 0.012 + 1e-12);
  EXPECT_EQ(pad["size_m"][2], 0.0) << "flat";
  EXPECT_LE(pad["reach_m"].get<double>(), 0.006 + 1e-12);
  EXPECT_EQ(pad["max_torque_nm"], 0.0) << "a Touch senses turns alone";
  EXPECT_EQ(pad["senses_turn"], true);
  const Ended text = palpa(dry);
  EXPECT_THAT(text.out,
              testing::AllOf(HasSubstr("tool       pad: 8 feet, "), HasSubstr("foot     bears 1 of each strength"),
                             HasSubstr("turning  radius 0.02 m: "), HasSubstr("no torque: the device senses turns alone")));
  std::vector<std::string> ideal = with_json;
  ideal.erase(ideal.begin() + 6, ideal.begin() + 8);
  EXPECT_EQ(json::parse(palpa(ideal).out)["left"]["tool"]["max_torque_nm"], 0.05) << "the scene's";
}

TEST_F(TwoHands, OfAnotherNumberAreRefusedInALine) {
  expect_refusal({"run", "two.toml", "--hand", "sim:press"},
                 {"two.toml: the scene has 2 hands (left, right), and 1 is given; ", "--set only_hand=left"});
  expect_refusal({"run", "two.toml", "--hand", "left=sim:press"}, {"the scene has 2 hands (left, right), and 1 is given; "});
  write_scene("one.toml");
  expect_refusal({"run", "one.toml", "--hand", "sim:press", "--hand", "sim:press"},
                 {"one.toml: the scene has one hand, and 2 --hand are given; add a [[hand]] for each, or give fewer"});
  const Ended alone = palpa({"run", "two.toml", "--hand", "sim:press", "--duration-s", "0.05", "--set", "only_hand=right"});
  EXPECT_EQ(alone.code, 0) << alone.err;
}

}  // namespace hands_command_test
}  // namespace palpa
