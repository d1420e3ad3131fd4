#include "palpa/loop/release.h"

#include <algorithm>

namespace palpa {

namespace {
constexpr double fall_n_per_s = 500.0;  // slower than a knock, faster than anyone would call soft
constexpr double shortest_s = 0.005;
constexpr double longest_s = 0.020;
}  // namespace

Vec3 Release::shape(const Vec3& command_n, bool is_released, double time_step_s) noexcept {
  if (is_released) {
    falling_n_ = sent_n_ - command_n;
    whole_s_ = left_s_ = std::clamp(norm(falling_n_) / fall_n_per_s, shortest_s, longest_s);
  }
  left_s_ = std::max(0.0, left_s_ - time_step_s);
  sent_n_ = left_s_ > 0.0 ? command_n + (left_s_ / whole_s_) * falling_n_ : command_n;
  return sent_n_;
}

}  // namespace palpa
