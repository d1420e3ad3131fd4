#include "palpa/solver/tool_law.h"

#include <utility>

#include "palpa/solver/split.h"

namespace palpa {

ToolLaw::ToolLaw(std::unique_ptr<Law> law, const Tool& tool, std::size_t capacity)
    : law_(std::move(law)), tool_(tool), levers_m_(tool.feet()) {
  if (tool.is_point()) return;
  pose_law_ = std::make_unique<PoseSolver>(capacity, tool.feet());
  planes_.reserve(capacity);
  plane_levers_m_.reserve(capacity);
  plane_forces_n_.reserve(capacity);
  loads_n_.reserve(capacity);
}

void ToolLaw::turn_levers() noexcept {
  seen_ = {start_.turn, {}};
  for (std::size_t foot = 0; foot < tool_.feet(); ++foot) levers_m_[foot] = tool_.lever_m(start_.turn, foot);
}

Balance ToolLaw::solve_body(const PrimitiveSet& set, const Pose& probe, double stiffness_n_per_m, double time_step_s) noexcept {
  return pose_law_->solve(set, {start_, probe, levers_m_, stiffness_n_per_m, tool_.turning_radius_m(), time_step_s});
}

std::span<const Vec3> ToolLaw::loads_n(const PrimitiveSet& set, const Balance& found) noexcept {
  if (tool_.is_point()) return law_->forces_n();
  const auto is_plane = [](const Primitive& p) { return p.kind == PrimitiveKind::plane || p.kind == PrimitiveKind::corner; };
  loads_n_.assign(forces_n().begin(), forces_n().end());
  planes_.clear();
  plane_levers_m_.clear();
  plane_forces_n_.clear();
  for (std::size_t i = 0; i < set.size(); ++i) {
    if (!is_plane(set[i])) continue;
    planes_.push_back(set[i]);
    plane_levers_m_.push_back(lever_m(set[i].id));
    plane_forces_n_.push_back(loads_n_[i]);
  }
  const FeetOfRows feet{plane_levers_m_, tool_.turning_radius_m()};
  if (!split_is_shared(planes_, found, feet)) return loads_n_;
  least_split(planes_, found, plane_forces_n_, feet);
  for (std::size_t i = 0, plane = 0; i < set.size(); ++i) {
    if (is_plane(set[i])) loads_n_[i] = plane_forces_n_[plane++];
  }
  return loads_n_;
}

void ToolLaw::reset() noexcept { tool_.is_point() ? law_->reset() : pose_law_->reset(); }

Pose ToolLaw::body_pose_of(const Balance& balance, const Pose& probe) const noexcept {
  const bool is_at_probe =
      balance.position_m == probe.position_m && balance.turn_rad == rotation_between_rad(start_.turn, probe.turn);
  return is_at_probe ? probe : Pose{balance.position_m, turned_further(start_.turn, balance.turn_rad)};
}

Vec3 ToolLaw::linear_foot_m(const PrimitiveId& id, const Pose& end) const noexcept {
  if (tool_.is_point()) return end.position_m;
  if (seen_.to != end.turn) seen_ = {end.turn, rotation_between_rad(start_.turn, end.turn)};
  return end.position_m + lever_m(id) + cross(seen_.rotation_rad, lever_m(id));
}

}  // namespace palpa
