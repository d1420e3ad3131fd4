#include "devices/inverse3_connection.h"

#include <boost/asio/post.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <functional>
#include <sstream>
#include <utility>

namespace palpa::inverse3 {

namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::asio::ip::tcp;
using boost::system::error_code;
// The executor as a type, and no compression, which is never offered to the service: a third less to compile.
using Stream = beast::basic_stream<tcp, boost::asio::io_context::executor_type>;

// Timeout of the version request. Longer: delays each connection to a service that never answers; shorter: the version of a
// busy service stays unknown, and the key of its force may be wrong.
constexpr std::chrono::milliseconds version_deadline{300};
// Size limit of the answer, which has about 200 bytes. More: memory; fewer: a longer answer is ignored.
constexpr std::size_t longest_version_bytes = std::size_t{16} << 10;
// Size limit of the answer's header. As above.
constexpr std::uint32_t longest_header_bytes = 8 << 10;

std::string host_of(const tcp::endpoint& service) {
  std::ostringstream host;
  host << service;
  return host.str();
}

/// GET /version. Owns itself until it has called `done`.
class VersionQuestion : public std::enable_shared_from_this<VersionQuestion> {
 public:
  using Done = std::function<void(std::optional<ForceWord>)>;
  VersionQuestion(boost::asio::io_context& context, Done done) : stream_(context), done_(std::move(done)) {
    answer_.body_limit(longest_version_bytes);
    answer_.header_limit(longest_header_bytes);
  }

  void ask(const tcp::endpoint& service) {
    question_.set(http::field::host, host_of(service));
    stream_.expires_after(version_deadline);
    stream_.async_connect(service, [self = shared_from_this()](error_code error) {
      if (error) return self->end();
      http::async_write(self->stream_, self->question_, [self](error_code failed, std::size_t) {
        if (failed) return self->end();
        http::async_read(self->stream_, self->buffer_, self->answer_, [self](error_code, std::size_t) { self->end(); });
      });
    });
  }
  void drop() noexcept {
    done_ = nullptr;
    stream_.close();
  }

 private:
  void end() {
    std::optional<ForceWord> word;
    if (answer_.is_done() && answer_.get().result() == http::status::ok) word = word_of_version(answer_.get().body());
    stream_.close();
    if (done_) std::exchange(done_, nullptr)(word);
  }

  Stream stream_;
  http::request<http::empty_body> question_{http::verb::get, "/version", 11};
  beast::flat_buffer buffer_{longest_version_bytes + longest_header_bytes};
  http::response_parser<http::string_body> answer_;
  Done done_;
};

class WebSocketConnection final : public Connection, public std::enable_shared_from_this<WebSocketConnection> {
 public:
  WebSocketConnection(boost::asio::io_context& context, const tcp::endpoint& service, ConnectionUser& user)
      : context_(context), service_(service), stream_(context), user_(&user) {
    stream_.auto_fragment(false);
    stream_.read_message_max(longest_message_bytes);
    stream_.text(true);
  }

  void begin(bool asks_version) {
    if (!asks_version) return open(std::nullopt);
    // Weak: the connection owns the request.
    question_ = std::make_shared<VersionQuestion>(context_, [weak = weak_from_this()](std::optional<ForceWord> word) {
      if (const auto self = weak.lock()) self->open(word);
    });
    question_->ask(service_);
  }
  bool is_writing() const noexcept override { return is_writing_; }
  bool has_unread() noexcept override {
    error_code error;
    return beast::get_lowest_layer(stream_).socket().available(error) > 0 && !error;
  }

  void send(std::string text) override {
    sent_ = std::move(text);
    is_writing_ = true;
    stream_.async_write(boost::asio::buffer(sent_), [self = shared_from_this()](error_code error, std::size_t) {
      self->is_writing_ = false;
      if (self->user_ == nullptr) return;
      if (error) return self->lose();
      self->user_->on_written();
    });
  }

  void say_goodbye() override {
    stream_.async_close(websocket::close_code::normal, [self = shared_from_this()](error_code) { self->lose(); });
  }

  void close() noexcept override {
    user_ = nullptr;
    if (question_) question_->drop();
    beast::get_lowest_layer(stream_).close();
  }

 private:
  void open(std::optional<ForceWord> word) {
    beast::get_lowest_layer(stream_).async_connect(service_, [self = shared_from_this(), word](error_code error) {
      if (error || self->user_ == nullptr) return self->lose();
      self->shake_hands(word);
    });
  }

  void shake_hands(std::optional<ForceWord> word) {
    error_code ignored;  // an optimisation only
    beast::get_lowest_layer(stream_).socket().set_option(tcp::no_delay(true), ignored);
    stream_.async_handshake(host_of(service_), "/", [self = shared_from_this(), word](error_code error) {
      if (error || self->user_ == nullptr) return self->lose();
      self->user_->on_open(word);
      self->read();
    });
  }

  void read() {
    if (user_ == nullptr) return;
    stream_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error || self->user_ == nullptr) return self->lose();
      const auto bytes = self->buffer_.cdata();
      const std::string_view text(static_cast<const char*>(bytes.data()), bytes.size());
      self->user_->on_message(self->stream_.got_text() ? text : std::string_view{});
      self->buffer_.consume(self->buffer_.size());
      self->read();
    });
  }

  void lose() {
    ConnectionUser* const user = user_;
    close();
    if (user != nullptr) user->on_lost();
  }

  boost::asio::io_context& context_;
  tcp::endpoint service_;
  websocket::stream<Stream, false> stream_;
  beast::flat_buffer buffer_{longest_message_bytes};
  std::shared_ptr<VersionQuestion> question_;
  std::string sent_;
  bool is_writing_ = false;
  ConnectionUser* user_;
};

}  // namespace

std::shared_ptr<Connection> connect(boost::asio::io_context& context, const tcp::endpoint& service, bool asks_version,
                                    ConnectionUser& user) {
  auto connection = std::make_shared<WebSocketConnection>(context, service, user);
  connection->begin(asks_version);
  return connection;
}

}  // namespace palpa::inverse3
