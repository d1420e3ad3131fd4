#include "palpa/scene/first_scene_lines.h"

#include <algorithm>

#include "palpa/base/printed.h"

namespace palpa::detail {
namespace {

constexpr std::size_t comment_at = 40;  // column of the reasons

}  // namespace

std::string reasoned(const std::string& what, const std::string& why) {
  const std::string gap(what.size() < comment_at ? comment_at - what.size() : 2, ' ');
  return what + gap + "# " + why + "\n";
}

std::string with_digits(double value, int digits) { return text("%.*g", digits, value); }

std::string percent(double share) { return with_digits(100.0 * share, 2) + " %"; }

std::string size_words(std::initializer_list<double> lengths_m) {
  constexpr std::pair<const char*, double> units[] = {{"km", 1e3}, {"m", 1.0}, {"mm", 1e-3}, {"um", 1e-6}, {"nm", 1e-9}};
  const double longest_m = std::max(lengths_m);
  const auto* unit = std::ranges::find_if(units, [&](const auto& u) { return longest_m >= u.second; });
  if (unit == std::end(units)) unit = std::end(units) - 1;
  std::string all;
  for (const double length_m : lengths_m) {
    const double length = length_m / unit->second;
    all += (all.empty() ? "" : " x ") + with_digits(length, length < 1000.0 ? 3 : 4);
  }
  return all + " " + unit->first;
}

std::string size_words(const Vec3& size_m) { return size_words({size_m.x, size_m.y, size_m.z}); }

}  // namespace palpa::detail
