// palpa-net.so: the client, and what the object exports.
#include <sys/eventfd.h>
#include <unistd.h>

#include <atomic>
#include <boost/asio/connect.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <memory>
#include <mutex>
#include <thread>

#include "net/datagram_link.h"
#include "net/message_ring.h"
#include "net/net.h"
#include "net/stream.h"
#include "palpa/base/load_error.h"
#include "palpa/base/sanitized.h"
#include "palpa/loop/loop.h"
#include "palpa/version.h"

namespace palpa::net {

namespace {

using namespace std::chrono_literals;

// From the name's look-up to the answer. Longer: a dead address is reported later; shorter: slow links are taken for dead.
constexpr auto connect_deadline = 5s;
// Between attempts. Longer: later back; shorter: more futile attempts.
constexpr auto retry_interval = 300ms;
// Without any byte, pings included. As the server's.
constexpr auto silence_deadline = 5s;
// On the way out [1]: more: older samples are sent first after a pause; fewer: a busy machine loses samples.
constexpr std::size_t places_out = 8;
// On the way in [1]: more: memory; fewer: a busy machine loses models.
constexpr std::size_t places_in = 64;
// Messages a second [1]. More: a flood takes the processor of the loop; fewer: models of 1 kHz with events do not fit.
constexpr int most_messages_per_s = 4000;
// [bytes] of a server's reason in a sentence. More: it hides the sentence; less: it is cut.
constexpr std::size_t longest_reason_bytes = 200;

std::string reason_of(beast::string_view text) {
  return detail::shortened(detail::sanitized({text.data(), text.size()}), longest_reason_bytes);
}

/// One attempt and the connection that it makes, on the client's thread. Its operations own it.
class Attempt;

class Client final : public NetClient {
 public:
  explicit Client(const NetClientOptions& options);
  ~Client() override;

  std::uint32_t connection() const noexcept override { return open_.load(std::memory_order_acquire); }
  bool send(std::uint32_t connection, std::span<const std::byte> message) noexcept override {
    const bool is_datagram = is_by_datagrams() && message.size() <= longest_whole_bytes && options_.may_be_lost(message);
    const bool has_room = (is_datagram ? datagrams_out_ : out_).put(connection, message);
    const std::uint64_t one = 1;
    // Only fails if it was called 2^64 times without a reader.
    [[maybe_unused]] const ssize_t written = ::write(bell_, &one, sizeof one);
    return has_room;
  }
  std::span<const std::byte> receive(std::uint32_t connection) noexcept override {
    if (std::exchange(has_front_, false)) in_.drop();
    const std::span<const std::byte> message = in_.front(connection);
    has_front_ = !message.empty();
    return message;
  }
  Problem problem() const override {
    const std::lock_guard lock(mutex_);
    return problem_;
  }
  std::uint64_t sent_bytes() const noexcept override { return sent_.load(std::memory_order_relaxed); }
  std::uint64_t received_bytes() const noexcept override { return received_.load(std::memory_order_relaxed); }
  bool is_by_datagrams() const noexcept override { return is_by_datagrams_.load(std::memory_order_relaxed); }
  std::uint64_t sent_datagrams() const noexcept override { return sent_datagrams_.load(std::memory_order_relaxed); }
  std::uint64_t received_datagrams() const noexcept override { return received_datagrams_.load(std::memory_order_relaxed); }

 private:
  friend class Attempt;
  void attempt();
  void listen_to_bell();
  /// An attempt or its connection has ended.
  void lose(const std::string& words, bool is_final);
  std::string place() const { return format_endpoint(options_.host, options_.port); }

  const NetClientOptions options_;
  std::optional<asio::ssl::context> tls_;
  asio::io_context context_{1};
  Strand strand_{asio::make_strand(context_)};
  Timer retry_{strand_};
  std::shared_ptr<Attempt> attempt_;
  std::uint32_t last_ = 0;  // number of the last connection
  bool ends_ = false;

  const int bell_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  asio::posix::basic_stream_descriptor<Strand> ears_{strand_, bell_};
  std::array<std::byte, 8> rung_{};

  MessageRing<places_out> out_, datagrams_out_;
  MessageRing<places_in> in_;
  bool has_front_ = false;  // of the tick's thread
  std::atomic<std::uint32_t> open_{0};
  std::atomic<std::uint64_t> sent_{0}, received_{0}, sent_datagrams_{0}, received_datagrams_{0};
  std::atomic<bool> is_by_datagrams_{false};
  mutable std::mutex mutex_;
  Problem problem_;
  std::thread thread_;
};

class Attempt : public std::enable_shared_from_this<Attempt> {
 public:
  Attempt(Client& client)
      : client_(client),
        web_(Socket(client.strand_), client.tls_ ? &*client.tls_ : nullptr),
        resolver_(client.strand_),
        timer_(client.strand_) {
    web_.auto_fragment(false);
    web_.read_message_max(longest_message_bytes);
    web_.binary(true);
  }

  void begin() {
    timer_.expires_after(connect_deadline);
    timer_.async_wait([self = shared_from_this()](error_code error) {
      if (!error) self->lose("no answer within 5 s; is the port open, and palpa serve there?", false);
    });
    resolver_.async_resolve(client_.options_.host, std::to_string(client_.options_.port),
                            [self = shared_from_this()](error_code error, const auto& found) {
                              if (self->is_over_) return;
                              if (error) return self->lose("no such host (" + error.message() + "); write HOST:PORT", false);
                              self->connect(found);
                            });
  }
  void send() {
    if (is_writing_ || number_ == 0) return;
    const std::span<const std::byte> message = client_.out_.front(number_);
    if (message.empty()) return;
    is_writing_ = true;
    web_.async_write(asio::buffer(message.data(), message.size()),
                     [self = shared_from_this()](error_code error, std::size_t bytes) {
                       self->is_writing_ = false;
                       if (self->is_over_) return;
                       self->client_.out_.drop();
                       if (error) return self->lose("the connection has ended (" + error.message() + ")", false);
                       self->client_.sent_.fetch_add(bytes, std::memory_order_relaxed);
                       self->send();
                     });
  }
  void send_datagrams() {
    if (!datagrams_) return;
    for (auto message = client_.datagrams_out_.front(number_); !message.empty();
         message = client_.datagrams_out_.front(number_)) {
      datagrams_->send(message);
      client_.sent_.fetch_add(message.size(), std::memory_order_relaxed);
      client_.sent_datagrams_.fetch_add(1, std::memory_order_relaxed);
      client_.datagrams_out_.drop();
    }
  }
  void drop() {
    is_over_ = true;
    if (datagrams_) std::exchange(datagrams_, nullptr)->end();
    timer_.cancel();
    resolver_.cancel();
    web_.next_layer().close();
  }

 private:
  void connect(const tcp::resolver::results_type& found) {
    asio::async_connect(web_.next_layer().socket(), found, [self = shared_from_this()](error_code error, const tcp::endpoint&) {
      if (self->is_over_) return;
      if (error) return self->lose("no server listens there (" + error.message() + "); begin palpa serve, or ssh -L", false);
      self->web_.next_layer().prefer_newest();
      self->secure();
    });
  }
  void secure() {
    const std::string& host = client_.options_.host;
    if (auto* const tls = web_.next_layer().tls()) {
      ::SSL_set_tlsext_host_name(tls->native_handle(), host.c_str());
      tls->set_verify_callback(asio::ssl::host_name_verification(host));
    }
    web_.next_layer().async_secure(asio::ssl::stream_base::client, [self = shared_from_this()](error_code error) {
      if (self->is_over_) return;
      if (error)
        return self->lose("TLS failed (" + error.message() + "); is the certificate for this host, and --ca its authority?",
                          true);
      self->shake_hands();
    });
  }
  void shake_hands() {
    web_.set_option(websocket::stream_base::timeout{connect_deadline, silence_deadline, true});
    web_.async_handshake(answer_, client_.place(), "/", [self = shared_from_this()](error_code error) {
      if (self->is_over_) return;
      if (error == websocket::error::upgrade_declined) return self->lose("refused: " + reason_of(self->answer_.body()), true);
      if (error) return self->lose("no palpa serve is there (" + error.message() + "), or with --tls alone", false);
      self->timer_.cancel();
      self->number_ = ++self->client_.last_;
      self->client_.out_.front(self->number_);  // drops messages of the connection before
      self->client_.open_.store(self->number_, std::memory_order_release);
      self->read();
    });
  }
  void read() {
    web_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t bytes) {
      if (self->is_over_) return;
      if (error == websocket::error::closed && self->web_.reason().code == websocket::close_code::policy_error)
        return self->lose("refused: " + reason_of(self->web_.reason().reason.c_str()), true);
      if (error) return self->lose("the connection has ended (" + error.message() + ")", false);
      if (self->is_flooding()) return self->lose("more than 4000 messages a second; no palpa serve sends them", true);
      const auto data = self->buffer_.cdata();
      const std::span<const std::byte> message(static_cast<const std::byte*>(data.data()), data.size());
      // Without room the message is lost: newer ones follow.
      if (is_of_transport(message))
        self->use_datagrams(message);
      else if (self->web_.got_binary())
        self->client_.in_.put(self->number_, message);
      self->client_.received_.fetch_add(bytes, std::memory_order_relaxed);
      self->buffer_.consume(self->buffer_.size());
      self->read();
    });
  }
  void use_datagrams(std::span<const std::byte> message) {
    const std::optional<DatagramOffer> offer = offer_of(message);
    if (!offer || datagrams_ || !client_.options_.may_be_lost) return;
    error_code error;
    const Socket& socket = web_.next_layer().socket();
    const asio::ip::address here = socket.local_endpoint(error).address(), there = socket.remote_endpoint(error).address();
    if (error) return;
    datagrams_ = std::make_shared<DatagramLink>(
        client_.strand_, offer->key, udp::endpoint(here, 0), udp::endpoint(there, offer->port),
        [this](std::span<const std::byte> taken) { take_datagram(taken); },
        [this](bool used) { client_.is_by_datagrams_.store(used, std::memory_order_relaxed); });
    datagrams_->begin();
  }
  void take_datagram(std::span<const std::byte> message) {
    if (is_flooding()) return lose("more than 4000 messages a second; no palpa serve sends them", true);
    if (!client_.options_.may_be_lost(message)) return;
    client_.in_.put(number_, message);
    client_.received_.fetch_add(message.size(), std::memory_order_relaxed);
    client_.received_datagrams_.fetch_add(1, std::memory_order_relaxed);
  }
  bool is_flooding() noexcept {
    const auto now = std::chrono::steady_clock::now();
    if (now - second_ >= 1s) second_ = now, messages_ = 0;
    return ++messages_ > most_messages_per_s;
  }
  void lose(const std::string& words, bool is_final) {
    if (is_over_) return;
    const auto self = shared_from_this();
    drop();
    client_.lose(words, is_final);
  }

  Client& client_;
  WebSocket web_;
  asio::ip::basic_resolver<tcp, Strand> resolver_;
  Timer timer_;
  websocket::response_type answer_;
  beast::flat_buffer buffer_{longest_message_bytes};
  std::shared_ptr<DatagramLink> datagrams_;  // none without an offer
  std::uint32_t number_ = 0;                 // 0: not open
  bool is_writing_ = false;
  bool is_over_ = false;
  std::chrono::steady_clock::time_point second_{};
  int messages_ = 0;  // in it
};

asio::ssl::context client_tls(const NetClientOptions& options) {
  asio::ssl::context tls(asio::ssl::context::tls_client);
  ::SSL_CTX_set_min_proto_version(tls.native_handle(), TLS1_2_VERSION);
  tls.set_verify_mode(asio::ssl::verify_peer);
  error_code error;
  if (options.authority.empty()) {
    tls.set_default_verify_paths(error);
  } else {
    const std::string authority = pem_file(options.authority, "name the authority's certificate, PEM");
    tls.add_certificate_authority(asio::buffer(authority), error);
    if (error) throw LoadError(options.authority.string() + ": holds no certificate (" + error.message() + "); it is PEM");
  }
  return tls;
}

Client::Client(const NetClientOptions& options) : options_(options) {
  if (options.has_tls) tls_.emplace(client_tls(options));
  asio::post(strand_, [this] {
    attempt();
    listen_to_bell();
  });
  thread_ = std::thread([this] {
    const RealTimeThread as_urgent_as_the_loop;
    context_.run();
  });
}

Client::~Client() {
  asio::post(strand_, [this] {
    ends_ = true;
    if (attempt_) attempt_->drop();
    attempt_.reset();
    retry_.cancel();
    error_code ignored;
    ears_.close(ignored);  // closes the bell
  });
  thread_.join();
}

void Client::attempt() {
  attempt_ = std::make_shared<Attempt>(*this);
  attempt_->begin();
}

void Client::listen_to_bell() {
  ears_.async_read_some(asio::buffer(rung_), [this](error_code error, std::size_t) {
    if (error || ends_) return;
    if (attempt_) attempt_->send(), attempt_->send_datagrams();
    listen_to_bell();
  });
}

void Client::lose(const std::string& words, bool is_final) {
  open_.store(0, std::memory_order_release);
  attempt_.reset();
  {
    const std::lock_guard lock(mutex_);
    problem_ = {place() + ": " + words, is_final};
  }
  if (is_final || ends_) return;
  retry_.expires_after(retry_interval);
  retry_.async_wait([this](error_code error) {
    if (!error && !ends_) attempt();
  });
}

}  // namespace

std::unique_ptr<NetServer> serve(const NetServerOptions& options, NetService& service);  // server.cpp

namespace {
std::unique_ptr<NetClient> connect(const NetClientOptions& options) { return std::make_unique<Client>(options); }
}  // namespace

}  // namespace palpa::net

extern "C" [[gnu::visibility("default")]] const palpa::Net palpa_net;
const palpa::Net palpa_net = {palpa::version, palpa::net::serve, palpa::net::connect};
