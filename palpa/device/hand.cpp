#include "palpa/device/hand.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <string_view>
#include <utility>

namespace palpa {

namespace {

// Steps of the simulated mechanics in a tick: at least the first, none longer than the second. More or shorter: slower; fewer
// or longer: a stiff hand is integrated less precisely.
constexpr int least_sub_steps = 20;
constexpr double longest_sub_step_s = 50e-6;

// [N·m] that an ideal device drives.
constexpr double ideal_torque_nm = 1.0;

// Delay of a force by a number of advances.
class Delay {
 public:
  explicit Delay(int ticks) : ticks_(std::clamp(ticks, 0, DevicePlant::longest_delay_ticks)) {}
  /// Stores the newest force and returns the delayed one.
  Vec3 pass(const Vec3& force_n) noexcept {
    if (ticks_ == 0) return force_n;
    next_ = (next_ + 1) % ticks_;
    return std::exchange(waiting_n_[static_cast<std::size_t>(next_)], force_n);
  }

 private:
  int ticks_;
  int next_ = 0;
  std::array<Vec3, DevicePlant::longest_delay_ticks> waiting_n_{};
};

double rounded(double value_m, double step_m) noexcept {
  return step_m > 0.0 ? std::floor(value_m / step_m + 0.5) * step_m : value_m;
}

class Hand : public SimulatedDevice {
 public:
  Hand(std::shared_ptr<const Target> target, DevicePlant plant)
      : target_(std::move(target)), plant_(std::move(plant)), wanted_(target_->at(0.0)) {
    if (!wanted_.turn) return;
    plant_.limits.senses_turn = true;
    if (plant_.name.empty()) plant_.limits.max_torque_nm = ideal_torque_nm;
  }

  DeviceLimits limits() const final { return plant_.limits; }
  double duration_s() const noexcept final { return target_->duration_s(); }
  DeviceState read() noexcept final {
    const Vec3 x = where_m();
    const double step_m = plant_.limits.encoder_step_m;
    return {.position_m = {rounded(x.x, step_m), rounded(x.y, step_m), rounded(x.z, step_m)},
            .velocity_m_per_s = std::nullopt,
            .valid = wanted_.valid,
            .buttons = wanted_.buttons,
            .time_s = time_s_,
            .fault = nullptr,
            .turn = wanted_.turn};
  }

 protected:
  virtual Vec3 where_m() const noexcept = 0;

  std::string name_of_kind(const char* kind) const {
    return std::string(kind) + " hand" + (plant_.name.empty() ? "" : " in " + plant_.name);
  }
  const DevicePlant& plant() const noexcept { return plant_; }
  const Target::Point& wanted() const noexcept { return wanted_; }
  void pass_time(double time_step_s) noexcept {
    // Kahan summation: after any number of steps the time equals that of a recording's row, to rounding.
    const double step_s = time_step_s - excess_s_;
    const double now_s = time_s_ + step_s;
    excess_s_ = (now_s - time_s_) - step_s;
    time_s_ = now_s;
    wanted_ = target_->at(time_s_);
  }

 private:
  std::shared_ptr<const Target> target_;
  DevicePlant plant_;
  double time_s_ = 0.0;
  double excess_s_ = 0.0;  // of the time, over the sum of its steps
  Target::Point wanted_;
};

class RigidHand final : public Hand {
 public:
  using Hand::Hand;
  std::string name() const override { return name_of_kind("rigid"); }
  bool write(const Vec3&) noexcept override { return true; }
  void advance(double time_step_s) noexcept override { pass_time(time_step_s); }

 private:
  Vec3 where_m() const noexcept override { return wanted().position_m; }
};

class ArmHand final : public Hand {
 public:
  ArmHand(std::shared_ptr<const Target> target, const Arm& arm, const DevicePlant& plant)
      : Hand(std::move(target), plant),
        mass_kg_(arm.mass_kg + plant.mass_kg),
        damping_ns_per_m_(arm.damping_ns_per_m + plant.damping_ns_per_m),
        stiffness_n_per_m_(arm.stiffness_n_per_m),
        delay_(plant.delay_ticks),
        position_m_(wanted().position_m) {}

  std::string name() const override { return name_of_kind("simulated"); }
  bool write(const Vec3& force_n) noexcept override {
    force_n_ = is_finite(force_n) ? shortened(force_n, plant().limits.max_force_n) : Vec3{};
    return true;
  }
  void advance(double time_step_s) noexcept override {
    const Target::Point before = wanted();
    pass_time(time_step_s);
    const Vec3 force_n = delay_.pass(force_n_);
    if (!before.valid || !wanted().valid) {
      position_m_ = wanted().position_m;
      velocity_m_per_s_ = {};
      return;
    }
    const int steps = std::max(least_sub_steps, static_cast<int>(std::ceil(time_step_s / longest_sub_step_s)));
    const double h = time_step_s / steps;
    const Vec3 target_step_m = (1.0 / steps) * (wanted().position_m - before.position_m);
    for (int i = 1; i <= steps; ++i) step(before.position_m + static_cast<double>(i) * target_step_m, force_n, h);
  }

 private:
  Vec3 where_m() const noexcept override { return position_m_; }

  // Backward Euler: (m/h + b + K h) v⁺ = m v/h + force + K (target − x) − friction, with the friction c along v⁺, or up to c at
  // v⁺ = 0.
  void step(const Vec3& target_m, const Vec3& force_n, double h) noexcept {
    Vec3 push_n = (mass_kg_ / h) * velocity_m_per_s_ + force_n + stiffness_n_per_m_ * (target_m - position_m_);
    if (const double friction_n = plant().coulomb_friction_n; friction_n > 0.0) {
      const double length_n = norm(push_n);
      push_n = length_n > friction_n ? (1.0 - friction_n / length_n) * push_n : Vec3{};
    }
    velocity_m_per_s_ = push_n / (mass_kg_ / h + damping_ns_per_m_ + stiffness_n_per_m_ * h);
    position_m_ += h * velocity_m_per_s_;
  }

  double mass_kg_;
  double damping_ns_per_m_;
  double stiffness_n_per_m_;
  Delay delay_;
  Vec3 position_m_;
  Vec3 velocity_m_per_s_;
  Vec3 force_n_;
};

class Displaced final : public Target {
 public:
  Displaced(std::shared_ptr<const Target> target, const Vec3& offset_m, double scale)
      : target_(std::move(target)), offset_m_(offset_m), scale_(scale) {}
  Point at(double time_s) const noexcept override {
    Point point = target_->at(time_s);
    point.position_m = scale_ * point.position_m + offset_m_;
    return point;
  }
  double duration_s() const noexcept override { return target_->duration_s(); }

 private:
  std::shared_ptr<const Target> target_;
  Vec3 offset_m_;
  double scale_;
};

}  // namespace

std::unique_ptr<Target> displaced(std::shared_ptr<const Target> target, const Vec3& offset_m, double scale) {
  assert(target && scale > 0.0);
  return std::make_unique<Displaced>(std::move(target), offset_m, scale);
}

std::unique_ptr<SimulatedDevice> hand_device(std::shared_ptr<const Target> target, Hold hold, const DevicePlant& plant) {
  assert(target);
  if (hold == Hold::rigid) return std::make_unique<RigidHand>(std::move(target), plant);
  return std::make_unique<ArmHand>(std::move(target), hold == Hold::relaxed ? relaxed_arm : firm_arm, plant);
}

std::unique_ptr<SimulatedDevice> open_hand(const std::string& description, std::optional<Hold> hold,
                                           const RecordingOptions& options, const DevicePlant& plant) {
  if (description.starts_with("sim:")) return hand_device(simulated_target(description), hold.value_or(Hold::relaxed), plant);
  return hand_device(recorded_target(description, options), hold.value_or(Hold::rigid), plant);
}

}  // namespace palpa
