#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include "palpa/core/load_error.h"
#include "palpa/device/hand.h"

namespace palpa {

namespace {

constexpr double pi = 3.141592653589793;
constexpr double front_m = 0.075;  // half of what a fitted object spans
constexpr Vec3 start_m{0.0, 0.0, 0.09};

// Sine and cosine of turns by their own series: the C library's may round differently on another
// machine, and a path must not.
struct SineCosine {
  double sine;
  double cosine;
};
SineCosine sine_cosine(double turns) noexcept {
  const double in_turn = turns - std::floor(turns);
  const double quarter = std::floor(4.0 * in_turn + 0.5);
  const double x = 2.0 * pi * (in_turn - 0.25 * quarter);  // |x| <= pi/4
  const double xx = x * x;
  double sine = 0.0;
  double cosine = 0.0;
  for (int n = 17; n >= 3; n -= 2) sine = (1.0 + sine) * (-xx / ((n - 1) * n));
  for (int n = 16; n >= 2; n -= 2) cosine = (1.0 + cosine) * (-xx / ((n - 1) * n));
  sine = x * (1.0 + sine);
  cosine = 1.0 + cosine;
  switch (static_cast<int>(quarter) & 3) {
    case 0: return {sine, cosine};
    case 1: return {cosine, -sine};
    case 2: return {-sine, -cosine};
    default: return {-cosine, sine};
  }
}
double sine(double turns) noexcept { return sine_cosine(turns).sine; }

// 0 before 0, 1 after 1, with two continuous derivatives; its largest slope is 1.875.
double smooth_step(double t) noexcept {
  const double u = std::clamp(t, 0.0, 1.0);
  return u * u * u * (10.0 + u * (6.0 * u - 15.0));
}
constexpr double smooth_step_slope = 1.875;

// SplitMix64 (Steele, Lea, Flood 2014): the standard library's generators leave distributions open.
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

struct PathOptions {
  double speed_m_per_s = 0.1;
  double radius_m = 0.03;
  double depth_m = 0.02;
  std::uint64_t seed = default_hand_seed;
};

class SimulatedTarget : public Target {
 public:
  double duration_s() const noexcept final { return std::numeric_limits<double>::infinity(); }
};

class Press final : public SimulatedTarget {
 public:
  explicit Press(const PathOptions& options)
      : stroke_m_(start_m.z - front_m + options.depth_m), presses_per_s_(options.speed_m_per_s / (pi * stroke_m_)) {}
  Point at(double time_s) const noexcept override {
    const double in = 0.5 * (1.0 - sine_cosine(presses_per_s_ * time_s).cosine);
    return {.position_m = start_m - Vec3{0.0, 0.0, stroke_m_ * in}};
  }

 private:
  double stroke_m_;
  double presses_per_s_;
};

// A path that never ends and need not begin outside or at rest: the hand moves over to it smoothly.
class Joined : public SimulatedTarget {
 public:
  Point at(double time_s) const noexcept final {
    return {.position_m = start_m + smooth_step(time_s / joining_s_) * (along(time_s) - start_m)};
  }

 protected:
  /// \param speed_m_per_s  of the way over, which is about `way_m` long
  Joined(double way_m, double speed_m_per_s) : joining_s_(std::max(0.5, smooth_step_slope * way_m / speed_m_per_s)) {}
  virtual Vec3 along(double time_s) const noexcept = 0;

 private:
  double joining_s_;
};

// A dome of radius front − depth around the middle: over its edge it goes on flat.
Vec3 on_dome(double x_m, double y_m, double radius_m) noexcept {
  return {x_m, y_m, std::sqrt(std::max(0.0, radius_m * radius_m - x_m * x_m - y_m * y_m))};
}

class Stroke final : public Joined {
 public:
  explicit Stroke(const PathOptions& options)
      : Joined(start_m.z - front_m + options.depth_m, options.speed_m_per_s),
        radius_m_(options.radius_m),
        dome_m_(std::max(0.0, front_m - options.depth_m)),
        strokes_per_s_(options.speed_m_per_s / (2.0 * pi * options.radius_m)) {}

 private:
  Vec3 along(double time_s) const noexcept override {
    const double turns = strokes_per_s_ * time_s;
    return on_dome(radius_m_ * sine(turns), radius_m_ * sine(0.375 * turns), dome_m_);
  }
  double radius_m_, dome_m_, strokes_per_s_;
};

class Circle final : public Joined {
 public:
  explicit Circle(const PathOptions& options)
      : Joined(start_m.z - front_m + options.depth_m + options.radius_m, options.speed_m_per_s),
        radius_m_(options.radius_m),
        dome_m_(std::max(0.0, front_m - options.depth_m)),
        turns_per_s_(options.speed_m_per_s / (2.0 * pi * options.radius_m)) {}

 private:
  Vec3 along(double time_s) const noexcept override {
    const SineCosine angle = sine_cosine(turns_per_s_ * time_s);
    return on_dome(radius_m_ * angle.cosine, radius_m_ * angle.sine, dome_m_);
  }
  double radius_m_, dome_m_, turns_per_s_;
};

class Helix final : public Joined {
 public:
  explicit Helix(const PathOptions& options)
      : Joined(start_m.z, options.speed_m_per_s),
        radius_m_(std::max(0.0, options.radius_m - options.depth_m)),
        turns_per_s_(options.speed_m_per_s / (2.0 * pi * options.radius_m)) {}

 private:
  Vec3 along(double time_s) const noexcept override {
    constexpr double half_height_m = 0.05;
    constexpr double climbs_per_turn = 0.1;
    const double turns = turns_per_s_ * time_s;
    const SineCosine angle = sine_cosine(turns);
    return {radius_m_ * angle.sine, half_height_m * sine(climbs_per_turn * turns), radius_m_ * angle.cosine};
  }
  double radius_m_, turns_per_s_;
};

class RandomMotion final : public Joined {
 public:
  explicit RandomMotion(const PathOptions& options)
      : Joined(start_m.z - front_m + options.depth_m + options.radius_m, options.speed_m_per_s),
        middle_z_m_(front_m - options.depth_m) {
    Random random(options.seed);
    // Every wave has the same share of the mean squared speed.
    const double share_m_per_s = options.speed_m_per_s * std::sqrt(2.0 / (3.0 * waves));
    for (Wave(&axis)[waves] : axes_) {
      double reach_m = 0.0;
      for (Wave& wave : axis) {
        wave.frequency_hz = lowest_hz + (highest_hz - lowest_hz) * random.next();
        wave.phase_turns = random.next();
        wave.amplitude_m = share_m_per_s / (2.0 * pi * wave.frequency_hz);
        reach_m += wave.amplitude_m;
      }
      if (reach_m <= options.radius_m) continue;
      for (Wave& wave : axis) wave.amplitude_m *= options.radius_m / reach_m;
    }
  }

 private:
  static constexpr int waves = 12;
  static constexpr double lowest_hz = 0.2;
  static constexpr double highest_hz = 7.5;
  struct Wave {
    double frequency_hz, phase_turns, amplitude_m;
  };

  Vec3 along(double time_s) const noexcept override {
    double x[3] = {0.0, 0.0, middle_z_m_};
    for (int axis = 0; axis < 3; ++axis) {
      for (const Wave& wave : axes_[axis]) x[axis] += wave.amplitude_m * sine(wave.frequency_hz * time_s + wave.phase_turns);
    }
    return {x[0], x[1], x[2]};
  }
  double middle_z_m_;
  Wave axes_[3][waves];
};

constexpr std::string_view right_form =
    "a simulated hand is sim:press|stroke|circle|helix|random[,speed_m_per_s=…,radius_m=…,depth_m=…,seed=…]";

[[noreturn]] void refuse(const std::string& description, const std::string& what, std::string_view right = right_form) {
  throw LoadError(description + ": " + what + "; " + std::string(right));
}

template <class Number>
bool read_number(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

void set_length(const std::string& description, std::string_view key, std::string_view text, double above, double at_most,
                double& value) {
  if (read_number(text, value) && value > above && value <= at_most) return;
  refuse(description, "'" + std::string(text) + "' cannot be used for " + std::string(key),
         "it lies above " + std::to_string(above) + " and is at most " + std::to_string(at_most));
}

}  // namespace

std::unique_ptr<Target> simulated_target(const std::string& description) {
  std::string_view rest = description;
  constexpr std::string_view prefix = "sim:";
  if (!rest.starts_with(prefix)) refuse(description, "does not begin with sim:");
  rest.remove_prefix(prefix.size());
  const auto next = [&rest] {
    const std::size_t end = std::min(rest.find(','), rest.size());
    const std::string_view word = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    return word;
  };
  const std::string_view path = next();
  PathOptions options;
  if (path == "helix") options.radius_m = front_m;
  while (!rest.empty()) {
    const std::string_view word = next();
    const std::size_t equals = std::min(word.find('='), word.size());
    const std::string_view key = word.substr(0, equals);
    const std::string_view value = word.substr(std::min(equals + 1, word.size()));
    if (key == "speed_m_per_s") {
      set_length(description, key, value, 0.0, 2.0, options.speed_m_per_s);
    } else if (key == "radius_m") {
      set_length(description, key, value, 0.0, 0.2, options.radius_m);
    } else if (key == "depth_m") {
      set_length(description, key, value, -0.015, 0.15, options.depth_m);
    } else if (key == "seed") {
      if (!read_number(value, options.seed) || options.seed >= (std::uint64_t{1} << 63)) {
        refuse(description, "'" + std::string(value) + "' cannot be used for seed", "it is a whole number from 0 to 2^63 - 1");
      }
    } else {
      refuse(description, "unknown key '" + std::string(key) + "'");
    }
  }
  if (path == "press") return std::make_unique<Press>(options);
  if (path == "stroke") return std::make_unique<Stroke>(options);
  if (path == "circle") return std::make_unique<Circle>(options);
  if (path == "helix") return std::make_unique<Helix>(options);
  if (path == "random") return std::make_unique<RandomMotion>(options);
  refuse(description, "unknown path '" + std::string(path) + "'");
}

}  // namespace palpa
