#include "palpa/field/spline.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <thread>
#include <vector>

namespace palpa::detail {
namespace {

/// Neighbouring lines are solved together: along j and k one line alone would fetch memory for one value in sixteen.
constexpr std::int64_t most_lanes = 16;

/// Solves c[i−1]/6 + 4c[i]/6 + c[i+1]/6 = v[i] along `lanes` lines in place (elimination without pivots: the diagonal
/// dominates). Where a neighbour is missing, at a border or beside a gap, it is c[i] that repeats.
template <class T>
class Lines {
 public:
  Lines(std::int64_t count, std::int64_t stride)
      : count_(count), stride_(stride), value_(count * most_lanes), ratio_(count * most_lanes) {}

  void solve(T* first, std::int64_t lanes, std::int64_t lane_stride) noexcept {
    const auto at = [&](std::int64_t n, std::int64_t lane) -> T& { return first[n * stride_ + lane * lane_stride]; };
    double before[most_lanes] = {}, last_value[most_lanes] = {}, last_ratio[most_lanes] = {};
    for (std::int64_t n = 0; n < count_; ++n) {
      for (std::int64_t lane = 0; lane < lanes; ++lane) {
        const T here = at(n, lane);
        const bool there = std::isfinite(here);
        const double after = n + 1 < count_ && std::isfinite(at(n + 1, lane)) ? 1.0 / 6.0 : 0.0;
        const double inverse = there ? 1.0 / (1.0 - before[lane] - after - before[lane] * last_ratio[lane]) : 0.0;
        last_value[lane] = there ? (static_cast<double>(here) - before[lane] * last_value[lane]) * inverse : 0.0;
        last_ratio[lane] = after * inverse;
        before[lane] = there ? 1.0 / 6.0 : 0.0;
        value_[n * most_lanes + lane] = last_value[lane];
        ratio_[n * most_lanes + lane] = last_ratio[lane];
      }
    }
    double next[most_lanes] = {};
    for (std::int64_t n = count_ - 1; n >= 0; --n) {
      for (std::int64_t lane = 0; lane < lanes; ++lane) {
        next[lane] = value_[n * most_lanes + lane] - ratio_[n * most_lanes + lane] * next[lane];
        if (std::isfinite(at(n, lane))) at(n, lane) = static_cast<T>(next[lane]);
      }
    }
  }

 private:
  std::int64_t count_, stride_;
  std::vector<double> value_, ratio_;
};

/// Calls `act(first, last)` with the two halves of 0…count, at once.
template <class Act>
void in_two(std::int64_t count, Act act) {
  const std::jthread other([&] { act(0, count / 2); });
  act(count / 2, count);
}

}  // namespace

template <class T>
std::shared_ptr<const T> interpolating_coefficients(const GridGeometry& geometry, int components, const T* values) {
  const auto [nx, ny, nz] = geometry.dims;
  const std::int64_t row = nx * components, plane = row * ny;
  const std::shared_ptr<T[]> result(new T[static_cast<std::size_t>(plane * nz)]);
  T* const c = result.get();
  const auto in_lanes = [](std::int64_t count, auto act) {
    for (std::int64_t first = 0; first < count; first += most_lanes) act(first, std::min(most_lanes, count - first));
  };
  in_two(nz, [&](std::int64_t first, std::int64_t last) {
    std::copy(values + first * plane, values + last * plane, c + first * plane);
    Lines<T> along_i(nx, components), along_j(ny, row);
    for (std::int64_t k = first; k < last; ++k) {
      for (int component = 0; component < components; ++component) {
        in_lanes(ny,
                 [&](std::int64_t j, std::int64_t lanes) { along_i.solve(c + k * plane + j * row + component, lanes, row); });
      }
      in_lanes(row, [&](std::int64_t i, std::int64_t lanes) { along_j.solve(c + k * plane + i, lanes, 1); });
    }
  });
  in_two(ny, [&](std::int64_t first, std::int64_t last) {
    Lines<T> along_k(nz, plane);
    for (std::int64_t j = first; j < last; ++j) {
      in_lanes(row, [&](std::int64_t i, std::int64_t lanes) { along_k.solve(c + j * row + i, lanes, 1); });
    }
  });
  return {result, c};
}

template std::shared_ptr<const float> interpolating_coefficients(const GridGeometry&, int, const float*);
template std::shared_ptr<const double> interpolating_coefficients(const GridGeometry&, int, const double*);

}  // namespace palpa::detail
