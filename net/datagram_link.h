// The client's datagrams of one connection.
#pragma once

#include <chrono>
#include <functional>
#include <memory>

#include "net/datagram.h"

namespace palpa::net {

/// Pings the server from `begin` to `end`, and is in use while its datagrams come. On the connection's strand; its operations
/// own it.
class DatagramLink : public std::enable_shared_from_this<DatagramLink> {
 public:
  /// \param here, there  of the connection; the port of `there` is the server's for datagrams
  /// \param take     for each message that comes
  /// \param set_use  for each change of being in use
  DatagramLink(const Strand& strand, const DatagramKey& key, const udp::endpoint& here, const udp::endpoint& there,
               std::function<void(std::span<const std::byte>)> take, std::function<void(bool)> set_use);

  void begin();
  void send(std::span<const std::byte> message) noexcept { send_datagram(socket_.native_handle(), key_, message, nullptr); }
  void end();

 private:
  void ping();
  void wait();
  void receive();
  void use(bool used);

  DatagramSocket socket_;
  Timer timer_;
  const DatagramKey key_;
  std::function<void(std::span<const std::byte>)> take_;
  std::function<void(bool)> set_use_;
  std::array<std::byte, longest_datagram_bytes + 1> datagram_{};
  std::chrono::steady_clock::time_point heard_{};
  bool is_used_ = false;
  bool is_over_ = false;
};

}  // namespace palpa::net
