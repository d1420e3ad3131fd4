// Suggested scenes of volumes larger than memory: the numbers of octave 0, the places of the coarsest octave.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <random>
#include <regex>

#include "palpa/data/derived.h"
#include "palpa/data/octave_parts.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "palpa/scene/first_scene.h"
#include "palpa/scene/load_scene.h"
#include "tests/data/pyramid.h"

namespace palpa::test {
namespace first_octaves_test {

using testing::HasSubstr;
using testing::Not;

Volume in_octaves(const Volume& volume, int count) {
  Volume large = volume;
  for (VolumeField& field : large.fields) field.field = test::in_octaves(*field.field, count);
  return large;
}

/// The scene of a volume, which loads without a warning.
std::string scene_of(const Volume& volume) {
  const std::string file = testing::TempDir() + "/large.zarr";
  std::ofstream(file) << "x";
  VolumeRequest request;
  request.files = {file};
  request.memory_mb = 1.0;
  const std::string text = first_scene(volume, request);
  const LoadedScene loaded =
      parse_scene(text, "first.toml", {}, [&](const VolumeRequest&) { return volume; }, standard_modes(), {.thin_parts = true});
  EXPECT_TRUE(loaded.warnings.empty());
  return text;
}

double number_of(const std::string& text, const std::string& key, int which = 0) {
  const std::regex line("\n" + key + " = ([-0-9.e]+)");
  auto found = std::sregex_iterator(text.begin(), text.end(), line);
  for (int n = 0; n < which && found != std::sregex_iterator(); ++n) ++found;
  EXPECT_NE(found, std::sregex_iterator()) << key;
  return found == std::sregex_iterator() ? 0.0 : std::stod((*found)[1].str());
}

/// Whole numbers over a grid of 4 µm.
template <class T, class Value>
Volume volume_of(std::array<std::int64_t, 3> dims, VoxelType type, Value value) {
  const GridGeometry grid{dims, 4e-6 * Mat3::identity(), {}, {}};
  const std::shared_ptr<T[]> voxels(new T[static_cast<std::size_t>(grid.voxels())]);
  T* to = voxels.get();
  for (std::int64_t k = 0; k < dims[2]; ++k)
    for (std::int64_t j = 0; j < dims[1]; ++j)
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        const auto share = [](std::int64_t at, std::int64_t n) {
          return 2.0 * static_cast<double>(at) / static_cast<double>(n) - 1.0;
        };
        *to++ = static_cast<T>(std::lround(value(Vec3{share(i, dims[0]), share(j, dims[1]), share(k, dims[2])})));
      }
  Volume volume;
  volume.format = "zarr";
  volume.fields.push_back({"value", "", grid_field(grid, {type, 1, voxels})});
  return volume;
}

Volume porous_ball() {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 6.0);
  return volume_of<std::uint8_t>({224, 200, 208}, VoxelType::uint8, [random, noise](const Vec3& at) mutable {
    const bool pore = std::sin(60.0 * at.x) * std::sin(60.0 * at.y) * std::sin(60.0 * at.z) > 0.3;  // a few voxels wide
    const double value = norm(at) > 0.8 ? 30.0 : pore ? 40.0 : norm(at) < 0.4 ? 210.0 : 130.0;
    return std::clamp(value + noise(random), 0.0, 255.0);
  });
}

TEST(FirstSceneInOctaves, HasTheLevelsOfTheWhole) {
  const Volume whole = porous_ball();
  const std::string text = scene_of(in_octaves(whole, 4)), expected = scene_of(whole);
  for (const char* key : {"value", "strength_n"}) {
    for (const int n : {0, 1})
      EXPECT_NEAR(number_of(text, key, n), number_of(expected, key, n), 0.05 * std::abs(number_of(expected, key, n)));
  }
  EXPECT_NEAR(number_of(text, "scale"), number_of(expected, "scale"), 0.05 * number_of(expected, "scale"));
  for (const char* part : {"solid = \"high\"", "memory_mb = 1", "filter = \"smooth\"", "of a sample, loses"})
    EXPECT_THAT(text, HasSubstr(part));
}

TEST(FirstSceneInOctaves, SaysHowMuchOfTheHandAVoxelTakes) {
  const std::string text = scene_of(in_octaves(porous_ball(), 4));
  std::smatch found;
  ASSERT_TRUE(std::regex_search(
      text, found, std::regex("# A voxel takes ([0-9.]+) um of the hand, one of the coarsest octave, 3, ([0-9.]+) mm")));
  EXPECT_NEAR(std::stod(found[1]), 1e6 * 4e-6 / number_of(text, "scale"), 0.01 * std::stod(found[1]));
  EXPECT_NEAR(std::stod(found[2]), 8e-3 * std::stod(found[1]), 0.01 * std::stod(found[2]));
}

TEST(FirstSceneInOctaves, OfLabelsHasOneSurfaceAroundAll) {
  const Volume labels = volume_of<std::int16_t>({120, 120, 120}, VoxelType::int16, [](const Vec3& at) {
    return norm(at) > 0.8 ? 0.0 : at.x > 0.2 ? 7.0 : at.y > 0.0 ? 3.0 : 12.0;
  });
  const std::string text = scene_of(in_octaves(labels, 3));
  EXPECT_DOUBLE_EQ(number_of(text, "value"), 1.5);
  EXPECT_THAT(text, testing::AllOf(HasSubstr("labelled"), Not(HasSubstr("labels = {"))));
}

TEST(FirstSceneInOctaves, OfAFlowReadsNoFieldsOfAWholeGrid) {
  Volume flow = sampled(ring_vortex(), 96);
  flow.format = "zarr";
  const std::string text = scene_of(in_octaves(flow, 2)), expected = scene_of(flow);
  EXPECT_THAT(expected, HasSubstr("curl("));
  for (const char* part : {"curl(large", "q(large", "coherence(large", "sign ="}) EXPECT_THAT(text, Not(HasSubstr(part)));
  for (const char* part : {"type = \"follow\"", "type = \"vector_force\"", "type = \"viscosity\"", "magnitude(large"})
    EXPECT_THAT(text, HasSubstr(part));
}

/// A flow with its curl as `palpa prepare --derive curl=NAME` names it.
Volume with_curl(Volume flow) {
  const VolumeField& of = flow.fields[0];
  const FieldPtr curl = derived(Derivation::curl, of.field);
  const GridView& view = *smooth_grid_of(*curl);
  flow.fields.push_back({"curl_" + of.name, "", grid_field(view.geometry, view.voxels, view.scale, view.offset)});
  return flow;
}

TEST(FirstSceneInOctaves, OfAFlowWithItsCurlHasRailsWhereItTurns) {
  Volume flow = sampled(ring_vortex(), 96);
  flow.format = "zarr", flow.fields.resize(1);
  const std::string name = flow.fields[0].name;
  const std::string text = scene_of(in_octaves(with_curl(flow), 2)), expected = scene_of(flow);
  EXPECT_THAT(text, testing::AllOf(HasSubstr("type = \"follow\""), HasSubstr("magnitude(large.curl_" + name + ")"),
                                   HasSubstr("rails where it turns"), Not(HasSubstr("--derive")), Not(HasSubstr("curl("))));
  const auto turning_of = [](const std::string& scene, const std::string& curl) {
    const std::size_t begin = scene.find("magnitude(" + curl);
    EXPECT_NE(begin, std::string::npos);
    const std::string points = scene.substr(scene.find("[[", begin));
    const std::size_t second = points.find("[", 2);
    return std::pair(std::stod(points.substr(2)), std::stod(points.substr(second + 1)));
  };
  const auto [from, full] = turning_of(text, "large.curl_" + name);
  const auto [from_of_whole, full_of_whole] = turning_of(expected, "curl(");
  EXPECT_NEAR(from, from_of_whole, 0.1 * from_of_whole);
  EXPECT_NEAR(full, full_of_whole, 0.2 * full_of_whole);

  EXPECT_THAT(scene_of(in_octaves(flow, 2)),
              testing::AllOf(HasSubstr("# palpa prepare STORE --derive curl=" + name), HasSubstr("rails along it")));
}

TEST(FirstSceneInOctaves, OfDirectionsIsWithoutAKeyThatNeedsAWholeGrid) {
  Volume flow = sampled(ring_vortex(), 64);
  GridView grid = *grid_behind(*flow.fields[0].field);
  const auto* from = static_cast<const float*>(grid.voxels.data.get());
  const std::shared_ptr<float[]> units(new float[static_cast<std::size_t>(3 * grid.geometry.voxels())]);
  for (std::int64_t n = 0; n < grid.geometry.voxels(); ++n) {
    const Vec3 unit = normalized({from[3 * n], from[3 * n + 1], from[3 * n + 2]});
    units[3 * n] = static_cast<float>(unit.x), units[3 * n + 1] = static_cast<float>(unit.y),
              units[3 * n + 2] = static_cast<float>(unit.z);
  }
  flow.fields[0].field = grid_field(grid.geometry, {VoxelType::float32, 3, units});
  EXPECT_THAT(scene_of(in_octaves(flow, 2)), testing::AllOf(HasSubstr("type = \"follow\""), Not(HasSubstr("sign ="))));
}

TEST(FirstSceneInOctaves, OfOneValueHasNothingToFeel) {
  const Volume flat = volume_of<std::uint8_t>({64, 64, 64}, VoxelType::uint8, [](const Vec3&) { return 7.0; });
  EXPECT_THROW(scene_of(in_octaves(flat, 2)), LoadError);
}

}  // namespace first_octaves_test
}  // namespace palpa::test
