#include "tests/device/closed_loop.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "palpa/solver/damper.h"

namespace palpa::test {
namespace {

constexpr double dt = 1e-3;

double rounded(double value_m, double step_m) { return step_m > 0.0 ? std::floor(value_m / step_m + 0.5) * step_m : value_m; }

// The mean square from 20 to 500 Hz of a second of samples at 1 kHz.
double noise(const std::vector<double>& values) {
  double power = 0.0;
  const auto n = static_cast<double>(values.size());
  for (int hz = 20; hz <= 500; ++hz) {
    double re = 0.0, im = 0.0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double turn = 2.0 * std::numbers::pi * hz * static_cast<double>(i) * dt;
      re += values[i] * std::cos(turn);
      im += values[i] * std::sin(turn);
    }
    power += (hz < 500 ? 2.0 : 1.0) * (re * re + im * im) / (n * n);
  }
  return std::sqrt(power);
}

}  // namespace

LoopFelt felt_in(const ClosedLoop& loop, double duration_s) {
  constexpr int sub_steps = 20;
  constexpr double h = dt / sub_steps;
  const double k = loop.stiffness_n_per_m, q = loop.plant.limits.encoder_step_m;
  const double mass_kg = loop.arm.mass_kg + loop.plant.mass_kg;
  const double resisting = loop.arm.damping_ns_per_m + loop.plant.damping_ns_per_m;
  const double friction_n = loop.friction ? loop.plant.coulomb_friction_n : 0.0;
  Damper damper(loop.damping_ns_per_m, loop.told ? q : 0.0);

  Vec3 position_m{}, velocity = -loop.speed_m_per_s * loop.normal, late_n{};
  const Vec3 target_m{};
  const int ticks = static_cast<int>(duration_s / dt);
  std::vector<double> last_n;
  double nearest_m = 1e9, farthest_m = -1e9;
  for (int i = 0; i < ticks; ++i) {
    // The plane lies anywhere between two steps of the encoder.
    const Vec3 at_m = position_m + 0.3 * q * loop.normal;
    const Vec3 read_m{rounded(at_m.x, q), rounded(at_m.y, q), rounded(at_m.z, q)};
    const Vec3 stretch_m = std::max(0.0, -dot(read_m, loop.normal)) * loop.normal;
    const Vec3 relative = damper.relative_velocity({stretch_m, {}}, {}, dt, k).way_m;
    const Vec3 command_n = shortened(k * stretch_m + loop.damping_ns_per_m * relative, loop.plant.limits.max_force_n);
    const Vec3 acting_n = std::exchange(late_n, command_n);
    if (i >= ticks - 1000) {
      last_n.push_back(dot(command_n, loop.normal));
      nearest_m = std::min(nearest_m, dot(position_m, loop.normal));
      farthest_m = std::max(farthest_m, dot(position_m, loop.normal));
    }
    for (int j = 0; j < sub_steps; ++j) {
      Vec3 push_n = (mass_kg / h) * velocity + acting_n - loop.push_n * loop.normal +
                    loop.arm.stiffness_n_per_m * (target_m - position_m);
      const double length_n = norm(push_n);
      push_n = length_n > friction_n ? (1.0 - friction_n / length_n) * push_n : Vec3{};
      const Vec3 next = push_n / (mass_kg / h + resisting + loop.arm.stiffness_n_per_m * h);
      position_m += 0.5 * h * (velocity + next);
      velocity = next;
    }
  }
  return {.swing_m = farthest_m - nearest_m, .noise_n = noise(last_n)};
}

double largest_stable_stiffness(ClosedLoop loop) {
  const std::array normals{Vec3{0, 0, 1}, normalized({1, 1, 1}), normalized({1, 2, 5})};
  double largest = 0.0;
  for (double k = 50.0; k <= 2000.0; k += 25.0) {
    loop.stiffness_n_per_m = k;
    for (const Vec3& normal : normals) {
      for (const double speed_m_per_s : {0.05, 0.2}) {
        loop.normal = normal;
        loop.speed_m_per_s = speed_m_per_s;
        if (felt_in(loop).swing_m > 12.0 * loop.plant.limits.encoder_step_m) return largest;
      }
    }
    largest = k;
  }
  return largest;
}

}  // namespace palpa::test
