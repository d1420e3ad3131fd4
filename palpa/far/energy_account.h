// Energy account of a felt extension that updates of the model shift.
#pragma once

#include "palpa/solver/vec3.h"

namespace palpa {

/// The hand feels the extension s = e + o: e from the probe to the proxy of the newest model, o an *offset*, by which the
/// change of e at an update is spread over time. In each tick o shrinks. The spring's energy k/2 |s|² may rise by no more than
/// the model's sources and elastic levels give, and an account holds: it is filled with 5 mW and with what the model
/// dissipates, up to 2 mJ, and pays for the elastic energy that an update brings. Where there is less, s is shortened. So, for
/// any models at any times (docs/theory.md 11), with k/2 |step|² of each tick for the zero-order hold,
///     work on the hand <= 2 mJ + 5 mW · time + work of sources + Σ k/2 |step|² + debt.
/// The account is in debt where s is shortened no faster than an offset shrinks, so that the force has no step.
///
/// Allocates nothing; one thread.
class EnergyAccount {
 public:
  /// A tick of the model.
  struct Step {
    Vec3 before_m;  ///< e of the newest model at the last probe
    Vec3 now_m;     ///< e
    Vec3 probe_step_m;
    double time_step_s = 0.0;  ///< > 0
    double source_j = 0.0;     ///< given by the model's sources
    double elastic_j = 0.0;    ///< more in elastic levels, and in the spring beyond the force limit, after it
    double stiffness_n_per_m = 0.0;
  };

  /// The model is replaced: the felt extension stays.
  /// \param from_m   [m] e of the old model at the last probe
  /// \param to_m     [m] likewise of the new one
  /// \param more_j   [J] energy that elastic levels hold more
  void update(const Vec3& from_m, const Vec3& to_m, double more_j) noexcept {
    offset_m_ += from_m - to_m;
    account_j_ -= more_j;
  }
  /// Returns the felt extension s [m].
  Vec3 felt_m(const Step& step) noexcept;
  /// No extension and offset; the account stays.
  void restart() noexcept { offset_m_ = felt_m_ = {}; }
  /// Scales extensions, as where a spring of another stiffness bears an equal force.
  /// \param share  [1] > 0
  void scale(double share) noexcept { offset_m_ *= share, felt_m_ *= share; }

  const Vec3& offset_m() const noexcept { return offset_m_; }
  const Vec3& felt_m() const noexcept { return felt_m_; }
  double account_j() const noexcept { return account_j_; }
  /// Energy [J] of the last tick that the spread of updates gave to the spring; below zero: took.
  double link_j() const noexcept { return link_j_; }
  /// Longest way [m] by which the offset shrinks in a tick.
  static double shrinks_m(double offset_m, const Step& step) noexcept;

  static constexpr double full_j = 2e-3;    ///< More: an update may give more; less: forces stay off the model for longer
  static constexpr double income_w = 5e-3;  ///< [W] Likewise

 private:
  Vec3 offset_m_, felt_m_;
  double account_j_ = full_j, link_j_ = 0.0;
};

}  // namespace palpa
