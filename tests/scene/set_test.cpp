// --set: one value of a scene, given beside its file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "palpa/mode/modes.h"
#include "tests/scene/ball_scene.h"

namespace palpa {
namespace set_test {

using namespace test::ball_scene;
using test::error_of;
using test::parse;
using testing::HasSubstr;
using testing::StartsWith;

TEST(Set, ReachesEveryPath) {
  EXPECT_EQ(parse(ball, set("coupling.stiffness_n_per_m", "300")).scene.coupling().stiffness_n_per_m, 300);
  EXPECT_EQ(parse(ball, set("law.method", "exact")).scene.law(), "exact");
  EXPECT_EQ(parse(ball, set("workspace.scale", "2.5")).scene.workspace().scale, 2.5);
  EXPECT_EQ(parse(ball, set("workspace.up", "+x")).scene.workspace().up, "+x");
  EXPECT_EQ(parse(ball, set("workspace.center", "[1, 2, 3]")).scene.workspace().center_m, (Vec3{1, 2, 3}));
  EXPECT_EQ(parse(ball, set("volume.ball.sampled", "16")).scene.volumes()[0].volume.format, "grid");
  EXPECT_FALSE(parse(ball, set("mode.skin.enabled", "false")).scene.modes()[0].enabled);
  const auto level = [](const LoadedScene& loaded) { return loaded.scene.modes()[0].mode.as<SurfaceAndFriction>()->levels[0]; };
  EXPECT_EQ(level(parse(ball, set("mode.skin.level.outside.strength_n", "0.25"))).strength_n.constant_n, 0.25);
  EXPECT_EQ(level(parse(ball, set("mode.skin.level.outside.value", "-0.01"))).value, -0.01);
  EXPECT_EQ(
      level(parse(ball, set("mode.skin.level.outside.strength_n", "{of = 'ball', points = [[0, 1]]}"))).strength_n.of.name,
      "ball");
}

TEST(Set, TheLastOneHolds) {
  SceneOptions options;
  options.sets = {{"coupling.max_force_n", "1"}, {"coupling.max_force_n", "2"}};
  EXPECT_EQ(parse(header("[coupling]\nmax_force_n = 3\n"), options).scene.coupling().max_force_n, 2);
}

TEST(Set, IsTheSameAsEditingTheFile) {
  const std::string edited = std::string(ball).replace(std::string(ball).find("0.8"), 3, "1.5");
  EXPECT_EQ(to_toml(parse(ball, set("mode.skin.level.outside.strength_n", "1.5")).scene), to_toml(parse(edited).scene));
}

TEST(Set, ErrorsNameIt) {
  const auto error = [](const std::string& path, const std::string& value) { return error_of(ball, set(path, value)); };
  EXPECT_THAT(error("coupling.stiffness_n_per_m", "-1"),
              StartsWith("--set coupling.stiffness_n_per_m: 'stiffness_n_per_m' in [coupling] is -1; it must be"));
  EXPECT_THAT(error("coupling.stiffness_n_per_m", "1e9x"),
              StartsWith("--set coupling.stiffness_n_per_m: 'stiffness_n_per_m' in [coupling] is a text; it must be a number"));
  EXPECT_THAT(error("coupling.stiffness_n_per_m", "nan"), HasSubstr("not finite"));
  EXPECT_THAT(error("coupling.stiffness_n_per_m", "1\nmax_force_n = 2"), HasSubstr("is a text; it must be a number"));
  EXPECT_THAT(
      error("coupling.stifness_n_per_m", "1"),
      StartsWith(
          "--set coupling.stifness_n_per_m: unknown key 'stifness_n_per_m' in [coupling]; did you mean 'stiffness_n_per_m'?"));
  EXPECT_THAT(error("coupling.", "1"), StartsWith("--set coupling.: unknown key '' in [coupling]; "));
  EXPECT_THAT(error("law.method", "paper-2007"),
              StartsWith("--set law.method: 'method' in [law] cannot be 'paper-2007'; did you mean 'paper-2005'?"));
  EXPECT_THAT(error("volume.bal.sampled", "8"), StartsWith("--set volume.bal.sampled: no volume 'bal'; did you mean 'ball'?"));
  EXPECT_THAT(error("mode.skim.enabled", "true"), StartsWith("--set mode.skim.enabled: no mode 'skim'; did you mean 'skin'?"));
  EXPECT_THAT(error("mode.skin.level.inside.value", "1"),
              StartsWith("--set mode.skin.level.inside.value: no level 'inside'; "));
  EXPECT_THAT(error("mode.skin.field", "ballet"),
              StartsWith("--set mode.skin.field: no volume 'ballet'; did you mean 'ball'?"));
  EXPECT_THAT(error("workspace.towards_user", "+y"),
              StartsWith("--set workspace.towards_user: 'up' and 'towards_user' lie along one axis;"));
  for (const char* path : {"", "coupling", "title", "coupling.a.b", "law.name", "volume.ball", "mode.skin",
                           "mode.skin.level.outside", "mode.skin.level.outside.a.b"}) {
    EXPECT_THAT(error(path, "1"),
                HasSubstr(": no such path; there are: coupling.KEY, law.method, workspace.KEY, volume.NAME.KEY"))
        << path;
  }
  std::string deep = "{";
  for (int i = 0; i < 200000; ++i) deep += "a.";
  EXPECT_THAT(error("coupling.max_force_n", deep + "a = 1}"), HasSubstr("is a text; it must be a number"));
}

TEST(Set, WarningsNameIt) {
  const LoadedScene loaded = parse(ball, set("mode.skin.level.outside.value", "9"));
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_THAT(loaded.warnings[0],
              StartsWith("--set mode.skin.level.outside.value: 'value' in level 'outside' of mode 'skin' is 9, outside"));
}

}  // namespace set_test
}  // namespace palpa
