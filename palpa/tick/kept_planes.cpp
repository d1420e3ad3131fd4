#include "palpa/tick/kept_planes.h"

#include <algorithm>

#include "palpa/tick/felt_modes.h"

namespace palpa {

namespace {

constexpr double distinct_squared = 1e-4;  // |n − n'|² of normals that are not the same: half a degree
constexpr double hollow_m = 1e-9;          // what rounding may hide
constexpr double reach_spacings = 0.75;
constexpr double behind_spacings = 1e-5;  // rounding of the balance is far less

bool same_level(const Captured& a, const Captured& b) noexcept { return a.field == b.field && a.value == b.value; }

}  // namespace

void KeptPlanes::begin_tick() noexcept {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < size_; ++i) {
    if (++planes_[i].age_ticks <= 1) planes_[kept++] = planes_[i];
  }
  size_ = kept;
}

std::size_t KeptPlanes::add_to(PrimitiveSet& set) const noexcept {
  const std::size_t own = set.size();
  std::size_t added = 0;
  for (std::size_t i = 0; i < own && size_ > 0; ++i) {
    const Primitive newest = set[i];
    const Captured level = set.captured(i);
    if (!level.any()) continue;
    for (std::size_t j = 0; j < size_; ++j) {
      const Plane& kept = planes_[j];
      if (!(kept.id == newest.id) || !same_level(kept.level, level)) continue;
      if (norm_squared(kept.normal - newest.direction) < distinct_squared) continue;
      // Each in front of the other: a hollow. A surface that turns away leaves its own tangents behind.
      const Vec3 apart_m = newest.position_m - kept.position_m;
      if (dot(kept.normal, apart_m) < -hollow_m || dot(newest.direction, apart_m) > hollow_m) continue;
      set.begin_mode(newest.id.mode);
      set.plane(static_cast<std::uint16_t>(FeltModes::first_slot_of_the_tick + most * newest.id.slot + added), kept.position_m,
                kept.normal, newest.strength_n, level);
      ++added;
    }
  }
  return set.size() - own;
}

void KeptPlanes::learn(const PrimitiveSet& set, const Balance& balance, const Vec3& proxy_m, double spacing_m) noexcept {
  std::array<Plane, most> next;
  std::size_t count = 0;
  const auto find = [&](const Plane& plane) {
    std::size_t i = 0;
    while (i < count && !(next[i].id == plane.id && norm_squared(next[i].normal - plane.normal) < distinct_squared)) ++i;
    return i;
  };
  for (std::size_t i = 0; i < set.size() && count < most; ++i) {
    const Primitive& p = set[i];
    if (set.captured(i).any() && p.strength_n > 0.0 && p.id.slot < FeltModes::first_slot_of_the_tick)
      next[count++] = {p.id, set.captured(i), p.position_m, p.direction, 0};
  }
  const std::size_t own = count;
  for (std::size_t j = 0; j < size_ && count < most; ++j) {
    Plane kept = planes_[j];
    const bool stands = std::any_of(next.begin(), next.begin() + static_cast<std::ptrdiff_t>(own),
                                    [&](const Plane& n) { return n.id == kept.id && same_level(n.level, kept.level); });
    const bool near = distance(kept.position_m, proxy_m) <= reach_spacings * spacing_m;
    const bool in_front = dot(kept.normal, proxy_m - kept.position_m) >= -behind_spacings * spacing_m;
    if (!stands || !near || !in_front || find(kept) < count) continue;
    const Primitive plane{PrimitiveKind::plane, kept.id, kept.position_m, kept.normal, 1.0, 0.0};
    if (state_at(plane, balance) != PrimitiveState::off) kept.age_ticks = 0;
    next[count++] = kept;
  }
  planes_ = next;
  size_ = count;
}

}  // namespace palpa
