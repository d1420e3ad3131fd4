// Histograms in classes of powers of two: equal of the whole and of merged parts.
#include "palpa/file/store_histogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

namespace palpa::detail {
namespace {

template <class T>
constexpr VoxelType type_of() {
  if (std::is_same_v<T, std::uint8_t>) return VoxelType::uint8;
  if (std::is_same_v<T, std::int16_t>) return VoxelType::int16;
  if (std::is_same_v<T, std::uint16_t>) return VoxelType::uint16;
  if (std::is_same_v<T, std::int32_t>) return VoxelType::int32;
  return std::is_same_v<T, float> ? VoxelType::float32 : VoxelType::float64;
}

template <class T>
DyadicHistogram histogram_of(const std::vector<T>& values, int components = 1) {
  const std::int64_t voxels = static_cast<std::int64_t>(values.size()) / components;
  VoxelBlock block{.size = {voxels, 1, 1}, .valid = {voxels, 1, 1}, .voxels = {}};
  block.voxels.resize(values.size() * sizeof(T));
  if (!values.empty()) std::memcpy(block.voxels.data(), values.data(), block.voxels.size());
  DyadicHistogram histogram;
  histogram.add({type_of<T>(), components}, block, {}, block.size);
  return histogram;
}

/// Numbers of many magnitudes.
template <class T>
std::vector<T> drawn(std::mt19937& random, std::size_t count) {
  std::vector<T> values(count);
  const double octave = std::uniform_real_distribution<double>(-60.0, 60.0)(random);
  for (T& value : values) {
    if constexpr (std::is_floating_point_v<T>) {
      value = static_cast<T>(std::ldexp(std::normal_distribution<double>(0.0, 1.0)(random), static_cast<int>(octave)));
    } else {
      value = static_cast<T>(random()) / static_cast<T>(1 + random() % 7);
    }
  }
  return values;
}

/// Counts by definition.
template <class T>
void expect_exact(const std::vector<T>& values, const DyadicHistogram& histogram) {
  const Histogram found = histogram.classes(false);
  ASSERT_LE(found.counts.size(), 256u);
  const double width = (found.high - found.low) / static_cast<double>(found.counts.size());
  EXPECT_EQ(std::ldexp(1.0, std::ilogb(width)), width);
  std::vector<std::int64_t> expected(found.counts.size());
  double low = INFINITY, high = -INFINITY;
  for (const T value : values) {
    if (!std::isfinite(static_cast<double>(value))) continue;
    low = std::min(low, static_cast<double>(value)), high = std::max(high, static_cast<double>(value));
    ++expected.at(static_cast<std::size_t>(std::floor(static_cast<double>(value) / width) - std::floor(found.low / width)));
  }
  EXPECT_EQ(found.counts, expected);
  if (found.counts.size() == 1 || (!std::is_floating_point_v<T> && width == 1.0)) return;
  EXPECT_GE(std::floor(high / (0.5 * width)) - std::floor(low / (0.5 * width)), 256.0) << "no narrower classes are enough";
}

template <class T>
void expect_any_parts_merge() {
  std::mt19937 random(5);
  for (int round = 0; round < 60; ++round) {
    std::vector<T> whole;
    std::vector<DyadicHistogram> parts;
    for (std::size_t part = 0; part < 1 + random() % 6; ++part) {
      const std::vector<T> values = drawn<T>(random, random() % 300);
      whole.insert(whole.end(), values.begin(), values.end());
      parts.push_back(histogram_of(values));
    }
    const DyadicHistogram expected = histogram_of(whole);
    if (!whole.empty()) expect_exact(whole, expected);
    for (int order = 0; order < 4; ++order) {
      std::shuffle(parts.begin(), parts.end(), random);
      // As a tree, from neighbours.
      std::vector<DyadicHistogram> left = parts;
      while (left.size() > 1) {
        const std::size_t n = random() % (left.size() - 1);
        left[n].merge(left[n + 1]);
        left.erase(left.begin() + static_cast<std::ptrdiff_t>(n) + 1);
      }
      EXPECT_EQ(left.front(), expected);
      EXPECT_EQ(left.front().numbers(), expected.numbers());
    }
    DyadicHistogram stored;
    EXPECT_TRUE(stored.take(expected.numbers()));
    EXPECT_EQ(stored, expected);
  }
}

TEST(DyadicHistograms, OfMergedPartsAreThoseOfTheWhole) {
  expect_any_parts_merge<std::uint8_t>();
  expect_any_parts_merge<std::int16_t>();
  expect_any_parts_merge<std::uint16_t>();
  expect_any_parts_merge<std::int32_t>();
  expect_any_parts_merge<float>();
  expect_any_parts_merge<double>();
}

TEST(DyadicHistograms, CountTheLengthsOfVectors) {
  std::mt19937 random(3);
  const std::vector<float> values = drawn<float>(random, 900);
  std::vector<double> lengths;
  for (std::size_t n = 0; n < values.size(); n += 3) {
    const double x = values[n], y = values[n + 1], z = values[n + 2];
    lengths.push_back(std::sqrt(x * x + y * y + z * z));
  }
  EXPECT_EQ(histogram_of(values, 3), histogram_of(lengths));
}

TEST(DyadicHistograms, HaveWholeNumbersInTheMiddleOfTheirClasses) {
  const Histogram few = histogram_of(std::vector<std::int16_t>{-3, 2, 2}).classes(true);
  EXPECT_EQ(few, (Histogram{-3.5, 2.5, {1, 0, 0, 0, 0, 2}}));
  const Histogram wide = histogram_of(std::vector<std::uint16_t>{0, 65535}).classes(true);
  EXPECT_EQ(wide.counts.size(), 256u);
  EXPECT_EQ(wide.high - wide.low, 65536.0);
}

TEST(DyadicHistograms, TakeAnyNumbers) {
  constexpr double huge = std::numeric_limits<double>::max(), tiny = std::numeric_limits<double>::denorm_min();
  for (const std::vector<double>& values : {std::vector<double>{},
                                            {NAN},
                                            {INFINITY, NAN},
                                            {0.0},
                                            {0.0, 0.0, 1.0},
                                            {huge, -huge},
                                            {huge},
                                            {-huge},
                                            {tiny, 0.0},
                                            {1e-310},
                                            {1.0, std::nextafter(1.0, 2.0)},
                                            {-tiny, huge}}) {
    const DyadicHistogram histogram = histogram_of(values);
    const Histogram found = histogram.classes(false);
    EXPECT_TRUE(std::isfinite(found.low) && std::isfinite(found.high) && found.low <= found.high);
    EXPECT_EQ(found.total(), std::ranges::count_if(values, [](double v) { return std::isfinite(v); }));
    DyadicHistogram stored, merged;
    EXPECT_TRUE(stored.take(histogram.numbers()));
    for (const double value : values) merged.merge(histogram_of(std::vector{value}));
    EXPECT_EQ(stored, histogram);
    EXPECT_EQ(merged, histogram);
  }
}

TEST(DyadicHistograms, OfFilesAreTakenOnlyIfTheyAreSound) {
  const DyadicHistogram::Numbers sound = histogram_of(std::vector<float>{1, 2, 3}).numbers();
  for (const auto& [place, number] :
       {std::pair{0, 0.5}, {0, 2000.0}, {0, NAN}, {1, 1e17}, {1, 0.1}, {2, -1.0}, {5, NAN}, {257, INFINITY}}) {
    DyadicHistogram::Numbers wrong = sound;
    wrong[static_cast<std::size_t>(place)] = number;
    DyadicHistogram histogram;
    EXPECT_FALSE(histogram.take(wrong));
    EXPECT_EQ(histogram, DyadicHistogram());
  }
}

}  // namespace
}  // namespace palpa::detail
