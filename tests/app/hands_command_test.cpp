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
