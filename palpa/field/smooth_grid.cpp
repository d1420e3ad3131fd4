#include "palpa/field/smooth_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "palpa/field/grid_base.h"
#include "palpa/field/spline.h"

namespace palpa {
namespace {

/// The four weights along a straight piece from t = begin to end: cubics of the share of the piece, as Bernstein coefficients.
/// They are the values of the cubics' polar forms at the ends of the piece; none is negative, and together they are 1.
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

/// Coefficients times their binomials: products of polynomials are then sums like those of powers.
constexpr double binomials_3[4] = {1, 3, 3, 1};
constexpr double binomials_9[10] = {1, 9, 36, 84, 126, 126, 84, 36, 9, 1};

/// Value, index derivatives and second index derivatives of one component, raw.
struct Raw {
  double value = 0.0;
  Vec3 first;
  double ii = 0.0, jj = 0.0, kk = 0.0, ij = 0.0, ik = 0.0, jk = 0.0;
};

/// One class for all types of voxel.
class SmoothGrid : public detail::GridBase {
 public:
  using GridBase::GridBase;
};

template <class T>
class TypedSmoothGrid final : public SmoothGrid {
 public:
  /// `coefficients` are as many as the voxels: the voxels themselves, or what makes the spline meet them.
  TypedSmoothGrid(const GridGeometry& geometry, Voxels voxels, double scale, double offset, Filter filter,
                  std::shared_ptr<const T> coefficients)
      : SmoothGrid(geometry, std::move(voxels), scale, offset, filter, false, std::move(coefficients)),
        data_(static_cast<const T*>(coefficients_.get())) {}

  ScalarSample scalar(const Vec3& world_m) const noexcept override {
    Cell cells[3];
    if (view_.voxels.components != 1 || !locate(world_m, cells)) return {};
    const Raw raw = Stencil(*this, cells).template evaluate<false>(data_);
    const ScalarSample sample{raw.value * view_.scale + view_.offset, gradient_of(raw.first, cells), true};
    return std::isfinite(sample.value) && is_finite(sample.gradient) ? sample : ScalarSample{};
  }

  VectorSample vector(const Vec3& world_m) const noexcept override {
    Cell cells[3];
    if (view_.voxels.components != 3 || !locate(world_m, cells)) return {};
    const Stencil stencil(*this, cells);
    VectorSample sample;
    double value[3];
    for (int c = 0; c < 3; ++c) {
      const Raw raw = stencil.template evaluate<false>(data_ + c);
      value[c] = raw.value * view_.scale + view_.offset;
      sample.jacobian.row[c] = gradient_of(raw.first, cells);
    }
    sample.value = {value[0], value[1], value[2]};
    sample.inside = true;
    return is_finite(sample.value) && is_finite(sample.jacobian) ? sample : VectorSample{};
  }

  Mat3 hessian(const Vec3& world_m) const noexcept override {
    Cell cells[3];
    if (view_.voxels.components != 1 || !locate(world_m, cells)) return {};
    const Raw raw = Stencil(*this, cells).template evaluate<true>(data_);
    const double i = cells[0].per_step, j = cells[1].per_step, k = cells[2].per_step;
    const Mat3 index_hessian{{{raw.ii * i * i, raw.ij * i * j, raw.ik * i * k},
                              {raw.ij * i * j, raw.jj * j * j, raw.jk * j * k},
                              {raw.ik * i * k, raw.jk * j * k, raw.kk * k * k}}};
    const Mat3 h = transposed(world_to_steps_) * (view_.scale * index_hessian) * world_to_steps_;
    return is_finite(h) ? h : Mat3{};
  }

 protected:
  void polynomial(int component, const Passage& cell, const Extent& quiet, Stretch& piece) const noexcept override {
    const T* data = data_ + component;
    std::int64_t at[3][4];
    for (int a = 0; a < 3; ++a) {
      for (int n = 0; n < 4; ++n) {
        at[a][n] = std::clamp<std::int64_t>(cell.first[a] + n - 1, 0, view_.geometry.dims[a] - 1) * stride_[a];
      }
    }
    double c[4][4][4];  // [k][j][i]
    double least = std::numeric_limits<double>::infinity(), greatest = -least, poison = 0.0;
    for (int k = 0; k < 4; ++k) {
      for (int j = 0; j < 4; ++j) {
        for (int i = 0; i < 4; ++i) {
          const double v = static_cast<double>(data[at[2][k] + at[1][j] + at[0][i]]);
          c[k][j][i] = v;
          least = std::min(least, v);
          greatest = std::max(greatest, v);
          poison += v - v;
        }
      }
    }
    if (poison == 0.0 && is_quiet(least, greatest, quiet)) {
      piece.degree = -1;
      return;
    }

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
  /// The 64 coefficients of a position: where they lie, and their weights along each axis.
  class Stencil {
   public:
    Stencil(const TypedSmoothGrid& grid, const Cell (&cells)[3]) noexcept : i_(cells[0].f), j_(cells[1].f), k_(cells[2].f) {
      for (int a = 0; a < 3; ++a) {
        const std::int64_t last = grid.view_.geometry.dims[a] - 1;
        for (int n = 0; n < 4; ++n) {
          at_[a][n] = std::clamp<std::int64_t>(cells[a].first + n - 1, 0, last) * grid.stride_[a];
        }
      }
    }

    /// A coefficient that is not finite makes the value so, whatever its weight (0·∞ is NaN).
    template <bool Second>
    Raw evaluate(const T* component) const noexcept {
      Raw r;
      for (int k = 0; k < 4; ++k) {
        double value = 0.0, di = 0.0, dj = 0.0, dii = 0.0, djj = 0.0, dij = 0.0;
        for (int j = 0; j < 4; ++j) {
          const T* row = component + at_[2][k] + at_[1][j];
          const double c0 = static_cast<double>(row[at_[0][0]]), c1 = static_cast<double>(row[at_[0][1]]);
          const double c2 = static_cast<double>(row[at_[0][2]]), c3 = static_cast<double>(row[at_[0][3]]);
          const double along = (i_.w[0] * c0 + i_.w[1] * c1) + (i_.w[2] * c2 + i_.w[3] * c3);
          const double slope = (i_.d[0] * c0 + i_.d[1] * c1) + (i_.d[2] * c2 + i_.d[3] * c3);
          value += j_.w[j] * along;
          di += j_.w[j] * slope;
          dj += j_.d[j] * along;
          if constexpr (Second) {
            const double bend = (i_.e[0] * c0 + i_.e[1] * c1) + (i_.e[2] * c2 + i_.e[3] * c3);
            dii += j_.w[j] * bend;
            djj += j_.e[j] * along;
            dij += j_.d[j] * slope;
          }
        }
        r.value += k_.w[k] * value;
        r.first += Vec3{k_.w[k] * di, k_.w[k] * dj, k_.d[k] * value};
        if constexpr (Second) {
          r.ii += k_.w[k] * dii;
          r.jj += k_.w[k] * djj;
          r.ij += k_.w[k] * dij;
          r.kk += k_.e[k] * value;
          r.ik += k_.d[k] * di;
          r.jk += k_.d[k] * dj;
        }
      }
      return r;
    }

   private:
    detail::SplineWeights i_, j_, k_;
    std::int64_t at_[3][4];
  };

  const T* data_;
};

}  // namespace

FieldPtr smooth_grid_field(const GridGeometry& geometry, Voxels voxels, double scale, double offset) {
  detail::check_grid(geometry, voxels, scale, offset);
  return detail::with_values_of(voxels, [&]<class T>(const T* values) -> FieldPtr {
    std::shared_ptr<const T> coefficients(voxels.data, values);
    return std::make_shared<const TypedSmoothGrid<T>>(geometry, std::move(voxels), scale, offset, Filter::smooth,
                                                      std::move(coefficients));
  });
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
