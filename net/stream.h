// Stream of both sides: TCP, with or without TLS.
#pragma once

#include <netinet/tcp.h>
#include <sys/socket.h>

#include <boost/asio/basic_waitable_timer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/asio/strand.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

namespace palpa::net {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;

using Strand = asio::strand<asio::io_context::executor_type>;
using Socket = asio::basic_stream_socket<tcp, Strand>;
using Timer = asio::basic_waitable_timer<std::chrono::steady_clock, asio::wait_traits<std::chrono::steady_clock>, Strand>;

/// [bytes] of a message of either side; more: a hostile peer takes memory; fewer: longer models do not fit.
inline constexpr std::size_t longest_message_bytes = 4096;
/// [bytes] of the head of a request or its answer. As above.
inline constexpr std::uint32_t longest_header_bytes = 8 << 10;

/// The next layer of a WebSocket. One type with or without TLS: half to compile.
class EitherStream {
 public:
  using executor_type = Strand;
  EitherStream(Socket socket, asio::ssl::context* tls) : socket_(std::move(socket)) {
    if (tls) tls_.emplace(socket_, *tls);
  }
  EitherStream(const EitherStream&) = delete;
  EitherStream& operator=(const EitherStream&) = delete;

  executor_type get_executor() noexcept { return socket_.get_executor(); }
  Socket& socket() noexcept { return socket_; }
  /// nullptr: without TLS
  asio::ssl::stream<Socket&>* tls() noexcept { return tls_ ? &*tls_ : nullptr; }

  /// Prepares for small messages of which the newest counts: each is sent at once, and few bytes are queued in the system.
  void prefer_newest() noexcept {
    error_code ignored;  // optimisations only
    socket_.set_option(tcp::no_delay(true), ignored);
    // More: older models are sent first on a slow link; fewer: the link idles between messages.
    const int unsent_bytes = 4096;
    ::setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &unsent_bytes, sizeof unsent_bytes);
  }
  /// Shakes hands of TLS, or calls `handler` with success.
  template <class Handler>
  void async_secure(asio::ssl::stream_base::handshake_type side, Handler&& handler) {
    if (tls_) return tls_->async_handshake(side, std::forward<Handler>(handler));
    asio::post(get_executor(), beast::bind_front_handler(std::forward<Handler>(handler), error_code{}));
  }
  void close() noexcept {
    error_code ignored;
    socket_.close(ignored);
  }

  template <class Buffers, class Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    if (tls_) return tls_->async_read_some(buffers, std::forward<Handler>(handler));
    socket_.async_read_some(buffers, std::forward<Handler>(handler));
  }
  template <class Buffers, class Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    if (tls_) return tls_->async_write_some(buffers, std::forward<Handler>(handler));
    socket_.async_write_some(buffers, std::forward<Handler>(handler));
  }

 private:
  Socket socket_;
  std::optional<asio::ssl::stream<Socket&>> tls_;
};

// For Beast, by argument-dependent look-up: the WebSocket's own closing handshake has ended before.
template <class Handler>
void async_teardown(beast::role_type, EitherStream& stream, Handler&& handler) {
  error_code ignored;
  stream.socket().shutdown(tcp::socket::shutdown_both, ignored);
  asio::post(stream.get_executor(), beast::bind_front_handler(std::forward<Handler>(handler), error_code{}));
}
inline void beast_close_socket(EitherStream& stream) { stream.close(); }

using WebSocket = websocket::stream<EitherStream, false>;

/// "127.0.0.1:4711", "[::1]:4711".
inline std::string format_endpoint(const std::string& host, std::uint16_t port) {
  const bool is_v6 = host.find(':') != std::string::npos;
  return (is_v6 ? "[" + host + "]:" : host + ":") + std::to_string(port);
}

/// Text of a PEM file. Throws LoadError.
/// \param right  remedy if it cannot be opened
std::string pem_file(const std::filesystem::path& file, const char* right);

}  // namespace palpa::net
