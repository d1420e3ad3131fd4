#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <random>

#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "scene_files.h"

namespace palpa {
namespace load_scene_test {

using test::error_of;
using test::parse;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

/// A whole scene: line 1 is the format, the mode's table starts at line 4.
constexpr const char* ball = R"(palpa = 1
[volume.ball]
analytic = "sphere"
[[mode]]
name = "skin"
type = "surface_and_friction"
field = "ball"
[[mode.level]]
name = "outside"
value = 0
strength_n = 0.8
)";

std::string with(const std::string& more) { return ball + more; }

/// A folder that is gone after the test.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "palpa-scene-XXXXXX").string();
    path = mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path); }
  std::filesystem::path file(const std::string& name, const std::string& text = "x") const {
    std::filesystem::create_directories((path / name).parent_path());
    std::ofstream(path / name) << text;
    return path / name;
  }
  std::filesystem::path path;
};

TEST(LoadScene, ReadsEveryPart) {
  const LoadedScene loaded = parse(R"toml(palpa = 1
title = "a ball"
needs = ["viscosity"]
[coupling]
stiffness_n_per_m = 800
damping_ns_per_m = 0.5
max_force_n = 4.5
[law]
method = "exact"
[workspace]
fit = "ball"
center = [0, 0.01, 0]
towards_user = "+y"
up = "+z"
[volume.ball]
analytic = "sphere"
sampled = 16
pose = {translate_m = [1, 2, 3], rotate_axis_deg = [0, 0, 2, 90], scale = 2}
[[mode]]
name = "skin"
type = "surface_and_friction"
enabled = false
field = "ball"
solid = "both"
friction_coefficient = 0.3
mask = [{of = "ball", points = [[-1, 0.5], [1, 1]], outside = 0.25}]
level = [{name = "a", value = -0.001, strength_n = {of = "ball", points = [[-1, 2], [1, 3]]}}, {value = 0.02, friction_n = 0.1}]
[[view.layer]]
show = "surface"
field = "ball"
level = 0
colors = {points = [[0, "#e8b899", 0.3]]}
)toml");
  const Scene& scene = loaded.scene;
  EXPECT_EQ(scene.title, "a ball");
  EXPECT_THAT(scene.needs, ElementsAre("viscosity"));
  EXPECT_EQ(scene.coupling, (CouplingOptions{800, 0.5, 4.5}));
  EXPECT_EQ(scene.workspace.center_m, (Vec3{0, 0.01, 0}));
  EXPECT_EQ(scene.workspace.up, "+z");
  ASSERT_EQ(scene.volumes().size(), 1u);
  EXPECT_EQ(scene.volumes()[0].pose, (Similarity{{{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}}, 2, {1, 2, 3}}));
  EXPECT_EQ(scene.volumes()[0].volume.bounds_m().centre_m(), (Vec3{1, 2, 3}));
  ASSERT_EQ(scene.modes().size(), 1u);
  const SceneMode& mode = scene.modes()[0];
  EXPECT_FALSE(mode.enabled);
  ASSERT_EQ(mode.masks.size(), 1u);
  EXPECT_EQ(mode.masks[0].curve, TransferFunction({{-1, 0.5}, {1, 1}}, 0.25));
  const auto* skin = mode.mode.as<SurfaceAndFriction>();
  ASSERT_NE(skin, nullptr);
  EXPECT_EQ(skin->solid, SurfaceAndFriction::Solid::both);
  EXPECT_EQ(skin->friction_coefficient, 0.3);
  ASSERT_EQ(skin->levels.size(), 2u);
  EXPECT_EQ(skin->levels[0].strength_n, Strength({"ball"}, TransferFunction({{-1, 2}, {1, 3}})));
  EXPECT_EQ(skin->levels[1].name, "");
  EXPECT_EQ(skin->levels[1].strength_n.constant_n, 1.0);
  EXPECT_EQ(skin->levels[1].friction_n, 0.1);
  EXPECT_THAT(loaded.warnings, ElementsAre());
}

TEST(LoadScene, LeavesDefaultsWhereNothingIsSaid) {
  const Scene scene = parse(ball).scene;
  EXPECT_EQ(scene.coupling, CouplingOptions{});
  EXPECT_EQ(scene.law, "exact");
  EXPECT_EQ(scene.workspace, Workspace{});
  EXPECT_TRUE(scene.modes()[0].enabled);
}

TEST(LoadScene, KeepsTheOrderOfTheFile) {
  const Scene scene = parse(R"(palpa = 1
[volume.zebra]
analytic = "sphere"
[volume.ant]
analytic = "plane"
[[mode]]
name = "m"
type = "viscosity"
strength_n = 1
)")
                          .scene;
  EXPECT_EQ(scene.volumes()[0].name, "zebra");
  EXPECT_EQ(scene.volumes()[1].name, "ant");
}

TEST(LoadScene, GivesTheTextBack) { EXPECT_EQ(parse(ball).text, ball); }

struct Wrong {
  const char* what;
  std::string text;
  const char* error;  ///< begins with
};

/// Each is refused in one line that begins as it should: with its place.
void expect_refused(const std::vector<Wrong>& scenes) {
  for (const Wrong& wrong : scenes) {
    const std::string error = error_of(wrong.text);
    EXPECT_THAT(error, StartsWith(wrong.error)) << wrong.what << ":\n" << wrong.text.substr(0, 2000);
    EXPECT_EQ(error.find('\n'), std::string::npos) << wrong.what;
    EXPECT_THAT(error, HasSubstr(";")) << wrong.what;
  }
}

std::string header(const std::string& more) { return "palpa = 1\n" + more + std::string(ball).substr(10); }
std::string volume(const std::string& body) {
  return "palpa = 1\n[volume.v]\n" + body + "\n[[mode]]\nname = \"m\"\ntype = \"viscosity\"\nstrength_n = 1\n";
}
std::string mode(const std::string& body) {
  return "palpa = 1\n[volume.ball]\nanalytic = \"sphere\"\n[[mode]]\n" + body + "\n";
}

TEST(WrongScene, Toml) {
  expect_refused({Wrong{"empty", "", "s.toml:1:1: no format; a scene begins with 'palpa = 1'"},
                  Wrong{"no format", "title = 'x'\n", "s.toml:1:1: no format;"},
                  Wrong{"another format", "palpa = 2\n", "s.toml:1:9: scene format 2 is not known;"},
                  Wrong{"format of another kind", "palpa = 'one'\n",
                        "s.toml:1:9: 'palpa' in the scene is a text; it must be a whole number"},
                  Wrong{"syntax", "palpa = 1\ntitle = \n", "s.toml:2:9: no valid TOML: "},
                  Wrong{"no TOML at all", std::string("\x89PNG\r\n\x1a\n\0\0", 10), "s.toml:1:1: no valid TOML: "},
                  Wrong{"key given twice", "palpa = 1\npalpa = 1\n", "s.toml:2:"},
                  Wrong{"key of many dots",
                        "palpa = 1\n" +
                            [] {
                              std::string k;
                              for (int i = 0; i < 200000; ++i) k += "a.";
                              return k;
                            }() +
                            "b = 1\n",
                        "s.toml:2:34: a key of more than 16 parts;"},
                  Wrong{"table of many dots",
                        "palpa = 1\n[" +
                            [] {
                              std::string k;
                              for (int i = 0; i < 200000; ++i) k += "'a' . ";
                              return k;
                            }() +
                            "b]\n",
                        "s.toml:2:"},
                  Wrong{"key of many dots behind a text that ends in a quote",
                        "palpa = 1\nv = {a = \"\"\"x\"\"\"\", " +
                            [] {
                              std::string k;
                              for (int i = 0; i < 200000; ++i) k += "a.";
                              return k;
                            }() +
                            "b = 1}\n",
                        "s.toml:2:53: a key of more than 16 parts;"},
                  Wrong{"list of many lists", "palpa = " + std::string(100000, '['), "s.toml:1:"},
                  Wrong{"too long", "palpa = 1 #" + std::string(5 << 20, 'x'), "s.toml: longer than 4 MiB;"}});
}

TEST(WrongScene, Header) {
  expect_refused(
      {Wrong{"unknown key", header("titel = 'x'\n"), "s.toml:2:1: unknown key 'titel' in the scene; did you mean 'title'?"},
       Wrong{"unknown table, far from all", header("[weather]\n"),
             "s.toml:2:2: unknown key 'weather' in the scene; there are: palpa, title, needs,"},
       Wrong{"title of another kind", header("title = 3\n"),
             "s.toml:2:9: 'title' in the scene is a number; it must be a text in quotes"},
       Wrong{"needs of another kind", header("needs = 'x'\n"),
             "s.toml:2:9: 'needs' in the scene is a text; it must be a list of texts"},
       Wrong{"needs holds a number", header("needs = ['viscosity', 3]\n"),
             "s.toml:2:23: 'needs' in the scene holds a number; it must be a list of texts"},
       Wrong{"needs what is not there", header("needs = ['lab.ridge']\n"),
             "s.toml:2:10: needs the mode type 'lab.ridge', which is not there; there are: surface_and_friction, follow, "
             "viscosity"},
       Wrong{"coupling is no table", header("coupling = 3\n"),
             "s.toml:2:12: 'coupling' in the scene is a number; it must be a table"},
       Wrong{"unknown key in coupling", header("[coupling]\nstifness_n_per_m = 3\n"),
             "s.toml:3:1: unknown key 'stifness_n_per_m' in [coupling]; did you mean 'stiffness_n_per_m'?"},
       Wrong{"unit left out", header("[coupling]\nstiffness = 3\n"),
             "s.toml:3:1: unknown key 'stiffness' in [coupling]; did you mean 'stiffness_n_per_m'?"},
       Wrong{"stiffness zero", header("[coupling]\nstiffness_n_per_m = 0\n"),
             "s.toml:3:21: 'stiffness_n_per_m' in [coupling] is 0; it must be above 0 and at most 100000"},
       Wrong{"damping negative", header("[coupling]\ndamping_ns_per_m = -0.5\n"),
             "s.toml:3:20: 'damping_ns_per_m' in [coupling] is -0.5; it must be between 0 and 100"},
       Wrong{"force not a number", header("[coupling]\nmax_force_n = nan\n"),
             "s.toml:3:15: 'max_force_n' in [coupling] is not finite;"},
       Wrong{"force infinite", header("[coupling]\nmax_force_n = inf\n"),
             "s.toml:3:15: 'max_force_n' in [coupling] is not finite;"},
       Wrong{"force a date", header("[coupling]\nmax_force_n = 2020-01-01\n"),
             "s.toml:3:15: 'max_force_n' in [coupling] is a date or time; it must be a number"},
       Wrong{"law that is none", header("[law]\nmethod = 'paper-2007'\n"),
             "s.toml:3:10: 'method' in [law] cannot be 'paper-2007'; did you mean 'paper-2005'?"},
       Wrong{"unknown key in law", header("[law]\nname = 'exact'\n"),
             "s.toml:3:1: unknown key 'name' in [law]; there are: method"}});
}

TEST(WrongScene, Workspace) {
  expect_refused(
      {Wrong{"unknown key", header("[workspace]\ncentre = 'ball'\n"),
             "s.toml:3:1: unknown key 'centre' in [workspace]; did you mean 'center'?"},
       Wrong{"fit names no volume", header("[workspace]\nfit = 'bal'\n"), "s.toml:3:7: no volume 'bal'; did you mean 'ball'?"},
       Wrong{"center names no volume", header("[workspace]\ncenter = 'heart'\n"),
             "s.toml:3:10: no volume 'heart'; there are: ball"},
       Wrong{"center of two", header("[workspace]\ncenter = [1, 2]\n"),
             "s.toml:3:10: 'center' in [workspace] is a list of another kind; it must be"},
       Wrong{"center not finite", header("[workspace]\ncenter = [1, 2, inf]\n"),
             "s.toml:3:10: 'center' in [workspace] is a list of another kind; it must be"},
       Wrong{"center a number", header("[workspace]\ncenter = 1\n"),
             "s.toml:3:10: 'center' in [workspace] is a number; it must be a volume's name"},
       Wrong{"scale zero", header("[workspace]\nscale = 0\n"), "s.toml:3:9: 'scale' in [workspace] is 0; it must be above 0"},
       Wrong{"fit and scale", header("[workspace]\nfit = 'ball'\nscale = 1\n"),
             "s.toml:4:9: both 'fit' and 'scale' are given; use one"},
       Wrong{"no direction", header("[workspace]\nup = 'north'\n"),
             "s.toml:3:6: 'up' in [workspace] cannot be 'north'; there are: anterior"},
       Wrong{"medical word without a medical frame", header("[workspace]\nup = 'superior'\n"),
             "s.toml:3:6: 'superior' is a medical word, and volume 'ball' has no medical frame; use one of: +x,"},
       Wrong{"parallel directions", header("[workspace]\nup = '+y'\ntowards_user = '-y'\n"),
             "s.toml:3:6: 'up' and 'towards_user' lie along one axis; give two"},
       Wrong{"parallel to the default", header("[workspace]\ntowards_user = '-y'\n"),
             "s.toml:3:16: 'up' and 'towards_user' lie along one axis;"}});
}

TEST(WrongScene, Volume) {
  expect_refused(
      {Wrong{"not a table", "palpa = 1\n[volume]\nv = 3\n", "s.toml:3:5: volume 'v' is a number; it must be a table"},
       Wrong{"name no plain word", "palpa = 1\n[volume.'a.b']\n", "s.toml:2:9: volume name 'a.b' is no plain word;"},
       Wrong{"no data", volume("sampled = 8"), "s.toml:2:1: volume 'v' has no data; give either 'file' or 'analytic'"},
       Wrong{"two sources", volume("file = 'x'\nanalytic = 'sphere'"), "s.toml:2:1: volume 'v' has two sources;"},
       Wrong{"unknown key", volume("analytic = 'sphere'\nsample = 8"),
             "s.toml:4:1: unknown key 'sample' in volume 'v'; did you mean 'sampled'?"},
       Wrong{"key of a later issue", volume("analytic = 'sphere'\nstretch = [1, 1, 20]"),
             "s.toml:4:1: unknown key 'stretch' in volume 'v'; "},
       Wrong{"components_along", volume("file = 'a'\ncomponents_along = 'grid'"),
             "s.toml:4:20: 'components_along' in volume 'v' cannot be 'grid'; there are: file, index"},
       Wrong{"list of files", volume("file = ['a', 'b']"), "s.toml:3:8: no file 'a' for volume 'v'"},
       Wrong{"list of no files", volume("file = []"), "s.toml:3:8: 'file' in volume 'v' is an empty list; name a file"},
       Wrong{"list of numbers", volume("file = [1]"), "s.toml:3:9: 'file' in volume 'v' holds a number; it must be a text"},
       Wrong{"moment", volume("file = 'a'\ntime = 'first'"), "s.toml:4:8: 'time' in volume 'v' cannot be 'first'; "},
       Wrong{"crop of three", volume("file = 'a'\ncrop_m = [1, 2, 3]"), "s.toml:4:10: 'crop_m' in volume 'v' "},
       Wrong{"dims", volume("file = 'a'\ndims = [1, 2, 2.5]"), "s.toml:"},
       Wrong{"axes", volume("file = 'a'\naxes = 'xxy'"), "s.toml:4:8: 'axes' in volume 'v' cannot be 'xxy'"},
       Wrong{"unknown formula", volume("analytic = 'spere'"),
             "s.toml:3:12: 'analytic' in volume 'v' cannot be 'spere'; did you mean 'sphere'?"},
       Wrong{"formula that is none", volume("analytic = 'molecule'"),
             "s.toml:3:12: 'analytic' in volume 'v' cannot be 'molecule'; there are: plane,"},
       Wrong{"sampled by one", volume("analytic = 'sphere'\nsampled = 1"),
             "s.toml:4:11: 'sampled' in volume 'v' is 1; it must be between 2 and"},
       Wrong{"sampled by a fraction", volume("analytic = 'sphere'\nsampled = 8.5"),
             "s.toml:4:11: 'sampled' in volume 'v' is a number; it must be a whole number"},
       Wrong{"sampled without end", volume("analytic = 'sphere'\nsampled = 9223372036854775807"),
             "s.toml:4:11: 'sampled' in volume 'v' is 9223372036854775808.0;"},
       Wrong{"file that is sampled", volume("file = '/dev/null'\nsampled = 8"),
             "s.toml:4:11: 'sampled' in volume 'v' is for embedded data;"},
       Wrong{"formula with a unit of length", volume("analytic = 'sphere'\nlength_unit = 'mm'"),
             "s.toml:4:15: 'length_unit' in volume 'v' speaks of a file;"},
       Wrong{"unknown unit of length", volume("file = '/dev/null'\nlength_unit = 'furlong'"),
             "s.toml:4:15: 'length_unit' in volume 'v' cannot be 'furlong'; there are: m"},
       Wrong{"negative frame", volume("file = '/dev/null'\nframe = -1"), "s.toml:4:9: 'frame' in volume 'v' is -1;"},
       Wrong{"as something", volume("file = '/dev/null'\nas = 'tensor'"),
             "s.toml:4:6: 'as' in volume 'v' cannot be 'tensor'; there are: vector"},
       Wrong{"fields of another kind", volume("file = '/dev/null'\nfields = ['a']"),
             "s.toml:4:10: 'fields' in volume 'v' is a list; it must be a table"},
       Wrong{"field name", volume("file = '/dev/null'\nfields = {'a b' = {array = 'x'}}"),
             "s.toml:4:11: field name 'a b' is no plain word;"},
       Wrong{"field of another kind", volume("file = '/dev/null'\nfields = {a = 'x'}"),
             "s.toml:4:15: field 'a' of volume 'v' is a text; it must be {array"},
       Wrong{"unknown key in a field", volume("file = '/dev/null'\nfields = {a = {arrray = 'x'}}"),
             "s.toml:4:16: unknown key 'arrray' in field 'a' of volume 'v'; did you mean 'array'?"},
       Wrong{"unknown key in the pose", volume("analytic = 'sphere'\npose = {translate = [0, 0, 0]}"),
             "s.toml:4:9: unknown key 'translate' in 'pose' of volume 'v'; did you mean 'translate_m'?"},
       Wrong{"pose by two", volume("analytic = 'sphere'\npose = {translate_m = [0, 0]}"),
             "s.toml:4:23: 'translate_m' in 'pose' of volume 'v' is a list of another kind; it must be a list of 3 numbers"},
       Wrong{"pose about nothing", volume("analytic = 'sphere'\npose = {rotate_axis_deg = [0, 0, 0, 90]}"),
             "s.toml:4:27: the axis in 'rotate_axis_deg' of volume 'v' is zero;"},
       Wrong{"pose mirrored", volume("analytic = 'sphere'\npose = {scale = -1}"),
             "s.toml:4:17: 'scale' in 'pose' of volume 'v' is -1; it must be above 0"},
       Wrong{"file that is not there", volume("file = 'gone.nrrd'"),
             "s.toml:3:8: no file 'gone.nrrd' for volume 'v'; looked for gone.nrrd; name the folder"},
       Wrong{"absolute file that is not there", volume("file = '/gone/x.nrrd'"),
             "s.toml:3:8: no file '/gone/x.nrrd' for volume 'v'; looked for /gone/x.nrrd"},
       Wrong{"file without a name", volume("file = ''"), "s.toml:3:8: 'file' in volume 'v' is no path;"},
       Wrong{"file with a zero in its name", volume("file = \"/dev/null\\u0000x\""),
             "s.toml:3:8: 'file' in volume 'v' is no path;"}});
}

TEST(WrongScene, Mode) {
  expect_refused(
      {Wrong{"none", "palpa = 1\n[volume.v]\nanalytic = 'sphere'\n",
             "s.toml:1:1: a scene without modes cannot be felt; add a [[mode]]"},
       Wrong{"empty list", "palpa = 1\nmode = []\n", "s.toml:2:8: a scene without modes cannot be felt;"},
       Wrong{"a table instead of a list", "palpa = 1\n[mode]\nname = 'm'\n",
             "s.toml:2:1: 'mode' in the scene is a table; it must be a list of tables"},
       Wrong{"a list of numbers", "palpa = 1\nmode = [1]\n",
             "s.toml:2:9: 'mode' in the scene holds a number; it must be a list of tables"},
       Wrong{"no type", mode("name = 'm'"),
             "s.toml:4:1: no key 'type' in mode 'm'; it is needed: one of surface_and_friction,"},
       Wrong{"type of another kind", mode("name = 'm'\ntype = 3"),
             "s.toml:6:8: 'type' in mode 'm' is a number; it must be a text"},
       Wrong{"unknown type", mode("name = 'm'\ntype = 'viscous'"),
             "s.toml:6:8: unknown mode type 'viscous' in mode 'm'; there are: surface_and_friction"},
       Wrong{"type that nobody brings", mode("name = 'm'\ntype = 'vortex_sheet'"),
             "s.toml:6:8: unknown mode type 'vortex_sheet' in mode 'm';"},
       Wrong{"no name", mode("type = 'viscosity'\nstrength_n = 1"), "s.toml:4:1: no key 'name' in mode 1; it is needed"},
       Wrong{"name no plain word", mode("name = 'a b'\ntype = 'viscosity'\nstrength_n = 1"),
             "s.toml:5:8: mode name 'a b' is no plain word;"},
       Wrong{"name on two lines", mode("name = \"a\\nb\"\ntype = 'viscosity'\nstrength_n = 1"),
             "s.toml:5:8: mode name 'a\\u000Ab' is no plain word;"},
       Wrong{"name taken", with("[[mode]]\nname = 'skin'\ntype = 'viscosity'\nstrength_n = 1\n"),
             "s.toml:13:8: mode name 'skin' is taken;"},
       Wrong{"enabled by a number", mode("name = 'm'\ntype = 'viscosity'\nstrength_n = 1\nenabled = 1"),
             "s.toml:8:11: 'enabled' in mode 'm' is a number; it must be true or false"},
       Wrong{"unknown key", mode("name = 'm'\ntype = 'viscosity'\nstrenght_n = 1"),
             "s.toml:7:1: unknown key 'strenght_n' in mode 'm'; did you mean 'strength_n'?"},
       Wrong{"key of another type", mode("name = 'm'\ntype = 'viscosity'\nstrength_n = 1\nsolid = 'high'"),
             "s.toml:8:1: unknown key 'solid' in mode 'm'; "},
       Wrong{"negative strength", mode("name = 'm'\ntype = 'viscosity'\nstrength_n = -1"),
             "s.toml:7:14: 'strength_n' in mode 'm' is -1; it must be between 0 and 1"},
       Wrong{"strength as a text", mode("name = 'm'\ntype = 'viscosity'\nstrength_n = '1'"),
             "s.toml:7:14: 'strength_n' in mode 'm' is a text; it must be a number or a function"},
       Wrong{"drag out of range", mode("name = 'm'\ntype = 'viscosity'\ndrag_ns_per_m = 101"),
             "s.toml:7:17: 'drag_ns_per_m' in mode 'm' is 101; it must be between 0 and 100"},
       Wrong{"neither strength nor drag", mode("name = 'm'\ntype = 'viscosity'"),
             "s.toml:4:1: mode 'm': neither strength_n nor drag_ns_per_m is given; give one"},
       Wrong{"no field", mode("name = 'm'\ntype = 'surface_and_friction'\nstrength_n = 1"),
             "s.toml:4:1: no key 'field' in mode 'm'; it is needed: scalar field"},
       Wrong{"field of no volume", mode("name = 'm'\ntype = 'viscosity'\nstrength_n = 1\nfield = 'bal'"),
             "s.toml:8:9: no volume 'bal'; did you mean 'ball'?"},
       Wrong{"field not in the volume", mode("name = 'm'\ntype = 'viscosity'\nstrength_n = 1\nfield = 'ball.x'"),
             "s.toml:8:9: no field 'ball.x'; "},
       Wrong{"magnitude of a scalar", mode("name = 'm'\ntype = 'viscosity'\nstrength_n = 1\nfield = 'magnitude(ball)'"),
             "s.toml:8:9: 'magnitude' cannot be taken of the scalar field within it; it takes a vector field"},
       Wrong{"scalar where a vector belongs", mode("name = 'm'\ntype = 'follow'\nfield = 'ball'"),
             "s.toml:7:9: 'field' in mode 'm' must be a vector field; 'ball' is a scalar field"},
       Wrong{"unknown choice", mode("name = 'm'\ntype = 'surface_and_friction'\nfield = 'ball'\nstrength_n = 1\nsolid = 'hi'"),
             "s.toml:9:9: 'solid' in mode 'm' cannot be 'hi'; "},
       Wrong{"levels and material", with("").replace(with("").find("[[mode.level]]"), 0, "strength_n = 1\n"),
             "s.toml:4:1: mode 'skin': levels and strength_n are both given;"}});
}

std::string strength(const std::string& function) { return mode("name = 'm'\ntype = 'viscosity'\nstrength_n = " + function); }
std::string mask(const std::string& masks) { return mode("name = 'm'\ntype = 'viscosity'\nstrength_n = 1\nmask = " + masks); }

TEST(WrongScene, Function) {
  expect_refused(
      {Wrong{"unknown key", strength("{of = 'ball', point = []}"),
             "s.toml:7:28: unknown key 'point' in 'strength_n' of mode 'm'; did you mean 'points'?"},
       Wrong{"without field", strength("{points = [[0, 1]]}"), "s.toml:7:14: no key 'of' in 'strength_n' of mode 'm';"},
       Wrong{"without points", strength("{of = 'ball'}"), "s.toml:7:14: no key 'points' in 'strength_n' of mode 'm';"},
       Wrong{"no points", strength("{of = 'ball', points = []}"),
             "s.toml:7:37: the points in 'strength_n' of mode 'm' make no function: "},
       Wrong{"falling values", strength("{of = 'ball', points = [[1, 1], [0, 2]]}"),
             "s.toml:7:37: the points in 'strength_n' of mode 'm' make no function: "},
       Wrong{"a point of three", strength("{of = 'ball', points = [[0, 1], [1, 2, 3]]}"),
             "s.toml:7:46: a point in 'strength_n' of mode 'm' is no pair of numbers;"},
       Wrong{"a point not finite", strength("{of = 'ball', points = [[0, 1], [nan, 2]]}"),
             "s.toml:7:46: a point in 'strength_n' of mode 'm' is no pair"},
       Wrong{"a negative result", strength("{of = 'ball', points = [[0, 1], [1, -2]]}"),
             "s.toml:7:50: a result in 'strength_n' of mode 'm' is -2; it must be between 0 and 1"},
       Wrong{"a negative outside", strength("{of = 'ball', points = [[0, 1]], outside = -2}"),
             "s.toml:7:57: a result in 'strength_n' of mode 'm' is -2;"},
       Wrong{"of no volume", strength("{of = 'bell', points = [[0, 1]]}"),
             "s.toml:7:20: no volume 'bell'; did you mean 'ball'?"},
       Wrong{"mask no list", mask("{of = 'ball', points = [[0, 1]]}"),
             "s.toml:8:8: 'mask' in mode 'm' is a table; it must be a list of tables"},
       Wrong{"mask above one", mask("[{of = 'ball', points = [[0, 1.5]]}]"),
             "s.toml:8:37: a result in 'mask' of mode 'm' is 1.5; it must be between 0 and 1"},
       Wrong{"mask of no volume", mask("[{of = 'bell', points = [[0, 1]]}]"),
             "s.toml:8:15: no volume 'bell'; did you mean 'ball'?"},
       Wrong{"level is no list", mode("name = 'm'\ntype = 'surface_and_friction'\nfield = 'ball'\n[mode.level]\nvalue = 0"),
             "s.toml:8:1: 'level' in mode 'm' is a table; it must be a list of tables"},
       Wrong{"unknown key in a level", with("friction = 1"),
             "s.toml:12:1: unknown key 'friction' in level 'outside' of mode 'skin'; did you mean 'friction_n'?"},
       Wrong{"level without value", with("[[mode.level]]\n"),
             "s.toml:12:1: no key 'value' in level 2 of mode 'skin'; it is needed"},
       Wrong{"level not finite", with("[[mode.level]]\nvalue = nan\n"),
             "s.toml:13:9: 'value' in level 2 of mode 'skin' is not finite;"},
       Wrong{"level name taken", with("[[mode.level]]\nvalue = 0\nname = 'outside'\n"),
             "s.toml:14:8: level name 'outside' is taken;"},
       Wrong{"level name no plain word", with("[[mode.level]]\nvalue = 0\nname = '1st'\n"),
             "s.toml:14:8: level name '1st' is no plain word;"},
       Wrong{"friction out of range on a level", with("friction_coefficient = 11\n"),
             "s.toml:12:24: 'friction_coefficient' in level 'outside' of mode 'skin' is 11; it must be between 0 and 10"},
       Wrong{"strength negative on a level", with("[[mode.level]]\nvalue = 0\nstrength_n = -0.5\n"),
             "s.toml:14:14: 'strength_n' in level 2 of mode 'skin' is -0.5;"},
       Wrong{"both frictions on a level", with("friction_coefficient = 1\nfriction_n = 1\n"),
             "s.toml:4:1: mode 'skin': level 'outside' has both"}});
}

std::string layer(const std::string& body) { return with("[[view.layer]]\n" + body + "\n"); }

TEST(WrongScene, View) {
  expect_refused(
      {Wrong{"unknown key", with("[view]\ncamera = 1\n"), "s.toml:13:1: unknown key 'camera' in [view]; there are: layer"},
       Wrong{"layer is no list", with("[view.layer]\nshow = 'surface'\n"),
             "s.toml:12:1: 'layer' in [view] is a table; it must be a list of tables"},
       Wrong{"unknown key in a layer", layer("show = 'surface'\nfield = 'ball'\ncolor = 'red'"),
             "s.toml:15:1: unknown key 'color' in [[view.layer]]; did you mean 'colors'?"},
       Wrong{"shown as something", layer("show = 'points'\nfield = 'ball'"),
             "s.toml:13:8: 'show' in [[view.layer]] cannot be 'points'; "},
       Wrong{"without field", layer("show = 'slices'"), "s.toml:12:1: no key 'field' in [[view.layer]];"},
       Wrong{"a color that is none", layer("show = 'slices'\nfield = 'ball'\ncolors = {points = [[0, 'red', 1]]}"),
             "s.toml:15:21: a point of 'colors' is something else;"},
       Wrong{"an opacity above one", layer("show = 'slices'\nfield = 'ball'\ncolors = {points = [[0, '#ff0000', 2]]}"),
             "s.toml:15:21: a point of 'colors'"},
       Wrong{"colors without points", layer("show = 'slices'\nfield = 'ball'\ncolors = {}"),
             "s.toml:15:10: no key 'points' in 'colors'"}});
}

TEST(LoadScene, ReadsHowAPictureLooks) {
  const LoadedScene loaded =
      parse(with("[view]\nfrom = [1, 0, 2]\n[[view.layer]]\nshow = 'surface'\nfield = 'ball'\n"
                 "name = 'a ball'\nparts = 'all'\n[[view.layer]]\nshow = 'slices'\nfield = 'ball'\n"));
  const Scene& scene = loaded.scene;
  EXPECT_EQ(scene.view.from, (Vec3{1, 0, 2}));
  ASSERT_EQ(scene.layers.size(), 2u);
  EXPECT_EQ(scene.layers[0].name, "a ball");
  EXPECT_TRUE(scene.layers[0].all_parts);
  EXPECT_EQ(scene.layers[1].name, "");
  EXPECT_FALSE(scene.layers[1].all_parts);
  EXPECT_EQ(parse(to_toml(scene)).scene, scene);
  expect_refused({Wrong{"from nowhere", with("[view]\nfrom = [0, 0, 0]\n"), "s.toml:13:8: 'from' is [0, 0, 0];"},
                  Wrong{"other parts", layer("show = 'surface'\nfield = 'ball'\nparts = 'some'"),
                        "s.toml:15:9: 'parts' in [[view.layer]] cannot be 'some'; "}});
}

TEST(LoadScene, WhatCannotBeDrawnIsToldWhereItStandsAndFeltAllTheSame) {
  EXPECT_THAT(parse(layer("show = 'slices'\nfield = 'bell'")).warnings,
              ElementsAre(StartsWith("s.toml:14:9: no volume 'bell'; did you mean 'ball'?")));
  EXPECT_THAT(parse(layer("show = 'streamlines'\nfield = 'ball'")).warnings,
              ElementsAre("s.toml:14:9: 'ball' is a scalar field; streamlines and glyphs are drawn of a vector one"));
  EXPECT_THAT(parse(layer("show = 'slices'\nfield = 'ball'")).warnings, testing::IsEmpty());
}

TEST(LoadScene, NamesSeveralFieldsOfOneVolume) {
  const Folder folder;
  folder.file("two.vti");
  const std::string two = "palpa = 1\n[volume.flow]\nfile = 'two.vti'\n[[mode]]\nname = 'm'\ntype = 'follow'\nfield = ";
  EXPECT_EQ(parse(two + "'flow.velocity'", {}, folder.path).scene.index_of({"flow.velocity"}), 1);
  EXPECT_THAT(error_of(two + "'flow'", {}, folder.path),
              StartsWith("s.toml:7:9: volume 'flow' has several fields; name one of: flow.density, flow.velocity"));
  EXPECT_THAT(error_of(two + "'flow.velocty'", {}, folder.path),
              StartsWith("s.toml:7:9: no field 'flow.velocty'; did you mean 'flow.velocity'?"));
  EXPECT_THAT(error_of(two + "'flow.density'", {}, folder.path),
              StartsWith("s.toml:7:9: 'field' in mode 'm' must be a vector field;"));
}

TEST(LoadScene, SaysWhatAReaderSays) {
  const Folder folder;
  const auto file = folder.file("broken.nrrd");
  EXPECT_EQ(error_of(volume("file = 'broken.nrrd'"), {}, folder.path),
            file.string() + ": ends in the middle; give a whole file");
}

TEST(LoadScene, HandsTheRequestOn) {
  const Folder folder;
  folder.file("scalar.vti");
  VolumeRequest got;
  const VolumeReader reader = [&](const VolumeRequest& request) {
    got = request;
    return sphere_field();
  };
  parse_scene(volume("file = 'scalar.vti'\nlength_unit = 'cm'\nframe = 3\nas = 'vector'\nfields = {speed = {array = 'V 1', "
                     "unit = 'm/s'}, t = {}}"),
              "s.toml", folder.path, reader, standard_modes());
  EXPECT_THAT(got.files, ElementsAre(folder.path / "scalar.vti"));
  EXPECT_EQ(got.length_unit, "cm");
  EXPECT_EQ(got.frame, 3);
  EXPECT_EQ(got.as, "vector");
  ASSERT_EQ(got.fields.size(), 2u);
  EXPECT_EQ(got.fields[0].name, "speed");
  EXPECT_EQ(got.fields[0].array, "V 1");
  EXPECT_EQ(got.fields[0].unit, "m/s");
  EXPECT_EQ(got.fields[1].name, "t");
}

TEST(LoadScene, OpensNoVolumeOfASceneThatIsWrong) {
  const Folder folder;
  folder.file("scalar.vti");
  const VolumeReader never = [](const VolumeRequest&) -> Volume { throw LoadError("opened"); };
  for (const std::string wrong :
       {"strenght_n = 1", "strength_n = -1", "strength_n = 1\nfield = 'w'", "strength_n = 1\nmask = 3"}) {
    const std::string text = "palpa = 1\n[volume.v]\nfile = 'scalar.vti'\n[[mode]]\nname = 'm'\ntype = 'viscosity'\n" + wrong;
    try {
      parse_scene(text, "s.toml", folder.path, never, standard_modes());
      FAIL() << wrong;
    } catch (const LoadError& error) {
      EXPECT_THAT(error.what(), StartsWith("s.toml:")) << wrong;
    }
  }
}

TEST(LoadScene, LooksForFilesInOrder) {
  const Folder folder;
  const std::string text = volume("file = 'scalar.vti'");
  const auto used = [&] {
    SceneOptions options;
    options.data_folders = {folder.path / "first", folder.path / "second"};
    return std::filesystem::path(parse(text, options, folder.path / "scene").scene.volumes()[0].volume.files[0].path);
  };
  setenv("PALPA_DATA", (folder.path / "environment").c_str(), 1);
  for (const char* where : {"environment", "second", "first", "scene"}) {
    const auto file = folder.file(std::string(where) + "/scalar.vti");
    EXPECT_EQ(used(), file);
  }
  unsetenv("PALPA_DATA");
  std::filesystem::remove_all(folder.path / "scene");
  std::filesystem::remove_all(folder.path / "first");
  EXPECT_EQ(used(), folder.path / "second" / "scalar.vti");
  std::filesystem::remove_all(folder.path / "second");
  SceneOptions options;
  options.data_folders = {folder.path / "first", folder.path / "second"};
  const std::string at = folder.path.string();
  EXPECT_THAT(error_of(text, options, folder.path / "scene"),
              HasSubstr("looked for " + at + "/scene/scalar.vti, " + at + "/first/scalar.vti, " + at + "/second/scalar.vti; "));
}

// Of a volume so small that a derivative is beyond a double.
TEST(LoadScene, SaysWhatWouldLetItDerive) {
  const std::string error = error_of(R"toml(palpa = 1
[coupling]
stiffness_n_per_m = 400
[volume.flow]
analytic = "burgers_vortex"
sampled = 16
pose = { translate_m = [0, 0, 0], scale = 1e-320 }
[[mode]]
name = "tube"
type = "vortex_plane"
field = "flow"
strength_n = { of = "q(flow)", points = [[0.0, 0.0], [1.0, 0.5]] }
)toml");
  EXPECT_THAT(error, StartsWith("s.toml:8:1: what mode 'tube' feels cannot be derived: "));
  EXPECT_THAT(error, HasSubstr("; use a larger scale"));
}

TEST(LoadScene, WarnsOfALevelOutsideTheData) {
  const LoadedScene loaded = parse(with("[[mode.level]]\nname = 'far'\nvalue = 0.7\n"));
  EXPECT_EQ(loaded.scene.modes().size(), 1u);
  ASSERT_EQ(loaded.warnings.size(), 1u);
  EXPECT_THAT(loaded.warnings[0], StartsWith("s.toml:14:9: 'value' in level 'far' of mode 'skin' is 0.7, outside the data of "
                                             "'ball' and never met; they go from "));
  EXPECT_EQ(loaded.scene.check().size(), 1u);
}

TEST(LoadScene, PassesWarningsOfVolumesOn) {
  const Folder folder;
  folder.file("scalar.vti");
  const VolumeReader reader = [&](const VolumeRequest&) {
    Volume ball_volume = sphere_field();
    ball_volume.warnings = {"no unit of length; taken as metres"};
    return ball_volume;
  };
  const LoadedScene loaded = parse_scene(volume("file = 'scalar.vti'"), "s.toml", folder.path, reader, standard_modes());
  EXPECT_THAT(loaded.warnings, ElementsAre("s.toml:2:1: volume 'v': no unit of length; taken as metres"));
}

TEST(LoadScene, WarnsOfVolumesInDifferentFramesOfReference) {
  const Folder folder;
  for (const char* file : {"a.nrrd", "b.nrrd", "c.nrrd"}) folder.file(file);
  const auto warnings = [&](const std::string& of_b, const char* pose_of_b) {
    const VolumeReader reader = [&](const VolumeRequest& request) {
      Volume scan = sphere_field();
      const auto name = request.files.front().filename();
      scan.frame_of_reference = name == "a.nrrd" ? "1.2.3" : name == "b.nrrd" ? of_b : "";
      return scan;
    };
    const std::string text =
        "palpa = 1\n[volume.a]\nfile = 'a.nrrd'\n[volume.b]\nfile = 'b.nrrd'\n" + std::string(pose_of_b) +
        "\n[volume.c]\nfile = 'c.nrrd'\n[[mode]]\nname = 'inside'\ntype = 'viscosity'\nfield = 'a'\ndrag_ns_per_m = 1\n";
    return parse_scene(text, "s.toml", folder.path, reader, standard_modes()).warnings;
  };
  EXPECT_THAT(warnings("1.2.3", ""), ElementsAre());
  EXPECT_THAT(warnings("", ""), ElementsAre());
  EXPECT_THAT(warnings("1.2.4", "pose = {translate_m = [0.01, 0, 0]}"), ElementsAre());
  EXPECT_THAT(warnings("1.2.4", ""),
              ElementsAre(StartsWith("s.toml:4:1: volume 'b': is in another frame of reference than volume 'a': ")));
}

TEST(LoadScene, FromAFile) {
  const Folder folder;
  const auto file = folder.file("ball.toml", ball);
  EXPECT_EQ(load_scene(file, test::read_stand_in, standard_modes()).text, ball);
  const auto error = [](const std::filesystem::path& path) -> std::string {
    try {
      load_scene(path, test::read_stand_in, standard_modes());
    } catch (const SceneError& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_THAT(error(folder.path / "gone.toml"), StartsWith((folder.path / "gone.toml").string() + ": no such scene;"));
  EXPECT_THAT(error(folder.path), StartsWith(folder.path.string() + ": a folder, no scene;"));
  EXPECT_THAT(error("/dev/zero"), StartsWith("/dev/zero: is no ordinary file"));
  const auto endless = folder.file("endless.toml", "");
  std::filesystem::resize_file(endless, std::uintmax_t{1} << 40);  // without a byte on the disk
  EXPECT_THAT(error(endless), StartsWith(endless.string() + ": longer than 4 MiB;"));
  EXPECT_THAT(error(folder.file("wrong.toml", "palpa = 3")),
              StartsWith((folder.path / "wrong.toml").string() + ":1:9: scene format 3"));
}

// ---- Scenes that people see

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Loads with an empty file in place of each that the scene names. Its fields are formulas, which have no filter.
void expect_loads(std::string text, const std::string& what) {
  const Folder data;
  if (const std::size_t at = text.find("\nfilter = "); at != std::string::npos) text.insert(at + 1, "# ");
  const std::string key = "\nfile = \"";
  for (std::size_t at = text.find(key); at != std::string::npos; at = text.find(key, at + 1)) {
    const std::size_t begin = at + key.size();
    data.file(text.substr(begin, text.find('"', begin) - begin));
  }
  EXPECT_EQ(error_of(text, {}, data.path), "no error") << what;
}

TEST(Scenes, OfTheRepositoryLoad) {
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(PALPA_SOURCE_FOLDER) / "scenes")) {
    if (entry.path().extension() != ".toml") continue;
    expect_loads(text_of(entry.path()), entry.path().string());
    ++scenes;
  }
  EXPECT_GT(scenes, 0);
}

TEST(Scenes, OfTheDocumentationLoad) {
  const std::string page = text_of(std::filesystem::path(PALPA_SOURCE_FOLDER) / "docs" / "scene.md");
  const std::size_t start = page.find("```toml\n") + 8;
  ASSERT_LT(start, page.size());
  expect_loads(page.substr(start, page.find("```", start) - start), "docs/scene.md");
}

// ---- --set

SceneOptions set(const std::string& path, const std::string& value) {
  SceneOptions options;
  options.sets = {{path, value}};
  return options;
}

TEST(Set, ReachesEveryPath) {
  EXPECT_EQ(parse(ball, set("coupling.stiffness_n_per_m", "300")).scene.coupling.stiffness_n_per_m, 300);
  EXPECT_EQ(parse(ball, set("law.method", "exact")).scene.law, "exact");
  EXPECT_EQ(parse(ball, set("workspace.scale", "2.5")).scene.workspace.scale, 2.5);
  EXPECT_EQ(parse(ball, set("workspace.up", "+x")).scene.workspace.up, "+x");
  EXPECT_EQ(parse(ball, set("workspace.center", "[1, 2, 3]")).scene.workspace.center_m, (Vec3{1, 2, 3}));
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
  EXPECT_EQ(parse(header("[coupling]\nmax_force_n = 3\n"), options).scene.coupling.max_force_n, 2);
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

// ---- Round trip

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
    scene.workspace.center_m = Vec3{value, -value, std::round(value)};
    const Scene again = parse(to_toml(scene)).scene;
    EXPECT_EQ(again.workspace.center_m, scene.workspace.center_m) << value;
  }
}

// ---- Anything at all

TEST(LoadScene, AnythingGivesASceneOrAnError) {
  const std::string whole = header("title = 't'\n[coupling]\nstiffness_n_per_m = 800\n[workspace]\nfit = 'ball'\nup = '+y'\n") +
                            "friction_n = 0.1\n[[mode]]\nname = 'v'\ntype = 'viscosity'\nfield = 'ball'\n"
                            "strength_n = {of = 'ball', points = [[0, 0], [0.1, 1]], outside = 0}\n"
                            "mask = [{of = 'ball', points = [[0, 1]]}]\n[[view.layer]]\nshow = 'volume'\nfield = 'ball'\n";
  ASSERT_EQ(error_of(whole), "no error");
  std::mt19937 random(7);
  const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  const std::string pool = "[]{}=.,'\"\n\\#-+0129eaxn \t\xc3\xff\x01";
  int scenes = 0, errors = 0;
  for (int round = 0; round < 4000; ++round) {
    std::string text = whole;
    for (std::size_t edit = 0, edits = 1 + below(3); edit < edits; ++edit) {
      const std::size_t at = below(text.size());
      switch (below(5)) {
        case 4: text[at] = static_cast<char>('0' + below(10)); break;
        case 0: text[at] = pool[below(pool.size())]; break;
        case 1: text.erase(at, 1 + below(20)); break;
        case 2: text.insert(at, 1, pool[below(pool.size())]); break;
        default: text.insert(at, text.substr(below(text.size()), below(60))); break;
      }
    }
    try {
      const LoadedScene loaded = parse(text);
      loaded.scene.hand_to_world();
      EXPECT_EQ(to_toml(parse(to_toml(loaded.scene)).scene), to_toml(loaded.scene)) << text;
      ++scenes;
    } catch (const SceneError& error) {
      const std::string what = error.what();
      EXPECT_THAT(what, StartsWith("s.toml:")) << text;
      EXPECT_THAT(what, HasSubstr(";")) << text;
      EXPECT_EQ(what.find('\n'), std::string::npos);
      ++errors;
    }
  }
  EXPECT_GT(scenes, 30);
  EXPECT_GT(errors, 1000);
}

}  // namespace load_scene_test
}  // namespace palpa
