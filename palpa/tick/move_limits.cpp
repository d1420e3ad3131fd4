#include "palpa/tick/move_limits.h"

#include <algorithm>

#include "palpa/tick/path_tolerances.h"
#include "palpa/tick/watch.h"

namespace palpa {

using namespace path_tolerances;

namespace {

constexpr int max_halvings = 6;

}  // namespace

// On the levels that hold the proxy, as near as one step comes to them.
Vec3 MoveLimits::put_back(const Vec3& x_m) const noexcept {
  const PrimitiveSet& set = joint_.set();
  const double spacing_m = joint_.terms().spacing_m;
  Samples& samples = modes_.samples();
  Vec3 on_level = x_m;
  for (std::size_t i = 0; i < joint_.own(); ++i) {
    const Captured& level = set.captured(i);
    if (!level.any() || !(set[i].strength_n > 0.0) || joint_.state_of(i, to_) != PrimitiveState::stick) continue;
    samples.move_to(on_level);
    const ScalarSample& sample = samples.scalar(level.field);
    const double steepness = norm(sample.gradient);
    if (!sample.inside || !(steepness > 0.0)) continue;
    on_level += std::clamp((level.value - sample.value) / steepness, -spacing_m, spacing_m) * normalized(sample.gradient);
  }
  return on_level;
}

double MoveLimits::descending_share(double share) const noexcept {
  const PrimitiveSet& set = joint_.set();
  const double spacing_m = joint_.terms().spacing_m;
  Vec3 directed_n;
  bool any = false;
  for (std::size_t i = 0; i < joint_.own(); ++i) {
    const Primitive& p = set[i];
    if (p.kind == PrimitiveKind::directed) directed_n += p.strength_n * p.direction;
    any = any || (set.captured(i).any() && p.strength_n > 0.0);
  }
  for (std::size_t m = 0; m < modes_.size(); ++m) any = any && !modes_.fades(m);  // that level is where the proxy is not yet
  const Vec3 move_m = to_.position_m - start_m_;
  if (!any || share * norm(move_m) <= still * spacing_m) return share;
  const Vec3 before = put_back(start_m_);
  const double off_m = distance(before, start_m_);
  const bool is_off = off_m > piercing * spacing_m;
  const auto descends = [&](const Vec3& from, const Vec3& after, double allowed) {
    // As a product: the difference of two squares would lose its digits.
    const Vec3 pull_n = stiffness_n_per_m_ * (0.5 * (from + after) - probe_m_) - directed_n;
    return dot(after - from, pull_n) <= allowed * spacing_m * norm(pull_n);
  };
  for (int halving = 0; halving < max_halvings; ++halving, share *= 0.5) {
    const Vec3 end = start_m_ + share * move_m;
    const Vec3 after = put_back(end);
    // A proxy that is off its level has to come back, whatever that costs.
    if (is_off ? distance(after, end) < off_m : descends(before, after, 0.0)) return share;
    // Data may carry the proxy against the spring, as far as they go themselves.
    for (std::size_t m = 0; modes_.any_carried() && m < modes_.size(); ++m) {
      const Vec3& carried_m = modes_.carried_m(m);
      if (carried_m != Vec3{} && descends(put_back(start_m_ + share * carried_m), after, trial)) return share;
    }
  }
  return 0.0;
}

double MoveLimits::share_outside(const Vec3& end_m) const noexcept {
  const PrimitiveSet& set = joint_.set();
  const double spacing_m = joint_.terms().spacing_m;
  double share = 1.0;
  if (distance(start_m_, end_m) <= piercing * spacing_m) return share;
  Samples& samples = modes_.samples();
  for (std::size_t i = 0; i < joint_.own(); ++i) {
    const Captured& level = set.captured(i);
    if (!level.any() || !(joint_.own_n(i) > 0.0) || joint_.state_of(i, to_) == PrimitiveState::slip) continue;
    samples.move_to(joint_.terms().levels_at_m);  // where the plane's normal was read
    const Vec3 uphill = samples.scalar(level.field).gradient;
    const bool solid_is_high = dot(uphill, set[i].direction) < 0.0;
    const double margin = piercing * spacing_m * norm(uphill);
    samples.move_to(start_m_);
    const double here = samples.scalar(level.field).value;
    // From where the proxy is, if it is inside already.
    const double value = solid_is_high ? std::max(level.value, here) + margin : std::min(level.value, here) - margin;
    share = std::min(share, first_beyond(samples, level.field, value, solid_is_high, start_m_, end_m));
  }
  return share;
}

}  // namespace palpa
