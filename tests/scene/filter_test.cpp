// The keys `filter` and `sign` of a volume.
#include "palpa/data/filter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <memory>
#include <vector>

#include "palpa/data/axis_grid.h"
#include "palpa/data/grid.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "tests/scene/scene_files.h"

namespace palpa {
namespace filter_test {

using testing::HasSubstr;

template <class T>
FieldPtr cube(VoxelType type, int components = 1) {
  constexpr std::int64_t n = 8;
  const auto voxels = std::make_shared<std::vector<T>>();
  for (std::int64_t v = 0; v < components * n * n * n; ++v) voxels->push_back(static_cast<T>(v % 251));
  return grid_field({{n, n, n}, 0.01 * Mat3::identity(), {}}, {type, components, {voxels, voxels->data()}});
}
/// A volume "ct" of integers, "mr" of fractions, "both" of each, "dti" of vectors.
Volume read_grids(const VolumeRequest& request) {
  const std::string name = request.files.front().filename().string();
  Volume volume;
  volume.format = "test";
  volume.files = {{request.files.front().string(), 1, "0"}};
  if (name != "mr" && name != "dti") volume.fields.push_back({"counts", "", cube<std::int16_t>(VoxelType::int16)});
  if (name == "mr" || name == "both") volume.fields.push_back({"signal", "", cube<float>(VoxelType::float32)});
  if (name == "dti") volume.fields.push_back({"axis", "", cube<float>(VoxelType::float32, 3)});
  return volume;
}

class FilterKey : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* name : {"ct", "mr", "both", "dti"}) std::ofstream(folder_ / name) << "x";
  }
  static std::string text(const std::string& body) {
    return "palpa = 1\n[volume.v]\n" + body + "\n[[mode]]\nname = 'm'\ntype = 'viscosity'\ndrag_ns_per_m = 1\n";
  }
  LoadedScene load(const std::string& body, const SceneOptions& options = {}) const {
    return parse_scene(text(body), "s.toml", folder_, read_grids, standard_modes(), options);
  }
  std::string error(const std::string& body) const {
    try {
      load(body);
    } catch (const LoadError& error) {
      return error.what();
    }
    return "no error";
  }
  static Filter filter_of(const Scene& scene, std::size_t field = 0) {
    return grid_below(*scene.volumes().front().volume.fields[field].field)->filter;
  }
  std::filesystem::path folder_ = testing::TempDir();
};

TEST_F(FilterKey, IsSmoothForScansCubicForFormulasAndTrilinearForVectorsByDefault) {
  EXPECT_EQ(filter_of(load("file = 'ct'").scene), Filter::smooth);
  EXPECT_EQ(filter_of(load("file = 'mr'").scene), Filter::smooth);
  EXPECT_EQ(filter_of(load("file = 'both'").scene, 0), Filter::smooth);
  EXPECT_EQ(filter_of(load("file = 'both'").scene, 1), Filter::smooth);
  EXPECT_EQ(filter_of(load("file = 'dti'").scene), Filter::trilinear);
  EXPECT_EQ(filter_of(load("analytic = 'sphere'\nsampled = 8").scene), Filter::cubic);
  Scene scene;
  scene.add("ct", read_grids({.files = {"ct"}}));
  EXPECT_EQ(filter_of(scene), Filter::smooth);
  Scene plain;
  plain.add("ct", read_grids({.files = {"ct"}}), Similarity{.scale = 2.0}, Filter::trilinear);
  EXPECT_EQ(filter_of(plain), Filter::trilinear);
}

TEST_F(FilterKey, IsWhatItSaysUnderAPoseAndBySet) {
  EXPECT_EQ(filter_of(load("file = 'ct'\nfilter = 'trilinear'").scene), Filter::trilinear);
  EXPECT_EQ(filter_of(load("file = 'mr'\nfilter = 'smooth'\npose = {scale = 2}").scene), Filter::smooth);
  EXPECT_EQ(filter_of(load("file = 'mr'\nfilter = 'cubic'").scene), Filter::cubic);
  EXPECT_EQ(filter_of(load("analytic = 'sphere'\nsampled = 8\nfilter = 'cubic'").scene), Filter::cubic);
  EXPECT_EQ(filter_of(load("file = 'ct'", {.sets = {{"volume.v.filter", "trilinear"}}}).scene), Filter::trilinear);
}

TEST_F(FilterKey, SaysWhereAndWhyItDoesNotFit) {
  EXPECT_THAT(error("file = 'ct'\nfilter = 'cubic'"),
              testing::AllOf(testing::StartsWith("s.toml:4:10: "), HasSubstr("'counts'"), HasSubstr("int16"),
                             HasSubstr("amplify the steps"), HasSubstr("smooth")));
  EXPECT_THAT(error("file = 'ct'\nfilter = 'cubicle'"),
              HasSubstr("s.toml:4:10: 'filter' in volume 'v' cannot be 'cubicle'; did"));
  EXPECT_THAT(error("analytic = 'sphere'\nfilter = 'smooth'"),
              HasSubstr("s.toml:4:10: 'filter' in volume 'v' speaks of voxels"));
  EXPECT_THAT(error("analytic = 'lamb_oseen_vortex'\nsign = 'none'"), HasSubstr("s.toml:4:8: 'sign' in volume 'v' speaks of"));
  EXPECT_THAT(error("file = 'ct'\nsign = 'none'"), HasSubstr("s.toml:4:8: volume 'v': it has no vector field"));
  EXPECT_THAT(error("file = 'dti'\nsign = 'none'\nfilter = 'cubic'"),
              testing::AllOf(HasSubstr("s.toml:5:10: "), HasSubstr("axes cannot be met by a cubic")));
  Scene scene;
  try {
    scene.add("ct", read_grids({.files = {"ct"}}), Similarity{}, Filter::cubic);
    ADD_FAILURE() << "no error";
  } catch (const SceneError& error) {
    EXPECT_THAT(error.what(), HasSubstr("scene: volume 'ct'"));
  }
}

TEST_F(FilterKey, SurvivesBeingPrinted) {
  for (const char* body :
       {"file = 'ct'", "file = 'ct'\nfilter = 'trilinear'", "file = 'both'\nfilter = 'smooth'", "file = 'mr'\nfilter = 'cubic'",
        "file = 'dti'\nsign = 'none'", "file = 'dti'\nfilter = 'smooth'\nsign = 'none'"}) {
    const Scene scene = load(body).scene;
    const std::string printed = to_toml(scene);
    const Scene again = parse_scene(printed, "t.toml", folder_, read_grids, standard_modes()).scene;
    EXPECT_TRUE(scene == again) << printed;
    EXPECT_EQ(filter_of(again), filter_of(scene));
  }
  // Made by a program, from files.
  const auto printed = [&](const char* file, std::optional<Filter> filter, bool axes) {
    Scene scene;
    Volume volume = read_grids({.files = {folder_ / file}});
    scene.add("v", axes ? signless(volume) : volume, Similarity{}, filter);
    return to_toml(scene);
  };
  EXPECT_THAT(printed("ct", {}, false), testing::Not(HasSubstr("filter")));
  EXPECT_THAT(printed("ct", Filter::smooth, false), testing::Not(HasSubstr("filter")));
  EXPECT_THAT(printed("ct", Filter::trilinear, false), HasSubstr("filter = \"trilinear\"\n"));
  EXPECT_THAT(printed("both", Filter::smooth, false), testing::Not(HasSubstr("filter")));
  EXPECT_THAT(printed("both", Filter::trilinear, false), HasSubstr("filter = \"trilinear\"\n"));
  EXPECT_THAT(printed("mr", Filter::cubic, false), HasSubstr("filter = \"cubic\"\n"));
  EXPECT_THAT(printed("dti", {}, true), HasSubstr("sign = \"none\"\n"));
}

TEST_F(FilterKey, TheSameVoxelsOfAProgramAreTheSameScene) {
  const Volume volume = read_grids({.files = {"ct"}});
  Volume code = volume;
  code.files.clear();
  Scene a, b, c;
  a.add("v", code);
  b.add("v", code);
  c.add("v", code, Similarity{}, Filter::trilinear);
  EXPECT_TRUE(a == b);
  EXPECT_FALSE(a == c);
}

TEST_F(FilterKey, SignNoneMakesAxesWhoseMagnitudeIsAStrength) {
  const Scene scene = load("file = 'dti'\nsign = 'none'").scene;
  EXPECT_TRUE(is_axis_field(*scene.field({"v"}).field));
  const Vec3 x{0.033, 0.027, 0.041};
  EXPECT_EQ(scene.field({"magnitude(v)"}).field->scalar(x).value, norm(scene.field({"v"}).field->vector(x).value));
  EXPECT_THAT(error("file = 'dti'\nsign = 'none'\n[[mode]]\nname = 'w'\ntype = 'gradient_force'\nfield = 'divergence(v)'\n"),
              HasSubstr("divergence cannot be taken of axes"));
}

TEST_F(FilterKey, ThinPartsThatAreLostAreWarnedOfWhereThatIsAskedFor) {
  // A plate of one voxel: 4/6 of its value is left.
  const auto plate = [](const VolumeRequest&) {
    constexpr std::int64_t n = 8;
    const auto voxels = std::make_shared<std::vector<std::int16_t>>(n * n * n, std::int16_t{0});
    for (std::int64_t v = 0; v < n * n; ++v) (*voxels)[3 * n * n + v] = 900;
    Volume volume;
    volume.fields = {
        {"f", "", grid_field({{n, n, n}, 0.01 * Mat3::identity(), {}}, {VoxelType::int16, 1, {voxels, voxels->data()}})}};
    return volume;
  };
  const auto loaded = [&](const std::string& filter, const std::string& solid, int level, bool asked) {
    const std::string scene = "palpa = 1\n[volume.v]\nfile = 'ct'\n" + filter +
                              "\n[[mode]]\nname = 's'\ntype = 'surface_and_friction'\nfield = 'v'\nsolid = '" + solid +
                              "'\n[[mode.level]]\nvalue = " + std::to_string(level) + "\nstrength_n = 1\n";
    return parse_scene(scene, "s.toml", folder_, plate, standard_modes(), {.thin_parts = asked});
  };
  const auto warnings = [&](auto&&... scene) { return loaded(scene...).warnings; };
  const auto notes = [&](auto&&... scene) { return loaded(scene...).notes; };
  ASSERT_EQ(warnings("", "high", 700, true).size(), 1U);
  EXPECT_THAT(warnings("", "high", 700, true)[0], testing::AllOf(testing::StartsWith("s.toml:11:9: "),
                                                                 HasSubstr("loses 100 % of the parts thinner than 2 voxels")));
  EXPECT_EQ(warnings("", "both", 700, true).size(), 1U);
  EXPECT_TRUE(warnings("", "high", 700, false).empty());
  EXPECT_TRUE(warnings("", "high", 500, true).empty());
  EXPECT_TRUE(warnings("", "low", 700, true).empty());
  EXPECT_TRUE(warnings("filter = 'trilinear'", "high", 700, true).empty());
  EXPECT_TRUE(notes("", "high", 700, true).empty());
  EXPECT_TRUE(notes("filter = 'trilinear'", "high", 700, true).empty());
  EXPECT_TRUE(notes("filter = 'smooth'", "high", 500, true).empty());
  EXPECT_TRUE(notes("filter = 'smooth'", "high", 700, false).empty());
  EXPECT_TRUE(warnings("filter = 'smooth'", "high", 700, true).empty()) << "the scene names its filter";
  EXPECT_THAT(notes("filter = 'smooth'", "high", 700, true),
              testing::ElementsAre(HasSubstr("loses 100 % of the parts thinner than 2 voxels")));
}

// The shell of one voxel of a label map has few holes after the filter, 1.6 % of it, but a hand falls through each.
TEST_F(FilterKey, HolesInAShellOfOneVoxelAreWarnedOf) {
  const auto shell = [](double thickness) {
    return [thickness](const VolumeRequest&) {
      constexpr std::int64_t n = 48;
      const auto voxels = std::make_shared<std::vector<std::int16_t>>(n * n * n, std::int16_t{0});
      for (std::int64_t v = 0; v < n * n * n; ++v) {
        const auto from_middle = [](std::int64_t i) { return static_cast<double>(i) - 0.5 * (n - 1); };
        const double r = norm(Vec3{from_middle(v % n), from_middle(v / n % n), from_middle(v / (n * n))});
        if (std::abs(r - 20.0) <= 0.5 * thickness) (*voxels)[static_cast<std::size_t>(v)] = 100;
      }
      Volume volume;
      volume.fields = {
          {"f", "", grid_field({{n, n, n}, 0.001 * Mat3::identity(), {}}, {VoxelType::int16, 1, {voxels, voxels->data()}})}};
      return volume;
    };
  };
  const std::string scene =
      "palpa = 1\n[volume.v]\nfile = 'ct'\n[[mode]]\nname = 's'\ntype = 'surface_and_friction'\nfield = 'v'\nsolid = 'both'\n"
      "[[mode.level]]\nvalue = 50\nstrength_n = 1\n";
  const auto warnings = [&](double thickness) {
    return parse_scene(scene, "s.toml", folder_, shell(thickness), standard_modes(), {.thin_parts = true}).warnings;
  };
  EXPECT_THAT(warnings(1.0), testing::Contains(HasSubstr("of the parts thinner than 2 voxels there")));
  EXPECT_THAT(warnings(3.0), testing::Not(testing::Contains(HasSubstr("thinner than 2 voxels"))));
}

}  // namespace filter_test
}  // namespace palpa
