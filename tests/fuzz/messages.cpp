// Messages of a far hand, cut, flipped, repeated, late and hostile, against its promises (docs/far.md).
#include <cmath>
#include <deque>

#include "palpa/far/hand_side.h"
#include "tests/fuzz/campaigns.h"

namespace palpa::test {
extern thread_local long allocations;  // of ticks.cpp
}

namespace palpa::fuzz {
namespace {

constexpr double most_n = 3.3;

using Bytes = std::vector<std::byte>;

Bytes model_message(Choices& choices, std::uint64_t newest, std::uint32_t scene, double reach_m) {
  ModelUpdate model;
  model.answers = choices.one_in(20) ? choices.below(1u << 30) : newest > 3 ? newest - choices.below(3) : newest;
  model.scene = choices.one_in(50) ? static_cast<std::uint32_t>(choices.below(10)) : scene;
  model.echo_us = choices.below(1u << 30);
  const auto vector = [&](double most) {
    return Vec3{choices.between(-most, most), choices.between(-most, most), choices.between(-most, most)};
  };
  model.proxy_m = vector(choices.one_in(30) ? 1e6 : reach_m);
  model.count = static_cast<std::uint16_t>(choices.below(choices.one_in(10) ? ModelUpdate::most_rows + 1 : 6));
  for (std::int32_t n = 0; n < model.count; ++n) {
    ModelRow& row = model.rows[static_cast<std::size_t>(n)];
    row.kind = static_cast<PrimitiveKind>(choices.below(5));
    row.rides = choices.one_in(3), row.is_facet = choices.one_in(4);
    row.mode = static_cast<std::uint16_t>(choices.below(4)), row.slot = static_cast<std::uint16_t>(choices.below(8));
    row.plane = static_cast<std::int32_t>(choices.below(static_cast<std::uint64_t>(n) + 1)) - 1;
    row.strength_n = static_cast<float>(choices.one_in(20) ? choices.log_between(1.0, 1e9) : choices.between(0.0, 5.0));
    row.drag_ns_per_m = static_cast<float>(choices.one_in(4) ? choices.log_between(1e-3, 1e9) : 0.0);
    if (choices.one_in(4)) row.stiffness_n_per_m = static_cast<float>(choices.log_between(1e-11, 1e9));
    row.coefficient = static_cast<float>(choices.between(0.0, 2.0));
    row.offset_m = vector(choices.one_in(20) ? 1e3 : 0.01);
    row.direction = row.kind == PrimitiveKind::point ? Vec3{} : normalized(vector(1.0) + Vec3{1e-6, 0.0, 0.0});
    if (choices.one_in(10)) row.velocity_m_per_s = vector(50.0);
  }
  Bytes bytes(most_message_bytes);
  bytes.resize(write_message(model, choices.below(1u << 30), bytes));
  return bytes;
}

Bytes welcome_message(Choices& choices, std::uint32_t scene) {
  DataWelcome welcome;
  welcome.scene = scene;
  welcome.stiffness_n_per_m = choices.one_in(10) ? choices.log_between(1e-6, 1e8) : 500.0;
  welcome.damping_ns_per_m = choices.one_in(3) ? choices.between(0.0, 5.0) : 0.0;
  welcome.max_force_n = choices.one_in(10) ? choices.log_between(1e-3, 1e8) : 3.0;
  welcome.impact_ns_per_m = choices.one_in(3) ? choices.between(0.0, 50.0) : 0.0;
  Bytes bytes(most_message_bytes);
  bytes.resize(write_message(welcome, 1, bytes));
  return bytes;
}

void damage(Choices& choices, Bytes& bytes) {
  if (bytes.empty()) return;
  switch (choices.below(12)) {
    case 8: bytes.resize(choices.below(bytes.size())); break;
    case 9: bytes[choices.below(bytes.size())] ^= static_cast<std::byte>(1u << choices.below(8)); break;
    case 10: bytes.resize(bytes.size() + choices.below(64), std::byte{0x5a}); break;
    case 11:
      for (std::uint64_t n = choices.below(16); n > 0; --n)
        bytes[choices.below(bytes.size())] = static_cast<std::byte>(choices.below(256));
      break;
    default: break;
  }
}

std::string broken_by(const HandTick& tick) {
  if (!is_finite(tick.command_n) || !is_finite(tick.force_n) || !is_finite(tick.proxy_m)) return "a value is not finite";
  if (norm(tick.command_n) > most_n) return "the command exceeds the limit";
  return {};
}

Tried fed(Choices& choices, const fs::path&) {
  const std::uint64_t count = 1 + choices.below(2000);
  HandSideOptions options{.device = {.max_force_n = most_n}, .motors = choices.one_in(2)};
  HandSide hand(options);
  std::deque<Bytes> sent;
  Tried result;
  std::uint32_t scene = 1;
  std::uint64_t newest = 0;
  Bytes room(most_message_bytes);
  Vec3 probe_m;
  const double reach_m = choices.log_between(1e-3, 0.2);
  for (std::uint64_t n = 0; n < count && result.broken.empty(); ++n) {
    probe_m += choices.between(0.0, 1e-3) * Vec3{choices.between(-1, 1), choices.between(-1, 1), choices.between(-1, 1)};
    HandSample sample{.position_m = probe_m, .valid = !choices.one_in(200)};
    if (choices.one_in(500)) sample.position_m.x = std::numeric_limits<double>::quiet_NaN();
    if (choices.one_in(300)) scene += choices.one_in(2);
    Bytes message = n == 0 || choices.one_in(200)         ? welcome_message(choices, scene)
                    : !sent.empty() && choices.one_in(20) ? sent[choices.below(sent.size())]
                                                          : model_message(choices, newest, scene, reach_m);
    damage(choices, message);
    const long before = test::allocations;
    hand.begin(sample, choices.one_in(500) ? 0.0 : 1e-3);
    ++newest;
    while (hand.give(room) > 0) {
    }
    hand.take(message);
    const HandTick tick = hand.feel();
    ModelEvent event;
    hand.take_event(event);
    result.broken = test::allocations != before ? "the hand's side allocates" : broken_by(tick);
    if (choices.one_in(1000)) hand.set_connected(choices.one_in(2));
    ++result.tries;
    sent.push_back(std::move(message));
    if (sent.size() > 8) sent.pop_front();
  }
  if (!result.broken.empty()) result.broken += ": message " + std::to_string(result.tries);
  return result;
}

// A hand on a wall whose models come through a link of any delay, until none comes any more: no force 150 ms after the usual
// age of a model.
Tried cut_off(Choices& choices, const fs::path&) {
  constexpr double dt_s = 1e-3;
  HandSideOptions options{.device = {.max_force_n = most_n}, .motors = choices.one_in(2)};
  HandSide hand(options);
  Bytes room(most_message_bytes);
  hand.take({room.data(), write_message(DataWelcome{.scene = 1, .stiffness_n_per_m = 500.0, .max_force_n = most_n}, 1, room)});
  const std::uint64_t delay = choices.below(60), jitter = choices.below(1 + delay / 4), pause = 1 + choices.below(20);
  const std::uint64_t end = (options.motors ? 1000 : 300) + choices.below(200);
  double usual_s = 0.0;
  std::uint64_t arrives = 0;
  ModelUpdate model{.scene = 1, .count = 1};
  model.rows[0] = {.kind = PrimitiveKind::plane, .strength_n = 3.0f, .direction = {0.0, 0.0, 1.0}};
  Tried result{.tries = 1};
  for (std::uint64_t n = 1; n < end + 400 && result.broken.empty(); ++n) {
    hand.begin({.position_m = {0.0, 0.0, -0.002}}, dt_s);
    while (hand.give(room) > 0) {
    }
    if (n > delay + jitter && n >= arrives && n < end) {
      model.answers = n - delay - choices.below(jitter + 1);
      arrives = n + 1 + choices.below(pause);
      hand.take({room.data(), write_message(model, n, room)});
    }
    const HandTick tick = hand.feel();
    if (n < end && n + 100 > end) usual_s = std::max(usual_s, tick.model_age_s);
    if (n + 1 == end && norm(tick.command_n) < 0.1) result.broken = "no force with models";
    if (n > end && tick.model_age_s > usual_s + 0.15 && tick.command_n != Vec3{}) result.broken = "a force without models";
  }
  return result;
}

}  // namespace

void add_messages(std::vector<Campaign>& to) {
  to.push_back(
      {.name = "outage", .of = "outages", .long_tries = 1'000'000, .begin = [](const fs::path&) { return Attempt(cut_off); }});
  to.push_back(
      {.name = "message", .of = "messages", .long_tries = 10'000'000, .begin = [](const fs::path&) { return Attempt(fed); }});
}

}  // namespace palpa::fuzz
