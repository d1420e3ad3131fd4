// Random calls of the functions for C: wrong sizes, NULL, numbers that are not finite, any order.
#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "palpa/c.h"
#include "tests/fuzz/choices.h"

namespace palpa::test {

inline constexpr const char* ball_toml = R"(palpa = 1
[volume.ball]
analytic = "sphere"
[[mode]]
name = "skin"
type = "surface_and_friction"
field = "ball"
[[mode.level]]
name = "outside"
value = 0
strength_n = 20
)";
inline constexpr const char* given_toml = R"(palpa = 1
[volume.ct]
pose = {scale = 1.5}
[[mode]]
name = "skin"
type = "surface_and_friction"
field = "ct"
[[mode.level]]
name = "outside"
value = 0.5
strength_n = 20
)";

/// A grid of n³ numbers from 0 to 1 along k, 0.1 m wide.
inline palpa_grid grid_of(const std::vector<float>& voxels, int n) {
  palpa_grid grid{};
  grid.size = sizeof grid;
  grid.type = PALPA_FLOAT32;
  grid.components = 1;
  const double step_m = 0.1 / (n - 1);
  for (int axis = 0; axis < 3; ++axis) {
    grid.dims[axis] = n;
    grid.origin_m[axis] = -0.05;
    grid.axes_m[axis][axis] = step_m;
  }
  grid.voxels = voxels.data();
  grid.bytes = voxels.size() * sizeof(float);
  grid.slope = 1.0;
  return grid;
}
inline std::vector<float> ramp(int n) {
  std::vector<float> voxels;
  for (int k = 0; k < n; ++k)
    voxels.insert(voxels.end(), static_cast<std::size_t>(n) * n, static_cast<float>(k) / static_cast<float>(n - 1));
  return voxels;
}

/// Calls in any order; `broken` is the first promise that one broke.
class RandomCalls {
 public:
  explicit RandomCalls(fuzz::Choices& choices) : choices_(choices), voxels_(ramp(4)) {}
  ~RandomCalls() {
    for (palpa_scene* scene : scenes_) palpa_scene_free(scene);
    for (palpa_session* session : sessions_) palpa_session_free(session);
    for (palpa_data* data : datas_) palpa_data_free(data);
    for (palpa_hand* hand : hands_) palpa_hand_free(hand);
    for (palpa_inverse3* inverse3 : inverse3s_) palpa_inverse3_free(inverse3);
  }
  RandomCalls(const RandomCalls&) = delete;
  RandomCalls& operator=(const RandomCalls&) = delete;

  void next() {
    const std::uint64_t call = choices_.below(64);
    if (call < 14) return far();
    if (call < 26) return inverse3();
    if (call < 40) return tick();
    if (call < 44) return events();
    if (call < 48) return take_over();
    if (call < 50) return palpa_session_reset(any(sessions_));
    if (call < 52) return begin_session();
    if (call < 54) return put(sessions_, nullptr);
    if (call < 56) return begin_scene();
    if (call < 58) return set();
    if (call < 60) return add_grid();
    if (call < 61) return put(scenes_, nullptr);
    if (call < 62) return text(palpa_scene_text(any(scenes_)), "scene_text");
    if (call < 63) return text(palpa_scene_warnings(any(scenes_)), "scene_warnings");
    palpa_free(nullptr);
    if (palpa_abi() != PALPA_ABI || !palpa_version()) broken = "abi or version";
  }

  std::string broken;

 private:
  template <class Handle>
  using Handles = std::array<Handle*, 4>;  // some are NULL

  template <class Handle>
  Handle* any(const Handles<Handle>& handles) {
    return handles[choices_.below(handles.size())];
  }
  static void free_one(palpa_scene* scene) { palpa_scene_free(scene); }
  static void free_one(palpa_session* session) { palpa_session_free(session); }
  static void free_one(palpa_data* data) { palpa_data_free(data); }
  static void free_one(palpa_hand* hand) { palpa_hand_free(hand); }
  static void free_one(palpa_inverse3* inverse3) { palpa_inverse3_free(inverse3); }
  template <class Handle>
  void put(Handles<Handle>& handles, std::type_identity_t<Handle>* handle) {
    Handle*& place = handles[choices_.below(handles.size())];
    free_one(place);
    place = handle;
  }

  double number() {
    constexpr double inf = std::numeric_limits<double>::infinity();
    constexpr std::array special = {0.0,    -0.0,  1.0, -1.0, 1e3,
                                    1e-300, 1e300, inf, -inf, std::numeric_limits<double>::quiet_NaN()};
    return choices_.one_in(40) ? choices_.one_of(special) : choices_.between(-0.1, 0.1);
  }
  std::uint32_t size(std::size_t right) {
    if (!choices_.one_in(20)) return static_cast<std::uint32_t>(right);
    return static_cast<std::uint32_t>(choices_.one_in(2) ? choices_.below(std::uint64_t{1} << 32)
                                                         : right - 8 + choices_.below(16));
  }
  void must_fail_with_sentence(bool failed, const char* of) {
    if (!failed) return;
    const std::string_view sentence = palpa_last_error();
    const std::size_t colon = sentence.find(": ");
    if (colon == sentence.npos || sentence.find(';', colon) == sentence.npos || sentence.find('\n') != sentence.npos)
      broken = std::string(of) + " fails with '" + std::string(sentence) + "'";
  }

  void tick() {
    palpa_probe probe{};
    probe.size = size(sizeof probe);
    probe.valid = !choices_.one_in(50);
    probe.has_velocity = choices_.one_in(4);
    for (double& x : probe.position_m) x = number();
    for (double& v : probe.velocity_m_per_s) v = number();
    probe.turn[0] = choices_.one_in(20) ? number() : 1.0;
    palpa_tick out{};
    out.size = size(sizeof out);
    const double step_s = choices_.one_in(40) ? number() : 1e-3;
    const palpa_result result = palpa_session_tick(any(sessions_), choices_.one_in(50) ? nullptr : &probe, step_s,
                                                   choices_.one_in(50) ? nullptr : &out);
    must_fail_with_sentence(result < 0, "session_tick");
    for (const double f : out.force_n) {
      if (!std::isfinite(f)) broken = "force is not finite";
    }
  }
  void events() {
    std::array<palpa_event, 3> out{};
    for (palpa_event& event : out) event.size = size(sizeof event);
    palpa_session_events(any(sessions_), choices_.one_in(10) ? nullptr : out.data(), choices_.below(out.size() + 1));
    for (const palpa_event& event : out) {
      if (!std::memchr(event.text, '\0', sizeof event.text)) broken = "text of an event has no end";
    }
  }
  void take_over() {
    must_fail_with_sentence(palpa_session_take_over(any(sessions_), any(sessions_)) < 0, "session_take_over");
  }
  void begin_session() {
    palpa_session* const session = palpa_session_new(any(scenes_), choices_.one_in(4) ? number() : 0.0);
    must_fail_with_sentence(!session, "session_new");
    put(sessions_, session);
  }
  void begin_scene() {
    palpa_scene* scene = nullptr;
    if (choices_.one_in(4)) {
      scene = palpa_scene_copy(any(scenes_));
    } else if (choices_.one_in(4)) {
      scene = palpa_scene_load(choices_.one_in(2) ? nullptr : "/no/such.toml");
    } else {
      std::string toml = choices_.one_in(2) ? given_toml : ball_toml;
      if (choices_.one_in(3)) toml += "[tool]\nshape = \"rod\"\nlength_m = 0.02\npoints = 3\n";
      if (choices_.one_in(4)) toml[choices_.below(toml.size())] = static_cast<char>(1 + choices_.below(255));
      scene = palpa_scene_parse(choices_.one_in(20) ? nullptr : toml.c_str(), choices_.one_in(2) ? nullptr : "/");
    }
    must_fail_with_sentence(!scene, "scene");
    put(scenes_, scene);
  }
  void set() {
    constexpr std::array<const char*, 9> paths = {"coupling.stiffness_n_per_m",
                                                  "mode.skin.level.outside.strength_n",
                                                  "mode.skin.enabled",
                                                  "volume.ball.analytic",
                                                  "volume.ct.filter",
                                                  "law.method",
                                                  "mode.skin.name",
                                                  "",
                                                  "..."};
    constexpr std::array<const char*, 9> values = {"300", "true", "exact", "smooth", "-1", "nan", "", "[[[[", "'"};
    const palpa_result result = palpa_scene_set(any(scenes_), choices_.one_in(30) ? nullptr : choices_.one_of(paths),
                                                choices_.one_in(30) ? nullptr : choices_.one_of(values));
    must_fail_with_sentence(result < 0, "scene_set");
  }
  void add_grid() {
    palpa_grid grid = grid_of(voxels_, 4);
    grid.size = size(sizeof grid);
    if (choices_.one_in(5)) grid.type = static_cast<std::int32_t>(choices_.below(9)) - 1;
    if (choices_.one_in(5)) grid.components = static_cast<std::int32_t>(choices_.below(5)) - 1;
    if (choices_.one_in(5)) grid.dims[choices_.below(3)] = static_cast<std::int64_t>(choices_.below(std::uint64_t{1} << 63));
    if (choices_.one_in(5)) grid.axes_m[choices_.below(3)][choices_.below(3)] = number();
    if (choices_.one_in(5)) grid.slope = number();
    if (choices_.one_in(5)) grid.intercept = number();
    if (choices_.one_in(5)) grid.bytes -= 1;
    if (choices_.one_in(9)) grid.voxels = nullptr;
    constexpr std::array<const char*, 3> names = {"ct", "ball", ""};
    const palpa_result result = palpa_scene_add_grid(any(scenes_), choices_.one_in(30) ? nullptr : choices_.one_of(names),
                                                     choices_.one_in(30) ? nullptr : &grid);
    must_fail_with_sentence(result < 0, "scene_add_grid");
  }
  void text(char* text, const char* of) {
    must_fail_with_sentence(!text, of);
    palpa_free(text);
  }

  // ---- far ----

  void far() {
    const std::uint64_t call = choices_.below(64);
    if (call < 30) return hand_tick();
    if (call < 42) return pass(palpa_hand_give, any(hands_), palpa_data_take, any(datas_));
    if (call < 54) return pass(palpa_data_give, any(datas_), palpa_hand_take, any(hands_));
    if (call < 57) return hand_events();
    if (call < 58) return palpa_hand_panic(any(hands_), static_cast<std::int32_t>(choices_.below(2)));
    if (call < 59) return must_fail_with_sentence(palpa_hand_take(any(hands_), nullptr, choices_.below(2)) < 0, "hand_take");
    if (call < 60) return must_fail_with_sentence(palpa_data_change(any(datas_), any(scenes_)) < 0, "data_change");
    if (call < 61) return put(hands_, nullptr);
    if (call < 62) return put(datas_, nullptr);
    if (call < 63) return begin_hand();
    palpa_data* const data = palpa_data_new(any(scenes_));
    must_fail_with_sentence(!data, "data_new");
    put(datas_, data);
  }
  void begin_hand() {
    palpa_limits limits{};
    limits.size = size(sizeof limits);
    limits.has_motors = choices_.one_in(2);
    for (double* const limit : {&limits.max_force_n, &limits.max_stiffness_n_per_m, &limits.max_damping_ns_per_m,
                                &limits.continuous_force_n, &limits.encoder_step_m, &limits.damping_ns_per_m})
      *limit = choices_.one_in(20) ? number() : limit == &limits.max_force_n ? most_n : choices_.between(0.0, 1e3);
    palpa_hand* const hand = palpa_hand_new(choices_.one_in(20) ? nullptr : &limits);
    must_fail_with_sentence(!hand, "hand_new");
    put(hands_, hand);
  }
  void hand_tick() {
    palpa_probe probe{};
    probe.size = size(sizeof probe);
    probe.valid = !choices_.one_in(50);
    for (double& x : probe.position_m) x = number();
    palpa_command out{};
    out.size = size(sizeof out);
    const double step_s = choices_.one_in(40) ? number() : 1e-3;
    const palpa_result result =
        palpa_hand_tick(any(hands_), choices_.one_in(50) ? nullptr : &probe, step_s, choices_.one_in(50) ? nullptr : &out);
    must_fail_with_sentence(result < 0, "hand_tick");
    const double force_n = std::hypot(out.force_n[0], out.force_n[1], out.force_n[2]);
    if (!(force_n <= largest_n)) broken = "command is not finite, or beyond any limit";
  }
  template <class Give, class From, class Take, class To>
  void pass(Give give, From* from, Take take, To* to) {
    std::size_t bytes = give(from, choices_.one_in(50) ? nullptr : message_.data(),
                             choices_.one_in(50) ? choices_.below(PALPA_MESSAGE_BYTES) : message_.size());
    if (bytes > message_.size()) broken = "message is longer than its room";
    if (bytes == 0) bytes = choices_.below(message_.size());  // what was there before
    if (choices_.one_in(4)) message_[choices_.below(bytes)] = static_cast<unsigned char>(choices_.below(256));
    if (choices_.one_in(20)) bytes = choices_.below(message_.size());
    must_fail_with_sentence(take(to, choices_.one_in(50) ? nullptr : message_.data(), bytes) < 0, "take");
  }
  void hand_events() {
    std::array<palpa_event, 3> out{};
    for (palpa_event& event : out) event.size = size(sizeof event);
    palpa_hand_events(any(hands_), choices_.one_in(10) ? nullptr : out.data(), choices_.below(out.size() + 1));
    for (const palpa_event& event : out) {
      if (!std::memchr(event.text, '\0', sizeof event.text)) broken = "text of an event has no end";
    }
  }

  // ---- Inverse3 ----

  double time_s() {
    if (choices_.one_in(100)) return choices_.one_in(2) ? number() : now_s_ + number();
    return now_s_ += choices_.one_in(100) ? 1.0 : 1e-4;
  }
  void inverse3() {
    palpa_inverse3* const device = any(inverse3s_);
    const std::uint64_t call = choices_.below(64);
    if (call < 8) return exchange(device);
    if (call < 20) return look(device);
    if (call < 32) return take_text(device);
    if (call < 42) return give_text(device);
    if (call < 50) return read(device);
    if (call < 58) {
      const double force_n[3] = {number(), 100.0 * number(), number()};
      const palpa_result result = palpa_inverse3_write(device, choices_.one_in(50) ? nullptr : force_n, time_s());
      return must_fail_with_sentence(result < 0, "inverse3_write");
    }
    if (call < 59 && choices_.one_in(9))
      return must_fail_with_sentence(palpa_inverse3_end(device, time_s()) < 0, "inverse3_end");
    if (call < 60) return put(inverse3s_, nullptr);
    if (call < 63) return begin_inverse3();
    palpa_limits limits{};
    limits.size = size(sizeof limits);
    must_fail_with_sentence(palpa_inverse3_limits(choices_.one_in(9) ? nullptr : &limits) < 0, "inverse3_limits");
  }
  /// Rounds of a program, until its forces are sent.
  void exchange(palpa_inverse3* device) {
    for (std::uint64_t left = choices_.below(24); left > 0; --left) {
      const double force_n[3] = {choices_.between(-5.0, 5.0), 0.0, choices_.between(-5.0, 5.0)};
      palpa_inverse3_write(device, force_n, time_s());
      look(device);
      give_text(device);
      take_text(device);
    }
  }
  void begin_inverse3() {
    palpa_inverse3_options options{};
    options.size = size(sizeof options);
    options.force_key = choices_.one_in(20) ? static_cast<std::int32_t>(choices_.below(9)) - 3 : 0;
    constexpr std::array<const char*, 4> names = {nullptr, "049D", "a b", ""};
    for (const char** const name : {&options.device_id, &options.grip_id, &options.profile})
      *name = choices_.one_in(20) ? choices_.one_of(names) : nullptr;
    constexpr std::array<const char*, 3> versions = {nullptr, R"({"data":{"project_version":"3.4.1"}})", "[["};
    options.version = choices_.one_of(versions);
    palpa_inverse3* const made = palpa_inverse3_new(choices_.one_in(20) ? nullptr : &options);
    must_fail_with_sentence(!made, "inverse3_new");
    put(inverse3s_, made);
  }
  void look(palpa_inverse3* device) {
    const std::int32_t act = palpa_inverse3_look(device, time_s());
    must_fail_with_sentence(act < 0, "inverse3_look");
    if (act > PALPA_INVERSE3_DONE) broken = "act is not known";
    if (act == PALPA_INVERSE3_CONNECT) take_text(device);
  }
  void take_text(palpa_inverse3* device) {
    std::string text = R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":0,"y":0.01,"z":0}},)"
                       R"("status":{"power_supply":true}}],"verse_grip":[{"device_id":"7","state":{"button":true}}]})";
    if (choices_.one_in(8)) text[choices_.below(text.size())] = static_cast<char>(choices_.below(256));
    if (choices_.one_in(40)) text.resize(choices_.below(text.size()));
    const bool is_closed = choices_.one_in(40);
    const palpa_result result =
        palpa_inverse3_take(device, is_closed ? nullptr : text.data(), is_closed ? choices_.below(2) : text.size(), time_s());
    must_fail_with_sentence(result < 0, "inverse3_take");
  }
  void give_text(palpa_inverse3* device) {
    auto* const room = reinterpret_cast<char*>(message_.data());
    const std::size_t bytes =
        palpa_inverse3_give(device, choices_.one_in(50) ? nullptr : room,
                            choices_.one_in(50) ? choices_.below(PALPA_MESSAGE_BYTES) : message_.size(), time_s());
    if (bytes == 0) return;
    if (bytes > message_.size() || room[0] != '{' || room[bytes - 1] != '}') {
      broken = "message is no object";
      return;
    }
    const std::string text(room, bytes);
    double force_n[3] = {};
    const std::size_t at = text.find("{\"x\":");
    if (at != text.npos &&
        std::sscanf(text.c_str() + at, "{\"x\":%lf,\"y\":%lf,\"z\":%lf", force_n, force_n + 1, force_n + 2) != 3)
      broken = "force is no vector";
    if (!(std::hypot(force_n[0], force_n[1], force_n[2]) < 3.001)) broken = "force is beyond the device's limit";
  }
  void read(palpa_inverse3* device) {
    palpa_probe probe{};
    probe.size = size(sizeof probe);
    const char* fault = nullptr;
    const palpa_result result =
        palpa_inverse3_read(device, choices_.one_in(50) ? nullptr : &probe, choices_.one_in(50) ? nullptr : &fault, time_s());
    must_fail_with_sentence(result < 0, "inverse3_read");
    if (!(std::abs(probe.position_m[1]) <= 10.0)) broken = "position is not finite, or beyond any device";
  }

  static constexpr double most_n = 3.0;     // limit of most hands
  static constexpr double largest_n = 1e9;  // of any

  fuzz::Choices& choices_;
  std::vector<float> voxels_;
  Handles<palpa_scene> scenes_{};
  Handles<palpa_session> sessions_{};
  Handles<palpa_data> datas_{};
  Handles<palpa_hand> hands_{};
  Handles<palpa_inverse3> inverse3s_{};
  double now_s_ = 0.0;
  std::vector<unsigned char> message_ = std::vector<unsigned char>(PALPA_MESSAGE_BYTES);
};

}  // namespace palpa::test
