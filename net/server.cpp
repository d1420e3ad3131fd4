// palpa-net.so: the server. A strand for each connection, on as many threads as there may be hands, and one.
#include <algorithm>
#include <array>
#include <atomic>
#include <boost/beast/http.hpp>
#include <chrono>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "net/datagram_port.h"
#include "net/net.h"
#include "net/request.h"
#include "net/stream.h"
#include "palpa/base/load_error.h"
#include "palpa/base/sanitized.h"
#include "palpa/base/wording.h"

namespace palpa::net {

namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

// Sessions tick on them, and may block on data. More: memory; fewer: hands hold up each other.
constexpr int threads = 5;
// Between acceptance and the first message. Longer: silent connections take places; shorter: slow links are refused.
constexpr auto hello_deadline = 2s;
// Without any byte. Longer: a lost hand keeps its place; shorter: a slow link is taken for none.
constexpr auto silence_deadline = 5s;
// Without a datagram, until messages go by the WebSocket again. As the client's.
constexpr auto datagram_silence = 1s;
// Of a close frame on its way out. Longer: a full socket takes a place; shorter: the reason does not arrive.
constexpr auto goodbye_deadline = 500ms;
// Messages a second [1]. More: a flood takes the processor; fewer: hands at 1 kHz with pings do not fit.
constexpr int most_messages_per_s = 2000;
// Connections without a first message [1]. More: memory; fewer: several who come at once are refused.
constexpr int most_strangers = 8;
// Between two offers to a silent user: 60 a second. Longer: views jerk; shorter: more work.
constexpr auto offer_interval = 16667us;
// [bytes] Messages that wait to be read, in the system. More: older ones are felt first after a pause; fewer: a link of 100 ms
// does not carry 1000 reports a second.
constexpr int unread_bytes = 32 << 10;
// Lines a second about refused connections [1]. More: they hide the others; fewer: causes are lost.
constexpr int most_lines_per_s = 20;
// [bytes] of the reason in a close frame, by the standard 123.
constexpr std::size_t longest_reason_bytes = 120;

class Connection;

class Server final : public NetServer {
 public:
  Server(const NetServerOptions& options, NetService& service);
  ~Server() override;
  std::uint16_t port() const noexcept override { return port_; }

  // ---- for its connections ----

  NetService& service() noexcept { return service_; }
  const std::vector<std::string>& hosts() const noexcept { return hosts_; }
  void report(const std::string& line);
  /// nullptr: without datagrams
  DatagramPort* datagrams() noexcept { return datagrams_ ? &*datagrams_ : nullptr; }
  void meet(int strangers) noexcept { strangers_ += strangers; }
  void forget(const Connection* connection);

 private:
  void accept();
  void begin(Socket socket);

  NetService& service_;
  asio::io_context context_{threads};
  std::optional<asio::ssl::context> tls_;
  asio::basic_socket_acceptor<tcp, Strand> acceptor_{asio::make_strand(context_)};
  std::optional<DatagramPort> datagrams_;
  std::vector<std::string> hosts_;
  std::uint16_t port_ = 0;
  std::atomic<int> strangers_{0};
  std::mutex mutex_;  // of all below
  std::vector<std::shared_ptr<Connection>> connections_;
  Clock::time_point lines_since_{};
  int lines_ = 0;
  bool ends_ = false;
  std::vector<std::thread> threads_;
};

/// One connection, on its strand. Its operations own it, and the server until `end`.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Socket socket, asio::ssl::context* tls, Server& server)
      : server_(server), web_(std::move(socket), tls), timer_(web_.get_executor()), offers_(web_.get_executor()) {
    error_code unknown;
    const tcp::endpoint from = stream().socket().remote_endpoint(unknown);
    if (!unknown) from_ = format_endpoint(from.address().to_string(), from.port()), address_ = from.address();
    const tcp::endpoint here = stream().socket().local_endpoint(unknown);
    if (!unknown) here_ = host_without_port(format_endpoint(here.address().to_string(), here.port()));
    web_.auto_fragment(false);
    web_.read_message_max(longest_message_bytes);
    parser_.header_limit(longest_header_bytes);
    parser_.body_limit(0);
    stream().prefer_newest();
  }
  ~Connection() { meet_once(); }

  /// Begins, from another thread.
  void begin() {
    asio::post(web_.get_executor(), [self = shared_from_this()] { self->secure(); });
  }
  /// Ends it, likewise.
  void drop() {
    asio::post(web_.get_executor(), [self = shared_from_this()] { self->end({}); });
  }

 private:
  EitherStream& stream() noexcept { return web_.next_layer(); }

  void secure() {
    timer_.expires_after(hello_deadline);
    timer_.async_wait([self = shared_from_this()](error_code error) {
      if (!error) self->refuse("no first message within 2 s; palpa run --data-at sends one at once");
    });
    stream().async_secure(asio::ssl::stream_base::server, [self = shared_from_this()](error_code error) {
      if (error) return self->end("TLS failed (" + error.message() + "); connect with --tls");
      self->read_request();
    });
  }
  void read_request();
  void answer(const std::string& problem);
  void open();
  void read();
  void take();
  void offer();
  void write(std::size_t bytes);
  void offer_again();
  void offer_datagrams();
  void take_datagrams();
  void take_datagram(const DatagramBox::Letter& letter);
  void set_by_datagrams(bool are_used);
  bool is_flooding() noexcept;
  /// Says why, here and there, and ends.
  void refuse(const std::string& why);
  /// \param why  for the report; empty: none
  void end(const std::string& why);
  void meet_once() noexcept {
    if (!std::exchange(is_known_, true)) server_.meet(-1);
  }

  Server& server_;
  WebSocket web_;
  Timer timer_, offers_;
  std::string from_ = "unknown", here_;
  asio::ip::address address_;
  beast::flat_buffer buffer_{longest_message_bytes + longest_header_bytes};
  http::request_parser<http::empty_body> parser_;
  http::response<http::string_body> answer_;
  std::unique_ptr<NetUser> user_;
  std::array<std::byte, 8192> out_{};
  bool is_open_ = false;     // as a WebSocket
  bool is_writing_ = false;  // a message
  bool is_ending_ = false;   // no further message is taken or given
  bool is_known_ = false;    // no longer one of the strangers
  std::shared_ptr<DatagramBox> box_;
  udp::endpoint peer_;         // of its datagrams
  bool by_datagrams_ = false;  // the newest message that may be lost came by one
  Clock::time_point heard_{};  // then
  Clock::time_point second_{};
  int messages_ = 0;  // in it
};

void Connection::read_request() {
  http::async_read(stream(), buffer_, parser_, [self = shared_from_this()](error_code error, std::size_t) {
    if (self->is_ending_) return;
    if (error == http::error::header_limit || error == http::error::body_limit)
      return self->answer("the request is too long; connect with palpa run --data-at");
    if (error) return self->end("no request of HTTP (" + error.message() + "); connect with palpa run --data-at");
    std::vector<std::string> hosts = self->server_.hosts();
    hosts.push_back(self->here_);
    const std::string problem = problem_with(self->parser_.get(), hosts);
    if (!problem.empty() || self->buffer_.size() > 0)
      return self->answer(problem.empty() ? "messages before the answer; wait for it" : problem);
    self->open();
  });
}

// A refusal by HTTP.
void Connection::answer(const std::string& problem) {
  is_ending_ = true;
  server_.report(from_ + ": refused: " + problem);
  answer_.result(http::status::forbidden);
  answer_.set(http::field::content_type, "text/plain; charset=utf-8");
  answer_.keep_alive(false);
  answer_.body() = problem + "\n";
  answer_.prepare_payload();
  http::async_write(stream(), answer_, [self = shared_from_this()](error_code, std::size_t) {
    error_code ignored;
    self->stream().socket().shutdown(tcp::socket::shutdown_send, ignored);
    self->end({});
  });
}

void Connection::open() {
  web_.set_option(websocket::stream_base::timeout{hello_deadline, silence_deadline, true});
  web_.control_callback([this](websocket::frame_type kind, beast::string_view) {
    if (kind == websocket::frame_type::ping && is_flooding() && !is_ending_)
      asio::post(web_.get_executor(), [self = shared_from_this()] { self->refuse("more than 2000 messages a second"); });
  });
  web_.async_accept(parser_.get(), [self = shared_from_this()](error_code error) {
    if (error) return self->end({});
    self->is_open_ = true;
    self->read();
  });
}

void Connection::read() {
  web_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
    if (self->is_ending_) return;
    if (error == websocket::error::message_too_big) return self->end("refused: a message of more than 4096 bytes");
    if (error) return self->end({});
    self->take();
  });
}

bool Connection::is_flooding() noexcept {
  const Clock::time_point now = Clock::now();
  if (now - second_ >= 1s) second_ = now, messages_ = 0;
  return ++messages_ > most_messages_per_s;
}

void Connection::take() {
  if (is_flooding()) return refuse("more than 2000 messages a second; a hand sends at most 1000");
  if (web_.got_text()) return refuse("a message of text; a hand sends binary ones");
  const auto bytes = buffer_.cdata();
  const std::span<const std::byte> message(static_cast<const std::byte*>(bytes.data()), bytes.size());
  try {
    if (user_) {
      if (by_datagrams_ && user_->may_be_lost(message)) set_by_datagrams(false);
      if (const std::string why = user_->take(message); !why.empty()) return refuse(why);
    } else {
      user_ = server_.service().admit(message);
      timer_.cancel();
      meet_once();
      web_.text(user_->gives_text());
      offer_again();
      if (server_.datagrams() && !user_->gives_text()) offer_datagrams();
    }
  } catch (const std::exception& error) {
    return refuse(error.what());
  }
  buffer_.consume(buffer_.size());
  // After a pause several have come: the newest is answered.
  error_code unknown;
  if (stream().socket().available(unknown) == 0) offer();
  read();
}

// No message waits here: the user gives the newest when the socket has taken the one before.
void Connection::offer() {
  while (!is_writing_ && !is_ending_ && user_) {
    std::size_t bytes = 0;
    try {
      bytes = user_->give(out_);
    } catch (const std::exception& error) {
      return refuse(error.what());
    }
    if (bytes == 0) return;
    const std::span<const std::byte> message(out_.data(), bytes);
    const bool is_datagram = by_datagrams_ && bytes <= longest_whole_bytes && user_->may_be_lost(message);
    if (!is_datagram) return write(bytes);
    server_.datagrams()->send(box_->key(), message, peer_);
  }
}

void Connection::write(std::size_t bytes) {
  is_writing_ = true;
  web_.async_write(asio::buffer(out_.data(), bytes), [self = shared_from_this()](error_code error, std::size_t) {
    self->is_writing_ = false;
    if (error) return self->end({});
    self->offer();
  });
}

// Only to whom has been admitted. The key opens nothing but this connection.
void Connection::offer_datagrams() {
  box_ = std::make_shared<DatagramBox>(random_key(), address_, [weak = weak_from_this(), strand = web_.get_executor()] {
    asio::post(strand, [weak] {
      if (const auto self = weak.lock()) self->take_datagrams();
    });
  });
  server_.datagrams()->open(box_);
  const auto message = offer_message({.key = box_->key(), .port = server_.datagrams()->port()});
  std::ranges::copy(message, out_.begin());
  write(message.size());
}

void Connection::take_datagrams() {
  DatagramBox::Letter letter;
  while (!is_ending_ && box_->take(letter)) take_datagram(letter);
  if (is_ending_) return;
  if (box_->in_this_second() > most_messages_per_s)
    return refuse("more than 2000 datagrams a second; a hand sends at most 1000");
  offer();
}

// A wrong datagram is dropped without an answer: its sender may have read the key on its way.
void Connection::take_datagram(const DatagramBox::Letter& letter) {
  if (!user_) return;
  const std::span<const std::byte> message(letter.message.data(), letter.bytes);
  if (message.empty()) return server_.datagrams()->send(box_->key(), {}, letter.from);
  if (!user_->may_be_lost(message)) return;
  try {
    if (!user_->take(message).empty()) return;
  } catch (const std::exception& error) {
    return refuse(error.what());
  }
  peer_ = letter.from;
  heard_ = Clock::now();
  set_by_datagrams(true);
}

void Connection::set_by_datagrams(bool are_used) {
  if (std::exchange(by_datagrams_, are_used) != are_used) user_->set_by_datagrams(are_used);
}

void Connection::offer_again() {
  offers_.expires_after(offer_interval);
  offers_.async_wait([self = shared_from_this()](error_code error) {
    if (error || self->is_ending_) return;
    if (self->by_datagrams_ && Clock::now() - self->heard_ > datagram_silence) self->set_by_datagrams(false);
    self->offer();
    self->offer_again();
  });
}

void Connection::refuse(const std::string& why) {
  if (is_ending_) return;
  if (!is_open_) return end("refused: " + why);
  is_ending_ = true;
  server_.report(from_ + ": refused: " + why);
  timer_.expires_after(goodbye_deadline);
  timer_.async_wait([self = shared_from_this()](error_code error) {
    if (!error) self->end({});
  });
  const websocket::close_reason reason(websocket::close_code::policy_error, detail::shortened(why, longest_reason_bytes));
  web_.async_close(reason, [self = shared_from_this()](error_code) { self->end({}); });
}

void Connection::end(const std::string& why) {
  if (!why.empty() && !is_ending_) server_.report(from_ + ": " + why);
  is_ending_ = true;
  timer_.cancel();
  offers_.cancel();
  stream().close();
  user_.reset();
  meet_once();
  server_.forget(this);
}

asio::ssl::context server_tls(const NetServerOptions& options) {
  asio::ssl::context tls(asio::ssl::context::tls_server);
  ::SSL_CTX_set_min_proto_version(tls.native_handle(), TLS1_2_VERSION);
  tls.set_password_callback([](std::size_t, auto) { return std::string(); });  // not asked for in a terminal
  const std::string chain = pem_file(options.certificate, "name the certificate, PEM"),
                    key = pem_file(options.key, "name its key, PEM");
  error_code error;
  tls.use_certificate_chain(asio::buffer(chain), error);
  if (error) throw LoadError(options.certificate.string() + ": holds no certificate (" + error.message() + "); it is PEM");
  tls.use_private_key(asio::buffer(key), asio::ssl::context::pem, error);
  if (error)
    throw LoadError(options.key.string() + ": holds no key of that certificate (" + error.message() +
                    "); it is PEM, without a password");
  return tls;
}

Server::Server(const NetServerOptions& options, NetService& service) : service_(service) {
  if (!options.certificate.empty()) tls_.emplace(server_tls(options));
  const std::string place = format_endpoint(options.address, options.port);
  error_code error;
  tcp::resolver resolver(context_);
  const auto found = resolver.resolve(options.address, std::to_string(options.port), tcp::resolver::passive, error);
  if (error || found.empty())
    throw LoadError("--listen " + options.address + ": is no address of this machine (" + error.message() + ")");
  const tcp::endpoint at = *found.begin();
  acceptor_.open(at.protocol(), error);
  if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor_.set_option(tcp::acceptor::receive_buffer_size(unread_bytes), error);
  if (!error) acceptor_.bind(at, error);
  if (!error) acceptor_.listen(most_strangers, error);
  if (error == asio::error::address_in_use) throw LoadError(place + ": is listened to already; choose another --port");
  if (error) throw LoadError(place + ": cannot be listened to (" + error.message() + "); choose an address of this machine");
  port_ = acceptor_.local_endpoint(error).port();
  hosts_.push_back(host_without_port(format_endpoint(options.address, port_)));
  if (options.datagrams) datagrams_.emplace(context_, at.address(), port_, options.port == 0);
  if (datagrams_) datagrams_->begin();
  accept();
  for (int n = 0; n < threads; ++n) threads_.emplace_back([this] { context_.run(); });
}

Server::~Server() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
    for (const auto& connection : connections_) connection->drop();
  }
  if (datagrams_) datagrams_->end();
  asio::post(acceptor_.get_executor(), [this] {
    error_code ignored;
    acceptor_.close(ignored);
  });
  for (std::thread& thread : threads_) thread.join();
}

void Server::accept() {
  acceptor_.async_accept(asio::make_strand(context_), [this](error_code error, Socket socket) {
    if (!acceptor_.is_open()) return;
    if (!error) begin(std::move(socket));
    if (error) std::this_thread::sleep_for(50ms);  // no descriptor is left
    accept();
  });
}

void Server::begin(Socket socket) {
  if (strangers_ >= most_strangers)
    return report("a connection: refused: " + std::to_string(most_strangers) + " others have sent no first message yet");
  strangers_ += 1;
  const auto connection = std::make_shared<Connection>(std::move(socket), tls_ ? &*tls_ : nullptr, *this);
  const std::lock_guard lock(mutex_);
  if (ends_) return;
  connections_.push_back(connection);
  connection->begin();
}

void Server::report(const std::string& line) {
  std::string more;
  {
    const std::lock_guard lock(mutex_);
    const Clock::time_point now = Clock::now();
    if (now - lines_since_ >= 1s) {
      if (lines_ > most_lines_per_s) more = "and " + std::to_string(lines_ - most_lines_per_s) + " more were refused";
      lines_since_ = now, lines_ = 0;
    }
    if (++lines_ > most_lines_per_s) return;
  }
  if (!more.empty()) service_.report(more);
  service_.report(line);
}

void Server::forget(const Connection* connection) {
  std::shared_ptr<Connection> last;  // destroyed after the lock
  const std::lock_guard lock(mutex_);
  const auto at = std::ranges::find(connections_, connection, [](const auto& one) { return one.get(); });
  if (at == connections_.end()) return;
  last = std::move(*at);
  connections_.erase(at);
}

}  // namespace

std::unique_ptr<NetServer> serve(const NetServerOptions& options, NetService& service) {
  return std::make_unique<Server>(options, service);
}

}  // namespace palpa::net
