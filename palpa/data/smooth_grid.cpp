#include "palpa/data/smooth_grid.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
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

/// Four values of two rows, side by side.
template <class T>
void read_rows(const T* row, const T* beyond, Pair (&c)[4]) noexcept {
  if constexpr (sizeof(T) == 2 || sizeof(T) == 4) {  // by way of 32-bit numbers, which hold all of them
    using Wide = std::conditional_t<std::is_floating_point_v<T>, float, std::int32_t>;
    typedef T Four __attribute__((vector_size(4 * sizeof(T))));  // g++ ignores the attribute of a `using`
    typedef Wide WideFour __attribute__((vector_size(16)));
    typedef Wide WideEight __attribute__((vector_size(32)));
    typedef double Doubles __attribute__((vector_size(32)));
    Four a, b;
    std::memcpy(&a, row, sizeof a);
    std::memcpy(&b, beyond, sizeof b);
    WideFour first, last;
    if constexpr (sizeof(T) == 2) {
      const WideEight all = __builtin_convertvector(__builtin_shufflevector(a, b, 0, 4, 1, 5, 2, 6, 3, 7), WideEight);
      first = __builtin_shufflevector(all, all, 0, 1, 2, 3);
      last = __builtin_shufflevector(all, all, 4, 5, 6, 7);
    } else {
      first = __builtin_shufflevector(a, b, 0, 4, 1, 5);
      last = __builtin_shufflevector(a, b, 2, 6, 3, 7);
    }
    const auto low = __builtin_convertvector(first, Doubles), high = __builtin_convertvector(last, Doubles);
    c[0] = Pair{low[0], low[1]};
    c[1] = Pair{low[2], low[3]};
    c[2] = Pair{high[0], high[1]};
    c[3] = Pair{high[2], high[3]};
  } else {
    for (int n = 0; n < 4; ++n) c[n] = Pair{static_cast<double>(row[n]), static_cast<double>(beyond[n])};
  }
}

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
    double least, greatest;
    double poison;  ///< NaN if any is not finite

    CellCoefficients(const TypedSmoothGrid& of, int component, const Passage& cell) noexcept : grid(of) {
      std::int64_t at[3][4];
      for (int a = 0; a < 3; ++a) {
        for (int n = 0; n < 4; ++n) {
          at[a][n] = std::clamp<std::int64_t>(cell.first[a] + n - 1, 0, of.view_.geometry.dims[a] - 1) * of.stride_[a];
        }
      }
      constexpr double infinity = std::numeric_limits<double>::infinity();
      Extremes range{Pair{infinity, infinity}, Pair{-infinity, -infinity}};
      Pair spoilt{};
      for (int k = 0; k < 4; ++k) {
        for (int j = 0; j < 4; ++j) {
          const T* const row = of.data_ + (component + at[2][k] + at[1][j] - of.before_window_);
          for (int i = 0; i < 4; ++i) c[k][j][i] = static_cast<double>(row[at[0][i]]);
          const Pair first{c[k][j][0], c[k][j][1]}, last{c[k][j][2], c[k][j][3]};
          range.take(first);
          range.take(last);
          spoilt += (first - first) + (last - last);
        }
      }
      least = std::min(range.least[0], range.least[1]);
      greatest = std::max(range.greatest[0], range.greatest[1]);
      poison = spoilt[0] + spoilt[1];
    }

    /// Whether the value stays quiet on the piece: within the hull; or, for a short piece, near its start: an index derivative
    /// is bounded by the width of the hull; or near its chord.
    bool stays_quiet(const Passage& cell, const ValueRange& quiet) const noexcept {
      if (poison != 0.0 || !(quiet.min <= quiet.max)) return false;
      if (grid.is_quiet(least, greatest, quiet)) return true;
      double change = 0.0;
      for (int a = 0; a < 3; ++a) change += (greatest - least) * std::abs(cell.end[a] - cell.begin[a]);
      const double value = value_at(cell.begin);
      if (grid.is_quiet(std::max(least, value - change), std::min(greatest, value + change), quiet)) return true;
      const double end = value_at(cell.end), off = off_chord(cell);
      return grid.is_quiet(std::max(least, std::min(value, end) - off), std::min(greatest, std::max(value, end) + off), quiet);
    }
    double value_at(const double (&at)[3]) const noexcept {
      const detail::SplineWeights in_i(at[0]), in_j(at[1]), in_k(at[2]);
      Pair low{}, high{};
      for (int k = 0; k < 4; ++k) {
        for (int j = 0; j < 4; ++j) {
          const double w = in_k.w[k] * in_j.w[j];
          const double* const row = c[k][j];
          low += w * Pair{row[0], row[1]};
          high += w * Pair{row[2], row[3]};
        }
      }
      return (in_i.w[0] * low[0] + in_i.w[1] * low[1]) + (in_i.w[2] * high[0] + in_i.w[3] * high[1]);
    }
    /// Bound on the distance of the value from its chord along the piece: an eighth of its second derivative along it. Second
    /// index derivatives are means of second differences of the coefficients, here bounded by the largest.
    double off_chord(const Passage& cell) const noexcept {
      Extremes bends;
      for (int k = 0; k < 4; ++k) {
        for (int j = 0; j < 4; ++j) {
          const Run here(c[k][j]), by_i = here.differences();
          bends.take(by_i.last - by_i.first);
          if (k < 3) {
            const Run by_k = Run(c[k + 1][j]) - here;
            bends.take(by_k.differences());
            if (k < 2) bends.take((Run(c[k + 2][j]) - Run(c[k + 1][j])) - by_k);
            if (j < 3) bends.take((Run(c[k + 1][j + 1]) - Run(c[k][j + 1])) - by_k);
          }
          if (j < 3) {
            const Run by_j = Run(c[k][j + 1]) - here;
            bends.take(by_j.differences());
            if (j < 2) bends.take((Run(c[k][j + 2]) - Run(c[k][j + 1])) - by_j);
          }
        }
      }
      double way = 0.0;
      for (int a = 0; a < 3; ++a) way += std::abs(cell.end[a] - cell.begin[a]);
      const double most = std::max(std::max(bends.greatest[0], bends.greatest[1]), -std::min(bends.least[0], bends.least[1]));
      return 0.125 * way * way * most;
    }

   private:
    /// Four numbers along i.
    struct Run {
      Pair first, last;
      explicit Run(const double (&row)[4]) noexcept : first{row[0], row[1]}, last{row[2], row[3]} {}
      Run(const Pair& low, const Pair& high) noexcept : first(low), last(high) {}
      Run operator-(const Run& b) const noexcept { return {first - b.first, last - b.last}; }
      /// Of neighbours; the middle one twice.
      Run differences() const noexcept {
        const Pair middle{first[1], last[0]};
        return {middle - first, last - middle};
      }
    };
    struct Extremes {
      Pair least{}, greatest{};
      void take(const Pair& values) noexcept {
        least = values < least ? values : least;
        greatest = values > greatest ? values : greatest;
      }
      void take(const Run& values) noexcept { take(values.first), take(values.last); }
    };
  };

  bool is_scalar_at(const Place& place) const noexcept { return view_.voxels.components == 1 && place.inside; }

  ScalarSample sample_of(const Raw& raw, const Place& place) const noexcept {
    const ScalarSample sample{raw.value * view_.scale + view_.offset, gradient_of(raw.first, place.cells), true};
    return std::isfinite(sample.value) && is_finite(sample.gradient) ? sample : ScalarSample{};
  }

  /// The four coefficients of a row of a plane, in the first lane, and of the next plane, in the second.
  void load(const detail::SplineStencil& at, const T* row, const T* row_beyond, Pair (&c)[4]) const noexcept {
    const std::int64_t components = view_.voxels.components;
    if (components == 1 && at.is_inside_row()) {
      read_rows(row + at.at[0][0], row_beyond + at.at[0][0], c);
      return;
    }
    for (int n = 0; n < 4; ++n) {
      const std::int64_t voxel = components * at.at[0][n];
      c[n] = Pair{static_cast<double>(row[voxel]), static_cast<double>(row_beyond[voxel])};
    }
  }

  /// A non-finite coefficient makes the value so at any weight (0·∞ is NaN).
  template <bool Second>
  Raw evaluate(const detail::SplineStencil& at, int component) const noexcept {
    const std::int64_t components = view_.voxels.components;
    const T* const first = data_ + (component - before_window_);
    const auto along_i = [](const double(&weights)[4], const Pair(&c)[4]) {
      return (weights[0] * c[0] + weights[1] * c[1]) + (weights[2] * c[2] + weights[3] * c[3]);
    };
    Pair value_i{}, j_ij{};  // value and derivative along i; derivative along j and i j
    Pair k_ik{};             // along k, and i k
    double ii = 0.0, jj = 0.0, kk = 0.0, jk = 0.0;
    for (int k = 0; k < 4; k += 2) {
      Pair value{}, by_i{}, by_j{}, by_ij{}, by_ii{}, by_jj{};  // sums over two planes
      for (int j = 0; j < 4; ++j) {
        Pair c[4];
        load(at, first + components * (at.at[2][k] + at.at[1][j]), first + components * (at.at[2][k + 1] + at.at[1][j]), c);
        const Pair line = along_i(at.i.w, c), slope = along_i(at.i.d, c);
        value += at.j.w[j] * line;
        by_i += at.j.w[j] * slope;
        by_j += at.j.d[j] * line;
        by_ij += at.j.d[j] * slope;
        if constexpr (Second) {
          by_ii += at.j.w[j] * along_i(at.i.e, c);
          by_jj += at.j.e[j] * line;
        }
      }
      for (int plane = 0; plane < 2; ++plane) {
        const double w = at.k.w[k + plane], d = at.k.d[k + plane];
        value_i += w * Pair{value[plane], by_i[plane]};
        j_ij += w * Pair{by_j[plane], by_ij[plane]};
        k_ik += d * Pair{value[plane], by_i[plane]};
        if constexpr (Second) {
          ii += w * by_ii[plane];
          jj += w * by_jj[plane];
          kk += at.k.e[k + plane] * value[plane];
          jk += d * by_j[plane];
        }
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
