// Feel a head in real time with a custom device, and change the scene meanwhile.
//
// The device simulates a motion in ten lines, in place of a driver: it strokes the forehead for two seconds. After a second the
// skin becomes stronger. The guard ramps the force up, and changes of the scene cause no jump.
#include <palpa/loop/loop.h>
#include <palpa/palpa.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>

namespace {

class MyDevice final : public palpa::Device {
 public:
  explicit MyDevice(const palpa::Similarity& map)
      : outside_m_(map.to_hand({0, -0.14, 0.05})), inwards_(map.direction_to_hand({0, 1, 0})) {}
  std::string name() const override { return "my device"; }
  palpa::DeviceLimits limits() const override { return {.max_force_n = 3, .max_stiffness_n_per_m = 600}; }
  palpa::DeviceState read() noexcept override {
    const double time_s = std::chrono::duration<double>(Clock::now() - begin_).count();
    return {.position_m = outside_m_ + (0.02 - 0.02 * std::cos(6.0 * time_s)) * inwards_, .valid = true, .time_s = time_s};
  }
  bool write(const palpa::Vec3&) noexcept override { return true; }  // send the force to the motors here

 private:
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin_ = Clock::now();
  palpa::Vec3 outside_m_, inwards_;
};

}  // namespace

int main() {
  palpa::Scene scene({.stiffness_n_per_m = 400});
  const palpa::FieldRef head = scene.add("head", palpa::head_phantom());
  scene.add("skin", palpa::SurfaceAndFriction{.field = head, .levels = {{.value = -300, .strength_n = 1.0}}});

  MyDevice device(scene.hand_to_world());
  palpa::LiveScene live(scene, device.limits());
  palpa::LiveLoop loop(live, device, {.duration_s = 2.0, .guard = palpa::guard_options_for(device.limits(), 3.0)});

  const std::atomic<bool> never{false};
  double strongest_n = 0.0, largest_step_n = 0.0;
  std::thread haptic([&] {
    const palpa::RealTimeThread real_time;  // if the system permits
    palpa::Vec3 last_n;
    loop.run(never, [&](const palpa::TickFrame& frame, const palpa::Session&) {
      strongest_n = std::max(strongest_n, norm(frame.command.force_n));
      largest_step_n = std::max(largest_step_n, norm(frame.command.force_n) - norm(last_n));
      last_n = frame.command.force_n;
    });
  });
  std::this_thread::sleep_for(std::chrono::seconds(1));
  live.change([](palpa::Scene& changed) {
    changed.edit<palpa::SurfaceAndFriction>("skin", [](auto& skin) { skin.levels[0].strength_n = 2.0; });
  });
  haptic.join();

  const palpa::LoopStatistics statistics = loop.statistics();
  std::printf("%lld ticks, %lld missed; late by %.0f us (p99), a tick took %.1f us (p99)\n",
              static_cast<long long>(statistics.ticks), static_cast<long long>(statistics.missed), statistics.late.p99_us,
              statistics.tick.p99_us);
  std::printf("up to %.2f N, growing by at most %.3f N a tick; the scene changed %lld times\n", strongest_n, largest_step_n,
              static_cast<long long>(statistics.scenes));
  return strongest_n > 0.5 && strongest_n <= 3.0 && statistics.scenes == 1 ? 0 : 1;
}
