// Pictures of data: tissues of a head, labels, directions by their axis.
#include "palpa/view/volume_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <vector>

#include "palpa/data/grid.h"
#include "palpa/data/volume.h"
#include "palpa/scene/scene.h"
#include "palpa/view/canvas.h"
#include "palpa/view/layers.h"

namespace palpa {
namespace volume_picture_test {

constexpr std::int64_t side = 64;

/// A volume of cubes of 3 mm in a patient's frame, by a function of the position from its middle [mm].
template <class Number, class Value>
Volume volume_of(VoxelType type, int components, const std::string& unit, Value&& value) {
  const auto raw = std::make_shared<std::vector<Number>>();
  for (std::int64_t k = 0; k < side; ++k)
    for (std::int64_t j = 0; j < side; ++j)
      for (std::int64_t i = 0; i < side; ++i) {
        const auto mm = [](std::int64_t n) { return 3.0 * (static_cast<double>(n) - 31.5); };
        for (const double number : value(Vec3{mm(i), mm(j), mm(k)})) raw->push_back(static_cast<Number>(number));
      }
  const GridGeometry grid{{side, side, side}, 3e-3 * Mat3::identity(), {}};
  Volume volume;
  volume.medical_frame = true;
  volume.fields = {{"value", unit, grid_field(grid, {type, components, {raw, raw->data()}})}};
  return volume;
}

using Colour = std::array<int, 3>;

/// Colours that fill a part of the picture, with their numbers of pixels.
std::map<Colour, int> colours_of(const Volume& volume) {
  const Statistics values = statistics(*volume.fields[0].field);
  const Picture picture = volume_picture(volume, 0, values, "test");
  std::map<Colour, int> counts;
  for (std::size_t p = 0; p + 2 < picture.rgb.size(); p += 3)
    ++counts[{picture.rgb[p], picture.rgb[p + 1], picture.rgb[p + 2]}];
  std::erase_if(counts, [](const auto& entry) { return entry.second < 5000; });
  return counts;
}

TEST(FieldNames, AreGenericWhereTheySayTheKindAlone) {
  for (const char* name : {"value", "values", "Scalars_", "vectors", "vector2", "ImageScalars"})
    EXPECT_TRUE(detail::is_generic_name(name)) << name;
  for (const char* name : {"eigenvalue", "eigenvector1", "scalar_dissipation", "velocity", "s", ""})
    EXPECT_FALSE(detail::is_generic_name(name)) << name;
}

TEST(VolumePicture, ShowsGreyAndWhiteMatterApart) {
  const Volume head = volume_of<std::int16_t>(VoxelType::int16, 1, "HU", [](const Vec3& mm) {
    const double r = norm(mm);
    return std::array{r > 85.0 ? -1000.0 : r > 78.0 ? 900.0 : mm.x < 0.0 ? 28.0 : 40.0};
  });
  const auto colours = colours_of(head);
  // 12 of the 80 HU from black to white; a window of all values has 1 in 200 of them.
  int pairs = 0;
  for (const auto& [dark, unused] : colours) {
    for (const auto& [light, unused_too] : colours) {
      const bool grey = dark[0] == dark[2] && light[0] == light[2];
      pairs += grey && std::abs(light[0] - dark[0] - 0.15 * 230) < 6.0 && dark[0] > 40 && light[0] < 200;
    }
  }
  EXPECT_GT(pairs, 0);
}

TEST(VolumePicture, ShowsLabelsAsTheyAre) {
  const Volume labels = volume_of<std::uint8_t>(VoxelType::uint8, 1, "", [](const Vec3& mm) {
    return std::array{norm(mm) > 80.0 ? 0.0 : mm.x < 0.0 ? 2.0 : 9.0};
  });
  int coloured = 0;
  for (const auto& [colour, count] : colours_of(labels)) coloured += colour[0] != colour[1] || colour[1] != colour[2];
  EXPECT_EQ(coloured, 2) << "nothing lies between 2 and 9";
}

TEST(VolumePicture, ShowsDirectionsByTheirAxis) {
  const Volume directions = volume_of<float>(VoxelType::float32, 3, "", [](const Vec3& mm) {
    const double sign = std::fmod(std::abs(mm.y) / 3.0, 2.0) < 1.0 ? 1.0 : -1.0;
    return mm.x < 0.0 ? std::array{sign, 0.0, 0.0} : std::array{0.0, 0.0, sign};
  });
  const auto colours = colours_of(directions);
  EXPECT_TRUE(colours.contains({255, 0, 0}));
  EXPECT_TRUE(colours.contains({0, 0, 255}));
  EXPECT_GT(colours.at({255, 0, 0}), 20000) << "whatever the signs of neighbours";
}

/// [1] Share of the coloured pixels of the streamlines' part of the picture that lie in its upper and lower quarter.
double colour_far_from_the_middle(const Volume& volume) {
  const Picture picture = volume_picture(volume, 0, statistics(*volume.fields[0].field), "test");
  const int left = picture.width_px / 2, right = left + picture.width_px * 3 / 8;
  const int top = picture.height_px * 6 / 10, bottom = picture.height_px;
  int all = 0, far = 0;
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      const std::uint8_t* p = &picture.rgb[3 * (static_cast<std::size_t>(y) * picture.width_px + x)];
      const auto [low, high] = std::minmax({p[0], p[1], p[2]});
      if (high - low < 40) continue;
      ++all;
      far += y < top + (bottom - top) / 4 || y > bottom - (bottom - top) / 4;
    }
  }
  EXPECT_GT(all, 300) << "no streamlines";
  return static_cast<double>(far) / std::max(1, all);
}

// Velocity MR: in unmeasured air the phase is noise over the whole velocity range.
TEST(VolumePicture, WritesLengthsInFileUnitsWhereNoUnitIsKnown) {
  Volume volume = volume_of<float>(VoxelType::float32, 1, "", [](const Vec3& mm) { return std::array{mm.x}; });
  volume.medical_frame = false;
  volume.length_unit = "mm";
  EXPECT_EQ(file_unit_m(volume), 0.0) << "the file says it";
  volume.length_unit_assumed = true;
  EXPECT_DOUBLE_EQ(file_unit_m(volume), 1e-3);
  Scene scene;
  EXPECT_EQ(file_unit_m(scene), 0.0) << "without data";
  scene.add("one", volume);
  EXPECT_DOUBLE_EQ(file_unit_m(scene), 1e-3);
  volume.length_unit_assumed = false;
  scene.add("other", volume);
  EXPECT_EQ(file_unit_m(scene), 0.0) << "one of them says it";
  volume.length_unit_assumed = true;
  volume.medical_frame = true;
  EXPECT_EQ(file_unit_m(volume), 0.0) << "a patient's are in millimetres";
  EXPECT_EQ(detail::length_words(0.02, 0.0, 1e-3), "20 file units");
  EXPECT_EQ(detail::length_words(0.02, 0.0, 0.0), "20 mm");
}

TEST(VolumePicture, ShowsNoStreamlinesOfNoise) {
  const auto jet_in = [](double noise) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> phase(-noise, noise);
    Volume volume = volume_of<float>(VoxelType::float32, 3, "", [&](const Vec3& mm) {
      if (std::hypot(mm.y, mm.z) < 18.0) return std::array{1.0, 0.0, 0.0};
      return std::array{phase(random), phase(random), phase(random)};
    });
    volume.medical_frame = false;
    return volume;
  };
  EXPECT_LT(colour_far_from_the_middle(jet_in(1e-6)), 0.02);
  EXPECT_LT(colour_far_from_the_middle(jet_in(1.5)), 0.02);
}

}  // namespace volume_picture_test
}  // namespace palpa
