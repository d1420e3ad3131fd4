#include "palpa/data/bricks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <type_traits>

#include "palpa/data/grid_base.h"
#include "palpa/data/parallel.h"

namespace palpa::detail {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

// Rounded outwards to the float that bounds the value.
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

// Voxels that cells of a brick use along an axis: [first, last].
struct Window {
  std::int64_t first, last;
  Window(std::int64_t brick, std::int64_t voxels) noexcept
      : first(std::max<std::int64_t>(brick * Bricks::cells - 1, 0)),
        last(std::min((brick + 1) * Bricks::cells + 1, voxels - 1)) {}
};

// Type of voxel differences: unsigned for integers, so that none overflows.
template <class T, bool = std::is_integral_v<T>>
struct StepOf {
  using Type = std::make_unsigned_t<T>;
};
template <class T>
struct StepOf<T, false> {
  using Type = T;
};
template <class T>
using Step = typename StepOf<T>::Type;

template <class T>
Step<T> apart(T a, T b) noexcept {
  const T high = a > b ? a : b, low = a > b ? b : a;  // of the values' own type: one instruction each
  return static_cast<Step<T>>(static_cast<Step<T>>(high) - static_cast<Step<T>>(low));
}

// Values by column over rows: plain loops along memory, which the compiler vectorises.
template <class T>
struct Columns {
  std::vector<T> least, greatest;
  std::vector<T> poison;       // of floats: NaN after a value that was not finite
  std::vector<Step<T>> steps;  // to the neighbours

  explicit Columns(std::int64_t n)
      : least(static_cast<std::size_t>(n)),
        greatest(least),
        poison(std::is_floating_point_v<T> ? least.size() : 0),
        steps(least.size()) {}

  void clear() noexcept {
    std::fill(least.begin(), least.end(), std::numeric_limits<T>::max());
    std::fill(greatest.begin(), greatest.end(), std::numeric_limits<T>::lowest());
    std::fill(poison.begin(), poison.end(), T{});
    std::fill(steps.begin(), steps.end(), Step<T>{});
  }

  // Adds values first…last of a row, with their neighbours along each axis; the row itself at a border.
  void add(const T* __restrict row, const T* __restrict next_i, const T* __restrict next_j, const T* __restrict next_k,
           std::size_t first, std::size_t last) noexcept {
    T* __restrict low = least.data();
    T* __restrict high = greatest.data();
    Step<T>* __restrict most = steps.data();
    const auto larger = [](Step<T> a, Step<T> b) { return a > b ? a : b; };  // b if a is NaN
    for (std::size_t i = first; i < last; ++i) {
      const T v = row[i];
      low[i] = v < low[i] ? v : low[i];
      high[i] = v > high[i] ? v : high[i];
      most[i] = larger(apart(next_i[i], v), larger(apart(next_j[i], v), larger(apart(next_k[i], v), most[i])));
    }
    if constexpr (std::is_floating_point_v<T>) {
      T* __restrict bad = poison.data();
      for (std::size_t i = first; i < last; ++i) bad[i] += row[i] - row[i];
    }
  }
};

// Range of a brick's voxels so far.
struct Found {
  float min = infinity, max = -infinity, step = 0.0F;
  bool hole = false;

  template <class T>
  void add(const Columns<T>& columns, const Window& window, std::int64_t component, std::int64_t components) noexcept {
    T low = std::numeric_limits<T>::max(), high = std::numeric_limits<T>::lowest(), bad{};
    Step<T> most{};
    for (std::int64_t i = window.first * components + component; i <= window.last * components + component; i += components) {
      const auto at = static_cast<std::size_t>(i);
      low = std::min(low, columns.least[at]);
      high = std::max(high, columns.greatest[at]);
      most = std::max(most, columns.steps[at]);
      if constexpr (std::is_floating_point_v<T>) bad += columns.poison[at];
    }
    hole = hole || bad != T{};
    if (low > high) return;
    min = std::min(min, at_most(low));
    max = std::max(max, at_least(high));
    step = std::max(step, at_least(most));
  }
};

}  // namespace

// By slices, so that each is read from memory once: its rows enter the bricks that contain or touch it.
template <class T>
void Bricks::fill(const T* data, const GridGeometry& geometry, std::int64_t first, std::int64_t last) {
  const auto& [nx, ny, nz] = geometry.dims;
  const std::int64_t row = nx * components_, in_layer = count_[0] * count_[1] * components_;
  std::vector<Found> found(static_cast<std::size_t>((last - first) * in_layer));
  const auto inner = static_cast<std::size_t>(row - components_);  // values with a neighbour along i
  Columns<T> columns(row);
  for (std::int64_t k = Window(first, nz).first; k <= Window(last - 1, nz).last; ++k) {
    const std::int64_t from = std::max(first, (k - 2) / cells), to = std::min(last - 1, (k + 1) / cells);
    for (std::int64_t bj = 0; bj < count_[1]; ++bj) {
      columns.clear();
      const Window in_j(bj, ny);
      for (std::int64_t j = in_j.first; j <= in_j.last; ++j) {
        const T* here = data + row * (j + ny * k);
        const T *next_j = j + 1 < ny ? here + row : here, *next_k = k + 1 < nz ? here + row * ny : here;
        columns.add(here, here + components_, next_j, next_k, 0, inner);
        columns.add(here, here, next_j, next_k, inner, static_cast<std::size_t>(row));
      }
      for (std::int64_t bk = from; bk <= to; ++bk) {
        Found* out = found.data() + (bk - first) * in_layer + bj * count_[0] * components_;
        for (std::int64_t bi = 0; bi < count_[0]; ++bi) {
          for (std::int64_t c = 0; c < components_; ++c) (out++)->add(columns, Window(bi, nx), c, components_);
        }
      }
    }
  }
  constexpr float nan = std::numeric_limits<float>::quiet_NaN(),
                  rounded_up = 1.0F + 4.0F * std::numeric_limits<float>::epsilon();
  Range* out = ranges_.data() + first * in_layer;
  for (std::size_t brick = 0; brick < found.size(); brick += static_cast<std::size_t>(components_)) {
    const std::span<const Found> all(found.data() + brick, static_cast<std::size_t>(components_));
    const bool none = std::any_of(all.begin(), all.end(), [](const Found& f) { return f.min > f.max; });
    const bool hole = std::any_of(all.begin(), all.end(), [](const Found& f) { return f.hole; });
    for (const Found& f : all)
      *out++ = none ? Range{infinity, -infinity} : hole ? Range{nan, nan} : Range{f.min, f.max, f.step * rounded_up};
  }
}

Bricks::Bricks(const GridGeometry& geometry, const Voxels& voxels) : components_(voxels.components) {
  for (int a = 0; a < 3; ++a) count_[a] = (std::max<std::int64_t>(geometry.dims[a] - 1, 1) + cells - 1) / cells;
  ranges_.resize(static_cast<std::size_t>(components_ * count_[0] * count_[1] * count_[2]));
  constexpr std::int64_t worth_a_thread = 1 << 16;  // [voxels] fewer: thread overhead; more: idle cores
  const std::int64_t layers = worth_a_thread / (cells * geometry.dims[0] * geometry.dims[1]) + 1;
  with_values_of(voxels, [&](const auto* data) {
    in_parts(count_[2], layers, [&](std::int64_t first, std::int64_t last) { fill(data, geometry, first, last); });
  });
}

std::optional<Bricks::Range> Bricks::whole(int component) const noexcept {
  Range range{infinity, -infinity};
  for (auto at = static_cast<std::size_t>(component); at < ranges_.size(); at += static_cast<std::size_t>(components_)) {
    const Range& brick = ranges_[at];
    if (!(brick.min <= brick.max)) return std::nullopt;
    range = {std::min(range.min, brick.min), std::max(range.max, brick.max)};
  }
  return range;
}

}  // namespace palpa::detail
