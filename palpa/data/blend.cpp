#include "palpa/data/blend.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "palpa/data/quantile.h"

namespace palpa::detail {

namespace {

/// Degree elevation.
void raise(PolynomialPiece& piece, int degree) noexcept {
  for (; piece.degree < degree; ++piece.degree) {
    const int n = piece.degree + 1;
    piece.control[n] = piece.control[n - 1];
    for (int i = n - 1; i > 0; --i) {
      const double share = static_cast<double>(i) / n;
      piece.control[i] = share * piece.control[i - 1] + (1.0 - share) * piece.control[i];
    }
  }
}

}  // namespace

ScalarSample blend(const ScalarSample& a, const ScalarSample& b, double u) noexcept {
  if (!a.inside || !b.inside) return {};
  return {(1.0 - u) * a.value + u * b.value, (1.0 - u) * a.gradient + u * b.gradient, true};
}

Mat3 blend(const Mat3& a, const Mat3& b, double u) noexcept {
  Mat3 m;
  for (int i = 0; i < 3; ++i) m.row[i] = (1.0 - u) * a.row[i] + u * b.row[i];
  return m;
}

VectorSample blend(const VectorSample& a, const VectorSample& b, double u) noexcept {
  if (!a.inside || !b.inside) return {};
  return {(1.0 - u) * a.value + u * b.value, blend(a.jacobian, b.jacobian, u), true};
}

LipschitzBound blend(const LipschitzBound& a, const LipschitzBound& b, double u, double largest) noexcept {
  const double radius_m = std::min(a.radius_m, b.radius_m);
  if (!(radius_m > 0.0)) return {};
  // [1] of the largest value: two products and a sum, of an interpolant that overshoots its samples by a few times.
  constexpr double of_blend = 64.0 * std::numeric_limits<double>::epsilon();
  const LipschitzBound blended{radius_m, (1.0 - u) * a.slope_per_m + u * b.slope_per_m,
                               (1.0 - u) * a.rounding + u * b.rounding + of_blend * largest,
                               (1.0 - u) * a.bend_per_m2 + u * b.bend_per_m2};
  return std::isfinite(blended.slope_per_m + blended.rounding) ? blended : LipschitzBound{};
}

void keep_first(PolynomialPiece& piece, double share) noexcept {
  for (int level = 1; level <= piece.degree; ++level) {
    for (int i = piece.degree; i >= level; --i) {
      piece.control[i] = (1.0 - share) * piece.control[i - 1] + share * piece.control[i];
    }
  }
}

PolynomialPiece joined_pieces(PolynomialPiece a, PolynomialPiece b, double begin, double u) noexcept {
  const double end = std::min(a.end, b.end);
  if (!a.inside || !b.inside || a.degree < 0 || b.degree < 0) return {.end = end};
  for (PolynomialPiece* piece : {&a, &b}) {
    if (piece->end > end) keep_first(*piece, (end - begin) / (piece->end - begin));
    raise(*piece, std::max(a.degree, b.degree));
  }
  for (int i = 0; i <= a.degree; ++i) a.control[i] = (1.0 - u) * a.control[i] + u * b.control[i];
  a.end = end;
  return a;
}

double noise_of_gradient(const Field& field, int places, const std::function<Vec3(int)>& place) {
  const double h = field.spacing_m();
  std::vector<double> differences;
  for (int i = 1; i <= places; ++i) {
    const Vec3 at = place(i);
    const Vec3 step = i % 3 == 0 ? Vec3{h, 0, 0} : i % 3 == 1 ? Vec3{0, h, 0} : Vec3{0, 0, h};
    const ScalarSample here = field.scalar(at), ahead = field.scalar(at + step), behind = field.scalar(at - step);
    if (!here.inside || !ahead.inside || !behind.inside) continue;
    const Vec3 second = (ahead.gradient - here.gradient) - (here.gradient - behind.gradient);
    if (is_finite(second)) differences.insert(differences.end(), {std::abs(second.x), std::abs(second.y), std::abs(second.z)});
  }
  constexpr double median_of_normal = 0.6745;  // |x| of a standard normal variable
  // Of independent values a second difference has six times the variance of one.
  return 3.0 * median(differences) / (median_of_normal * std::numbers::sqrt2 * std::numbers::sqrt3);
}

}  // namespace palpa::detail
