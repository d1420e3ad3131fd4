// Passages of a polynomial in Bernstein form through a level.
#pragma once

namespace palpa {

/// No share: no passage.
inline constexpr double no_passage = 2.0;  // [1]

inline constexpr int largest_degree = 9;  // [1]

/// First share [1] of [from, 1] at which the polynomial is on the other side of `level`: at or above it if `up`, else below it;
/// `from` itself if it is there already. To 1e-15, never before the passage; `no_passage` if none.
///
/// By subdivision: the coefficients' hull contains the values, so a double passage is found. A polynomial that touches the
/// level by no more than rounding (1e-15 of its largest coefficient) does not pass. Bounded work, no allocation. Coefficients
/// must be finite.
/// \param control  [unit] Bernstein coefficients
/// \param degree   [1] 0…largest_degree
/// \param level    [unit]
/// \param from     [1] 0…1
double first_passage(const double* control, int degree, double level, bool up, double from = 0.0) noexcept;

/// Value [unit] at `share` [1] of the polynomial with Bernstein coefficients `control` [unit].
double value_of(const double* control, int degree, double share) noexcept;

}  // namespace palpa
