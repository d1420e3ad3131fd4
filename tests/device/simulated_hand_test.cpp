// The simulated hand: closed forms of its plant, its energy, and its paths.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "palpa/base/load_error.h"
#include "palpa/device/hand.h"

namespace palpa {
namespace simulated_hand_test {

using testing::AllOf;
using testing::HasSubstr;

class Still final : public Target {
 public:
  explicit Still(const Vec3& position_m = {}, double valid_until_s = 1e9)
      : position_m_(position_m), valid_until_s_(valid_until_s) {}
  Point at(double time_s) const noexcept override { return {.position_m = position_m_, .valid = time_s < valid_until_s_}; }
  double duration_s() const noexcept override { return 1e9; }

 private:
  Vec3 position_m_;
  double valid_until_s_;
};

/// A target that jumps by `offset_m` at time 0+.
class Moved final : public Target {
 public:
  explicit Moved(const Vec3& offset_m) : offset_m_(offset_m) {}
  Point at(double time_s) const noexcept override { return {.position_m = time_s > 0.0 ? offset_m_ : Vec3{}}; }
  double duration_s() const noexcept override { return 1e9; }

 private:
  Vec3 offset_m_;
};

constexpr double dt = 1e-3;

// ---- the plant ----

TEST(SimulatedHand, UnderAConstantForceItRestsAtForceOverStiffness) {
  for (const auto& [hold, stiffness] : {std::pair{Hold::relaxed, 135.0}, std::pair{Hold::firm, 500.0}}) {
    const Vec3 where{0.01, -0.02, 0.03};
    const auto hand = hand_device(std::make_unique<Still>(where), hold);
    const Vec3 force{0.5, -1.0, 2.0};
    hand->write(force);
    for (int i = 0; i < 8000; ++i) hand->advance(dt);
    EXPECT_NEAR(distance(hand->read().position_m, where + force / stiffness), 0, 1e-12);
  }
}

TEST(SimulatedHand, ItMovesAsTheDampedOscillatorThatItIs) {
  // x'' = (F − b x' − K x)/m from rest, underdamped: the textbook's step response, to the sub-step's first order.
  const double m = 0.5, b = 6, k = 135, f = 1.0;
  const double decay = b / (2 * m), omega = std::sqrt(k / m - decay * decay);
  const auto hand = hand_device(std::make_unique<Still>(), Hold::relaxed);
  hand->write({f, 0, 0});
  for (int i = 1; i <= 1000; ++i) {
    hand->advance(dt);
    const double t = i * dt;
    const double exact = f / k * (1 - std::exp(-decay * t) * (std::cos(omega * t) + decay / omega * std::sin(omega * t)));
    EXPECT_NEAR(hand->read().position_m.x, exact, 2e-5 * 2 * f / k * 100) << t;
  }
}

TEST(SimulatedHand, SubStepsBoundTheDependenceOnTheRate) {
  const auto at_rate = [](double rate_hz) {
    const auto hand = hand_device(std::make_unique<Still>(), Hold::firm);
    hand->write({1, 0, 0});
    for (int i = 0; i < static_cast<int>(0.05 * rate_hz); ++i) hand->advance(1 / rate_hz);
    return hand->read().position_m.x;
  };
  EXPECT_NEAR(at_rate(100), at_rate(1000), 1e-12);
  EXPECT_NEAR(at_rate(4000), at_rate(1000), 1e-5);
}

TEST(SimulatedHand, EnergyNeverGrowsByMoreThanTheForceGives) {
  std::mt19937 engine(5);
  const auto in = [&](double low, double high) { return low + (high - low) * static_cast<double>(engine()) / 4294967295.0; };
  for (int trial = 0; trial < 60; ++trial) {
    const DevicePlant plant{.mass_kg = in(0, 0.3),
                            .damping_ns_per_m = in(0, 5),
                            .coulomb_friction_n = trial % 2 ? in(0, 1) : 0.0,
                            .limits = {.max_force_n = 100}};
    const double stiffness = trial % 3 ? 135.0 : 500.0;
    const double time_step_s = trial % 5 ? dt : 0.02;
    const Vec3 offset{in(-0.1, 0.1), in(-0.1, 0.1), in(-0.1, 0.1)};
    const auto hand = hand_device(std::make_unique<Moved>(offset), trial % 3 ? Hold::relaxed : Hold::firm, plant);
    hand->advance(1e-9);  // now the target lies away from the hand, which rests
    Vec3 last = hand->read().position_m;
    double given_j = 0.5 * stiffness * norm_squared(last - offset);
    for (int i = 0; i < 3000; ++i) {
      // Any force at all, then none.
      const Vec3 force = i < 1500 ? Vec3{in(-3, 3), in(-3, 3), -200 * last.z} : Vec3{};
      hand->write(force);
      hand->advance(time_step_s);
      const Vec3 now = hand->read().position_m;
      given_j += dot(force, now - last);
      ASSERT_LE(0.5 * stiffness * norm_squared(now - offset), given_j + 1e-12) << trial << " " << i;
      if (i >= 1500) {
        // In some sub-step the hand was at least as fast as on average.
        ASSERT_LE(0.5 * (0.5 + plant.mass_kg) * norm_squared((now - last) / time_step_s), given_j + 1e-12) << trial << " " << i;
      }
      last = now;
    }
  }
}

TEST(SimulatedHand, ReleasedItComesToRestOnItsTargetAndItsEnergyOnlyFalls) {
  const auto hand = hand_device(std::make_unique<Moved>(Vec3{0.05, 0, 0}), Hold::relaxed);
  double swing = 0.05;
  double last = 0.0;
  for (int i = 0; i < 6000; ++i) {
    hand->advance(dt);
    const double x = hand->read().position_m.x;
    // At turning points of the motion all energy is in the spring: they converge.
    if (i > 10 && std::abs(x - last) < 1e-9) {
      EXPECT_LE(std::abs(x - 0.05), swing + 1e-9);
      swing = std::abs(x - 0.05);
    }
    last = x;
  }
  EXPECT_NEAR(last, 0.05, 1e-9);
}

TEST(SimulatedHand, FrictionHoldsWhatIsWeakerThanItselfExactly) {
  for (const char* name : {"touch", "omega", "falcon", "inverse3"}) {
    DevicePlant plant = device_plant(name);
    plant.limits.encoder_step_m = 0;
    const Vec3 direction = normalized({1, 2, -2});
    const auto hand = hand_device(std::make_unique<Still>(Vec3{0.01, 0, 0}), Hold::relaxed, plant);
    hand->write(0.999 * plant.coulomb_friction_n * direction);
    for (int i = 0; i < 1000; ++i) hand->advance(dt);
    EXPECT_EQ(hand->read().position_m, (Vec3{0.01, 0, 0})) << name;
    hand->write(1.01 * plant.coulomb_friction_n * direction);
    for (int i = 0; i < 1000; ++i) hand->advance(dt);
    EXPECT_GT(dot(hand->read().position_m - Vec3{0.01, 0, 0}, direction), 0) << name;
  }
}

TEST(SimulatedHand, TheForceArrivesAfterItsDelay) {
  const auto hand = hand_device(std::make_unique<Still>(), Hold::relaxed, {.delay_ticks = 3});
  hand->write({1, 0, 0});
  for (int i = 0; i < 3; ++i) {
    hand->advance(dt);
    EXPECT_EQ(hand->read().position_m, Vec3{}) << i;
  }
  hand->write({});
  hand->advance(dt);
  EXPECT_GT(hand->read().position_m.x, 0);
}

TEST(SimulatedHand, PositionsAreRoundedToTheEncodersStep) {
  const auto hand = hand_device(std::make_unique<Still>(Vec3{0.1, -0.0123456, 1e-6}), Hold::rigid, device_plant("touch"));
  const Vec3 x = hand->read().position_m;
  const double step = 55e-6;
  for (const auto& [read, wanted] : {std::pair{x.x, 0.1}, std::pair{x.y, -0.0123456}, std::pair{x.z, 1e-6}}) {
    EXPECT_LE(std::abs(read - wanted), step / 2 * (1 + 1e-9));
    EXPECT_NEAR(read / step, std::round(read / step), 1e-9);
  }
}

TEST(SimulatedHand, ARigidHandIsMovedByNoForceAndAnArmByNoNan) {
  const auto rigid = hand_device(std::make_unique<Still>(Vec3{1, 2, 3}), Hold::rigid);
  rigid->write({100, 0, 0});
  rigid->advance(dt);
  EXPECT_EQ(rigid->read().position_m, (Vec3{1, 2, 3}));
  const auto arm = hand_device(std::make_unique<Still>(), Hold::relaxed);
  for (const double bad : {double{NAN}, double{INFINITY}, 1e308}) {
    arm->write({bad, 0, 0});
    arm->advance(dt);
    EXPECT_TRUE(is_finite(arm->read().position_m));
  }
}

TEST(SimulatedHand, TheDeviceGivesNoMoreThanItsForce) {
  const DevicePlant plant = device_plant("falcon");
  const auto hand = hand_device(std::make_unique<Still>(), Hold::firm, {.limits = plant.limits});
  hand->write({0, 1000, 0});
  for (int i = 0; i < 8000; ++i) hand->advance(dt);
  EXPECT_NEAR(hand->read().position_m.y, plant.limits.max_force_n / 500.0, plant.limits.encoder_step_m);
}

TEST(SimulatedHand, WhereTheTargetIsNotKnownTheProbeIsNotValidAndThenStartsAtRest) {
  class Gap final : public Target {
   public:
    Point at(double time_s) const noexcept override {
      return {.position_m = {time_s < 0.0155 ? 0.0 : 0.1, 0, 0}, .valid = time_s < 0.0045 || time_s > 0.0155};
    }
    double duration_s() const noexcept override { return 1; }
  };
  const auto hand = hand_device(std::make_unique<Gap>(), Hold::relaxed);
  hand->write({5, 0, 0});
  for (int i = 1; i <= 20; ++i) {
    hand->advance(dt);
    EXPECT_EQ(hand->read().valid, i < 5 || i > 15) << i;
    if (i == 10) hand->write({});
  }
  EXPECT_EQ(hand->read().position_m.x, 0.1);
}

TEST(SimulatedHand, ItsClockIsExactWhenTimeIsGivenExactly) {
  for (const double rate : {1000.0, 4000.0, 333.0}) {
    const auto hand = hand_device(std::make_unique<Still>(), Hold::rigid);
    for (int i = 0; i < 5000; ++i) {
      EXPECT_EQ(hand->read().time_s, i / rate);
      hand->advance((i + 1) / rate - i / rate);
    }
  }
}

TEST(SimulatedHand, AnUnknownPresetIsToldTheNames) {
  try {
    device_plant("phantom");
    FAIL();
  } catch (const LoadError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no preset 'phantom'; there are touch, omega, falcon, inverse3"));
  }
}

TEST(DevicePlant, ADescriptionChangesSingleValuesOfAPreset) {
  const DevicePlant touch = device_plant("touch");
  const DevicePlant changed = device_plant("touch,encoder_step_m=2e-5,delay_ticks=2,max_force_n=2,mass_kg=0.1");
  EXPECT_EQ(changed.name, "touch,encoder_step_m=2e-5,delay_ticks=2,max_force_n=2,mass_kg=0.1");
  EXPECT_EQ(changed.limits.encoder_step_m, 2e-5);
  EXPECT_EQ(changed.delay_ticks, 2);
  EXPECT_EQ(changed.limits.max_force_n, 2);
  EXPECT_EQ(changed.mass_kg, 0.1);
  EXPECT_EQ(changed.coulomb_friction_n, touch.coulomb_friction_n);
  EXPECT_EQ(changed.limits.max_stiffness_n_per_m, touch.limits.max_stiffness_n_per_m);
  EXPECT_EQ(device_plant("omega,encoder_step_m=0").limits.encoder_step_m, 0);
  for (const DevicePlant& preset : device_presets())
    EXPECT_EQ(device_plant(preset.name).limits.max_force_n, preset.limits.max_force_n);
}

TEST(DevicePlant, BadDescriptionsAreRefusedWithTheRightForm) {
  const auto error = [](const std::string& text) {
    try {
      device_plant(text);
    } catch (const LoadError& refused) {
      return std::string(refused.what());
    }
    return std::string("(no error)");
  };
  EXPECT_THAT(error(""), HasSubstr("device: no preset ''; there are touch"));
  EXPECT_THAT(error("touch,step=1"), AllOf(HasSubstr("device: unknown key 'step'; there are"), HasSubstr("encoder_step_m")));
  EXPECT_THAT(error("touch,"), testing::StrEq("(no error)"));
  EXPECT_THAT(error("touch,encoder_step_m"), HasSubstr("'' cannot be used for encoder_step_m; it is a number of metres"));
  for (const char* bad :
       {"mass_kg=-1", "mass_kg=nan", "max_force_n=0", "max_force_n=2N", "encoder_step_m=inf", "delay_ticks=1.5",
        "delay_ticks=65", "delay_ticks=-1", "damping_ns_per_m=", "coulomb_friction_n=1e3"}) {
    EXPECT_THAT(error(std::string("falcon,") + bad), HasSubstr("cannot be used for")) << bad;
  }
}

// ---- the paths ----

const char* const all_paths[] = {"sim:press",
                                 "sim:stroke",
                                 "sim:circle",
                                 "sim:helix",
                                 "sim:random",
                                 "sim:press,speed_m_per_s=0.3,depth_m=0.05",
                                 "sim:circle,radius_m=0.06,speed_m_per_s=0.4",
                                 "sim:random,seed=12345,speed_m_per_s=0.3,radius_m=0.05"};

TEST(SimulatedPath, StartsOutsideAndAtRest) {
  for (const char* path : all_paths) {
    const auto target = simulated_target(path);
    EXPECT_EQ(target->at(0).position_m, (Vec3{0, 0, 0.09})) << path;
    EXPECT_LT(distance(target->at(1e-4).position_m, target->at(0).position_m) / 1e-4, 5e-3) << path;
    EXPECT_TRUE(target->at(0).valid && std::isinf(target->duration_s()));
  }
}

TEST(SimulatedPath, IsSmoothAndStaysInReachForLong) {
  for (const char* path : all_paths) {
    const auto target = simulated_target(path);
    Vec3 last = target->at(0).position_m;
    Vec3 last_velocity;
    for (int i = 1; i < 60'000; ++i) {
      const Vec3 now = target->at(i * dt).position_m;
      const Vec3 velocity = (now - last) / dt;
      ASSERT_LE(largest_component(now), 0.16) << path << " at " << i;
      ASSERT_LE(norm(velocity), 2.0) << path << " at " << i;
      ASSERT_LE(norm(velocity - last_velocity) / dt, 60.0) << path << " at " << i;  // [m/s²]: no jump in velocity
      last = now;
      last_velocity = velocity;
    }
  }
}

TEST(SimulatedPath, PressGoesToItsDepthAndOutAgainAtItsSpeed) {
  const auto target = simulated_target("sim:press,depth_m=0.025,speed_m_per_s=0.2");
  double deepest = 1, shallowest_later = 0, fastest = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vec3 p = target->at(i * dt).position_m;
    EXPECT_EQ(p.x, 0);
    EXPECT_EQ(p.y, 0);
    deepest = std::min(deepest, p.z);
    if (i > 300) shallowest_later = std::max(shallowest_later, p.z);
    fastest = std::max(fastest, std::abs(target->at((i + 1) * dt).position_m.z - p.z) / dt);
  }
  EXPECT_NEAR(deepest, 0.075 - 0.025, 1e-5);
  EXPECT_NEAR(shallowest_later, 0.09, 1e-5);
  EXPECT_NEAR(fastest, 0.2, 1e-3);
}

TEST(SimulatedPath, CircleAndHelixKeepTheirRadius) {
  const auto circle = simulated_target("sim:circle,radius_m=0.04");
  const auto helix = simulated_target("sim:helix,radius_m=0.07,depth_m=0.01");
  for (double t = 5; t < 30; t += 0.01) {
    const Vec3 a = circle->at(t).position_m;
    EXPECT_NEAR(std::hypot(a.x, a.y), 0.04, 1e-12);
    EXPECT_NEAR(norm(a), 0.055, 1e-12);
    const Vec3 b = helix->at(t).position_m;
    EXPECT_NEAR(std::hypot(b.x, b.z), 0.06, 1e-12);
  }
}

TEST(SimulatedPath, CircleGoesRoundInTheTimeThatItsSpeedSays) {
  // The generator's own sines against the closed form, over many turns.
  const double radius = 0.04, speed = 0.1;
  const auto circle = simulated_target("sim:circle,radius_m=0.04,speed_m_per_s=0.1");
  for (double t = 5; t < 300; t += 0.0917) {
    const double angle = speed * t / radius;
    EXPECT_NEAR(circle->at(t).position_m.x, radius * std::cos(angle), 1e-14 * (1 + angle));
    EXPECT_NEAR(circle->at(t).position_m.y, radius * std::sin(angle), 1e-14 * (1 + angle));
  }
}

TEST(SimulatedPath, RandomHasNoPowerAbove8Hz) {
  const auto target = simulated_target("sim:random,seed=4,speed_m_per_s=0.3");
  // Hann-windowed Fourier sums over 8 s, well after the start.
  const int n = 4000;
  const double step = 2e-3;
  const auto power = [&](double frequency_hz) {
    double re = 0, im = 0;
    for (int i = 0; i < n; ++i) {
      const double window = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * i / n);
      const double x = window * target->at(10 + i * step).position_m.x;
      re += x * std::cos(2 * std::numbers::pi * frequency_hz * i * step);
      im += x * std::sin(2 * std::numbers::pi * frequency_hz * i * step);
    }
    return re * re + im * im;
  };
  double below = 0, above = 0;
  for (double f = 0.5; f < 7.6; f += 0.25) below = std::max(below, power(f));
  for (double f = 8.25; f < 60; f += 0.75) above = std::max(above, power(f));
  EXPECT_LT(above, 1e-6 * below);
}

TEST(SimulatedPath, SameSeedSamePathAnotherSeedAnother) {
  const auto a = simulated_target("sim:random,seed=9");
  const auto b = simulated_target("sim:random,seed=9");
  const auto c = simulated_target("sim:random,seed=10");
  EXPECT_EQ(a->at(3.21).position_m, b->at(3.21).position_m);
  EXPECT_NE(a->at(3.21).position_m, c->at(3.21).position_m);
}

TEST(SimulatedPath, BadDescriptionsAreRefusedWithTheRightForm) {
  const auto error = [](const std::string& text) {
    try {
      simulated_target(text);
    } catch (const LoadError& refused) {
      return std::string(refused.what());
    }
    return std::string("(no error)");
  };
  EXPECT_THAT(error("sim:poke"), AllOf(HasSubstr("unknown path 'poke'"), HasSubstr("sim:press|stroke|circle|helix|random")));
  EXPECT_THAT(error("sim:"), HasSubstr("unknown path ''"));
  EXPECT_THAT(error("press"), HasSubstr("sim:press|"));
  EXPECT_THAT(error("sim:press,speed=1"), HasSubstr("unknown key 'speed'"));
  EXPECT_THAT(error("sim:press,speed_m_per_s"), HasSubstr("'' cannot be used for speed_m_per_s"));
  EXPECT_THAT(error("sim:press,speed_m_per_s=nan"), HasSubstr("cannot be used"));
  EXPECT_THAT(error("sim:press,speed_m_per_s=0"), HasSubstr("cannot be used"));
  EXPECT_THAT(error("sim:press,depth_m=1m"), HasSubstr("'1m' cannot be used for depth_m"));
  EXPECT_THAT(error("sim:circle,radius_m=-0.1"), HasSubstr("radius_m"));
  EXPECT_THAT(error("sim:random,seed=-1"), HasSubstr("seed"));
  EXPECT_THAT(error("sim:random,seed=99999999999999999999"), HasSubstr("seed"));
}

TEST(OpenHand, SimulatedHandsAreRelaxedAndRecordingsRigidUnlessSaid) {
  EXPECT_EQ(open_hand("sim:press", std::nullopt)->name(), "simulated hand");
  EXPECT_EQ(open_hand("sim:press", Hold::rigid)->name(), "rigid hand");
  EXPECT_EQ(open_hand("sim:press", std::nullopt, {}, device_plant("falcon"))->name(), "simulated hand in falcon");
  EXPECT_EQ(open_hand("sim:press", std::nullopt, {}, device_plant("falcon"))->limits().max_force_n, 8.0);
}

}  // namespace simulated_hand_test
}  // namespace palpa
