// Cost of a tick through the functions for C beside C++, of a session and of a far hand: alternating passes over one hand's
// way, in one run.
//
//   bench_c SCENE [TICKS]
#include <palpa/c.h>
#include <palpa/loop/loop.h>
#include <palpa/palpa.h>
#include <time.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <vector>

#include "palpa/far/hand_side.h"
#include "palpa/serve/data_side.h"
#include "palpa/study/run.h"

namespace {

using namespace palpa;

constexpr double dt_s = 1e-3;
constexpr int passes = 41;

/// This thread's processor time, independent of other load.
double thread_s() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

std::vector<Vec3> way_of(const char* scene, int ticks) {
  RunOptions options;
  options.scene = scene;
  options.hand = "sim:stroke";
  options.hold = Hold::firm;
  PreparedRun prepared = prepare(options);
  Session session(prepared.loaded.scene);
  std::vector<Vec3> way_m;
  run_simulated(session, *prepared.hand, {.rate_hz = 1.0 / dt_s, .duration_s = ticks * dt_s}, nullptr,
                [&](const TickFrame& frame, const Session&) { way_m.push_back(frame.result.probe_m); });
  return way_m;
}

double microseconds_in_cpp(Session& session, const std::vector<Vec3>& way_m) {
  session.reset();
  const double begin_s = thread_s();
  for (const Vec3& x : way_m) session.tick({.position_m = x}, dt_s);
  return 1e6 * (thread_s() - begin_s) / static_cast<double>(way_m.size());
}

double microseconds_in_c(palpa_session* session, const std::vector<Vec3>& way_m) {
  palpa_session_reset(session);
  palpa_probe probe{};
  probe.size = sizeof probe;
  probe.valid = 1;
  palpa_tick tick{};
  tick.size = sizeof tick;
  const double begin_s = thread_s();
  for (const Vec3& x : way_m) {
    probe.position_m[0] = x.x, probe.position_m[1] = x.y, probe.position_m[2] = x.z;
    palpa_session_tick(session, &probe, dt_s, &tick);
  }
  return 1e6 * (thread_s() - begin_s) / static_cast<double>(way_m.size());
}

// ---- a far hand: messages to it, recorded once, and its ticks with these ----

using Message = std::vector<std::byte>;
using Messages = std::vector<std::vector<Message>>;  // of each tick

HandSide new_hand() {
  return HandSide({.device = {.max_force_n = 3.3, .has_motors = false, .max_stiffness_n_per_m = 1e4}, .motors = false});
}

Messages messages_for(const Scene& scene, const std::vector<Vec3>& way_m) {
  HandSide hand = new_hand();
  DataSide data(scene);
  Messages all;
  double now_s = 0.0;
  std::vector<std::byte> room(most_message_bytes);
  for (const Vec3& x : way_m) {
    now_s += dt_s;
    hand.begin({.position_m = x}, dt_s);
    hand.feel();
    while (const std::size_t bytes = hand.give(room)) data.take({room.data(), bytes}, now_s);
    std::vector<Message>& of_tick = all.emplace_back();
    while (const std::size_t bytes = data.give(room, now_s)) {
      hand.take({room.data(), bytes});
      of_tick.emplace_back(room.begin(), room.begin() + static_cast<std::ptrdiff_t>(bytes));
    }
  }
  return all;
}

double microseconds_far_in_cpp(const Messages& messages, const std::vector<Vec3>& way_m) {
  HandSide hand = new_hand();
  std::vector<std::byte> room(most_message_bytes);
  const double begin_s = thread_s();
  for (std::size_t n = 0; n < way_m.size(); ++n) {
    hand.begin({.position_m = way_m[n]}, dt_s);
    hand.feel();
    while (hand.give(room) > 0) {
    }
    for (const Message& message : messages[n]) hand.take(message);
  }
  return 1e6 * (thread_s() - begin_s) / static_cast<double>(way_m.size());
}

double microseconds_far_in_c(const Messages& messages, const std::vector<Vec3>& way_m) {
  palpa_limits limits{};
  limits.size = sizeof limits;
  limits.max_force_n = 3.3;
  limits.max_stiffness_n_per_m = 1e4;
  limits.max_damping_ns_per_m = limits.continuous_force_n = std::numeric_limits<double>::infinity();
  palpa_hand* const hand = palpa_hand_new(&limits);
  if (!hand) throw LoadError(palpa_last_error());
  std::vector<std::byte> room(most_message_bytes);
  palpa_probe probe{};
  probe.size = sizeof probe;
  probe.valid = 1;
  palpa_command command{};
  command.size = sizeof command;
  const double begin_s = thread_s();
  for (std::size_t n = 0; n < way_m.size(); ++n) {
    probe.position_m[0] = way_m[n].x, probe.position_m[1] = way_m[n].y, probe.position_m[2] = way_m[n].z;
    palpa_hand_tick(hand, &probe, dt_s, &command);
    while (palpa_hand_give(hand, room.data(), room.size()) > 0) {
    }
    for (const Message& message : messages[n]) palpa_hand_take(hand, message.data(), message.size());
  }
  const double passed_us = 1e6 * (thread_s() - begin_s) / static_cast<double>(way_m.size());
  palpa_hand_free(hand);
  return passed_us;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

/// Measures both in turn, and prints their medians.
template <class InCpp, class InC>
void compare(const char* what, std::size_t ticks, InCpp in_cpp, InC in_c) {
  std::vector<double> cpp_us, difference_us;
  for (int pass = 0; pass < passes; ++pass) {
    const bool c_first = pass % 2 == 1;
    const double early_us = c_first ? in_c() : 0.0;
    cpp_us.push_back(in_cpp());
    difference_us.push_back((c_first ? early_us : in_c()) - cpp_us.back());
  }
  std::printf("%s: C++ %.3f us a tick; C %+.3f us, ratio %.4f (medians of %d passes of %zu ticks)\n", what, median(cpp_us),
              median(difference_us), 1.0 + median(difference_us) / median(cpp_us), passes, ticks);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 2) return std::fprintf(stderr, "usage: bench_c SCENE [TICKS]\n"), 2;
  const std::vector<Vec3> way_m = way_of(argv[1], argc > 2 ? std::max(100, std::atoi(argv[2])) : 5000);
  Session in_cpp(load_scene(argv[1]).scene);
  palpa_scene* const scene = palpa_scene_load(argv[1]);
  palpa_session* const in_c = palpa_session_new(scene, 0.0);
  if (!in_c) throw LoadError(palpa_last_error());
  compare(
      "session", way_m.size(), [&] { return microseconds_in_cpp(in_cpp, way_m); },
      [&] { return microseconds_in_c(in_c, way_m); });
  palpa_session_free(in_c);
  palpa_scene_free(scene);
  const Messages messages = messages_for(load_scene(argv[1]).scene, way_m);
  compare(
      "far hand, with its messages", way_m.size(), [&] { return microseconds_far_in_cpp(messages, way_m); },
      [&] { return microseconds_far_in_c(messages, way_m); });
} catch (const palpa::LoadError& error) {
  std::fprintf(stderr, "bench_c: %s\n", error.what());
  return 2;
}
