// A written scene reads back as an equal scene.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "tests/scene/ball_scene.h"

namespace palpa {
namespace to_toml_test {

using namespace test::ball_scene;
using test::parse;

TEST(ToToml, IsReadBackAsTheSameScene) {
  const Folder folder;
  folder.file("two.vti");
  const std::string texts[] = {
      ball,
      header("title = \"a \\\"ball\\\" \\\\ \\u0001 é\"\nneeds = ['follow']\n[coupling]\nstiffness_n_per_m = "
             "333.3333333333333\nmax_force_n = 1e-7\n"
             "[workspace]\nscale = 1e22\ncenter = [0.1, -0.0, 1e18]\nup = '-x'\n"),
      "palpa = 1\n[volume.z]\nfile = 'two.vti'\nlength_unit = 'mm'\nfields = {a = {array = 'x \"y\"', unit = 'm'}}\n"
      "pose = {translate_m = [0.1, 0.2, 0.3], rotate_axis_deg = [1, 2, 3, 33.3], scale = 0.7}\n"
      "[volume.a]\nanalytic = 'plane'\nsampled = 8\n"
      "[[mode]]\nname = 'rail'\ntype = 'follow'\nfield = 'z.velocity'\nstrength_n = {of = 'z.density', points = [[-0.1, 0], "
      "[0.1, 3], [0.1, 2]], outside = 0.1}\n"
      "mask = [{of = 'a', points = [[0, 1]]}, {of = 'a', points = [[0, 0.5]], outside = 1}]\n"
      "[[mode]]\nname = 'thick'\ntype = 'viscosity'\nenabled = false\ndrag_ns_per_m = 3.3\n"
      "[[mode]]\nname = 'skin'\ntype = 'surface_and_friction'\nfield = 'a'\nsolid = 'low'\n"
      "[[mode.level]]\nname = 'p'\nvalue = -0.05\nfriction_n = 0.2\n[[mode.level]]\nvalue = 1e-17\nstrength_n = {of = 'a', "
      "points = [[0, 1]]}\n"};
  for (const std::string& text : texts) {
    const Scene scene = parse(text, {}, folder.path).scene;
    const std::string printed = to_toml(scene);
    const Scene again = parse(printed, {}, folder.path).scene;
    EXPECT_EQ(to_toml(again), printed);
    EXPECT_TRUE(again == scene) << printed;
  }
}

TEST(ToToml, DiffersWhereScenesDiffer) {
  const Scene scene = parse(ball).scene;
  const std::pair<const char*, const char*> changes[] = {
      {"coupling.max_force_n", "1"},         {"workspace.scale", "1"},          {"volume.ball.analytic", "plane"},
      {"volume.ball.sampled", "9"},          {"mode.skin.enabled", "false"},    {"mode.skin.level.outside.value", "0.001"},
      {"mode.skin.friction_n", "0.125"},     {"coupling.impact_ns_per_m", "5"}, {"mode.skin.static_friction_ratio", "1.5"},
      {"mode.skin.friction_ns_per_m", "0.5"}};
  for (const auto& [path, value] : changes) EXPECT_FALSE(parse(ball, set(path, value)).scene == scene) << path;
}

TEST(ToToml, ReadsNumbersBackExactly) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 300; ++i) {
    const std::uint64_t bits = random();
    double value;
    std::memcpy(&value, &bits, sizeof value);
    if (!std::isfinite(value)) continue;
    Scene scene = parse(ball).scene;
    scene.edit<Workspace>([&](auto& workspace) { workspace.center_m = Vec3{value, -value, std::round(value)}; });
    const Scene again = parse(to_toml(scene)).scene;
    EXPECT_EQ(again.workspace().center_m, scene.workspace().center_m) << value;
  }
}

}  // namespace to_toml_test
}  // namespace palpa
