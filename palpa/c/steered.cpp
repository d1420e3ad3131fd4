// Functions for C of hands that the program steers.
#include <chrono>
#include <cmath>
#include <memory>
#include <variant>

#include "palpa/c.h"
#include "palpa/c/device_limits.h"
#include "palpa/c/failure.h"
#include "palpa/c/session_values.h"
#include "palpa/c/sized.h"
#include "palpa/device/mouse_hand.h"
#include "palpa/device/rate_hand.h"

namespace palpa::c {
namespace {

Vec3 vector_of(const double (&xyz)[3]) noexcept {
  const Vec3 given{xyz[0], xyz[1], xyz[2]};
  return is_finite(given) ? given : Vec3{};
}

// Radius [m] of the mouse's workspace, as in the window of palpa-explorer: scenes are about 0.15 m large.
constexpr double pointer_radius_m = 0.4;

/// Hand that moves by ways. Time passes by the program's time steps alone.
struct Mouse {
  MouseHand hand{{.radius_m = pointer_radius_m, .now = []() noexcept { return std::chrono::steady_clock::time_point{}; }}};

  DeviceState read(const palpa_steering& input, double time_step_s) noexcept {
    if (input.is_put != 0) hand.put(vector_of(input.put_m));
    hand.move(vector_of(input.way_m));
    hand.press(input.buttons);
    hand.pass(time_step_s);
    return hand.read();
  }
  void write(const Vec3& force_n) noexcept { hand.write(force_n); }
  DeviceLimits limits() const { return hand.limits(); }
};

/// Hand that a deflection moves.
struct Controller {
  RateHand hand;
  Vec3 force_n;

  DeviceState read(const palpa_steering& input, double time_step_s) noexcept {
    hand.pass(vector_of(input.deflection), force_n, time_step_s);
    return {
        .position_m = hand.position_m(), .velocity_m_per_s = hand.velocity_m_per_s(), .valid = true, .buttons = input.buttons};
  }
  void write(const Vec3& force) noexcept { force_n = is_finite(force) ? force : Vec3{}; }
  DeviceLimits limits() const { return rate_hand_limits(); }
};

palpa_probe probe_of(const DeviceState& state) noexcept {
  palpa_probe probe{
      .buttons = state.buttons, .valid = state.valid, .has_velocity = state.velocity_m_per_s.has_value(), .turn = {1, 0, 0, 0}};
  put_vector(probe.position_m, state.position_m);
  put_vector(probe.velocity_m_per_s, state.velocity_m_per_s.value_or(Vec3{}));
  return probe;
}

}  // namespace
}  // namespace palpa::c

struct palpa_steered {
  std::variant<palpa::c::Mouse, palpa::c::Controller> hand;
};

using namespace palpa::c;

extern "C" {

palpa_steered* palpa_steered_new(int32_t kind, palpa_limits* limits) {
  return pointer_of("palpa_steered_new", [&] {
    if (kind != PALPA_MOUSE && kind != PALPA_CONTROLLER)
      throw WrongArgument("kind is not known; give PALPA_MOUSE or PALPA_CONTROLLER");
    if (limits && !is_known_size<palpa_limits>(limits->size))
      throw WrongArgument("size of the limits is wrong; set it to sizeof(palpa_limits)");
    auto made = std::make_unique<palpa_steered>();
    if (kind == PALPA_CONTROLLER) made->hand.emplace<Controller>();
    if (limits) put(std::visit([](const auto& hand) { return limits_of(hand.limits()); }, made->hand), limits->size, limits);
    return made.release();
  });
}

void palpa_steered_free(palpa_steered* hand) { delete hand; }

palpa_result palpa_steered_read(palpa_steered* hand, const palpa_steering* input, double time_step_s, palpa_probe* out) {
  constexpr const char* place = "palpa_steered_read";
  if (!hand) return fail(PALPA_WRONG_ARGUMENT, place, "hand is NULL; give one");
  if (!input || !is_known_size<palpa_steering>(input->size))
    return fail(PALPA_WRONG_ARGUMENT, place, "input is NULL or of a wrong size; give one with size set");
  if (!out || !is_known_size<palpa_probe>(out->size))
    return fail(PALPA_WRONG_ARGUMENT, place, "out is NULL or of a wrong size; give a place with size set");
  if (!(time_step_s > 0.0 && time_step_s <= 1.0))
    return fail(PALPA_WRONG_ARGUMENT, place, "time_step_s is out of its range; it is above 0 and at most 1");
  const palpa_steering whole_input = whole(input);
  put(std::visit([&](auto& moved) { return probe_of(moved.read(whole_input, time_step_s)); }, hand->hand), out->size, out);
  return PALPA_OK;
}

palpa_result palpa_steered_write(palpa_steered* hand, const double force_n[3]) {
  constexpr const char* place = "palpa_steered_write";
  if (!hand || !force_n) return fail(PALPA_WRONG_ARGUMENT, place, "hand or force_n is NULL; give both");
  std::visit([&](auto& moved) { moved.write({force_n[0], force_n[1], force_n[2]}); }, hand->hand);
  return PALPA_OK;
}
}
