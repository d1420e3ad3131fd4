// Label maps: distinguished from images, and split into a field for each label.
#include "palpa/data/labels.h"

#include <cmath>
#include <stdexcept>

#include "palpa/data/filter.h"
#include "tests/data/test_fields.h"

namespace palpa {
namespace labels_test {

using namespace test;

constexpr int n = 40;
const GridGeometry grid{{n, n, n}, 0.001 * Mat3::identity(), {-0.0195, -0.0195, -0.0195}};

template <class T, class Value>
FieldPtr scalars(Value value, double scale = 1.0, double offset = 0.0) {
  std::vector<T> values;
  for (int at = 0; at < n * n * n; ++at)
    values.push_back(static_cast<T>(value(grid.to_world({double(at % n), double(at / n % n), double(at / n / n)}))));
  return grid_field(grid, voxels_of(std::move(values)), scale, offset);
}

/// A ball of 12 mm, half 41 and half 3, with a core of 5 mm, 7.
double parts(const Vec3& x) { return norm(x) > 0.012 ? 0.0 : norm(x) < 0.005 ? 7.0 : x.x > 0.0 ? 41.0 : 3.0; }

TEST(LabelMap, NamesItsPartsTheLargestFirst) {
  const LabelMap map = label_map(*scalars<std::uint8_t>(parts));
  ASSERT_EQ(map.labels.size(), 3U);
  EXPECT_EQ(map.background, 0.0);
  EXPECT_EQ(map.labels[2].value, 7.0);
  std::int64_t voxels[3] = {};
  for (int at = 0; at < n * n * n; ++at) {
    const double value = parts(grid.to_world({double(at % n), double(at / n % n), double(at / n / n)}));
    for (int l = 0; l < 3; ++l) voxels[l] += value == map.labels[static_cast<std::size_t>(l)].value;
  }
  for (int l = 0; l < 3; ++l) EXPECT_EQ(map.labels[static_cast<std::size_t>(l)].voxels, voxels[l]);
}

TEST(LabelMap, IsTheSameInAnyTypeAndAboutAnyBackground) {
  const LabelMap bytes = label_map(*scalars<std::uint8_t>(parts));
  for (const LabelMap& other : {label_map(*scalars<float>(parts)), label_map(*scalars<std::int16_t>(parts, 2.0, 100.0))}) {
    const bool scaled = other.background == 100.0;
    ASSERT_EQ(other.labels.size(), bytes.labels.size());
    for (std::size_t l = 0; l < other.labels.size(); ++l) {
      EXPECT_EQ(other.labels[l].value, scaled ? 2.0 * bytes.labels[l].value + 100.0 : bytes.labels[l].value);
      EXPECT_EQ(other.labels[l].voxels, bytes.labels[l].voxels);
    }
  }
}

TEST(LabelMap, IsNoImage) {
  std::mt19937 random(1);
  EXPECT_TRUE(label_map(*scalars<std::uint8_t>([&](const Vec3& x) {
                return norm(x) < 0.015 ? 100 + uniform(random, 0, 20) : 0;
              })).labels.empty())
      << "noise of 20 steps";
  EXPECT_TRUE(
      label_map(*scalars<std::uint8_t>([](const Vec3& x) { return 200.0 * std::exp(-norm_squared(x) / 1e-4); })).labels.empty())
      << "a slope";
  EXPECT_TRUE(label_map(*scalars<float>([](const Vec3& x) { return 0.5 * parts(x); })).labels.empty()) << "fractions";
  EXPECT_TRUE(label_map(*scalars<std::uint8_t>([](const Vec3&) { return 4; })).labels.empty()) << "nothing but background";
}

TEST(LabelMap, IsNoneWhereTheFileSaysOtherwise) {
  const FieldPtr field = scalars<std::uint8_t>(parts);
  const Statistics values = statistics(*field);
  for (const char* modality : {"", "SEG"})
    EXPECT_FALSE(label_map_unless_said(*field, values, "", modality).labels.empty()) << modality;
  for (const char* modality : {"CT", "MR", "PT", "NM", "US"})
    EXPECT_TRUE(label_map_unless_said(*field, values, "", modality).labels.empty()) << modality;
  EXPECT_TRUE(label_map_unless_said(*field, values, "K", "").labels.empty());
}

TEST(LabelField, IsOneInItsPartAndItsSurfaceIsThePartsOwn) {
  const FieldPtr core = label_field(*scalars<std::uint8_t>(parts), 7.0);
  EXPECT_EQ(core->value_ranges()[0], (ValueRange{0.0, 1.0}));
  const FieldPtr smooth = filtered(core, Filter::smooth);
  std::mt19937 random(2);
  double sum_m = 0.0;
  constexpr int ways = 500;
  for (int i = 0; i < ways; ++i) {
    const Vec3 out = normalized({uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)});
    double inside_m = 0.0, outside_m = 0.01;
    for (int step = 0; step < 40; ++step) {
      const double middle_m = 0.5 * (inside_m + outside_m);
      (smooth->scalar(middle_m * out).value > 0.5 ? inside_m : outside_m) = middle_m;
    }
    EXPECT_NEAR(inside_m, 0.005, 0.0008) << "within a voxel";
    sum_m += inside_m / ways;
  }
  EXPECT_NEAR(sum_m, 0.005, 0.0002);
}

TEST(LabelField, OfAllLabelsTogetherIsOneEverywhere) {
  const FieldPtr map = scalars<std::uint8_t>(parts);
  std::vector<FieldPtr> fields;
  for (const double value : {0.0, 3.0, 7.0, 41.0}) fields.push_back(label_field(*map, value));
  std::mt19937 random(3);
  for (int i = 0; i < 500; ++i) {
    const Vec3 x = within(random, map->bounds_m());
    double sum = 0.0;
    for (const FieldPtr& field : fields) sum += field->scalar(x).value;
    EXPECT_NEAR(sum, 1.0, 1e-12);
  }
}

TEST(LabelField, IsOfAGridOfNumbers) {
  EXPECT_THROW(label_field(*grid_field({{2, 2, 2}, Mat3::identity(), {}}, voxels_of(std::vector<float>(24), 3)), 1.0),
               std::invalid_argument);
}

}  // namespace labels_test
}  // namespace palpa
