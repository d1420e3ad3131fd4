// [tool] of a scene: its keys, their faults, and which feet feel a mode.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "palpa/mode/modes.h"
#include "tests/scene/ball_scene.h"

namespace palpa {
namespace tool_test {

using namespace test::ball_scene;
using test::error_of;
using test::parse;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

using Shape = ToolOptions::Shape;

ToolOptions tool_of(const std::string& keys) { return parse(header("[tool]\n" + keys + "\n")).scene.tool(); }

std::string points(std::size_t count) {
  std::string all;
  for (std::size_t i = 0; i < count; ++i)
    all += (i ? ", [0, 0, " : "[0, 0, ") + std::to_string(1e-4 * static_cast<double>(i)) + "]";
  return "[" + all + "]";
}

TEST(ToolOfAScene, IsAPointWithoutATable) {
  const Scene scene = parse(ball).scene;
  EXPECT_EQ(scene.tool(), ToolOptions{});
  EXPECT_THAT(to_toml(scene), Not(HasSubstr("[tool]")));
  EXPECT_THAT(to_toml(scene), Not(HasSubstr("torque"))) << "scenes without a tool are written as before";
  EXPECT_EQ(tool_of(""), ToolOptions{});
}

TEST(ToolOfAScene, HasTheFeetThatItsKeysSay) {
  EXPECT_EQ(tool_of("points_m = [[0, 0, 0], [0, 0.01, -0.02]]").shape, Shape::points) << "points need no word";
  EXPECT_THAT(tool_of("points_m = [[0, 0, 0], [0, 0.01, -0.02]]").points_m, ElementsAre(Vec3{}, Vec3{0, 0.01, -0.02}));
  EXPECT_EQ(tool_of("shape = 'points'\npoints_m = [[1, 0, 0]]"),
            (ToolOptions{.shape = Shape::points, .points_m = {{1, 0, 0}}}));
  EXPECT_EQ(tool_of("shape = 'rod'\nlength_m = 0.1\npoints = 12\ncentre_m = [0, 0, 0.05]"),
            (ToolOptions{.shape = Shape::rod, .length_m = 0.1, .points = 12, .centre_m = {0, 0, 0.05}}));
  EXPECT_EQ(tool_of("shape = 'rod'\nlength_m = 0.1\nradius_m = 0.005").radius_m, 0.005);
  EXPECT_EQ(tool_of("shape = 'pad'\nradius_m = 0.01\npoints = 64\nshare = 0.015625"),
            (ToolOptions{.shape = Shape::pad, .radius_m = 0.01, .points = 64, .share = 0.015625}));
  EXPECT_EQ(tool_of("shape = 'ball'\nradius_m = 0.01\nturning_radius_m = 0.02"),
            (ToolOptions{.shape = Shape::ball, .radius_m = 0.01, .turning_radius_m = 0.02}));
  EXPECT_EQ(tool_of("points_m = " + points(256)).points_m.size(), 256u);
  const CouplingOptions coupling =
      parse(header("[coupling]\nmax_torque_nm = 0.1\nturn_damping_nms_per_rad = 0.002\n")).scene.coupling();
  EXPECT_EQ(coupling.max_torque_nm, 0.1);
  EXPECT_EQ(coupling.turn_damping_nms_per_rad, 0.002);
}

TEST(ToolOfAScene, IsReadBack) {
  for (const char* keys :
       {"points_m = [[0, 0, 0], [0.1, -0.3333333333333333, 1e-17]]\nshare = 0.5", "shape = 'rod'\nlength_m = 0.15\npoints = 7",
        "shape = 'pad'\nradius_m = 0.3\ncentre_m = [0, 0.1, 0]", "shape = 'ball'\nradius_m = 0.1\nturning_radius_m = 0.07"}) {
    const Scene scene =
        parse(header(std::string("[coupling]\nmax_torque_nm = 0.25\nturn_damping_nms_per_rad = 0.001\n[tool]\n") + keys + "\n"))
            .scene;
    const std::string printed = to_toml(scene);
    const Scene again = parse(printed).scene;
    EXPECT_EQ(again.tool(), scene.tool()) << printed;
    EXPECT_EQ(again.coupling(), scene.coupling()) << printed;
    EXPECT_TRUE(again == scene);
    EXPECT_EQ(to_toml(again), printed);
    EXPECT_FALSE(parse(ball).scene == scene);
  }
  EXPECT_THAT(to_toml(parse(header("[tool]\nshape = 'pad'\nradius_m = 0.01\n")).scene),
              HasSubstr("[tool]\nshape = \"pad\"\nradius_m = 0.01\n\n"))
      << "the other keys are left out";
}

TEST(ToolOfAScene, CanBeSetFromOutside) {
  SceneOptions options;
  options.sets = {{"tool.shape", "rod"}, {"tool.length_m", "0.1"}, {"tool.points", "5"}};
  EXPECT_EQ(parse(ball, options).scene.tool(), (ToolOptions{.shape = Shape::rod, .length_m = 0.1, .points = 5}));
  EXPECT_EQ(parse(ball, set("tool.points_m", "[[0, 0, 0.1]]")).scene.tool().points_m.size(), 1u);
  EXPECT_EQ(parse(ball, set("coupling.max_torque_nm", "2")).scene.coupling().max_torque_nm, 2.0);
  EXPECT_THAT(error_of(ball, set("tool.lenght_m", "0.1")),
              StartsWith("--set tool.lenght_m: unknown key 'lenght_m' in [tool]; did you mean 'length_m'?"));
  EXPECT_THAT(error_of(ball, set("tool.length_m", "0.1")),
              StartsWith("--set tool.length_m: 'length_m' in [tool] does not fit a tool of the shape 'point'; "));
  EXPECT_EQ(parse(ball, set("mode.skin.feet", "first")).scene.modes()[0].feet, SceneMode::Feet::first);
  EXPECT_THAT(set_paths(ball, standard_modes()),
              testing::IsSupersetOf({"tool.shape=rod", "tool.points_m", "tool.centre_m", "mode.skin.feet=first"}));
}

TEST(ToolOfAScene, ErrorsNameKeyAndLine) {
  const auto tool = [](const std::string& keys) { return header("[tool]\n" + keys + "\n"); };
  expect_refused(
      {Wrong{"no table", header("tool = 3\n"), "s.toml:2:8: 'tool' in the scene is a number; it must be a table"},
       Wrong{"unknown key", tool("lenght_m = 0.1"), "s.toml:3:1: unknown key 'lenght_m' in [tool]; did you mean 'length_m'?"},
       Wrong{"American", tool("center_m = [0, 0, 0]"),
             "s.toml:3:1: unknown key 'center_m' in [tool]; did you mean 'centre_m'?"},
       Wrong{"unknown shape", tool("shape = 'rood'"), "s.toml:3:9: 'shape' in [tool] cannot be 'rood'; did you mean 'rod'?"},
       Wrong{"shape a number", tool("shape = 3"), "s.toml:3:9: 'shape' in [tool] is a number; it must be a text"},
       Wrong{"points no list", tool("points_m = 3"), "s.toml:3:12: 'points_m' in [tool] is a number; it must be a list of [x"},
       Wrong{"points of numbers", tool("points_m = [1, 2, 3]"),
             "s.toml:3:13: 'points_m' in [tool] holds a number that is no position; it must be [x, y, z], all finite"},
       Wrong{"points of two", tool("points_m = [[0, 0, 0],\n[1, 2]]"), "s.toml:4:1: 'points_m' in [tool] holds a list that is"},
       Wrong{"points not finite", tool("points_m = [[0, 0, nan]]"),
             "s.toml:3:13: 'points_m' in [tool] holds a list that is no"},
       Wrong{"points infinite", tool("points_m = [[0, inf, 0]]"), "s.toml:3:13: 'points_m' in [tool] holds a list that is no"},
       Wrong{"no points", tool("points_m = []"), "s.toml:3:12: 'points_m' in [tool] is empty; it must be a list of [x, y, z]"},
       Wrong{"257 points", tool("points_m = " + points(257)),
             "s.toml:3:12: 'points_m' in [tool] has more than 256 points; leave out"},
       Wrong{"points in millimetres", tool("points_m = [[0, 0, 50]]"),
             "s.toml:3:12: 'points_m' in [tool] does not fit a tool of the shape 'points'; points_m must be finite and within"},
       Wrong{"points with a shape", tool("shape = 'ball'\nradius_m = 0.1\npoints_m = [[0, 0, 0]]"),
             "s.toml:5:12: 'points_m' in [tool] does not fit a tool of the shape 'ball'; points_m needs no shape"},
       Wrong{"points of a point", tool("shape = 'point'\npoints_m = [[0, 0, 0]]"),
             "s.toml:4:12: 'points_m' in [tool] does not fit a tool of the shape 'point'; "},
       Wrong{"a rod without length", tool("shape = 'rod'"),
             "s.toml:2:1: 'length_m' in [tool] does not fit a tool of the shape 'rod'; length_m of a rod must be above 0"},
       Wrong{"length of a ball", tool("shape = 'ball'\nradius_m = 0.1\nlength_m = 0.1"),
             "s.toml:5:12: 'length_m' in [tool] does not fit a tool of the shape 'ball'; length_m is of a rod"},
       Wrong{"length in millimetres", tool("shape = 'rod'\nlength_m = 100"),
             "s.toml:4:12: 'length_m' in [tool] is 100; it must be between 0 and 1"},
       Wrong{"length not a number", tool("shape = 'rod'\nlength_m = nan"), "s.toml:4:12: 'length_m' in [tool] is not finite;"},
       Wrong{"a pad without radius", tool("shape = 'pad'"),
             "s.toml:2:1: 'radius_m' in [tool] does not fit a tool of the shape"},
       Wrong{"radius negative", tool("shape = 'pad'\nradius_m = -0.1"),
             "s.toml:4:12: 'radius_m' in [tool] is -0.1; it must be"},
       Wrong{"radius of points", tool("points_m = [[0, 0, 0]]\nradius_m = 0.1"),
             "s.toml:4:12: 'radius_m' in [tool] does not fit a tool of the shape 'points'; radius_m is of a rod, pad or ball"},
       Wrong{"257 feet", tool("shape = 'pad'\nradius_m = 0.1\npoints = 257"),
             "s.toml:5:10: 'points' in [tool] is 257; it must be between 1 and 256"},
       Wrong{"no feet", tool("shape = 'pad'\nradius_m = 0.1\npoints = 0"), "s.toml:5:10: 'points' in [tool] is 0; it must be"},
       Wrong{"feet and a half", tool("shape = 'pad'\nradius_m = 0.1\npoints = 1.5"),
             "s.toml:5:10: 'points' in [tool] is a number; it must be a whole number"},
       Wrong{"no share", tool("share = 0"), "s.toml:3:9: 'share' in [tool] is 0; it must be above 0 and at most 1"},
       Wrong{"share above 1", tool("share = 1.5"), "s.toml:3:9: 'share' in [tool] is 1.5; it must be above 0 and at most 1"},
       Wrong{"centre of two", tool("centre_m = [0, 0]"),
             "s.toml:3:12: 'centre_m' in [tool] is a list of another kind; it must"},
       Wrong{"centre far away", tool("centre_m = [0, 0, 5]"), "s.toml:3:12: 'centre_m' in [tool] does not fit a tool"},
       Wrong{"no turning radius", tool("turning_radius_m = 0"), "s.toml:3:20: 'turning_radius_m' in [tool] is 0; it must be"},
       Wrong{"torque negative", header("[coupling]\nmax_torque_nm = -1\n"),
             "s.toml:3:17: 'max_torque_nm' in [coupling] is -1; it must be above 0 and at most 10"},
       Wrong{"turn damping", header("[coupling]\nturn_damping_nms_per_rad = 2\n"),
             "s.toml:3:28: 'turn_damping_nms_per_rad' in [coupling] is 2; it must be between 0 and 1"},
       Wrong{"feet of a mode", mode("name = 'm'\ntype = 'viscosity'\nstrength_n = 1\nfeet = 'last'"),
             "s.toml:8:8: 'feet' in mode 'm' cannot be 'last'; there are: all, first"}});
}

TEST(ToolOfAScene, FromCodeIsCheckedAlike) {
  Scene scene;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto error = [&](const ToolOptions& tool) -> std::string {
    try {
      scene.set(tool);
    } catch (const SceneError& refusal) {
      EXPECT_EQ(scene.tool(), ToolOptions{}) << "nothing changed";
      return refusal.what();
    }
    return "no error";
  };
  EXPECT_THAT(error({.shape = Shape::points, .points_m = {{0, nan, 0}}}), StartsWith("scene: 'points_m' is not finite; "));
  EXPECT_THAT(error({.shape = Shape::points, .points_m = std::vector<Vec3>(257)}),
              StartsWith("scene: 'points_m' has more than 256 points; "));
  EXPECT_THAT(error({.shape = Shape::points}), HasSubstr("points_m needs at least one point"));
  EXPECT_THAT(error({.points_m = {{}}}), HasSubstr("points_m needs no shape"));
  EXPECT_THAT(error({.shape = Shape::rod, .length_m = nan}),
              StartsWith("scene: 'length_m' is nan; it must be between 0 and 1"));
  EXPECT_THAT(error({.shape = Shape::rod, .length_m = 0.1, .points = 0}), HasSubstr("points must be between 1 and 256"));
  EXPECT_THAT(error({.share = nan}), StartsWith("scene: 'share' is nan; it must be above 0 and at most 1"));
  EXPECT_THAT(error({.centre_m = {nan, 0, 0}}), StartsWith("scene: 'centre_m' is not finite"));
  EXPECT_THAT(error({.turning_radius_m = nan}), StartsWith("scene: 'turning_radius_m' is nan; "));
  EXPECT_EQ(error({.shape = Shape::points, .points_m = std::vector<Vec3>(256)}), "no error");
}

TEST(ToolOfAScene, WarnsOfWhatTipsOverAndOfWhatIsTooLarge) {
  const auto warnings = [](const std::string& keys) {
    return parse(header("[coupling]\nstiffness_n_per_m = 500\nmax_force_n = 3\n[tool]\n" + keys + "\n")).warnings;
  };
  EXPECT_THAT(warnings("shape = 'rod'\nlength_m = 0.1"), IsEmpty()) << "the default never tips over";
  EXPECT_THAT(warnings("points_m = [[0, 0, -0.05]]"), IsEmpty());
  // 500 ρ² against 2 · 3 N · 0.05 m.
  EXPECT_THAT(warnings("points_m = [[0, 0, -0.05]]\nturning_radius_m = 0.0245"), IsEmpty());
  EXPECT_THAT(
      warnings("points_m = [[0, 0, -0.05]]\nturning_radius_m = 0.0244"),
      ElementsAre(StartsWith("s.toml:7:20: 'turning_radius_m' is 0.0244: the tool can tip over when it is pressed; from "
                             "0.0245 on it cannot")));
  EXPECT_THAT(warnings("shape = 'rod'\nlength_m = 0.2"),
              ElementsAre(StartsWith("s.toml:5:1: the tool is longer than the data: ")));
  EXPECT_THAT(parse(header("[tool]\nshape = 'rod'\nlength_m = 0.2\n")).scene.check(),
              Contains(StartsWith("the tool is longer than the data: ")));
}

TEST(Feet, ThatFeelAModeAreAllOnLevelsAndElseTheFirst) {
  const Scene scene = parse(with("[[mode]]\nname = 'thick'\ntype = 'viscosity'\nstrength_n = 1\n"
                                 "[[mode]]\nname = 'both'\ntype = 'viscosity'\nfeet = 'all'\nstrength_n = 1\n"
                                 "[[mode]]\nname = 'tip'\ntype = 'surface_and_friction'\nfield = 'ball'\nfeet = 'first'\n"
                                 "[[mode.level]]\nvalue = 0\nstrength_n = 1\n"))
                          .scene;
  const auto feet = [&](const char* name) {
    const SceneMode& mode = *scene.find_mode(name);
    return std::vector<bool>{mode.acts_at(0), mode.acts_at(1), mode.acts_at(255)};
  };
  EXPECT_EQ(feet("skin"), (std::vector<bool>{true, true, true}));
  EXPECT_EQ(feet("thick"), (std::vector<bool>{true, false, false}));
  EXPECT_EQ(feet("both"), (std::vector<bool>{true, true, true}));
  EXPECT_EQ(feet("tip"), (std::vector<bool>{true, false, false}));
  EXPECT_TRUE(parse(to_toml(scene)).scene == scene);
  EXPECT_EQ(parse(to_toml(scene)).scene.find_mode("tip")->feet, SceneMode::Feet::first);
  EXPECT_EQ(parse(to_toml(scene)).scene.find_mode("skin")->feet, std::nullopt);
  for (const Mode& mode : standard_modes().modes()) {
    EXPECT_EQ(mode.has_levels(), mode.type() == "surface_and_friction") << mode.type();
    EXPECT_EQ(Mode(mode).has_levels(), mode.has_levels());
  }
}

}  // namespace tool_test
}  // namespace palpa
