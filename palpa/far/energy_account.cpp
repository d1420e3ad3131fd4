#include "palpa/far/energy_account.h"

#include <algorithm>
#include <cmath>

namespace palpa {

namespace {

constexpr double shrink_n_per_s = 50.0;  // More: an update is felt as a click; less: forces stay off the model for longer
constexpr double shrink_s = 0.02;        // Of a large offset. Shorter: a click; longer: as above
constexpr double enough = 1.0 - 1e-12;   // [1] of an energy: rounding of the sums below

}  // namespace

double EnergyAccount::shrinks_m(double offset_m, const Step& step) noexcept {
  return std::max(norm(step.probe_step_m) + shrink_n_per_s * step.time_step_s / step.stiffness_n_per_m,
                  offset_m * std::min(1.0, step.time_step_s / shrink_s));
}

Vec3 EnergyAccount::felt_m(const Step& step) noexcept {
  const double half_k = 0.5 * step.stiffness_n_per_m;
  const auto spring_j = [&](const Vec3& extension_m) { return half_k * norm_squared(extension_m); };
  const double length_m = norm(offset_m_), way_m = shrinks_m(length_m, step);
  const Vec3 offset_m = length_m > way_m ? (1.0 - way_m / length_m) * offset_m_ : Vec3{};
  const Vec3 whole_m = step.now_m + offset_m;
  Vec3 felt_m = whole_m;

  const double kept_j = spring_j(felt_m_ - step.probe_step_m);
  const double rest_j = kept_j + account_j_ + income_w * step.time_step_s - step.elastic_j;
  // A source that takes energy takes what there is: its debt would be the model's, not the hand's.
  const double most_j = step.source_j < 0.0 ? std::max(std::min(rest_j, 0.0), rest_j + step.source_j) : rest_j + step.source_j;
  const double wanted_j = spring_j(whole_m);
  if (wanted_j > 0.0 && enough * wanted_j > most_j) {
    const double own_m = distance(step.now_m, step.before_m - step.probe_step_m);
    const double shortened_m = way_m + own_m + shrinks_m(norm(whole_m), step);
    const double least = std::max(0.0, 1.0 - shortened_m / norm(whole_m));
    felt_m = std::max(std::sqrt(std::max(0.0, most_j) / wanted_j), least) * whole_m;
  }
  account_j_ = std::min(full_j, most_j - spring_j(felt_m));
  offset_m_ = felt_m == step.now_m ? Vec3{} : felt_m - step.now_m;
  link_j_ = spring_j(felt_m) - kept_j - (spring_j(step.now_m) - spring_j(step.before_m - step.probe_step_m));
  felt_m_ = felt_m;
  return felt_m;
}

}  // namespace palpa
