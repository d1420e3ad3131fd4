// Functions for C of the hand's side; also of libpalpa-hand, so of far and guard alone.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>

#include "palpa/c.h"
#include "palpa/c/device_limits.h"
#include "palpa/c/failure.h"
#include "palpa/c/message_arguments.h"
#include "palpa/c/sized.h"
#include "palpa/far/hand_side.h"

struct palpa_hand {
  palpa::HandSide side;
  bool panics = false;
  bool resumes = false;  // in the next tick
  bool reopens = false;  // likewise, at its end
};

namespace palpa::c {
namespace {

HandSideOptions options_of(const palpa_limits& given) {
  HandSideOptions options{
      .device = limits_of(given), .motors = given.has_motors != 0, .token = {}, .dead_man_buttons = given.dead_man_buttons};
  std::ranges::copy(given.token, options.token.begin());
  return options;
}

palpa_command command_of(const HandTick& tick) noexcept {
  const auto put_vector = [](double(&to)[3], const Vec3& v) { to[0] = v.x, to[1] = v.y, to[2] = v.z; };
  palpa_command out{};
  out.guard = static_cast<std::int32_t>(tick.guard);
  out.cause = static_cast<std::int32_t>(tick.cause);
  out.link = static_cast<std::int32_t>(tick.link);
  out.brakes = tick.brakes;
  out.beyond = tick.beyond;
  put_vector(out.force_n, tick.command_n);
  put_vector(out.coupling_n, tick.force_n);
  put_vector(out.proxy_m, tick.proxy_m);
  out.model_age_s = tick.model_age_s;
  out.round_trip_s = tick.round_trip_s;
  return out;
}
static_assert(static_cast<int>(GuardState::off) == PALPA_GUARD_OFF);
static_assert(static_cast<int>(GuardCause::link_closed) == PALPA_CAUSE_LINK_CLOSED);
static_assert(static_cast<int>(LinkState::closed) == PALPA_LINK_CLOSED);
static_assert(static_cast<int>(ModelEvent::Kind::warning) == PALPA_EVENT_WARNING);
static_assert(most_message_bytes == PALPA_MESSAGE_BYTES);

palpa_event event_of(const ModelEvent& event) noexcept {
  palpa_event out{};
  out.kind = static_cast<std::int32_t>(event.kind);
  out.mode = event.mode;
  out.value = event.value;
  out.depth_m = event.depth_m;
  const std::string_view all(event.text.data(), event.text.size());
  copy_utf8(all.substr(0, all.find('\0')), out.text);
  return out;
}

/// Fault of a tick's arguments, half a sentence; nullptr: none.
const char* problem_with_tick(const palpa_hand* hand, const palpa_probe* probe) noexcept {
  if (!hand) return "hand is NULL; give one";
  if (!probe) return "probe is NULL; give one";
  if (!is_known_size<palpa_probe>(probe->size)) return "size of the probe is wrong; set it to sizeof(palpa_probe)";
  return nullptr;
}

}  // namespace
}  // namespace palpa::c

using namespace palpa::c;

extern "C" {

palpa_hand* palpa_hand_new(const palpa_limits* limits) {
  return pointer_of("palpa_hand_new", [&] {
    if (!is_known_size<palpa_limits>(given(limits, "limits").size))
      throw WrongArgument("size of the limits is wrong; set it to sizeof(palpa_limits)");
    return std::make_unique<palpa_hand>(palpa::HandSide(options_of(whole(limits)))).release();
  });
}

void palpa_hand_free(palpa_hand* hand) { delete hand; }

palpa_result palpa_hand_take(palpa_hand* hand, const void* message, size_t bytes) {
  constexpr const char* place = "palpa_hand_take";
  if (!hand) return fail(PALPA_WRONG_ARGUMENT, place, "hand is NULL; give one");
  if (!message && bytes == 0) {
    hand->side.set_connected(false);
    hand->reopens = true;
    return PALPA_OK;
  }
  if (!message) return fail(PALPA_WRONG_ARGUMENT, place, "message is NULL; give one, or 0 bytes for a closed connection");
  if (hand->side.take(message_given(message, bytes))) return PALPA_OK;
  return fail(PALPA_WRONG_DATA, place, "the message is none of a data's side, or an old one; it is passed over");
}

size_t palpa_hand_give(palpa_hand* hand, void* message, size_t room) {
  if (const char* problem = problem_with_room(hand, "hand is NULL; give one", message, room))
    return fail(0, "palpa_hand_give", problem), std::size_t{0};
  return hand->side.give(room_given(message, room));
}

palpa_result palpa_hand_tick(palpa_hand* hand, const palpa_probe* probe, double time_step_s, palpa_command* out) {
  constexpr const char* place = "palpa_hand_tick";
  if (!out) return fail(PALPA_WRONG_ARGUMENT, place, "out is NULL; give a place for the command");
  if (!is_known_size<palpa_command>(out->size))
    return fail(PALPA_WRONG_ARGUMENT, place, "size of out is wrong; set it to sizeof(palpa_command)");
  if (const char* problem = problem_with_tick(hand, probe)) {
    put(command_of({}), out->size, out);
    return fail(PALPA_WRONG_ARGUMENT, place, problem);
  }
  const palpa_probe at = whole(probe);
  const palpa::Vec3 position_m{at.position_m[0], at.position_m[1], at.position_m[2]};
  hand->side.begin({.position_m = position_m, .valid = at.valid != 0, .buttons = at.buttons}, time_step_s);
  std::uint32_t circumstances = hand->panics ? bit_of(palpa::Circumstance::panic) : 0u;
  if (std::exchange(hand->resumes, false)) circumstances |= bit_of(palpa::Circumstance::resume);
  put(command_of(hand->side.feel(circumstances)), out->size, out);
  if (std::exchange(hand->reopens, false)) hand->side.set_connected(true);
  if (!(time_step_s > 0.0 && time_step_s <= 1.0))
    return fail(PALPA_WRONG_ARGUMENT, place, "time_step_s is out of its range; it is above 0 and at most 1");
  if (at.valid != 0 && !is_within(position_m, 1000.0))
    return fail(PALPA_WRONG_ARGUMENT, place, "the probe cannot be used; its position is finite and within 1000 m");
  return PALPA_OK;
}

void palpa_hand_panic(palpa_hand* hand, int32_t on) {
  if (!hand) return;
  hand->resumes = hand->resumes || (hand->panics && on == 0);
  hand->panics = on != 0;
}

size_t palpa_hand_events(palpa_hand* hand, palpa_event* out, size_t room) {
  constexpr const char* place = "palpa_hand_events";
  if (!hand) return fail(0, place, "hand is NULL; give one"), std::size_t{0};
  if (!out) return fail(0, place, "out is NULL; give places for events"), std::size_t{0};
  if (room == 0) return 0;
  const std::uint32_t size = out->size;
  if (!is_known_size<palpa_event>(size))
    return fail(0, place, "size of the first event is wrong; set it to sizeof(palpa_event)"), std::size_t{0};
  auto* to = reinterpret_cast<std::byte*>(out);
  std::size_t taken = 0;
  for (palpa::ModelEvent event; taken < room && hand->side.take_event(event); ++taken, to += size)
    put(event_of(event), size, to);
  return taken;
}
}
