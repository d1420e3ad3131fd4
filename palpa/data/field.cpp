#include "palpa/data/field.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpa {

LipschitzBound LipschitzBound::scaled(double scale, double shift_m) const noexcept {
  const LipschitzBound seen{((1.0 - 1e-12) * radius_m - 2.0 * shift_m) * scale, slope_per_m / scale,
                            rounding + 2.0 * slope_per_m * shift_m, bend_per_m2 / (scale * scale), values};
  const bool usable = seen.radius_m > 0.0 && std::isfinite(seen.radius_m + seen.slope_per_m + seen.rounding);
  return usable ? seen : LipschitzBound{};
}

LipschitzBound LipschitzBound::posed(const Similarity& pose, const Vec3& world_m) const noexcept {
  const double shift_m =
      16.0 * std::numeric_limits<double>::epsilon() * (norm(world_m) + norm(pose.translation_m)) / pose.scale;
  return scaled(pose.scale, shift_m);
}

ScalarSample Field::scalar(const Vec3&) const noexcept { return {}; }
VectorSample Field::vector(const Vec3&) const noexcept { return {}; }

Mat3 Field::hessian(const Vec3& world_m) const noexcept {
  const ScalarSample here = scalar(world_m);
  if (!here.inside) return {};
  const double step_m = 0.25 * spacing_m();
  const Vec3 steps[3] = {{step_m, 0, 0}, {0, step_m, 0}, {0, 0, step_m}};
  Mat3 h;
  for (int a = 0; a < 3; ++a) {
    const ScalarSample ahead = scalar(world_m + steps[a]), behind = scalar(world_m - steps[a]);
    const int sides = int(ahead.inside) + int(behind.inside);  // at a face there is only one
    if (sides == 0) continue;
    h.row[a] = ((ahead.inside ? ahead : here).gradient - (behind.inside ? behind : here).gradient) / (sides * step_m);
  }
  const Mat3 symmetric =
      0.5 * Mat3{{h.row[0] + transposed(h).row[0], h.row[1] + transposed(h).row[1], h.row[2] + transposed(h).row[2]}};
  return is_finite(symmetric) ? symmetric : Mat3{};
}

PolynomialPiece Field::piece_along(const Vec3& from_m, const Vec3& to_m, double begin, const ValueRange&) const noexcept {
  return cubic_piece(from_m, to_m, begin, 0.25 * spacing_m());
}

PolynomialPiece Field::cubic_piece(const Vec3& from_m, const Vec3& to_m, double begin, double longest_m) const noexcept {
  const Vec3 way_m = to_m - from_m;
  const double length_m = norm(way_m);
  PolynomialPiece piece;
  if (!is_finite(from_m) || !std::isfinite(length_m) || !(begin >= 0.0 && begin < 1.0)) return piece;
  const Box box = bounds_m();
  const double from[3] = {from_m.x, from_m.y, from_m.z}, way[3] = {way_m.x, way_m.y, way_m.z};
  const double low[3] = {box.low_m.x, box.low_m.y, box.low_m.z}, high[3] = {box.high_m.x, box.high_m.y, box.high_m.z};
  double enters = 0.0, leaves = 1.0;
  for (int a = 0; a < 3; ++a) {
    if (way[a] == 0.0) {
      if (from[a] < low[a] || from[a] > high[a]) return piece;
      continue;
    }
    const double one = (low[a] - from[a]) / way[a], other = (high[a] - from[a]) / way[a];
    enters = std::max(enters, std::min(one, other));
    leaves = std::min(leaves, std::max(one, other));
  }
  if (enters > leaves || (begin >= leaves && leaves < 1.0)) return piece;
  if (begin < enters) {
    piece.end = enters;
    return piece;
  }

  const auto place = [&](double s) { return s < 1.0 ? from_m + s * way_m : to_m; };
  if (components() != 1) {
    piece.end = leaves;
    piece.inside = vector(place(0.5 * (begin + leaves))).inside;
    return piece;
  }

  const double whole = leaves - begin;
  const double share = length_m * whole > longest_m ? longest_m / length_m : whole;
  piece.end = share < whole ? std::max(begin + share, std::nextafter(begin, 1.0)) : leaves;
  const auto at = [&](double s) { return scalar(place(s)); };
  const ScalarSample first = at(begin), last = at(piece.end);
  const double step = piece.end - begin;
  if (first.inside && last.inside) {
    piece.inside = true;
    piece.degree = 3;
    piece.control[0] = first.value;
    piece.control[1] = first.value + step / 3.0 * dot(first.gradient, way_m);
    piece.control[2] = last.value - step / 3.0 * dot(last.gradient, way_m);
    piece.control[3] = last.value;
  } else {
    // An end on a face, by rounding, or next to a hole in the data: the tangent at the middle.
    const ScalarSample middle = at(begin + 0.5 * step);
    piece.inside = middle.inside;
    piece.degree = 1;
    const double half = 0.5 * step * dot(middle.gradient, way_m);
    piece.control[0] = middle.value - half;
    piece.control[1] = middle.value + half;
  }
  for (const double c : piece.control) {
    if (!std::isfinite(c)) piece.inside = false;
  }
  if (!piece.inside) piece = {.end = piece.end};
  return piece;
}

}  // namespace palpa
