// The range of values of a grid, by bricks of 8 × 8 × 8 cells.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "palpa/data/grid.h"

namespace palpa::detail {

/// What an interpolant, trilinear or cubic, can be within each brick of cells: between the least and the greatest voxel within
/// one voxel of the brick; and how much it can change from voxel to voxel. 12 bytes per brick and component.
class Bricks {
 public:
  /// [1] Cells along a brick's edge, as a power of two. Larger: ranges are wider and skip less; smaller: more memory.
  static constexpr int shift = 3;
  static constexpr std::int64_t cells = 1 << shift;  ///< [1] along a brick's edge

  /// Raw voxel values of one component, rounded outwards. NaN: some voxel is not finite, in this or another component.
  /// min > max: none is finite altogether.
  struct Range {
    float min;          ///< [raw]
    float max;          ///< [raw]
    float step = 0.0F;  ///< [raw] no two neighbours along an axis differ by more
  };

  Bricks() = default;
  /// Reads the voxels once, by as many threads as there are cores.
  Bricks(const GridGeometry& geometry, const Voxels& voxels);

  bool empty() const noexcept { return ranges_.empty(); }

  /// Of all voxels; none where they are not all finite.
  std::optional<Range> whole(int component) const noexcept;

  /// Of the brick at position b along each axis.
  const Range& at(int component, const std::int64_t (&b)[3]) const noexcept {
    return ranges_[static_cast<std::size_t>(component + components_ * (b[0] + count_[0] * (b[1] + count_[1] * b[2])))];
  }

 private:
  template <class T>
  void fill(const T* data, const GridGeometry& geometry, std::int64_t first, std::int64_t last);

  std::int64_t components_ = 0;
  std::int64_t count_[3]{};
  std::vector<Range> ranges_;
};

}  // namespace palpa::detail
