// What the damper is worth on a device: the stiffest plane that is stable under a hand that lets go, and how quiet it is.
// Usage: bench_damper
#include <cstdio>

#include "tests/device/closed_loop.h"

namespace {

using namespace palpa;
using test::ClosedLoop;

constexpr const char* devices[] = {"touch", "desktop", "omega", "falcon", "inverse3"};

void stiffness() {
  std::puts("Largest stable stiffness [N/m], let go, no friction, one tick of delay: encoder told / not told");
  std::puts("  device        D = 0.5        D = 1        D = 2");
  for (const char* device : devices) {
    std::printf("  %-10s", device);
    for (const double damping : {0.5, 1.0, 2.0}) {
      ClosedLoop loop{.plant = device_plant(device), .damping_ns_per_m = damping};
      const double told = test::largest_stable_stiffness(loop);
      loop.told = false;
      std::printf("  %4.0f /%5.0f", told, test::largest_stable_stiffness(loop));
    }
    std::puts("");
  }
}

void quietness() {
  struct Held {
    const char* name;
    Arm arm;
  };
  const Held hands[] = {{"let go", {0, 0, 0}}, {"relaxed", relaxed_arm}, {"firm", firm_arm}};
  std::puts("Noise of the command at rest, 20-500 Hz, rms / (k q), worst of three planes; k = 500 N/m, D = 1 N.s/m");
  std::puts("  device     hand        told   not told   told, with the device's friction");
  for (const char* device : devices) {
    for (const Held& held : hands) {
      const auto worst = [&](bool told, bool friction) {
        double noise_n = 0.0;
        for (const Vec3& normal : {Vec3{0, 0, 1}, normalized(Vec3{1, 1, 1}), normalized(Vec3{1, 2, 5})}) {
          const ClosedLoop loop{
              .plant = device_plant(device), .arm = held.arm, .friction = friction, .told = told, .normal = normal};
          noise_n = std::max(noise_n, test::felt_in(loop).noise_n);
        }
        return noise_n / (500.0 * device_plant(device).limits.encoder_step_m);
      };
      std::printf("  %-10s %-8s %7.3f    %7.3f    %7.3f\n", device, held.name, worst(true, false), worst(false, false),
                  worst(true, true));
    }
  }
}

}  // namespace

int main() {
  stiffness();
  quietness();
}
