// Thread that communicates with an Inverse Service; the haptic thread only reads and writes two values.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <memory>
#include <optional>
#include <string>

#include "palpa/device/device.h"
#include "palpa/device/inverse3_exchange.h"

namespace palpa::inverse3 {

struct LinkOptions {
  boost::asio::ip::tcp::endpoint service;
  ExchangeOptions exchange;
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
  class Driver;
  std::unique_ptr<Driver> driver_;
};

/// Snapshot of a service. None: no valid answer within 1 s.
std::optional<ServiceView> look(const boost::asio::ip::tcp::endpoint& service);

}  // namespace palpa::inverse3
