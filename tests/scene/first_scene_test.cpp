// Suggested scenes: they load, say why each number is so, and fit the data that they are for.
#include "palpa/scene/first_scene.h"

#include <gmock/gmock.h>

#include <fstream>
#include <functional>
#include <regex>
#include <sstream>

#include "palpa/mode/viscosity.h"
#include "palpa/scene/reach.h"
#include "scene_files.h"

namespace palpa::test {
namespace {

using testing::HasSubstr;
using testing::Not;

/// The scene for a volume, which must load with that volume and without a warning.
std::string scene_of(const Volume& volume, VolumeRequest request = {}) {
  request.files = {"/data/file.nrrd"};
  const std::string text = first_scene(volume, request);
  const auto as_read = [&](const VolumeRequest& wanted) {
    Volume read = volume;
    if (!wanted.fields.empty()) {
      read.fields.clear();
      for (const auto& field : wanted.fields) {
        for (const VolumeField& there : volume.fields) {
          if (there.name == (field.array.empty() ? field.name : field.array))
            read.fields.push_back({field.name, "", there.field});
        }
      }
    }
    return read;
  };
  // The file need not be there for a scene to be understood, but its loader looks for it.
  std::string here = text;
  const std::string folder = testing::TempDir();
  std::ofstream(folder + "/file.nrrd") << "x";
  here.replace(here.find("/data/file.nrrd"), 15, folder + "/file.nrrd");
  EXPECT_TRUE(parse_scene(here, "first.toml", {}, as_read, standard_modes()).warnings.empty());
  return text;
}

Volume sampled_head() {
  Volume head = sampled(head_phantom(), 60);
  head.fields[0].unit = "";
  return head;
}

TEST(FirstScene, OfCtFeelsSkinAndBone) {
  const std::string text = scene_of(sampled_head());
  for (const char* part : {"value = -300", "value = 300", "-1000 HU", "solid = \"high\"", "viscosity"})
    EXPECT_THAT(text, HasSubstr(part));
}

TEST(FirstScene, SaysWhyOfEveryNumber) {
  for (const Volume& volume : {sampled_head(), ring_vortex(), sphere_field()}) {
    std::istringstream lines(scene_of(volume));
    for (std::string line; std::getline(lines, line);) {
      if (!std::regex_search(line, std::regex("= .*[0-9]")) || line.starts_with("palpa = ") || line.starts_with("file = "))
        continue;
      EXPECT_THAT(line, HasSubstr("# ")) << "no reason";
    }
  }
}

TEST(FirstScene, OfAVectorFieldFollowsItWhereItFlows) {
  const std::string text = scene_of(ring_vortex());
  for (const char* part : {"type = \"follow\"", "type = \"viscosity\"", "magnitude(data)", "mask = "})
    EXPECT_THAT(text, HasSubstr(part));
}

TEST(FirstScene, NeverTakesAUnitInSilence) {
  Volume head = sampled_head();
  head.length_unit = "mm", head.length_unit_assumed = true;
  EXPECT_THAT(scene_of(head), HasSubstr("ASSUMED"));
  head.length_unit_assumed = false;
  EXPECT_THAT(scene_of(head), Not(HasSubstr("length_unit")));
  VolumeRequest request;
  request.length_unit = "cm";
  head.length_unit = "cm";
  EXPECT_THAT(scene_of(head, request), HasSubstr("length_unit = \"cm\""));
}

TEST(FirstScene, NamesFieldsByPlainWords) {
  Volume two = sampled_head();
  two.fields[0].name = "1st array (raw)";
  two.fields.push_back({"other", "", two.fields[0].field});
  EXPECT_THAT(scene_of(two), HasSubstr("fields = {value = {array = \"1st array (raw)\"}}"));
  two.fields[0].name = "my array";
  EXPECT_THAT(scene_of(two), HasSubstr("fields = {my_array = {array = \"my array\"}}"));
}

TEST(FirstScene, SaysAllThatTheFileWasReadBy) {
  VolumeRequest request;
  request.files = {"/data/file.xyz", "/data/other.q"};
  request.fields = {{"speed", "velocity magnitude", "m/s"}};
  request.series = "1.2.3";
  request.components_along = "index";
  request.time_s = 0.5;
  request.crop = Box{{0, 0, 0}, {1, 2, 3}};
  request.layout = {.type = "int16",
                    .byte_order = "big",
                    .header_bytes = 8,
                    .axes = "xyz",
                    .components = "last",
                    .dims = {4, 5, 6},
                    .spacing_m = {1, 2, 3},
                    .origin_m = Vec3{-1, 0, 1}};
  Volume volume = sampled_head();
  volume.fields[0].name = "speed";
  const auto again = [&](const std::string& text) {
    std::optional<VolumeRequest> asked;
    const auto note = [&](const VolumeRequest& wanted) {
      asked = wanted;
      return volume;
    };
    std::string here = text;
    const std::string folder = testing::TempDir();
    for (const char* file : {"/file.xyz", "/other.q"}) {
      std::ofstream(folder + file) << "x";
      here.replace(here.find("/data" + std::string(file)), 5 + std::string(file).size(), folder + file);
    }
    parse_scene(here, "first.toml", {}, note, standard_modes());
    return *asked;
  };
  Scene code;
  code.add("fluid", Viscosity{.drag_ns_per_m = 1.0});
  Volume read = volume;
  read.files = {{"/data/file.xyz", 1, "0"}, {"/data/other.q", 1, "0"}};
  read.request = std::make_shared<const VolumeRequest>(request);
  code.add("data", read);
  for (const std::string& text : {first_scene(volume, request), to_toml(code)}) {
    SCOPED_TRACE(text);
    const VolumeRequest asked = again(text);
    ASSERT_EQ(asked.files.size(), 2U);
    EXPECT_EQ(asked.files[1].filename(), "other.q");
    ASSERT_EQ(asked.fields.size(), 1U);
    EXPECT_EQ(asked.fields[0].name, "speed");
    EXPECT_EQ(asked.fields[0].array, "velocity magnitude");
    EXPECT_EQ(asked.fields[0].unit, "m/s");
    EXPECT_EQ(asked.series, request.series);
    EXPECT_EQ(asked.components_along, request.components_along);
    EXPECT_EQ(asked.time_s, request.time_s);
    ASSERT_TRUE(asked.crop);
    EXPECT_EQ(asked.crop->high_m, request.crop->high_m);
    EXPECT_EQ(asked.layout, request.layout);
  }
}

TEST(FirstScene, OfPartsOfACtAndOfSparseFlowsCanBeLoaded) {
  const auto volume = [](const std::string& unit, int components, const std::function<double(int)>& value) {
    const auto data = std::make_shared<std::vector<float>>();
    for (int n = 0; n < 20 * 20 * 20 * components; ++n) data->push_back(static_cast<float>(value(n)));
    Volume made;
    made.fields = {
        {"v", unit,
         grid_field({{20, 20, 20}, 1e-3 * Mat3::identity(), {}}, {VoxelType::float32, components, {data, data->data()}})}};
    return made;
  };
  EXPECT_THAT(scene_of(volume("HU", 1, [](int n) { return n % 1000; })), Not(HasSubstr("name = \"skin\"")));
  scene_of(volume("HU", 1, [](int n) { return -320 + n % 100; }));
  scene_of(volume("HU", 1, [](int n) { return -1000 + n % 701; }));
  scene_of(volume("", 1, [](int n) { return 1e6 + n % 2; }));
  scene_of(volume("", 1, [](int n) { return n % 4000 == 0 ? 1.0 : 0.0; }));
  // Eight of 8000 voxels move, and of one flow nothing but an outlier is much.
  const std::string sparse = scene_of(volume("", 3, [](int n) { return n % 3000 == 0 ? 2.0 : 0.0; }));
  EXPECT_THAT(sparse, HasSubstr("points = [[0.1, 0], [2, 1.2]"));
  scene_of(volume("", 3, [](int n) { return n == 0 ? 1e9 : 1e-6 * (n % 7); }));
}

TEST(FirstScene, OfMedicalDataShowsTheFace) {
  EXPECT_THAT(scene_of(sampled_head()), HasSubstr("\"anterior\""));
  EXPECT_THAT(scene_of(sphere_field()), HasSubstr("\"+z\""));
}

TEST(FirstScene, OfNothingToFeelIsRefused) {
  const auto zeros = std::make_shared<std::vector<float>>(27, 4.0F);
  Volume flat;
  flat.fields = {{"flat", "", grid_field({{3, 3, 3}, Mat3::identity(), {}}, {VoxelType::float32, 1, {zeros, zeros->data()}})}};
  EXPECT_THROW(scene_of(flat), LoadError);
}

TEST(FirstScene, LooksAtVectorsFirstAndLeavesOutWhatIsConstant) {
  Volume volume = ring_vortex();
  std::vector<Statistics> values;
  for (const VolumeField& field : volume.fields) values.push_back(statistics(*field.field));
  const auto chosen = field_to_feel(volume, values);
  ASSERT_TRUE(chosen);
  EXPECT_EQ(volume.fields[*chosen].field->components(), 3);
  for (Statistics& v : values) v.min = v.max = 0.0;
  EXPECT_FALSE(field_to_feel(volume, values));
}

const Box unit_box{{0, 0, 0}, {1, 1, 1}};

TEST(Reach, IsAllOfTheBoxWhereItsMiddleCanBeFelt) {
  const auto reach = detail::reach_with(
      unit_box, [](const Vec3&) { return true; }, 0.5);
  EXPECT_TRUE(reach.whole);
  EXPECT_EQ(reach.side_m, 1.0);
  EXPECT_EQ(reach.centre_m, (Vec3{0.5, 0.5, 0.5}));
  EXPECT_TRUE(detail::reach_with(
                  unit_box, [](const Vec3&) { return false; }, 0.5)
                  .whole)
      << "nothing to find";
}

TEST(Reach, FindsASmallObjectInACorner) {
  const Vec3 centre_m{0.75, 0.25, 0.25};
  const auto ball = [&](const Vec3& x) { return distance(x, centre_m) < 0.15; };
  const auto reach = detail::reach_with(unit_box, ball, 0.5);
  EXPECT_FALSE(reach.whole);
  EXPECT_LT(distance(reach.centre_m, centre_m), 0.03);
  EXPECT_GE(reach.share, 0.5);
  EXPECT_GT(reach.side_m, 0.4) << "twice the cube of which a half is ball";
  EXPECT_LT(reach.side_m, 0.7);
}

TEST(Reach, MeetsTheSurfaceFromTheUsersSide) {
  const auto ball = [&](const Vec3& x) { return distance(x, {0.5, 0.5, 0.5}) < 0.3; };
  const auto reach = detail::reach_with(unit_box, ball, 0.3);
  EXPECT_LT(distance(detail::surface_before(reach, unit_box, {0, 0, 1}, ball), {0.5, 0.5, 0.8}), 0.02);
}

}  // namespace
}  // namespace palpa::test
