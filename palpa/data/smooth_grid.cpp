#include "palpa/data/smooth_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "palpa/data/grid_base.h"
#include "palpa/data/spline.h"

namespace palpa {
namespace {

/// The four weights along a straight piece from t = begin to end: cubics of the share of the piece, as Bernstein coefficients.
/// They are the cubics' polar forms at the ends of the piece; nonnegative, with sum 1.
struct WeightsAlong {
  double w[4][4];  // [weight][coefficient]

  WeightsAlong(double begin, double end) noexcept {
    for (int n = 0; n < 4; ++n) {
      const double x = n > 2 ? end : begin, y = n > 1 ? end : begin, z = n > 0 ? end : begin;
      const auto inner = [](double a, double b, double c) {
        return 2.0 / 3.0 - (a * b + b * c + c * a) / 3.0 + 0.5 * a * b * c;
      };
      w[0][n] = (1.0 - x) * (1.0 - y) * (1.0 - z) / 6.0;
      w[1][n] = inner(x, y, z);
      w[2][n] = inner(1.0 - x, 1.0 - y, 1.0 - z);
      w[3][n] = x * y * z / 6.0;
    }
  }
};

/// Coefficients times their binomials: products of polynomials become sums as for monomials.
constexpr double binomials_3[4] = {1, 3, 3, 1};
constexpr double binomials_9[10] = {1, 9, 36, 84, 126, 126, 84, 36, 9, 1};

/// Value, index derivatives and second index derivatives of a component, raw.
struct Raw {
  double value = 0.0;
  Vec3 first;
  double ii = 0.0, jj = 0.0, kk = 0.0, ij = 0.0, ik = 0.0, jk = 0.0;
};

/// Two doubles in a vector register, with the arithmetic of single ones.
using Pair = double __attribute__((vector_size(16)));

/// Common base for all types of voxel.
class SmoothGrid : public detail::GridBase {
 public:
  using GridBase::GridBase;
};

template <class T>
class TypedSmoothGrid final : public SmoothGrid {
 public:
  /// `coefficients`, as many as the voxels: the voxels themselves, or those of the interpolating spline.
  TypedSmoothGrid(const GridGeometry& geometry, Voxels voxels, double scale, double offset, Filter filter,
                  std::shared_ptr<const T> coefficients, const GridWindow* window = nullptr)
      : SmoothGrid(geometry, std::move(voxels), scale, offset, filter, false, std::move(coefficients), 0, window),
        data_(static_cast<const T*>(coefficients_.get())) {}

  ScalarSample scalar_in(Place& place) const noexcept override {
    return is_scalar_at(place) ? sample_of(evaluate<false>(place.stencil_of(view_.geometry.dims, window_.dims), 0), place)
                               : ScalarSample{};
  }

  ScalarSample scalar_in(Place& place, Mat3& hessian) const noexcept override {
    hessian = {};
    if (!is_scalar_at(place)) return {};
    const Raw raw = evaluate<true>(place.stencil_of(view_.geometry.dims, window_.dims), 0);
    const double i = place.cells[0].per_step, j = place.cells[1].per_step, k = place.cells[2].per_step;
    const Mat3 index_hessian{{{raw.ii * i * i, raw.ij * i * j, raw.ik * i * k},
                              {raw.ij * i * j, raw.jj * j * j, raw.jk * j * k},
                              {raw.ik * i * k, raw.jk * j * k, raw.kk * k * k}}};
    const Mat3 h = transposed(world_to_steps_) * (view_.scale * index_hessian) * world_to_steps_;
    if (is_finite(h)) hessian = h;
    return sample_of(raw, place);
  }
  bool has_curvature() const noexcept override { return true; }

  VectorSample vector_in(Place& place) const noexcept override {
    if (view_.voxels.components != 3 || !place.inside) return {};
    const detail::SplineStencil& stencil = place.stencil_of(view_.geometry.dims, window_.dims);
    VectorSample sample;
    double value[3];
    for (int c = 0; c < 3; ++c) {
      const Raw raw = evaluate<false>(stencil, c);
      value[c] = raw.value * view_.scale + view_.offset;
      sample.jacobian.row[c] = gradient_of(raw.first, place.cells);
    }
    sample.value = {value[0], value[1], value[2]};
    sample.inside = true;
    return is_finite(sample.value) && is_finite(sample.jacobian) ? sample : VectorSample{};
  }

  Mat3 hessian(const Vec3& world_m) const noexcept override {
    Place place = place_of(world_m);
    Mat3 hessian;
    scalar_in(place, hessian);
    return hessian;
  }

 protected:
  void polynomial(int component, const Passage& cell, const ValueRange& quiet, PolynomialPiece& piece) const noexcept override {
    const CellCoefficients cell_of(*this, component, cell);
    if (cell_of.stays_quiet(cell, quiet)) {
      piece.degree = -1;
      return;
    }
    const auto& c = cell_of.c;
    const WeightsAlong along[3] = {{cell.begin[0], cell.end[0]}, {cell.begin[1], cell.end[1]}, {cell.begin[2], cell.end[2]}};
    double scaled[3][4][4];
    for (int a = 0; a < 3; ++a) {
      for (int w = 0; w < 4; ++w) {
        for (int n = 0; n < 4; ++n) scaled[a][w][n] = binomials_3[n] * along[a].w[w][n];
      }
    }
    double sum[10]{};
    for (int k = 0; k < 4; ++k) {
      double plane[7]{};
      for (int j = 0; j < 4; ++j) {
        double row[4]{};
        for (int i = 0; i < 4; ++i) {
          for (int n = 0; n < 4; ++n) row[n] += c[k][j][i] * scaled[0][i][n];
        }
        for (int m = 0; m < 4; ++m) {
          for (int n = 0; n < 4; ++n) plane[m + n] += row[n] * scaled[1][j][m];
        }
      }
      for (int m = 0; m < 4; ++m) {
        for (int n = 0; n < 7; ++n) sum[m + n] += plane[n] * scaled[2][k][m];
      }
    }
    for (int n = 0; n < 10; ++n) piece.control[n] = sum[n] / binomials_9[n];
    piece.degree = 9;
  }

 private:
  /// Coefficients of a cell, raw.
  struct CellCoefficients {
    const TypedSmoothGrid& grid;
    double c[4][4][4];  ///< [k][j][i]
    double least = std::numeric_limits<double>::infinity(), greatest = -least;
    double poison = 0.0;  ///< NaN if any is not finite

    CellCoefficients(const TypedSmoothGrid& of, int component, const Passage& cell) noexcept : grid(of) {
      std::int64_t at[3][4];
      for (int a = 0; a < 3; ++a) {
        for (int n = 0; n < 4; ++n) {
          at[a][n] = std::clamp<std::int64_t>(cell.first[a] + n - 1, 0, of.view_.geometry.dims[a] - 1) * of.stride_[a];
        }
      }
      for (int k = 0; k < 4; ++k) {
        for (int j = 0; j < 4; ++j) {
          for (int i = 0; i < 4; ++i) {
            const double v = static_cast<double>(of.data_[component + at[2][k] + at[1][j] + at[0][i] - of.before_window_]);
            c[k][j][i] = v;
            least = std::min(least, v);
            greatest = std::max(greatest, v);
            poison += v - v;
          }
        }
      }
    }

    /// Whether the value stays quiet on the piece: within the hull, or, for a short piece, near its start. An index derivative
    /// is bounded by the width of the hull.
    bool stays_quiet(const Passage& cell, const ValueRange& quiet) const noexcept {
      if (poison != 0.0 || !(quiet.min <= quiet.max)) return false;
      if (grid.is_quiet(least, greatest, quiet)) return true;
      double change = 0.0;
      for (int a = 0; a < 3; ++a) change += (greatest - least) * std::abs(cell.end[a] - cell.begin[a]);
      const double value = at_begin(cell);
      return grid.is_quiet(std::max(least, value - change), std::min(greatest, value + change), quiet);
    }
    double at_begin(const Passage& cell) const noexcept {
      const detail::SplineWeights in_i(cell.begin[0]), in_j(cell.begin[1]), in_k(cell.begin[2]);
      double value = 0.0;
      for (int k = 0; k < 4; ++k) {
        for (int j = 0; j < 4; ++j) {
          const double* row = c[k][j];
          value +=
              in_k.w[k] * in_j.w[j] * ((in_i.w[0] * row[0] + in_i.w[1] * row[1]) + (in_i.w[2] * row[2] + in_i.w[3] * row[3]));
        }
      }
      return value;
    }
  };

  bool is_scalar_at(const Place& place) const noexcept { return view_.voxels.components == 1 && place.inside; }

  ScalarSample sample_of(const Raw& raw, const Place& place) const noexcept {
    const ScalarSample sample{raw.value * view_.scale + view_.offset, gradient_of(raw.first, place.cells), true};
    return std::isfinite(sample.value) && is_finite(sample.gradient) ? sample : ScalarSample{};
  }

  /// A non-finite coefficient makes the value so at any weight (0·∞ is NaN).
  template <bool Second>
  Raw evaluate(const detail::SplineStencil& at, int component) const noexcept {
    const std::int64_t components = view_.voxels.components;
    const std::int64_t first = component - before_window_;
    Pair along_i[4];  // weights of the value and of its derivative
    for (int n = 0; n < 4; ++n) along_i[n] = Pair{at.i.w[n], at.i.d[n]};
    Pair value_i{}, j_ij{};  // value and derivative along i; derivative along j and i j
    Pair k_ik{};             // along k, and i k
    double ii = 0.0, jj = 0.0, kk = 0.0, jk = 0.0;
    for (int k = 0; k < 4; ++k) {
      Pair plane{}, slope_j{};  // sums over a plane
      double bend_i = 0.0, bend_j = 0.0;
      for (int j = 0; j < 4; ++j) {
        const std::int64_t row = first + components * (at.at[2][k] + at.at[1][j]);
        Pair c[4];
        for (int n = 0; n < 4; ++n) {
          const auto voxel = static_cast<double>(data_[row + components * at.at[0][n]]);
          c[n] = Pair{voxel, voxel};
        }
        const Pair line = (along_i[0] * c[0] + along_i[1] * c[1]) + (along_i[2] * c[2] + along_i[3] * c[3]);
        plane += at.j.w[j] * line;
        slope_j += at.j.d[j] * line;
        if constexpr (Second) {
          const double bend = (at.i.e[0] * c[0][0] + at.i.e[1] * c[1][0]) + (at.i.e[2] * c[2][0] + at.i.e[3] * c[3][0]);
          bend_i += at.j.w[j] * bend;
          bend_j += at.j.e[j] * line[0];
        }
      }
      value_i += at.k.w[k] * plane;
      j_ij += at.k.w[k] * slope_j;
      k_ik += at.k.d[k] * plane;
      if constexpr (Second) {
        ii += at.k.w[k] * bend_i;
        jj += at.k.w[k] * bend_j;
        kk += at.k.e[k] * plane[0];
        jk += at.k.d[k] * slope_j[0];
      }
    }
    return {value_i[0], {value_i[1], j_ij[0], k_ik[0]}, ii, jj, kk, j_ij[1], k_ik[1], jk};
  }

  const T* data_;
};

}  // namespace

namespace {
FieldPtr made_smooth(const GridGeometry& geometry, Voxels voxels, double scale, double offset, const GridWindow* window) {
  detail::check_grid(geometry, voxels, scale, offset);
  return detail::with_values_of(voxels, [&]<class T>(const T* values) -> FieldPtr {
    std::shared_ptr<const T> coefficients(voxels.data, values);
    return std::make_shared<const TypedSmoothGrid<T>>(geometry, std::move(voxels), scale, offset, Filter::smooth,
                                                      std::move(coefficients), window);
  });
}
}  // namespace

FieldPtr smooth_grid_field(const GridGeometry& geometry, Voxels voxels, double scale, double offset) {
  return made_smooth(geometry, std::move(voxels), scale, offset, nullptr);
}

FieldPtr detail::smooth_window(const GridGeometry& whole, const GridWindow& window, Voxels voxels, double scale,
                               double offset) {
  return made_smooth(whole, std::move(voxels), scale, offset, &window);
}

FieldPtr cubic_grid_field(const GridGeometry& geometry, Voxels voxels, double scale, double offset) {
  detail::check_grid(geometry, voxels, scale, offset);
  return detail::with_values_of(voxels, [&]<class T>(const T* values) -> FieldPtr {
    if constexpr (std::is_floating_point_v<T>) {
      std::shared_ptr<const T> coefficients = detail::interpolating_coefficients(geometry, voxels.components, values);
      return std::make_shared<const TypedSmoothGrid<T>>(geometry, std::move(voxels), scale, offset, Filter::cubic,
                                                        std::move(coefficients));
    } else {
      throw std::invalid_argument("voxels of " + std::string(name_of(voxels.type)) +
                                  " cannot be met by a cubic: that would amplify the steps of whole numbers; the smooth "
                                  "filter, their default, or the trilinear one suits them");
    }
  });
}

const GridView* smooth_grid_of(const Field& field) noexcept {
  const GridView* grid = dynamic_cast<const SmoothGrid*>(&field) ? grid_behind(field) : nullptr;
  return grid && grid->filter == Filter::smooth ? grid : nullptr;
}

}  // namespace palpa
