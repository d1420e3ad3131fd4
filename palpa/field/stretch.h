// Pieces of a straight way on which a scalar field is one polynomial, or known to stay within bounds.
#pragma once

namespace palpa {

/// A piece of a straight way through a scalar field. It begins where it was asked for.
struct Stretch {
  double end = 1.0;      ///< [1] share of the way where the piece ends
  bool inside = false;   ///< the field has data on the piece, but for its ends perhaps
  int degree = -1;       ///< [1] of the polynomial, 0…9; −1 where only this is known: the value stays in the quiet interval
  double control[10]{};  ///< Bernstein coefficients of the value from begin to end, the field's own unit; their hull holds it
};

}  // namespace palpa
