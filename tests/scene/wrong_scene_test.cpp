// Invalid scenes: each is refused in one line with place and error.
#include <gtest/gtest.h>

#include "tests/scene/ball_scene.h"

namespace palpa {
namespace wrong_scene_test {

using namespace test::ball_scene;

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
             "s.toml:2:10: needs the mode type 'lab.ridge', which is not available; there are: surface_and_friction, follow, "
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

}  // namespace wrong_scene_test
}  // namespace palpa
