#include "palpa/solver/solver.h"

#include <cassert>
#include <limits>

#include "palpa/solver/solver_work.h"

namespace palpa {

using namespace detail::solving;

namespace {

// Accepted k, far beyond any device: with the limits of PrimitiveSet nothing overflows; outside: `bad_input`.
constexpr double softest_n_per_m = 1e-12;
constexpr double stiffest_n_per_m = 1e12;

bool usable(const Vec3& position_m) noexcept { return is_within(position_m, largest_position_m); }

}  // namespace

void Solver::Work::solve() noexcept {
  if (in_closed_form()) return;
  if (warm_) keep();
  Z_ = sum();
  sweep();
  // More than three at once rarely converge after a sweep, and the proof costs as much as a sweep.
  if (plane_count_ + span_count_ + corner_count_ <= 3) {
    Z_ = sum();
    if (certify(1)) return;
  } else if (!warm_) {
    sweep();
  }
  // A round without proof is repeated from its end, after a sweep. Either a few rounds find the balance, or they cycle.
  int in_vain = plane_count_ + span_count_ + corner_count_ > many ? 1 : 0;
  for (int i = 0; i < max_rounds && in_vain < max_rounds_in_vain; ++i) {
    if (i > 0) {
      recentre();
      Z_ = sum();
      sweep();
    }
    const double before = best_bound_n_;
    if (round()) return;
    if (i == 0 && warm_ && solve_from_before()) return;
    if (!(best_bound_n_ < 0.5 * before)) ++in_vain;
  }
  augmented_lagrangian();
}

Balance Solver::solve(const PrimitiveSet& set, const Vec3& start_m, const Vec3& probe_m, double k, double T) noexcept {
  assert(set.size() <= capacity_);
  const bool fits = set.size() <= capacity_;
  const std::span<const Primitive> primitives = set.primitives().first(fits ? set.size() : 0);
  remainder_m_ = {};
  bool same = size_ == primitives.size();
  bool drags = false;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    same = same && ids_[i] == primitives[i].id;
    drags = drags || primitives[i].drag_ns_per_m > 0.0;
  }
  if (!same) match(primitives);

  const bool time_usable = !drags || (std::isfinite(T) && T > 0.0);
  Balance balance;
  if (!fits || !(k >= softest_n_per_m && k <= stiffest_n_per_m) || !time_usable || !usable(start_m) || !usable(probe_m)) {
    std::fill_n(forces_.get(), size_, Vec3{});
    if (usable(start_m)) balance.position_m = start_m;
    balance.error_bound_m = std::numeric_limits<double>::max();
    balance.status = BalanceStatus::bad_input;
    return balance;
  }
  balance.position_m = probe_m;
  if (primitives.empty()) return balance;  // without primitives the proxy is the probe, to the bit

  work_->pose(primitives, forces_.get(), start_m, probe_m, k, T);
  work_->solve();
  work_->give(balance, remainder_m_, forces_.get());
  return balance;
}

// Maps the forces of the last balance to the order of this set, by id; zero for new primitives.
void Solver::match(std::span<const Primitive> primitives) noexcept {
  Vec3* const matched = work_->spare_forces();
  std::size_t next = 0;  // after the last match: sets rarely change their order
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    matched[i] = {};
    for (std::size_t step = 0; step < size_; ++step) {
      if (next >= size_) next = 0;
      const std::size_t j = next++;
      if (ids_[j] == primitives[i].id) {
        matched[i] = forces_[j];
        break;
      }
    }
  }
  size_ = primitives.size();
  for (std::size_t i = 0; i < size_; ++i) ids_[i] = primitives[i].id, forces_[i] = matched[i];
}

Balance solve_once(const PrimitiveSet& primitives, const Vec3& start_m, const Vec3& probe_m, double stiffness_n_per_m,
                   double time_step_s) {
  Solver solver(std::max<std::size_t>(1, primitives.size()));
  return solver.solve(primitives, start_m, probe_m, stiffness_n_per_m, time_step_s);
}

}  // namespace palpa
