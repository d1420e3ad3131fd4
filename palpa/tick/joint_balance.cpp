#include "palpa/tick/joint_balance.h"

#include <algorithm>
#include <utility>

#include "palpa/core/split.h"
#include "palpa/tick/path_tolerances.h"

namespace palpa {

using namespace path_tolerances;

namespace {

constexpr int max_rounds = 4;  // of adding the kept planes that a balance is behind of

}  // namespace

JointBalance::JointBalance(std::unique_ptr<Law> law, std::size_t modes, double stiffness_n_per_m, Samples& samples)
    : law_(std::move(law)),
      stiffness_n_per_m_(stiffness_n_per_m),
      samples_(&samples),
      in_steps_(law_->walk() == Law::Walk::steps),
      set_(max_primitives),
      gives_way_(modes),
      friction_(max_primitives) {
  own_n_.reserve(max_primitives);
}

void JointBalance::clear() noexcept {
  law_->reset();
  friction_.clear();
  kept_.clear();
}

void JointBalance::continue_from(const JointBalance& other) noexcept {
  law_->reset();
  friction_ = other.friction_;
  kept_ = other.kept_;
}

void JointBalance::pose(const Terms& terms) noexcept {
  terms_ = terms;
  own_ = set_.size();
  own_n_.clear();
  for (const Primitive& p : set_.primitives()) own_n_.push_back(p.strength_n);
}

void JointBalance::keep_own() noexcept {
  set_.truncate(own_);
  for (std::size_t i = 0; i < own_; ++i) {
    if (set_.captured(i).any()) set_.set_strength(i, own_n_[i]);
  }
}

Balance JointBalance::solve(const Vec3& probe_m, double time_step_s) noexcept {
  return friction_.solve(*law_, set_, own_, probe_m, stiffness_n_per_m_, time_step_s);
}

Balance JointBalance::balance(const Vec3& probe_m, double time_step_s) noexcept {
  std::fill(gives_way_.begin(), gives_way_.end(), 0);
  keep_own();
  Balance found = solve(probe_m, time_step_s);
  const double slack_m = terms_.relaxed ? piercing * terms_.spacing_m : 0.0;
  for (int round = 0; round < max_rounds && in_steps_; ++round) {
    if (!kept_.add_to(set_, own_n_, found, still * terms_.spacing_m, slack_m)) break;
    found = solve(probe_m, time_step_s);
  }
  const bool shared = set_.size() > own_;
  bool gives_way = yields(found, true);
  if (gives_way && shared && split_is_shared(set_.primitives(), found)) {
    // With others beside them the planes' sum is one of many. Each plane by itself slips or sticks, whatever the split.
    std::fill(gives_way_.begin(), gives_way_.end(), 0);
    for (std::size_t i = own_; i < set_.size(); ++i) set_.set_strength(i, set_[i].strength_n / KeptPlanes::wedge);
    for (std::size_t i = 0; i < own_; ++i) {
      if (set_.captured(i).any()) set_.set_strength(i, own_n_[i]);
    }
    found = solve(probe_m, time_step_s);
    gives_way = yields(found, false);
  }
  if (shared && (gives_way || is_off_level(found))) {
    keep_own();
    found = solve(probe_m, time_step_s);
  }
  return found;
}

// Marks the modes whose level is pressed through: one of its planes, or all of them together, exert its strength.
bool JointBalance::yields(const Balance& found, bool together) noexcept {
  bool any = false;
  for (std::size_t i = 0; i < own_; ++i) {
    const Primitive& p = set_[i];
    const Captured& level = set_.captured(i);
    if (!level.any() || !(own_n_[i] > 0.0)) continue;
    Vec3 sum_n = law_->forces_n()[i];
    bool over = state_at(p, found) == PrimitiveState::slip;
    for (std::size_t j = own_; j < set_.size(); ++j) {
      if (set_[j].id.mode != p.id.mode || set_.captured(j) != level) continue;
      sum_n += law_->forces_n()[j];
      over = over || state_at(set_[j], found) == PrimitiveState::slip;
    }
    if (over || (together && norm(sum_n) > own_n_[i])) {
      gives_way_[p.id.mode] = 1;
      any = true;
    }
  }
  return any;
}

// Kept planes that hold the proxy off the level itself bound no hollow; nor do the two sides of a thin wall, which hold it
// inside.
bool JointBalance::is_off_level(const Balance& found) noexcept {
  Samples& samples = *samples_;
  for (std::size_t i = 0; i < own_; ++i) {
    const Captured& level = set_.captured(i);
    if (!level.any() || state_of(i, found) == PrimitiveState::off) continue;
    samples.move_to(terms_.levels_at_m);
    const double side = dot(set_[i].direction, samples.scalar(level.field).gradient) < 0.0 ? 1.0 : -1.0;
    samples.move_to(set_.start_m());
    const double start = side * (samples.scalar(level.field).value - level.value);
    samples.move_to(found.position_m);
    const ScalarSample& sample = samples.scalar(level.field);
    const double inside = side * (sample.value - level.value);
    const double spacing = terms_.spacing_m * norm(sample.gradient);
    const bool hovers = state_at(set_[i], found) == PrimitiveState::off || terms_.relaxed;
    if (hovers && -inside > hovering * spacing) return true;
    if (terms_.relaxed && inside > std::max(start, piercing * spacing)) return true;
  }
  return false;
}

PrimitiveState JointBalance::state_of(std::size_t i, const Balance& at) const noexcept {
  const Primitive& p = set_[i];
  const Captured& level = set_.captured(i);
  PrimitiveState state = state_at(p, at);
  if (!level.any()) return state;
  if (gives_way(p.id.mode)) return state == PrimitiveState::off ? state : PrimitiveState::slip;
  for (std::size_t j = own_; j < set_.size() && state == PrimitiveState::off; ++j) {
    if (set_[j].id.mode == p.id.mode && set_.captured(j) == level && state_at(set_[j], at) != PrimitiveState::off) {
      state = PrimitiveState::stick;
    }
  }
  return state;
}

}  // namespace palpa
