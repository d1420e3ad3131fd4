// Ipopt, the general solver of Debian that takes the balance: as it is asked by someone who knows it.
#pragma once

#include "tests/solver/random_problems.h"

namespace palpa::bench {

struct IpoptAnswer {
  Vec3 position_m;
  bool converged = false;
};

/// The dual of the balance, which is smooth: over the forces u_i, and the sum Z in newtons as variables of its own (so
/// that the matrices are sparse), minimise ½|Z|² − Σ b_i·u_i subject to Z = C + Σ u_i, |u_i|² <= s_i², 0 <= t_i <= s_i.
/// Forces of lines in two coordinates, of planes in one; in units of the largest force; exact derivatives. Problems with
/// drags are not taken. Allocates, as Ipopt does.
IpoptAnswer balance_by_ipopt(const test::Problem& problem, double tolerance);

}  // namespace palpa::bench
