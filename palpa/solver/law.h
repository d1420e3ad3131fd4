// Law of the balance, and the record that makes a balance verifiable. The exact law is in solver.h; other laws are of earlier
// systems.
#pragma once

#include <cstdint>
#include <span>

#include "palpa/solver/pose.h"
#include "palpa/solver/primitives.h"

namespace palpa {

enum class BalanceStatus : std::uint8_t {
  exact,      ///< the bound is at most `exact_bound_m`
  capped,     ///< a cap on the work was reached; best position found, its bound still proven
  bad_input,  ///< unusable k, T or position; position is the start, all forces zero
  baseline,   ///< an earlier system's law, without a bound of its own
};

const char* name_of(BalanceStatus status) noexcept;  ///< "exact", …

/// [m] Largest proven error of a balance called exact. Less: rounding makes good balances `capped`; more: weaker claim, and
/// recorded traces no longer compare.
inline constexpr double exact_bound_m = 1e-9;

/// A solved proxy position.
struct Balance {
  Vec3 position_m;             ///< where the forces of the spring and of all primitives cancel
  double error_bound_m = 0.0;  ///< proven distance to the exact balance, rounding included
  BalanceStatus status = BalanceStatus::exact;
  int stage = 0;       ///< stage of the law that found it (0: nothing to solve)
  int iterations = 0;  ///< passes over all primitives: proofs and Newton steps, in all stages
  // Of a tool, whose balance is a motion from the start; zero for a point:
  Vec3 way_m{};     ///< of the device's point, in finer steps than `position_m`
  Vec3 turn_rad{};  ///< rotation vector
};

/// Finds the balance: the minimiser over x of
///     E(x) = k/2 |x − probe|² − Σ directed·x + Σ s|r(x)| + c/(2T) |r(x)|²   (sum over the primitives)
/// with Huber's function of |r(x)| in place of the last two terms for elastic primitives: the paper's zero of the residual
/// force (Eq. 8), kinks included.
///
/// Keeps the forces of the last balance for a warm start: a law serves one session and one thread. `solve` never allocates,
/// throws, blocks, loops without a cap or returns a value that is not finite.
class Law {
 public:
  virtual ~Law() = default;

  /// Solves for the proxy. Returns `bad_input` for unusable arguments.
  /// \param primitives        forces on the proxy
  /// \param start_m           [m] the proxy before this sub-step
  /// \param probe_m           [m] the probe
  /// \param stiffness_n_per_m [N/m] k of Eq. 1, > 0
  /// \param time_step_s       [s] T of the sub-step, > 0 if a primitive has a drag; else unused
  virtual Balance solve(const PrimitiveSet& primitives, const Vec3& start_m, const Vec3& probe_m, double stiffness_n_per_m,
                        double time_step_s) noexcept = 0;

  /// Force of each primitive on the proxy [N] at the last balance, in the set's order; valid until the next `solve`. For
  /// redundant primitives one of several valid splits.
  virtual std::span<const Vec3> forces_n() const noexcept = 0;

  /// Clears the warm start.
  virtual void reset() noexcept = 0;
};

/// Decrease of a primitive's term of E (a single facet counts as a plane) between two positions [m], in joules [J].
/// \param time_step_s  [s] T as above
double fall_j(const Primitive& primitive, const Vec3& from_m, const Vec3& to_m, double time_step_s) noexcept;

/// State of a primitive (a single facet counts as a plane) in the balance, from the residual, which is unique, not from a split
/// of forces: a proxy within `error_bound_m` of the primitive is on it. An elastic primitive slips from a deflection of
/// strength over stiffness.
PrimitiveState state_at(const Primitive& primitive, const Balance& balance) noexcept;
/// State of `primitives[i]`, or of the whole corner that it is a facet of.
PrimitiveState state_at(std::span<const Primitive> primitives, std::size_t i, const Balance& balance) noexcept;

/// Direction [1] of the sum of the forces [N] of a corner's facets; if a single facet presses, its normal to the bit. Zero if
/// none presses, or they cancel. Reads only its arguments.
Vec3 pressed_direction(std::span<const Primitive> facets, std::span<const Vec3> forces_n) noexcept;

/// Proven bound [m] of |x − x*| for any x and any forces, where x* is the exact balance, by the duality gap (strong convexity
/// of E): (ρ + √(ρ² + 4kε))/(2k) with ρ the residual force and ε the sum of φ(r) + φ*(u) − u·r. Includes the rounding of this
/// computation. Projects `forces_n` on the admissible forces of each primitive. The largest double (no proof) for unusable k or
/// T or a force that is not finite. Reads only its arguments; allocates nothing.
double error_bound_m(std::span<const Primitive> primitives, std::span<const Vec3> forces_n, const Vec3& x_m,
                     const Vec3& probe_m, double stiffness_n_per_m, double time_step_s) noexcept;

/// Reason for the end of a move (docs/path.md). `full`: reached the balance; `event`: met a level or an edge of data;
/// `release`: longest allowed move, the rest follows at this probe; `energy`: no position further on was allowed; `cap`: a cap
/// was reached.
enum class Stop : std::uint8_t { full, event, release, energy, cap };

/// Verifiable record of a sub-step (docs/trace.md, balances.csv).
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
  std::uint32_t first_primitive = 0;  ///< in `Session::primitives()`
  std::uint32_t primitives = 0;
  // Of a tool:
  Turn start_turn{}, probe_turn{}, proxy_turn{};
  double turning_radius_m = 0.0;  ///< ρ; 0: a point, without orientation
};

/// A primitive as placed in a sub-step, with its result.
struct PlacedPrimitive {
  Primitive primitive;
  HeldLevel captured;
  Vec3 force_n;  ///< in the law's split; other splits of a shared load are as valid
  PrimitiveState state = PrimitiveState::off;
  Vec3 carried_m;            ///< motion of the proxy with moving data of its mode in the whole sub-step
  Vec3 lever_m{};            ///< from the device's point of a tool to the foot, at the start of the sub-step; zero for a point
  double coefficient = 0.0;  ///< [1] of a Coulomb friction line, whose strength is that times the force of its plane
  std::int32_t plane_slot = -1;  ///< of a Coulomb friction line: slot of its plane or corner, of this mode and foot; -1: none
  bool rides = false;  ///< lies at the start of the foot, carried by moving data, or is a material's: in the next sub-step it
                       ///< lies elsewhere
};

/// Way [m] of a primitive's foot in a sub-step, linear in the turn; of a point that of the proxy.
Vec3 foot_way_m(const SubStep& step, const PlacedPrimitive& placed) noexcept;

/// Energy [J] that a primitive injected over its sub-step, F·(way of the foot − move_fraction · carried); below zero:
/// dissipated.
double work_j(const SubStep& step, const PlacedPrimitive& placed) noexcept;

/// Upper bound [m] of the duality gap (`error_bound_m`) of a recorded balance, at its position in doubles. The law's bound is
/// that of a finer position; where the proxy rests on a primitive, or slips by little, the rounding to doubles adds its root to
/// the gap (docs/theory.md 3.5). At least the law's bound. Reads only its arguments; allocates nothing.
///
/// \param placed             all primitives of the balance, with the law's forces; the facets of a corner in a row and
///                           with a common state; facets without force may be left out
/// \param stiffness_n_per_m  [N/m] k of Eq. 1, > 0
/// \param time_step_s        [s] of the sub-step, used by drags; at least `shortest_time_s` is assumed
/// \param turning_radius_m   [m] ρ of a tool; unused for a point
double recorded_bound_m(std::span<const PlacedPrimitive> placed, const Balance& balance, double stiffness_n_per_m,
                        double time_step_s, double turning_radius_m = 0.0) noexcept;

}  // namespace palpa
