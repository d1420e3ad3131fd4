#include "palpa/field/bricks.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <thread>
#include <type_traits>

#include "palpa/field/grid_base.h"

namespace palpa::detail {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

// Outwards: the float that holds the bound.
template <class T>
float at_most(T value) noexcept {
  const auto f = static_cast<float>(value);
  return static_cast<double>(f) <= static_cast<double>(value) ? f : std::nextafter(f, -infinity);
}
template <class T>
float at_least(T value) noexcept {
  const auto f = static_cast<float>(value);
  return static_cast<double>(f) >= static_cast<double>(value) ? f : std::nextafter(f, infinity);
}

// The voxels that the cells of a brick reach along one axis: [first, last].
struct Window {
  std::int64_t first, last;
  Window(std::int64_t brick, std::int64_t reach, std::int64_t voxels) noexcept
      : first(std::max<std::int64_t>(brick * Bricks::cells - reach, 0)),
        last(std::min((brick + 1) * Bricks::cells + reach, voxels - 1)) {}
};

// Column by column over rows: plain loops along memory, which the compiler makes wide.
template <class T>
struct Columns {
  std::vector<T> least, greatest;
  std::vector<T> poison;  // of floats: NaN where a value was not finite

  explicit Columns(std::int64_t n)
      : least(static_cast<std::size_t>(n)), greatest(least), poison(std::is_floating_point_v<T> ? least.size() : 0) {}

  void clear() noexcept {
    std::fill(least.begin(), least.end(), std::numeric_limits<T>::max());
    std::fill(greatest.begin(), greatest.end(), std::numeric_limits<T>::lowest());
    std::fill(poison.begin(), poison.end(), T{});
  }

  template <int Stride>
  void add(const T* __restrict row) noexcept {
    T* __restrict low = least.data();
    T* __restrict high = greatest.data();
    const std::size_t n = least.size();
    for (std::size_t i = 0; i < n; ++i) {
      const T v = row[Stride * i];
      low[i] = v < low[i] ? v : low[i];
      high[i] = v > high[i] ? v : high[i];
    }
    if constexpr (std::is_floating_point_v<T>) {
      T* __restrict bad = poison.data();
      for (std::size_t i = 0; i < n; ++i) bad[i] += row[Stride * i] - row[Stride * i];
    }
  }

  Bricks::Range over(const Window& window) const noexcept {
    T low = std::numeric_limits<T>::max(), high = std::numeric_limits<T>::lowest(), bad{};
    for (auto i = static_cast<std::size_t>(window.first); i <= static_cast<std::size_t>(window.last); ++i) {
      low = std::min(low, least[i]);
      high = std::max(high, greatest[i]);
      if constexpr (std::is_floating_point_v<T>) bad += poison[i];
    }
    if (low > high) return {infinity, -infinity};
    if (bad != T{}) return {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::quiet_NaN()};
    return {at_most(low), at_least(high)};
  }
};

}  // namespace

Bricks::Bricks(const GridGeometry& geometry, const Voxels& voxels, int component, int reach) {
  for (int a = 0; a < 3; ++a) count_[a] = (std::max<std::int64_t>(geometry.dims[a] - 1, 1) + cells - 1) / cells;
  ranges_.resize(static_cast<std::size_t>(count_[0] * count_[1] * count_[2]));
  with_values_of(voxels, [&]<class T>(const T* data) {
    const auto& dims = geometry.dims;
    const std::int64_t components = voxels.components;
    const auto fill = [&](Columns<T>& columns, std::int64_t first, std::int64_t last) {
      for (std::int64_t bk = first; bk < last; ++bk) {
        const Window in_k(bk, reach, dims[2]);
        for (std::int64_t bj = 0; bj < count_[1]; ++bj) {
          const Window in_j(bj, reach, dims[1]);
          columns.clear();
          for (std::int64_t k = in_k.first; k <= in_k.last; ++k) {
            for (std::int64_t j = in_j.first; j <= in_j.last; ++j) {
              const T* row = data + component + components * dims[0] * (j + dims[1] * k);
              if (components == 1) {
                columns.template add<1>(row);
              } else {
                columns.template add<3>(row);
              }
            }
          }
          Range* out = ranges_.data() + count_[0] * (bj + count_[1] * bk);
          for (std::int64_t bi = 0; bi < count_[0]; ++bi) out[bi] = columns.over(Window(bi, reach, dims[0]));
        }
      }
    };
    const std::int64_t middle = geometry.voxels() > (1 << 16) ? count_[2] / 2 : 0;
    Columns<T> here(dims[0]), there(middle > 0 ? dims[0] : 0);
    if (middle == 0) return fill(here, 0, count_[2]);
    const std::jthread other(fill, std::ref(there), 0, middle);
    fill(here, middle, count_[2]);
  });
}

std::optional<Bricks::Range> Bricks::whole() const noexcept {
  Range range{infinity, -infinity};
  for (const Range& brick : ranges_) {
    if (!(brick.min <= brick.max)) return std::nullopt;
    range = {std::min(range.min, brick.min), std::max(range.max, brick.max)};
  }
  return range;
}

}  // namespace palpa::detail
