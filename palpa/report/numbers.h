// Numbers as a page holds them: no longer than can be seen.
#pragma once

#include <cstdio>
#include <cstdlib>

namespace palpa::detail {

/// To so many digits that count; what is not finite stays so.
inline double rounded(double value, int digits) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.*g", digits, value);
  return std::strtod(buffer, nullptr);
}

/// [mm] to the micrometre.
inline double millimetres(double length_m) { return rounded(1e3 * length_m, length_m < 0.1 && length_m > -0.1 ? 5 : 7); }

}  // namespace palpa::detail
