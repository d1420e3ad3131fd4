// Transfer functions: piecewise linear functions of a field's value, for strengths and masks.
#pragma once

#include <vector>

namespace palpa {

/// Piecewise linear in the value; constant beyond the first and the last point is *not* assumed:
/// outside the points it is `outside`. Two points with equal value are a step.
class TransferFunction {
 public:
  struct Point {
    double value = 0.0;   ///< of the field, in the field's own unit
    double result = 0.0;  ///< newtons of a strength, 0…1 of a mask
    friend bool operator==(const Point&, const Point&) = default;
  };
  /// Which of the two results a step has at its own value.
  enum class Side { below, above };

  TransferFunction() = default;
  /// \param points   with values that do not fall; at least one
  /// \param outside  result below the first and above the last value
  /// Throws std::invalid_argument, with a sentence, on points that fall or are not finite.
  TransferFunction(std::vector<Point> points, double outside = 0.0);

  /// The result at `value`. At a step, the limit from `side`. 0 for an empty function or a NaN.
  double at(double value, Side side = Side::above) const noexcept;
  /// dresult/dvalue at `value`, from `side`; 0 outside the points and for an empty function.
  double slope_at(double value, Side side = Side::above) const noexcept;

  const std::vector<Point>& points() const noexcept { return points_; }
  double outside() const noexcept { return outside_; }
  friend bool operator==(const TransferFunction&, const TransferFunction&) = default;

 private:
  std::vector<Point> points_;
  double outside_ = 0.0;
};

}  // namespace palpa
