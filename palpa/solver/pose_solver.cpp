#include "palpa/solver/pose_solver.h"

#include <cassert>
#include <limits>

#include "palpa/solver/pose_work.h"

namespace palpa {

namespace {

// Accepted k and ρ, far beyond any device: nothing overflows.
constexpr double softest_coupling_n_per_m = 1e-12, stiffest_coupling_n_per_m = 1e12;
constexpr double least_turning_m = 1e-6, largest_turning_m = 1e3;
constexpr double quaternion_tolerance = 1e-9;  // [1] of a quaternion's length. Less: rounded turns are refused

bool is_within(const Vec3& position_m) noexcept {
  return is_finite(position_m) && largest_component(position_m) <= largest_position_m;
}
bool is_within(const Pose& pose) noexcept { return is_within(pose.position_m) && is_unit(pose.turn, quaternion_tolerance); }

bool is_solvable(std::span<const Primitive> primitives, const ToolStep& step, std::size_t feet) noexcept {
  const double k = step.stiffness_n_per_m, radius_m = step.turning_radius_m;
  if (!(k >= softest_coupling_n_per_m && k <= stiffest_coupling_n_per_m) ||
      !(radius_m >= least_turning_m && radius_m <= largest_turning_m))
    return false;
  if (!is_within(step.start) || !is_within(step.probe) || step.levers_m.size() > feet) return false;
  bool drags = false;
  for (const Primitive& p : primitives) {
    if (p.id.foot >= step.levers_m.size() || !is_within(step.levers_m[p.id.foot])) return false;
    drags = drags || p.drag_ns_per_m > 0.0;
  }
  return !drags || (std::isfinite(step.time_step_s) && step.time_step_s > 0.0);
}

}  // namespace

PoseSolver::PoseSolver(std::size_t capacity, std::size_t feet)
    : capacity_(capacity),
      feet_(feet),
      forces_(std::make_unique<Vec3[]>(capacity)),
      ids_(std::make_unique<PrimitiveId[]>(capacity)),
      work_(std::make_unique<Work>(capacity, feet)) {}

PoseSolver::~PoseSolver() = default;

Balance PoseSolver::solve(const PrimitiveSet& set, const ToolStep& step) noexcept {
  assert(set.size() <= capacity_);
  const bool fits = set.size() <= capacity_;
  const std::span<const Primitive> primitives = set.primitives().first(fits ? set.size() : 0);
  match(primitives);
  if (!fits || !is_solvable(primitives, step, feet_)) {
    std::fill_n(forces_.get(), size_, Vec3{});
    const Vec3& start_m = step.start.position_m;
    return {is_within(start_m) ? start_m : Vec3{}, std::numeric_limits<double>::max(), BalanceStatus::bad_input, 0, 0};
  }
  // Without primitives the tool is at the device.
  if (primitives.empty()) {
    const Vec3 turn_rad = rotation_between_rad(step.start.turn, step.probe.turn);
    const double rounding_rad = turn_rad == Vec3{} ? 0.0 : detail::epsilon * (12.0 + 4.0 * norm(turn_rad));
    return {.position_m = step.probe.position_m,
            .error_bound_m = step.turning_radius_m * rounding_rad,
            .way_m = step.probe.position_m - step.start.position_m,
            .turn_rad = turn_rad};
  }
  work_->pose(primitives, forces_.get(), step, false);
  work_->solve();
  Balance balance;
  work_->give(balance, forces_.get());
  return balance;
}

// Maps the forces of the last balance to the order of this set, by id; zero for new primitives. Facets that are gone leave
// their force to those before them.
void PoseSolver::match(std::span<const Primitive> primitives) noexcept {
  bool same = size_ == primitives.size();
  for (std::size_t i = 0; same && i < size_; ++i) same = ids_[i] == primitives[i].id;
  if (same) return;
  Vec3* const matched = work_->spare_forces();
  std::size_t next = 0;  // after the last match: sets rarely change their order
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    matched[i] = {};
    for (std::size_t step = 0; step < size_; ++step) {
      if (next >= size_) next = 0;
      const std::size_t j = next++;
      if (ids_[j] != primitives[i].id) continue;
      matched[i] = forces_[j];
      for (const bool is_last = i + 1 == primitives.size() || !(primitives[i + 1].id == ids_[j]);
           is_last && next < size_ && ids_[next] == ids_[j]; ++next)
        matched[i] += forces_[next];
      break;
    }
  }
  size_ = primitives.size();
  for (std::size_t i = 0; i < size_; ++i) ids_[i] = primitives[i].id, forces_[i] = matched[i];
}

Balance balance_at_foot(const Balance& balance, const Vec3& lever_m, double turning_radius_m) noexcept {
  if (lever_m == Vec3{}) return balance;
  Balance at = balance;
  at.position_m = balance.position_m + lever_m + cross(balance.turn_rad, lever_m);
  at.error_bound_m *= std::sqrt(1.0 + norm_squared(lever_m / turning_radius_m));
  // The rounding of the sums above and of the foot's start.
  at.error_bound_m +=
      4.0 * detail::epsilon *
      (detail::size_of(balance.position_m) + (1.0 + detail::size_of(balance.turn_rad)) * detail::size_of(lever_m));
  at.error_bound_m = std::min(at.error_bound_m, std::numeric_limits<double>::max());
  return at;
}

double PoseSolver::error_bound_m(const PrimitiveSet& set, std::span<const Vec3> forces_n, const ToolStep& step,
                                 const Balance& at) {
  const bool finite = std::ranges::all_of(forces_n, [](const Vec3& force_n) { return is_finite(force_n); });
  if (!finite || forces_n.size() < set.size() || !is_finite(at.position_m) || !is_finite(at.turn_rad) ||
      !is_solvable(set.primitives(), step, step.levers_m.size()))
    return std::numeric_limits<double>::max();
  Work work(std::max<std::size_t>(2, set.size()), step.levers_m.size());
  work.pose(set.primitives(), forces_n.data(), step, true);
  return work.bound_m({at.position_m - step.start.position_m, step.turning_radius_m * at.turn_rad});
}

}  // namespace palpa
