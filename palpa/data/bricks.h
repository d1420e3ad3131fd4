// Ranges of values of a grid, by bricks of 8 × 8 × 8 cells.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "palpa/data/grid.h"

namespace palpa::detail {

/// Bounds of a trilinear or cubic interpolant within each brick of cells: the least and the greatest voxel within one voxel of
/// the brick; and of its change from voxel to voxel. 12 bytes per brick and component.
class Bricks {
 public:
  /// [1] Cells along a brick's edge, as a power of two. Larger: wider ranges, fewer skips; smaller: more memory.
  static constexpr int shift = 3;
  static constexpr std::int64_t cells = 1 << shift;  ///< [1] along a brick's edge

  /// Raw voxel values of a component, rounded outwards. NaN: a voxel is not finite, in this or another component. min > max: no
  /// voxel is finite.
  struct Range {
    float min;          ///< [raw]
    float max;          ///< [raw]
    float step = 0.0F;  ///< [raw] bound of the difference of neighbours along an axis
  };

  Bricks() = default;
  /// Reads the voxels once, on all cores.
  Bricks(const GridGeometry& geometry, const Voxels& voxels);

  bool empty() const noexcept { return ranges_.empty(); }

  /// Range of all voxels; none unless all are finite.
  std::optional<Range> whole(int component) const noexcept;

  /// Range at brick index b along each axis.
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
