// The figures of docs/theory.md, drawn from answers of the solver.
#pragma once

#include <span>
#include <vector>

#include "palpa/solver/primitives.h"
#include "tools/figures/paper_figures.h"

namespace palpa {

/// Energy and inclusion, sum of force sets, error and bound, sweeps over two planes, passivity. All but what names
/// things comes from a Solver, `error_bound_m`, or sweeps over forces. Takes about a second.
std::vector<Figure> theory_figures();

namespace detail {

/// Each force in turn becomes the best one while the others are held: one sweep of dual ascent.
/// \param primitives  without drag
/// \param forces_n    [N] one for each primitive; replaced
/// \return            [m] where the spring then holds the proxy
Vec3 sweep(std::span<const Primitive> primitives, std::vector<Vec3>& forces_n, const Vec3& probe_m, double stiffness_n_per_m);

/// A proxy that sweeps have brought near its balance.
struct NearBalance {
  double error_m = 0.0;     ///< distance to the balance
  double bound_m = 0.0;     ///< what `error_bound_m` proves of it
  double residual_n = 0.0;  ///< what the printed forces of the paper (Eqs. 2–8) leave over there
};

/// Each of `sweeps` sweeps over a set of two oblique planes, a line and a point; number `seed` of such sets.
std::vector<NearBalance> sweeps_towards_balance(unsigned seed, int sweeps);

/// Two planes `angle_deg` apart hold a proxy in their edge: its distance to it after each of up to `cap` sweeps
/// [m], the last one below 1e-9 m.
std::vector<double> sweeps_into_edge(double angle_deg, int cap);

/// One tick of a random motion among random primitives.
struct EnergyOfStep {
  double leak_j = 0.0;   ///< work on the hand − what the spring released
  double bound_j = 0.0;  ///< k/2 |Δp|²
};

/// Ticks with primitives of any direction and strength, new in each tick: all through the proxy, or (`elsewhere`)
/// up to 3 mm away from it and with directed forces.
std::vector<EnergyOfStep> random_steps(bool elsewhere, int count);

}  // namespace detail
}  // namespace palpa
