#include "palpa/study/released_device.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

#include "palpa/data/analytic.h"
#include "palpa/loop/loop.h"
#include "palpa/mode/modes.h"

namespace palpa {
namespace {

constexpr int sub_steps = 100;  // [1] of an advance. More: slower; fewer: backward Euler damps the hum

class PushedMass final : public ReleasedDevice {
 public:
  PushedMass(const DevicePlant& plant, const Vec3& start_m, const Vec3& push_n)
      : plant_(plant),
        position_m_(start_m),
        push_n_(push_n),
        waiting_n_(static_cast<std::size_t>(std::max(0, plant.delay_ticks)) + 1) {
    assert(plant.mass_kg > 0.0);
  }

  std::string name() const override { return plant_.name + " let go"; }
  DeviceLimits limits() const override { return plant_.limits; }
  double duration_s() const noexcept override { return INFINITY; }
  DeviceState read() noexcept override {
    const double step_m = plant_.limits.encoder_step_m;
    const auto seen = [&](double x_m) { return step_m > 0.0 ? std::floor(x_m / step_m + 0.5) * step_m : x_m; };
    return {.position_m = {seen(position_m_.x), seen(position_m_.y), seen(position_m_.z)},
            .velocity_m_per_s = std::nullopt,
            .valid = true,
            .buttons = 0,
            .time_s = time_s_};
  }
  bool write(const Vec3& force_n) noexcept override {
    waiting_n_[next_] = is_finite(force_n) ? shortened(force_n, plant_.limits.max_force_n) : Vec3{};
    return true;
  }
  void advance(double time_step_s) noexcept override {
    next_ = (next_ + 1) % waiting_n_.size();
    const Vec3 rendered_n = waiting_n_[next_];  // the oldest: written `delay_ticks` writes ago
    const Vec3 force_n = push_n_ + rendered_n, from_m = position_m_;
    const double h = time_step_s / sub_steps, inertia = plant_.mass_kg / h, friction_n = plant_.coulomb_friction_n;
    const bool may_stick = friction_n > 0.0 && !(norm(force_n) > friction_n);
    Vec3 position_m = from_m, velocity_m_per_s = velocity_m_per_s_;
    for (int i = 0; i < sub_steps && !(may_stick && velocity_m_per_s == Vec3{}); ++i) {
      Vec3 momentum_n = inertia * velocity_m_per_s + force_n;
      if (friction_n > 0.0) {
        const double length_n = norm(momentum_n);
        momentum_n = length_n > friction_n ? (1.0 - friction_n / length_n) * momentum_n : Vec3{};
      }
      velocity_m_per_s = momentum_n / (inertia + plant_.damping_ns_per_m);
      position_m += h * velocity_m_per_s;
    }
    position_m_ = position_m, velocity_m_per_s_ = velocity_m_per_s;
    work_j_ += dot(rendered_n, position_m_ - from_m);
    time_s_ += time_step_s;
  }
  double work_j() const noexcept override { return work_j_; }

 private:
  DevicePlant plant_;
  Vec3 position_m_, velocity_m_per_s_, push_n_;
  std::vector<Vec3> waiting_n_;  // a ring; `next_` is the next to be written
  std::size_t next_ = 0;
  double time_s_ = 0.0, work_j_ = 0.0;
};

/// Range of an interval of positions.
double swing_m(const std::vector<double>& places_m, std::size_t begin, std::size_t end) {
  const auto [low, high] = std::minmax_element(places_m.begin() + static_cast<std::ptrdiff_t>(begin),
                                               places_m.begin() + static_cast<std::ptrdiff_t>(end));
  return *high - *low;
}

}  // namespace

std::unique_ptr<ReleasedDevice> released_device(const DevicePlant& plant, const Vec3& start_m, const Vec3& push_n) {
  return std::make_unique<PushedMass>(plant, start_m, push_n);
}

bool comes_to_rest(const ReleasedDeviceOptions& options, double stiffness_n_per_m) {
  // Force limits, high enough to be inactive; and the settling time of the device before it is observed for two times `half_s`.
  // Longer: slower; shorter: slow decay counts as humming.
  constexpr double strong_n = 100.0, settled_s = 1.0, half_s = 0.5;
  constexpr double always_at_rest_m = 1e-6;  // a swing this small is rest, without an encoder too
  Scene scene({.stiffness_n_per_m = stiffness_n_per_m, .damping_ns_per_m = options.damping_ns_per_m, .max_force_n = strong_n});
  const FieldRef wall = scene.add("wall", plane_field());
  scene.add("wall", SurfaceAndFriction{.field = wall, .levels = {{.value = 0.0, .strength_n = strong_n}}});
  // The field's value grows into the wall; the device approaches from the other side.
  const Vec3 inwards = normalized(scene.field(wall).field->scalar({}).gradient);
  DevicePlant plant = options.plant;
  plant.limits.max_force_n = strong_n;
  const double rest_m = options.push_n / stiffness_n_per_m + options.start_depth_m;
  const auto device = released_device(plant, rest_m * inwards, options.push_n * inwards);
  Session session(scene, options.uses_encoder ? plant.limits.encoder_step_m : 0.0);
  // The first tick is outside of the wall, so that contact begins before the device rests on it.
  session.tick({.position_m = -rest_m * inwards}, 1.0 / options.rate_hz);
  std::vector<double> places_m;
  run_simulated(session, *device, {.rate_hz = options.rate_hz, .duration_s = settled_s + 2.0 * half_s, .time_ticks = false},
                nullptr,
                [&](const TickFrame& frame, const Session&) { places_m.push_back(dot(frame.result.probe_m, inwards)); });
  const std::size_t last = places_m.size(), half = static_cast<std::size_t>(half_s * options.rate_hz);
  const double before_m = swing_m(places_m, last - 2 * half, last - half), after_m = swing_m(places_m, last - half, last);
  return after_m <= std::max(always_at_rest_m, options.rest_steps * plant.limits.encoder_step_m) || after_m < before_m;
}

double largest_stable_stiffness_n_per_m(const std::function<bool(double)>& is_stable, double low_n_per_m, double high_n_per_m) {
  constexpr double close_enough = 1.01;  // ratio of the final bounds. Less: more runs; more: a coarser result
  if (!is_stable(low_n_per_m)) return 0.0;
  if (is_stable(high_n_per_m)) return high_n_per_m;
  while (high_n_per_m > close_enough * low_n_per_m) {
    const double middle_n_per_m = std::sqrt(low_n_per_m * high_n_per_m);
    (is_stable(middle_n_per_m) ? low_n_per_m : high_n_per_m) = middle_n_per_m;
  }
  return low_n_per_m;
}

}  // namespace palpa
