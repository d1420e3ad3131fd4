// Exchange of messages with an Inverse Service on its caller's clock: states, faults and the messages that are due. Without a
// socket, a thread or a clock, so one set of rules serves every program that has them.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/device/device.h"
#include "palpa/device/grip_turn.h"
#include "palpa/device/inverse3_messages.h"

namespace palpa::inverse3 {

/// Limits of an Inverse3. No data sheet was available. Force: others clip at 2 to 10 N; larger: the motors may overheat;
/// smaller: walls feel soft. Stiffness: other programs' tutorials use 400 to 1000 N/m; larger: a wall may vibrate; smaller: it
/// feels soft. Radius, of the arm's ball about the origin: larger: scenes reach beyond it; smaller: unused reach.
inline constexpr DeviceLimits device_limits{.max_force_n = 3.0, .max_stiffness_n_per_m = 800.0, .workspace_radius_m = 0.1};

/// Age at which a force is no longer sent [s]. Longer: a hung program pushes longer; shorter: a busy machine's pause drops the
/// force.
inline constexpr double force_lifetime_s = 0.02;
/// Age at which a state is invalid [s], even if the exchange is not called. Must exceed the idle interval plus the answer's
/// deadline. Longer: stale positions count; shorter: a busy machine's pause is a fault.
inline constexpr double state_lifetime_s = 0.05;
/// An answer takes about 1e-4 s. Longer: an old force is held longer; shorter: a busy machine's pause is a fault. [s]
inline constexpr double answer_deadline_s = 0.01;
/// For the final zero force and the closing handshake [s]. Longer: with a silent service the program ends later; shorter: a
/// slow service gets no handshake.
inline constexpr double end_deadline_s = 0.25;
/// Consecutive answers in time before states and forces are used, initially and after a late answer. More: later back; fewer:
/// an unsteady service causes a stuttering force.
inline constexpr int answers_to_trust = 10;

/// Service and device of an exchange.
struct ExchangeOptions {
  std::string device_id;          ///< plain; empty: the first Inverse3 that the service lists, from then on that one
  std::optional<ForceWord> word;  ///< none: by the service's version
  std::string profile;            ///< of plain characters: name of the session for the service
  std::string grip_id;            ///< of the grip that is the handle; empty: the first with an orientation
};

/// Force that a program wants.
struct WrittenForce {
  Vec3 force_n;
  std::uint64_t number = 0;  ///< that grows with each force
  double time_s = 0.0;       ///< of its request
};

/// The force, within the device's limit; zero if not finite. Any thread; allocates nothing.
inline Vec3 limited_force_n(const Vec3& force_n) noexcept {
  return is_finite(force_n) ? shortened(force_n, device_limits.max_force_n) : Vec3{};
}

/// The state at a time [s]: one that is too old has no position and no buttons. Any thread; allocates nothing.
DeviceState state_at(double time_s, DeviceState state) noexcept;

/// One device at one service, across connections. Never two messages at once; zero force while there is a fault, and as the
/// last message. Its owner opens a connection while `wants_connection()`, passes on its events, drops it when that is no longer
/// so, and calls `look` every few milliseconds. Times [s] are of one steady clock; an earlier one than the last counts as the
/// last. A pause of the caller is found at the next call. Throws std::bad_alloc alone; one thread.
class Exchange {
 public:
  explicit Exchange(ExchangeOptions options);

  // ---- events ----

  /// The connection is open. \param word_of_version  key of the force by the service's version; none: unknown
  void open(std::optional<ForceWord> word_of_version) noexcept;
  /// A complete message of the connection. False: refused; after several in a row the connection is no longer wanted.
  bool take(std::string_view text, double time_s);
  /// The connection was refused, closed or broken.
  void lose(double time_s);
  /// A force, to be sent with the next message if that is not too late.
  void write(const WrittenForce& force) noexcept;
  /// Begins the end: zero force at once, then the closing handshake.
  void end(double time_s) noexcept;
  /// Deadlines: may begin a connection, or end it.
  void look(double time_s);

  // ---- what is to be done ----

  bool wants_connection() const noexcept { return is_connected_; }
  /// Whether the version of the service is of use.
  bool wants_version() const noexcept { return !options_.word; }
  /// The end is complete: nothing is to be done any more.
  bool is_over() const noexcept { return is_over_; }

  enum class Due : std::uint8_t {
    nothing,
    message,   ///< `message`, once all messages that have come were taken: the next that comes is its answer
    zero,      ///< `message`, at once
    handshake  ///< `say_goodbye`, and the closing handshake of the connection
  };
  /// To be sent, once the last message is written.
  Due due(double time_s) const noexcept;
  /// The message, which counts as sent.
  std::string message(double time_s);
  void say_goodbye() noexcept;

  // ---- state ----

  /// As of the last event.
  const DeviceState& state() const noexcept { return state_; }
  /// Changes of the state.
  std::uint64_t states() const noexcept { return states_; }
  /// Answers are in time.
  bool is_linked() const noexcept { return has_view_ && answers_in_time_ == answers_to_trust; }
  /// A usable state or a fault that needs the user has been reached.
  bool is_settled() const noexcept { return is_settled_; }
  /// Number of the last force written before the motors certainly had none.
  std::uint64_t resting_number() const noexcept { return resting_number_; }

 private:
  /// Time for which the motors have not rendered the sent force.
  class MissingForce {
   public:
    void note(const Vec3& sent_n, const std::optional<Vec3>& reported_n, double since_last_s) noexcept;
    bool is_too_long() const noexcept;

   private:
    double time_s_ = 0.0;
  };
  enum class End : std::uint8_t { none, wanted, at_rest, said };  // at rest: zero force sent; said: closing handshake sent

  void advance(double time_s) noexcept;
  double later(double time_s) const noexcept;
  void begin();
  void lose(const char* why);
  void look_at_age();
  bool read(std::string_view text);
  bool take_first(std::string_view text);
  bool take_answer(std::string_view text);
  bool refuse(const char* why);
  void note_grips();
  void note_turn();
  void note_use(const ServiceGrip& grip);
  bool has_lost_grip() const noexcept;
  bool is_anything_due(double now_s) const noexcept;
  Vec3 force_to_send_n() const noexcept;
  const char* fault() const noexcept;
  void publish() noexcept;

  const ExchangeOptions options_;
  std::string device_id_;  // empty: not listed yet
  double now_s_ = -std::numeric_limits<double>::infinity();

  bool is_connected_ = false;  // or connecting
  bool is_over_ = false;
  End end_ = End::none;
  const char* fault_of_link_;   // until enough answers are in time
  bool has_view_ = false;       // the first message has been read
  bool is_named_ = false;       // the session's profile was sent
  bool is_awaiting_ = false;    // of an answer
  bool has_new_force_ = false;  // since the last message
  bool is_settled_ = false;
  int answers_in_time_ = 0;  // consecutive
  int refused_ = 0;          // consecutive
  DeviceState state_;
  std::uint64_t states_ = 0;
  ForceWord word_ = ForceWord::vector;
  ServiceView view_;
  std::vector<ServiceGrip> used_grips_;  // with buttons pressed, or turned as the handle, since construction
  std::optional<ServiceGrip> handle_;    // grip whose orientation is the handle's, as first seen
  GripTurn handle_turn_;
  WrittenForce written_;
  Vec3 sent_n_;
  std::uint64_t sent_number_ = 0;  // of the force sent last
  std::uint64_t resting_number_ = 0;
  MissingForce missing_force_;
  double began_s_ = now_s_, ended_s_ = now_s_, sent_s_ = now_s_, answered_s_ = 0.0;
};

}  // namespace palpa::inverse3
