// Statistics of a field's values, against sums over voxels and histograms of known parts.
#include "palpa/data/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "palpa/data/analytic.h"

namespace palpa {
namespace statistics_test {

template <class T>
FieldPtr grid_of_values(const std::vector<T>& values, std::array<std::int64_t, 3> dims, VoxelType type, int components = 1,
                        double scale = 1.0, double offset = 0.0) {
  auto data = std::make_shared<std::vector<T>>(values);
  const std::shared_ptr<const void> bytes(data, data->data());
  return grid_field({dims, Mat3::identity(), {}}, {type, components, bytes}, scale, offset);
}

TEST(Statistics, AreThoseOfTheVoxels) {
  std::mt19937 random(3);
  std::vector<std::int16_t> raw(20 * 11 * 7);
  for (auto& v : raw) v = static_cast<std::int16_t>(std::uniform_int_distribution(-900, 2500)(random));
  raw[1234] = 3000;
  const Statistics s = statistics(*grid_of_values(raw, {20, 11, 7}, VoxelType::int16, 1, 0.5, -7.0));
  double mean = 0.0, squares = 0.0, zeros = 0;
  for (const auto v : raw) mean += (0.5 * v - 7.0) / static_cast<double>(raw.size()), zeros += 0.5 * v - 7.0 == 0.0;
  for (const auto v : raw) squares += std::pow(0.5 * v - 7.0 - mean, 2.0) / static_cast<double>(raw.size());
  EXPECT_EQ(s.counted, 1540);
  EXPECT_EQ(s.one_in, 1);
  EXPECT_EQ(s.zeros, zeros);
  EXPECT_NEAR(s.mean, mean, 1e-9);
  EXPECT_NEAR(s.deviation, std::sqrt(squares), 1e-9);
  EXPECT_EQ(s.max, 1493.0);
  EXPECT_EQ(s.max_at, (GridPoint{1234 % 20, 1234 / 20 % 11, 1234 / 220}));
  EXPECT_EQ(s.histogram.total(), 1540);
  EXPECT_EQ(s.histogram.low, s.min);
  EXPECT_EQ(s.histogram.high, s.max);
  EXPECT_EQ(s.histogram.in_classes(10).total(), 1540);
  EXPECT_FALSE(s.whole_numbers);
  EXPECT_NEAR(s.histogram.percentile(0.5), 0.5 * 800 - 7.0, 40.0);
  EXPECT_NEAR(s.histogram.share_between(-1e9, 1e9), 1.0, 1e-12);
}

TEST(Statistics, PercentilesAreExactOfWholeNumbersAndOfZeros) {
  std::vector<std::int16_t> whole(1000);
  for (std::size_t n = 0; n < 1000; ++n) whole[n] = static_cast<std::int16_t>(n < 600 ? -5 : 2 * n);
  const Statistics s = statistics(*grid_of_values(whole, {10, 10, 10}, VoxelType::int16));
  EXPECT_EQ(s.percentile(0.5), -5.0);
  EXPECT_EQ(s.percentile(0.9), 2.0 * 899);
  EXPECT_EQ(s.percentile(1.0), 2.0 * 999);
  for (std::size_t n = 0; n < 1000; ++n) whole[n] = static_cast<std::int16_t>(n < 600 ? 0 : n);
  const double zero = statistics(*grid_of_values(whole, {10, 10, 10}, VoxelType::int16)).percentile(0.5);
  EXPECT_EQ(zero, 0.0);
  EXPECT_FALSE(std::signbit(zero));
  std::vector<float> parts(1000, 0.0F);
  for (std::size_t n = 0; n < 400; ++n) parts[n] = 0.001F + 0.01F * static_cast<float>(n);
  const Statistics t = statistics(*grid_of_values(parts, {10, 10, 10}, VoxelType::float32));
  EXPECT_EQ(t.percentile(0.5), 0.0);
  EXPECT_NEAR(t.percentile(0.8), 0.01 * 200, 0.011);
}

TEST(Statistics, OfVectorsAreThoseOfTheirLengths) {
  const Statistics s =
      statistics(*grid_of_values<float>({3, 4, 0, 0, 0, 0, 0, -2, 0, 1, 2, 2}, {2, 2, 1}, VoxelType::float32, 3));
  EXPECT_EQ(s.counted, 4);
  EXPECT_EQ(s.zeros, 1);
  EXPECT_EQ(s.max, 5.0);
  EXPECT_EQ(s.max_at, (GridPoint{0, 0, 0}));
  EXPECT_NEAR(s.mean, 2.5, 1e-12);
}

TEST(Statistics, LeaveOutWhatIsNotFinite) {
  const float nan = std::nanf("");
  const Statistics s = statistics(*grid_of_values<float>({nan, 2, 4, nan}, {4, 1, 1}, VoxelType::float32));
  EXPECT_EQ(s.counted, 2);
  EXPECT_EQ(s.mean, 3.0);
  const Statistics none = statistics(*grid_of_values<float>({nan, nan}, {2, 1, 1}, VoxelType::float32));
  EXPECT_EQ(none.counted, 0);
  EXPECT_FALSE(dividing_value(none.histogram, -1, 1));
}

TEST(Statistics, OfManyVoxelsAreThoseOfSomeRows) {
  std::vector<std::uint8_t> raw(64 * 64 * 64);
  std::mt19937 random(5);
  for (auto& v : raw) v = static_cast<std::uint8_t>(random() % 200);
  const FieldPtr field = grid_of_values(raw, {64, 64, 64}, VoxelType::uint8);
  const Statistics all = statistics(*field), some = statistics(*field, 20000);
  EXPECT_EQ(some.one_in, 14);
  EXPECT_NEAR(static_cast<double>(some.counted), 64.0 * 64 * 64 / 14, 128);
  EXPECT_NEAR(some.mean, all.mean, 3.0);
}

// Also where the number of rows in a slice is a multiple of the step: a constant one would stay within a plane of the grid.
TEST(Statistics, OfSomeRowsKnowABallWhateverTheStep) {
  constexpr int n = 64;
  std::vector<std::uint8_t> raw;
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) raw.push_back(std::hypot(i - 31.5, j - 31.5, k - 31.5) < 28.0 ? 100 : 0);
  const FieldPtr field = grid_of_values(raw, {n, n, n}, VoxelType::uint8);
  const double mean = statistics(*field).mean;
  for (const int step : {2, 3, 8, 13, 16, 32, 63, 64}) {
    const Statistics some = statistics(*field, n * n * n / step);
    EXPECT_NEAR(some.mean, mean, 0.15 * mean) << step;
    EXPECT_EQ(some.max, 100.0) << step;
    const GridView& grid = *grid_behind(*field);
    EXPECT_EQ(preview_grid_field(grid.geometry, grid.voxels, 1.0, 0.0, step)->value_ranges()[0].max, 100.0) << step;
  }
}

// For any storage: small types are counted in a table, others one by one.
TEST(Statistics, AreTheSameOfTheSameNumbers) {
  std::mt19937 random(7);
  std::vector<std::int16_t> shorts(90 * 41 * 33);
  for (auto& v : shorts) v = static_cast<std::int16_t>(std::uniform_int_distribution(-32768, 32767)(random));
  shorts[5000] = shorts[5001] = 0;
  const std::vector<float> floats(shorts.begin(), shorts.end());
  for (const double scale : {1.0, 0.37, -2.5}) {
    for (const std::int64_t most : {std::int64_t{1} << 24, std::int64_t{20000}}) {
      const Statistics a = statistics(*grid_of_values(shorts, {90, 41, 33}, VoxelType::int16, 1, scale, 3.0), most);
      const Statistics b = statistics(*grid_of_values(floats, {90, 41, 33}, VoxelType::float32, 1, scale, 3.0), most);
      EXPECT_EQ(a.counted, b.counted);
      EXPECT_EQ(a.zeros, b.zeros);
      EXPECT_EQ(a.one_in, b.one_in);
      EXPECT_EQ(a.min, b.min);
      EXPECT_EQ(a.max, b.max);
      EXPECT_EQ(a.max_at, b.max_at);
      EXPECT_EQ(a.whole_numbers, b.whole_numbers);
      EXPECT_EQ(a.histogram.counts, b.histogram.counts);
      EXPECT_NEAR(a.mean, b.mean, 1e-9 * (b.max - b.min));
      EXPECT_NEAR(a.deviation, b.deviation, 1e-9 * b.deviation);
    }
  }
}

TEST(Statistics, OfAFormulaAreOfPlacesOverItsBox) {
  const Statistics s = statistics(*sphere_field().fields[0].field);
  EXPECT_GT(s.counted, 100000);
  EXPECT_LT(s.min, 0.0);
  EXPECT_GT(s.max, 0.0);
}

TEST(DividingValue, LiesBetweenTwoClasses) {
  std::mt19937 random(7);
  std::vector<float> raw;
  for (int n = 0; n < 8000; ++n) raw.push_back(std::normal_distribution<float>(10, 2)(random));
  for (int n = 0; n < 4000; ++n) raw.push_back(std::normal_distribution<float>(50, 4)(random));
  const Statistics s = statistics(*grid_of_values(raw, {120, 10, 10}, VoxelType::float32));
  const auto value = dividing_value(s.histogram, s.min, s.max);
  ASSERT_TRUE(value);
  EXPECT_GT(*value, 18.0);
  EXPECT_LT(*value, 36.0);
  EXPECT_NEAR(s.histogram.mean_between(s.min, *value), 10.0, 0.5);
  EXPECT_NEAR(s.histogram.mean_between(*value, s.max), 50.0, 0.5);
}

TEST(DividingValue, OfTwoValuesIsTheirMiddle) {
  const Statistics s = statistics(*grid_of_values<std::uint8_t>({0, 0, 0, 10}, {4, 1, 1}, VoxelType::uint8));
  EXPECT_NEAR(dividing_value(s.histogram, 0, 10).value(), 5.0, 0.01);
  const Statistics one = statistics(*grid_of_values<std::uint8_t>({4, 4}, {2, 1, 1}, VoxelType::uint8));
  EXPECT_FALSE(dividing_value(one.histogram, 0, 10));
}

TEST(LooksLike, HounsfieldUnitsAndDirections) {
  EXPECT_TRUE(looks_like_hounsfield(statistics(*head_phantom().fields[0].field), "HU"));
  EXPECT_TRUE(looks_like_hounsfield(statistics(*head_phantom().fields[0].field), ""));
  EXPECT_FALSE(looks_like_hounsfield(statistics(*head_phantom().fields[0].field), "K"));
  EXPECT_FALSE(looks_like_hounsfield(statistics(*sphere_field().fields[0].field), ""));
  EXPECT_TRUE(looks_like_directions(
      statistics(*grid_of_values<float>({1, 0, 0, 0, 0, 0, 0, 0.6F, 0.8F}, {3, 1, 1}, VoxelType::float32, 3))));
  EXPECT_FALSE(looks_like_directions(
      statistics(*grid_of_values<float>({1, 0, 0, 0, 0.5F, 0, 0, 0.6F, 0.8F}, {3, 1, 1}, VoxelType::float32, 3))));
}

}  // namespace statistics_test
}  // namespace palpa
