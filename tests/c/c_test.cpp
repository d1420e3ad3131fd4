// The functions for C: what they feel is what C++ feels, and every failure is a sentence.
#include "palpa/c.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <utility>

#include "palpa/c/sized.h"
#include "palpa/far/hand_side.h"
#include "palpa/palpa.h"
#include "tests/c/random_calls.h"
#include "tests/solver/counted_allocations.h"
#include "tests/solver/counted_locks.h"

namespace palpa {
namespace c_test {

/// A struct that has grown since its first header.
struct Grown {
  std::uint32_t size;
  std::int32_t first;
  double later;
};

}  // namespace c_test

template <>
inline constexpr std::size_t c::first_bytes<c_test::Grown> = 8;

namespace c_test {

using test::ball_toml;
using test::given_toml;
using testing::HasSubstr;
using testing::StartsWith;

struct Free {
  void operator()(palpa_scene* scene) const { palpa_scene_free(scene); }
  void operator()(palpa_session* session) const { palpa_session_free(session); }
  void operator()(palpa_data* data) const { palpa_data_free(data); }
  void operator()(palpa_hand* hand) const { palpa_hand_free(hand); }
  void operator()(palpa_inverse3* inverse3) const { palpa_inverse3_free(inverse3); }
  void operator()(char* text) const { palpa_free(text); }
};
using ScenePtr = std::unique_ptr<palpa_scene, Free>;
using SessionPtr = std::unique_ptr<palpa_session, Free>;
using DataPtr = std::unique_ptr<palpa_data, Free>;
using HandPtr = std::unique_ptr<palpa_hand, Free>;
using Text = std::unique_ptr<char, Free>;

/// Pressed into the scene along z and stroked, with a position that gets lost now and then.
Probe probe_at(int n) {
  const double t = 1e-3 * n;
  return {.position_m = {0.01 * std::sin(9 * t), 0.02 * std::sin(5 * t), 0.07 - 0.05 * std::sin(2 * t)},
          .valid = n % 997 != 996};
}
palpa_probe for_c(const Probe& probe) {
  palpa_probe out{};
  out.size = sizeof out;
  out.valid = probe.valid;
  out.position_m[0] = probe.position_m.x, out.position_m[1] = probe.position_m.y, out.position_m[2] = probe.position_m.z;
  out.turn[0] = probe.turn.w, out.turn[1] = probe.turn.x, out.turn[2] = probe.turn.y, out.turn[3] = probe.turn.z;
  return out;
}
palpa_tick tick_of(palpa_session* session, const Probe& probe) {
  palpa_tick out{};
  out.size = sizeof out;
  const palpa_probe given = for_c(probe);
  EXPECT_EQ(palpa_session_tick(session, &given, 1e-3, &out), PALPA_OK) << palpa_last_error();
  return out;
}

bool same(const double (&a)[3], const Vec3& b) {
  const double xyz[3] = {b.x, b.y, b.z};
  return std::memcmp(a, xyz, sizeof xyz) == 0;
}
bool same(const double (&a)[4], const Turn& b) {
  const double wxyz[4] = {b.w, b.x, b.y, b.z};
  return std::memcmp(a, wxyz, sizeof wxyz) == 0;
}
bool same(const palpa_tick& a, const Tick& b) {
  return same(a.force_n, b.force_n) && same(a.proxy_m, b.proxy_m) && same(a.proxy_velocity_m_per_s, b.proxy_velocity_m_per_s) &&
         same(a.probe_m, b.probe_m) && same(a.probe_velocity_m_per_s, b.probe_velocity_m_per_s) &&
         same(a.probe_step_m, b.probe_step_m) && a.probe_valid == b.probe_valid && a.given_back_n == b.given_back_n &&
         a.error_bound_m == b.error_bound_m && a.sub_steps == b.sub_steps && a.iterations == b.iterations &&
         a.status == static_cast<int>(b.status) && a.dropped == b.dropped && a.unborne_n == b.unborne_n && a.work == b.work &&
         a.felt_octave == b.felt_octave && a.forced_octave == b.forced_octave && a.stored_j == b.energy.stored_j &&
         a.elastic_j == b.energy.elastic_j && a.dissipated_j == b.energy.dissipated_j && a.injected_j == b.energy.injected_j &&
         a.path_and_release_j == b.energy.path_and_release_j && a.damper_j == b.energy.damper_j &&
         a.data_motion_j == b.energy.data_motion_j && a.released_j == b.energy.released_j &&
         a.sampling_j == b.energy.sampling_j && a.sampling_bound_j == b.energy.sampling_bound_j &&
         same(a.torque_nm, b.torque_nm) && same(a.probe_turn, b.probe_turn) && same(a.proxy_turn, b.proxy_turn) &&
         same(a.probe_turn_step_rad, b.probe_turn_step_rad);
}

/// Ticks of both are equal to the bit, and touch something; so are their events.
void expect_same(palpa_session* in_c, Session& in_cpp, int ticks = 3000) {
  int touching = 0, events = 0;
  for (int n = 0; n < ticks; ++n) {
    Probe probe = probe_at(n);
    probe.turn = turn_by({0.0, 0.3 * std::sin(3e-3 * n), 0.0});
    const palpa_tick a = tick_of(in_c, probe);
    const Tick b = in_cpp.tick(probe, 1e-3);
    ASSERT_TRUE(same(a, b)) << "tick " << n;
    touching += norm(b.force_n) > 1e-3;
    std::array<palpa_event, 8> told{};
    told[0].size = sizeof(palpa_event);
    ASSERT_EQ(palpa_session_events(in_c, told.data(), told.size()), in_cpp.events().size());
    for (std::size_t i = 0; i < in_cpp.events().size() && i < told.size(); ++i, ++events) {
      const SessionEvent& event = in_cpp.events()[i];
      ASSERT_EQ(told[i].kind, static_cast<int>(event.kind));
      ASSERT_EQ(told[i].mode, event.mode);
      ASSERT_EQ(told[i].value, event.value);
      ASSERT_EQ(told[i].depth_m, event.depth_m);
      ASSERT_STREQ(told[i].text, event.text ? event.text : "");
    }
  }
  EXPECT_GT(touching, ticks / 10);
  EXPECT_GT(events, 0);
}

ScenePtr parsed(const char* toml) {
  ScenePtr scene(palpa_scene_parse(toml, nullptr));
  EXPECT_TRUE(scene) << palpa_last_error();
  return scene;
}

TEST(C, FeelsShippedScenesToTheBitAsCppDoes) {
  for (const char* name : {"head_phantom", "many_phantom", "flow_phantom"}) {
    const std::string path = std::string(PALPA_SCENES_FOLDER "/") + name + ".toml";
    const ScenePtr scene(palpa_scene_load(path.c_str()));
    ASSERT_TRUE(scene) << palpa_last_error();
    const SessionPtr in_c(palpa_session_new(scene.get(), 1e-5));
    Session in_cpp(load_scene(path).scene, 1e-5);
    int touching = 0;
    for (int n = 0; n < 1500; ++n) {
      const Tick tick = in_cpp.tick(probe_at(n), 1e-3);
      ASSERT_TRUE(same(tick_of(in_c.get(), probe_at(n)), tick)) << name << ", tick " << n;
      touching += norm(tick.force_n) > 1e-3;
    }
    EXPECT_GT(touching, 100) << name;
  }
}

TEST(C, FeelsAToolToTheBitAsCppDoes) {
  const std::string toml = std::string(ball_toml) + "[tool]\nshape = \"rod\"\nlength_m = 0.02\npoints = 5\n";
  const SessionPtr in_c(palpa_session_new(parsed(toml.c_str()).get(), 0.0));
  Session in_cpp(parse_scene(toml, "scene", "", volume_reader(), standard_modes()).scene);
  expect_same(in_c.get(), in_cpp);
}

TEST(C, FeelsAGridAsCppFeelsItsVoxels) {
  constexpr int n = 12;
  std::vector<float> voxels = test::ramp(n);
  const ScenePtr scene = parsed(given_toml);
  palpa_grid grid = test::grid_of(voxels, n);
  grid.slope = -2.0;
  grid.intercept = 2.0;
  ASSERT_EQ(palpa_scene_add_grid(scene.get(), "ct", &grid), PALPA_OK) << palpa_last_error();

  const GridGeometry geometry{{n, n, n}, (0.1 / (n - 1)) * Mat3::identity(), {-0.05, -0.05, -0.05}};
  const auto kept = std::make_shared<std::vector<float>>(voxels);
  std::ranges::fill(voxels, 0.0f);  // the scene has copied them
  Scene same_scene;
  Volume volume;
  volume.fields.push_back({"data", "", grid_field(geometry, {VoxelType::float32, 1, {kept, kept->data()}}, -2.0, 2.0)});
  const FieldRef ct = same_scene.add("ct", volume, {.scale = 1.5});
  same_scene.add("skin", SurfaceAndFriction{.field = ct, .levels = {{.name = "outside", .value = 0.5, .strength_n = 20.0}}});
  const SessionPtr in_c(palpa_session_new(scene.get(), 0.0));
  ASSERT_TRUE(in_c) << palpa_last_error();
  Session in_cpp(same_scene);
  expect_same(in_c.get(), in_cpp);
}

TEST(C, ATextIsTheSceneAgain) {
  const ScenePtr scene = parsed(ball_toml);
  ASSERT_EQ(palpa_scene_set(scene.get(), "coupling.stiffness_n_per_m", "321"), PALPA_OK);
  ASSERT_EQ(palpa_scene_set(scene.get(), "mode.skin.level.outside.strength_n", "17"), PALPA_OK);
  const Text text(palpa_scene_text(scene.get()));
  const ScenePtr again = parsed(text.get());
  EXPECT_STREQ(Text(palpa_scene_text(again.get())).get(), text.get());
  EXPECT_THAT(text.get(), HasSubstr("stiffness_n_per_m = 321"));
  const SessionPtr in_c(palpa_session_new(again.get(), 0.0));
  Session in_cpp(parse_scene(ball_toml, "scene", "", volume_reader(), standard_modes(),
                             {.sets = {{"coupling.stiffness_n_per_m", "321"}, {"mode.skin.level.outside.strength_n", "17"}}})
                     .scene);
  expect_same(in_c.get(), in_cpp);
}

TEST(C, TheTextOfASceneWithAGridAsksForTheGridAgain) {
  const std::vector<float> voxels = test::ramp(5);
  const palpa_grid grid = test::grid_of(voxels, 5);
  const ScenePtr scene = parsed(given_toml);
  EXPECT_FALSE(palpa_session_new(scene.get(), 0.0));
  EXPECT_THAT(palpa_last_error(), StartsWith("scene:2:1: volume 'ct' has no data yet; "));
  EXPECT_FALSE(palpa_scene_text(scene.get()));
  EXPECT_THAT(Text(palpa_scene_warnings(scene.get())).get(), HasSubstr("volume 'ct' has no data yet"));
  ASSERT_EQ(palpa_scene_add_grid(scene.get(), "ct", &grid), PALPA_OK);
  EXPECT_STREQ(Text(palpa_scene_warnings(scene.get())).get(), "");
  const Text text(palpa_scene_text(scene.get()));
  const ScenePtr again = parsed(text.get());
  ASSERT_EQ(palpa_scene_add_grid(again.get(), "ct", &grid), PALPA_OK) << palpa_last_error();
  const SessionPtr a(palpa_session_new(scene.get(), 0.0)), b(palpa_session_new(again.get(), 0.0));
  for (int n = 0; n < 2000; ++n) {
    const palpa_tick first = tick_of(a.get(), probe_at(n)), second = tick_of(b.get(), probe_at(n));
    ASSERT_EQ(std::memcmp(&first, &second, sizeof first), 0) << n;
  }
}

TEST(C, ACopyIsIndependent) {
  const ScenePtr scene = parsed(ball_toml);
  const ScenePtr copy(palpa_scene_copy(scene.get()));
  const Text before(palpa_scene_text(scene.get()));
  ASSERT_EQ(palpa_scene_set(copy.get(), "coupling.max_force_n", "1"), PALPA_OK);
  EXPECT_STREQ(Text(palpa_scene_text(scene.get())).get(), before.get());
  EXPECT_STRNE(Text(palpa_scene_text(copy.get())).get(), before.get());
}

TEST(C, TakesOverAsCppResumesAndResets) {
  const ScenePtr scene = parsed(ball_toml);
  const SessionPtr first(palpa_session_new(scene.get(), 0.0));
  for (int n = 0; n < 500; ++n) tick_of(first.get(), probe_at(n));
  ASSERT_EQ(palpa_scene_set(scene.get(), "mode.skin.level.outside.strength_n", "15"), PALPA_OK);
  const SessionPtr next(palpa_session_new(scene.get(), 0.0));
  ASSERT_EQ(palpa_session_take_over(next.get(), first.get()), PALPA_OK);
  Session before(parse_scene(ball_toml, "scene", "", volume_reader(), standard_modes()).scene);
  for (int n = 0; n < 500; ++n) before.tick(probe_at(n), 1e-3);
  Session after(parse_scene(ball_toml, "scene", "", volume_reader(), standard_modes(),
                            {.sets = {{"mode.skin.level.outside.strength_n", "15"}}})
                    .scene);
  after.resume_in_changed_scene(before);
  for (int n = 500; n < 900; ++n) ASSERT_TRUE(same(tick_of(next.get(), probe_at(n)), after.tick(probe_at(n), 1e-3))) << n;
  palpa_session_reset(next.get());
  after.reset();
  for (int n = 900; n < 1200; ++n) ASSERT_TRUE(same(tick_of(next.get(), probe_at(n)), after.tick(probe_at(n), 1e-3))) << n;
}

TEST(C, ASettingReplacesAnEarlierOneOfItsPath) {
  const ScenePtr scene = parsed(ball_toml);
  for (int n = 0; n < 300; ++n) {
    ASSERT_EQ(palpa_scene_set(scene.get(), "coupling.stiffness_n_per_m", std::to_string(200 + n % 7).c_str()), PALPA_OK);
    ASSERT_EQ(palpa_scene_set(scene.get(), "coupling.max_force_n", n % 2 ? "1" : "2"), PALPA_OK);
  }
  ASSERT_EQ(palpa_scene_set(scene.get(), "mode.skin.name", "bone"), PALPA_OK);
  ASSERT_EQ(palpa_scene_set(scene.get(), "mode.bone.name", "skin"), PALPA_OK);
  ASSERT_EQ(palpa_scene_set(scene.get(), "mode.skin.name", "shell"), PALPA_OK) << palpa_last_error();
  EXPECT_THAT(Text(palpa_scene_text(scene.get())).get(), HasSubstr("name = \"shell\""));
}

TEST(C, EveryFailureIsASentence) {
  const ScenePtr scene = parsed(ball_toml);
  const SessionPtr session(palpa_session_new(scene.get(), 0.0));
  const auto error = [](bool failed) { return failed ? std::string(palpa_last_error()) : "no failure"; };
  EXPECT_EQ(error(!palpa_scene_parse(nullptr, nullptr)), "palpa_scene_parse: toml is NULL; give one");
  EXPECT_THAT(error(!palpa_scene_parse("palpa = ", nullptr)), StartsWith("scene:1:"));
  EXPECT_THAT(error(!palpa_scene_load("/no/such.toml")), StartsWith("/no/such.toml: no such scene; "));
  EXPECT_EQ(error(!palpa_scene_copy(nullptr)), "palpa_scene_copy: scene is NULL; give one");
  EXPECT_THAT(error(palpa_scene_set(scene.get(), "coupling.stifness", "1") < 0),
              StartsWith("--set coupling.stifness: unknown key 'stifness' in [coupling]; "));
  EXPECT_THAT(error(!palpa_session_new(scene.get(), -1.0)), StartsWith("palpa_session_new: encoder_step_m is below 0"));
  EXPECT_THAT(error(palpa_session_take_over(session.get(), nullptr) < 0), HasSubstr("a session is NULL; give both"));

  const std::vector<float> voxels = test::ramp(4);
  palpa_grid grid = test::grid_of(voxels, 4);
  EXPECT_THAT(error(palpa_scene_add_grid(scene.get(), "ball", &grid) < 0),
              StartsWith("volume 'ball': the scene has no table [volume.ball] without 'file' and 'analytic'"));
  grid.bytes = 17;
  EXPECT_THAT(error(palpa_scene_add_grid(scene.get(), "ct", &grid) < 0),
              HasSubstr("bytes is 17; type, components and dims take 256"));
  grid.dims[2] = std::int64_t{1} << 62;
  EXPECT_THAT(error(palpa_scene_add_grid(scene.get(), "ct", &grid) < 0), HasSubstr("dims are more than memory can hold; "));
  grid.size -= 1;
  EXPECT_THAT(error(palpa_scene_add_grid(scene.get(), "ct", &grid) < 0), HasSubstr("set it to sizeof(palpa_grid)"));

  palpa_probe probe = for_c(probe_at(0));
  palpa_tick out{};
  out.size = sizeof out;
  EXPECT_EQ(palpa_session_tick(session.get(), &probe, 0.0, &out), PALPA_WRONG_ARGUMENT);
  EXPECT_THAT(palpa_last_error(), HasSubstr("time_step_s is out of its range; it is above 0 and at most 1"));
  probe.position_m[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(palpa_session_tick(session.get(), &probe, 1e-3, &out), PALPA_WRONG_ARGUMENT);
  EXPECT_THAT(palpa_last_error(), HasSubstr("the probe cannot be used; "));
  EXPECT_EQ(out.status, PALPA_BAD_INPUT);
  probe.size += 8;
  EXPECT_THAT(error(palpa_session_tick(session.get(), &probe, 1e-3, &out) < 0), HasSubstr("set it to sizeof(palpa_probe)"));
  palpa_event event{};
  EXPECT_EQ(palpa_session_events(session.get(), &event, 1), palpa_session_events(nullptr, nullptr, 0));
}

TEST(C, TheSentenceIsTheThreadsOwn) {
  palpa_scene_copy(nullptr);
  std::thread([] {
    EXPECT_STREQ(palpa_last_error(), "");
    palpa_session_new(nullptr, 0.0);
    EXPECT_THAT(palpa_last_error(), StartsWith("palpa_session_new"));
  }).join();
  EXPECT_THAT(palpa_last_error(), StartsWith("palpa_scene_copy"));
}

TEST(C, AnOlderCallersStructsAreHonoured) {
  EXPECT_FALSE(c::is_known_size<Grown>(7));
  EXPECT_TRUE(c::is_known_size<Grown>(8));
  EXPECT_FALSE(c::is_known_size<Grown>(sizeof(Grown) + 1));
  const struct {
    std::uint32_t size = 8;
    std::int32_t first = 5;
  } older;
  Grown given{};
  std::memcpy(&given, &older, sizeof older);
  given.later = -1.0;  // not the caller's
  const Grown read = c::whole(&given, {0, 0, 2.5});
  EXPECT_EQ(read.first, 5);
  EXPECT_EQ(read.later, 2.5);
  c::put(Grown{0, 9, 7.0}, 8, &given);
  EXPECT_EQ(given.size, 8u);
  EXPECT_EQ(given.first, 9);
  EXPECT_EQ(given.later, -1.0);
}

TEST(C, TicksAndEventsNeitherAllocateNorLock) {
  const ScenePtr scene = parsed(ball_toml);
  const SessionPtr session(palpa_session_new(scene.get(), 0.0));
  palpa_session_tick(nullptr, nullptr, 0.0, nullptr);  // the thread has its sentence
  std::array<palpa_event, 4> events{};
  events[0].size = sizeof(palpa_event);
  const long allocations = test::allocations, locks = test::locks;
  for (int n = 0; n < 2000; ++n) {
    tick_of(session.get(), probe_at(n));
    palpa_session_events(session.get(), events.data(), events.size());
    palpa_tick out{};
    if (n % 100 == 0) palpa_session_tick(session.get(), nullptr, 0.0, &out);
  }
  EXPECT_EQ(test::allocations, allocations);
  EXPECT_EQ(test::locks, locks);
}

palpa_limits device_limits() {
  palpa_limits limits{};
  limits.size = sizeof limits;
  limits.max_force_n = 3.3;
  limits.max_stiffness_n_per_m = limits.max_damping_ns_per_m = limits.continuous_force_n =
      std::numeric_limits<double>::infinity();
  return limits;
}

/// Blocks for a millisecond; returns the time [s] since the last call: the data's side has the machine's clock.
double next_tick_s() {
  static auto last = std::chrono::steady_clock::now();
  std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const auto now = std::chrono::steady_clock::now();
  return std::clamp(std::chrono::duration<double>(now - std::exchange(last, now)).count(), 1e-4, 0.02);
}

/// Messages of a hand to its data and back.
template <class GiveHand, class TakeData, class GiveData, class TakeHand>
void pass_messages(GiveHand give_hand, TakeData take_data, GiveData give_data, TakeHand take_hand) {
  std::array<std::byte, PALPA_MESSAGE_BYTES> room;
  while (const std::size_t bytes = give_hand(room)) take_data(std::span<const std::byte>(room).first(bytes));
  while (const std::size_t bytes = give_data(room)) take_hand(std::span<const std::byte>(room).first(bytes));
}

TEST(C, AHandFeelsToTheBitAsCppDoesWithTheSameMessages) {
  const ScenePtr scene = parsed(ball_toml);
  const palpa_limits limits = device_limits();
  const HandPtr hand(palpa_hand_new(&limits));
  const DataPtr data(palpa_data_new(scene.get()));
  ASSERT_TRUE(hand && data) << palpa_last_error();
  HandSide in_cpp({.device = {.max_force_n = 3.3, .has_motors = false, .max_stiffness_n_per_m = 1e9}, .motors = false});
  int touching = 0, events = 0;
  for (int n = 0; n < 1000; ++n) {
    const Probe probe = probe_at(n);
    const palpa_probe given = for_c(probe);
    const double step_s = next_tick_s();
    palpa_command out{};
    out.size = sizeof out;
    ASSERT_EQ(palpa_hand_tick(hand.get(), &given, step_s, &out), PALPA_OK) << palpa_last_error();
    in_cpp.begin({.position_m = probe.position_m, .valid = probe.valid}, step_s);
    const HandTick tick = in_cpp.feel();
    ASSERT_TRUE(same(out.force_n, tick.command_n) && same(out.proxy_m, tick.proxy_m) && same(out.coupling_n, tick.force_n))
        << n;
    ASSERT_EQ(out.guard, static_cast<int>(tick.guard));
    ASSERT_EQ(out.cause, static_cast<int>(tick.cause));
    ASSERT_EQ(out.link, static_cast<int>(tick.link));
    ASSERT_EQ(out.model_age_s, tick.model_age_s);
    touching += norm(tick.command_n) > 0.1;
    std::array<std::byte, PALPA_MESSAGE_BYTES> room;
    while (const std::size_t bytes = palpa_hand_give(hand.get(), room.data(), room.size())) {
      std::array<std::byte, PALPA_MESSAGE_BYTES> other;
      ASSERT_EQ(in_cpp.give(other), bytes);
      ASSERT_EQ(std::memcmp(room.data(), other.data(), bytes), 0);
      palpa_data_take(data.get(), room.data(), bytes);
    }
    while (const std::size_t bytes = palpa_data_give(data.get(), room.data(), room.size())) {
      EXPECT_EQ(palpa_hand_take(hand.get(), room.data(), bytes) == PALPA_OK, in_cpp.take({room.data(), bytes}));
    }
    std::array<palpa_event, 8> told{};
    told[0].size = sizeof(palpa_event);
    events += static_cast<int>(palpa_hand_events(hand.get(), told.data(), told.size()));
  }
  EXPECT_GT(touching, 50);
  EXPECT_GT(events, 0);
}

TEST(C, AHandLetsGoInAPanicAndOfALinkThatCloses) {
  const ScenePtr scene = parsed(ball_toml);
  const palpa_limits limits = device_limits();
  const HandPtr hand(palpa_hand_new(&limits));
  DataPtr data(palpa_data_new(scene.get()));
  const auto force_n = [&](int ticks) {
    palpa_command out{};
    out.size = sizeof out;
    palpa_probe probe = for_c({.position_m = {0, 0, 0.045}});
    for (int n = 0; n < ticks; ++n) {
      palpa_hand_tick(hand.get(), &probe, next_tick_s(), &out);
      pass_messages([&](auto& room) { return palpa_hand_give(hand.get(), room.data(), room.size()); },
                    [&](auto message) { palpa_data_take(data.get(), message.data(), message.size()); },
                    [&](auto& room) { return palpa_data_give(data.get(), room.data(), room.size()); },
                    [&](auto message) { palpa_hand_take(hand.get(), message.data(), message.size()); });
    }
    return std::hypot(out.force_n[0], out.force_n[1], out.force_n[2]);
  };
  palpa_command out{};
  out.size = sizeof out;
  palpa_probe above = for_c({.position_m = {0, 0, 0.06}});
  for (int n = 0; n < 50; ++n) {
    palpa_hand_tick(hand.get(), &above, next_tick_s(), &out);
    pass_messages([&](auto& room) { return palpa_hand_give(hand.get(), room.data(), room.size()); },
                  [&](auto message) { palpa_data_take(data.get(), message.data(), message.size()); },
                  [&](auto& room) { return palpa_data_give(data.get(), room.data(), room.size()); },
                  [&](auto message) { palpa_hand_take(hand.get(), message.data(), message.size()); });
  }
  EXPECT_GT(force_n(200), 0.5);
  EXPECT_EQ(palpa_hand_take(hand.get(), nullptr, 0), PALPA_OK);
  data.reset(palpa_data_new(scene.get()));
  EXPECT_EQ(force_n(1), 0.0);
  EXPECT_EQ(palpa_hand_take(nullptr, nullptr, 0), PALPA_WRONG_ARGUMENT);
  palpa_hand_panic(nullptr, 1);
}

TEST(C, AHandNeitherAllocatesNorLocks) {
  const ScenePtr scene = parsed(ball_toml);
  const palpa_limits limits = device_limits();
  const HandPtr hand(palpa_hand_new(&limits));
  const DataPtr data(palpa_data_new(scene.get()));
  palpa_hand_tick(nullptr, nullptr, 0.0, nullptr);  // the thread has its sentence
  long allocated = 0, locked = 0;
  const auto counted = [&](auto act) {
    const long allocations = test::allocations, locks = test::locks;
    act();
    allocated += test::allocations - allocations;
    locked += test::locks - locks;
  };
  std::array<std::byte, PALPA_MESSAGE_BYTES> room;
  for (int n = 0; n < 1000; ++n) {
    palpa_command out{};
    out.size = sizeof out;
    const palpa_probe probe = for_c(probe_at(n));
    std::size_t bytes = 0;
    counted([&] { palpa_hand_tick(hand.get(), &probe, 1e-3, &out); });
    for (;;) {
      counted([&] { bytes = palpa_hand_give(hand.get(), room.data(), room.size()); });
      if (bytes == 0) break;
      palpa_data_take(data.get(), room.data(), bytes);
    }
    while ((bytes = palpa_data_give(data.get(), room.data(), room.size())) > 0)
      counted([&] { palpa_hand_take(hand.get(), room.data(), bytes); });
    palpa_event event{};
    event.size = sizeof event;
    counted([&] { palpa_hand_events(hand.get(), &event, 1); });
  }
  EXPECT_EQ(allocated, 0);
  EXPECT_EQ(locked, 0);
}

TEST(C, AnInverse3IsReadAndWrittenWithoutMemoryAndLocks) {
  const std::unique_ptr<palpa_inverse3, Free> device(palpa_inverse3_new(nullptr));
  const std::string state = R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":0.01,"y":0.02,"z":0.03}}}]})";
  long allocated = 0, locked = 0;
  palpa_probe probe{};
  probe.size = sizeof probe;
  std::string room(PALPA_MESSAGE_BYTES, '\0');
  for (double now_s = 0.0; now_s < 1.0; now_s += 1e-3) {
    const long allocations_before = test::allocations, locks_before = test::locks;
    const double force_n[3] = {1.0, 0.0, 0.0};
    const char* fault = nullptr;
    palpa_inverse3_write(device.get(), force_n, now_s);
    palpa_inverse3_read(device.get(), &probe, &fault, now_s);
    allocated += test::allocations - allocations_before;
    locked += test::locks - locks_before;
    palpa_inverse3_look(device.get(), now_s);
    if (palpa_inverse3_give(device.get(), room.data(), room.size(), now_s) > 0 || now_s == 0.0)
      palpa_inverse3_take(device.get(), state.data(), state.size(), now_s);
  }
  EXPECT_TRUE(probe.valid);
  EXPECT_EQ(allocated, 0);
  EXPECT_EQ(locked, 0);
}

TEST(C, RandomCallsKeepEveryPromise) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    fuzz::Choices choices(seed);
    test::RandomCalls calls(choices);
    for (int n = 0; n < 1000; ++n) {
      calls.next();
      ASSERT_EQ(calls.broken, "") << "seed " << seed << ", call " << n;
    }
  }
}

}  // namespace c_test
}  // namespace palpa
