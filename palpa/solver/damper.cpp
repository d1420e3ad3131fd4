#include "palpa/solver/damper.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace palpa {

namespace {
// Low-pass without an encoder step. Lower: later damping; higher: more noise from the difference of two ticks.
constexpr double cut_off_hz = 150.0;
// The damper's ripple under an encoder, as a share of the spring's. Less: longer windows, later damping; more: more ripple.
constexpr double ripple_share = 1.0 / 3.0;
// Windows with an encoder. Shorter minimum: more ripple on fast changes; longer maximum: damping delayed by up to half of it.
constexpr double shortest_window_s = 3e-3;
constexpr double longest_window_s = 24e-3;
// Largest distance of positions from the line of a steady motion through two of them, in encoder steps: 1 along an axis, (1 +
// √3)/2 across a plane with all three encoders; a little more for rounding.
constexpr double line_tolerance = 1.4;
constexpr double rounding = 1e-9;  // [1] relative error of sums of ticks when times are compared
// Limit on the damper's force: the larger of these. Less: fast contacts are damped less; more: a kick becomes possible.
constexpr double always_allowed_n = 0.2;
constexpr double share_of_spring = 0.5;
}  // namespace

Damper::Damper(double damping_ns_per_m, double encoder_step_m, bool turns) noexcept
    : damping_ns_per_m_(damping_ns_per_m), encoder_step_m_(encoder_step_m), turns_(turns) {}

Motion Damper::relative_velocity(const Motion& stretch_m, const Motion& released_m, double time_step_s,
                                 double stiffness_n_per_m) noexcept {
  // In free space the force must be exactly zero; an estimate would only decay towards zero.
  if (stretch_m.way_m == Vec3{} && (!turns_ || stretch_m.arc_m == Vec3{})) {
    reset({});
    return {};
  }
  const Motion seen = encoder_step_m_ > 0.0 ? windowed(stretch_m, released_m, time_step_s, stiffness_n_per_m)
                                            : smoothed(stretch_m, released_m, time_step_s);
  if (damping_ns_per_m_ == 0.0) return seen;
  const double limit_n = std::max(always_allowed_n, share_of_spring * stiffness_n_per_m * length_m(stretch_m));
  const double longest = limit_n / damping_ns_per_m_, all = length_m(seen);
  return all > longest ? (longest / all) * seen : seen;
}

Motion Damper::smoothed(const Motion& stretch_m, const Motion& released_m, double time_step_s) noexcept {
  if (time_step_s != time_step_s_) {
    time_step_s_ = time_step_s;
    weight_ = -std::expm1(-2.0 * std::numbers::pi * cut_off_hz * time_step_s);
  }
  const auto follow = [&](Vec3 Motion::* part) {
    const Vec3 rate = (stretch_m.*part - last_stretch_m_.*part - released_m.*part) / time_step_s;
    filtered_m_per_s_.*part += weight_ * (rate - filtered_m_per_s_.*part);
    return is_finite(filtered_m_per_s_.*part);
  };
  const bool follows = follow(&Motion::way_m) && (!turns_ || follow(&Motion::arc_m));
  if (!follows) filtered_m_per_s_ = {};
  last_stretch_m_ = stretch_m;
  return filtered_m_per_s_;
}

namespace {

// Slope of the longest line from the past to now, for one component. Walking back, each position narrows the range of slopes
// that pass it closely enough; a position within the range of all later ones ends a line. The shortest line is accepted
// unchecked.
class LongestLine {
 public:
  explicit LongestLine(double tolerance_m) noexcept : tolerance_m_(tolerance_m) {}
  /// \param rise_m  [m] now − then
  void look_back(double rise_m, double age_s) noexcept {
    const double slope = rise_m / age_s, slack = tolerance_m_ / age_s;
    const bool close = slope >= least_ && slope <= most_;
    if (is_long_enough(age_s) && (close || !found_)) {
      slope_ = slope;
      found_ = true;
    }
    least_ = std::max(least_, slope - slack);
    most_ = std::min(most_, slope + slack);
  }
  double slope() const noexcept { return slope_; }
  static bool is_long_enough(double age_s) noexcept { return age_s >= shortest_window_s * (1.0 - rounding); }

 private:
  double tolerance_m_;
  bool found_ = false;
  double slope_ = 0.0;
  double least_ = -std::numeric_limits<double>::infinity();
  double most_ = std::numeric_limits<double>::infinity();
};

// Longest lines of the three components of a vector.
class LinesOfVector {
 public:
  explicit LinesOfVector(double tolerance_m) noexcept : x_(tolerance_m), y_(tolerance_m), z_(tolerance_m) {}
  void look_back(const Vec3& rise_m, double age_s) noexcept {
    x_.look_back(rise_m.x, age_s);
    y_.look_back(rise_m.y, age_s);
    z_.look_back(rise_m.z, age_s);
  }
  Vec3 slope() const noexcept { return {x_.slope(), y_.slope(), z_.slope()}; }

 private:
  LongestLine x_, y_, z_;
};

}  // namespace

Motion Damper::windowed(const Motion& stretch_m, const Motion& released_m, double time_step_s,
                        double stiffness_n_per_m) noexcept {
  const double window_s =
      std::clamp(damping_ns_per_m_ / (ripple_share * stiffness_n_per_m), shortest_window_s, longest_window_s);
  if (released_m != Motion{}) {
    for (Kept& kept : past_) kept.stretch_m += released_m;
  }
  time_s_ += time_step_s;

  const double tolerance_m = line_tolerance * encoder_step_m_;
  LinesOfVector way(tolerance_m), arc(tolerance_m);
  const auto look_back = [&](const Motion& then_m, double age_s) {
    const Motion rise_m = stretch_m - then_m;
    way.look_back(rise_m.way_m, age_s);
    if (turns_) arc.look_back(rise_m.arc_m, age_s);
  };
  bool reached = false;
  for (int i = 0; i < kept_; ++i) {
    const Kept& kept = past_[static_cast<std::size_t>((newest_ - i + most_kept) % most_kept)];
    const double age_s = time_s_ - kept.time_s;
    if (reached && age_s > window_s * (1.0 + rounding)) break;
    look_back(kept.stretch_m, age_s);
    reached = LongestLine::is_long_enough(age_s);
  }
  // Before the first stored position the extension counts as constant.
  if (kept_ < most_kept) {
    const Kept& first = past_[static_cast<std::size_t>((newest_ - kept_ + 1 + most_kept) % most_kept)];
    for (const double age_s : {shortest_window_s, window_s}) {
      if (age_s > (time_s_ - first.time_s) * (1.0 + rounding)) look_back(first.stretch_m, age_s);
    }
  }

  // Stores at most `most_kept` positions per window, at any tick rate.
  if (time_s_ - past_[static_cast<std::size_t>(newest_)].time_s > window_s / (most_kept - 1) * (1.0 - rounding)) {
    newest_ = (newest_ + 1) % most_kept;
    kept_ = std::min(kept_ + 1, most_kept);
    past_[static_cast<std::size_t>(newest_)] = {time_s_, stretch_m};
  }
  const Motion slope{way.slope(), arc.slope()};
  if (is_finite(slope)) return slope;
  reset(stretch_m);
  return {};
}

void Damper::reset(const Motion& stretch_m) noexcept {
  last_stretch_m_ = stretch_m;
  filtered_m_per_s_ = {};
  time_s_ = 0.0;
  newest_ = 0;
  kept_ = 1;
  past_[0] = {0.0, stretch_m};
}

}  // namespace palpa
