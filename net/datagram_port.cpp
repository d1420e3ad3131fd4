#include "net/datagram_port.h"

#include <sys/random.h>

#include <cerrno>

#include "palpa/base/load_error.h"

namespace palpa::net {
namespace {

using namespace std::chrono_literals;

// Datagrams [1] without a pause for the other work of the thread. More: a flood delays it; fewer: more waits.
constexpr int most_at_once = 64;

}  // namespace

DatagramKey random_key() {
  DatagramKey key;
  if (::getrandom(key.data(), key.size(), 0) != static_cast<ssize_t>(key.size()))
    throw LoadError("datagrams: the system gives no random numbers; try again");
  return key;
}

void DatagramBox::offer(std::span<const std::byte> datagram, const udp::endpoint& from) {
  const auto message = message_of(datagram, key_);
  if (!message || from.address() != from_) return;
  bool was_empty = false;
  {
    const std::lock_guard lock(mutex_);
    const auto now = std::chrono::steady_clock::now();
    if (now - second_ >= 1s) second_ = now, datagrams_ = 0;
    ++datagrams_;
    was_empty = count_ == 0;
    if (count_ == places) first_ = (first_ + 1) % places, --count_;
    Letter& letter = (*letters_)[(first_ + count_++) % places];
    letter.from = from;
    letter.bytes = message->size();
    std::ranges::copy(*message, letter.message.begin());
  }
  if (was_empty) ring_();
}

bool DatagramBox::take(Letter& letter) noexcept {
  const std::lock_guard lock(mutex_);
  if (count_ == 0) return false;
  const Letter& oldest = (*letters_)[first_];
  letter.from = oldest.from;
  letter.bytes = oldest.bytes;
  std::copy_n(oldest.message.begin(), oldest.bytes, letter.message.begin());
  first_ = (first_ + 1) % places, --count_;
  return true;
}

int DatagramBox::in_this_second() const noexcept {
  const std::lock_guard lock(mutex_);
  return datagrams_;
}

DatagramPort::DatagramPort(asio::io_context& context, const asio::ip::address& address, std::uint16_t port, bool is_any_free)
    : socket_(asio::make_strand(context)) {
  error_code error;
  socket_.open(address.is_v6() ? udp::v6() : udp::v4(), error);
  if (!error) socket_.bind({address, port}, error);
  if (error && is_any_free) socket_.bind({address, 0}, error);
  if (!error) socket_.non_blocking(true, error);
  if (!error) port_ = socket_.local_endpoint(error).port();
  if (error)
    throw LoadError(format_endpoint(address.to_string(), port) + ": no datagrams can come there (" + error.message() +
                    "); choose another --port, or leave out --datagrams");
  handle_ = socket_.native_handle();
}

void DatagramPort::end() {
  asio::post(socket_.get_executor(), [this] {
    ends_ = true;
    error_code ignored;
    socket_.cancel(ignored);
  });
}

void DatagramPort::open(const std::shared_ptr<DatagramBox>& box) {
  const std::lock_guard lock(mutex_);
  std::erase_if(boxes_, [](const auto& one) { return one.expired(); });
  boxes_.push_back(box);
}

void DatagramPort::wait() {
  socket_.async_wait(DatagramSocket::wait_read, [this](error_code error) {
    if (error || ends_) return;
    receive();
    wait();
  });
}

// All boxes look at each datagram: the time does not depend on whose key it has.
void DatagramPort::receive() {
  for (int n = 0; n < most_at_once; ++n) {
    error_code error;
    const std::size_t bytes = socket_.receive_from(asio::buffer(datagram_), from_, 0, error);
    if (error == asio::error::would_block) return;
    if (error) continue;  // an answer of the network to a datagram of ours
    const std::lock_guard lock(mutex_);
    for (const auto& box : boxes_)
      if (const auto open = box.lock()) open->offer({datagram_.data(), bytes}, from_);
  }
}

}  // namespace palpa::net
