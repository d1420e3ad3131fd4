#include "app/igtl_view.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <deque>
#include <optional>
#include <string>

#include "app/igtl_image.h"
#include "palpa/base/load_error.h"
#include "palpa/base/printed.h"
#include "palpa/base/sanitized.h"
#include "palpa/device/blocked_signals.h"

namespace palpa::app {
namespace {

using Clock = std::chrono::steady_clock;
using Shared = std::shared_ptr<const igtl::Bytes>;

constexpr std::size_t most_clients = 8;
// 30 Hz. Longer: jerky pictures; shorter: more work, and no smoother for an eye.
constexpr std::chrono::microseconds view_interval{33'333};
// Without a byte taken. Longer: more memory of the system is bound; shorter: a busy client is let go.
constexpr std::chrono::seconds patience{2};
// [messages] to a client, not yet sent. More: memory; fewer: a burst of events lets it go.
constexpr std::size_t most_waiting = 128;
// [bytes] read or sent at once. More: others are served later; fewer: more calls.
constexpr std::size_t piece_bytes = 65536;
// [bytes] of a client's messages that the system keeps. More: an idle client is noticed later; fewer: more wake-ups.
constexpr int send_buffer_bytes = 65536;

constexpr std::string_view own_types[] = {"TRANSFORM",  "STRING",    "STATUS",     "IMAGE",
                                          "CAPABILITY", "GET_IMAGE", "GET_STATUS", "GET_CAPABIL"};

Shared shared(igtl::Bytes bytes) { return std::make_shared<const igtl::Bytes>(std::move(bytes)); }
Shared message(std::string_view type, const std::string& name, const igtl::Bytes& body) {
  return shared(igtl::message_of(type, name, body));
}

/// "PalpaProbe"; of the second hand "PalpaProbe2".
std::string device_name(const char* what, std::size_t hand) {
  return std::string("Palpa") + what + (hand > 0 ? std::to_string(hand + 1) : std::string());
}

/// Pose in RAS of a point and a turn of the hand frame: the hand's axes where it is not turned.
igtl::RasPose ras_pose(const Similarity& hand_to_world, const Vec3& hand_m, const Turn& turn) {
  const Vec3 world_m = hand_to_world.to_world(hand_m);
  igtl::RasPose pose{.rotation = {}, .place_mm = {-1e3 * world_m.x, -1e3 * world_m.y, 1e3 * world_m.z}};
  const auto axis = [&](const Vec3& of_hand) { return hand_to_world.rotation * rotated(turn, of_hand); };
  const Vec3 x = axis({1, 0, 0}), y = axis({0, 1, 0}), z = axis({0, 0, 1});
  pose.rotation = {{{-x.x, -y.x, -z.x}, {-x.y, -y.y, -z.y}, {x.z, y.z, z.z}}};
  return pose;
}

std::string words_of(const IgtlEvent& event, std::size_t hand) {
  const std::string mode(event.mode.data(), ::strnlen(event.mode.data(), event.mode.size()));
  const std::string of_hand = hand > 0 ? "hand " + std::to_string(hand + 1) + ": " : std::string();
  const std::string lead = detail::text("%.3f s: ", event.t_s) + of_hand + detail::sanitized(mode);
  switch (event.event.kind) {
    case SessionEventKind::onset: return lead + detail::text(" holds at %g", event.event.value);
    case SessionEventKind::break_through:
      return lead + detail::text(" gives way at %g, %.2f mm deep", event.event.value, 1e3 * event.event.depth_m);
    case SessionEventKind::fault:
    case SessionEventKind::warning: break;
  }
  const char* const text = event.event.text;
  return lead + (mode.empty() ? "" : ": ") + (text != nullptr ? text : "");
}

struct Client {
  explicit Client(int its_socket) : socket(its_socket) {}
  ~Client() { ::close(socket); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  struct Waiting {
    Shared bytes;
    bool is_view;  // a newer one takes its place
  };
  int socket;
  igtl::MessageStream stream;
  std::deque<Waiting> waiting;
  std::size_t sent = 0;  // [bytes] of the first
  Clock::time_point moved = Clock::now();
  bool is_gone = false;
  bool awaits_image = false;
  std::string image;  // its name
};

void send_what_waits(Client& client) {
  for (std::size_t budget = 16; budget > 0 && !client.waiting.empty(); --budget) {
    const igtl::Bytes& bytes = *client.waiting.front().bytes;
    const std::size_t length = std::min(bytes.size() - client.sent, piece_bytes);
    const ssize_t sent = ::send(client.socket, bytes.data() + client.sent, length, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && (errno == EAGAIN || errno == EINTR)) break;
    if (sent <= 0) client.is_gone = true;
    if (sent <= 0) return;
    client.moved = Clock::now();
    client.sent += static_cast<std::size_t>(sent);
    if (client.sent < bytes.size()) continue;
    client.waiting.pop_front();
    client.sent = 0;
  }
  if (client.waiting.empty()) client.moved = Clock::now();
  client.is_gone = client.is_gone || Clock::now() - client.moved > patience;
}

void enqueue(Client& client, const Shared& bytes) {
  if (client.waiting.size() < most_waiting)
    client.waiting.push_back({bytes, false});
  else
    client.is_gone = true;
}

}  // namespace

/// The thread's side of a view.
class IgtlView::Server {
 public:
  explicit Server(IgtlView& view) : view_(view) {}

  void run() {
    for (auto next = Clock::now(); !view_.ends_;) {
      const bool is_busy = image_.has_value();
      exchange(is_busy ? std::chrono::milliseconds(0) : std::chrono::ceil<std::chrono::milliseconds>(next - Clock::now()));
      if (const auto now = Clock::now(); now >= next) {
        show();
        next = std::max(next + view_interval, now);
      }
      make_image();
    }
  }

 private:
  void exchange(std::chrono::milliseconds longest);
  void welcome();
  void read(Client& client);
  void obey(Client& client, const igtl::Head& head);
  void show();
  void make_image();
  void give_image(const Shared& bytes);
  Shared status() const;
  template <class Condition>
  void tell_all(const Shared& bytes, Condition condition) {
    for (const auto& client : clients_)
      if (condition(*client)) enqueue(*client, bytes);
  }
  void tell_all(const Shared& bytes) {
    tell_all(bytes, [](const Client&) { return true; });
  }

  IgtlView& view_;
  std::vector<std::unique_ptr<Client>> clients_;
  std::array<IgtlHandView, most_hands> seen_{};
  std::optional<IgtlImage> image_;
  std::string image_name_;  // as requested
};

void IgtlView::Server::exchange(std::chrono::milliseconds longest) {
  std::vector<pollfd> sockets{{.fd = view_.socket_, .events = POLLIN, .revents = 0}};
  for (const auto& client : clients_) {
    const short events = client->waiting.empty() ? POLLIN : POLLIN | POLLOUT;
    sockets.push_back({.fd = client->socket, .events = events, .revents = 0});
  }
  ::poll(sockets.data(), sockets.size(), static_cast<int>(std::max<std::chrono::milliseconds::rep>(0, longest.count())));
  for (std::size_t n = 0; n < clients_.size(); ++n) {
    Client& client = *clients_[n];
    if ((sockets[n + 1].revents & (POLLIN | POLLHUP | POLLERR)) != 0) read(client);
    if (!client.is_gone) send_what_waits(client);
  }
  std::erase_if(clients_, [](const auto& client) { return client->is_gone; });
  if ((sockets[0].revents & POLLIN) != 0) welcome();
}

void IgtlView::Server::welcome() {
  const int socket = ::accept4(view_.socket_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (socket < 0) return;
  auto client = std::make_unique<Client>(socket);
  if (clients_.size() >= most_clients) return;
  const int on = 1;
  ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  ::setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &send_buffer_bytes, sizeof send_buffer_bytes);
  enqueue(*client, status());
  clients_.push_back(std::move(client));
}

void IgtlView::Server::read(Client& client) {
  std::array<std::byte, piece_bytes> piece;
  const ssize_t length = ::recv(client.socket, piece.data(), piece.size(), MSG_DONTWAIT);
  if (length < 0 && (errno == EAGAIN || errno == EINTR)) return;
  const auto take = [&](const igtl::Head& head, std::span<const std::byte>) { obey(client, head); };
  const bool is_usable =
      length > 0 && client.stream.take(std::span<const std::byte>(piece).first(static_cast<std::size_t>(length)), take);
  client.is_gone = client.is_gone || !is_usable;
}

void IgtlView::Server::obey(Client& client, const igtl::Head& head) {
  const std::string_view type = igtl::word_of(head.type);
  if (client.waiting.size() > most_waiting / 2) return;  // requests without reading
  if (type == "GET_STATUS") {
    enqueue(client, status());
  } else if (type == "GET_CAPABIL") {
    enqueue(client, message("CAPABILITY", "Palpa", igtl::capability_body(own_types)));
  } else if (type == "GET_IMAGE" && !client.awaits_image) {
    client.awaits_image = true;
    client.image = igtl::word_of(head.name);
    view_.wants_scene_ = true;
  }
}

Shared IgtlView::Server::status() const {
  const IgtlHandView& first = seen_.front();
  if (!first.is_known) return message("STATUS", "Palpa", igtl::status_body(igtl::Status::not_ready, "waiting", "no tick yet"));
  const bool is_off = first.guard == GuardState::off || first.guard == GuardState::fault;
  const igtl::Status code = first.cause == GuardCause::panic ? igtl::Status::panic
                            : is_off                         ? igtl::Status::not_ready
                                                             : igtl::Status::ok;
  const std::string why = first.cause == GuardCause::none ? std::string() : std::string(": ") + format_cause(first.cause);
  return message("STATUS", "Palpa",
                 igtl::status_body(code, name_of(first.guard), std::string("guard ") + name_of(first.guard) + why));
}

void IgtlView::Server::show() {
  std::vector<Shared> views;
  bool is_news = false;
  for (std::size_t hand = 0; hand < most_hands; ++hand) {
    const IgtlHandView& now = view_.hands_[hand].view.take();
    const IgtlHandView before = std::exchange(seen_[hand], now);
    const bool is_change = now.is_known != before.is_known || now.guard != before.guard || now.cause != before.cause;
    is_news = is_news || (hand == 0 && is_change);
    if (!now.is_known) continue;
    const auto add = [&](const char* what, const Vec3& at_m, const Turn& turn) {
      views.push_back(
          message("TRANSFORM", device_name(what, hand), igtl::transform_body(ras_pose(now.hand_to_world, at_m, turn))));
    };
    if (now.has_probe) add("Probe", now.probe_m, now.probe_turn);
    add("Proxy", now.proxy_m, now.proxy_turn);
  }
  if (is_news) tell_all(status());
  for (std::size_t hand = 0; hand < most_hands; ++hand)
    for (IgtlEvent event; view_.hands_[hand].take(event);)
      tell_all(message("STRING", device_name("Event", hand), igtl::string_body(words_of(event, hand))));
  for (const auto& client : clients_) {
    const bool has_view = std::ranges::any_of(client->waiting, [](const Client::Waiting& one) { return one.is_view; });
    if (has_view) continue;  // it reads slower than these come: it gets the next
    for (const Shared& view : views) client->waiting.push_back({view, true});
  }
}

void IgtlView::Server::make_image() {
  const auto refuse = [&](const char* why) {
    give_image(message("STATUS", "Palpa", igtl::status_body(igtl::Status::not_found, "image", why)));
    image_.reset();
  };
  try {
    if (image_) {
      if (!image_->step()) {
        give_image(shared(image_->message()));
        image_.reset();
      }
      return;
    }
    const auto asks = std::ranges::find_if(clients_, [](const auto& client) { return client->awaits_image; });
    if (asks == clients_.end()) return;
    std::shared_ptr<const Scene> scene;
    {
      const std::lock_guard lock(view_.mutex_);
      scene = std::exchange(view_.scene_, nullptr);
    }
    if (!scene) return;
    image_name_ = (*asks)->image;
    image_.emplace(*scene, image_name_);
  } catch (const std::bad_alloc&) {
    refuse("not enough memory");
  } catch (const std::exception& error) {
    refuse(error.what());
  }
}

/// To all clients that have requested it.
void IgtlView::Server::give_image(const Shared& bytes) {
  for (const auto& client : clients_) {
    if (!client->awaits_image || client->image != image_name_) continue;
    client->awaits_image = false;
    enqueue(*client, bytes);
  }
  const bool more = std::ranges::any_of(clients_, [](const auto& client) { return client->awaits_image; });
  if (more) view_.wants_scene_ = true;
}

IgtlView::IgtlView(std::uint16_t port) {
  const auto refuse = [&] {
    const std::string why = std::strerror(errno);
    if (socket_ >= 0) ::close(socket_);
    throw LoadError("--igtl " + std::to_string(port) + ": port cannot be had (" + why + "); choose another");
  };
  socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket_ < 0) refuse();
  const int on = 1;
  ::setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  if (::bind(socket_, reinterpret_cast<const sockaddr*>(&address), length) != 0) refuse();
  if (::listen(socket_, static_cast<int>(most_clients)) != 0) refuse();
  if (::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &length) != 0) refuse();
  port_ = ntohs(address.sin_port);
  const detail::BlockedSignals in_the_thread;
  thread_ = std::thread([this] {
    constexpr int nice = 10;  // of this thread: the loop's comes first
    ::setpriority(PRIO_PROCESS, 0, nice);
    while (!ends_) {
      try {
        Server(*this).run();
      } catch (const std::exception&) {  // no memory: without its clients it begins anew
      }
    }
  });
}

IgtlView::~IgtlView() {
  ends_ = true;
  thread_.join();
  ::close(socket_);
}

void IgtlView::tick(std::size_t hand, const TickFrame& frame, const Session& felt) noexcept {
  if (hand >= most_hands) return;
  const Tick& tick = frame.result;
  hands_[hand].view.give({.is_known = true,
                          .has_probe = tick.probe_valid && is_finite(tick.probe_m) && is_unit(tick.probe_turn, 0.01),
                          .hand_to_world = felt.hand_to_world(),
                          .probe_m = tick.probe_m,
                          .proxy_m = tick.proxy_m,
                          .probe_turn = tick.probe_turn,
                          .proxy_turn = tick.proxy_turn,
                          .guard = frame.command.guard,
                          .cause = frame.command.cause});
  for (const SessionEvent& event : felt.events()) hands_[hand].note(event, frame.t_s, felt.scene());
}

void IgtlView::leave(std::size_t hand) noexcept {
  if (hand < most_hands) hands_[hand].view.give({});
}

void IgtlView::Hand::note(const SessionEvent& event, double t_s, const Scene& scene) noexcept {
  const std::size_t number = written.load(std::memory_order_relaxed);
  if (number - read.load(std::memory_order_acquire) == most_events) return;
  IgtlEvent& place = events[number % most_events];
  place = {.event = event, .t_s = t_s, .mode = {}};
  if (event.mode >= 0 && static_cast<std::size_t>(event.mode) < scene.modes().size()) {
    const std::string& name = scene.modes()[static_cast<std::size_t>(event.mode)].name;
    std::copy_n(name.begin(), std::min(name.size(), place.mode.size()), place.mode.begin());
  }
  written.store(number + 1, std::memory_order_release);
}

bool IgtlView::Hand::take(IgtlEvent& event) noexcept {
  const std::size_t number = read.load(std::memory_order_relaxed);
  if (number == written.load(std::memory_order_acquire)) return false;
  event = events[number % most_events];
  read.store(number + 1, std::memory_order_release);
  return true;
}

void IgtlView::give(const Scene& scene) {
  auto copy = std::make_shared<const Scene>(scene);
  const std::lock_guard lock(mutex_);
  scene_ = std::move(copy);
}

}  // namespace palpa::app
