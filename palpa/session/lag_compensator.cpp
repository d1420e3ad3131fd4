#include "palpa/session/lag_compensator.h"

#include <algorithm>
#include <cmath>

namespace palpa {

namespace {

// Point nearest to `x` on the straight line from 0 to `end`; the end itself to the bit.
Motion nearest_on_way(const Motion& x, const Motion& end) noexcept {
  const double along = dot(x, end), all = length_squared(end);
  if (!(along > 0.0)) return {};
  return along < all ? (along / all) * end : end;
}

}  // namespace

Motion LagCompensator::applied_extension_m(const Motion& extension_m, const Motion& to_followed_m, double lag_s,
                                           const Motion& left_m) noexcept {
  const double share = std::clamp(1.0 - lag_s / fade_s, 0.0, 1.0);
  const Motion applied_m = nearest_on_way(left_m, share * to_followed_m);
  withheld_m_ = extension_m - applied_m;
  any_ = withheld_m_ != Motion{};
  if (lag_s > 0.0) left_s_ = give_back_s;
  return applied_m;
}

// Whole ticks, so that the last of them is within the remaining time.
Motion LagCompensator::give_back_m(double time_step_s, double most_m) noexcept {
  constexpr double rounded = 1.0 + 1e-9;  // [1] for times that are sums of ticks
  const double ticks = std::floor(rounded * left_s_ / time_step_s);
  left_s_ = std::max(0.0, left_s_ - time_step_s);
  const Motion back_m = shortened(withheld_m_ / std::max(1.0, ticks), most_m);
  withheld_m_ = back_m == withheld_m_ ? Motion{} : withheld_m_ - back_m;
  any_ = withheld_m_ != Motion{};
  return back_m;
}

}  // namespace palpa
