#include "palpa/far/local_model.h"

#include <algorithm>
#include <memory>

#include "palpa/solver/solver.h"

namespace palpa {

namespace {

bool is_level(const Primitive& p) noexcept { return p.kind == PrimitiveKind::plane || p.kind == PrimitiveKind::corner; }

// The first of its corner's facets, which counts for all.
bool is_first(const PrimitiveSet& set, std::size_t i) noexcept { return whole_of(set.primitives(), i).data() == &set[i]; }

}  // namespace

LocalModel::LocalModel()
    : law_(std::make_unique<Solver>(ModelUpdate::most_rows), tool_, ModelUpdate::most_rows),
      set_(ModelUpdate::most_rows),
      friction_(state_, ModelUpdate::most_rows) {}

void LocalModel::take(const ModelUpdate& update) noexcept {
  rows_ = update.rows;
  count_ = std::min<std::size_t>(update.count, rows_.size());
  proxy_m_ = update.proxy_m;
  valid_m_ = update.valid_m;
}

void LocalModel::clear() noexcept {
  count_ = 0;
  pressing_size_ = met_size_ = 0;
  law_.reset();
  friction_.clear();
}

void LocalModel::place(const Vec3& start_m, double time_step_s, double age_s) noexcept {
  set_.clear(start_m);
  std::array<std::int32_t, ModelUpdate::most_rows> handle_of;
  handle_of.fill(-1);
  for (std::size_t n = 0; n < count_; ++n) {
    const ModelRow& row = rows_[n];
    const Vec3 carried_start_m = start_m + time_step_s * row.velocity_m_per_s;
    Primitive p{row.kind,
                {.slot = row.slot},
                proxy_m_ + row.offset_m + age_s * row.velocity_m_per_s,
                row.direction,
                row.strength_n,
                row.drag_ns_per_m,
                row.stiffness_n_per_m};
    if (row.rides) p.position_m = carried_start_m;
    // A drag acts from the start of a step on: away from it it would be a spring.
    if (p.drag_ns_per_m > 0.0 && !row.rides) p.position_m -= residual(p, carried_start_m);
    Friction friction;
    if (row.plane >= 0) {
      friction = {handle_of[static_cast<std::size_t>(row.plane)], row.coefficient};
      if (!friction.any()) continue;
    }
    set_.begin_mode(row.mode, carried_start_m);
    const std::size_t before = set_.size();
    set_.add(p, {}, friction);
    if (set_.size() == before) continue;
    handle_of[n] = static_cast<std::int32_t>(before);
    row_of_[before] = n;
  }
}

Vec3 LocalModel::move(const Vec3& start_m, const Vec3& probe_m, double time_step_s, double age_s,
                      double stiffness_n_per_m) noexcept {
  time_step_s_ = std::max(time_step_s, shortest_time_s);
  start_m_ = start_m;
  place(start_m, time_step_s_, age_s);
  const Pose probe{.position_m = probe_m};
  law_.begin_move({.position_m = start_m});
  const Balance found = friction_.solve(law_, set_, probe, stiffness_n_per_m, time_step_s_);
  end_m_ = is_finite(found.position_m) ? found.position_m : start_m;
  find_met(stiffness_n_per_m);
  return end_m_;
}

void LocalModel::find_met(double stiffness_n_per_m) noexcept {
  const auto before = pressing_;
  const std::span<const PrimitiveId> pressed(before.data(), pressing_size_);
  pressing_size_ = met_size_ = 0;
  for (std::size_t i = 0; i < set_.size(); ++i) {
    const Primitive& p = set_[i];
    if (!is_level(p) || !(p.stiffness_n_per_m > stiffness_n_per_m) || law_.forces_n()[i] == Vec3{}) continue;
    pressing_[pressing_size_++] = p.id;
    if (std::ranges::find(pressed, p.id) == pressed.end()) met_[met_size_++] = {p.direction, p.strength_n};
  }
}

double LocalModel::elastic_j() const noexcept {
  double all_j = 0.0;
  for (std::size_t i = 0; i < set_.size(); ++i) {
    if (!set_[i].is_elastic() || !is_first(set_, i)) continue;
    all_j += 0.5 * set_[i].stiffness_n_per_m * norm_squared(way_to_footing_m(set_.primitives(), i, end_m_));
  }
  return all_j;
}

double LocalModel::source_j() const noexcept {
  double all_j = 0.0;
  const std::span<const Vec3> forces_n = law_.forces_n();
  for (std::size_t i = 0; i < set_.size() && i < forces_n.size(); ++i) {
    const ModelRow& row = rows_[row_of_[i]];
    const Vec3 carried_m = time_step_s_ * row.velocity_m_per_s;
    all_j += dot(forces_n[i], carried_m);
    if (!row.rides && !is_level(set_[i])) all_j += fall_j(set_[i], start_m_ + carried_m, end_m_, time_step_s_);
  }
  return all_j;
}

}  // namespace palpa
