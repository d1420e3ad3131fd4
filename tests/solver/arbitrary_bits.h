// Problems made of arbitrary bits, and the required properties of the solver's answers.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "palpa/solver/solver.h"
#include "tests/solver/random_problems.h"

namespace palpa::test {

/// Result of a run. `wrong` is half a sentence, nullptr if everything held; `wrong_at` the problem.
struct ArbitraryBits {
  long long problems = 0;
  long long bad_input = 0;
  long long exact = 0;
  long long capped = 0;
  long long refused = 0;  ///< primitives
  const char* wrong = nullptr;
  long long wrong_at = -1;
};

namespace arbitrary {

/// A hostile number: any bits, or a usual extreme value.
inline double hostile(Random& random) {
  using limits = std::numeric_limits<double>;
  constexpr double known[] = {0.0,
                              -0.0,
                              1.0,
                              -1.0,
                              limits::infinity(),
                              -limits::infinity(),
                              limits::quiet_NaN(),
                              limits::denorm_min(),
                              -limits::denorm_min(),
                              limits::min(),
                              limits::max(),
                              -limits::max(),
                              1e-300,
                              1e150,
                              1e-160,
                              largest_position_m,
                              largest_strength_n};
  if (random.below(2) == 0) return std::bit_cast<double>(random.bits());
  return known[random.below(std::size(known))];
}

/// A number of the size `usual`; once in `one_in` a hostile number.
inline double number(Random& random, int one_in, double usual_low, double usual_high) {
  const double usual = random.uniform(usual_low, usual_high);
  return random.below(one_in) == 0 ? hostile(random) : usual;
}
inline Vec3 place(Random& random, int one_in) {
  const double x = number(random, one_in, -0.05, 0.05);
  const double y = number(random, one_in, -0.05, 0.05);
  return {x, y, number(random, one_in, -0.05, 0.05)};
}
inline Vec3 direction(Random& random, int one_in) {
  const Vec3 q = random.direction();
  if (random.below(one_in) != 0) return q;
  switch (random.below(4)) {
    case 0: return {};
    case 1: return (1.0 + random.uniform(-1e-11, 1e-11)) * q;
    case 2: return hostile(random) * q;
    default: return {hostile(random), hostile(random), hostile(random)};
  }
}

inline bool usable(const Vec3& position_m) {
  return is_finite(position_m) && largest_component(position_m) <= largest_position_m;
}

/// The error of a set of `added` primitives; nullptr: none.
inline const char* wrong_with(const PrimitiveSet& set, int added) {
  if (static_cast<int>(set.size()) + set.dropped() != added) return "a primitive was neither taken nor refused";
  for (const Primitive& p : set.primitives()) {
    if (!usable(p.position_m)) return "a position was taken that is not usable";
    if (!(p.strength_n >= 0.0 && p.strength_n <= largest_strength_n)) return "a strength was taken that is not usable";
    if (!(p.drag_ns_per_m >= 0.0 && p.drag_ns_per_m <= largest_drag_ns_per_m)) return "a drag was taken that is not usable";
    if (p.kind != PrimitiveKind::point && !(std::abs(norm(p.direction) - 1.0) <= 1e-11))
      return "a direction is not of unit length";
  }
  return nullptr;
}

/// The error of an answer; nullptr: none.
inline const char* wrong_with(const Balance& balance, const Solver& solver, const PrimitiveSet& set, const Vec3& start_m,
                              const Vec3& probe_m, double k, double T) {
  if (!is_finite(balance.position_m)) return "the position is not finite";
  if (!(balance.error_bound_m >= 0.0) || !std::isfinite(balance.error_bound_m)) return "the bound is not finite";
  if (solver.forces_n().size() != set.size()) return "there is not one force for each primitive";
  for (const Vec3& force : solver.forces_n()) {
    if (!is_finite(force)) return "a primitive's force is not finite";
  }
  bool drags = false;
  for (const Primitive& p : set.primitives()) drags = drags || p.drag_ns_per_m > 0.0;
  const bool bad =
      !(k > 0.0) || !std::isfinite(k) || !usable(start_m) || !usable(probe_m) || (drags && (!(T > 0.0) || !std::isfinite(T)));
  const bool ordinary = !bad && k >= 1.0 && k <= 1e9 && (!drags || (T >= 1e-9 && T <= 1e3));
  if (bad && balance.status != BalanceStatus::bad_input) return "bad input was not told";
  if (ordinary && balance.status == BalanceStatus::bad_input) return "good input was called bad";
  switch (balance.status) {
    case BalanceStatus::bad_input:
      if (usable(start_m) && !(balance.position_m == start_m)) return "bad input moved the proxy";
      for (const Vec3& force : solver.forces_n()) {
        if (!(force == Vec3{})) return "bad input gave a force";
      }
      return nullptr;
    case BalanceStatus::exact:
      if (!(balance.error_bound_m <= exact_bound_m)) return "a balance is called exact that is not";
      break;
    case BalanceStatus::capped:
      if (balance.error_bound_m <= exact_bound_m) return "an exact balance is called capped";
      break;
    case BalanceStatus::baseline: return "the exact law called itself a baseline";
  }
  if (!is_finite(k * (balance.position_m - probe_m))) return "the coupling's force is not finite";
  return nullptr;
}

}  // namespace arbitrary

/// Solves `problems` problems of up to 8 primitives made of arbitrary bits, one after another with one solver, and checks each
/// answer; stops at the first error.
/// \param corners  half of the primitives are facets
inline ArbitraryBits solve_arbitrary_bits(long long problems, std::uint64_t seed, bool corners = false) {
  using namespace arbitrary;
  constexpr int most = 8;
  Random random(seed);
  Solver solver(most);
  PrimitiveSet set(most);
  ArbitraryBits run;
  while (run.problems < problems && !run.wrong) {
    // From hardly a hostile number to hostile numbers only.
    constexpr int shares[] = {1, 4, 30, 300};
    const int one_in = shares[random.below(4)];
    const Vec3 start_m = place(random, one_in);
    const Vec3 probe_m = random.below(2) == 0 ? place(random, one_in) : start_m + random.in_cube(0.004);
    const double k = number(random, one_in, 1, 3000);
    const double T = number(random, one_in, 1e-4, 1e-2);
    const int n = random.below(most + 1);
    set.clear(start_m);
    for (int i = 0; i < n; ++i) {
      Primitive p;
      p.kind = random_kind(random);
      p.id.slot = static_cast<std::uint16_t>(random.below(one_in * 30) == 0 ? 0 : i);
      p.position_m = random.below(2) == 0 ? start_m : place(random, one_in);
      p.direction = direction(random, one_in);
      p.strength_n = number(random, one_in, 0, 5);
      p.drag_ns_per_m = random.below(2) == 0 ? 0.0 : number(random, one_in, 0, 20);
      if (corners && random.below(2) == 0) {
        p.kind = PrimitiveKind::corner;
        if (random.below(one_in * 4) != 0) p.drag_ns_per_m = 0.0;
        const bool further = !set.empty() && set[set.size() - 1].kind == p.kind && random.below(4) != 0;
        if (further) p.id = set[set.size() - 1].id, p.strength_n = set[set.size() - 1].strength_n;
      }
      set.add(p);
    }
    run.wrong = wrong_with(set, n);
    if (!run.wrong) {
      const Balance balance = solver.solve(set, start_m, probe_m, k, T);
      run.wrong = wrong_with(balance, solver, set, start_m, probe_m, k, T);
      run.bad_input += balance.status == BalanceStatus::bad_input;
      run.exact += balance.status == BalanceStatus::exact;
      run.capped += balance.status == BalanceStatus::capped;
    }
    run.refused += set.dropped();
    if (run.wrong) run.wrong_at = run.problems;
    ++run.problems;
  }
  return run;
}

}  // namespace palpa::test
