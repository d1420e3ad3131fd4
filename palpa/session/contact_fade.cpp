#include "palpa/session/contact_fade.h"

#include <algorithm>
#include <span>

namespace palpa {

namespace {
// Duration of a fade-out, and of a fade-in. Shorter: a jump of the data is felt as a kick; longer: the new level is late.
constexpr double fade_s = 0.05;
}  // namespace

void ContactFade::clear() noexcept { *this = {}; }

bool ContactFade::advance(bool is_known, double time_step_s) noexcept {
  const double change = time_step_s / fade_s;
  if (!is_leaving_ && is_known) share_ = std::min(1.0, share_ + change);
  if (is_leaving_) share_ = std::max(0.0, share_ - change);
  if (!is_leaving_ || share_ > 0.0 || !is_known) return false;
  is_leaving_ = false;
  return returns_ = true;
}

void ContactFade::keep(std::size_t mode, std::size_t foot, const PrimitiveSet& placed) noexcept {
  level_ = {};
  size_ = 0;
  for (std::size_t i = 0; i < placed.size() && size_ < static_cast<std::int32_t>(most_primitives); ++i) {
    Primitive p = placed[i];
    if (p.id.mode != mode || p.id.foot != foot) continue;
    if (placed.captured(i).any() && p.strength_n > 0.0) {
      level_ = {placed.captured(i).field, placed.captured(i).value};
      plane_ = size_;
    }
    if (share_ > 0.0) {  // strengths without the fade
      p.strength_n /= share_;
      p.drag_ns_per_m /= share_;
    }
    last_[static_cast<std::size_t>(size_++)] = p;
  }
}

bool ContactFade::begin_fade_out(Samples& samples) noexcept {
  if (level_.field < 0) return false;
  const Primitive& plane = last_[static_cast<std::size_t>(plane_)];
  const DataTime now = samples.time(), before = samples.came_from();
  samples.set_time(before);
  is_free_above_ = dot(plane.direction, samples.scalar(level_.field, plane.position_m).gradient) > 0.0;
  samples.set_time(now, before);
  return is_leaving_ = true;
}

void ContactFade::place(const Vec3& start_m, PrimitiveSet& out) const noexcept {
  for (Primitive p : std::span(last_).first(static_cast<std::size_t>(size_))) {
    const bool is_at_proxy = p.kind == PrimitiveKind::point || p.kind == PrimitiveKind::line;
    if (is_at_proxy) p.position_m = start_m;
    out.add(p);
  }
}

void ContactFade::configure_events(std::size_t foot, std::int32_t field, Crossings& crossings, EventPolicy& policy) noexcept {
  if (is_leaving_) policy.fields[field].is_ignored = true;
  if (returns_) crossings.take_side(foot, level_, is_free_above_);
  returns_ = false;
}

}  // namespace palpa
