// Loadable scenes, their messages, and the sources of their data.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <random>

#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "tests/scene/ball_scene.h"

namespace palpa {
namespace load_scene_test {

using namespace test::ball_scene;
using test::error_of;
using test::parse;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

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
  EXPECT_EQ(scene.coupling(), (CouplingOptions{800, 0.5, 4.5}));
  EXPECT_EQ(scene.workspace().center_m, (Vec3{0, 0.01, 0}));
  EXPECT_EQ(scene.workspace().up, "+z");
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
  EXPECT_EQ(scene.coupling(), CouplingOptions{});
  EXPECT_EQ(scene.law(), "exact");
  EXPECT_EQ(scene.workspace(), Workspace{});
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

// Of a volume too small for a derivative in a double.
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

// ---- Scenes of the documentation

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
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(std::filesystem::path(PALPA_SOURCE_FOLDER) / "scenes")) {
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

// ---- Random texts

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
