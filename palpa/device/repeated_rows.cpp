#include "palpa/device/repeated_rows.h"

#include <algorithm>
#include <vector>

namespace palpa::detail {
namespace {

// Coarsest step of a haptic device's encoder: commercial ones have 10 to 60 um. More: slow hands of slow trackers keep their
// repeats; less: coarse encoders lose theirs.
constexpr double coarsest_encoder_step_m = 1.5e-4;
// Steps of an encoder are similar: largest ratio of their ninth decile to their first. More: steps of a tracker count as an
// encoder's; less: those of encoders in joints, which vary with the arm's reach, count as a tracker's.
constexpr double widest_encoder_spread = 2.0;
// Least ratio of the spread of steps to the spread of row counts between them, for a logger. More: trackers with uneven times
// keep their repeats; less: encoders in joints lose theirs.
constexpr double least_excess = 1.5;
// Least ratio [1] of a logger's step after a repeat to other steps, if most rows are new: below, it is an encoder's, of a slow
// hand.
constexpr double least_share_of_other_steps = 0.5;

template <class Number>
Number quantile(std::vector<Number> values, double share) {
  const auto at = std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())));
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(at));
  return values[at];
}

}  // namespace

bool repeat_by_logger(std::span<const PositionChange> changes) {
  std::vector<double> after_repeat_m, other_m, rows;
  for (const PositionChange& change : changes) {
    (change.rows > 1 ? after_repeat_m : other_m).push_back(change.step_m);
    if (change.rows > 1) rows.push_back(change.rows);
  }
  if (after_repeat_m.empty()) return false;
  const double middle_m = quantile(after_repeat_m, 0.5);
  const double spread = quantile(after_repeat_m, 0.9) / quantile(after_repeat_m, 0.1);
  const bool differ = spread > widest_encoder_spread;
  if (other_m.size() > after_repeat_m.size()) {
    const bool is_slow = middle_m < least_share_of_other_steps * quantile(other_m, 0.5);
    return !is_slow && (differ || middle_m > coarsest_encoder_step_m);
  }
  if (!differ) return middle_m > coarsest_encoder_step_m;
  return spread > least_excess * quantile(rows, 0.9) / quantile(rows, 0.1) ||
         quantile(after_repeat_m, 0.9) > coarsest_encoder_step_m;
}

}  // namespace palpa::detail
