// Energy ledger: stored, dissipated and injected energy of each tick, in total and by mode.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "palpa/mode/mode_context.h"
#include "palpa/solver/coupling.h"
#include "palpa/solver/law.h"
#include "palpa/solver/vec3.h"

namespace palpa {

/// Books the work of one tick. Allocates at construction only; then never throws.
class Ledger {
 public:
  /// \param modes  [1] number of modes of the session
  explicit Ledger(std::size_t modes);

  /// Starts a tick with the proxy at `proxy_m`, the probe's path processed up to `processed_up_to_m` [m], and these
  /// contacts.
  void begin(const Vec3& proxy_m, const Vec3& processed_up_to_m, std::span<const Contact> contacts) noexcept;
  /// Returns the energy of a tick that ends with the proxy at `proxy_m` and the probe at `probe_m` [m], `probe_step_m` [m] from
  /// its last position, after these sub-steps and with these contacts.
  Energy end(const Vec3& proxy_m, const Vec3& probe_m, const Vec3& probe_step_m, double stiffness_n_per_m,
             std::span<const SubStep> sub_steps, std::span<const PlacedPrimitive> placed,
             std::span<const Contact> contacts) noexcept;

  /// W [J] of each mode in this tick: above zero injected, below zero dissipated.
  std::span<const double> works_j() const noexcept { return {works_j_.get(), modes_}; }

 private:
  void book_sub_steps(std::span<const SubStep> sub_steps, std::span<const PlacedPrimitive> placed) noexcept;
  // Books the force [N] of a primitive over a sub-step: the proxy moved by `step_m` [m], of which the data carried it
  // `carried_m` [m]. W = F·(step − carried).
  void book(std::size_t mode, const Vec3& force_n, const Vec3& step_m, const Vec3& carried_m) noexcept;
  // Books a move of the proxy from `from_m` to `to_m` [m], towards the balance `balance_m` for the probe `probe_m`; the data
  // carried it at most `carried_m` [m].
  void move(const Vec3& from_m, const Vec3& to_m, const Vec3& balance_m, const Vec3& probe_m, double carried_m) noexcept;
  std::size_t modes_;
  std::unique_ptr<double[]> works_j_;
  Vec3 start_m_;
  double data_motion_j_ = 0.0;
  double elastic_j_ = 0.0, elastic_before_j_ = 0.0;
  Vec3 probe_m_;              // of the last move
  double left_m2_ = 0.0;      // square of the motion of probe and data not yet followed
  double released_m2_ = 0.0;  // twice over the stiffness
};

}  // namespace palpa
