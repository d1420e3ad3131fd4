// Double-double arithmetic for the solver. Internal.
#pragma once

#include "palpa/solver/vec3.h"

namespace palpa::detail {

/// high + low, |low| at most half a unit in the last place of high.
struct Double2 {
  double high = 0.0, low = 0.0;
};

/// a + b exactly (Knuth, TAOCP 2, 4.2.2 theorem B).
inline Double2 two_sum(double a, double b) noexcept {
  const double sum = a + b;
  const double of_b = sum - a;
  return {sum, (a - (sum - of_b)) + (b - of_b)};
}

/// a b exactly, barring overflow and underflow (Dekker 1971; not every machine has a fused product).
inline Double2 two_product(double a, double b) noexcept {
  constexpr double splitter = 134217729.0;  // 2²⁷ + 1
  const double a_split = splitter * a, b_split = splitter * b;
  const double a_high = a_split - (a_split - a), b_high = b_split - (b_split - b);
  const double a_low = a - a_high, b_low = b - b_high;
  const double product = a * b;
  return {product, ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low};
}

inline Double2 sum(Double2 a, Double2 b) noexcept {
  const Double2 high = two_sum(a.high, b.high);
  return two_sum(high.high, high.low + (a.low + b.low));
}

inline Double2 product(Double2 a, double b) noexcept {
  const Double2 high = two_product(a.high, b);
  return {high.high, high.low + a.low * b};
}

inline double rounded(Double2 a) noexcept { return a.high + a.low; }

/// Components of a vector, or of a − o, along q and across it, for q of unit length but for rounding: the error of each is about one rounding of
/// itself and one of a rounding of |a − o|.
struct Slide {
  double along = 0.0;
  Vec3 across;
};
inline Slide slide(const Vec3& q, const Double2& x, const Double2& y, const Double2& z) noexcept {
  const Double2 along = sum(sum(product(x, q.x), product(y, q.y)), product(z, q.z));
  const Double2 squared = sum(sum(two_product(q.x, q.x), two_product(q.y, q.y)), two_product(q.z, q.z));
  const double longer = (squared.high - 1.0) + squared.low;  // |q|² − 1
  const Double2 back{-along.high, along.high * longer - along.low};
  return {rounded(along),
          {rounded(sum(x, product(back, q.x))), rounded(sum(y, product(back, q.y))), rounded(sum(z, product(back, q.z)))}};
}
inline Slide slide(const Vec3& q, const Vec3& a, const Vec3& o) noexcept {
  return slide(q, two_sum(a.x, -o.x), two_sum(a.y, -o.y), two_sum(a.z, -o.z));
}

}  // namespace palpa::detail
