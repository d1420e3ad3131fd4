// A sub-step as it is recorded: all that is needed to check it.
#pragma once

#include <cstdint>
#include <span>

#include "palpa/core/law.h"

namespace palpa {

/// Why the proxy went no further.
enum class Stop : std::uint8_t { full, event, release, energy, cap };

/// One sub-step, for those who want to check it (docs/trace.md, balances.csv).
struct SubStep {
  double time_step_s = 0.0;
  Vec3 start_m;
  Vec3 probe_m;
  double stiffness_n_per_m = 0.0;
  Vec3 directed_n;
  Balance balance;
  double move_fraction = 0.0;  ///< [1] proxy = start + move_fraction · (balance − start)
  Stop stop = Stop::full;
  Vec3 proxy_m;
  double energy_before_j = 0.0;  ///< S − directed·x at the start
  double energy_after_j = 0.0;
  std::uint32_t first_primitive = 0;  ///< in `Session::placed()`
  std::uint32_t primitives = 0;
};

/// A primitive as it was placed in a sub-step, and what it did.
struct PlacedPrimitive {
  Primitive primitive;
  Captured captured;
  Vec3 force_n;  ///< in the law's split: valid, but where several share a load one of many
  PrimitiveState state = PrimitiveState::off;
  Vec3 carried_m;  ///< how far the data of its mode carry the proxy in the whole sub-step
};

/// What a primitive brought in over its sub-step [J], below zero took out: F·(proxy − start − move_fraction · carried).
double work_j(const SubStep& step, const PlacedPrimitive& placed) noexcept;

/// What the duality gap (`error_bound_m`) says at most [m] of a balance as it is recorded: at its position, a double. The law's
/// bound is that of a finer place, and the gap pays a root for the rounding where the proxy rests on something, or slips by
/// little (docs/theory.md 3.5). Never less than the law's bound. Reads only its arguments; allocates nothing.
/// \param placed             all that the balance is of, with the law's forces, the facets of a corner in a row and all of one
///                           state; facets without force may be left out
/// \param stiffness_n_per_m  [N/m] k of Eq. 1, > 0
double recorded_bound_m(std::span<const PlacedPrimitive> placed, const Balance& balance, double stiffness_n_per_m) noexcept;

/// Makes what a sub-step says of itself that which its record proves: the bound, the status that goes with it, both energies.
/// For once, when all else is filled in. Allocates nothing.
/// \param placed  in this sub-step
void complete(SubStep& step, std::span<const PlacedPrimitive> placed) noexcept;

}  // namespace palpa
