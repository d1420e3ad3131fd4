// A WebSocket connection to an Inverse Service.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "palpa/device/inverse3_messages.h"

namespace palpa::inverse3 {

/// Receives a connection's events, on its io_context's thread, never from within a call of the connection.
class ConnectionUser {
 public:
  virtual void on_open(std::optional<ForceWord> word_of_version) = 0;  ///< none: unknown version
  /// A complete message; a binary message is passed as empty: the service sends text only.
  virtual void on_message(std::string_view text) = 0;
  virtual void on_written() = 0;  ///< the next `send` is allowed
  /// Last call: connection refused, lost, or broken by a WebSocket error.
  virtual void on_lost() = 0;

 protected:
  ~ConnectionUser() = default;
};

/// Answers pings, refuses compression, reads continuously. Its only timeout is that of the version request: the user closes
/// slow connections. For the io_context's thread.
class Connection {
 public:
  virtual ~Connection() = default;
  virtual bool is_writing() const noexcept = 0;
  /// True if the socket holds unread bytes, which cannot answer a later `send`.
  virtual bool has_unread() noexcept = 0;
  /// Sends a text; only while `is_writing` is false.
  virtual void send(std::string text) = 0;
  /// Starts the closing handshake; `on_lost` reports its end.
  virtual void say_goodbye() = 0;
  /// Drops the connection without further calls of the user.
  virtual void close() noexcept = 0;
};

/// Starts connecting.
/// \param asks_version  request the service's version first, by HTTP; unknown without an answer within 0.3 s
std::shared_ptr<Connection> connect(boost::asio::io_context& context, const boost::asio::ip::tcp::endpoint& service,
                                    bool asks_version, ConnectionUser& user);

}  // namespace palpa::inverse3
