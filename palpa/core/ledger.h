// The energy ledger: what every tick stored, dissipated and injected, and which mode did.
#pragma once

#include <memory>
#include <span>

#include "palpa/core/vec3.h"

namespace palpa {

/// The energy of one tick [J].
///
/// With S = k/2 |proxy − probe|², x₀ and x_m the proxy before and after the tick, p and p⁺ the probe,
/// the spring's force held since the last tick did the work f₀·Δp on the hand, and, whatever happened
/// inside the tick,
///     f₀·Δp = S₀ − S_m + k/2 |Δp|² + I,     I = S_m − k/2 |x₀ − p⁺|²
/// As an equation of I this holds for any x; what can be wrong, and is checked by the tests, is how I
/// is split over the modes and the path. What elastic levels store, V, is of no mode: of the work of their forces only what is
/// not found again in V is. Summed over ticks, with −Δp·force as what the hand put in, it is the
/// table of a run (energy_table.h); docs/theory.md 7.7.
struct Energy {
  double stored_j = 0.0;        ///< S_m, in the spring after the tick
  double elastic_j = 0.0;       ///< V, in elastic levels after the tick
  double dissipated_j = 0.0;    ///< taken out by modes: −Σ of the modes' works below zero
  double injected_j = 0.0;      ///< brought in by modes: Σ of the modes' works above zero
  double path_j = 0.0;          ///< I − ΣW + V − V₀ − moved: the price of walking the path in sub-steps
  double damper_j = 0.0;        ///< work of the held damper force on the hand
  double moved_j = 0.0;         ///< work of the data's own motion
  double work_on_hand_j = 0.0;  ///< work of the command that was held since the last tick
  double let_go_j = 0.0;        ///< lost by the springs where the proxy went further than the hand and the data took it
  double held_back_j = 0.0;     ///< work on the hand that the guard held back: of the force less the command
  double ticks_j = 0.0;         ///< brought in by holding the force for a tick: path + k/2 |Δp|² + let go
  double ticks_bound_j = 0.0;   ///< k/2 |Δp|²: the most that one balance can have brought in so
};

/// Books the works of one tick. Takes its memory at construction; then never allocates or throws.
class Ledger {
 public:
  /// For a session of `modes` modes.
  explicit Ledger(std::size_t modes);

  /// Starts a tick with the proxy at `proxy_m` and the probe's path walked up to `walked_m` [m].
  void begin(const Vec3& proxy_m, const Vec3& walked_m) noexcept;
  /// Books the force [N] of one primitive of mode `mode` over one sub-step: the proxy went by `step_m`
  /// [m], of which the data themselves carried it `carried_m` [m]. W = F·(step − carried).
  void book(std::size_t mode, const Vec3& force_n, const Vec3& step_m, const Vec3& carried_m) noexcept;
  /// Books what an elastic level of mode `mode` held before the tick and holds after it [J].
  void book_elastic(std::size_t mode, double before_j, double after_j) noexcept;
  /// Books one move of the proxy, from `from_m` to `to_m` [m], towards the balance at `balance_m` for the probe at
  /// `probe_m`; the data took it at most `carried_m` [m] of the way.
  void move(const Vec3& from_m, const Vec3& to_m, const Vec3& balance_m, const Vec3& probe_m, double carried_m) noexcept;
  /// Ends the tick with the proxy at `proxy_m` and the probe at `probe_m` [m], `probe_step_m` [m] from where it was in the
  /// last tick.
  Energy end(const Vec3& proxy_m, const Vec3& probe_m, const Vec3& probe_step_m, double stiffness_n_per_m) noexcept;

  /// W [J] of each mode in this tick: above zero injected, below zero dissipated.
  std::span<const double> works_j() const noexcept { return {works_j_.get(), modes_}; }

 private:
  std::size_t modes_;
  std::unique_ptr<double[]> works_j_;
  Vec3 start_m_;
  double moved_j_ = 0.0;
  double elastic_j_ = 0.0, elastic_before_j_ = 0.0;
  Vec3 probe_m_;            // that the last move was for
  double left_m2_ = 0.0;    // the square of the way of probe and data that the proxy has not gone yet
  double let_go_m2_ = 0.0;  // twice over the stiffness
};

}  // namespace palpa
