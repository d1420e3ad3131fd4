// Sine and cosine with equal bits on every machine with IEEE arithmetic.
#pragma once

#include <cmath>

namespace palpa::detail {

struct SineCosine {
  double sine;
  double cosine;
};
/// Sine and cosine of an angle in turns [1], by a series of our own: C libraries round differently, but motions have to be
/// equal to the bit everywhere.
inline SineCosine sine_cosine(double turns) noexcept {
  constexpr double pi = 3.141592653589793;
  const double in_turn = turns - std::floor(turns);
  const double quarter = std::floor(4.0 * in_turn + 0.5);
  const double x = 2.0 * pi * (in_turn - 0.25 * quarter);  // |x| <= pi/4
  const double xx = x * x;
  double sine = 0.0;
  double cosine = 0.0;
  for (int n = 17; n >= 3; n -= 2) sine = (1.0 + sine) * (-xx / ((n - 1) * n));
  for (int n = 16; n >= 2; n -= 2) cosine = (1.0 + cosine) * (-xx / ((n - 1) * n));
  sine = x * (1.0 + sine);
  cosine = 1.0 + cosine;
  switch (static_cast<int>(quarter) & 3) {
    case 0: return {sine, cosine};
    case 1: return {cosine, -sine};
    case 2: return {-sine, -cosine};
    default: return {-cosine, sine};
  }
}

}  // namespace palpa::detail
