#include "palpa/study/beside.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "palpa/base/printed.h"
#include "palpa/study/summary.h"

namespace palpa {
namespace {

// Tolerance of equal hands: a replay from a file of ticks is rounded. More: different hands pass.
constexpr double same_place_m = 1e-9, same_time_s = 1e-9;
// Bridged gaps in an interval: shorter than a hand notices. More: intervals merge.
constexpr double bridged_s = 0.05;

}  // namespace

double discrimination_threshold_n(const Vec3& first_n, const Vec3& second_n) noexcept {
  return std::max(discrimination_min_n, discrimination_share * 0.5 * (norm(first_n) + norm(second_n)));
}

double turned_deg(const Vec3& first_n, const Vec3& second_n) noexcept {
  if (norm(first_n) <= discrimination_min_n || norm(second_n) <= discrimination_min_n) return 0.0;
  return std::atan2(norm(cross(first_n, second_n)), dot(first_n, second_n)) * 180.0 / std::numbers::pi;
}

bool are_distinguishable(const Vec3& first_n, const Vec3& second_n) noexcept {
  return std::abs(norm(first_n) - norm(second_n)) > discrimination_threshold_n(first_n, second_n) ||
         turned_deg(first_n, second_n) > discrimination_deg;
}

std::string where_hands_part(const FeltRun& first, const FeltRun& second) {
  for (std::size_t i = 0; i < std::min(first.ticks.size(), second.ticks.size()); ++i) {
    const FeltTick &a = first.ticks[i], &b = second.ticks[i];
    const std::string place = detail::text("from tick %zu (%.3f s) on ", i, a.t_s);
    if (!(std::abs(a.t_s - b.t_s) <= same_time_s) || !(std::abs(a.dt_s - b.dt_s) <= same_time_s))
      return place + detail::text("the times are others (%.6f s there)", b.t_s);
    if (a.usable != b.usable) return place + "one of the hands is not known";
    if (a.usable && !(distance(a.probe_m, b.probe_m) <= same_place_m))
      return place + detail::text("the probe is %.3g mm elsewhere", 1e3 * distance(a.probe_m, b.probe_m));
  }
  return {};
}

FeltDifference compare_felt(const FeltRun& first, const FeltRun& second) {
  assert(where_hands_part(first, second).empty());
  FeltDifference difference;
  const std::size_t count = std::min(first.ticks.size(), second.ticks.size());
  double squares = 0.0;
  std::size_t noticeable = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const FeltTick &a = first.ticks[i], &b = second.ticks[i];
    const bool pushes = a.usable && std::max(norm(a.command_n), norm(b.command_n)) > contact_force_n;
    difference.difference_n.push_back(pushes ? distance(a.command_n, b.command_n) : 0.0);
    difference.noticeable.push_back(pushes && are_distinguishable(a.command_n, b.command_n));
    if (difference.difference_n[i] > difference.difference_n[difference.largest]) difference.largest = i;
    if (!pushes) continue;
    ++difference.in_contact;
    squares += difference.difference_n[i] * difference.difference_n[i];
    if (difference.noticeable[i] == 0) continue;
    ++noticeable;
    std::vector<NoticeableInterval>& all = difference.intervals;
    if (all.empty() || a.t_s - first.ticks[all.back().last].t_s > bridged_s) all.push_back({i, i, i});
    all.back().last = i;
    if (difference.difference_n[i] > difference.difference_n[all.back().largest]) all.back().largest = i;
  }
  if (difference.in_contact > 0) {
    difference.rms_n = std::sqrt(squares / static_cast<double>(difference.in_contact));
    difference.noticeable_share = static_cast<double>(noticeable) / static_cast<double>(difference.in_contact);
  }
  return difference;
}

}  // namespace palpa
