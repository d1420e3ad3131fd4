#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "palpa/base/load_error.h"
#include "palpa/device/described.h"
#include "palpa/device/front.h"
#include "palpa/device/hand.h"
#include "palpa/device/sine_cosine.h"

namespace palpa {

namespace {

using detail::sine_cosine;
using detail::SineCosine;

constexpr double pi = 3.141592653589793;
double sine(double turns) noexcept { return sine_cosine(turns).sine; }

// Smooth step: 0 before 0, 1 after 1, with two continuous derivatives; its largest slope is 1.875.
double smooth_step(double t) noexcept {
  const double u = std::clamp(t, 0.0, 1.0);
  return u * u * u * (10.0 + u * (6.0 * u - 15.0));
}
constexpr double smooth_step_slope = 1.875;

// SplitMix64 (Steele, Lea, Flood 2014): the standard library's distributions differ between implementations.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  /// In [0, 1).
  double next() noexcept {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

// Approach of a hand from before the front: at up to 0.1 m/s until just before it, then slowly to its depth. An arm of half a
// kilogram lags and swings: in a faster approach it would break through a thin skin unfelt.
class Approach {
 public:
  /// \param from_m, to_m  [m] depths behind the front, negative before it; from < to
  Approach(double from_m, double to_m)
      : from_m_(from_m),
        near_m_(std::min(std::max(from_m, -slow_before_m), to_m)),
        to_m_(to_m),
        near_s_(smooth_step_slope * (near_m_ - from_m_) / fast_m_per_s),
        slow_s_(smooth_step_slope * (to_m_ - near_m_) /
                std::clamp(slow_m_per_s * (to_m_ - near_m_) / (2.0 * slow_before_m), slow_m_per_s, fast_m_per_s)) {}
  double end_s() const noexcept { return near_s_ + slow_s_; }
  /// [m] behind the front.
  double depth_m(double time_s) const noexcept {
    if (time_s < near_s_) return from_m_ + (near_m_ - from_m_) * smooth_step(time_s / near_s_);
    if (time_s < end_s()) return near_m_ + (to_m_ - near_m_) * smooth_step((time_s - near_s_) / slow_s_);
    return to_m_;
  }

 private:
  // Largest speeds far from the front and near it, and the limit of "near"; deeper approaches are faster, up to the first.
  // Faster or later: thin skins break unfelt; slower or earlier: a run begins with a long approach.
  static constexpr double fast_m_per_s = 0.1, slow_m_per_s = 0.02, slow_before_m = 0.003;
  double from_m_, near_m_, to_m_, near_s_, slow_s_;
};

constexpr double usual_m_per_s = 0.1;  // of a motion without a speed: as in exploration. Faster: the arm lags more

/// Frequency of a motion round a path of `length_m` [m]: from its speed, else from `usual_m_per_s`, but at most `most_hz`.
double rate_hz(const SimulatedMotion& motion, double length_m) noexcept {
  constexpr double most_hz = 1.0;  // More: an arm cannot follow small motions; less: these become slow
  return motion.speed_m_per_s ? *motion.speed_m_per_s / length_m : std::min(usual_m_per_s / length_m, most_hz);
}

class SimulatedTarget : public Target {
 public:
  double duration_s() const noexcept final { return std::numeric_limits<double>::infinity(); }
};

class Press final : public SimulatedTarget {
 public:
  Press(const SimulatedMotion& motion, double depth_m, const Encounter& encounter)
      : front_(encounter.facing), back_m_(std::min(-encounter.retreat_m, depth_m)), stroke_m_(depth_m - back_m_) {
    if (-encounter.before_m < back_m_) approach_.emplace(-encounter.before_m, back_m_);
    if (stroke_m_ > 0.0) presses_per_s_ = rate_hz(motion, pi * stroke_m_);
  }
  Point at(double time_s) const noexcept override {
    const double pressing_s = time_s - (approach_ ? approach_->end_s() : 0.0);
    if (pressing_s < 0.0) return {.position_m = front_->at(0.0, 0.0, approach_->depth_m(time_s))};
    const double in = 0.5 * (1.0 - sine_cosine(presses_per_s_ * pressing_s).cosine);
    return {.position_m = front_->at(0.0, 0.0, back_m_ + stroke_m_ * in)};
  }

 private:
  std::shared_ptr<const Front> front_;
  double back_m_, stroke_m_;
  std::optional<Approach> approach_;
  double presses_per_s_ = 0.0;
};

// Path over a front: the hand enters at the point of contact, then moves smoothly to the path.
class Along : public SimulatedTarget {
 public:
  Point at(double time_s) const noexcept final {
    const double share = smooth_step((time_s - approach_.end_s()) / joining_s_);
    const Place place = along(time_s);
    const double depth_m = approach_.depth_m(time_s) + share * place.further_in_m;
    return {.position_m = front_->at(share * place.u, share * place.v, depth_m - share * lifted(time_s) * (depth_m + lift_m_))};
  }

 protected:
  struct Place {
    double u, v;
    double further_in_m = 0.0;  // beyond the motion's depth
  };
  /// \param aside_m  [m] largest distance between the point of entry and the start of the path
  Along(const SimulatedMotion& motion, const Encounter& encounter, std::shared_ptr<const Front> front, double depth_m,
        double aside_m)
      : front_(std::move(front)),
        approach_(-encounter.before_m, depth_m),
        joining_s_(std::max(0.5, smooth_step_slope * aside_m / motion.speed_m_per_s.value_or(usual_m_per_s))),
        lifts_(encounter.lifts && depth_m > 0.0),
        lift_m_(encounter.retreat_m) {}
  virtual Place along(double time_s) const noexcept = 0;

 private:
  std::shared_ptr<const Front> front_;
  /// [1] 0: at its depth, 1: before the front.
  double lifted(double time_s) const noexcept {
    // Period and share of lifts. Shorter or more: less time in contact; longer or less: broken levels are felt again late, or
    // lifts are too fast for an arm.
    constexpr double every_s = 2.0, for_share = 0.3;
    if (!lifts_) return 0.0;
    const double turns = (time_s - approach_.end_s()) / every_s;
    const double within = (turns - std::floor(turns) - (1.0 - for_share)) / for_share;
    return within > 0.0 && turns > 0.0 ? 0.5 * (1.0 - sine_cosine(within).cosine) : 0.0;
  }

  Approach approach_;
  double joining_s_;
  bool lifts_;
  double lift_m_;
};

class Stroke final : public Along {
 public:
  Stroke(const SimulatedMotion& motion, const Encounter& encounter, double depth_m, double radius_m)
      : Along(motion, encounter, encounter.facing, depth_m, 0.0),
        radius_m_(radius_m),
        strokes_per_s_(rate_hz(motion, 2.0 * pi * radius_m)) {}

 private:
  Place along(double time_s) const noexcept override {
    const double turns = strokes_per_s_ * time_s;
    return {radius_m_ * sine(turns), radius_m_ * sine(0.375 * turns)};
  }
  double radius_m_, strokes_per_s_;
};

class Circle final : public Along {
 public:
  Circle(const SimulatedMotion& motion, const Encounter& encounter, double depth_m, double radius_m)
      : Along(motion, encounter, encounter.facing, depth_m, radius_m),
        radius_m_(radius_m),
        turns_per_s_(rate_hz(motion, 2.0 * pi * radius_m)) {}

 private:
  Place along(double time_s) const noexcept override {
    const SineCosine angle = sine_cosine(turns_per_s_ * time_s);
    return {radius_m_ * angle.cosine, radius_m_ * angle.sine};
  }
  double radius_m_, turns_per_s_;
};

class Helix final : public Along {
 public:
  Helix(const SimulatedMotion& motion, const Encounter& encounter, double depth_m)
      : Helix(motion, encounter, depth_m,
              motion.radius_m ? cylinder_around(encounter.axis_m, *motion.radius_m) : encounter.around) {}

 private:
  Helix(const SimulatedMotion& motion, const Encounter& encounter, double depth_m, const std::shared_ptr<const Front>& front)
      : Along(motion, encounter, front, depth_m, 0.0), half_height_m_(encounter.half_height_m) {
    Vec3 last_m = front->at(0.0, 0.0, depth_m);
    for (int n = 1; n <= pieces; ++n) {
      const Vec3 next_m = front->at(static_cast<double>(n) / pieces, 0.0, depth_m);
      ways_m_[n] = ways_m_[n - 1] + distance(last_m, next_m);
      last_m = next_m;
    }
    if (ways_m_[pieces] > 0.0) turns_per_s_ = rate_hz(motion, ways_m_[pieces]);
  }
  Place along(double time_s) const noexcept override {
    // [1] Climbs in a turn. More: fewer turns at each height; less: the ends of the object are reached late.
    constexpr double climbs_per_turn = 0.1;
    const double even_turns = turns_per_s_ * time_s;
    return {turns_after(even_turns), half_height_m_ * sine(climbs_per_turn * even_turns)};
  }
  // Turns on the front of equal path length per time: a front need not be round.
  double turns_after(double even_turns) const noexcept {
    const double whole = std::floor(even_turns);
    const double way_m = (even_turns - whole) * ways_m_[pieces];
    const double* next = std::upper_bound(ways_m_ + 1, ways_m_ + pieces, way_m);
    const double piece_m = *next - *(next - 1);
    const double within = piece_m > 0.0 ? (way_m - *(next - 1)) / piece_m : 0.0;
    return whole + (static_cast<double>(next - 1 - ways_m_) + within) / pieces;
  }
  static constexpr int pieces = 128;  // [1] of a turn, measured as straight. More: memory; fewer: the speed is less even
  double half_height_m_;
  double turns_per_s_ = 0.0;
  double ways_m_[pieces + 1] = {};  // from the start of a turn, at the middle's height
};

class RandomMotion final : public Along {
 public:
  RandomMotion(const SimulatedMotion& motion, const Encounter& encounter, double depth_m, double radius_m)
      : Along(motion, encounter, encounter.facing, 0.5 * depth_m, radius_m) {
    Random random(motion.seed);
    // Each wave has an equal share of the mean squared speed.
    const double share_m_per_s = motion.speed_m_per_s.value_or(usual_m_per_s) * std::sqrt(2.0 / (3.0 * waves));
    // Deep enough that the hand leaves the front now and then: a broken level is only felt again from outside.
    const double in_and_out_m = std::min(radius_m, std::max(0.0, depth_m) + 2.0 * encounter.retreat_m);
    const double largest_m[3] = {radius_m, radius_m, in_and_out_m};
    for (int axis = 0; axis < 3; ++axis) {
      double reach_m = 0.0;
      for (Wave& wave : axes_[axis]) {
        wave.frequency_hz = lowest_hz + (highest_hz - lowest_hz) * random.next();
        wave.phase_turns = random.next();
        wave.amplitude_m = share_m_per_s / (2.0 * pi * wave.frequency_hz);
        reach_m += wave.amplitude_m;
      }
      if (reach_m <= largest_m[axis]) continue;
      for (Wave& wave : axes_[axis]) wave.amplitude_m *= largest_m[axis] / reach_m;
    }
  }

 private:
  // Sines along each axis, and their frequencies. More waves: slower; fewer: the motion repeats itself. A person tracks up to
  // some hertz: higher ones shake an arm, a higher lowest one omits slow motion. Any change alters the motion of a seed.
  static constexpr int waves = 12;
  static constexpr double lowest_hz = 0.2;
  static constexpr double highest_hz = 7.5;
  struct Wave {
    double frequency_hz, phase_turns, amplitude_m;
  };

  Place along(double time_s) const noexcept override {
    double x[3] = {};
    for (int axis = 0; axis < 3; ++axis) {
      for (const Wave& wave : axes_[axis]) x[axis] += wave.amplitude_m * sine(wave.frequency_hz * time_s + wave.phase_turns);
    }
    return {x[0], x[1], -x[2]};
  }
  Wave axes_[3][waves];
};

// A motion whose handle swings.
class Tilted final : public SimulatedTarget {
 public:
  Tilted(std::unique_ptr<Target> target, double tilt_rad) : target_(std::move(target)), tilt_turns_(tilt_rad / (2.0 * pi)) {}
  Point at(double time_s) const noexcept override {
    // Frequencies whose ratio repeats late: many orientations are met. Faster: no wrist follows; slower: short runs meet few.
    constexpr double about_x_hz = 0.5, about_z_hz = 0.3125;
    const SineCosine x = sine_cosine(0.5 * tilt_turns_ * sine(about_x_hz * time_s));
    const SineCosine z = sine_cosine(0.5 * tilt_turns_ * sine(about_z_hz * time_s));
    Point point = target_->at(time_s);
    point.turn = Turn{z.cosine, 0.0, 0.0, z.sine} * Turn{x.cosine, x.sine, 0.0, 0.0};
    return point;
  }

 private:
  std::unique_ptr<Target> target_;
  double tilt_turns_;
};

constexpr std::string_view right_form =
    "a simulated hand is sim:press|stroke|circle|helix|random[,speed_m_per_s=…,radius_m=…,depth_m=…,tilt_rad=…,seed=…]";

[[noreturn]] void refuse(const std::string& description, const std::string& what, std::string_view right = right_form) {
  throw LoadError(description + ": " + what + "; " + std::string(right));
}

/// Parses a number of SI units in a range (above, at_most].
double number_of(const std::string& description, std::string_view key, std::string_view text, double above, double at_most,
                 const char* range) {
  double value = 0.0;
  if (detail::read_number(text, value) && value > above && value <= at_most) return value;
  refuse(description, "'" + std::string(text) + "' cannot be used for " + std::string(key), range);
}

}  // namespace

SimulatedMotion simulated_motion(const std::string& description) {
  std::string_view rest = description;
  constexpr std::string_view prefix = "sim:";
  if (!rest.starts_with(prefix)) refuse(description, "does not begin with sim:");
  rest.remove_prefix(prefix.size());
  using Kind = SimulatedMotion::Kind;
  constexpr std::pair<std::string_view, Kind> kinds[] = {{"press", Kind::press},
                                                         {"stroke", Kind::stroke},
                                                         {"circle", Kind::circle},
                                                         {"helix", Kind::helix},
                                                         {"random", Kind::random}};
  SimulatedMotion motion;
  const std::string_view name = detail::next_word(rest);
  const auto* const known =
      std::find_if(std::begin(kinds), std::end(kinds), [&](const auto& kind) { return kind.first == name; });
  while (!rest.empty()) {
    const auto [key, value] = detail::key_and_value(detail::next_word(rest));
    if (key == "speed_m_per_s") {
      motion.speed_m_per_s =
          number_of(description, key, value, 0.0, 2.0, "it is a number of m/s above 0, at most 2, as in 0.1");
    } else if (key == "radius_m") {
      motion.radius_m =
          number_of(description, key, value, 0.0, 0.2, "it is a number of metres above 0, at most 0.2, as in 0.03");
    } else if (key == "depth_m") {
      motion.depth_m =
          number_of(description, key, value, -0.015, 0.15, "it is a number of metres above -0.015, at most 0.15, as in 0.05");
    } else if (key == "tilt_rad") {
      motion.tilt_rad = number_of(description, key, value, 0.0, 3.0, "it is a number of radians above 0, at most 3, as in 0.3");
    } else if (key == "seed") {
      if (!detail::read_number(value, motion.seed) || motion.seed >= (std::uint64_t{1} << 63)) {
        refuse(description, "'" + std::string(value) + "' cannot be used for seed", "it is a whole number from 0 to 2^63 - 1");
      }
    } else {
      refuse(description, "unknown key '" + std::string(key) + "'");
    }
  }
  if (known == std::end(kinds)) refuse(description, "unknown path '" + std::string(name) + "'");
  motion.kind = known->second;
  return motion;
}

namespace {

std::unique_ptr<Target> upright_target(const SimulatedMotion& motion, const Encounter& encounter) {
  const double depth_m = motion.depth_m.value_or(encounter.depth_m);
  const double radius_m = motion.radius_m.value_or(encounter.radius_m);
  switch (motion.kind) {
    case SimulatedMotion::Kind::press: return std::make_unique<Press>(motion, depth_m, encounter);
    case SimulatedMotion::Kind::stroke: return std::make_unique<Stroke>(motion, encounter, depth_m, radius_m);
    case SimulatedMotion::Kind::circle: return std::make_unique<Circle>(motion, encounter, depth_m, radius_m);
    case SimulatedMotion::Kind::helix: return std::make_unique<Helix>(motion, encounter, depth_m);
    case SimulatedMotion::Kind::random: break;
  }
  return std::make_unique<RandomMotion>(motion, encounter, depth_m, radius_m);
}

}  // namespace

std::unique_ptr<Target> simulated_target(const SimulatedMotion& motion, const Encounter& encounter) {
  std::unique_ptr<Target> target = upright_target(motion, encounter);
  if (motion.tilt_rad > 0.0) return std::make_unique<Tilted>(std::move(target), motion.tilt_rad);
  return target;
}

std::unique_ptr<Target> simulated_target(const std::string& description) {
  return simulated_target(simulated_motion(description));
}

}  // namespace palpa
