// What a tick may do: units of work, which are counted and never timed, so that the same inputs give the same path.
#pragma once

namespace palpa::tick_work {

// A unit is: a piece of a straight way that is searched for events, a mode that places its primitives or whose data carry the
// proxy, a look at a level, a balance; and, of a balance,
inline constexpr int primitives_each = 4;  ///< [1] so many primitives in one of its iterations
// Pieces, modes and looks are more where a sample of their data is:
inline constexpr int values_each =
    128;  ///< [1] so many values are a unit; a sample of up to two smooth grids of numbers is one

/// [units] of a piece, a mode or a look whose sample is made of so many values (Field::values_per_sample).
constexpr int of_sample(int values) noexcept { return values > values_each ? values / values_each : 1; }

/// [1] A tick begins nothing once it has spent this. More: longer worst tick; less: the proxy lags behind the hand sooner.
inline constexpr int most = 4096;

}  // namespace palpa::tick_work
