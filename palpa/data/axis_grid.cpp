#include "palpa/data/axis_grid.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "palpa/data/filter.h"
#include "palpa/data/grid_base.h"
#include "palpa/data/spline.h"

namespace palpa {
namespace {

/// Interpolated quantities: the dyad's xx, yy, zz, xy, xz, yz, and the length.
constexpr int channels = 7;
using Sums = double[channels];

Mat3 dyads_in(const Sums& s) noexcept { return {{{s[0], s[3], s[4]}, {s[3], s[1], s[5]}, {s[4], s[5], s[2]}}}; }
double trace(const Mat3& m) noexcept { return m.row[0].x + m.row[1].y + m.row[2].z; }
double trace_of_product(const Mat3& a, const Mat3& b) noexcept {
  return dot(a.row[0], b.row[0]) + dot(a.row[1], b.row[1]) + dot(a.row[2], b.row[2]);
}

/// Largest eigenvalue of a symmetric matrix and its unit eigenvector, by Jacobi's rotations: unlike a root of the
/// characteristic polynomial, exact near double eigenvalues, too.
struct Principal {
  double value = 0.0;
  Vec3 direction;

  explicit Principal(const Mat3& symmetric) noexcept {
    double a[3][3], v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int r = 0; r < 3; ++r) a[r][0] = symmetric.row[r].x, a[r][1] = symmetric.row[r].y, a[r][2] = symmetric.row[r].z;
    constexpr int most_sweeps = 10;  // [1] five are enough, by quadratic convergence; fewer: off-diagonals remain
    for (int sweep = 0; sweep < most_sweeps; ++sweep) {
      bool turned = false;
      for (const auto& [p, q] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
        const double off = a[p][q];
        if (!(std::abs(off) > 1e-17 * (std::abs(a[p][p]) + std::abs(a[q][q])))) continue;
        turned = true;
        const double theta = 0.5 * (a[q][q] - a[p][p]) / off;
        const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::hypot(theta, 1.0));
        const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
        const int r = 3 - p - q;
        a[p][p] -= t * off;
        a[q][q] += t * off;
        a[p][q] = a[q][p] = 0.0;
        const double rp = a[r][p], rq = a[r][q];
        a[r][p] = a[p][r] = c * rp - s * rq;
        a[r][q] = a[q][r] = s * rp + c * rq;
        for (auto& row : v) {
          const double vp = row[p], vq = row[q];
          row[p] = c * vp - s * vq;
          row[q] = s * vp + c * vq;
        }
      }
      if (!turned) break;
    }
    int n = 0;
    for (int m = 1; m < 3; ++m) n = a[m][m] > a[n][n] ? m : n;
    value = a[n][n];
    direction = normalized({v[0][n], v[1][n], v[2][n]});
  }
};

/// ±e L g, and its derivative in a direction in which the sums change by `slope`.
class Axis {
 public:
  explicit Axis(const Sums& sums) noexcept : dyads_(dyads_in(sums)), length_(sums[6]) {
    const Principal principal(dyads_);
    const double l = principal.value, t = trace(dyads_);
    if (!(l > 0.0) || !std::isfinite(t)) return;
    minors_ = 0.5 * (t * t - trace_of_product(dyads_, dyads_));
    const double gap = 3.0 - 2.0 * t / l + minors_ / (l * l);  // (λ₁ − λ₂)(λ₁ − λ₃)/λ₁²
    constexpr double rounding = 1e-14;  // [1] less: rounding picks a direction; more: weak directions count as none
    if (!(gap > rounding)) return;
    value_ = l;
    gap_ = std::min(gap, 1.0);
    direction_ = principal.direction;
    const double parts[3] = {direction_.x, direction_.y, direction_.z};
    const double* largest = std::max_element(parts, parts + 3, [](double a, double b) { return std::abs(a) < std::abs(b); });
    if (*largest < 0.0) direction_ = -direction_;
  }

  Vec3 value() const noexcept { return length_ * gap_ * direction_; }

  Vec3 derivative(const Sums& slope) const noexcept {
    if (gap_ == 0.0) return {};
    const Mat3 d = dyads_in(slope);
    const double l = value_, t = trace(dyads_);
    const Vec3 pushed = d * direction_;
    const double dl = dot(direction_, pushed), dt = trace(d);
    const double dminors = t * dt - trace_of_product(dyads_, d);
    const double dgap = (-2.0 * dt + (2.0 * t * dl + dminors - 2.0 * minors_ * dl / l) / l) / l;
    // g de = Σ over the other eigenvectors m of eₘ (eₘ·D'e) g/(λ₁ − λₘ); both gaps in g make it [(2λ₁ − t) I + D] / λ₁² across
    // e.
    const Vec3 across = pushed - dl * direction_;
    const Vec3 turning = ((2.0 * l - t) * across + dyads_ * across) / (l * l);
    return length_ * turning + (slope[6] * gap_ + length_ * dgap) * direction_;
  }

 private:
  Mat3 dyads_;
  double length_;
  double value_ = 0.0;   ///< λ₁
  double minors_ = 0.0;  ///< λ₁λ₂ + λ₁λ₃ + λ₂λ₃
  double gap_ = 0.0;     ///< g
  Vec3 direction_;
};

/// Weights along an axis of the voxels about a position, and their derivatives.
template <Filter>
struct Weights;
template <>
struct Weights<Filter::trilinear> {
  static constexpr int count = 2, before = 0;  ///< number of voxels; voxels before the cell's first
  double w[2], d[2];
  explicit Weights(double f) noexcept : w{1.0 - f, f}, d{-1.0, 1.0} {}
};
template <>
struct Weights<Filter::smooth> : detail::SplineWeights {
  static constexpr int count = 4, before = 1;
  using SplineWeights::SplineWeights;
};

template <class T, Filter filter>
class AxisGrid final : public detail::GridBase {
 public:
  AxisGrid(const GridGeometry& geometry, Voxels voxels, double scale, double offset)
      : GridBase(geometry, std::move(voxels), scale, offset, filter, true),
        data_(static_cast<const T*>(view_.voxels.data.get())) {
    for (const ValueRange& e : GridBase::value_ranges()) {
      const double reach = std::max(std::abs(e.min), std::abs(e.max));
      extents_.push_back({-reach, reach});
      unit_ = std::max(unit_, reach);
    }
    unit_ = unit_ > 0.0 ? std::scalbn(1.0, std::ilogb(unit_)) : 1.0;
  }

  std::vector<ValueRange> value_ranges() const override { return extents_; }
  int values_per_sample() const noexcept override {
    return channels * Weights<filter>::count * Weights<filter>::count * Weights<filter>::count;
  }

  VectorSample vector_in(Place& place) const noexcept override {
    if (!place.inside) return {};
    const Cell(&cells)[3] = place.cells;
    Sums value, slopes[3];
    interpolate(cells, value, slopes);
    if (!std::isfinite(value[0] + value[1] + value[2])) return {};  // a non-finite voxel, at any weight
    const Axis axis(value);
    Vec3 derivatives[3];
    for (int a = 0; a < 3; ++a) derivatives[a] = cells[a].per_step * axis.derivative(slopes[a]);
    VectorSample sample{unit_ * axis.value(), {}, true};
    const Mat3 by_index = transposed(Mat3{{derivatives[0], derivatives[1], derivatives[2]}});
    for (int c = 0; c < 3; ++c) sample.jacobian.row[c] = transposed_times(world_to_steps_, unit_ * by_index.row[c]);
    return is_finite(sample.value) && is_finite(sample.jacobian) ? sample : VectorSample{};
  }

 protected:
  /// An axis has no polynomial and no levels; only presence of data is returned.
  void polynomial(int component, const Passage& cell, const ValueRange&, PolynomialPiece& piece) const noexcept override {
    constexpr int count = Weights<filter>::count, before = Weights<filter>::before;
    double poison = 0.0;
    for (int n = 0; n < count * count * count; ++n) {
      const int steps[3] = {n % count - before, n / count % count - before, n / count / count - before};
      std::int64_t at = component;
      for (int a = 0; a < 3; ++a) {
        at += std::clamp<std::int64_t>(cell.first[a] + steps[a], 0, view_.geometry.dims[a] - 1) * stride_[a];
      }
      const auto voxel = static_cast<double>(data_[at]);
      poison += voxel - voxel;
    }
    piece.control[0] = poison;
    piece.degree = 0;
  }

 private:
  void interpolate(const Cell (&cells)[3], Sums& value, Sums (&slopes)[3]) const noexcept {
    using AxisWeights = Weights<filter>;
    constexpr int count = AxisWeights::count;
    const AxisWeights i(cells[0].f), j(cells[1].f), k(cells[2].f);
    std::int64_t at[3][count];
    for (int a = 0; a < 3; ++a) {
      const std::int64_t last = view_.geometry.dims[a] - 1;
      for (int n = 0; n < count; ++n) {
        at[a][n] = std::clamp<std::int64_t>(cells[a].first + n - AxisWeights::before, 0, last) * stride_[a];
      }
    }
    std::fill_n(value, channels, 0.0);
    for (Sums& slope : slopes) std::fill_n(slope, channels, 0.0);
    for (int kk = 0; kk < count; ++kk) {
      for (int jj = 0; jj < count; ++jj) {
        const T* row = data_ + at[2][kk] + at[1][jj];
        double along[channels] = {}, steep[channels] = {};
        for (int ii = 0; ii < count; ++ii) {
          const T* raw = row + at[0][ii];
          const Vec3 v{part(raw[0]), part(raw[1]), part(raw[2])};
          const double terms[channels] = {v.x * v.x, v.y * v.y, v.z * v.z, v.x * v.y, v.x * v.z, v.y * v.z, norm(v)};
          for (int c = 0; c < channels; ++c) {
            along[c] += i.w[ii] * terms[c];
            steep[c] += i.d[ii] * terms[c];
          }
        }
        for (int c = 0; c < channels; ++c) {
          value[c] += j.w[jj] * k.w[kk] * along[c];
          slopes[0][c] += j.w[jj] * k.w[kk] * steep[c];
          slopes[1][c] += j.d[jj] * k.w[kk] * along[c];
          slopes[2][c] += j.w[jj] * k.d[kk] * along[c];
        }
      }
    }
  }

  /// Component in units near the largest: its square neither overflows nor underflows.
  double part(T raw) const noexcept { return (static_cast<double>(raw) * view_.scale + view_.offset) / unit_; }

  const T* data_;
  double unit_ = 0.0;
  std::vector<ValueRange> extents_;
};

}  // namespace

FieldPtr axis_grid_field(const GridGeometry& geometry, Voxels voxels, double scale, double offset, Filter filter) {
  detail::check_grid(geometry, voxels, scale, offset);
  if (voxels.components != 3) throw std::invalid_argument("a scalar field has no axis; only a vector's sign can mean nothing");
  if (filter == Filter::cubic) {
    throw std::invalid_argument("axes cannot be met by a cubic; the trilinear filter or the smooth one suits them");
  }
  return detail::with_values_of(voxels, [&]<class T>(const T*) -> FieldPtr {
    if (filter == Filter::smooth) {
      return std::make_shared<const AxisGrid<T, Filter::smooth>>(geometry, std::move(voxels), scale, offset);
    }
    return std::make_shared<const AxisGrid<T, Filter::trilinear>>(geometry, std::move(voxels), scale, offset);
  });
}

bool is_axis_field(const Field& field) noexcept {
  const GridView* grid = grid_below(field);
  return grid && grid->signless;
}

}  // namespace palpa
