// Where a polynomial in Bernstein form passes a level.
#pragma once

namespace palpa {

/// No share: the polynomial does not pass.
inline constexpr double no_passage = 2.0;  // [1]

inline constexpr int largest_degree = 9;  // [1]

/// The first share [1] of [from, 1] at which the polynomial is on the other side of `level`: at or above it where `up`, else
/// below it; `from` itself where it is there already. To 1e-15, never before the passage; `no_passage` where there is none.
///
/// By subdivision: the coefficients' hull holds the values, so a polynomial that passes twice between two places is
/// found there. One that touches the level by no more than rounding (1e-15 of its largest coefficient) and turns
/// back does not pass. Bounded work, nothing allocated. Coefficients must be finite.
/// \param control  [unit] Bernstein coefficients
/// \param degree   [1] 0…largest_degree
/// \param level    [unit]
/// \param from     [1] 0…1
double first_passage(const double* control, int degree, double level, bool up, double from = 0.0) noexcept;

/// The value [unit] at `share` [1] of the polynomial with Bernstein coefficients `control` [unit].
double value_of(const double* control, int degree, double share) noexcept;

}  // namespace palpa
