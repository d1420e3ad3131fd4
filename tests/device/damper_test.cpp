// The damper in a closed loop with a device: damping left by the encoder.
#include <gtest/gtest.h>

#include "tests/device/closed_loop.h"

namespace palpa {
namespace damper_test {

using test::ClosedLoop;
using test::felt_in;

// A released press on a plane of up to 500 N/m: with 1 N·s/m the device comes to rest, without its own friction and a tick
// late, at slow and fast contact, axial and oblique.
TEST(DamperOnADevice, HoldsAPlaneThatTheHandLetsGoOf) {
  for (const char* device : {"touch", "desktop", "omega"}) {
    for (const double k : {100.0, 200.0, 300.0, 400.0, 500.0}) {
      for (const Vec3& normal : {Vec3{0, 0, 1}, normalized(Vec3{1, 1, 1}), normalized(Vec3{1, 2, 5})}) {
        for (const double speed_m_per_s : {0.05, 0.2}) {
          const ClosedLoop loop{
              .plant = device_plant(device), .stiffness_n_per_m = k, .normal = normal, .speed_m_per_s = speed_m_per_s};
          EXPECT_LE(felt_in(loop).swing_m, 12 * loop.plant.limits.encoder_step_m)
              << device << " " << k << " N/m " << speed_m_per_s << " m/s";
        }
      }
    }
  }
}

// At rest the damper adds no tremble to the spring's on the encoder; with the device's friction there is none.
TEST(DamperOnADevice, IsAsQuietAsTheSpring) {
  for (const char* device : {"touch", "desktop", "omega", "falcon", "inverse3"}) {
    for (const Arm& arm : {Arm{0, 0, 0}, relaxed_arm, firm_arm}) {
      for (const Vec3& normal : {Vec3{0, 0, 1}, normalized(Vec3{1, 2, 5})}) {
        ClosedLoop loop{.plant = device_plant(device), .arm = arm, .normal = normal};
        const double step_n = loop.stiffness_n_per_m * loop.plant.limits.encoder_step_m;
        EXPECT_LE(felt_in(loop).noise_n, 1.2 * step_n) << device << " " << arm.stiffness_n_per_m;
        loop.friction = true;
        EXPECT_LE(felt_in(loop).noise_n, 1e-9) << device << " " << arm.stiffness_n_per_m;
      }
    }
  }
}

}  // namespace damper_test
}  // namespace palpa
