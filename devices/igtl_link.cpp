#include "devices/igtl_link.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>

#include "palpa/device/turn_of.h"

namespace palpa::igtl {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// Longer: a tracker that is hidden goes on where it was seen last; shorter: trackers below 10 Hz are faulty.
constexpr double pose_lifetime_s = 0.1;
// Longer: the thread ends later; shorter: more wake-ups.
constexpr milliseconds look_interval{20};
// Of a connection's attempt. Longer: later back; shorter: a busy server is refused.
constexpr milliseconds connect_deadline{1000};
// Between attempts to connect. Longer: later back; shorter: more futile attempts.
constexpr milliseconds retry_interval{300};
// Without a whole message, though bytes come. Longer: a length that is wrong is waited for; shorter: a large image on a slow
// link is cut off.
constexpr std::chrono::seconds message_deadline{2};
// Of a search. Longer: 'palpa devices' takes longer; shorter: slow trackers are not found.
constexpr milliseconds search_duration{500};
// More: a long sentence; fewer: a name may be missing in it.
constexpr std::size_t most_names = 16;
// [bytes] read at once. More: memory; fewer: more calls.
constexpr std::size_t piece_bytes = 16384;

constexpr const char* not_there = "the tracker's OpenIGTLink server is not there";
constexpr const char* nonsense = "the tracker's server sends no OpenIGTLink";
constexpr const char* silent = "no pose of the tracker for 100 ms; it is hidden, or off";

double seconds(Clock::time_point time) { return std::chrono::duration<double>(time.time_since_epoch()).count(); }

/// Hand frame of a user in front of the patient: x is the patient's left, y the head, z the front.
constexpr Mat3 hand_from_ras{{{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}}};

class Socket {
 public:
  explicit Socket(int number) : number_(number) {}
  ~Socket() {
    if (number_ >= 0) ::close(number_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int number() const noexcept { return number_; }

 private:
  int number_;
};

bool is_ready(int socket, short events, milliseconds longest) {
  pollfd one{.fd = socket, .events = events, .revents = 0};
  return ::poll(&one, 1, static_cast<int>(longest.count())) > 0;
}

/// Whether it connects in time. \param ends  ends the attempt
bool connects(int socket, const Service& service, const std::atomic<bool>& ends) {
  if (socket < 0) return false;
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&service.address), service.length) == 0) return true;
  if (errno != EINPROGRESS) return false;
  for (const auto end = Clock::now() + connect_deadline; !ends && Clock::now() < end;) {
    if (!is_ready(socket, POLLOUT, look_interval)) continue;
    int error = 0;
    socklen_t length = sizeof error;
    return ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &length) == 0 && error == 0;
  }
  return false;
}

int new_socket(const Service& service) {
  return ::socket(service.address.ss_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
}

/// Passes received bytes to `stream`. False: the connection has ended, or is of no use.
template <class Message>
bool pass(int socket, MessageStream& stream, Message&& message, bool& is_usable) {
  if (!is_ready(socket, POLLIN, look_interval)) return true;
  std::array<std::byte, piece_bytes> piece;
  const ssize_t length = ::recv(socket, piece.data(), piece.size(), 0);
  if (length < 0) return errno == EAGAIN || errno == EINTR;
  is_usable = stream.take(std::span<const std::byte>(piece).first(static_cast<std::size_t>(length)), message);
  return length > 0 && is_usable;
}

void note(std::vector<std::string>& names, std::string_view name) {
  if (names.size() < most_names && std::ranges::find(names, name) == names.end()) names.emplace_back(name);
}

}  // namespace

std::optional<Service> service_at(const std::string& host, std::uint16_t port) {
  Service service;
  sockaddr_in v4{};
  sockaddr_in6 v6{};
  const std::string digits = host == "localhost" ? "127.0.0.1" : host;
  if (::inet_pton(AF_INET, digits.c_str(), &v4.sin_addr) == 1) {
    v4.sin_family = AF_INET;
    v4.sin_port = htons(port);
    std::copy_n(reinterpret_cast<const char*>(&v4), sizeof v4, reinterpret_cast<char*>(&service.address));
    service.length = sizeof v4;
    service.is_loopback = (ntohl(v4.sin_addr.s_addr) >> 24) == 127;
    service.words = digits + ':' + std::to_string(port);
  } else if (::inet_pton(AF_INET6, digits.c_str(), &v6.sin6_addr) == 1) {
    v6.sin6_family = AF_INET6;
    v6.sin6_port = htons(port);
    std::copy_n(reinterpret_cast<const char*>(&v6), sizeof v6, reinterpret_cast<char*>(&service.address));
    service.length = sizeof v6;
    service.is_loopback = IN6_IS_ADDR_LOOPBACK(&v6.sin6_addr);
    service.words = '[' + digits + "]:" + std::to_string(port);
  } else {
    return std::nullopt;
  }
  return service;
}

std::optional<std::vector<std::string>> names_at(const Service& service) {
  const std::atomic<bool> never{false};
  const Socket socket(new_socket(service));
  if (!connects(socket.number(), service, never)) return std::nullopt;
  std::vector<std::string> names;
  MessageStream stream;
  bool is_usable = true;
  const auto message = [&](const Head& head, std::span<const std::byte> body) {
    if (word_of(head.type) == "TRANSFORM" && pose_of(content_of(head, body))) note(names, word_of(head.name));
  };
  for (const auto end = Clock::now() + search_duration; Clock::now() < end;)
    if (!pass(socket.number(), stream, message, is_usable)) break;
  if (!is_usable) return std::nullopt;
  return names;
}

DeviceState ReadingWalk::at(double time_s, const Reading& reading) noexcept {
  constexpr double newest_share = 0.2;  // [1] of the newest period in their mean. More: jitter is felt; less: late changes
  constexpr double shortest_period_s = 1e-3;
  DeviceState state{.time_s = reading.time_s, .fault = reading.fault};
  const bool is_late = reading.number == 0 || time_s - reading.time_s > pose_lifetime_s;
  if (state.fault == nullptr && is_late) state.fault = silent;
  state.position_m = to_m_;
  if (state.fault != nullptr) {
    number_ = 0;
    turn_.reset();
    return state;
  }
  if (number_ == 0) {
    from_m_ = to_m_ = reading.position_m;
  } else if (number_ != reading.number) {
    const double share = std::clamp((time_s - read_s_) / period_s_, 0.0, 1.0);
    from_m_ += share * (to_m_ - from_m_);
    to_m_ = reading.position_m;
    period_s_ += newest_share * (std::clamp(reading.time_s - arrived_s_, shortest_period_s, pose_lifetime_s) - period_s_);
  }
  if (number_ != reading.number) {
    number_ = reading.number;
    arrived_s_ = reading.time_s;
    read_s_ = time_s;
  }
  const double share = std::clamp((time_s - read_s_) / period_s_, 0.0, 1.0);
  state.position_m = share < 1.0 ? from_m_ + share * (to_m_ - from_m_) : to_m_;
  state.velocity_m_per_s = share < 1.0 ? (to_m_ - from_m_) / period_s_ : Vec3{};
  state.turn = turn_.at(time_s, reading.turn);
  state.valid = true;
  return state;
}

TrackerLink::TrackerLink(const Service& service, const std::string& name, bool here)
    : service_(service), begins_here_(here), name_(name) {
  readings_.give({.fault = not_there});
  thread_ = std::thread([this] { run(); });
}

TrackerLink::~TrackerLink() {
  ends_ = true;
  thread_.join();
}

DeviceState TrackerLink::read() noexcept { return walk_.at(seconds(Clock::now()), readings_.take()); }

bool TrackerLink::wait(double longest_s) {
  const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(longest_s));
  while (!has_pose_ && Clock::now() < end) std::this_thread::sleep_for(milliseconds(5));
  return has_pose_;
}

std::string TrackerLink::name() const {
  const std::lock_guard lock(mutex_);
  return name_;
}

std::vector<std::string> TrackerLink::names() const {
  const std::lock_guard lock(mutex_);
  return names_;
}

void TrackerLink::run() noexcept {
  while (!ends_) {
    try {
      const Socket socket(new_socket(service_));
      if (connects(socket.number(), service_, ends_)) listen_to(socket.number());
    } catch (const std::exception&) {  // no memory for a name
    }
    if (now_.fault != nonsense) publish(not_there);
    for (const auto end = Clock::now() + retry_interval; !ends_ && Clock::now() < end;)
      std::this_thread::sleep_for(milliseconds(5));
  }
}

void TrackerLink::listen_to(int socket) {
  stream_.begin();
  publish(silent);
  bool is_usable = true;
  auto whole_at = Clock::now();
  while (!ends_ && is_usable) {
    const auto message = [this](const Head& head, std::span<const std::byte> body) { take(head, body); };
    if (!pass(socket, stream_, message, is_usable)) break;
    if (!stream_.is_within()) whole_at = Clock::now();
    if (Clock::now() - whole_at > message_deadline) is_usable = false;
  }
  if (!is_usable) publish(nonsense);
}

void TrackerLink::take(const Head& head, std::span<const std::byte> body) {
  if (word_of(head.type) != "TRANSFORM") return;
  const std::optional<RasPose> pose = pose_of(content_of(head, body));
  if (!pose) return;
  {
    const std::lock_guard lock(mutex_);
    note(names_, word_of(head.name));
    if (name_.empty()) name_ = word_of(head.name);
    if (word_of(head.name) != name_) return;
  }
  const Vec3 position_m = 1e-3 * (hand_from_ras * pose->place_mm);
  if (!origin_m_) origin_m_ = begins_here_ ? position_m : Vec3{};
  now_.position_m = position_m - *origin_m_;
  now_.turn = turn_of(hand_from_ras * pose->rotation * transposed(hand_from_ras));
  now_.number = ++poses_;
  now_.time_s = seconds(Clock::now());
  publish(nullptr);
  has_pose_ = true;
}

void TrackerLink::publish(const char* fault) noexcept {
  now_.fault = fault;
  readings_.give(now_);
}

}  // namespace palpa::igtl
