#include "palpa/data/thin_parts.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <stdexcept>
#include <vector>

#include "palpa/data/filter.h"
#include "palpa/data/grid_base.h"
#include "palpa/data/parallel.h"

// Reads slices in order and keeps the last three: solid voxels, and values smoothed along i and j. Values are relative to the
// level, positive towards the solid side: solid means >= 0.

namespace palpa {
namespace {

template <class T>
class Counter {
 public:
  Counter(const GridView& grid, const T* voxels, double level, SolidSide solid)
      : grid_(grid),
        voxels_(voxels),
        level_(level),
        sign_(solid == SolidSide::high ? 1.0 : -1.0),
        nx_(grid.geometry.dims[0]),
        ny_(grid.geometry.dims[1]),
        nz_(grid.geometry.dims[2]),
        plane_(nx_ * ny_),
        row_(static_cast<std::size_t>(nx_)),
        rows_(static_cast<std::size_t>(plane_)),
        smooth_(static_cast<std::size_t>(3 * plane_)),
        solid_(static_cast<std::size_t>(3 * plane_)),
        block_(static_cast<std::size_t>(2 * plane_)) {}

  ThinParts count(std::int64_t first, std::int64_t last) {
    ThinParts found;
    std::int64_t unread = std::max<std::int64_t>(first - 1, 0);
    const auto read_to = [&](std::int64_t k) {
      for (; unread <= std::min(k, nz_ - 1); ++unread) read(unread);
    };
    if (first > 0) {
      read_to(first);
      find_blocks(first - 1);
    }
    for (std::int64_t k = first; k < last; ++k) {
      read_to(k + 1);
      if (k + 1 < nz_ || nz_ == 1) find_blocks(k);
      count(k, found);
    }
    return found;
  }

 private:
  double* smooth(std::int64_t k) noexcept { return smooth_.data() + (k % 3) * plane_; }
  std::uint8_t* solid(std::int64_t k) noexcept { return solid_.data() + (k % 3) * plane_; }
  std::uint8_t* blocks(std::int64_t k) noexcept { return block_.data() + (k % 2) * plane_; }

  static double spline(double before, double here, double after) noexcept {
    return (before + 4.0 * here + after) * (1.0 / 6.0);
  }

  void read(std::int64_t k) noexcept {
    const T* in = voxels_ + k * plane_;
    double* out = smooth(k);
    std::uint8_t* marks = solid(k);
    for (std::int64_t j = 0; j < ny_; ++j) {
      for (std::int64_t i = 0; i < nx_; ++i) {
        row_[i] = sign_ * (static_cast<double>(in[j * nx_ + i]) * grid_.scale + grid_.offset - level_);
        marks[j * nx_ + i] = row_[i] >= 0.0 && std::isfinite(row_[i]);
      }
      double* along = rows_.data() + j * nx_;
      along[0] = spline(row_[0], row_[0], row_[std::min<std::int64_t>(1, nx_ - 1)]);
      for (std::int64_t i = 1; i < nx_ - 1; ++i) along[i] = spline(row_[i - 1], row_[i], row_[i + 1]);
      if (nx_ > 1) along[nx_ - 1] = spline(row_[nx_ - 2], row_[nx_ - 1], row_[nx_ - 1]);
    }
    for (std::int64_t j = 0; j < ny_; ++j) {
      const double *before = rows_.data() + std::max<std::int64_t>(j - 1, 0) * nx_, *here = rows_.data() + j * nx_;
      const double* after = rows_.data() + std::min(j + 1, ny_ - 1) * nx_;
      for (std::int64_t i = 0; i < nx_; ++i) out[j * nx_ + i] = spline(before[i], here[i], after[i]);
    }
  }

  /// Marks the blocks of 2 × 2 × 2 solid voxels that begin in slice k.
  void find_blocks(std::int64_t k) noexcept {
    const std::uint8_t *low = solid(k), *high = solid(std::min(k + 1, nz_ - 1));
    std::uint8_t* out = blocks(k);
    const std::int64_t di = nx_ > 1, dj = ny_ > 1 ? nx_ : 0;
    std::fill_n(out, plane_, std::uint8_t{0});
    for (std::int64_t j = 0; j < std::max<std::int64_t>(ny_ - 1, 1); ++j) {
      for (std::int64_t v = j * nx_; v < j * nx_ + std::max<std::int64_t>(nx_ - 1, 1); ++v) {
        out[v] =
            low[v] & low[v + di] & low[v + dj] & low[v + di + dj] & high[v] & high[v + di] & high[v + dj] & high[v + di + dj];
      }
    }
  }

  void count(std::int64_t k, ThinParts& found) noexcept {
    const std::uint8_t* here = solid(k);
    const double *before = smooth(std::max<std::int64_t>(k - 1, 0)), *middle = smooth(k);
    const double* after = smooth(std::min(k + 1, nz_ - 1));
    const std::uint8_t* with[2] = {k + 1 < nz_ || nz_ == 1 ? blocks(k) : nullptr, k > 0 ? blocks(k - 1) : nullptr};
    for (std::int64_t j = 0; j < ny_; ++j) {
      for (std::int64_t i = 0; i < nx_; ++i) {
        const std::int64_t v = j * nx_ + i;
        if (!here[v]) continue;
        ++found.solid;
        bool thick = false;
        for (const std::uint8_t* marks : with) {
          if (!marks) continue;
          thick = thick || marks[v] || (i > 0 && marks[v - 1]) || (j > 0 && marks[v - nx_]) ||
                  (i > 0 && j > 0 && marks[v - nx_ - 1]);
        }
        if (thick) continue;
        ++found.thin;
        found.lost += spline(before[v], middle[v], after[v]) < 0.0;  // NaN counts as not lost
      }
    }
  }

  const GridView& grid_;
  const T* voxels_;
  double level_, sign_;
  std::int64_t nx_, ny_, nz_, plane_;
  std::vector<double> row_, rows_, smooth_;
  std::vector<std::uint8_t> solid_, block_;
};

}  // namespace

ThinParts thin_parts(const Field& field, double level, SolidSide solid) {
  const GridView* grid = grid_below(field);
  if (!grid) throw std::invalid_argument("a field without voxels has no thin parts; sample it first");
  if (grid->voxels.components != 1) throw std::invalid_argument("a vector field has no levels; take its magnitude");
  return detail::with_values_of(grid->voxels, [&]<class T>(const T* voxels) {
    ThinParts all;
    std::mutex joining;
    // [slices] Least for a thread. Fewer: neighbouring threads read the same slices; more: idle cores on small grids.
    constexpr std::int64_t worth_a_thread = 8;
    detail::in_parts(grid->geometry.dims[2], worth_a_thread, [&](std::int64_t first, std::int64_t last) {
      const ThinParts part = Counter<T>(*grid, voxels, level, solid).count(first, last);
      const std::lock_guard lock(joining);
      all = {all.solid + part.solid, all.thin + part.thin, all.lost + part.lost};
    });
    return all;
  });
}

}  // namespace palpa
