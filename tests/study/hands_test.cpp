// Runs of several hands: each feels as if it were alone, and is recorded and replayed by itself.
#include <gmock/gmock.h>

#include <tuple>

#include "palpa/study/run.h"
#include "study_fixture.h"

namespace palpa {
namespace study_hands_test {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

class Hands : public StudyTest {
 protected:
  Hands() {
    write("two.toml", std::string(phantom_scene) +
                          "[[hand]]\nname = \"thumb\"\nat_m = [-0.02, 0, 0]\n[hand.tool]\nshape = \"ball\"\nradius_m = 0.006\n"
                          "points = 12\n[[hand]]\nname = \"finger\"\nat_m = [0.02, 0.01, 0]\n");
  }
  RunOptions two(const std::string& trace, double duration_s = 1.0) const {
    RunOptions o = options(trace, duration_s);
    o.scene = folder / "two.toml";
    o.primitives = true;
    return o;
  }
  static std::string error_of(const RunOptions& o, const std::vector<std::string>& hands,
                              const std::vector<std::string>& devices = {}) {
    try {
      prepare_hands(o, hands, devices);
    } catch (const LoadError& error) {
      return error.what();
    }
    return "no error";
  }
};

TEST_F(Hands, AreRecordedAndReplayedToTheBit) {
  const RunOptions o = two("both");
  PreparedHands prepared = prepare_hands(o, {"sim:press,tilt_rad=0.2", "sim:stroke"}, {});
  EXPECT_THAT(prepared.names, ElementsAre("thumb", "finger"));
  const std::vector<RunResult> results = run_hands(std::move(prepared));
  ASSERT_EQ(results.size(), 2u);
  EXPECT_THAT(traces_in(o.out), ElementsAre(o.out / "finger", o.out / "thumb"));
  for (const fs::path& trace : traces_in(o.out)) {
    const ReplayResult again = replay(trace);
    EXPECT_TRUE(again.difference.same) << trace << ": " << again.difference.where;
    EXPECT_EQ(again.difference.ticks, 1000);
  }
  for (const RunResult& result : results) EXPECT_GT(result.summary.contact_share, 0.1);
  EXPECT_THAT(traces_in(o.out / "thumb"), ElementsAre(o.out / "thumb"));
  EXPECT_THAT(traces_in(folder / "none"), ElementsAre(folder / "none"));
}

// Data do not answer, so that one hand does not feel another.
TEST_F(Hands, FeelWhatEachFeelsAlone) {
  RunOptions o = two("both");
  run_hands(prepare_hands(o, {"sim:press", "sim:random,seed=2"}, {"touch", "omega"}));
  const std::vector<std::tuple<const char*, const char*, const char*>> all{{"thumb", "sim:press", "touch"},
                                                                           {"finger", "sim:random,seed=2", "omega"}};
  for (const auto& [name, hand, device] : all) {
    RunOptions alone = two(std::string("only_") + name);
    alone.hand = hand;
    alone.device = device;
    alone.scene_options.sets = {{"only_hand", name}};
    run(alone);
    EXPECT_EQ(reproducible_files(alone.out), reproducible_files(o.out / name)) << name;
  }
}

TEST_F(Hands, AreGivenInOrderOrByName) {
  const RunOptions o = two("");
  const auto hands_of = [](const PreparedHands& prepared) {
    return std::vector<std::string>{prepared.options[0].hand, prepared.options[1].hand};
  };
  EXPECT_THAT(hands_of(prepare_hands(o, {"finger=sim:press", "thumb=sim:stroke"}, {})), ElementsAre("sim:stroke", "sim:press"));
  EXPECT_THAT(hands_of(prepare_hands(o, {"thumb=sim:press", "sim:stroke"}, {})), ElementsAre("sim:press", "sim:stroke"));
  EXPECT_THAT(hands_of(prepare_hands(o, {"finger=sim:press", "sim:stroke"}, {"finger=touch"})),
              ElementsAre("sim:stroke", "sim:press"));
}

TEST_F(Hands, OfAnotherNumberAreRefusedInALine) {
  const RunOptions o = two("");
  EXPECT_THAT(error_of(o, {"sim:press"}),
              HasSubstr("two.toml: the scene has 2 hands (thumb, finger), and 1 is given; give each a --hand or --device, in "
                        "this order or as NAME=…, or feel one: --set only_hand=thumb"));
  EXPECT_THAT(error_of(o, {"sim:press", "sim:press", "sim:press"}),
              HasSubstr("the scene has 2 hands (thumb, finger), and 3 --hand are given; "));
  EXPECT_THAT(error_of(o, {"thumb=sim:press", "thumb=sim:stroke"}), StartsWith("run: --hand is given twice for hand thumb; "));
  RunOptions one = options("");
  EXPECT_THAT(error_of(one, {"sim:press", "sim:stroke"}),
              HasSubstr("the scene has one hand, and 2 --hand are given; add a [[hand]]"));
  RunOptions alone = two("");
  EXPECT_THROW(prepare(alone), LoadError) << "one hand of two";
  alone.scene_options.sets = {{"only_hand", "finger"}};
  EXPECT_NO_THROW(prepare(alone));
}

TEST_F(Hands, ShareALoopInRealTime) {
  RunOptions o = two("live", 0.3);
  o.live.emplace();
  const std::vector<RunResult> results = run_hands(prepare_hands(o, {"sim:press", "sim:stroke"}, {}));
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0].summary.ticks, results[1].summary.ticks);
  for (const char* name : {"thumb", "finger"}) {
    const ReplayResult again = replay(o.out / name);
    EXPECT_TRUE(again.difference.same) << name << ": " << again.difference.where;
  }
}

}  // namespace study_hands_test
}  // namespace palpa
