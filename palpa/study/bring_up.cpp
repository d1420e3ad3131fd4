#include "palpa/study/bring_up.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>
#include <thread>

#include "palpa/base/printed.h"

namespace palpa {

namespace {

constexpr double step_s = 1e-3;
constexpr double longest_force_n = 1.0;
// Of the device's largest force [1].
constexpr double force_share = 1.0 / 3.0;

// Timeout for the first position of a newly opened device. Longer: a device without position blocks; shorter: slow ones are
// missed.
constexpr double first_state_s = 1.0;
constexpr double stroke_s = 5.0;
// Share [1] of all nonzero position steps that are smaller than the encoder's. More: fast motion counts as encoder; less:
// rounding does.
constexpr double smallest_share = 0.01;
constexpr double longest_lag_s = 0.04;
constexpr double fast_enough_m_per_s = 0.02;  // below, noise counts as motion

constexpr double pulse_n = 0.3, pulse_s = 0.08, quiet_s = 0.3, before_s = 0.05;
// Least motion of a pulse [m]: below, the hand or friction held the handle. More: light pushes are missed; less: noise counts.
constexpr double least_motion_m = 2e-4;
// Least share [1] of the motion along the force. More: an obliquely suspended handle fails; less: wrong axes pass.
constexpr double right_way = 0.7;

constexpr double spring_n_per_m = 60.0, spring_ramp_s = 0.5, swing_s = 6.0;
// Least speed of a released handle. Slower: the hand's tremor counts; faster: the start is lost.
constexpr double release_speed_m_per_s = 0.05;
constexpr double at_rest_m_per_s = 0.004;
constexpr double piece_s = 0.03;  // of the swing, for the balance of energy. Shorter: noise; longer: fewer equations
constexpr std::size_t least_pieces = 6;

struct Sample {
  double time_s = 0.0;
  Vec3 position_m;
  std::optional<Vec3> velocity_m_per_s;
  Vec3 force_n;  // written at that time
};

/// Samples the device once a millisecond. Always ends without a force.
class Rhythm {
 public:
  Rhythm(Device& device, LoopClock& clock, const std::atomic<bool>& stop)
      : device_(device),
        clock_(clock),
        stop_(stop),
        driven_(device),
        most_n_(std::min(longest_force_n, force_share * device.limits().max_force_n)) {}
  ~Rhythm() { device_.write({}); }
  Rhythm(const Rhythm&) = delete;
  Rhythm& operator=(const Rhythm&) = delete;

  /// Samples for a duration, under `force_n(seconds since its start, position)`. Empty: a fault of the device, in `fault`, or
  /// stopped.
  std::vector<Sample> take(double duration_s, const std::function<Vec3(double, const Vec3&)>& force_n) {
    std::vector<Sample> samples;
    const double begin_s = clock_.now_s();
    for (double next_s = begin_s; next_s - begin_s < duration_s; next_s += step_s) {
      clock_.wait_until_s(next_s);
      const DeviceState state = device_.read();
      const bool is_stopped = driven_.has_to_rest() || stop_;
      if (is_stopped || !state.valid || state.fault != nullptr) {
        fault = state.fault != nullptr ? state.fault : is_stopped ? "stopped by the user" : "the device has no valid position";
        device_.write({});
        return {};
      }
      const Vec3 sent_n = shortened(force_n(next_s - begin_s, state.position_m), most_n_);
      device_.write(sent_n);
      samples.push_back({clock_.now_s(), state.position_m, state.velocity_m_per_s, sent_n});
    }
    device_.write({});
    return samples;
  }
  double most_n() const { return most_n_; }
  Device& device() { return device_; }
  LoopClock& clock() { return clock_; }

  std::string fault;

 private:
  Device& device_;
  LoopClock& clock_;
  const std::atomic<bool>& stop_;
  DrivenDevice driven_;
  double most_n_;
};

Vec3 no_force(double, const Vec3&) { return {}; }

/// Velocity in the middle of five samples.
Vec3 velocity_at(const std::vector<Sample>& samples, std::size_t n) {
  const Sample &before = samples[n - 2], &after = samples[n + 2];
  return (after.position_m - before.position_m) / (after.time_s - before.time_s);
}

std::optional<double> smallest_step_m(const std::vector<Sample>& samples) {
  std::vector<double> steps_m;
  for (std::size_t n = 1; n < samples.size(); ++n) {
    const Vec3 step_m = samples[n].position_m - samples[n - 1].position_m;
    for (const double component_m : {step_m.x, step_m.y, step_m.z})
      if (std::abs(component_m) > 1e-10) steps_m.push_back(std::abs(component_m));
  }
  if (steps_m.size() < 100) return std::nullopt;
  const auto at = steps_m.begin() + static_cast<std::ptrdiff_t>(smallest_share * static_cast<double>(steps_m.size()));
  std::nth_element(steps_m.begin(), at, steps_m.end());
  return *at;
}

/// Lag of the device's velocity of best agreement with the change of its positions.
std::optional<double> velocity_lag_s(const std::vector<Sample>& samples) {
  if (samples.empty() || !samples.front().velocity_m_per_s) return std::nullopt;
  const auto lags = static_cast<std::size_t>(longest_lag_s / step_s);
  std::size_t best = 0;
  double least = 0.0, moved = 0.0;
  for (std::size_t lag = 0; lag <= lags; ++lag) {
    double sum = 0.0;
    for (std::size_t n = lags + 2; n + 2 < samples.size(); ++n) {
      const Vec3 change = velocity_at(samples, n - lag);
      sum += norm_squared(samples[n].velocity_m_per_s.value_or(Vec3{}) - change);
      if (lag == 0) moved += norm_squared(change);
    }
    if (lag == 0 || sum < least) {
      least = sum;
      best = lag;
    }
  }
  const bool has_moved = moved > fast_enough_m_per_s * fast_enough_m_per_s * static_cast<double>(samples.size());
  if (!has_moved || least > 0.5 * moved) return std::nullopt;
  return static_cast<double>(best) * step_s;
}

/// First time at which the path along the axis has this length [s]; linear between samples.
double time_at_s(const std::vector<double>& way_m, const std::vector<Sample>& samples, double length_m) {
  for (std::size_t n = 1; n < way_m.size(); ++n) {
    if (way_m[n] < length_m) continue;
    const double share = way_m[n] > way_m[n - 1] ? (length_m - way_m[n - 1]) / (way_m[n] - way_m[n - 1]) : 1.0;
    return samples[n - 1].time_s + share * (samples[n].time_s - samples[n - 1].time_s);
  }
  return samples.back().time_s;
}

struct Pulse {
  bool is_felt = false, goes_right = false;
  double delay_s = 0.0;
};

/// Applies a pulse along an axis; none: the device has a fault.
std::optional<Pulse> pulse(Rhythm& rhythm, const Vec3& axis) {
  const double whole_s = quiet_s + pulse_s;
  const auto samples = rhythm.take(whole_s, [&](double time_s, const Vec3&) {
    return time_s < quiet_s ? Vec3{} : std::min(pulse_n, rhythm.most_n()) * axis;
  });
  if (samples.empty()) return std::nullopt;
  const auto before = static_cast<std::size_t>(before_s / step_s), begin = static_cast<std::size_t>(quiet_s / step_s);
  const Vec3 drift = (samples[begin].position_m - samples[begin - before].position_m) /
                     (samples[begin].time_s - samples[begin - before].time_s);
  std::vector<double> way_m(samples.size() - begin);
  const std::vector<Sample> pushed(samples.begin() + static_cast<std::ptrdiff_t>(begin), samples.end());
  Vec3 moved_m;
  for (std::size_t n = 0; n < pushed.size(); ++n) {
    moved_m = pushed[n].position_m - pushed.front().position_m - (pushed[n].time_s - pushed.front().time_s) * drift;
    way_m[n] = dot(moved_m, axis);
  }
  Pulse out;
  out.is_felt = norm(moved_m) > least_motion_m;
  out.goes_right = out.is_felt && dot(moved_m, axis) > right_way * norm(moved_m);
  if (out.goes_right) {
    // x = a (t - d)²/2: four times the path takes twice the time.
    const double eighth_m = way_m.back() / 8.0;
    const double first_s = time_at_s(way_m, pushed, eighth_m), second_s = time_at_s(way_m, pushed, 4.0 * eighth_m);
    out.delay_s = std::max(0.0, 2.0 * first_s - second_s - pushed.front().time_s);
  }
  return out;
}

struct Mechanics {
  double mass_kg = 0.0, damping_ns_per_m = 0.0, friction_n = 0.0;
};

/// Solves the three normal equations by Cramer's rule.
std::optional<Mechanics> solved(const std::array<std::array<double, 3>, 3>& a, const std::array<double, 3>& b) {
  const auto determinant = [](const std::array<std::array<double, 3>, 3>& m) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  };
  const double whole = determinant(a);
  if (!(std::abs(whole) > 1e-12 * a[0][0] * a[1][1] * a[2][2])) return std::nullopt;
  std::array<double, 3> x{};
  for (std::size_t column = 0; column < 3; ++column) {
    auto changed = a;
    for (std::size_t row = 0; row < 3; ++row) changed[row][column] = b[row];
    x[column] = determinant(changed) / whole;
  }
  return Mechanics{x[0], x[1], x[2]};
}

/// Mass, damping and friction of a handle that swings on a spring.
std::optional<Mechanics> mechanics_of(const std::vector<Sample>& samples, double delay_s) {
  const auto delay = static_cast<std::size_t>(std::lround(delay_s / step_s));
  std::size_t n = delay + 2;
  while (n + 2 < samples.size() && norm(velocity_at(samples, n)) < release_speed_m_per_s) ++n;
  std::array<std::array<double, 3>, 3> a{};
  std::array<double, 3> b{};
  std::size_t pieces = 0;
  const auto length = static_cast<std::size_t>(piece_s / step_s);
  for (double fastest = release_speed_m_per_s; n + length + 2 < samples.size() && fastest > at_rest_m_per_s; n += length) {
    std::array<double, 3> row{};
    double work_j = 0.0;
    fastest = 0.0;
    for (std::size_t k = n; k < n + length; ++k) {
      const Vec3 velocity = 0.5 * (velocity_at(samples, k) + velocity_at(samples, k + 1));
      const double passed_s = samples[k + 1].time_s - samples[k].time_s, speed = norm(velocity);
      row[1] += passed_s * speed * speed;
      row[2] += passed_s * speed;
      work_j += passed_s * dot(samples[k - delay].force_n, velocity);
      fastest = std::max(fastest, speed);
    }
    row[0] = 0.5 * (norm_squared(velocity_at(samples, n + length)) - norm_squared(velocity_at(samples, n)));
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) a[i][j] += row[i] * row[j];
      b[i] += row[i] * work_j;
    }
    ++pieces;
  }
  if (pieces < least_pieces) return std::nullopt;
  const auto found = solved(a, b);
  if (!found || !(found->mass_kg > 0.0)) return std::nullopt;
  return Mechanics{found->mass_kg, std::max(0.0, found->damping_ns_per_m), std::max(0.0, found->friction_n)};
}

// ---- the steps ----

bool find_place(Rhythm& rhythm, DeviceCalibration& result) {
  const double end_s = rhythm.clock().now_s() + first_state_s;
  DeviceState state;
  do {
    rhythm.clock().wait_until_s(rhythm.clock().now_s() + step_s);
    state = rhythm.device().read();
    rhythm.device().write({});
  } while (!(state.valid && state.fault == nullptr) && rhythm.clock().now_s() < end_s);
  result.has_valid_position = state.valid && state.fault == nullptr;
  result.findings.push_back(result.has_valid_position
                                ? "The position is valid."
                                : std::string("No measurement: ") +
                                      (state.fault != nullptr ? state.fault : "the device has no valid position") + ".");
  if (result.has_valid_position && rhythm.device().limits().senses_turn)
    result.findings.push_back(state.turn && is_unit(*state.turn, 1e-3) ? "The orientation is valid."
                                                                       : "The orientation of the handle is not valid.");
  return result.has_valid_position;
}

bool measure_positions(Rhythm& rhythm, DeviceCalibration& result) {
  const auto samples = rhythm.take(stroke_s, no_force);
  if (samples.empty()) return false;
  result.encoder_step_m = smallest_step_m(samples);
  result.velocity_lag_s = velocity_lag_s(samples);
  result.findings.push_back(result.encoder_step_m ? detail::text("Encoder step: %.3g um.", 1e6 * *result.encoder_step_m)
                                                  : "Too little motion: the encoder step is unknown.");
  if (!samples.front().velocity_m_per_s)
    result.findings.push_back("The device has no velocity; it is derived from positions.");
  else if (result.velocity_lag_s)
    result.findings.push_back(detail::text("The velocity lags the positions by %.0f ms.", 1e3 * *result.velocity_lag_s));
  else
    result.findings.push_back("The velocity disagrees with the positions, or there was too little motion.");
  return true;
}

bool measure_pulses(Rhythm& rhythm, DeviceCalibration& result) {
  constexpr std::pair<const char*, Vec3> axes[] = {{"to the right", {1, 0, 0}}, {"up", {0, 1, 0}}, {"towards you", {0, 0, 1}}};
  std::vector<double> delays_s;
  result.pushes_rightly = true;
  for (const auto& [words, axis] : axes) {
    const auto made = pulse(rhythm, axis);
    if (!made) return false;
    if (made->goes_right) {
      delays_s.push_back(made->delay_s);
      continue;
    }
    result.pushes_rightly = false;
    result.findings.push_back(std::string("A push ") + words +
                              (made->is_felt
                                   ? " moves the handle another way: do not use the device before that is fixed."
                                   : " does not move the handle: it was held too firmly, or its friction is larger."));
  }
  if (result.pushes_rightly) result.findings.push_back("Forces to the right, up and towards you have the right directions.");
  if (!delays_s.empty()) {
    std::nth_element(delays_s.begin(), delays_s.begin() + static_cast<std::ptrdiff_t>(delays_s.size() / 2), delays_s.end());
    result.delay_s = delays_s[delays_s.size() / 2];
    result.findings.push_back(detail::text("Latency from force to motion: %.1f ms.", 1e3 * *result.delay_s));
  }
  return true;
}

bool measure_swing(Rhythm& rhythm, const Vec3& middle_m, DeviceCalibration& result) {
  const auto samples = rhythm.take(swing_s, [&](double time_s, const Vec3& place_m) {
    return std::min(1.0, time_s / spring_ramp_s) * spring_n_per_m * (middle_m - place_m);
  });
  if (samples.empty()) return false;
  const auto found = mechanics_of(samples, result.delay_s.value_or(0.0));
  if (!found) {
    result.findings.push_back("The handle did not swing long enough to estimate its mass, damping and friction.");
    return true;
  }
  result.mass_kg = found->mass_kg;
  result.damping_ns_per_m = found->damping_ns_per_m;
  result.friction_n = found->friction_n;
  result.findings.push_back(detail::text("Handle: mass %.3g kg, damping %.3g N s/m", found->mass_kg, found->damping_ns_per_m) +
                            detail::text(", friction %.2g N.", found->friction_n));
  return true;
}

class WallClock final : public LoopClock {
 public:
  double now_s() noexcept override { return std::chrono::duration<double>(Clock::now() - begin_).count(); }
  void wait_until_s(double time_s) noexcept override {
    std::this_thread::sleep_until(begin_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(time_s)));
  }

 private:
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin_ = Clock::now();
};

}  // namespace

DeviceCalibration bring_up(Device& device, LoopClock& clock, const AskPerson& ask, const std::atomic<bool>& stop) {
  DeviceCalibration result;
  Rhythm rhythm(device, clock, stop);
  const auto broken = [&] {
    result.findings.push_back("Setup ended: " + rhythm.fault + ".");
    return result;
  };
  if (!find_place(rhythm, result)) return result;
  if (ask("Move the handle slowly to and fro, in all directions, for 5 seconds.") && !measure_positions(rhythm, result))
    return broken();
  if (!device.limits().has_motors) return result;
  if (ask("Hold the handle loosely in the middle of its reach. It will push three times, very lightly, with 0.3 N.") &&
      !measure_pulses(rhythm, result))
    return broken();
  if (!ask("Put the handle into the middle of its reach.")) return result;
  const Vec3 middle_m = device.read().position_m;
  if (ask("Pull the handle 3 cm to the right and hold it there. A spring will pull it back with up to 1 N: let go of it then, "
          "hands off.") &&
      !measure_swing(rhythm, middle_m, result))
    return broken();
  return result;
}

std::unique_ptr<LoopClock> wall_clock() { return std::make_unique<WallClock>(); }

}  // namespace palpa
