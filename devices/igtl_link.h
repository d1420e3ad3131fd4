// Connection with a server of OpenIGTLink, and the thread that reads a tracker's poses from it.
#pragma once

#include <netinet/in.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "palpa/device/grip_turn.h"
#include "devices/igtl_messages.h"
#include "palpa/device/device.h"
#include "palpa/device/latest.h"

namespace palpa::igtl {

/// Address of a server.
struct Service {
  sockaddr_storage address{};
  socklen_t length = 0;
  std::string words;  ///< 127.0.0.1:18944
  bool is_loopback = true;
};
/// None if the host is no address in digits.
std::optional<Service> service_at(const std::string& host, std::uint16_t port);

/// Names of the transforms that a server sends within half a second; none if there is no server of OpenIGTLink. Blocks.
std::optional<std::vector<std::string>> names_at(const Service& service);

/// Pose of a tracker, as received.
struct Reading {
  Vec3 position_m;  ///< hand frame
  Turn turn;
  double time_s = 0.0;       ///< of arrival
  std::uint64_t number = 0;  ///< [1] from 1; 0: none yet
  const char* fault = nullptr;
};

/// Between readings: each is approached at constant speed over one period, since they come slower than the loop's ticks. Late
/// by one period. Allocates nothing; one thread.
class ReadingWalk {
 public:
  /// State at a time [s], never decreasing; the reading is the latest, new or repeated.
  DeviceState at(double time_s, const Reading& reading) noexcept;

 private:
  std::uint64_t number_ = 0;
  double period_s_ = 0.02;
  double read_s_ = 0.0, arrived_s_ = 0.0;
  Vec3 from_m_, to_m_;
  GripTurn turn_;
};

/// Reads the poses of one tracker on a thread of its own; reconnects after a loss. `read` is for one thread, and never
/// allocates, locks, throws or blocks.
class TrackerLink {
 public:
  /// \param name  of the tracker's transform; empty: the first that comes
  /// \param here  the hand frame begins where the tracker is first; false: at the origin of its RAS frame
  TrackerLink(const Service& service, const std::string& name, bool here);
  ~TrackerLink();  ///< blocks for 50 ms at most
  TrackerLink(const TrackerLink&) = delete;
  TrackerLink& operator=(const TrackerLink&) = delete;

  DeviceState read() noexcept;
  /// Blocks until the first pose. False: timeout.
  bool wait(double longest_s);
  /// Name of the transform; empty before the first.
  std::string name() const;
  /// Names of transforms that came, for a sentence.
  std::vector<std::string> names() const;

 private:
  void run() noexcept;
  void listen_to(int socket);
  void take(const Head& head, std::span<const std::byte> body);
  void publish(const char* fault) noexcept;

  const Service service_;
  const bool begins_here_;
  Latest<Reading> readings_;
  ReadingWalk walk_;  // of the reading thread
  std::atomic<bool> has_pose_{false}, ends_{false};

  mutable std::mutex mutex_;  // of the names; `read` never takes it
  std::string name_;
  std::vector<std::string> names_;

  // Of the link's thread.
  MessageStream stream_;
  Reading now_;
  std::uint64_t poses_ = 0;
  std::optional<Vec3> origin_m_;
  std::thread thread_;
};

}  // namespace palpa::igtl
