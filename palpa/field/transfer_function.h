// Transfer functions: piecewise linear functions of a field's value, for strengths and masks.
#pragma once

#include <vector>

namespace palpa {

/// Piecewise linear in the value; beyond the points it is `outside`. Two points with equal value are a
/// step. The end points belong to the function: at the first and at the last value the result is
/// theirs, whatever the side.
///
/// Evaluation never allocates or throws, and is finite for every value.
class TransferFunction {
 public:
  struct Point {
    double value = 0.0;   ///< of the field, in the field's own unit
    double result = 0.0;  ///< [N] of a strength, [1] 0…1 of a mask
    friend bool operator==(const Point&, const Point&) = default;
  };
  /// Which of the two results a step has at its own value.
  enum class Side { below, above };

  TransferFunction() = default;
  /// \param points   with values that do not fall; at least one, at most two of one value
  /// \param outside  [N] or [1] as the results; holds below the first and above the last value
  /// Throws std::invalid_argument, with a sentence, on points that fall, are not finite or beyond 1e300.
  TransferFunction(std::vector<Point> points, double outside = 0.0);

  /// The result [N] or [1] at `value`, in the field's own unit. At a step, the limit from `side`. 0 for an empty function or a
  /// NaN.
  double at(double value, Side side = Side::above) const noexcept;
  /// dresult/dvalue [N/unit] at `value`, in the field's own unit; at a point that of the piece on `side`; 0 beyond the points,
  /// for an empty function or a NaN.
  double slope_at(double value, Side side = Side::above) const noexcept;
  /// Whether it is zero at `value`, in the field's own unit, and on both sides of it, up to the points next to it. At the first
  /// and the last point what is beyond does not count.
  bool stays_zero_at(double value) const noexcept;

  const std::vector<Point>& points() const noexcept { return points_; }
  double outside() const noexcept { return outside_; }  ///< [N] or [1] as the results
  friend bool operator==(const TransferFunction&, const TransferFunction&) = default;

 private:
  std::vector<Point> points_;
  double outside_ = 0.0;
};

}  // namespace palpa
