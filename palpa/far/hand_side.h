// The hand's side of a session whose data are far: forces of the newest local model, at the hand's own rate.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "palpa/device/device.h"
#include "palpa/far/message.h"
#include "palpa/guard/guard_state.h"

namespace palpa {

/// Device and rights of a hand.
struct HandSideOptions {
  DeviceLimits device;  ///< limits of the device
  bool motors = true;   ///< a person holds the device; false: a simulated hand, with the force limit alone
  std::array<std::uint8_t, 16> token{};
  std::uint32_t dead_man_buttons = 0;  ///< one of these must be held; 0: none
  std::array<char, 32> name{};         ///< of the device, for a person at the data's side: UTF-8, filled up by zeros
};

/// Probe of a tick of the hand's side, in the hand frame.
struct HandSample {
  Vec3 position_m;
  bool valid = true;  ///< false: the device has no position
  std::uint32_t buttons = 0;
};

/// Link between hand and data.
enum class LinkState : std::uint8_t {
  waiting,  ///< no model yet
  up,       ///< models arrive
  stale,    ///< the newest model is older than usual by 100 ms: no force
  closed,   ///< no connection, or a model of an unknown scene: no force
};

/// "waiting", …
const char* name_of(LinkState state) noexcept;

/// Result of one tick of the hand's side.
struct HandTick {
  Vec3 proxy_m;    ///< of the model
  Vec3 force_n;    ///< coupling force (Eq. 1) of the felt extension, before impact and guard
  Vec3 command_n;  ///< for the motors
  GuardState guard = GuardState::waiting;
  GuardCause cause = GuardCause::start;
  bool brakes = false;  ///< the device's brake should hold the hand
  LinkState link = LinkState::waiting;
  double model_age_s = 0.0;   ///< since the probe that the model answers
  double round_trip_s = 0.0;  ///< of the link, mean of the last second
  bool beyond = false;        ///< the proxy is further off than the model is valid
  Vec3 offset_m;              ///< part of the felt extension that spreads updates of the model
  double account_j = 0.0;     ///< of the energy account; below zero: debt
  // Energy ledger of the felt spring in this tick (docs/theory.md 11): work_j = −change of stored_j + sampling_j + model_j +
  // link_j − released_j.
  double work_j = 0.0;      ///< on the hand, of the spring's force held since the last tick
  double stored_j = 0.0;    ///< k/2 |felt extension|² after the tick
  double sampling_j = 0.0;  ///< k/2 |step of the probe|²: zero-order hold
  double model_j = 0.0;     ///< given by the model; below zero: taken
  double link_j = 0.0;      ///< given by the spread of updates; below zero: taken
  double released_j = 0.0;  ///< lost where contact restarts
};

/// Balances the newest model with its own probe, couples, guards. Bytes in, bytes out: no socket, clock or thread; time passes
/// by the ticks' steps. Construction allocates; nothing else allocates, throws, locks or blocks; finite, limited commands for
/// any messages. One thread.
///
/// In each tick, in this order: `begin`, messages out by `give`, messages in by `take`, `feel`. Messages that arrive later are
/// felt in the next tick.
class HandSide {
 public:
  explicit HandSide(const HandSideOptions& options);
  ~HandSide();
  HandSide(HandSide&&) noexcept;
  HandSide& operator=(HandSide&&) noexcept;

  /// Begins a tick with a new sample of the probe.
  /// \param time_step_s  [s] since the last tick; (0, 1]. Any other value, or a position that is not finite: an invalid sample
  void begin(const HandSample& sample, double time_step_s) noexcept;
  /// Writes the next message for the data's side; call until 0. The first is a hello; after the welcome reports, one in 1 to 3
  /// ms by the round trip, or for each four samples from 0.6 ms on. Returns its length [bytes]; 0: none.
  /// \param to  at least `most_message_bytes`
  std::size_t give(std::span<std::byte> to) noexcept;
  /// Takes a message of the data's side, of any origin. False if it is none, damaged, or older than one taken before.
  bool take(std::span<const std::byte> message) noexcept;
  /// Ends the tick: the command for the motors.
  /// \param circumstances  bits of Circumstance
  HandTick feel(std::uint32_t circumstances = 0) noexcept;

  /// The connection is open, as at the beginning, or closed: no force. Opened again it begins with a hello.
  void set_connected(bool connected) noexcept;
  /// Takes the oldest event not yet taken. False: none. At most 64 are kept, the newest.
  bool take_event(ModelEvent& event) noexcept;
  /// Last welcome; its `scene` is 0 before the first.
  const DataWelcome& welcome() const noexcept;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace palpa
