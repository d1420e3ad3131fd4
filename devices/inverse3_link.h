// The thread that talks with an Inverse Service while the haptic thread only reads and writes two values.
#pragma once

#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <memory>
#include <optional>
#include <string>

#include "devices/inverse3_messages.h"
#include "palpa/device/device.h"

namespace palpa::inverse3 {

/// The most that is asked of an Inverse3. No data sheet could be had: others clip at 2 to 10 N. Larger: its motors may not bear
/// it for long; smaller: walls feel soft.
inline constexpr double max_force_n = 3.0;

struct LinkOptions {
  boost::asio::ip::tcp::endpoint service;
  std::string device_id;
  std::optional<ForceWord> word;  ///< none: by the service's version
  std::string profile;            ///< plain
};

/// Exchanges force for state as fast as forces are written and answers come, one message at a time, from a thread of its own,
/// and comes back by itself when the service or the device has gone. `read` and `write` are for one thread and neither
/// allocate, lock, throw nor wait.
class Link {
 public:
  explicit Link(const LinkOptions& options);
  ~Link();  ///< sends a force of zero; at most half a second
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  DeviceState read() noexcept;
  bool write(const Vec3& force_n) noexcept;
  bool rests() const noexcept;  ///< as of Device
  /// Waits until there is a state that can be used, or a fault that a person has to mend. False: there was neither in time.
  bool wait(double longest_s);

 private:
  class Exchange;
  std::unique_ptr<Exchange> exchange_;
};

/// What a service has at this moment. None: nobody who speaks as an Inverse Service does answers within a second.
std::optional<View> look(const boost::asio::ip::tcp::endpoint& service);

}  // namespace palpa::inverse3
