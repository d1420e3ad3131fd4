#include "palpa/study/movement.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "palpa/loop/loop.h"

namespace palpa {
namespace {

class Path final : public Target {
 public:
  Path(std::function<Vec3(double)> at, double duration_s) : at_(std::move(at)), duration_s_(duration_s) {}
  Point at(double time_s) const noexcept override { return {.position_m = at_(time_s)}; }
  double duration_s() const noexcept override { return duration_s_; }

 private:
  std::function<Vec3(double)> at_;
  double duration_s_;
};

/// Smooth step from 0 to 1 with two continuous derivatives.
double ease(double share) {
  const double s = std::clamp(share, 0.0, 1.0);
  return s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
}

// For every hand here: approach to the front, then rest. Slow at the end, so that no arm breaks through a level.
constexpr double approach_s = 1.6, rest_s = 0.6;
double depth_at(const Encounter& met, double depth_m, double t_s) {
  const double left = 1.0 - ease(t_s / approach_s);
  return depth_m - (depth_m + met.before_m) * left * left;
}

}  // namespace

std::shared_ptr<const Target> path_target(std::function<Vec3(double)> at, double duration_s) {
  return std::make_shared<Path>(std::move(at), duration_s);
}

HandSlide slide_over(const Encounter& met, double turn, double beside_m, double depth_m) {
  constexpr double begin_s = approach_s + rest_s, ramp_s = 0.1, settle_s = 0.05, least_half_m = 0.02;
  const double half_m = std::max(met.radius_m, least_half_m);
  const double to_s = begin_s + ramp_s / 2.0 + 2.0 * half_m / slide_m_per_s;
  const double u = std::cos(2.0 * std::numbers::pi * turn), v = std::sin(2.0 * std::numbers::pi * turn);
  return {.target = path_target(
              [=, front = met.facing](double t_s) {
                const double since_s = std::max(0.0, t_s - begin_s), s = std::min(1.0, since_s / ramp_s);
                const double gone_s = since_s < ramp_s ? ramp_s * s * s * s * (1.0 - 0.5 * s) : since_s - ramp_s / 2.0;
                const double along_m = slide_m_per_s * gone_s - half_m;
                return front->at(u * along_m - v * beside_m, v * along_m + u * beside_m, depth_at(met, depth_m, t_s));
              },
              to_s),
          .from_s = begin_s + ramp_s + settle_s,
          .to_s = to_s};
}

std::shared_ptr<const Target> hold_at(const Encounter& met, double beside_m, double depth_m, const Tremor& tremor,
                                      double duration_s) {
  return path_target(
      [=, front = met.facing](double t_s) {
        const double sway_m = tremor.amplitude_m * ease((t_s - approach_s) / rest_s) *
                              std::sin(2.0 * std::numbers::pi * tremor.frequency_hz * (t_s - approach_s));
        return front->at(beside_m, 0.0, depth_at(met, depth_m, t_s)) + Vec3{0.0, 0.0, sway_m};
      },
      duration_s);
}

FeltRun feel(const Scene& scene, SimulatedDevice& device, double duration_s, SummaryBuilder* summary) {
  Session session(scene, device.limits().encoder_step_m);
  FeltRun run = felt_run(scene);
  run_simulated(session, device, {.duration_s = duration_s, .time_ticks = false}, nullptr,
                [&](const TickFrame& frame, const Session& felt) {
                  add_tick(run, frame, felt);
                  if (summary) summary->add(frame, felt);
                });
  return run;
}

}  // namespace palpa
