// The range of values of a grid, by bricks of 8 × 8 × 8 cells.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "palpa/field/grid.h"

namespace palpa::detail {

/// What the interpolant of one component can be within each brick of cells: between the least and the greatest voxel that it
/// reaches there. 8 bytes per brick.
class Bricks {
 public:
  static constexpr int shift = 3;                    ///< [1] cells along a brick's edge, as a power of two
  static constexpr std::int64_t cells = 1 << shift;  ///< [1] along a brick's edge

  /// Raw voxel values, rounded outwards. NaN: some voxel is not finite. min > max: none is.
  struct Range {
    float min;  ///< [raw]
    float max;  ///< [raw]
  };

  Bricks() = default;
  /// Reads the voxels once, by two threads.
  /// \param reach  [voxels] beyond the corners of a cell that its interpolant reads: 0 trilinear, 1 cubic
  Bricks(const GridGeometry& geometry, const Voxels& voxels, int component, int reach);

  bool empty() const noexcept { return ranges_.empty(); }

  /// Of all voxels; none where they are not all finite.
  std::optional<Range> whole() const noexcept;

  /// Of the brick at position b along each axis.
  const Range& at(const std::int64_t (&b)[3]) const noexcept {
    return ranges_[static_cast<std::size_t>(b[0] + count_[0] * (b[1] + count_[1] * b[2]))];
  }

 private:
  std::int64_t count_[3]{};
  std::vector<Range> ranges_;
};

}  // namespace palpa::detail
