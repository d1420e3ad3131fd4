// The server's UDP socket, and where its datagrams go.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "net/datagram.h"

namespace palpa::net {

/// Datagrams of one connection on their way from the socket to the connection's strand: the newest, a few. Any thread.
class DatagramBox {
 public:
  /// \param from  address of the connection: datagrams from elsewhere are none of it
  /// \param ring  is called by the socket's thread where the box was empty
  DatagramBox(const DatagramKey& key, asio::ip::address from, std::function<void()> ring)
      : key_(key), from_(std::move(from)), ring_(std::move(ring)), letters_(std::make_unique<Letters>()) {}

  const DatagramKey& key() const noexcept { return key_; }
  /// Takes a datagram if it has the key and came from the address.
  void offer(std::span<const std::byte> datagram, const udp::endpoint& from);

  struct Letter {
    udp::endpoint from;
    std::size_t bytes = 0;
    std::array<std::byte, longest_message_bytes> message{};
  };
  /// Takes out the oldest. False: there is none.
  bool take(Letter& letter) noexcept;
  /// Datagrams [1] of the second in progress, also those that were dropped.
  int in_this_second() const noexcept;

 private:
  // [1] More: older samples are felt first after a pause; fewer: a busy machine loses samples.
  static constexpr std::size_t places = 16;
  using Letters = std::array<Letter, places>;

  const DatagramKey key_;
  const asio::ip::address from_;
  const std::function<void()> ring_;
  mutable std::mutex mutex_;  // of all below
  std::unique_ptr<Letters> letters_;
  std::size_t first_ = 0, count_ = 0;
  std::chrono::steady_clock::time_point second_{};
  int datagrams_ = 0;
};

/// The socket, from construction to destruction, which has to come after the end of the context's threads.
class DatagramPort {
 public:
  /// Binds to the port, or where `is_any_free` and it is taken, to another one. Throws LoadError.
  DatagramPort(asio::io_context& context, const asio::ip::address& address, std::uint16_t port, bool is_any_free);

  std::uint16_t port() const noexcept { return port_; }
  /// Begins to receive; the context's threads do it.
  void begin() { wait(); }
  /// Ends that, from any thread.
  void end();

  // Any thread.

  /// Datagrams with the key of that box go into it, while it lives.
  void open(const std::shared_ptr<DatagramBox>& box);
  void send(const DatagramKey& key, std::span<const std::byte> message, const udp::endpoint& to) noexcept {
    send_datagram(handle_, key, message, &to);
  }

 private:
  void wait();
  void receive();

  DatagramSocket socket_;
  int handle_ = -1;  // of the socket
  std::uint16_t port_ = 0;
  std::array<std::byte, longest_datagram_bytes + 1> datagram_{};
  udp::endpoint from_;
  bool ends_ = false;  // on the socket's strand
  std::mutex mutex_;   // of the boxes
  std::vector<std::weak_ptr<DatagramBox>> boxes_;
};

/// Of the system's source of random numbers. Throws LoadError if it has none.
DatagramKey random_key();

}  // namespace palpa::net
