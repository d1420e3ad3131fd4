#include "palpa/core/slack.h"

#include <algorithm>

namespace palpa {

namespace {

// The point nearest to `x` on the straight way from 0 to `end`; the end itself to the bit.
Vec3 nearest_on_way(const Vec3& x, const Vec3& end) noexcept {
  const double along = dot(x, end), all = norm_squared(end);
  if (!(along > 0.0)) return {};
  return along < all ? (along / all) * end : end;
}

}  // namespace

Vec3 Slack::felt_m(const Vec3& stretch_m, const Vec3& to_followed_m, double waits_s, const Vec3& left_m) noexcept {
  const double share = std::clamp(1.0 - waits_s / fade_s, 0.0, 1.0);
  const Vec3 felt_m = nearest_on_way(left_m, share * to_followed_m);
  unfelt_m_ = stretch_m - felt_m;
  return felt_m;
}

}  // namespace palpa
