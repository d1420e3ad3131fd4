// Functions for C of an Inverse3 over a WebSocket of the program.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <string_view>

#include "palpa/c.h"
#include "palpa/c/device_limits.h"
#include "palpa/c/failure.h"
#include "palpa/c/message_arguments.h"
#include "palpa/c/sized.h"
#include "palpa/device/inverse3_exchange.h"

struct palpa_inverse3 {
  enum class Socket { none, open, closing };  // of the program, as it was told

  palpa::inverse3::Exchange exchange;
  Socket socket = Socket::none;
  std::uint64_t forces = 0;
  double now_s = -std::numeric_limits<double>::infinity();
};

namespace palpa::c {
namespace {

std::string name_given(const char* text, const char* what, const char* otherwise) {
  if (!text) return otherwise;
  if (!inverse3::is_plain(text))
    throw WrongArgument(std::string(what) + " cannot be; give 1 to 64 letters, digits, '_', '-', '.' and ':'");
  return text;
}

inverse3::ExchangeOptions options_of(const palpa_inverse3_options& given) {
  if (given.force_key < PALPA_FORCE_BY_VERSION || given.force_key > PALPA_FORCE_VALUES)
    throw WrongArgument("force_key is not known; give PALPA_FORCE_BY_VERSION, PALPA_FORCE_VECTOR or PALPA_FORCE_VALUES");
  inverse3::ExchangeOptions options{.device_id = name_given(given.device_id, "device_id", ""),
                                    .profile = name_given(given.profile, "profile", "palpa:palpa"),
                                    .grip_id = name_given(given.grip_id, "grip_id", "")};
  if (given.force_key == PALPA_FORCE_VECTOR) options.word = inverse3::ForceWord::vector;
  if (given.force_key == PALPA_FORCE_VALUES) options.word = inverse3::ForceWord::values;
  if (!options.word && given.version) options.word = inverse3::word_of_version(given.version);
  return options;
}

palpa_probe probe_of(const DeviceState& state) noexcept {
  const Vec3 velocity_m_per_s = state.velocity_m_per_s.value_or(Vec3{});
  const Turn turn = state.turn.value_or(Turn{});
  return {.size = sizeof(palpa_probe),
          .buttons = state.buttons,
          .valid = state.valid,
          .has_velocity = state.velocity_m_per_s.has_value(),
          .position_m = {state.position_m.x, state.position_m.y, state.position_m.z},
          .velocity_m_per_s = {velocity_m_per_s.x, velocity_m_per_s.y, velocity_m_per_s.z},
          .turn = {turn.w, turn.x, turn.y, turn.z}};
}

/// Notes the time of a call. Fault of its arguments, half a sentence; nullptr: none.
const char* problem_with_time(palpa_inverse3* inverse3, double now_s) noexcept {
  if (!inverse3) return "inverse3 is NULL; give one";
  if (!std::isfinite(now_s) || now_s < inverse3->now_s)
    return "now_s is not finite, or earlier than in an earlier call; give the time of a steady clock";
  inverse3->now_s = now_s;
  return nullptr;
}

std::int32_t next_act(palpa_inverse3& inverse3) {
  using Socket = palpa_inverse3::Socket;
  inverse3::Exchange& exchange = inverse3.exchange;
  // Of a connection that a message has ended, before the next is begun.
  const auto must_close = [&] { return inverse3.socket == Socket::open && !exchange.wants_connection(); };
  if (!must_close()) exchange.look(inverse3.now_s);
  if (must_close()) {
    inverse3.socket = Socket::none;
    return PALPA_INVERSE3_CLOSE;
  }
  if (exchange.is_over()) return PALPA_INVERSE3_DONE;
  if (inverse3.socket == Socket::none && exchange.wants_connection()) {
    inverse3.socket = Socket::open;
    exchange.open({});
    return PALPA_INVERSE3_CONNECT;
  }
  if (exchange.due(inverse3.now_s) == inverse3::Exchange::Due::handshake) {
    exchange.say_goodbye();
    inverse3.socket = Socket::closing;
    return PALPA_INVERSE3_CLOSE;
  }
  return PALPA_INVERSE3_NOTHING;
}

}  // namespace
}  // namespace palpa::c

using namespace palpa::c;

extern "C" {

palpa_result palpa_inverse3_limits(palpa_limits* out) {
  constexpr const char* place = "palpa_inverse3_limits";
  if (!out) return fail(PALPA_WRONG_ARGUMENT, place, "out is NULL; give a place for the limits");
  if (!is_known_size<palpa_limits>(out->size))
    return fail(PALPA_WRONG_ARGUMENT, place, "size of out is wrong; set it to sizeof(palpa_limits)");
  put(limits_of(palpa::inverse3::device_limits), out->size, out);
  return PALPA_OK;
}

palpa_inverse3* palpa_inverse3_new(const palpa_inverse3_options* options) {
  return pointer_of("palpa_inverse3_new", [&] {
    if (options && !is_known_size<palpa_inverse3_options>(options->size))
      throw WrongArgument("size of the options is wrong; set it to sizeof(palpa_inverse3_options)");
    const palpa_inverse3_options given = options ? whole(options) : palpa_inverse3_options{};
    return std::make_unique<palpa_inverse3>(palpa::inverse3::Exchange(options_of(given))).release();
  });
}

void palpa_inverse3_free(palpa_inverse3* inverse3) { delete inverse3; }

int32_t palpa_inverse3_look(palpa_inverse3* inverse3, double now_s) {
  constexpr const char* place = "palpa_inverse3_look";
  if (const char* problem = problem_with_time(inverse3, now_s)) return fail(PALPA_WRONG_ARGUMENT, place, problem);
  std::int32_t act = PALPA_INVERSE3_NOTHING;
  const palpa_result result = result_of(place, [&] { act = next_act(*inverse3); });
  return result == PALPA_OK ? act : result;
}

palpa_result palpa_inverse3_take(palpa_inverse3* inverse3, const char* text, size_t bytes, double now_s) {
  constexpr const char* place = "palpa_inverse3_take";
  if (const char* problem = problem_with_time(inverse3, now_s)) return fail(PALPA_WRONG_ARGUMENT, place, problem);
  if (!text && bytes > 0)
    return fail(PALPA_WRONG_ARGUMENT, place, "text is NULL; give one, or 0 bytes for a closed connection");
  bool is_taken = true;
  const palpa_result result = result_of(place, [&] {
    if (text) {
      is_taken = inverse3->exchange.take({text, bytes}, now_s);
    } else {
      inverse3->exchange.lose(now_s);
      inverse3->socket = palpa_inverse3::Socket::none;
    }
  });
  if (result != PALPA_OK || is_taken) return result;
  return fail(PALPA_WRONG_DATA, place, "the message is none of an Inverse Service, or was not asked for; it is passed over");
}

size_t palpa_inverse3_give(palpa_inverse3* inverse3, char* text, size_t room, double now_s) {
  constexpr const char* place = "palpa_inverse3_give";
  using Due = palpa::inverse3::Exchange::Due;
  if (const char* problem = problem_with_room(inverse3, "inverse3 is NULL; give one", text, room))
    return fail(0, place, problem), std::size_t{0};
  if (const char* problem = problem_with_time(inverse3, now_s)) return fail(0, place, problem), std::size_t{0};
  const Due due = inverse3->exchange.due(now_s);
  if (due != Due::message && due != Due::zero) return 0;
  std::size_t bytes = 0;
  result_of(place, [&] {
    const std::string message = inverse3->exchange.message(now_s);
    std::ranges::copy(message, text);
    bytes = message.size();
  });
  return bytes;
}

palpa_result palpa_inverse3_read(palpa_inverse3* inverse3, palpa_probe* out, const char** fault, double now_s) {
  constexpr const char* place = "palpa_inverse3_read";
  if (const char* problem = problem_with_time(inverse3, now_s)) return fail(PALPA_WRONG_ARGUMENT, place, problem);
  if (!out) return fail(PALPA_WRONG_ARGUMENT, place, "out is NULL; give a place for the probe");
  if (!is_known_size<palpa_probe>(out->size))
    return fail(PALPA_WRONG_ARGUMENT, place, "size of out is wrong; set it to sizeof(palpa_probe)");
  const palpa::DeviceState state = palpa::inverse3::state_at(now_s, inverse3->exchange.state());
  put(probe_of(state), out->size, out);
  if (fault) *fault = state.fault;
  return PALPA_OK;
}

palpa_result palpa_inverse3_write(palpa_inverse3* inverse3, const double force_n[3], double now_s) {
  constexpr const char* place = "palpa_inverse3_write";
  if (const char* problem = problem_with_time(inverse3, now_s)) return fail(PALPA_WRONG_ARGUMENT, place, problem);
  if (!force_n) return fail(PALPA_WRONG_ARGUMENT, place, "force_n is NULL; give three numbers");
  inverse3->exchange.write({.force_n = {force_n[0], force_n[1], force_n[2]}, .number = ++inverse3->forces, .time_s = now_s});
  return PALPA_OK;
}

palpa_result palpa_inverse3_end(palpa_inverse3* inverse3, double now_s) {
  constexpr const char* place = "palpa_inverse3_end";
  if (const char* problem = problem_with_time(inverse3, now_s)) return fail(PALPA_WRONG_ARGUMENT, place, problem);
  inverse3->exchange.end(now_s);
  return PALPA_OK;
}
}
