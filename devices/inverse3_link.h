// Thread that communicates with an Inverse Service; the haptic thread only reads and writes two values.
#pragma once

#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <memory>
#include <optional>
#include <string>

#include "devices/inverse3_messages.h"
#include "palpa/device/device.h"

namespace palpa::inverse3 {

/// Force limit for an Inverse3. No data sheet was available: others clip at 2 to 10 N. Larger: the motors may overheat;
/// smaller: walls feel soft.
inline constexpr double max_force_n = 3.0;

struct LinkOptions {
  boost::asio::ip::tcp::endpoint service;
  std::string device_id;
  std::optional<ForceWord> word;  ///< none: by the service's version
  std::string profile;            ///< of plain characters
  std::string grip_id;            ///< of the grip that is the handle; empty: the first with an orientation
};

/// Exchanges force for state at the rate of writes and answers, on its own thread, never two messages at once; reconnects after
/// a loss of service or device. `read` and `write` are for one thread and never allocate, lock, throw or block.
class Link {
 public:
  explicit Link(const LinkOptions& options);
  ~Link();  ///< sends zero force; blocks for 0.5 s at most
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  DeviceState read() noexcept;
  bool write(const Vec3& force_n) noexcept;
  bool rests() const noexcept;  ///< as in Device
  /// Blocks until a usable state or a fault that needs the user. False: timeout.
  bool wait(double longest_s);

 private:
  class Exchange;
  std::unique_ptr<Exchange> exchange_;
};

/// Snapshot of a service. None: no valid answer within 1 s.
std::optional<View> look(const boost::asio::ip::tcp::endpoint& service);

}  // namespace palpa::inverse3
