// Requirements of every device kind (rig.h): axes, units, limits, watchdogs, faults, identity, reconnection, rest after removal
// and stop. Turns: turns_test.cpp.
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <thread>

#include "palpa/base/load_error.h"
#include "palpa/data/analytic.h"
#include "palpa/device/open_device.h"
#include "palpa/loop/loop.h"
#include "palpa/mode/modes.h"
#include "tests/devices/every_device.h"
#include "tests/devices/steered_rigs.h"
#include "tests/devices/vendor_rigs.h"
#include "tests/solver/counted_allocations.h"

namespace palpa {
namespace conformance_test {

TEST_P(DeviceWithMotors, HasItsHandleWhereTheHandSeesIt) {
  const auto device = rig->open();
  for (const Vec3& place_m : {Vec3{0.01, 0, 0}, Vec3{0, 0.02, 0}, Vec3{0, 0, 0.03}, Vec3{-0.011, 0.017, -0.023}}) {
    rig->hold(place_m, 3.0 * place_m);
    EXPECT_TRUE(comes(*device, {},
                      [&] {
                        return state.valid && distance(state.position_m, place_m) <= rig->position_step_m() &&
                               state.velocity_m_per_s &&
                               distance(*state.velocity_m_per_s, 3.0 * place_m) <= 3.0 * rig->position_step_m();
                      }))
        << place_m.x << ' ' << place_m.y << ' ' << place_m.z;
  }
}

TEST_P(SteeredDevice, GoesWhereItIsSteered) {
  const auto device = rig->open();
  for (const Vec3& way : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}, Vec3{-1, 0, 0}, Vec3{0, -1, 0}, Vec3{0, 0, -1}}) {
    rig->hold(way, {});
    EXPECT_TRUE(comes(*device, {}, [&] { return state.valid && dot(*state.velocity_m_per_s, way) > 0.1; }));
    EXPECT_LT(norm(*state.velocity_m_per_s - dot(*state.velocity_m_per_s, way) * way), 0.02);
    rig->hold({}, {});
    EXPECT_TRUE(comes(*device, {}, [&] { return norm(*state.velocity_m_per_s) < 1e-3; }));
  }
  // A force holds it against a push.
  rig->hold({0.5, 0, 0}, {});
  EXPECT_TRUE(comes(*device, {-3, 0, 0}, [&] { return state.velocity_m_per_s->x < -0.01; }));
  const double far_m = device->limits().workspace_radius_m;
  EXPECT_TRUE(comes(*device, {10, 10, 10}, [&] { return norm(state.position_m) > 0.99 * far_m; }));
  EXPECT_LE(norm(state.position_m), far_m * (1 + 1e-9));
}

TEST_P(DeviceWithMotors, PushesTheWayItIsTold) {
  const auto device = rig->open();
  EXPECT_TRUE(works(*device));
  for (const Vec3& force_n : {Vec3{0.5, 0, 0}, Vec3{0, 0.6, 0}, Vec3{0, 0, 0.7}, Vec3{-0.3, 0.2, -0.1}})
    EXPECT_TRUE(makes(*device, force_n, force_n));
}

TEST_P(DeviceWithMotors, PushesNoHarderThanItMay) {
  const auto device = rig->open();
  EXPECT_TRUE(works(*device));
  const double most_n = device->limits().max_force_n;
  EXPECT_TRUE(makes(*device, {0, 300, 400}, {0, 0.6 * most_n, 0.8 * most_n}));
  EXPECT_TRUE(makes(*device, {1e308, 0, 0}, {most_n, 0, 0}));
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
  for (const Vec3& no_force_n : {Vec3{nan, 0, 0}, Vec3{0, infinite, 0}, Vec3{1, 1, -infinite}}) {
    EXPECT_TRUE(makes(*device, {0, 0.5, 0}, {0, 0.5, 0}));
    EXPECT_TRUE(makes(*device, no_force_n, {}));
  }
}

TEST_P(DeviceWithMotors, LetsGoOfAForceThatNobodyWritesAnyMore) {
  const auto device = rig->open();
  EXPECT_TRUE(works(*device));
  EXPECT_TRUE(makes(*device, {0.5, 0, 0}, {0.5, 0, 0}));
  const auto end = Clock::now() + patience;
  while (rig->force_n() != Vec3{} && Clock::now() < end) std::this_thread::sleep_for(milliseconds(1));
  EXPECT_EQ(rig->force_n(), Vec3{});
  EXPECT_TRUE(makes(*device, {0, 0.5, 0}, {0, 0.5, 0})) << "and takes the next one";
}

TEST_P(EveryDevice, ShowsItsButtons) {
  if (!rig->has_buttons()) return;
  const auto device = rig->open();
  EXPECT_TRUE(works(*device));
  rig->press_button(0, true);
  EXPECT_TRUE(comes(*device, {}, [&] { return state.buttons == 1u; }));
  rig->press_button(1, true);
  EXPECT_TRUE(comes(*device, {}, [&] { return state.buttons == 3u; }));
  rig->press_button(0, false);
  EXPECT_TRUE(comes(*device, {}, [&] { return state.buttons == 2u; }));
  rig->press_button(1, false);
  EXPECT_TRUE(comes(*device, {}, [&] { return state.buttons == 0u; }));
}

TEST_P(EveryDevice, SaysThatItIsGoneAndComesBack) {
  const auto device = rig->open();
  for (int n = 0; n < 3; ++n) {
    EXPECT_TRUE(works(*device));
    if (!GetParam().is_steered) {
      EXPECT_TRUE(makes(*device, {0.5, 0, 0}, {0.5, 0, 0}));
    }
    rig->unplug();
    EXPECT_TRUE(comes(*device, {0.5, 0, 0}, [&] { return state.fault != nullptr && rig->force_n() == Vec3{}; }));
    rig->plug();
  }
  EXPECT_TRUE(works(*device));
}

// A run keeps the device of its start.
TEST_P(EveryDevice, TouchesNoOtherWhileItIsGone) {
  for (const bool is_there_before : {true, false}) {
    for (Rig::Fault& way : rig->ways_to_go()) {
      SCOPED_TRACE(way.name + (is_there_before ? ", with another beside it" : ", with another that comes meanwhile"));
      const auto device = rig->open();
      EXPECT_TRUE(works(*device));
      const DeviceLimits limits = device->limits();
      if (is_there_before) {
        rig->plug_another();
        std::this_thread::sleep_for(milliseconds(50));  // both are listed by then
      }
      way.begin();
      EXPECT_TRUE(comes(*device, {0.5, 0, 0}, [&] { return state.fault != nullptr; }));
      if (!is_there_before) rig->plug_another();
      rig->use_another();
      // Longer than any driver's search interval.
      for (const auto end = Clock::now() + milliseconds(1000); Clock::now() < end;
           std::this_thread::sleep_for(milliseconds(1))) {
        device->write({0.5, 0, 0});
        state = device->read();
        ASSERT_NE(state.fault, nullptr) << "something else is taken for it";
        ASSERT_EQ(state.buttons, 0u);
        ASSERT_FALSE(rig->is_another_touched());
      }
      way.end();
      EXPECT_TRUE(works(*device));
      EXPECT_EQ(device->limits().max_force_n, limits.max_force_n);
      if (!GetParam().is_steered) {
        rig->hold({0.01, 0, 0}, {});
        EXPECT_TRUE(makes(*device, {0.5, 0, 0}, {0.5, 0, 0})) << "it is the one that comes back";
        EXPECT_TRUE(comes(*device, {}, [&] { return distance(state.position_m, {0.01, 0, 0}) <= rig->position_step_m(); }));
      }
      EXPECT_FALSE(rig->is_another_touched());
      rig->unplug_another();
    }
  }
}

// A removed input is at rest with released buttons and a fault; back again it starts anew.
TEST_P(EveryDevice, HoldsNothingWhileItIsGone) {
  const auto device = rig->open();
  const auto is_at_rest = [&] { return !state.velocity_m_per_s || norm(*state.velocity_m_per_s) < 1e-3; };
  const std::uint32_t held = rig->has_buttons() ? 1u : 0u;
  for (Rig::Fault& way : rig->ways_to_go()) {
    SCOPED_TRACE(way.name);
    EXPECT_TRUE(works(*device));
    rig->press_button(0, true);
    if (GetParam().is_steered) rig->hold({1, 0, 0}, {});
    EXPECT_TRUE(comes(*device, {}, [&] { return state.buttons == held; }));
    way.begin();
    EXPECT_TRUE(comes(*device, {}, [&] { return state.fault != nullptr && state.buttons == 0u && is_at_rest(); }));
    const Vec3 left_m = state.position_m;
    for (const auto end = Clock::now() + milliseconds(150); Clock::now() < end; std::this_thread::sleep_for(milliseconds(1))) {
      state = device->read();
      ASSERT_NE(state.fault, nullptr);
      ASSERT_EQ(state.buttons, 0u);
    }
    if (GetParam().is_steered) {
      EXPECT_LT(distance(state.position_m, left_m), 1e-4) << "[m] it goes on";
    }
    // The hand released the button meanwhile.
    rig->press_button(0, false);
    if (GetParam().is_steered) rig->hold({}, {});
    way.end();
    EXPECT_TRUE(works(*device));
    for (int n = 0; n < 50; ++n, std::this_thread::sleep_for(milliseconds(1))) {
      device->write({});
      state = device->read();
      ASSERT_EQ(state.buttons, 0u) << "what was held before counts again";
    }
    if (GetParam().is_steered) {
      EXPECT_TRUE(is_at_rest());
    }
    rig->press_button(0, true);
    EXPECT_TRUE(comes(*device, {}, [&] { return state.buttons == held; }));
    rig->press_button(0, false);
    EXPECT_TRUE(comes(*device, {}, [&] { return state.buttons == 0u; }));
  }
}

TEST_P(EveryDevice, HoldsNoButtonOfAHandleThatHasGone) {
  const auto device = rig->open();
  for (Rig::Fault& way : rig->ways_of_a_handle_to_go()) {
    SCOPED_TRACE(way.name);
    EXPECT_TRUE(works(*device));
    rig->press_button(0, true);
    EXPECT_TRUE(comes(*device, {}, [&] { return state.buttons == 1u; }));
    way.begin();
    EXPECT_TRUE(comes(*device, {}, [&] { return state.buttons == 0u && state.fault != nullptr; }));
    rig->press_button(0, false);
    way.end();
    EXPECT_TRUE(works(*device));
    EXPECT_EQ(state.buttons, 0u);
  }
}

TEST_P(EveryDevice, HoldsNoButtonWhileItsPositionIsUnknown) {
  const auto device = rig->open();
  const std::uint32_t held = rig->has_buttons() ? 1u : 0u;
  for (Rig::Fault& fault : rig->faults()) {
    SCOPED_TRACE(fault.name);
    EXPECT_TRUE(works(*device));
    rig->press_button(0, true);
    EXPECT_TRUE(comes(*device, {}, [&] { return state.buttons == held; }));
    fault.begin();
    EXPECT_TRUE(comes(*device, {}, [&] { return state.fault != nullptr || !state.valid; }));
    for (int n = 0; n < 100; ++n, std::this_thread::sleep_for(milliseconds(1))) {
      state = device->read();
      ASSERT_TRUE(state.valid || state.buttons == 0u);
    }
    rig->press_button(0, false);
    fault.end();
  }
}

// A stop of the program polls this.
TEST_P(EveryDevice, RestsOnlyOnceItsMotorsHaveNoForce) {
  const auto device = rig->open();
  EXPECT_TRUE(works(*device));
  for (int n = 0; n < 100; ++n) {
    if (!GetParam().is_steered) {
      ASSERT_TRUE(makes(*device, {0.5, 0, 0}, {0.5, 0, 0}));
      ASSERT_FALSE(device->rests()) << "with a force on its motors";
    }
    device->write({});
    const auto end = Clock::now() + patience;
    while (!device->rests() && Clock::now() < end) std::this_thread::yield();
    ASSERT_TRUE(device->rests());
    ASSERT_EQ(rig->force_n(), Vec3{});
  }
  if (!GetParam().is_steered) {
    ASSERT_TRUE(makes(*device, {0.5, 0, 0}, {0.5, 0, 0}));
  }
  for (const auto end = Clock::now() + patience; !device->rests() && Clock::now() < end;) std::this_thread::yield();
  EXPECT_TRUE(device->rests());
  EXPECT_EQ(rig->force_n(), Vec3{});
  // A removed device is not waited for.
  for (Rig::Fault& way : rig->ways_to_go()) {
    EXPECT_TRUE(works(*device));
    way.begin();
    EXPECT_TRUE(comes(*device, {}, [&] { return state.fault != nullptr && device->rests(); })) << way.name;
    way.end();
  }
}

std::set<std::string> threads_of_this_process() {
  std::set<std::string> out;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) out.insert(entry.path().filename());
  return out;
}
/// Blocked signals of a thread, a bit each from number 1 on; all after the thread's end.
std::uint64_t blocked_by(const std::string& thread) {
  std::ifstream status("/proc/self/task/" + thread + "/status");
  for (std::string word; status >> word;) {
    if (word != "SigBlk:") continue;
    status >> word;
    return std::stoull(word, nullptr, 16);
  }
  return ~std::uint64_t{0};
}

// A signal's handler waits for the motors; on a driver's thread that is a deadlock.
TEST_P(EveryDevice, HasNoThreadThatTakesASignal) {
  const std::set<std::string> before = threads_of_this_process();
  const auto device = rig->open();
  EXPECT_TRUE(works(*device));
  for (const std::string& thread : threads_of_this_process()) {
    if (before.contains(thread)) continue;
    const std::uint64_t blocked = blocked_by(thread);
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP, SIGTTIN, SIGTTOU, SIGPIPE, SIGALRM, SIGUSR1})
      EXPECT_NE(blocked >> (number - 1) & 1u, 0u) << "signal " << number;
  }
}

TEST(Rigs, AreThereForEveryKindOfDevice) {
  std::set<std::string> kinds, held;
  for (const DeviceBackend* backend : device_backends()) kinds.insert(backend->name);
  for (const NamedRig& rig : rigs())
    if (!rig.backend.empty()) held.insert(rig.backend);
  EXPECT_EQ(held, kinds) << "a kind without a rig is held to nothing";
}

TEST_P(DeviceWithMotors, SaysEveryFaultWithoutAForceAndRecovers) {
  const auto device = rig->open();
  for (Rig::Fault& fault : rig->faults()) {
    EXPECT_TRUE(works(*device)) << "before: " << fault.name;
    EXPECT_TRUE(makes(*device, {0.5, 0, 0}, {0.5, 0, 0})) << "before: " << fault.name;
    fault.begin();
    EXPECT_TRUE(comes(*device, {0.5, 0, 0}, [&] { return state.fault != nullptr || !state.valid; })) << fault.name;
    EXPECT_TRUE(comes(*device, {}, [&] { return rig->force_n() == Vec3{}; })) << fault.name;
    fault.end();
  }
  EXPECT_TRUE(works(*device));
}

// The limiter in the loop: at the latest three ticks after a fault nothing is sent; afterwards the force returns by the ramp.
TEST_P(DeviceWithMotors, EndsAtNoForceWithinThreeTicksOfAFault) {
  Scene scene({.stiffness_n_per_m = 300});
  const FieldRef wind = scene.add("wind", head_phantom());
  scene.add("syrup", Viscosity{.field = wind, .strength_n = {0.05}, .drag_ns_per_m = 0.2});
  scene.add("skin", SurfaceAndFriction{.field = wind, .levels = {{.name = "skin", .value = -300, .strength_n = 1.5}}});
  const auto device = rig->open();
  LiveScene live(scene);
  LiveOptions options{.duration_s = 60.0};
  options.guard = guard_options_for(device->limits(), 3.0);
  options.guard.ramp_s = 0.05;
  LiveLoop loop(live, *device, options);

  std::atomic<bool> stop{false}, is_pushing{false}, is_faulty{false};
  std::atomic<int> ticks_at_fault{0}, worst{0}, without_ramp{0};
  bool comes_back_next = true;
  std::thread haptic([&] {
    loop.run(stop, [&](const TickFrame& frame, const Session&) {
      const bool told = (frame.circumstances & bit_of(Circumstance::device_fault)) != 0 || !frame.result.probe_valid ||
                        (frame.circumstances & bit_of(Circumstance::link_lost)) != 0;
      ticks_at_fault = told ? ticks_at_fault + 1 : 0;
      if (ticks_at_fault > 3 && frame.command.force_n != Vec3{}) worst = std::max(worst.load(), ticks_at_fault.load());
      const bool comes_back =
          !told && comes_back_next && frame.command.force_n != Vec3{} && frame.command.guard != GuardState::falling;
      if (comes_back && frame.command.guard != GuardState::ramp) ++without_ramp;
      comes_back_next = told || (comes_back_next && !comes_back);
      is_pushing = norm(frame.command.force_n) > 0.05;
      is_faulty = told;
    });
  });
  const auto until = [](const std::atomic<bool>& what, const std::function<void()>& meanwhile = {}) {
    for (const auto end = Clock::now() + patience; !what && Clock::now() < end; std::this_thread::sleep_for(milliseconds(2)))
      if (meanwhile) meanwhile();
    return what.load();
  };
  // Into the head and out of it, for a steady change of force.
  double angle = 0.0;
  const auto stroke = [&] {
    angle += 0.02;
    rig->hold({0.03 * std::sin(angle), 0.0, 0.03 * std::cos(angle)}, {});
  };
  std::vector<Rig::Fault> faults = rig->faults();
  for (Rig::Fault& way : rig->ways_to_go()) faults.push_back(way);
  for (Rig::Fault& fault : faults) {
    EXPECT_TRUE(until(is_pushing, stroke)) << "before: " << fault.name;
    fault.begin();
    EXPECT_TRUE(until(is_faulty, stroke)) << fault.name;
    for (int n = 0; n < 10; ++n, std::this_thread::sleep_for(milliseconds(2))) stroke();
    fault.end();
  }
  EXPECT_TRUE(until(is_pushing, stroke)) << "after all";
  stop = true;
  haptic.join();
  EXPECT_EQ(worst, 0) << "ticks after a fault with a force";
  EXPECT_EQ(without_ramp, 0) << "times that a force came back at once";
  EXPECT_TRUE(comes(*device, {}, [&] { return rig->force_n() == Vec3{}; })) << "at the end";
}

TEST_P(EveryDevice, CanBeOpenedAgain) {
  for (int n = 0; n < 5; ++n) {
    const auto device = rig->open();
    EXPECT_TRUE(works(*device));
    if (!GetParam().is_steered) {
      EXPECT_TRUE(makes(*device, {0.5, 0, 0}, {0.5, 0, 0}));
    }
  }
  EXPECT_EQ(rig->force_n(), Vec3{}) << "one that was closed makes none";
}

TEST_P(DeviceWithMotors, KeepsApartFromAnotherOne) {
  const auto second_rig = GetParam().make();
  const auto first = rig->open(), second = second_rig->open();
  EXPECT_TRUE(works(*first));
  EXPECT_TRUE(works(*second));
  rig->hold({0.01, 0, 0}, {});
  second_rig->hold({0, 0.02, 0}, {});
  const auto end = Clock::now() + patience;
  bool is_so = false;
  while (!is_so && Clock::now() < end) {
    first->write({0.5, 0, 0});
    second->write({0, 0.25, 0});
    std::this_thread::sleep_for(milliseconds(1));
    is_so = distance(first->read().position_m, {0.01, 0, 0}) < 1e-9 &&
            distance(second->read().position_m, {0, 0.02, 0}) < 1e-9 && distance(rig->force_n(), {0.5, 0, 0}) < force_step_n &&
            distance(second_rig->force_n(), {0, 0.25, 0}) < force_step_n;
  }
  EXPECT_TRUE(is_so);
}

TEST_P(EveryDevice, NeitherReadsNorWritesWithMemoryOfItsOwn) {
  const auto device = rig->open();
  EXPECT_TRUE(works(*device));
  const long before = test::allocations;
  for (int n = 0; n < 2000; ++n) {
    state = device->read();
    device->write({0.1, 0, 0});
  }
  EXPECT_EQ(test::allocations, before);
}

TEST_P(EveryDevice, HasLimitsThatMakeSense) {
  const DeviceLimits limits = rig->open()->limits();
  EXPECT_GT(limits.max_force_n, 0.0);
  EXPECT_GT(limits.continuous_force_n, 0.0);
  EXPECT_GT(limits.max_stiffness_n_per_m, 100.0);
  EXPECT_GT(limits.workspace_radius_m, 0.02);
  EXPECT_LT(limits.workspace_radius_m, 0.5);
  EXPECT_EQ(limits.has_motors, !GetParam().is_steered);
}

std::string name_of(const testing::TestParamInfo<NamedRig>& rig) { return rig.param.name; }
std::vector<NamedRig> rigs_of(bool steered) {
  std::vector<NamedRig> some = rigs();
  std::erase_if(some, [&](const NamedRig& rig) { return rig.is_steered != steered || rig.has_place; });
  return some;
}
INSTANTIATE_TEST_SUITE_P(All, EveryDevice, testing::ValuesIn(rigs()), name_of);
INSTANTIATE_TEST_SUITE_P(All, DeviceWithMotors, testing::ValuesIn(rigs_of(false)), name_of);
INSTANTIATE_TEST_SUITE_P(All, SteeredDevice, testing::ValuesIn(rigs_of(true)), name_of);

bool becomes(Device& device, const Vec3& force_n, const std::function<bool()>& condition) {
  for (const auto end = Clock::now() + patience; Clock::now() < end; std::this_thread::sleep_for(milliseconds(1))) {
    device.write(force_n);
    device.read();
    if (condition()) return true;
  }
  return false;
}

TEST(ForceDimension, HoldsByItsBrakesWhenItIsTold) {
  const auto rig = force_dimension_rig();
  const auto device = rig->open();
  EXPECT_TRUE(becomes(*device, {1, 0, 0}, [&] { return rig->force_n().x == 1.0; }));
  EXPECT_TRUE(device->brake(true));
  EXPECT_TRUE(becomes(*device, {}, [&] { return rig->brakes() && rig->force_n() == Vec3{}; }));
  EXPECT_TRUE(device->brake(false));
  EXPECT_TRUE(becomes(*device, {0, 1, 0}, [&] { return !rig->brakes() && rig->force_n().y == 1.0; }));
}

TEST(ForceDimension, ASigmaHasTheLimitsOfItsWristAndAnOmegaSixNoTorque) {
  {
    const auto rig = force_dimension_rig(DhdLibrary::whole, Rig::Wrist::driven);
    const DeviceLimits limits = rig->open()->limits();
    EXPECT_EQ(limits.max_torque_nm, 0.2);
    EXPECT_EQ(limits.max_turn_stiffness_nm_per_rad, 1.0);
    EXPECT_EQ(limits.max_turn_damping_nms_per_rad, 0.07);
  }
  const auto rig = force_dimension_rig(DhdLibrary::whole, Rig::Wrist::sensed);
  const auto device = rig->open();
  EXPECT_EQ(device->name(), "Force Dimension omega.6 right");
  EXPECT_TRUE(device->limits().senses_turn);
  EXPECT_EQ(device->limits().max_torque_nm, 0.0);
}

TEST(OpenHaptics, WithoutAGimbalSensesNoTurn) {
  const auto rig = openhaptics_rig();
  rig->take_gimbal();
  const auto device = rig->open();
  EXPECT_FALSE(device->limits().senses_turn);
  EXPECT_TRUE(becomes(*device, {1, 0, 0}, [&] { return rig->force_n().x == 1.0; }));
  EXPECT_FALSE(device->read().turn);
}

TEST(OpenHaptics, GivesWarmMotorsNoMoreThanTheyBear) {
  const auto rig = openhaptics_rig();
  const auto device = rig->open();
  const DeviceLimits limits = device->limits();
  EXPECT_EQ(limits.max_force_n, 3.3);
  EXPECT_EQ(limits.continuous_force_n, 0.88);
  EXPECT_NEAR(limits.max_stiffness_n_per_m, 500.0, 1e-9);
  EXPECT_NEAR(limits.max_damping_ns_per_m, 3.0, 1e-9);
  EXPECT_NEAR(limits.workspace_radius_m, 0.1075, 1e-9) << "the narrowest half of its box";
  const auto makes = [&](double most_n) { return [&, most_n] { return std::abs(norm(rig->force_n()) - most_n) < 1e-9; }; };
  EXPECT_TRUE(becomes(*device, {0, 0, -10}, makes(3.3)));
  rig->warm(0.85);
  EXPECT_TRUE(becomes(*device, {0, 0, -10}, makes(0.5 * (3.3 + 0.88))));
  rig->warm(1.0);
  EXPECT_TRUE(becomes(*device, {0, 0, -10}, makes(0.88)));
  rig->warm(0.3);
  EXPECT_TRUE(becomes(*device, {0, 0, -10}, makes(3.3)));
}

TEST(Controller, RumblesWithTheForceAndKnocksAtATouch) {
  const auto rig = controller_rig();
  auto device = rig->open();
  const auto comes = [&](const Vec3& force_n, const std::function<bool(const Rumble&)>& condition) {
    for (const auto end = Clock::now() + patience; Clock::now() < end; std::this_thread::sleep_for(milliseconds(1))) {
      device->write(force_n);
      if (condition(rig->rumble())) return true;
    }
    return false;
  };
  EXPECT_TRUE(comes({0, 1.5, 0}, [](const Rumble& rumble) { return std::abs(rumble.slow - 0.5) < 1e-3 && rumble.fast > 0.9; }));
  EXPECT_TRUE(comes({0, 1.5, 0}, [](const Rumble& rumble) { return std::abs(rumble.slow - 0.5) < 1e-3 && rumble.fast == 0.0; }))
      << "a knock is short";
  EXPECT_TRUE(comes({}, [](const Rumble& rumble) { return rumble.slow == 0.0 && rumble.fast == 0.0; }));
  EXPECT_TRUE(comes({3, 0, 0}, [](const Rumble& rumble) { return rumble.slow > 0.9; }));
  device.reset();
  EXPECT_EQ(rig->rumble().slow, 0.0) << "it is left at rest";
}

// ---- damaged libraries ----

std::string refusal(const char* backend, const DeviceSettings& settings) {
  try {
    device_backend(backend).open(settings);
  } catch (const LoadError& error) {
    return error.what();
  }
  return "nothing was refused";
}

TEST(VendorLibraries, ThatAreNotThereAreToldWithTheRemedy) {
  for (const char* backend : {"force-dimension", "openhaptics"}) {
    const std::string words = refusal(backend, {{"library", "/nowhere/lib.so"}});
    EXPECT_NE(words.find("/nowhere/lib.so"), std::string::npos) << words;
    EXPECT_NE(words.find("library="), std::string::npos) << words;
    EXPECT_EQ(words.find('\n'), std::string::npos) << words;
    const DeviceSearch search = device_backend(backend).search({{"library", "/nowhere/lib.so"}});
    EXPECT_TRUE(search.found.empty());
    EXPECT_EQ(search.missing.size(), 1u);
  }
}

TEST(VendorLibraries, ThatMissAFunctionAreToldWhich) {
  EXPECT_NE(refusal("force-dimension", {{"library", PALPA_TESTS_DHD_WITHOUT_FORCE}}).find("dhdSetForce"), std::string::npos);
  EXPECT_NE(refusal("openhaptics", {{"library", PALPA_TESTS_HD_WITHOUT_UNSCHEDULE}}).find("hdUnschedule"), std::string::npos);
  EXPECT_NE(refusal("openhaptics", {{"library", PALPA_TESTS_DHD}}).find("hdInitDevice"), std::string::npos)
      << "another vendor's";
}

TEST(VendorLibraries, ShowDevicesThatCanBeOpenedAsTheySay) {
  const auto hands = force_dimension_rig();
  const auto touch = openhaptics_rig();
  for (const auto& [backend, file] :
       {std::pair("force-dimension", PALPA_TESTS_DHD), std::pair("openhaptics", PALPA_TESTS_HD)}) {
    const DeviceSearch search = device_backend(backend).search({{"library", file}});
    ASSERT_FALSE(search.found.empty());
    for (const FoundDevice& found : search.found) {
      const DeviceDescription description = device_description(found.description);
      EXPECT_EQ(description.name, backend);
      EXPECT_NE(device_backend(backend).open(description.settings), nullptr) << found.description;
    }
  }
}

TEST(VendorLibraries, OfAnEarlierVersionAreUsedForWhatTheyHave) {
  const auto device = device_backend("force-dimension").open({{"library", PALPA_TESTS_DHD_OLD}});
  EXPECT_FALSE(device->brake(true)) << "that version has no brakes";
  EXPECT_FALSE(device->limits().senses_turn) << "and no wrists";
  EXPECT_EQ(device->name(), "Force Dimension omega.3");
}

TEST(DeviceSettings, ThatAreWrongAreRefusedInALine) {
  for (const auto& [backend, settings] :
       std::vector<std::pair<const char*, DeviceSettings>>{{"force-dimension", {{"number", "0"}}},
                                                           {"force-dimension", {{"autoinit", "perhaps"}}},
                                                           {"force-dimension", {{"colour", "red"}}},
                                                           {"openhaptics", {{"colour", "red"}}},
                                                           {"spacemouse", {{"full_counts", "nan"}}},
                                                           {"spacemouse", {{"colour", "red"}}},
                                                           {"controller", {{"number", "99"}}},
                                                           {"controller", {{"colour", "red"}}}}) {
    const std::string words = refusal(backend, settings);
    EXPECT_EQ(words.rfind("device " + std::string(backend) + ": ", 0), 0u) << words;
    EXPECT_EQ(words.find('\n'), std::string::npos);
  }
}

}  // namespace conformance_test
}  // namespace palpa
