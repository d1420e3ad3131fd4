// Messages between the hand's side and the data's side of a session whose data are far from the hand.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "palpa/guard/guard_state.h"
#include "palpa/solver/primitives.h"

namespace palpa {

/// Every message begins with a head of 16 bytes: u16 version, u8 kind, u8 zero, u32 bytes of the whole message, u64 time [µs]
/// by the sender's clock. All numbers are little endian, floating point as IEEE 754, lengths in metres of the hand. The layout
/// of each kind is in docs/far.md.
struct MessageHead {
  enum class Kind : std::uint8_t { hello = 1, welcome, probes, model, event };
  Kind kind = Kind::hello;
  std::uint32_t bytes = 0;
  std::uint64_t time_us = 0;
};

inline constexpr std::uint16_t message_version = 1;
/// [bytes] Longest message. Longer: a hostile peer takes memory; shorter: fewer rows.
inline constexpr std::size_t most_message_bytes = 4096;

/// Head of a message; none if it is no message of this version, or its length is not that of its head. Any thread.
std::optional<MessageHead> head_of(std::span<const std::byte> message) noexcept;

/// First message of the hand's side.
struct HandHello {
  enum class Role : std::uint8_t { touch = 1, watch };
  std::array<std::uint8_t, 16> token{};
  Role role = Role::touch;
  double max_force_n = 0.0;            ///< >= 0: of the device, as the next three
  double max_stiffness_n_per_m = 0.0;  ///< >= 0
  double max_damping_ns_per_m = 0.0;   ///< >= 0
  double encoder_step_m = 0.0;         ///< >= 0
  std::array<char, 32> name{};         ///< of the device, for a person: UTF-8, ends at the first zero, or after all
};

/// Answer of the data's side, at the beginning and at each change of the scene.
struct DataWelcome {
  static constexpr std::size_t most_modes = 64;    ///< [1] with names
  static constexpr std::size_t most_letters = 32;  ///< [1] bytes of a name, cut off at that
  using Name = std::array<char, most_letters>;     ///< UTF-8, ends at the first zero, or after all
  std::uint32_t scene = 0;                         ///< number, another one after each change
  double stiffness_n_per_m = 0.0;                  ///< > 0: k, within the device's limits
  double damping_ns_per_m = 0.0;                   ///< >= 0: D, likewise
  double max_force_n = 0.0;                        ///< >= 0: of the scene
  double impact_ns_per_m = 0.0;                    ///< >= 0: gain of pulses at contact
  std::uint16_t modes = 0;                         ///< [1] at most `most_modes`
  std::array<Name, most_modes> names{};
};

/// Last positions of the probe, and what the hand felt.
struct ProbeReport {
  /// Position at a tick of the hand's side.
  struct Sample {
    Vec3 position_m;
    float time_step_s = 0.0f;  ///< (0, 1]: since the one before
    std::uint32_t buttons = 0;
    bool valid = false;
  };
  static constexpr std::size_t most_samples = 4;  ///< [1] so that three lost messages lose no position
  std::uint64_t newest = 0;                       ///< number of the last sample; those before have the numbers before
  std::uint8_t count = 0;                         ///< [1] of samples, at least 1
  std::array<Sample, most_samples> samples{};     ///< oldest first
  Vec3 proxy_m;                                   ///< that was felt
  Vec3 command_n;                                 ///< sent to the motors
  Vec3 command_nm;                                ///< likewise
  GuardState guard = GuardState::pass;
  GuardCause cause = GuardCause::none;
  float model_age_s = 0.0f;   ///< >= 0
  std::uint64_t model = 0;    ///< `ModelUpdate::answers` of the last model; 0: none
  std::uint64_t echo_us = 0;  ///< time of that model's message, by the clock of the data's side
  float held_s = 0.0f;        ///< >= 0: between its arrival and this message
  float account_j = 0.0f;     ///< `HandTick::account_j`
  float link_total_j = 0.0f;  ///< `HandTick::link_j` of all ticks so far
};

/// Row of a model: a primitive.
struct ModelRow {
  PrimitiveKind kind = PrimitiveKind::plane;
  bool rides = false;     ///< lies at the proxy (`PlacedPrimitive::rides`)
  bool ahead = false;     ///< of a level that the look-ahead has met, not yet of the session
  bool is_facet = false;  ///< further facet of the corner in the row before
  std::uint16_t mode = 0;
  std::uint16_t slot = 0;
  std::int32_t plane = -1;     ///< row of the plane of a friction line, before it; -1: none
  float strength_n = 0.0f;     ///< >= 0
  float drag_ns_per_m = 0.0f;  ///< >= 0
  float stiffness_n_per_m = std::numeric_limits<float>::infinity();  ///< > 0; infinity: rigid
  float coefficient = 0.0f;                                          ///< [1] >= 0, of a friction line
  Vec3 offset_m;                                                     ///< position less the model's proxy
  Vec3 direction;                                                    ///< [1] of unit length; zero of a point
  Vec3 velocity_m_per_s{};                                           ///< of moving data, by component at most `fastest`
  static constexpr double fastest_m_per_s = 100.0;                   ///< beyond it a level jumps
};

/// Local model of what is felt: the primitives of the data's last sub-step.
struct ModelUpdate {
  static constexpr std::size_t most_rows = 64;
  std::uint64_t answers = 0;  ///< number of the probe's sample that it was made for
  std::uint32_t scene = 0;    ///< number of the scene
  std::uint64_t echo_us = 0;  ///< time of the message with that sample, by the hand's clock
  float held_s = 0.0f;        ///< >= 0: between the arrival of that message and this one
  float ahead_s = 0.0f;       ///< >= 0: look-ahead
  float valid_m = 0.0f;       ///< >= 0: way of the proxy within which the model holds
  Vec3 proxy_m;               ///< of the session
  std::uint16_t count = 0;    ///< [1] of rows, at most `most_rows`
  std::array<ModelRow, most_rows> rows{};
};

/// Event of the session.
struct ModelEvent {
  enum class Kind : std::uint8_t { onset, break_through, fault, warning };
  static constexpr std::size_t most_letters = 120;  ///< [1] bytes of a sentence, cut off at that
  Kind kind = Kind::warning;
  std::int32_t mode = -1;                 ///< number; -1: the session
  std::uint64_t sample = 0;               ///< number of the probe's sample of its tick
  double value = 0.0;                     ///< level, in the field's own unit
  float depth_m = 0.0f;                   ///< >= 0: of a break-through
  std::array<char, most_letters> text{};  ///< UTF-8, as a name
};

/// Writes a message with its head. Returns its length [bytes]; 0: it does not fit, or has more samples, rows or modes than
/// there may be. No allocation; any thread.
/// \param time_us  [µs] by the sender's clock
std::size_t write_message(const HandHello& hello, std::uint64_t time_us, std::span<std::byte> to) noexcept;
std::size_t write_message(const DataWelcome& welcome, std::uint64_t time_us, std::span<std::byte> to) noexcept;
std::size_t write_message(const ProbeReport& report, std::uint64_t time_us, std::span<std::byte> to) noexcept;
std::size_t write_message(const ModelUpdate& model, std::uint64_t time_us, std::span<std::byte> to) noexcept;
std::size_t write_message(const ModelEvent& event, std::uint64_t time_us, std::span<std::byte> to) noexcept;

/// Reads a message of any origin. False, with an unspecified result within the ranges, if it is none of this kind, too short or
/// too long, or a number in it is not finite or beyond its range: a hostile peer can send wrong values, never unusable ones.
/// Directions are made unit again. No allocation; any thread.
bool read_message(std::span<const std::byte> message, HandHello& hello) noexcept;
bool read_message(std::span<const std::byte> message, DataWelcome& welcome) noexcept;
bool read_message(std::span<const std::byte> message, ProbeReport& report) noexcept;
bool read_message(std::span<const std::byte> message, ModelUpdate& model) noexcept;
bool read_message(std::span<const std::byte> message, ModelEvent& event) noexcept;

}  // namespace palpa
