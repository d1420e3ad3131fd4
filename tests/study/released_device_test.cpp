// A mass in a sampled loop: the closed form of its largest stiffness.
#include "palpa/study/released_device.h"

#include <gtest/gtest.h>

#include <cmath>

namespace palpa {
namespace let_go_test {

/// A mass m with damping b, held by −k times the position of this tick, or of the tick before, for a tick T. Of the exact
/// sampled loop, with a = exp(−bT/m), the position answers a force as (c1 z + c0)/((z − 1)(z − a)); by Jury's criterion it is
/// stable below: without delay, where a + k c0 = 1; with a delay of one tick, where
/// 1 − (k c0)² = a + k c1 + k c0 (1 + a).
double bound_n_per_m(double mass_kg, double damping_ns_per_m, double tick_s, bool delayed) {
  const double b = damping_ns_per_m, a = std::exp(-b * tick_s / mass_kg), slow = mass_kg / (b * b) * (1.0 - a);
  const double c1 = tick_s / b - slow, c0 = slow * (1.0 - a) - a * c1;
  if (!delayed) return (1.0 - a) / c0;
  const double half = 0.5 * (c1 + c0 * (1.0 + a));
  return (1.0 - a) / (half + std::sqrt(half * half + c0 * c0 * (1.0 - a)));
}

TEST(ReleasedDevice, IsStableUpToTheBoundOfTheSampledLoop) {
  for (const int delay_ticks : {0, 1}) {
    for (const DevicePlant& plant : {DevicePlant{.mass_kg = 0.05, .damping_ns_per_m = 0.2, .delay_ticks = delay_ticks},
                                     DevicePlant{.mass_kg = 0.2, .damping_ns_per_m = 0.8, .delay_ticks = delay_ticks}}) {
      const ReleasedDeviceOptions options{.plant = plant};
      const double found = largest_stable_stiffness_n_per_m([&](double k) { return comes_to_rest(options, k); }, 20.0, 5000.0);
      const double bound = bound_n_per_m(plant.mass_kg, plant.damping_ns_per_m, 1e-3, delay_ticks == 1);
      EXPECT_NEAR(found / bound, 1.0, 0.03) << plant.mass_kg << " kg, " << delay_ticks << " ticks late: " << bound << " N/m";
    }
  }
}

// An encoder makes a stable loop toggle by a few of its steps at single stiffnesses; these are no end of stability.
TEST(ReleasedDevice, MoreDampingNeverHasASmallerLargestStiffnessUnderAnEncoder) {
  for (const char* name : {"touch", "desktop", "omega"}) {
    double before = 0.0;
    for (const double damping : {0.5, 1.0, 2.0}) {
      ReleasedDeviceOptions options{.plant = device_plant(name), .damping_ns_per_m = damping, .rest_steps = 3.5};
      options.plant.coulomb_friction_n = 0.0;
      options.plant.damping_ns_per_m = 0.1;
      options.plant.delay_ticks = 1;
      const double k =
          largest_stable_stiffness_n_per_m([&](double stiff) { return comes_to_rest(options, stiff); }, 40.0, 3000.0);
      EXPECT_GT(k, before) << name << ", " << damping;
      EXPECT_NEAR(k / ((damping + 0.1) / 1.5e-3), 0.85, 0.2) << name << ", " << damping << ": " << k;
      before = k;
    }
  }
}

TEST(ReleasedDevice, TheBoundIsHalfATickOfDelayOrOneAndAHalf) {
  EXPECT_NEAR(bound_n_per_m(0.2, 0.2, 1e-3, false), 2.0 * 0.2 / 1e-3, 2.0);
  EXPECT_NEAR(bound_n_per_m(0.2, 0.2, 1e-3, true), 0.2 / 1.5e-3, 2.0);
}

TEST(ReleasedDevice, FallsAsAMassAndStaysWhereFrictionHoldsIt) {
  const DevicePlant plant{.mass_kg = 0.5, .coulomb_friction_n = 0.2};
  const auto held = released_device(plant, {}, {0, -0.19, 0});
  const auto falls = released_device(plant, {}, {0, -1.2, 0});
  for (int i = 0; i < 100; ++i) {
    for (SimulatedDevice* device : {held.get(), falls.get()}) {
      device->write({});
      device->advance(1e-3);
    }
  }
  EXPECT_EQ(held->read().position_m, Vec3{});
  EXPECT_NEAR(falls->read().position_m.y, -0.5 * (1.0 / 0.5) * 0.1 * 0.1, 2e-5);
}

TEST(ReleasedDevice, FeelsAForceSoManyTicksLater) {
  const auto device = released_device({.mass_kg = 0.1, .delay_ticks = 3}, {}, {});
  for (int i = 0; i < 5; ++i) {
    device->write({1, 0, 0});
    device->advance(1e-3);
    EXPECT_EQ(device->read().position_m.x > 0.0, i >= 3) << i;
  }
}

TEST(LargestStable, IsFoundToAHundredth) {
  EXPECT_NEAR(largest_stable_stiffness_n_per_m([](double k) { return k < 314.0; }, 10.0, 4000.0), 314.0, 4.0);
  EXPECT_EQ(largest_stable_stiffness_n_per_m([](double) { return true; }, 10.0, 4000.0), 4000.0);
  EXPECT_EQ(largest_stable_stiffness_n_per_m([](double) { return false; }, 10.0, 4000.0), 0.0);
}

}  // namespace let_go_test
}  // namespace palpa
