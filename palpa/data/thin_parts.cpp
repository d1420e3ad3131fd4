#include "palpa/data/thin_parts.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "palpa/data/filter.h"
#include "palpa/data/grid_base.h"
#include "palpa/data/parallel.h"

// Reads slices in order and marks solid voxels, squares of 2 × 2 of them, blocks and thin voxels, by a byte of 0 or 1 each:
// plain loops over whole slices, which the compiler vectorises. Only what is thin is smoothed, and that is little. Values are
// relative to the level, positive towards the solid side: solid means >= 0.

namespace palpa {
namespace {

using Marks = std::vector<std::uint8_t>;

std::int64_t marked(const Marks& marks) noexcept {
  std::int64_t sum = 0;
  for (auto from = marks.begin(); from != marks.end();) {
    const auto to = from + std::min<std::ptrdiff_t>(marks.end() - from, 1 << 16);
    std::uint32_t part = 0;  // no wider: half the lanes
    for (; from != to; ++from) part += *from;
    sum += part;
  }
  return sum;
}

/// Marks the first `count` voxels. \param mark_of  captures by value what it uses: through a pointer to it no loop is
/// vectorised
template <class MarkOf>
void mark(std::int64_t count, std::uint8_t* __restrict to, const MarkOf& mark_of) noexcept {
  const MarkOf of = mark_of;
  for (std::int64_t v = 0; v < count; ++v) to[v] = static_cast<std::uint8_t>(of(v));
}

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
        right_(nx_ > 1),
        down_(ny_ > 1 ? nx_ : 0),
        thin_(static_cast<std::size_t>(plane_)) {
    for (auto* both : {&solid_, &squares_, &blocks_}) both->fill(thin_);
    if constexpr (has_few_numbers) find_solid_numbers();
  }

  ThinParts count(std::int64_t first, std::int64_t last) {
    ThinParts found;
    if (first > 0) read(first - 1);
    read(first);
    if (first > 0) find_blocks(first - 1);
    for (std::int64_t k = first; k < last; ++k) {
      if (k + 1 < nz_) read(k + 1);
      find_blocks(k);
      find_thin(k);
      found.solid += marked(solid_[k % 2]);
      found.thin += marked(thin_);
      for (std::int64_t v = next_thin(0); v < plane_; v = next_thin(v + 1)) found.lost += smooth(v, k) < 0.0;  // NaN: not lost
    }
    return found;
  }

 private:
  static constexpr bool has_few_numbers = std::is_integral_v<T> && sizeof(T) <= 2;

  double value(T voxel) const noexcept { return sign_ * (static_cast<double>(voxel) * grid_.scale + grid_.offset - level_); }
  static bool is_solid(double value) noexcept { return value >= 0.0 && value <= std::numeric_limits<double>::max(); }

  /// Finds the least and the greatest solid number: all between them are solid, as the value rises or falls with it.
  void find_solid_numbers() noexcept {
    least_ = std::numeric_limits<T>::max(), greatest_ = std::numeric_limits<T>::min();
    for (int number = greatest_; number <= std::numeric_limits<T>::max(); ++number) {
      const auto voxel = static_cast<T>(number);
      if (is_solid(value(voxel))) least_ = std::min(least_, voxel), greatest_ = std::max(greatest_, voxel);
    }
  }

  /// Marks the solid voxels of slice k, and of each square the voxel where it begins.
  void read(std::int64_t k) noexcept {
    const T* const in = voxels_ + k * plane_;
    std::uint8_t* __restrict const solid = solid_[k % 2].data();
    std::uint8_t* __restrict const out = squares_[k % 2].data();
    if constexpr (has_few_numbers) {
      mark(plane_, solid, [in, least = least_, greatest = greatest_](std::int64_t v) {
        return static_cast<std::uint8_t>((in[v] >= least) & (in[v] <= greatest));
      });
    } else {
      mark(plane_, solid, [this, in](std::int64_t v) { return static_cast<std::uint8_t>(is_solid(value(in[v]))); });
    }
    const std::int64_t both = right_ + down_, end = plane_ - both;
    mark(end, out, [solid, right = right_, down = down_, both](std::int64_t v) {
      return solid[v] & solid[v + right] & solid[v + down] & solid[v + both];
    });
    std::fill(out + end, out + plane_, std::uint8_t{0});
    // Beside the last voxel of a row is the first of the next.
    for (std::int64_t v = nx_ - 1; right_ > 0 && v < plane_; v += nx_) out[v] = 0;
  }

  /// Marks the blocks that begin in slice k.
  void find_blocks(std::int64_t k) noexcept {
    const std::uint8_t *const low = squares_[k % 2].data(), *const high = squares_[std::min(k + 1, nz_ - 1) % 2].data();
    const std::uint8_t is_any = k + 1 < nz_ || nz_ == 1;
    mark(plane_, blocks_[k % 2].data(), [=](std::int64_t v) { return low[v] & high[v] & is_any; });
  }

  /// Marks the solid voxels of slice k in no block, those that begin in the slice before included.
  void find_thin(std::int64_t k) noexcept {
    const std::uint8_t *const solid = solid_[k % 2].data(), *const here = blocks_[k % 2].data();
    const std::uint8_t* const before = blocks_[(k + 1) % 2].data();
    const auto begins = [=](std::int64_t v) { return here[v] | before[v]; };
    const std::int64_t right = right_, down = down_, both = right_ + down_;
    mark(both, thin_.data(), [=](std::int64_t v) {
      const bool is_thick = begins(v) || (v >= right && begins(v - right)) || (v >= down && begins(v - down));
      return solid[v] && !is_thick;
    });
    mark(plane_ - both, thin_.data() + both, [=](std::int64_t v) {
      return solid[v + both] & ~(begins(v + both) | begins(v + down) | begins(v + right) | begins(v));
    });
  }

  std::int64_t next_thin(std::int64_t from) const noexcept {
    const void* const found =
        from < plane_ ? std::memchr(thin_.data() + from, 1, static_cast<std::size_t>(plane_ - from)) : nullptr;
    return found ? static_cast<const std::uint8_t*>(found) - thin_.data() : plane_;
  }

  /// Smoothing spline at voxel v of slice k.
  double smooth(std::int64_t v, std::int64_t k) const noexcept {
    const std::int64_t i = v % nx_, j = v / nx_;
    const auto around = [](std::int64_t at, std::int64_t count, const auto& along) {
      return (along(std::max<std::int64_t>(at - 1, 0)) + 4.0 * along(at) + along(std::min(at + 1, count - 1))) * (1.0 / 6.0);
    };
    return around(k, nz_, [&](std::int64_t slice) {
      return around(j, ny_, [&](std::int64_t row) {
        const T* const in = voxels_ + slice * plane_ + row * nx_;
        return around(i, nx_, [&](std::int64_t at) { return value(in[at]); });
      });
    });
  }

  const GridView& grid_;
  const T* voxels_;
  double level_, sign_;
  std::int64_t nx_, ny_, nz_, plane_;
  std::int64_t right_, down_;                      ///< [voxels] to the next along i and along j; 0 along an axis of one
  T least_{}, greatest_{};                         ///< solid numbers, of types that have few
  std::array<Marks, 2> solid_, squares_, blocks_;  ///< of an even and of an odd slice
  Marks thin_;
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
