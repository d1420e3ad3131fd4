// Far hands beside the undelayed session: no delay, flat walls, friction alone, and errors by delay.
#include <cmath>

#include "tests/serve/far_scenes.h"

namespace palpa {
namespace far_hand_test {

constexpr double dt = 1e-3;
const std::vector<double> delays_s = {0.001, 0.005, 0.02, 0.1};

TEST(FarHands, FeelTheSessionItselfWithoutADelay) {
  for (const std::string& name : test::phantoms()) {
    for (const char* hand : {"sim:stroke"}) {
      const Scene scene = test::phantom(name);
      Session session(scene);
      LinkedHand linked(scene, {});
      double most_m = 0.0;
      int n = 0;
      for (const Vec3& probe_m : test::positions_m(hand, 0.8)) {
        const Tick there = session.tick({.position_m = probe_m}, dt);
        const HandTick here = linked.tick({.position_m = probe_m}, dt);
        // The first tick is the hello's; what was there before it is spread.
        if (++n > 1) most_m = std::max(most_m, distance(here.proxy_m, there.proxy_m));
        if (n > 400) {
          EXPECT_EQ(here.offset_m, Vec3{}) << name << " " << n;
        }
      }
      EXPECT_LE(most_m, 1e-8) << name << " " << hand;
    }
  }
}

// The wall is ahead of the hand, or behind it, before it comes back: the local model is the wall itself.
TEST(FarHands, FeelAFlatWallAsWithoutADelay) {
  const Scene scene = test::flat_wall();
  for (const double delay_s : delays_s) {
    Session session(scene);
    LinkedHand linked(scene, {.delay_s = delay_s});
    double most_n = 0.0;
    for (int n = 0; n < 6000; ++n) {
      const double t_s = n * dt;
      const Vec3 probe_m{0.002 * std::sin(2.0 * t_s), 0.001 * std::sin(5.0 * t_s), 0.0005 - 0.004 * std::sin(3.0 * t_s)};
      const Tick there = session.tick({.position_m = probe_m}, dt);
      const HandTick here = linked.tick({.position_m = probe_m}, dt);
      if (t_s > 2.0) most_n = std::max(most_n, distance(here.force_n, there.force_n));
    }
    EXPECT_LE(most_n, 1e-3) << delay_s;
  }
}

// Beyond the largest force the spring is cut; on the way out it gives back what the hand put in, with a delay or without.
TEST(FarHands, FeelTheLargestForceAllTheWayOut) {
  const Scene scene = test::flat_wall();
  constexpr double most_n = 2.0;
  for (const double delay_s : delays_s) {
    Session session(scene);
    LinkedHand linked(scene, {.delay_s = delay_s}, {.device = {.max_force_n = most_n}, .motors = false});
    double most_off_n = 0.0, largest_n = 0.0;
    for (int n = 0; n < 6000; ++n) {
      const double t_s = n * dt;
      const Vec3 probe_m{0.0, 0.0, 0.0005 - 0.02 * std::sin(3.0 * t_s)};
      const Vec3 there_n = session.tick({.position_m = probe_m}, dt).force_n;
      const HandTick here = linked.tick({.position_m = probe_m}, dt);
      largest_n = std::max(largest_n, norm(there_n));
      const Vec3 cut_n = std::min(1.0, most_n / std::max(1e-9, norm(there_n))) * there_n;
      if (t_s > 2.0) most_off_n = std::max(most_off_n, distance(here.force_n, cut_n));
    }
    EXPECT_GT(largest_n, 2.0 * most_n);
    EXPECT_LE(most_off_n, 1e-3) << delay_s;
  }
}

TEST(FarHands, FeelViscosityAndFrictionAloneAsWithoutADelay) {
  Scene syrup({.stiffness_n_per_m = 500.0});
  syrup.add("syrup", Viscosity{.strength_n = {0.3}, .drag_ns_per_m = 3.0});
  for (const Scene& scene : {syrup, test::flat_wall(0.4)}) {
    for (const double delay_s : delays_s) {
      Session session(scene);
      LinkedHand linked(scene, {.delay_s = delay_s});
      double most_n = 0.0;
      for (int n = 0; n < 5000; ++n) {
        const double t_s = n * dt;
        const Vec3 probe_m{0.02 * std::sin(2.0 * t_s), 0.01 * std::sin(5.0 * t_s), 0.01 * std::exp(-5.0 * t_s) - 0.002};
        const Tick there = session.tick({.position_m = probe_m}, dt);
        const HandTick here = linked.tick({.position_m = probe_m}, dt);
        if (t_s > 2.0) most_n = std::max(most_n, distance(here.force_n, there.force_n));
      }
      EXPECT_LE(most_n, 1e-3) << scene.modes()[0].name << " " << delay_s;
    }
  }
}

// Beside forces sent over the link, which are a round trip old: less than two thirds of their error from 10 ms on.
TEST(FarHands, ErrLessThanForcesThatAreSent) {
  for (const char* name : {"head_phantom", "flow_phantom", "many_phantom"}) {
    const Scene scene = test::phantom(name);
    const std::vector<Vec3> hand_m = test::positions_m("sim:stroke", 3.0, test::encounter_of(scene));
    const double most_n = scene.coupling().max_force_n;
    const auto cut = [&](const Vec3& force_n) { return std::min(1.0, most_n / std::max(1e-9, norm(force_n))) * force_n; };
    for (const std::size_t delay : {10, 20}) {
      Session session(scene);
      LinkedHand linked(scene, {.delay_s = static_cast<double>(delay) * dt});
      std::vector<Vec3> there_n;
      double of_models_n2 = 0.0, of_forces_n2 = 0.0;
      for (const Vec3& probe_m : hand_m) {
        there_n.push_back(cut(session.tick({.position_m = probe_m}, dt).force_n));
        const HandTick here = linked.tick({.position_m = probe_m}, dt);
        if (there_n.size() < 500) continue;
        of_models_n2 += norm_squared(cut(here.force_n) - there_n.back());
        of_forces_n2 += norm_squared(there_n[there_n.size() - 1 - 2 * delay] - there_n.back());
      }
      EXPECT_LE(std::sqrt(of_models_n2), 0.67 * std::sqrt(of_forces_n2)) << name << " " << delay << " ms";
    }
  }
}

// A hand that goes into the data and stays there.
std::shared_ptr<const Target> held(const std::vector<Vec3>& way_m, std::size_t until) {
  std::vector<Vec3> positions_m(way_m.begin(), way_m.begin() + static_cast<std::ptrdiff_t>(until));
  positions_m.resize(until + 2000, positions_m.back());
  return sampled_target(positions_m, dt);
}

TEST(FarHands, RestWhereTheHandIsStill) {
  const std::vector<Vec3> way_m = test::positions_m("sim:stroke", 2.0);
  for (const char* name : {"head_phantom", "flow_phantom", "many_phantom"}) {
    for (const char* preset : {"", "touch", "inverse3"}) {
      const DevicePlant plant = *preset ? device_plant(preset) : DevicePlant{};
      for (const double delay_s : {0.1}) {
        for (const Hold hold : {Hold::relaxed, Hold::firm}) {
          const Scene scene = test::phantom(name);
          const auto device = hand_device(held(way_m, 1500), hold, plant);
          LinkedHand linked(scene, {.delay_s = delay_s}, {.device = device->limits(), .motors = false});
          Vec3 before_m;
          double most_m = 0.0;
          for (int n = 0; n < 3500; ++n) {
            const DeviceState state = device->read();
            device->write(linked.tick({.position_m = state.position_m, .valid = state.valid}, dt).command_n);
            device->advance(dt);
            if (n == 2900) before_m = state.position_m;
            if (n > 2900) most_m = std::max(most_m, distance(state.position_m, before_m));
          }
          EXPECT_LE(most_m, 0.1e-3) << name << " " << preset << " " << delay_s << (hold == Hold::firm ? " firm" : "");
        }
      }
    }
  }
}

}  // namespace far_hand_test
}  // namespace palpa
