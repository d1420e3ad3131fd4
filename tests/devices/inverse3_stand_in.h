// A stand-in for the Haply Inverse Service with an Inverse3, with faults on request.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "palpa/solver/pose.h"

namespace palpa::test {

/// Sends a snapshot at each connection, then one state for each message. Forces and positions are the service's own: x to the
/// right, y away from the user, z up. GET /version is answered on the same port. A force ends after 50 ms without a message,
/// with its connection, and without power. Thread-safe.
class Inverse3StandIn {
 public:
  /// Manner of an answer. The snapshot is always sent whole and at once.
  enum class Manner : std::uint8_t {
    whole,
    fragments,    ///< of seven bytes
    pings,        ///< a ping before and behind each answer
    paced,        ///< 1 ms after the last answer, if that is later
    slow,         ///< after 40 ms
    drip,         ///< a byte each 5 ms
    silent,       ///< not at all
    flood,        ///< repeated, also unasked
    twice,        ///< and again, unasked
    binary,       ///< as bytes, not as text
    huge,         ///< a frame with a declared length of 2^40 bytes, and a megabyte of it
    endless,      ///< fragments without a last one
    wrong_frame,  ///< a frame of an undefined kind
    goes_away,    ///< a close frame with the code 1001 instead
    hangs_up,     ///< the end of the connection instead
  };
  /// \param port  0: chosen by the system
  explicit Inverse3StandIn(std::uint16_t port = 0);
  ~Inverse3StandIn();
  Inverse3StandIn(const Inverse3StandIn&) = delete;
  Inverse3StandIn& operator=(const Inverse3StandIn&) = delete;

  std::uint16_t port() const;  ///< kept across `start`

  // ---- the device ----

  void hold(const Vec3& position_m, const Vec3& velocity_m_per_s);
  Vec3 force_n();
  Vec3 last_word_n();        ///< the last force sent to it, on any connection
  bool is_second_touched();  ///< true after a force to another device
  void turn_power(bool on);
  void calibrate(bool done);
  void connect_device(bool there);
  void connect_second_device(bool there);  ///< "0BEE", before the first device, "049D", in the list
  void scale_forces(double factor);        ///< [1] POST /settings/devices/force_scale of the service
  void press_wired(bool down);             ///< the button of a verse_grip
  void press_wireless(int number, bool down);
  /// Orientation of the wireless grip, w, x, y, z about the service's axes. It shows in messages at the grip's own rate, 50 Hz.
  void turn_grip(const Turn& turn);
  void connect_grip(bool there);      ///< the wireless one, in the list
  void tell_grip_is_gone(bool gone);  ///< it stays in the list, with its status "connected" false and its buttons unchanged

  // ---- the service ----

  void set_version(const std::string& version);  ///< reported by GET /version; empty: no such page
  void understand(bool vector, bool values);
  void tell_all(bool all);  ///< false: unchanged entries are left out
  void send(Manner manner);
  /// Every sent text goes through `change`; none: unchanged.
  void change_texts(std::function<std::string(const std::string&)> change, bool snapshots_too = false);
  void stop();
  void start();

  // ---- received ----

  struct Received {
    Vec3 force_n;       ///< zero: none
    double reaction_s;  ///< since the last bytes were sent to this connection
  };
  /// Calls `watch` in its own thread for every message.
  void watch(std::function<void(const Received&)> watch);
  std::vector<std::string> first_messages();  ///< of each connection that sent one
  std::vector<std::string> last_messages(std::size_t most);
  std::int64_t messages();
  std::int64_t good_byes();    ///< close frames with the code 1000
  std::int64_t connections();  ///< open now

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

}  // namespace palpa::test
