#include "tests/devices/igtl_stand_in.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <stdexcept>

namespace palpa::test {
namespace {

std::string big_endian(std::uint64_t number, int bytes) {
  std::string out;
  for (int n = bytes - 1; n >= 0; --n) out += static_cast<char>(number >> (8 * n));
  return out;
}
std::string padded(std::string text, std::size_t length) {
  text.resize(length);
  return text;
}
/// Bit by bit.
std::uint64_t checksum(const std::string& body) {
  std::uint64_t crc = 0;
  for (const char letter : body) {
    crc ^= static_cast<std::uint64_t>(static_cast<unsigned char>(letter)) << 56;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 63) != 0 ? (crc << 1) ^ 0x42f0e1eba9ea3693u : crc << 1;
  }
  return crc;
}

}  // namespace

std::string igtl_message(const std::string& type, const std::string& name, const std::string& body, std::uint16_t version) {
  return big_endian(version, 2) + padded(type, 12) + padded(name, 20) + big_endian(0, 8) + big_endian(body.size(), 8) +
         big_endian(checksum(body), 8) + body;
}

std::string transform_message(const std::string& name, const SentPose& pose) {
  const auto& r = pose.rotation.row;
  std::string body;
  for (const double x : {r[0].x, r[1].x, r[2].x, r[0].y, r[1].y, r[2].y, r[0].z, r[1].z, r[2].z, pose.place_mm.x,
                         pose.place_mm.y, pose.place_mm.z})
    body += big_endian(std::bit_cast<std::uint32_t>(static_cast<float>(x)), 4);
  return igtl_message("TRANSFORM", name, body);
}

IgtlStandIn::IgtlStandIn() {
  listen_anew();
  thread_ = std::thread([this] { run(); });
}
IgtlStandIn::~IgtlStandIn() {
  ends_ = true;
  thread_.join();
  stop();
}

void IgtlStandIn::listen_anew() {
  listening_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int on = 1;
  ::setsockopt(listening_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port_);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  if (::bind(listening_, reinterpret_cast<sockaddr*>(&address), length) != 0 || ::listen(listening_, 8) != 0)
    throw std::runtime_error("no port for the stand-in");
  ::getsockname(listening_, reinterpret_cast<sockaddr*>(&address), &length);
  port_ = ntohs(address.sin_port);
}

void IgtlStandIn::stop() {
  const std::lock_guard lock(mutex_);
  for (const int client : clients_) ::close(client);
  clients_.clear();
  if (listening_ >= 0) ::close(listening_);
  listening_ = -1;
}
void IgtlStandIn::start() {
  const std::lock_guard lock(mutex_);
  if (listening_ < 0) listen_anew();
}
void IgtlStandIn::hold(const std::string& name, const SentPose& pose) {
  const std::lock_guard lock(mutex_);
  poses_[name] = pose;
}
void IgtlStandIn::hide(const std::string& name) {
  const std::lock_guard lock(mutex_);
  poses_.erase(name);
}
void IgtlStandIn::change(std::function<std::string(const std::string&)> change) {
  const std::lock_guard lock(mutex_);
  change_ = std::move(change);
}
int IgtlStandIn::clients() {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(clients_.size());
}
bool IgtlStandIn::has_received() { return has_received_; }

void IgtlStandIn::run() {
  for (; !ends_; std::this_thread::sleep_for(std::chrono::milliseconds(10))) {
    const std::lock_guard lock(mutex_);
    if (listening_ < 0) continue;
    for (int client; (client = ::accept4(listening_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC)) >= 0; ++connections_)
      clients_.push_back(client);
    std::string all;
    for (const auto& [name, pose] : poses_) {
      const std::string message = transform_message(name, pose);
      all += change_ ? change_(message) : message;
    }
    std::erase_if(clients_, [&](int client) {
      char received = 0;
      const ssize_t length = ::recv(client, &received, 1, MSG_DONTWAIT);
      if (length > 0) has_received_ = true;
      if (length != 0 && (all.empty() || ::send(client, all.data(), all.size(), MSG_NOSIGNAL) >= 0 || errno == EAGAIN))
        return false;
      ::close(client);
      return true;
    });
  }
}

}  // namespace palpa::test
