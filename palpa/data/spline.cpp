#include "palpa/data/spline.h"

#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <vector>

#include "palpa/data/parallel.h"

namespace palpa::detail {
namespace {

/// Solves c[i−1]/6 + 4c[i]/6 + c[i+1]/6 = v[i] along lines (elimination without pivots: the diagonal dominates). A missing
/// neighbour, at a border or beside a gap, is replaced by c[i].
template <class T>
class Lines {
 public:
  /// \param count   values along a line
  /// \param stride  offset of successive values
  /// \param most    lines solved together
  Lines(std::int64_t count, std::int64_t stride, std::int64_t most)
      : count_(count),
        stride_(stride),
        most_(most),
        inverse_(static_cast<std::size_t>(count)),
        ratio_(inverse_),
        value_(static_cast<std::size_t>(count * most)),
        none_(static_cast<std::size_t>(most)) {
    double last_ratio = 0.0;
    for (std::int64_t n = 0; n < count; ++n) {
      const double before = n > 0 ? sixth : 0.0, after = n + 1 < count ? sixth : 0.0;
      const auto at = static_cast<std::size_t>(n);
      inverse_[at] = 1.0 / (1.0 - before - after - before * last_ratio);
      ratio_[at] = last_ratio = after * inverse_[at];
    }
  }

  /// Solves neighbouring lines of memory, in place.
  void solve(T* first, std::int64_t lanes) noexcept {
    for (std::int64_t n = 0; n < count_; ++n) forward(n, first + n * stride_, lanes, 1);
    if (any_gap(lanes)) return solve_gaps(first, lanes, 1);
    backward(lanes);
    for (std::int64_t n = 0; n < count_; ++n) {
      const double* value = value_.data() + n * most_;
      T* out = first + n * stride_;
      for (std::int64_t lane = 0; lane < lanes; ++lane) out[lane] = static_cast<T>(value[lane]);
    }
  }

  /// Solves lines `lane_stride` values apart, out of place.
  void solve(const T* from, T* to, std::int64_t lanes, std::int64_t lane_stride) noexcept {
    for (std::int64_t n = 0; n < count_; ++n) forward(n, from + n * stride_, lanes, lane_stride);
    const bool gaps = any_gap(lanes);
    if (!gaps) backward(lanes);
    for (std::int64_t n = 0; n < count_; ++n) {
      const double* value = value_.data() + n * most_;
      for (std::int64_t lane = 0; lane < lanes; ++lane) {
        const std::int64_t at = n * stride_ + lane * lane_stride;
        to[at] = gaps ? from[at] : static_cast<T>(value[lane]);
      }
    }
    if (gaps) solve_gaps(to, lanes, lane_stride);
  }

 private:
  static constexpr double sixth = 1.0 / 6.0;

  /// A non-finite value makes all later ones so.
  bool any_gap(std::int64_t lanes) const noexcept {
    const double* last = value_.data() + (count_ - 1) * most_;
    return !std::all_of(last, last + lanes, [](double value) { return std::isfinite(value); });
  }

  void forward(std::int64_t n, const T* __restrict in, std::int64_t lanes, std::int64_t lane_stride) noexcept {
    const double before = n > 0 ? sixth : 0.0, inverse = inverse_[static_cast<std::size_t>(n)];
    double* __restrict value = value_.data() + n * most_;
    const double* __restrict last = n > 0 ? value - most_ : none_.data();
    const auto step = [=](std::int64_t lane, double here) { value[lane] = (here - before * last[lane]) * inverse; };
    if (lane_stride == 1) {
      for (std::int64_t lane = 0; lane < lanes; ++lane) step(lane, static_cast<double>(in[lane]));
    } else {
      for (std::int64_t lane = 0; lane < lanes; ++lane) step(lane, static_cast<double>(in[lane * lane_stride]));
    }
  }

  void backward(std::int64_t lanes) noexcept {
    for (std::int64_t n = count_ - 2; n >= 0; --n) {
      const double ratio = ratio_[static_cast<std::size_t>(n)];
      double* __restrict value = value_.data() + n * most_;
      const double* __restrict after = value + most_;
      for (std::int64_t lane = 0; lane < lanes; ++lane) value[lane] -= ratio * after[lane];
    }
  }

  /// Solves lines with non-finite values.
  void solve_gaps(T* first, std::int64_t lanes, std::int64_t lane_stride) noexcept {
    for (std::int64_t lane = 0; lane < lanes; ++lane) {
      T* line = first + lane * lane_stride;
      for (std::int64_t begin = 0; begin < count_; ++begin) {
        std::int64_t end = begin;
        while (end < count_ && std::isfinite(line[end * stride_])) ++end;
        if (end > begin) solve_run(line + begin * stride_, end - begin);
        begin = end;
      }
    }
  }

  /// Solves a run within a line, with ends of its own.
  void solve_run(T* first, std::int64_t count) noexcept {
    double last = 0.0;
    for (std::int64_t n = 0; n < count; ++n) {
      const auto at = static_cast<std::size_t>(n);
      const double before = n > 0 ? sixth : 0.0, last_ratio = n > 0 ? ratio_[at - 1] : 0.0;
      const double inverse = n + 1 < count ? inverse_[at] : 1.0 / (1.0 - before - before * last_ratio);
      value_[at] = last = (static_cast<double>(first[n * stride_]) - before * last) * inverse;
    }
    for (std::int64_t n = count - 1; n >= 0; --n) {
      const auto at = static_cast<std::size_t>(n);
      if (n + 1 < count) last = value_[at] - ratio_[at] * last;
      first[n * stride_] = static_cast<T>(last);
    }
  }

  std::int64_t count_, stride_, most_;
  std::vector<double> inverse_, ratio_;  ///< of a line without gaps, from its start on
  std::vector<double> value_;
  std::vector<double> none_;  ///< before the first values
};

/// Memory for values to be written completely: in large pages, since the first touch of many small ones takes as long as
/// solving.
template <class T>
std::shared_ptr<T> room_for(std::size_t count) {
  constexpr std::size_t page = std::size_t{2} << 20;  // a large page of x86-64 and most ARM
  const std::size_t bytes = (count * sizeof(T) + page - 1) / page * page;
  void* memory = std::aligned_alloc(page, bytes);
  if (memory == nullptr) throw std::bad_alloc();
  ::madvise(memory, bytes, MADV_HUGEPAGE);
  return {static_cast<T*>(memory), std::free};
}

/// Calls `act(first, lanes)` for groups of neighbours among `count` lines.
template <class Act>
void in_lanes(std::int64_t count, std::int64_t most, Act act) {
  for (std::int64_t first = 0; first < count; first += most) act(first, std::min(most, count - first));
}

}  // namespace

template <class T>
std::shared_ptr<const T> interpolating_coefficients(const GridGeometry& geometry, int components, const T* values) {
  const std::int64_t nx = geometry.dims[0], ny = geometry.dims[1], nz = geometry.dims[2];
  const std::int64_t row = nx * components, plane = row * ny;
  const std::shared_ptr<T> result = room_for<T>(static_cast<std::size_t>(plane * nz));
  T* const c = result.get();
  constexpr std::int64_t worth_a_thread = 1 << 16;  // [values] fewer: thread overhead; more: idle cores
  // Lines solved together. Fewer: along j and k a single line uses a sixteenth of the fetched memory, and a thousandth of a
  // page; more: beyond the cache.
  constexpr std::int64_t rows_at_once = 16, columns_at_once = 64;
  in_parts(nz, worth_a_thread / plane + 1, [&](std::int64_t first, std::int64_t last) {
    Lines<T> along_i(nx, components, rows_at_once), along_j(ny, row, columns_at_once);
    for (std::int64_t k = first; k < last; ++k) {
      in_lanes(ny, rows_at_once, [&](std::int64_t j, std::int64_t lanes) {
        const std::int64_t at = k * plane + j * row;
        for (int component = 0; component < components; ++component) {
          along_i.solve(values + at + component, c + at + component, lanes, row);
        }
      });
      in_lanes(row, columns_at_once, [&](std::int64_t i, std::int64_t lanes) { along_j.solve(c + k * plane + i, lanes); });
    }
  });
  in_parts(ny, worth_a_thread / (row * nz) + 1, [&](std::int64_t first, std::int64_t last) {
    Lines<T> along_k(nz, plane, columns_at_once);
    for (std::int64_t j = first; j < last; ++j) {
      in_lanes(row, columns_at_once, [&](std::int64_t i, std::int64_t lanes) { along_k.solve(c + j * row + i, lanes); });
    }
  });
  return result;
}

template std::shared_ptr<const float> interpolating_coefficients(const GridGeometry&, int, const float*);
template std::shared_ptr<const double> interpolating_coefficients(const GridGeometry&, int, const double*);

}  // namespace palpa::detail
