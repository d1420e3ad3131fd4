// [[hand]] of a scene: several hands, each with a tool, and the scene of one of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "palpa/mode/modes.h"
#include "tests/scene/ball_scene.h"

namespace palpa {
namespace hands_test {

using namespace test::ball_scene;
using test::error_of;
using test::parse;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsSupersetOf;
using testing::Not;
using testing::StartsWith;

using Shape = ToolOptions::Shape;

/// A ball of a thumb, and a finger that is a point.
const std::string two_hands = header(
    "[[hand]]\nname = 'thumb'\nat_m = [-0.03, 0, 0]\n[hand.tool]\nshape = 'ball'\nradius_m = 0.01\n"
    "[[hand]]\nname = 'finger'\nat_m = [0.05, 0.01, -0.02]\n");
const ToolOptions ball_tool{.shape = Shape::ball, .radius_m = 0.01};

TEST(HandsOfAScene, AreNoneWithoutTables) {
  const Scene scene = parse(ball).scene;
  EXPECT_TRUE(scene.hands().empty());
  EXPECT_EQ(to_toml(scene.of_hand(0)), to_toml(scene));
  EXPECT_THAT(to_toml(scene), Not(HasSubstr("hand")));
  EXPECT_THROW(static_cast<void>(scene.of_hand("thumb")), SceneError);
}

TEST(HandsOfAScene, HaveAToolAndAPlaceEach) {
  const Scene scene = parse(two_hands).scene;
  EXPECT_THAT(scene.hands(),
              ElementsAre(SceneHand{"thumb", {-0.03, 0, 0}, ball_tool}, SceneHand{"finger", {0.05, 0.01, -0.02}, {}}));
  EXPECT_EQ(scene.tool(), ball_tool) << "of the first";
}

// The scene of a hand is one with its tool alone, whose hand frame begins at its place: a session needs to know no more.
TEST(HandsOfAScene, FeelScenesOfTheirOwn) {
  const Scene scene = parse(two_hands).scene;
  const Similarity whole = parse(ball).scene.hand_to_world();
  for (std::size_t i = 0; i < 2; ++i) {
    const SceneHand& hand = scene.hands()[i];
    const Scene one = scene.of_hand(i);
    EXPECT_THAT(one.hands(), ElementsAre(hand));
    EXPECT_EQ(one.tool(), hand.tool);
    EXPECT_TRUE(one == scene.of_hand(hand.name));
    for (const Vec3& at_m : {Vec3{}, Vec3{0.01, -0.02, 0.03}})
      EXPECT_LT(distance(one.hand_to_world().to_world(at_m), whole.to_world(at_m + hand.at_m)), 1e-15);
  }
  EXPECT_EQ(scene.hand_to_world(), scene.of_hand(0).hand_to_world());
  Scene changed = scene;
  changed.edit<ToolOptions>([](ToolOptions& tool) { tool.radius_m = 0.02; });
  EXPECT_EQ(changed.hands()[0].tool.radius_m, 0.02);
  EXPECT_EQ(changed.hands()[1], scene.hands()[1]);
  changed = scene;
  changed.set(ball_tool, 1);
  EXPECT_EQ(changed.tool(), scene.tool()) << "the first one's is another";
  EXPECT_EQ(changed.tool_of(1), ball_tool);
  EXPECT_EQ(changed.of_hand(1).tool(), ball_tool);
  EXPECT_THROW(changed.set(ToolOptions{.shape = Shape::rod}, 1), SceneError);
  EXPECT_EQ(changed.tool_of(1), ball_tool) << "nothing changed";
  try {
    static_cast<void>(scene.of_hand("fingr"));
    FAIL();
  } catch (const SceneError& error) {
    EXPECT_STREQ(error.what(), "scene: no hand 'fingr'; did you mean 'finger'?");
  }
}

TEST(HandsOfAScene, AreReadBack) {
  const Scene scene = parse(two_hands).scene;
  const std::string printed = to_toml(scene);
  EXPECT_TRUE(parse(printed).scene == scene) << printed;
  EXPECT_EQ(to_toml(parse(printed).scene), printed);
  EXPECT_TRUE(parse(to_toml(scene.of_hand(1))).scene == scene.of_hand(1));
}

TEST(HandsOfAScene, CanBeSetFromOutside) {
  const Scene wider = parse(two_hands, set("hand.thumb.tool.radius_m", "0.02")).scene;
  EXPECT_EQ(wider.hands()[0].tool.radius_m, 0.02);
  SceneOptions options;
  options.sets = {{"hand.finger.tool.shape", "pad"}, {"hand.finger.tool.radius_m", "0.01"}, {"hand.finger.at_m", "[0, 0, 0]"}};
  EXPECT_EQ(parse(two_hands, options).scene.hands()[1], (SceneHand{"finger", {}, {.shape = Shape::pad, .radius_m = 0.01}}));
  options.sets.emplace_back("only_hand", "finger");
  const Scene one = parse(two_hands, options).scene;
  EXPECT_THAT(one.hands(), ElementsAre(SceneHand{"finger", {}, {.shape = Shape::pad, .radius_m = 0.01}}));
  EXPECT_TRUE(parse(two_hands, set("only_hand", "finger")).scene == parse(two_hands).scene.of_hand("finger"));
  EXPECT_THAT(set_paths(two_hands, standard_modes()),
              IsSupersetOf({"hand.thumb.at_m", "hand.thumb.tool.shape=rod", "hand.finger.tool.points_m", "only_hand=finger"}));
}

TEST(HandsOfAScene, ErrorsNameKeyAndLine) {
  const auto hand = [](const std::string& keys) { return header("[[hand]]\n" + keys + "\n"); };
  std::string nine;
  for (int i = 0; i < 9; ++i) nine += "[[hand]]\nname = 'h" + std::to_string(i) + "'\n";
  expect_refused(
      {Wrong{"no tables", header("hand = 3\n"), "s.toml:2:8: 'hand' in the scene is a number; it must be a list of tables"},
       Wrong{"no name", hand("at_m = [0, 0, 0]"), "s.toml:2:1: no key 'name' in hand 1; it is needed: "},
       Wrong{"a name of two words", hand("name = 'my hand'"), "s.toml:3:8: "},
       Wrong{"a name again", hand("name = 'a'\n[[hand]]\nname = 'a'"), "s.toml:5:8: "},
       Wrong{"unknown key", hand("name = 'a'\nat_mm = [0, 0, 0]"),
             "s.toml:4:1: unknown key 'at_mm' in hand 'a'; did you mean 'at_m'?"},
       Wrong{"a place of two", hand("name = 'a'\nat_m = [0, 0]"), "s.toml:4:8: 'at_m' in hand 'a' is a list of another kind;"},
       Wrong{"a place in millimetres", hand("name = 'a'\nat_m = [0, -30, 0]"),
             "s.toml:4:8: 'at_m' in hand 'a' is not within 1 m; it is in metres of the hand"},
       Wrong{"a tool's unknown key", hand("name = 'a'\n[hand.tool]\nlenght_m = 0.1"),
             "s.toml:5:1: unknown key 'lenght_m' in 'tool' of hand 'a'; did you mean 'length_m'?"},
       Wrong{"a rod without length", hand("name = 'b'\n[[hand]]\nname = 'a'\n[hand.tool]\nshape = 'rod'"),
             "s.toml:6:1: 'length_m' in 'tool' of hand 'a' does not fit a tool of the shape 'rod'; length_m of a rod must be"},
       Wrong{"a length of a ball", hand("name = 'a'\n[hand.tool]\nshape = 'ball'\nradius_m = 0.1\nlength_m = 0.1"),
             "s.toml:7:12: 'length_m' in 'tool' of hand 'a' does not fit a tool of the shape 'ball'; "},
       Wrong{"a tool besides", header("[tool]\nshape = 'point'\n[[hand]]\nname = 'a'\n"),
             "s.toml:2:1: 'tool' stands beside [[hand]] in the scene; give each hand its own, [hand.tool]"},
       Wrong{"nine", header(nine), "s.toml:2:1: 'hand' in the scene has more than 8 hands; "},
       Wrong{"only one of none", header("only_hand = 'a'\n"),
             "s.toml:2:13: 'only_hand' in the scene has no [[hand]] to choose"},
       Wrong{"only another", header("only_hand = 'b'\n[[hand]]\nname = 'a'\n"), "s.toml:2:13: no hand 'b'; "}});
  EXPECT_THAT(error_of(two_hands, set("hand.thmb.tool.radius_m", "1")),
              StartsWith("--set hand.thmb.tool.radius_m: no hand 'thmb'; did you mean 'thumb'?"));
  EXPECT_THAT(error_of(two_hands, set("tool.radius_m", "0.02")),
              HasSubstr("'tool' stands beside [[hand]] in the scene; give each hand its own, [hand.tool]"));
}

TEST(HandsOfAScene, FromCodeAreCheckedAlike) {
  Scene scene;
  const auto error = [&](const SceneHand& hand) -> std::string {
    try {
      scene.add_hand(hand);
    } catch (const SceneError& refusal) {
      return refusal.what();
    }
    return "no error";
  };
  EXPECT_THAT(error({.name = ""}), StartsWith("scene: "));
  EXPECT_THAT(error({"a", {0, std::numeric_limits<double>::quiet_NaN(), 0}, {}}),
              StartsWith("scene: 'at_m' in hand 'a' is not"));
  EXPECT_THAT(error({"a", {}, {.shape = Shape::rod}}), HasSubstr("length_m of a rod must be above 0"));
  EXPECT_TRUE(scene.hands().empty()) << "nothing changed";
  for (int i = 0; i < 8; ++i) EXPECT_EQ(error({.name = "h" + std::to_string(i)}), "no error");
  EXPECT_THAT(error({.name = "h0"}), HasSubstr("more than 8 hands"));
}

TEST(HandsOfAScene, AreWarnedOfByThePlaceOfTheirTool) {
  const std::string text = header("[[hand]]\nname = 'a'\n[[hand]]\nname = 'b'\n[hand.tool]\nshape = 'rod'\nlength_m = 0.2\n");
  EXPECT_THAT(parse(text).warnings, ElementsAre(StartsWith("s.toml:6:1: the tool is longer than the data: ")));
  EXPECT_THAT(parse(text, set("only_hand", "b")).warnings, ElementsAre(StartsWith("s.toml:6:1: the tool is longer")));
  EXPECT_THAT(parse(text, set("only_hand", "a")).warnings, ElementsAre());
}

}  // namespace hands_test
}  // namespace palpa
