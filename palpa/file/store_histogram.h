// Histograms of the fields of a store, of all voxels, in parts that are merged.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "palpa/data/statistics.h"
#include "palpa/file/octave_means.h"

namespace palpa::detail {

/// Counts of numbers in classes as wide as a power of two, which begin at multiples of it. The width is the least one, of whole
/// numbers at least 1, with which all numbers lie in 256 neighbouring classes: it follows from the least and the largest number
/// alone. So any parts, merged in any order, give the histogram of the whole. Of vectors their lengths are counted; values that
/// are not finite are left out.
class DyadicHistogram {
 public:
  static constexpr std::int64_t most_classes = 256;
  /// Exponent of the width, number of the first class, counts from it on: as they are stored.
  using Numbers = std::array<double, 2 + most_classes>;

  /// Adds a part of a block. \param low  [voxels] first of the part \param size  [voxels] of it; voxels that do not exist are
  /// left out
  void add(const VoxelKind& kind, const VoxelBlock& block, const VoxelIndex& low, const VoxelIndex& size);
  void merge(const DyadicHistogram& other) noexcept;

  Numbers numbers() const noexcept;
  /// Takes numbers that a file had. Returns false, and takes none, if they are no histogram.
  bool take(const Numbers& numbers) noexcept;

  /// From the first class with a count to the last. \param is_whole  of whole numbers: each class has its number in its middle
  Histogram classes(bool is_whole) const;
  friend bool operator==(const DyadicHistogram&, const DyadicHistogram&) = default;

 private:
  /// Classes for numbers between these as well. \param least_exponent  [1] of their width
  void hold(std::int64_t first, std::int64_t last, int exponent) noexcept;
  template <class T>
  void add_numbers(int components, const T* row, std::int64_t voxels) noexcept;

  int exponent_ = 0;                                 ///< width 2^exponent
  std::int64_t first_ = 0, last_ = -1;               ///< [classes] from zero on; the last before the first: none
  std::array<std::int64_t, most_classes> counts_{};  ///< from class `first_` on
};

/// Whether a field has whole numbers, whose classes are no narrower than 1.
bool is_of_whole_numbers(VoxelType type, int components) noexcept;

}  // namespace palpa::detail
