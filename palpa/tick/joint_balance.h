// The balance of all that a sub-step has: what the modes placed, planes kept from further back, friction.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "palpa/core/law.h"
#include "palpa/mode/here.h"
#include "palpa/tick/coulomb_friction.h"
#include "palpa/tick/kept_planes.h"

namespace palpa {

/// The primitives of a sub-step and their balance. The modes' own come first in the set, planes that are kept (KeptPlanes)
/// are added behind them where the balance is behind those; which level gives way is said for all of its planes together.
/// Takes its memory at construction; one thread.
class JointBalance {
 public:
  static constexpr std::size_t max_primitives = 64;

  /// \param modes    their number
  /// \param samples  of the session; outlive this
  JointBalance(std::unique_ptr<Law> law, std::size_t modes, double stiffness_n_per_m, Samples& samples);

  void clear() noexcept;
  void continue_from(const JointBalance& other) noexcept;

  const Law& law() const noexcept { return *law_; }
  PrimitiveSet& set() noexcept { return set_; }
  const PrimitiveSet& set() const noexcept { return set_; }
  KeptPlanes& kept() noexcept { return kept_; }
  /// How many of the set are the modes' own, and the strength [N] that a mode gave the i-th of them.
  std::size_t own() const noexcept { return own_; }
  double own_n(std::size_t i) const noexcept { return own_n_[i]; }
  bool any_kept() const noexcept { return set_.size() > own_; }

  /// How a set is to be balanced.
  struct Terms {
    double spacing_m = 0.0;  ///< [hand m] finest sample spacing near the sub-step
    Vec3 levels_at_m;        ///< [m] where planes that stand on levels were looked up
    bool relaxed = false;    ///< see KeptPlanes::add_to
  };
  /// The set holds what the modes have placed.
  void pose(const Terms& terms) noexcept;
  const Terms& terms() const noexcept { return terms_; }
  /// Takes the kept planes out of the set; the modes' own have their own strengths again.
  void keep_own() noexcept;
  /// Balances what was posed. Again and again for different probes, if wanted.
  Balance balance(const Vec3& probe_m, double time_step_s) noexcept;

  /// In the last balance the level of this mode is pressed through: one of its planes, or all together, exert its strength.
  bool gives_way(std::size_t mode) const noexcept { return gives_way_[mode] != 0; }
  /// The state of a primitive as its mode is told: of a plane on a level, that of the level, whichever of its planes holds.
  PrimitiveState state_of(std::size_t i, const Balance& at) const noexcept;

 private:
  Balance solve(const Vec3& probe_m, double time_step_s) noexcept;
  bool yields(const Balance& found, bool together) noexcept;
  bool is_off_level(const Balance& found) noexcept;

  std::unique_ptr<Law> law_;
  double stiffness_n_per_m_;
  Samples* samples_;
  bool in_steps_;
  PrimitiveSet set_;
  std::size_t own_ = 0;
  std::vector<double> own_n_;
  std::vector<char> gives_way_;  // by mode
  CoulombFriction friction_;
  KeptPlanes kept_;
  Terms terms_;
};

}  // namespace palpa
