// One WebSocket connection to an Inverse Service, from the first packet to the last.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "devices/inverse3_messages.h"

namespace palpa::inverse3 {

/// What becomes of a connection. Called from its io_context's thread, never from within a call of the connection's.
class ConnectionUser {
 public:
  virtual void on_open(std::optional<ForceWord> word_of_version) = 0;  ///< none: the service's version is not known
  /// One whole message. What was binary comes as an empty one: no text of the service's is.
  virtual void on_message(std::string_view text) = 0;
  virtual void on_written() = 0;  ///< the next one can be sent
  /// The last call: the other side is not there, has gone, or has broken the rules of WebSocket.
  virtual void on_lost() = 0;

 protected:
  ~ConnectionUser() = default;
};

/// Answers pings, takes no compression, and reads all the time. It knows no deadlines but one, for the version: whoever uses it
/// closes what takes too long. For the io_context's thread.
class Connection {
 public:
  virtual ~Connection() = default;
  virtual bool is_writing() const noexcept = 0;
  /// Sends a text. Only where none is being written.
  virtual void send(std::string text) = 0;
  /// Says good-bye; `on_lost` comes when the other side has done so, too.
  virtual void say_goodbye() = 0;
  /// Drops it. The user hears nothing any more.
  virtual void close() noexcept = 0;
};

/// Begins to connect.
/// \param asks_version  the service is asked for its version first, by HTTP; without an answer within 0.3 s it is not known
std::shared_ptr<Connection> connect(boost::asio::io_context& context, const boost::asio::ip::tcp::endpoint& service,
                                    bool asks_version, ConnectionUser& user);

}  // namespace palpa::inverse3
