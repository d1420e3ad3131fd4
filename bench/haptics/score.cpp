#include "bench/haptics/score.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "bench/haptics/shape.h"

namespace palpa::haptics {

namespace {

// [N] Contact threshold: 0.1 mm of the spring.
constexpr double felt_n = 0.05;
// [N] Resting offset: below the just noticeable difference at 2.5 N (7 %).
constexpr double rest_n = 0.1;
// [N] Largest change per tick at rest.
constexpr double still_n = 1e-3;

/// Quantile `share` [1] of sorted values, without interpolation; 0 of none.
double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at = static_cast<std::ptrdiff_t>(std::ceil(share * static_cast<double>(values.size()))) - 1;
  std::nth_element(values.begin(), values.begin() + std::max<std::ptrdiff_t>(at, 0), values.end());
  return values[static_cast<std::size_t>(std::max<std::ptrdiff_t>(at, 0))];
}

double angle_deg(const Vec3& a, const Vec3& b) { return std::atan2(norm(cross(a, b)), dot(a, b)) * 180.0 / std::numbers::pi; }

double root_mean_square(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return values.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(values.size()));
}

class Scoring {
 public:
  Scoring(const MadeCase& one, std::span<const Vec3> forces_n) : one_(one), forces_n_(forces_n) {}

  bool in_contact(std::size_t i) const { return norm(right(i)) > felt_n; }

  void surface(const std::filesystem::path& folder, Scores& out) const {
    const Shape shape = shape_of(one_.shape, folder);
    std::vector<double> off_mm;
    for (std::size_t i = 0; i < size(); ++i) {
      if (in_contact(i)) off_mm.push_back(1e3 * std::abs(shape.depth_m(probe(i) + forces_n_[i] / stiffness_n_per_m)));
    }
    out["surface_p50_mm"] = quantile(off_mm, 0.5);
    out["surface_p99_mm"] = quantile(off_mm, 0.99);
  }

  void direction(Scores& out) const {
    std::vector<double> off_deg;
    for (std::size_t i = 0; i < size(); ++i) {
      if (in_contact(i)) off_deg.push_back(norm(forces_n_[i]) < still_n ? 180.0 : angle_deg(forces_n_[i], right(i)));
    }
    out["direction_p50_deg"] = quantile(off_deg, 0.5);
    out["direction_p99_deg"] = quantile(off_deg, 0.99);
  }

  void force(Scores& out) const {
    std::vector<double> off_n, right_n;
    for (std::size_t i = 0; i < size(); ++i) {
      if (right(i) == Vec3{} && forces_n_[i] == Vec3{}) continue;
      off_n.push_back(norm(error(i)));
      right_n.push_back(norm(right(i)));
    }
    out["force_rms_n"] = root_mean_square(off_n);
    out["force_p99_n"] = quantile(off_n, 0.99);
    out["force_share"] = 100.0 * root_mean_square(off_n) / root_mean_square(right_n);
  }

  /// Share [1] of the contact with less than half of the force.
  double lost_share() const {
    int contact = 0, lost = 0;
    for (std::size_t i = 0; i < size(); ++i) {
      if (!in_contact(i)) continue;
      ++contact;
      lost += dot(forces_n_[i], right(i)) < 0.5 * norm_squared(right(i));
    }
    return contact > 0 ? static_cast<double>(lost) / contact : 0.0;
  }

  void rest(Scores& out) const {
    int holds = 0, false_rests = 0, restless = 0;
    for (std::size_t begin = 0; begin < size();) {
      std::size_t end = begin;
      while (end < size() && one_.touches[end].phase == Phase::still) ++end;
      if (end == begin) {
        ++begin;
        continue;
      }
      bool moves = false;
      for (std::size_t i = begin + (end - begin) / 2; i < end; ++i)
        moves = moves || norm(forces_n_[i] - forces_n_[i - 1]) > still_n;
      if (in_contact(end - 1)) {
        ++holds;
        restless += moves;
        const Vec3 n = normalized(right(end - 1)), e = error(end - 1);
        false_rests += !moves && (norm(e - dot(e, n) * n) > rest_n || norm(forces_n_[end - 1]) < felt_n);
      }
      begin = end;
    }
    out["false_rest_share"] = holds > 0 ? 100.0 * false_rests / holds : 0.0;
    out["restless_share"] = holds > 0 ? 100.0 * restless / holds : 0.0;
  }

  void friction(const std::filesystem::path& folder, Scores& out) const {
    const Vec3 n = shape_of(one_.shape, folder).outward({});
    const auto angle_of = [&](const Vec3& force_n) { return angle_deg(force_n, n); };
    std::vector<double> off_deg;
    for (std::size_t i = 0; i < size(); ++i) {
      if (one_.touches[i].phase != Phase::sliding || !in_contact(i)) continue;
      // Without a force there is no angle: all of the cone is missing.
      const double felt_deg = norm(forces_n_[i]) < still_n ? 0.0 : angle_of(forces_n_[i]);
      off_deg.push_back(std::abs(felt_deg - angle_of(right(i))));
    }
    out["friction_p50_deg"] = quantile(off_deg, 0.5);
    out["friction_p99_deg"] = quantile(off_deg, 0.99);
  }

  // The largest forces of both are compared from a contact's true beginning to its true end.
  void breaks(Scores& out) const {
    double worst_n = 0.0;
    for (std::size_t begin = 0; begin < size();) {
      std::size_t end = begin;
      double right_n = 0.0, felt = 0.0;
      for (; end < size() && in_contact(end); ++end) {
        right_n = std::max(right_n, norm(right(end)));
        felt = std::max(felt, norm(forces_n_[end]));
      }
      worst_n = std::max(worst_n, std::abs(felt - right_n));
      begin = std::max(end, begin + 1);
    }
    out["break_n"] = worst_n;
  }

  // The last turn's end against the first turn's.
  void drift(Scores& out) const {
    const auto period = static_cast<std::size_t>(one_.period_ticks);
    const std::size_t turns = (size() - 1) / period - 1, last = size() - 1, first = last - turns * period;
    out["drift_um"] = 1e6 * norm(error(last) - error(first)) / stiffness_n_per_m / static_cast<double>(turns);
  }

  // Work on the hand after the first turn, less the true work.
  void energy(Scores& out) const {
    const auto period = static_cast<std::size_t>(one_.period_ticks);
    const std::size_t turns = (size() - 1) / period - 1, first = size() - 1 - turns * period;
    double work_j = 0.0;
    for (std::size_t i = first; i + 1 < size(); ++i) work_j += 0.5 * dot(error(i) + error(i + 1), probe(i + 1) - probe(i));
    out["energy_mj"] = 1e3 * work_j / static_cast<double>(turns);
  }

  void ripple(Scores& out) const {
    std::vector<double> steps_mn;
    for (std::size_t i = 1; i < size(); ++i) {
      if (in_contact(i) && in_contact(i - 1)) steps_mn.push_back(1e3 * norm(error(i) - error(i - 1)));
    }
    out["ripple_mn"] = root_mean_square(steps_mn);
  }

 private:
  std::size_t size() const { return one_.touches.size(); }
  const Vec3& probe(std::size_t i) const { return one_.touches[i].probe_m; }
  const Vec3& right(std::size_t i) const { return one_.touches[i].force_n; }
  Vec3 error(std::size_t i) const { return forces_n_[i] - right(i); }

  const MadeCase& one_;
  std::span<const Vec3> forces_n_;
};

}  // namespace

Scores score(const MadeCase& one, std::span<const Vec3> forces_n, const std::filesystem::path& folder) {
  const Scoring scoring(one, forces_n);
  Scores out;
  for (const std::string& wanted : one.scores) {
    if (wanted == "surface") scoring.surface(folder, out);
    if (wanted == "direction") scoring.direction(out);
    if (wanted == "force") scoring.force(out);
    if (wanted == "lost") out["lost_share"] = 100.0 * scoring.lost_share();
    if (wanted == "rest") scoring.rest(out);
    if (wanted == "friction") scoring.friction(folder, out);
    if (wanted == "break") scoring.breaks(out);
    if (wanted == "drift") scoring.drift(out);
    if (wanted == "energy") scoring.energy(out);
    if (wanted == "ripple") scoring.ripple(out);
  }
  // A force that does not hold the hand gets no credit for a lack of drift and ripple.
  if (scoring.lost_share() > 0.5) {
    for (const char* name : {"drift_um", "energy_mj", "ripple_mn"}) {
      if (out.contains(name)) out[name] = std::numeric_limits<double>::infinity();
    }
  }
  return out;
}

}  // namespace palpa::haptics
