// What is told of a tick's path: its sub-steps and what was placed in them.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "palpa/session/contact_problem.h"
#include "palpa/session/session.h"

namespace palpa {

/// The sub-steps of a tick, each a balance that anyone can check. Moves that settle one step are one sub-step as long as they
/// stay near the end of its first one: its balance is the last one, in which all that was learnt takes part. Takes its memory
/// at construction; one thread.
class StepRecord {
 public:
  /// Room for so many sub-steps. Allocates.
  void reserve(std::size_t steps);
  void clear() noexcept;

  /// Records a move that the model was solved for; `settles`: of the same step as the one before. `spacing_m` [m] is
  /// that of the data near by. Fills in what is not given: directed forces, energies, primitives.
  void add(SubStep& step, bool settles, double spacing_m, const ContactProblem& model, const ModeRuntime& modes) noexcept;
  /// Marks the last sub-step as stopped by the cap.
  void cut() noexcept { sub_steps_.back().stop = Stop::cap; }

  std::span<const SubStep> sub_steps() const noexcept { return sub_steps_; }
  std::span<const PlacedPrimitive> placed() const noexcept { return placed_; }

 private:
  void add_rows(SubStep& step, const ContactProblem& model, const ModeRuntime& modes) noexcept;

  std::vector<SubStep> sub_steps_;
  std::vector<PlacedPrimitive> placed_;
  Vec3 first_end_m_;    // of the last sub-step's first move
  bool begins_ = true;  // the last sub-step is its step's first: what data carried is its
};

}  // namespace palpa
