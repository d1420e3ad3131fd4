// A sample of the rows of a grid.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace palpa::detail {

/// One row of each `step` rows of a grid.
struct RowSamples {
  std::int64_t rows = 0;  ///< [rows] of the grid
  std::int64_t step = 1;  ///< [rows] >= 1; 1: all rows, in order

  std::int64_t count() const noexcept { return (rows + step - 1) / step; }
  /// Number of a sample's row, growing with `sample`. At multiples of the golden ratio within its step: at a constant place all
  /// samples would lie in a plane of the grid whose slices have a multiple of `step` rows.
  std::int64_t operator[](std::int64_t sample) const noexcept {
    const double turns = static_cast<double>(sample) * std::numbers::phi;
    const auto width = static_cast<double>(std::min(step, rows - sample * step));
    return sample * step + static_cast<std::int64_t>((turns - std::floor(turns)) * width);
  }
};

}  // namespace palpa::detail
