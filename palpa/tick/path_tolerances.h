// Lengths below which the proxy's path does not tell two things apart, as shares of the finest sample spacing near it.
#pragma once

namespace palpa::path_tolerances {

inline constexpr double still = 1e-6;     ///< [1] no move at all
inline constexpr double rest = 5e-4;      ///< [1] a move that does not change by more is settled
inline constexpr double trial = 1e-3;     ///< [1] below, directions have not changed
inline constexpr double hovering = 1e-2;  ///< [1] between the proxy and the level that a kept plane stands on
inline constexpr double halted = 2e-2;    ///< [1] a move shortened below this is rest
inline constexpr double piercing = 5e-2;  ///< [1] how deep a straight move may lead into what holds it

}  // namespace palpa::path_tolerances
