// The functions for C of loops, files, pictures and steered hands: equal to what they are made of, and every failure a
// sentence.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "palpa/c.h"
#include "palpa/device/mouse_hand.h"
#include "palpa/device/rate_hand.h"
#include "palpa/palpa.h"
#include "palpa/scene/first_scene.h"
#include "palpa/study/run.h"
#include "tests/c/random_calls.h"
#include "tests/solver/counted_allocations.h"
#include "tests/solver/counted_locks.h"

namespace palpa::c_test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::HasSubstr;

template <auto free>
struct Free {
  template <class Handle>
  void operator()(Handle* handle) const {
    free(handle);
  }
};
using ScenePtr = std::unique_ptr<palpa_scene, Free<&palpa_scene_free>>;
using LoopPtr = std::unique_ptr<palpa_loop, Free<&palpa_loop_free>>;
using FilesPtr = std::unique_ptr<palpa_files, Free<&palpa_files_free>>;
using SteeredPtr = std::unique_ptr<palpa_steered, Free<&palpa_steered_free>>;
using Text = std::unique_ptr<char, Free<&palpa_free>>;

constexpr const char* head = PALPA_SCENES_FOLDER "/head_phantom.toml";

palpa_limits limits(double max_force_n, bool has_motors) {
  palpa_limits made{};
  made.size = sizeof made;
  made.has_motors = has_motors;
  made.max_force_n = max_force_n;
  made.max_stiffness_n_per_m = 600.0;  // less than the scene's
  made.max_damping_ns_per_m = 5.0;
  made.continuous_force_n = std::numeric_limits<double>::infinity();
  return made;
}

/// Into the face and over it.
Probe probe_at(int n) {
  const double t_s = 1e-3 * n;
  return {.position_m = {0.015 * std::sin(3.0 * t_s), 0.01 * std::sin(2.0 * t_s), 0.075 - 0.04 * std::min(t_s, 0.6)}};
}
palpa_probe for_c(const Probe& probe) {
  palpa_probe out{};
  out.size = sizeof out;
  out.valid = 1;
  out.position_m[0] = probe.position_m.x, out.position_m[1] = probe.position_m.y, out.position_m[2] = probe.position_m.z;
  out.turn[0] = 1.0;
  return out;
}
palpa_command tick(palpa_loop* loop, const Probe& probe, std::uint32_t circumstances = 0) {
  palpa_command command{};
  command.size = sizeof command;
  const palpa_probe given = for_c(probe);
  EXPECT_EQ(palpa_loop_tick(loop, &given, 1e-3, circumstances, &command, nullptr), PALPA_OK) << palpa_last_error();
  return command;
}
Vec3 vector_of(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

fs::path fresh(const std::string& name) {
  const fs::path folder = fs::temp_directory_path() / ("palpa-c-" + name + "-" + std::to_string(::getpid()));
  fs::remove_all(folder);
  return folder;
}

TEST(CLoop, IsASessionWithTheGuardToTheBit) {
  for (const bool has_motors : {false, true}) {
    const palpa_limits given = limits(2.0, has_motors);
    const ScenePtr scene(palpa_scene_load(head));
    const LoopPtr in_c(palpa_loop_new(scene.get(), &given));
    ASSERT_TRUE(in_c) << palpa_last_error();
    const DeviceLimits device{
        .max_force_n = 2.0, .has_motors = has_motors, .max_stiffness_n_per_m = 600.0, .max_damping_ns_per_m = 5.0};
    const Scene clamped = clamped_to(load_scene(head).scene, device);
    Session session(clamped);
    GuardOptions options = guard_options_for(device, clamped.coupling().max_force_n);
    options.motors = has_motors;
    GuardedSession in_cpp(session, options);
    double most_n = 0.0;
    for (int n = 0; n < 2000; ++n) {
      const std::uint32_t bits = n % 700 > 690 ? std::uint32_t{PALPA_VIEW_MOVES} : 0u;
      const palpa_command command = tick(in_c.get(), probe_at(n), bits);
      const TickFrame frame = in_cpp.tick(n, 1e-3 * n, 1e-3, probe_at(n), bits);
      ASSERT_EQ(vector_of(command.force_n), frame.command.force_n) << "tick " << n;
      ASSERT_EQ(vector_of(command.coupling_n), frame.result.force_n) << "tick " << n;
      ASSERT_EQ(command.guard, static_cast<int>(frame.command.guard)) << "tick " << n;
      most_n = std::max(most_n, norm(frame.command.force_n));
    }
    EXPECT_GT(most_n, 0.5);
    EXPECT_LE(most_n, 2.0);
  }
}

TEST(CLoop, TicksNeitherAllocateNorLock) {
  const palpa_limits given = limits(2.0, true);
  const ScenePtr scene(palpa_scene_load(head));
  const LoopPtr loop(palpa_loop_new(scene.get(), &given));
  palpa_loop_tick(nullptr, nullptr, 0.0, 0, nullptr, nullptr);  // the thread has its sentence
  palpa_primitive placed[8]{};
  placed[0].size = sizeof placed[0];
  double force_n[3];
  const long allocations = test::allocations, locks = test::locks;
  for (int n = 0; n < 1000; ++n) {
    tick(loop.get(), probe_at(n));
    palpa_loop_primitives(loop.get(), placed, 8);
    palpa_loop_mode(loop.get(), 0, force_n);
  }
  EXPECT_EQ(test::allocations, allocations);
  EXPECT_EQ(test::locks, locks);
}

TEST(CLoop, ARecordingIsReplayedToTheBit) {
  for (const bool has_motors : {false, true}) {
    const fs::path folder = fresh("trace");
    const palpa_limits given = limits(2.0, has_motors);
    const ScenePtr scene(palpa_scene_load(head));
    palpa_scene_set(scene.get(), "coupling.damping_ns_per_m", "0.5");
    const LoopPtr loop(palpa_loop_new(scene.get(), &given));
    for (int n = 0; n < 100; ++n) tick(loop.get(), probe_at(600 + n));  // before: no part of it
    ASSERT_EQ(palpa_loop_record(loop.get(), folder.c_str(), 1e-3, "test"), PALPA_OK) << palpa_last_error();
    for (int n = 0; n < 1500; ++n)
      tick(loop.get(), probe_at(n), n == 1200 ? std::uint32_t{PALPA_PANIC} : n == 1201 ? std::uint32_t{PALPA_RESUME} : 0u);
    ASSERT_EQ(palpa_loop_record(loop.get(), nullptr, 0.0, nullptr), PALPA_OK) << palpa_last_error();
    const TraceReader trace(folder);
    EXPECT_TRUE(trace.header().complete);
    EXPECT_EQ(trace.ticks().size(), 1500U);
    const auto difference = replay(folder).difference;
    EXPECT_TRUE(difference.same) << difference.where;
    fs::remove_all(folder);
  }
}

TEST(CLoop, AChangedSceneIsFeltWhereTheHandIs) {
  const palpa_limits given = limits(3.0, true);
  const ScenePtr scene(palpa_scene_load(head));
  const LoopPtr loop(palpa_loop_new(scene.get(), &given));
  palpa_command last{};
  // Onto the skin, and held there.
  const auto pressing = [](int n) { return Probe{.position_m = {0.0, 0.01, 0.075 - 2.5e-5 * std::min(n, 980)}}; };
  for (int n = 0; n < 1700; ++n) last = tick(loop.get(), pressing(n));
  const ScenePtr softer(palpa_scene_copy(scene.get()));
  ASSERT_EQ(palpa_scene_set(softer.get(), "coupling.stiffness_n_per_m", "300"), PALPA_OK);
  ASSERT_EQ(palpa_loop_change(loop.get(), softer.get()), PALPA_OK) << palpa_last_error();
  const double before_n = norm(vector_of(last.force_n));
  ASSERT_GT(before_n, 0.3);
  for (int n = 0; n < 2000; ++n) {
    const palpa_command now = tick(loop.get(), pressing(1700));
    ASSERT_LE(norm(vector_of(now.force_n) - vector_of(last.force_n)), 0.01) << "the guard spreads the step";
    last = now;
  }
  EXPECT_LT(norm(vector_of(last.force_n)), 0.7 * before_n);
}

TEST(CLoop, OfSeveralChangesBetweenTicksTheLastIsFelt) {
  const palpa_limits given = limits(3.0, true);
  const ScenePtr scene(palpa_scene_load(head));
  const LoopPtr once(palpa_loop_new(scene.get(), &given)), often(palpa_loop_new(scene.get(), &given));
  for (int n = 0; n < 1500; ++n) {
    if (n % 100 == 99) {
      for (int change = 0; change < 5; ++change) {
        const std::string stiffness = std::to_string(200 + (n + 37 * change) % 400);
        ASSERT_EQ(palpa_scene_set(scene.get(), "coupling.stiffness_n_per_m", stiffness.c_str()), PALPA_OK);
        ASSERT_EQ(palpa_loop_change(often.get(), scene.get()), PALPA_OK);
      }
      ASSERT_EQ(palpa_loop_change(once.get(), scene.get()), PALPA_OK);
    }
    ASSERT_EQ(vector_of(tick(once.get(), probe_at(n)).force_n), vector_of(tick(often.get(), probe_at(n)).force_n)) << n;
  }
}

TEST(CLoop, AHandTurnedWithTheViewFeelsTheTurnedForce) {
  const palpa_limits given = limits(3.0, false);
  const ScenePtr scene(palpa_scene_load(head));
  const LoopPtr straight(palpa_loop_new(scene.get(), &given)), turned(palpa_loop_new(scene.get(), &given));
  const double about_y[9] = {0, 0, 1, 0, 1, 0, -1, 0, 0}, mirror[9] = {-1, 0, 0, 0, 1, 0, 0, 0, 1};
  EXPECT_EQ(palpa_loop_turn(turned.get(), mirror), PALPA_WRONG_ARGUMENT);
  ASSERT_EQ(palpa_loop_turn(turned.get(), about_y), PALPA_OK) << palpa_last_error();
  double most_n = 0.0;
  for (int n = 0; n < 1200; ++n) {
    const Vec3 at_m = probe_at(n).position_m;
    const Vec3 handle_m{-at_m.z, at_m.y, at_m.x};  // its turn is at_m
    const Vec3 force_n = vector_of(tick(straight.get(), {.position_m = at_m}).force_n);
    const Vec3 felt_n = vector_of(tick(turned.get(), {.position_m = handle_m}).force_n);
    if (n == 0) continue;  // contact begins anew
    ASSERT_NEAR(norm(felt_n - Vec3{-force_n.z, force_n.y, force_n.x}), 0.0, 1e-9) << "tick " << n;
    most_n = std::max(most_n, norm(force_n));
  }
  EXPECT_GT(most_n, 0.3);
}

TEST(CFiles, AFileOfTheProgramIsFeltAsItsGridAndSuggestsTheSceneOfInfo) {
  const int n = 24;
  std::vector<float> voxels;
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        voxels.push_back(
            std::hypot(static_cast<float>(i) - 11.5F, static_cast<float>(j) - 11.5F, static_cast<float>(k) - 11.5F) < 8.0F
                ? 900.0F
                : 20.0F);
  const palpa_grid grid = test::grid_of(voxels, n);
  const palpa_file_field field{.name = "density", .unit = "HU", .grid = &grid};
  const palpa_file_source source{.name = "ball.nrrd", .sha256 = "00ff", .bytes = 1234};
  const palpa_file file{.size = sizeof file,
                        .format = "nrrd",
                        .length_unit = "mm",
                        .fields = &field,
                        .field_count = 1,
                        .sources = &source,
                        .source_count = 1};
  const FilesPtr files(palpa_files_new());
  ASSERT_EQ(palpa_files_add(files.get(), "ball.nrrd", &file), PALPA_OK) << palpa_last_error();
  // As C++ suggests for the same volume.
  const Text first(palpa_files_first_scene(files.get(), "ball.nrrd"));
  ASSERT_TRUE(first) << palpa_last_error();
  const ScenePtr scene(palpa_scene_parse_with(first.get(), files.get()));
  ASSERT_TRUE(scene) << palpa_last_error();
  const Json facts = Json::parse(Text(palpa_files_facts(files.get(), "ball.nrrd")).get());
  EXPECT_EQ(facts["grid"]["dims"], Json({n, n, n}));
  EXPECT_EQ(facts["fields"][0]["max"], 900.0);
  const std::string modes =
      "[[mode]]\nname = \"skin\"\ntype = \"surface_and_friction\"\nfield = \"a\"\nlevel = [{name = \"l\", value = 400, "
      "strength_n = 2}]\n";
  const auto refusal = [&](const std::string& volume) {
    const ScenePtr refused(palpa_scene_parse_with(("palpa = 1\n[volume.a]\n" + volume + modes).c_str(), files.get()));
    EXPECT_FALSE(refused) << volume;
    return std::string(palpa_last_error());
  };
  EXPECT_THAT(refusal("file = \"other.nrrd\"\n"), HasSubstr("other.nrrd"));
  EXPECT_THAT(refusal("file = \"ball.nrrd\"\nfields = {a = {array = \"b\"}, c = {}}\n"), HasSubstr("has no array"));
  EXPECT_THAT(refusal("file = \"ball.nrrd\"\nlength_unit = \"m\"\n"), HasSubstr("was read in mm"));
  EXPECT_THAT(refusal("file = \"ball.nrrd\"\nframe = 3\n"), HasSubstr("leave out keys"));
  // Felt as the same voxels given to a volume without a file.
  const ScenePtr by_file(
      palpa_scene_parse_with(("palpa = 1\n[volume.a]\nfile = \"ball.nrrd\"\n" + modes).c_str(), files.get()));
  const ScenePtr by_grid(palpa_scene_parse(("palpa = 1\n[volume.a]\n" + modes).c_str(), nullptr));
  ASSERT_TRUE(by_file) << palpa_last_error();
  ASSERT_EQ(palpa_scene_add_grid(by_grid.get(), "a", &grid), PALPA_OK);
  const palpa_limits given = limits(3.0, false);
  const LoopPtr one(palpa_loop_new(by_file.get(), &given)), two(palpa_loop_new(by_grid.get(), &given));
  double most_n = 0.0;
  for (int t = 0; t < 800; ++t) {
    const Probe probe{.position_m = {0.002, 0.001, 0.06 - 5e-5 * t}};
    const Vec3 force_n = vector_of(tick(one.get(), probe).force_n);
    ASSERT_EQ(force_n, vector_of(tick(two.get(), probe).force_n));
    most_n = std::max(most_n, norm(force_n));
  }
  EXPECT_GT(most_n, 0.5);
}

TEST(CPicture, FactsNamePathsThatCanBeSetAndSamplesAreTheFields) {
  const ScenePtr scene(palpa_scene_load(head));
  const Json facts = Json::parse(Text(palpa_scene_facts(scene.get())).get());
  ASSERT_EQ(facts["modes"].size(), 1U);
  for (const Json& level : facts["modes"][0]["levels"]) {
    const std::string path = level["path"].get<std::string>() + ".value";
    EXPECT_EQ(palpa_scene_set(scene.get(), path.c_str(), "-200"), PALPA_OK) << palpa_last_error();
  }
  const Json changed = Json::parse(Text(palpa_scene_facts(scene.get())).get());
  for (const Json& level : changed["modes"][0]["levels"]) EXPECT_EQ(level["value"], -200.0);
  const Similarity map = load_scene(head).scene.hand_to_world();
  const Vec3 world_m = map.to_world({0.01, 0.02, 0.03});
  const auto row = [&](int r) {
    const auto number = [&](int c) { return facts["hand_to_world"][static_cast<std::size_t>(4 * r + c)].get<double>(); };
    return number(0) * 0.01 + number(1) * 0.02 + number(2) * 0.03 + number(3);
  };
  EXPECT_NEAR(norm(Vec3{row(0), row(1), row(2)} - world_m), 0.0, 1e-12);

  palpa_grid lattice{};
  lattice.size = sizeof lattice;
  lattice.dims[0] = 5, lattice.dims[1] = 4, lattice.dims[2] = 3;
  for (int a = 0; a < 3; ++a) lattice.origin_m[a] = -0.05, lattice.axes_m[a][a] = 0.02;
  std::vector<float> out(60);
  EXPECT_EQ(palpa_scene_sample(scene.get(), "head", &lattice, out.data(), 59), PALPA_WRONG_ARGUMENT);
  ASSERT_EQ(palpa_scene_sample(scene.get(), "head", &lattice, out.data(), out.size()), PALPA_OK) << palpa_last_error();
  const FieldPtr field = load_scene(head).scene.field(FieldRef("head")).field;
  for (int i = 0; i < 60; ++i) {
    const ScalarSample there = field->scalar({-0.05 + 0.02 * (i % 5), -0.05 + 0.02 * (i / 5 % 4), -0.05 + 0.02 * (i / 20)});
    const float expected = there.inside ? static_cast<float>(there.value) : std::numeric_limits<float>::quiet_NaN();
    EXPECT_THAT(out[static_cast<std::size_t>(i)], testing::NanSensitiveFloatEq(expected));
  }
  EXPECT_EQ(palpa_scene_sample(scene.get(), "foot", &lattice, out.data(), out.size()), PALPA_WRONG_DATA);
}

TEST(CSteered, AreTheHandsOfWindowAndController) {
  palpa_limits made{};
  made.size = sizeof made;
  const SteeredPtr controller(palpa_steered_new(PALPA_CONTROLLER, &made));
  EXPECT_EQ(made.has_motors, 0);
  EXPECT_EQ(made.max_force_n, rate_hand_limits().max_force_n);
  const SteeredPtr mouse(palpa_steered_new(PALPA_MOUSE, &made));
  EXPECT_EQ(made.max_force_n, MouseHand().limits().max_force_n);
  RateHand rate;
  Vec3 to_m;
  palpa_probe out{};
  out.size = sizeof out;
  for (int n = 0; n < 500; ++n) {
    const Vec3 share{std::sin(0.01 * n), 0.3, -1.0}, force_n{0, 0, n > 200 ? 1.5 : 0.0};
    palpa_steering input{};
    input.size = sizeof input;
    input.deflection[0] = share.x, input.deflection[1] = share.y, input.deflection[2] = share.z;
    input.way_m[2] = n < 100 ? -1e-4 : 0.0;
    ASSERT_EQ(palpa_steered_read(controller.get(), &input, 1e-3, &out), PALPA_OK);
    rate.pass(share, n > 0 ? Vec3{0, 0, n > 201 ? 1.5 : 0.0} : Vec3{}, 1e-3);
    ASSERT_EQ(vector_of(out.position_m), rate.position_m()) << n;
    const double force[3] = {force_n.x, force_n.y, force_n.z};
    palpa_steered_write(controller.get(), force);
    ASSERT_EQ(palpa_steered_read(mouse.get(), &input, 1e-3, &out), PALPA_OK);
    to_m = vector_of(out.position_m);
  }
  EXPECT_NEAR(to_m.z, -0.01, 1e-6) << "in free space a mouse's hand arrives where the ways lead";
}

TEST(CSteered, EveryFailureIsASentence) {
  EXPECT_EQ(palpa_steered_new(7, nullptr), nullptr);
  EXPECT_THAT(palpa_last_error(), HasSubstr("PALPA_MOUSE"));
  EXPECT_EQ(palpa_loop_new(nullptr, nullptr), nullptr);
  EXPECT_EQ(palpa_loop_tick(nullptr, nullptr, 1e-3, 0, nullptr, nullptr), PALPA_WRONG_ARGUMENT);
  EXPECT_EQ(palpa_loop_record(nullptr, "x", 1e-3, nullptr), PALPA_WRONG_ARGUMENT);
  EXPECT_EQ(palpa_files_add(nullptr, "x", nullptr), PALPA_WRONG_ARGUMENT);
  EXPECT_EQ(palpa_files_facts(nullptr, "x"), nullptr);
  EXPECT_EQ(palpa_scene_facts(nullptr), nullptr);
  const ScenePtr scene(palpa_scene_load(head));
  const palpa_limits given = limits(2.0, true);
  const LoopPtr loop(palpa_loop_new(scene.get(), &given));
  EXPECT_EQ(palpa_loop_record(loop.get(), nullptr, 0.0, nullptr), PALPA_WRONG_ARGUMENT);
  EXPECT_THAT(palpa_last_error(), HasSubstr("nothing is recorded"));
  EXPECT_EQ(palpa_loop_record(loop.get(), "/nowhere/trace", 1e-3, nullptr), PALPA_WRONG_DATA);
  palpa_command command{};
  command.size = sizeof command;
  const palpa_probe probe = for_c({});
  EXPECT_EQ(palpa_loop_tick(loop.get(), &probe, std::numeric_limits<double>::quiet_NaN(), 0, &command, nullptr),
            PALPA_WRONG_ARGUMENT);
  EXPECT_EQ(command.cause, PALPA_CAUSE_NO_POSITION);
  EXPECT_EQ(vector_of(command.force_n), Vec3{});
}

}  // namespace
}  // namespace palpa::c_test
