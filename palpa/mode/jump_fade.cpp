#include "palpa/mode/jump_fade.h"

#include <algorithm>

namespace palpa {

namespace {
constexpr double fade_s = 0.05;  // out, and in again
}  // namespace

void JumpFade::clear() noexcept {
  share_ = 1.0;
  is_leaving_ = returns_ = false;
}

bool JumpFade::advance(bool is_known, double time_step_s) noexcept {
  const double change = time_step_s / fade_s;
  if (!is_leaving_ && is_known) share_ = std::min(1.0, share_ + change);
  if (is_leaving_) share_ = std::max(0.0, share_ - change);
  if (!is_leaving_ || share_ > 0.0 || !is_known) return false;
  is_leaving_ = false;
  return returns_ = true;
}

bool JumpFade::let_go(std::size_t mode, const PrimitiveSet& placed, Samples& samples) noexcept {
  last_.clear();
  for (std::size_t i = 0; i < placed.size(); ++i) {
    Primitive p = placed[i];
    if (p.id.mode != mode) continue;
    if (placed.captured(i).any() && p.strength_n > 0.0) {
      is_leaving_ = true;
      level_ = {placed.captured(i).field, placed.captured(i).value};
      const DataTime now = samples.time(), before = samples.came_from();
      samples.set_time(before);
      is_free_above_ = dot(p.direction, samples.scalar(level_.field, p.position_m).gradient) > 0.0;
      samples.set_time(now, before);
    }
    if (share_ > 0.0) {  // as it is without the fade
      p.strength_n /= share_;
      p.drag_ns_per_m /= share_;
    }
    if (last_.size() < most_primitives) last_.push_back(p);
  }
  return is_leaving_;
}

void JumpFade::place(const Vec3& start_m, PrimitiveSet& out) const noexcept {
  for (Primitive p : last_) {
    const bool is_at_proxy = p.kind == PrimitiveKind::point || p.kind == PrimitiveKind::line;
    if (is_at_proxy) p.position_m = start_m;
    out.add(p);
  }
}

void JumpFade::attend(std::int32_t field, Crossings& crossings, EventPolicy& policy) noexcept {
  if (is_leaving_) policy.fields[field].is_ignored = true;
  if (returns_) crossings.take_side(level_, is_free_above_);
  returns_ = false;
}

}  // namespace palpa
