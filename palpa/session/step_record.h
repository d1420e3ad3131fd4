// Log of a tick's sub-steps.
#pragma once

#include <cassert>
#include <cstddef>
#include <span>
#include <vector>

#include "palpa/session/contact_problem.h"
#include "palpa/session/session.h"

namespace palpa {

/// Sub-steps of a tick, each a verifiable balance. Moves that settle one step are one sub-step as long as they stay near the
/// first move's end; its balance is the last one, with all facets. Allocates at construction; one thread.
class StepRecord {
 public:
  /// Allocates for `steps` [1] sub-steps of a tool with `feet` [1] feet.
  void reserve(std::size_t steps, std::size_t feet);
  void clear() noexcept;

  /// Begins to log a solved move, in the sub-step returned, which holds an earlier one.
  SubStep& begin() noexcept {
    assert(size_ < sub_steps_.size());
    return sub_steps_[size_++];
  }
  /// Ends it: fills in directed forces, energies, primitives. `settles`: it settles the previous move's step. `spacing_m` [m]
  /// of the data nearby.
  void end(bool settles, double spacing_m, const ContactProblem& model, const ModeRuntime& modes) noexcept;
  void cut() noexcept { sub_steps_[size_ - 1].stop = Stop::cap; }

  std::span<const SubStep> sub_steps() const noexcept { return {sub_steps_.data(), size_}; }
  std::span<const PlacedPrimitive> placed() const noexcept { return placed_; }

 private:
  void add_rows(SubStep& step, const ContactProblem& model, const ModeRuntime& modes) noexcept;

  std::vector<SubStep> sub_steps_;  // the first `size_`; to clear the others would take as long as to fill one in
  std::size_t size_ = 0;
  std::vector<PlacedPrimitive> placed_;
  Vec3 first_end_m_;    // of the last sub-step's first move
  bool begins_ = true;  // the last sub-step is the first of its step: the carried motion is its own
};

}  // namespace palpa
