#include "palpa/tick/kept_planes.h"

#include <algorithm>

#include "palpa/tick/felt_modes.h"

namespace palpa {

namespace {

constexpr double distinct_squared = 1e-7;  // |n − n'|² of normals that are not the same: a third of a milliradian
constexpr double hollow_m = 1e-13;         // what rounding may hide
constexpr double reach_spacings = 0.75;

}  // namespace

template <class Drop>
void KeptPlanes::drop_if(Drop&& drop) noexcept {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < size_; ++i) {
    if (!drop(planes_[i])) planes_[kept++] = planes_[i];
  }
  size_ = kept;
}

void KeptPlanes::begin_tick() noexcept {
  drop_if([](Plane& plane) { return ++plane.age_ticks > 1; });
}

void KeptPlanes::carry(const Samples& samples) noexcept {
  for (std::size_t i = 0; i < size_; ++i) {
    Plane& plane = planes_[i];
    plane.position_m = samples.carried_m(plane.level.field, plane.position_m, samples.came_from(), samples.time());
  }
}

void KeptPlanes::meet(const PrimitiveSet& set) noexcept {
  for (std::size_t i = 0; i < set.size(); ++i) {
    const Primitive& p = set[i];
    if (!set.captured(i).any() || !(p.strength_n > 0.0) || p.id.slot >= FeltModes::first_slot_of_the_tick) continue;
    drop_if(
        [&](const Plane& plane) { return plane.id == p.id && norm_squared(plane.normal - p.direction) < distinct_squared; });
    if (size_ == most) --size_;  // the one met longest ago
    std::copy_backward(planes_.begin(), planes_.begin() + static_cast<std::ptrdiff_t>(size_),
                       planes_.begin() + static_cast<std::ptrdiff_t>(size_) + 1);
    planes_[0] = {p.id, set.captured(i), p.position_m, p.direction, 0};
    ++size_;
  }
}

void KeptPlanes::forget_beyond(const Vec3& position_m, double reach_m) noexcept {
  drop_if([&](const Plane& plane) { return distance(plane.position_m, position_m) > reach_m; });
}

bool KeptPlanes::add_to(PrimitiveSet& set, std::span<const double> own_n, const Balance& found, double behind_m,
                        double slack_m) const noexcept {
  const bool relaxed = slack_m > 0.0;
  const double tolerance_m = std::max(hollow_m, slack_m);
  const std::size_t before = set.size();
  const auto put_back = [&](const Vec3& position_m, const Vec3& normal) {
    const double cut_off_m = dot(normal, position_m - set.start_m());
    return relaxed && cut_off_m > 0.0 ? position_m - 0.5 * cut_off_m * normal : position_m;
  };
  for (std::size_t i = 0; i < own_n.size() && size_ > 0; ++i) {
    Primitive newest = set[i];
    const Captured level = set.captured(i);
    if (!level.any() || state_at(newest, found) == PrimitiveState::slip) continue;
    const double strength_n = std::min(wedge * own_n[i], largest_strength_n);
    const std::size_t count = set.size();
    for (std::size_t j = 0; j < size_; ++j) {
      const Plane& kept = planes_[j];
      if (!(kept.id == newest.id) || kept.level != level) continue;
      if (norm_squared(kept.normal - newest.direction) < distinct_squared) continue;
      const Vec3 position_m = put_back(kept.position_m, kept.normal);
      if (dot(kept.normal, position_m - found.position_m) <= behind_m) continue;
      const Vec3 apart_m = set[i].position_m - kept.position_m;
      const bool in_front = dot(kept.normal, apart_m) >= -tolerance_m;
      const bool behind = dot(newest.direction, apart_m) > tolerance_m;
      const bool opposed = dot(kept.normal, newest.direction) < 0.0;
      if (relaxed ? !in_front && behind && !opposed : !in_front || behind) continue;
      const auto slot = static_cast<std::uint16_t>(FeltModes::first_slot_of_the_tick + most * i + j);
      bool there = false;
      for (std::size_t k = own_n.size(); k < set.size(); ++k)
        there = there || (set[k].id.mode == newest.id.mode && set[k].id.slot == slot);
      if (there) continue;
      set.begin_mode(newest.id.mode);
      set.plane(slot, position_m, kept.normal, strength_n, level);
    }
    if (set.size() == count || newest.strength_n == strength_n) continue;
    newest.position_m = put_back(newest.position_m, newest.direction);
    newest.strength_n = strength_n;
    set.replace(i, newest, level);
  }
  return set.size() > before;
}

void KeptPlanes::end_step(const PrimitiveSet& set, const Balance& balance, const Vec3& proxy_m, double spacing_m) noexcept {
  drop_if([&](Plane& plane) {
    bool stands = false;
    for (std::size_t i = 0; i < set.size() && !stands; ++i) stands = set[i].id == plane.id && set.captured(i) == plane.level;
    if (!stands || distance(plane.position_m, proxy_m) > reach_spacings * spacing_m) return true;
    const Primitive primitive{PrimitiveKind::plane, plane.id, plane.position_m, plane.normal, 1.0, 0.0};
    if (state_at(primitive, balance) != PrimitiveState::off) plane.age_ticks = 0;
    return false;
  });
}

}  // namespace palpa
