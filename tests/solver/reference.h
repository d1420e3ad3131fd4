// The tests' reference: the balance in floating point of 113 bits, with its own certificate.
#pragma once

#include <cfloat>
#include <span>

#include "tests/solver/random_problems.h"

namespace palpa::test {

#if defined(__SIZEOF_FLOAT128__)
using Quad = __float128;
#else
static_assert(LDBL_MANT_DIG == 113, "the reference needs floating point of 113 bits");
using Quad = long double;
#endif

struct Reference {
  Quad x_m[3] = {};
  Quad bound_m = 0;        ///< proven distance of x_m to the exact balance (without rounding at 113 bits)
  bool certified = false;  ///< bound_m <= 1e-14
  int iterations = 0;      ///< Newton steps at 113 bits
};

/// The balance of the problem as given by its doubles; directions are q/|q| in exact arithmetic. Shares no code with the
/// library's solver: Newton's method on the augmented Lagrangian, first in double, then at 113 bits, and without the start in
/// double where that gave no proof. Unproven: certified = false; count and print it. Allocates; any thread.
Reference reference_balance(const Problem& problem);

/// |x − x*| [m] of a position, with the reference as x*.
double error_m(const Reference& reference, const Vec3& position_m);

/// The check formula of a trace (plain bound [m]) for x = position_m + remainder_m and any forces [N], in 113 bits: forces are
/// projected on the primitives' force sets, slipping terms have no cancellation, and a force without drag whose length is its
/// strength to 1e-15 counts as exactly so, and so does a corner's that is off the way out by no more than 1e-15 of its t.
double plain_bound_m(const Problem& problem, std::span<const Vec3> forces_n, const Vec3& position_m, const Vec3& remainder_m);

}  // namespace palpa::test
