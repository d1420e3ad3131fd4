// The law: the rule that finds the balance, and the record of a balance by which anyone can check it. The exact law is in
// solver.h; other laws are those of earlier systems.
#pragma once

#include <cstdint>
#include <span>

#include "palpa/solver/primitives.h"

namespace palpa {

enum class BalanceStatus : std::uint8_t {
  exact,      ///< the bound is at most `exact_bound_m`
  capped,     ///< a cap on the work was reached; the position is the best found, and its bound still is proven
  bad_input,  ///< k, T or a position was not usable; position is the start, all forces zero
  baseline,   ///< an earlier system's law, which promises no bound of its own
};

const char* name_of(BalanceStatus status) noexcept;  ///< "exact", …

/// A balance whose proven error is at most this [m] is called exact. Less: rounding makes good balances `capped`; more: `exact`
/// promises less, and recorded traces no longer compare.
inline constexpr double exact_bound_m = 1e-9;

/// One solved proxy position.
struct Balance {
  Vec3 position_m;             ///< where the pull of the spring and of all primitives is zero
  double error_bound_m = 0.0;  ///< proven distance to the exact balance, rounding included
  BalanceStatus status = BalanceStatus::exact;
  int stage = 0;       ///< which stage of the law answered (0: nothing to solve)
  int iterations = 0;  ///< passes over all primitives: proofs and Newton steps, in all stages
};

/// Finds the balance: the minimiser over x of
///     E(x) = k/2 |x − probe|² − Σ directed·x + Σ s|r(x)| + c/(2T) |r(x)|²   (sum over the primitives)
/// with Huber's function of |r(x)| in place of the last two terms where a primitive is elastic,
/// which is the paper's zero of the residual force (Eq. 8), kinks included.
///
/// A law keeps the forces of the last balance for a warm start, so one law serves one session and one
/// thread. `solve` never allocates, throws, blocks, loops without a cap or returns a value that is
/// not finite.
class Law {
 public:
  virtual ~Law() = default;

  /// Solves for the proxy. Inputs that cannot be used are answered with `bad_input`.
  /// \param primitives        what pulls at the proxy
  /// \param start_m           [m] the proxy before this sub-step
  /// \param probe_m           [m] the probe
  /// \param stiffness_n_per_m [N/m] k of Eq. 1, > 0
  /// \param time_step_s       [s] T of the sub-step, > 0 where a primitive has a drag; else unused
  virtual Balance solve(const PrimitiveSet& primitives, const Vec3& start_m, const Vec3& probe_m, double stiffness_n_per_m,
                        double time_step_s) noexcept = 0;

  /// Force of each primitive on the proxy [N] at the last balance, in the set's order; valid until the next `solve`. Where
  /// redundant primitives share a load this is one valid split of several.
  virtual std::span<const Vec3> forces_n() const noexcept = 0;

  /// Forgets the forces kept for the warm start.
  virtual void reset() noexcept = 0;
};

/// How much the term of E of one primitive (a single facet counts as a plane) falls between two positions [m], in joules [J].
/// \param time_step_s  [s] T as above
double fall_j(const Primitive& primitive, const Vec3& from_m, const Vec3& to_m, double time_step_s) noexcept;

/// What the proxy does at a primitive (a single facet counts as a plane) given the balance. It is read from the residual, which
/// is unique, not from a split of forces, which is not: a proxy within `error_bound_m` of the primitive is on it. An elastic
/// primitive slips where it has given way by its strength over its stiffness.
PrimitiveState state_at(const Primitive& primitive, const Balance& balance) noexcept;
/// The same of `primitives[i]`, or of the whole corner that it is a facet of.
PrimitiveState state_at(std::span<const Primitive> primitives, std::size_t i, const Balance& balance) noexcept;

/// The direction [1] of the sum of the forces [N] of a corner's facets; if a single facet presses, its normal to the bit. Zero
/// where none presses, or they cancel. Reads only its arguments.
Vec3 pressed_direction(std::span<const Primitive> facets, std::span<const Vec3> forces_n) noexcept;

/// A proven bound [m] of |x − x*| for any x and any forces, where x* is the exact balance, by the
/// duality gap (strong convexity of E): (ρ + √(ρ² + 4kε))/(2k) with ρ the force left over and ε the
/// sum of φ(r) + φ*(u) − u·r. Rounding of this computation itself is inside the bound.
/// `forces_n` are first projected on the forces that each primitive can exert. Where k or T cannot be used, or a force is not
/// finite, the result is the largest double: nothing is proven. Reads only its arguments; allocates nothing.
double error_bound_m(std::span<const Primitive> primitives, std::span<const Vec3> forces_n, const Vec3& x_m,
                     const Vec3& probe_m, double stiffness_n_per_m, double time_step_s) noexcept;

/// Why the proxy went no further (docs/path.md). `full`: it reached the balance; `event`: it met a level or an edge of data;
/// `release`: it made the longest move that is allowed, and the rest follows at the same probe; `energy`: no place further on
/// was allowed; `cap`: a cap was reached.
enum class Stop : std::uint8_t { full, event, release, energy, cap };

/// One sub-step with all that is needed to check it (docs/trace.md, balances.csv).
struct SubStep {
  double time_step_s = 0.0;  ///< of the sub-step, a part of the tick's
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
  HeldLevel captured;
  Vec3 force_n;  ///< in the law's split; where several share a load, other splits are as valid
  PrimitiveState state = PrimitiveState::off;
  Vec3 carried_m;  ///< how far moving data of its mode carry the proxy in the whole sub-step
};

/// The energy [J] that a primitive brought in over its sub-step, F·(proxy − start − move_fraction · carried); below zero: took
/// out.
double work_j(const SubStep& step, const PlacedPrimitive& placed) noexcept;

/// The largest value [m] that the duality gap (`error_bound_m`) can have for a balance as it is recorded, at its position in
/// doubles. The law's bound is that of a place finer than doubles; where the proxy rests on something, or slips by little, the
/// rounding to doubles adds its root to the gap (docs/theory.md 3.5). Never less than the law's bound. Reads only its
/// arguments; allocates nothing.
///
/// \param placed             all primitives of the balance, with the law's forces; the facets of a corner in a row and all
///                           with one state; facets without force may be left out
/// \param stiffness_n_per_m  [N/m] k of Eq. 1, > 0
/// \param time_step_s        [s] of the sub-step, which drags count by; at least `shortest_time_s`, or counts as that
double recorded_bound_m(std::span<const PlacedPrimitive> placed, const Balance& balance, double stiffness_n_per_m,
                        double time_step_s) noexcept;

}  // namespace palpa
