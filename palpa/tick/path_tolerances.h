// Lengths below which the proxy's path does not tell two things apart, as shares of the finest sample spacing near it.
#pragma once

namespace palpa::path_tolerances {

inline constexpr double hair = 1e-9;      ///< [1] to which a place is on a level, by rounding
inline constexpr double novel = 1e-7;     ///< [1] what shuts out less of a level is known already
inline constexpr double still = 1e-6;     ///< [1] no move at all; as deep as rounding may lead into a level
inline constexpr double rest = 1e-4;      ///< [1] a step that would go on by no more is settled
inline constexpr double turned = 5e-4;    ///< [1] a move whose end changes by less has the same directions
inline constexpr double shallow = 1e-3;   ///< [1] as deep in a level may be an end that shows nothing new of it, or the witness
inline constexpr double piercing = 2e-2;  ///< [1] how deep a straight move may lead into what holds it before it is stopped
inline constexpr double earnest = 0.9;    ///< [1] of what a move into a level promises: it must really bring so much

}  // namespace palpa::path_tolerances
