#include "net/datagram_link.h"

namespace palpa::net {
namespace {

using namespace std::chrono_literals;

// Between pings. Longer: datagrams are used later; shorter: more of them.
constexpr auto ping_interval = 100ms;
// Without a datagram. Longer: no force where a firewall begins to drop them; shorter: losses turn datagrams off.
constexpr auto silence = 1s;
// [1] as the server's
constexpr int most_at_once = 64;

}  // namespace

DatagramLink::DatagramLink(const Strand& strand, const DatagramKey& key, const udp::endpoint& here, const udp::endpoint& there,
                           std::function<void(std::span<const std::byte>)> take, std::function<void(bool)> set_use)
    : socket_(strand), timer_(strand), key_(key), take_(std::move(take)), set_use_(std::move(set_use)) {
  error_code error;
  socket_.open(there.protocol(), error);
  if (!error) socket_.bind(here, error);
  if (!error) socket_.connect(there, error);  // datagrams of other places do not come in
  if (!error) socket_.non_blocking(true, error);
  is_over_ = bool{error};
}

void DatagramLink::begin() {
  if (is_over_) return;
  wait();
  ping();
}

void DatagramLink::end() {
  use(false);
  is_over_ = true;  // from now on neither function is called
  timer_.cancel();
  error_code ignored;
  socket_.close(ignored);
}

void DatagramLink::ping() {
  send({});
  if (std::chrono::steady_clock::now() - heard_ > silence) use(false);
  timer_.expires_after(ping_interval);
  timer_.async_wait([self = shared_from_this()](error_code error) {
    if (!error && !self->is_over_) self->ping();
  });
}

void DatagramLink::wait() {
  socket_.async_wait(DatagramSocket::wait_read, [self = shared_from_this()](error_code error) {
    if (error || self->is_over_) return;
    self->receive();
    if (!self->is_over_) self->wait();
  });
}

void DatagramLink::receive() {
  for (int n = 0; n < most_at_once && !is_over_; ++n) {
    error_code error;
    const std::size_t bytes = socket_.receive(asio::buffer(datagram_), 0, error);
    if (error == asio::error::would_block) return;
    if (error) continue;  // an answer of the network: no such port
    const auto message = message_of({datagram_.data(), bytes}, key_);
    if (!message) continue;
    heard_ = std::chrono::steady_clock::now();
    use(true);
    if (!message->empty()) take_(*message);
  }
}

void DatagramLink::use(bool used) {
  if (std::exchange(is_used_, used) != used) set_use_(used);
}

}  // namespace palpa::net
