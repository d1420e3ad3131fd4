// Energy ledger: stored, dissipated and injected energy of each tick, in total and by mode.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>

#include "palpa/mode/mode_context.h"
#include "palpa/solver/coupling.h"
#include "palpa/solver/law.h"
#include "palpa/solver/tool.h"

namespace palpa {

/// Books the work of one tick. Allocates at construction only; then never throws.
class Ledger {
 public:
  /// \param modes  [1] number of modes of the session
  /// \param tool   outlives this
  Ledger(std::size_t modes, const Tool& tool);

  /// Starts a tick with the proxy at `proxy`, the last probe at `last_probe`, the probe's path processed up to
  /// `processed_up_to` [m], and these contacts.
  void begin(const Pose& proxy, const Pose& last_probe, const Pose& processed_up_to,
             std::span<const Contact> contacts) noexcept {
    if (!tool_.is_point()) start_arc_m_ = tool_.motion(last_probe, proxy).arc_m;
    begin(proxy, processed_up_to, contacts);
  }
  /// Returns the energy of a tick that ends with the proxy at `proxy` and the probe at `probe` [m], `probe_step_m` [m] from
  /// the last, after these sub-steps and with these contacts.
  Energy end(const Pose& proxy, const Pose& probe, const Motion& probe_step_m, double stiffness_n_per_m,
             std::span<const SubStep> sub_steps, std::span<const PlacedPrimitive> placed,
             std::span<const Contact> contacts) noexcept;

  /// W [J] of each mode in this tick: above zero injected, below zero dissipated.
  std::span<const double> works_j() const noexcept { return {works_j_.get(), modes_}; }

  /// Forgets all works, as in a tick without a probe.
  void clear() noexcept {
    if (any_work_) std::fill_n(works_j_.get(), modes_, 0.0);
    any_work_ = false;
  }

 private:
  void begin(const Pose& proxy, const Pose& processed_up_to, std::span<const Contact> contacts) noexcept;
  void book_sub_steps(std::span<const SubStep> sub_steps, std::span<const PlacedPrimitive> placed) noexcept;
  // Books the force [N] of a primitive over a sub-step: its foot moved by `step_m` [m], of which the data carried it
  // `carried_m` [m]. W = F·(step − carried).
  void book(std::size_t mode, const Vec3& force_n, const Vec3& step_m, const Vec3& carried_m) noexcept;
  // Books the move of a sub-step; the data carried the proxy at most `carried_m` [m].
  void move(const SubStep& step, double carried_m) noexcept;
  double lost_by_turning_m2(const SubStep& step) const noexcept;
  std::size_t modes_;
  std::unique_ptr<double[]> works_j_;
  bool any_work_ = false;  // else all are zero
  const Tool& tool_;
  Pose start_;
  Vec3 start_arc_m_;  // of a tool, from the last probe to the start
  double data_motion_j_ = 0.0;
  double elastic_j_ = 0.0, elastic_before_j_ = 0.0;
  Pose probe_;                // of the last move
  double left_m2_ = 0.0;      // square of the motion of probe and data not yet followed
  double released_m2_ = 0.0;  // twice over the stiffness
};

}  // namespace palpa
