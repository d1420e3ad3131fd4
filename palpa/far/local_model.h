// Local model of what is felt: primitives of the data's last sub-step, balanced at another place and time.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "palpa/far/message.h"
#include "palpa/guard/impact.h"
#include "palpa/solver/coulomb_friction.h"

namespace palpa {

/// Moves a proxy by the rows of a model, one balance a step. Rows that ride lie at the start of each step; all others stay
/// where the session placed them, or move with their data. Allocates at construction only; one thread.
class LocalModel {
 public:
  LocalModel();
  LocalModel(const LocalModel&) = delete;
  LocalModel& operator=(const LocalModel&) = delete;

  /// Replaces the rows. Rows that no set takes (`PrimitiveSet::add`) are left out in each step.
  void take(const ModelUpdate& update) noexcept;
  /// Removes all rows: the proxy follows the probe.
  void clear() noexcept;
  const Vec3& session_proxy_m() const noexcept { return proxy_m_; }
  /// [m] Way from the session's proxy within which the model holds.
  double valid_m() const noexcept { return valid_m_; }

  /// Returns the proxy's next position: the balance for a probe at `probe_m`.
  /// \param start_m      [m] the proxy before
  /// \param time_step_s  [s] > 0
  /// \param age_s        [s] >= 0: from the model's sample to the end of the step
  Vec3 move(const Vec3& start_m, const Vec3& probe_m, double time_step_s, double age_s, double stiffness_n_per_m) noexcept;

  /// Energy [J] stored in elastic levels at the end of the last move.
  double elastic_j() const noexcept;
  /// Energy [J] given in the last move by directed forces, points and lines that stay, and the data's motion; below zero:
  /// taken.
  double source_j() const noexcept;
  /// Hard levels, stiffer than the coupling, that press in the last move and did not before it, in this model or another.
  /// Valid until the next move.
  std::span<const HardContact> met() const noexcept { return {met_.data(), met_size_}; }

 private:
  void place(const Vec3& start_m, double time_step_s, double age_s) noexcept;
  void find_met(double stiffness_n_per_m) noexcept;

  std::array<ModelRow, ModelUpdate::most_rows> rows_;
  std::size_t count_ = 0;
  Vec3 proxy_m_;
  double valid_m_ = 0.0;
  // Of the last move:
  Vec3 start_m_, end_m_;
  double time_step_s_ = 1.0;
  std::array<std::size_t, ModelUpdate::most_rows> row_of_{};  // by row of the set
  std::array<PrimitiveId, ModelUpdate::most_rows> pressing_{};
  std::size_t pressing_size_ = 0;
  std::array<HardContact, ModelUpdate::most_rows> met_{};
  std::size_t met_size_ = 0;

  StateArena state_;
  Tool tool_;
  ToolLaw law_;
  PrimitiveSet set_;
  CoulombFriction friction_;
};

}  // namespace palpa
