#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "palpa/mode/parameters.h"

namespace palpa {
namespace {

using Point = TransferFunction::Point;
using Side = TransferFunction::Side;

/// Finite, with finite differences.
bool is_usable(double number) noexcept { return std::abs(number) <= 1e300; }

/// First point beyond `value` when approached from `side`: end of the piece that applies.
std::vector<Point>::const_iterator end_of_piece(const std::vector<Point>& points, double value, Side side) noexcept {
  if (side == Side::above) {
    return std::upper_bound(points.begin(), points.end(), value, [](double v, const Point& p) { return v < p.value; });
  }
  return std::lower_bound(points.begin(), points.end(), value, [](const Point& p, double v) { return p.value < v; });
}

}  // namespace

TransferFunction::TransferFunction(std::vector<Point> points, double outside) : points_(std::move(points)), outside_(outside) {
  if (points_.empty()) throw std::invalid_argument("a transfer function has no points; it needs at least one");
  if (!is_usable(outside_))
    throw std::invalid_argument("a transfer function's outside is not finite; give a number up to 1e300");
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!is_usable(points_[i].value) || !is_usable(points_[i].result)) {
      throw std::invalid_argument("a transfer function has a point that is not finite; give numbers up to 1e300");
    }
    if (i >= 1 && points_[i].value < points_[i - 1].value) {
      throw std::invalid_argument("a transfer function's values fall; sort the points by value");
    }
    if (i >= 2 && points_[i].value == points_[i - 2].value) {
      throw std::invalid_argument("a transfer function has three points of one value; a step has two");
    }
  }
}

double TransferFunction::at(double value, Side side) const noexcept {
  if (points_.empty() || std::isnan(value)) return 0.0;
  if (value < points_.front().value || value > points_.back().value) return outside_;
  const auto end = end_of_piece(points_, value, side);
  if (end == points_.begin()) return points_.front().result;
  if (end == points_.end()) return points_.back().result;
  const Point& a = *(end - 1);
  const Point& b = *end;
  return std::lerp(a.result, b.result, (value - a.value) / (b.value - a.value));
}

double TransferFunction::slope_at(double value, Side side) const noexcept {
  if (points_.empty() || std::isnan(value)) return 0.0;
  const auto end = end_of_piece(points_, value, side);
  if (end == points_.begin() || end == points_.end()) return 0.0;
  const Point& a = *(end - 1);
  const Point& b = *end;
  constexpr double largest = std::numeric_limits<double>::max();
  return std::clamp((b.result - a.result) / (b.value - a.value), -largest, largest);
}

bool TransferFunction::stays_zero_at(double value) const noexcept {
  return at(value, Side::below) == 0.0 && at(value, Side::above) == 0.0 && slope_at(value, Side::below) == 0.0 &&
         slope_at(value, Side::above) == 0.0;
}

}  // namespace palpa
