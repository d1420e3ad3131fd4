// Numbers of a page, rounded to visible precision.
#pragma once

#include <charconv>

namespace palpa::detail {

/// Rounds to significant digits; non-finite values are unchanged.
inline double rounded(double value, int digits) {
  char buffer[40];
  const auto written = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, digits);
  std::from_chars(buffer, written.ptr, value);
  return value;
}

/// [mm] to the micrometre.
inline double millimetres(double length_m) { return rounded(1e3 * length_m, length_m < 0.1 && length_m > -0.1 ? 5 : 7); }

}  // namespace palpa::detail
