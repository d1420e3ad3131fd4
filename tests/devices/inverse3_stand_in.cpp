#include "tests/devices/inverse3_stand_in.h"

#include <array>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <deque>
#include <future>
#include <mutex>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

namespace palpa::test {

namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::asio::ip::tcp;
using boost::system::error_code;
using nlohmann::json;
using Clock = std::chrono::steady_clock;
using Manner = Inverse3StandIn::Manner;
using std::chrono::milliseconds;

// The service's: lifetime of a force without a further message.
constexpr milliseconds force_lifetime{50};
constexpr milliseconds slow_by{40};
constexpr std::chrono::microseconds pace{1000};
// Of a grip's orientation.
constexpr milliseconds grip_interval{20};
constexpr milliseconds drip_interval{5};
constexpr std::size_t fragment_bytes = 7;
// Of a frame with a huge declared length, before the stand-in waits for the reaction.
constexpr std::size_t huge_bytes = std::size_t{1} << 20;
constexpr std::size_t most_kept_messages = 200;
constexpr const char* own_id = "049D";

json quaternion_of(const Turn& turn) { return {{"w", turn.w}, {"x", turn.x}, {"y", turn.y}, {"z", turn.z}}; }
json vector_of(const Vec3& v) { return {{"x", v.x}, {"y", v.y}, {"z", v.z}}; }

/// A frame by RFC 6455, of a server: not masked.
std::string frame(unsigned first_byte, std::uint64_t says_bytes, const std::string& payload) {
  std::string out(1, static_cast<char>(first_byte));
  const auto length = [&](int bytes) {
    for (int i = bytes - 1; i >= 0; --i) out += static_cast<char>((says_bytes >> (8 * i)) & 0xff);
  };
  if (says_bytes < 126) {
    length(1);
  } else if (says_bytes < 65536) {
    out += static_cast<char>(126);
    length(2);
  } else {
    out += static_cast<char>(127);
    length(8);
  }
  return out + payload;
}
std::string frame(unsigned first_byte, const std::string& payload) { return frame(first_byte, payload.size(), payload); }

constexpr unsigned last = 0x80, more = 0x00, text_frame = 0x1, continuation = 0x0, binary_frame = 0x2, ping_frame = 0x9,
                   unknown_frame = 0x5;

std::string fragments(const std::string& text, bool has_end) {
  std::string out;
  for (std::size_t at = 0; at < text.size(); at += fragment_bytes) {
    const bool is_last = has_end && at + fragment_bytes >= text.size();
    out += frame((is_last ? last : more) | (at == 0 ? text_frame : continuation), text.substr(at, fragment_bytes));
  }
  return out;
}

/// Leaves out unchanged entries; vectors as a whole.
json without_repeats(const json& now, const json& before) {
  if (!now.is_object() || !before.is_object() || now.contains("x")) return now;
  json out = json::object();
  for (const auto& [key, value] : now.items()) {
    if (before.contains(key) && before[key] == value && key != "device_id") continue;
    const bool goes_deeper = value.is_object() && before.contains(key) && !value.contains("x");
    out[key] = goes_deeper ? without_repeats(value, before[key]) : value;
  }
  return out;
}

}  // namespace

class Inverse3StandIn::Server {
 public:
  explicit Server(std::uint16_t port) : listener_(context_, tcp::endpoint(boost::asio::ip::address_v4::loopback(), port)) {
    port_ = listener_.local_endpoint().port();
    listen();
    thread_ = std::thread([this] {
      const auto goes_on = boost::asio::make_work_guard(context_);  // also without a connection or a listener
      context_.run();
    });
  }
  ~Server() {
    boost::asio::post(context_, [this] { close_all(); });
    boost::asio::post(context_, [this] { context_.stop(); });
    thread_.join();
  }

  class Session;

  /// Runs in the server's thread, and waits for it.
  template <class Do>
  void in_thread(Do what) {
    std::promise<void> done;
    boost::asio::post(context_, [&] {
      what();
      done.set_value();
    });
    done.get_future().wait();
  }
  void close_all();
  void start() {
    listener_ = tcp::acceptor(context_);
    listener_.open(tcp::v4());
    listener_.set_option(tcp::acceptor::reuse_address(true));
    listener_.bind({boost::asio::ip::address_v4::loopback(), port_});
    listener_.listen();
    listen();
  }

  Vec3 made_force_n() const {
    if (!has_power || !is_there || Clock::now() - last_message > force_lifetime) return {};
    return force_scale * commanded_n;
  }
  json entry(const std::string& id) const {
    return {
        {"device_id", id},
        {"config",
         {{"type", "inverse3"},
          {"device_info", {{"id", 1}, {"major_version", 6}, {"minor_version", 2}, {"uuid", "stand-in"}}},
          {"handedness", "right"},
          {"preset", "defaults"},
          {"gravity_compensation", {{"enabled", true}, {"scaling_factor", 1.0}}}}},
        {"state",
         {{"cursor_position", vector_of(id == own_id ? position_m : Vec3{0.5, 0.5, 0.5})},
          {"cursor_velocity", vector_of(velocity_m_per_s)},
          {"angular_position", {{"a0", 0.5}, {"a1", 1.5}, {"a2", 2.5}}},
          {"body_orientation", {{"w", 1}, {"x", 0}, {"y", 0}, {"z", 0}}},
          {"current_cursor_force", vector_of(made_force_n())},
          {"control_domain", "cartesian"},
          {"control_mode", "force"},
          {"transform", json::object()}}},
        {"status",
         {{"calibrated", is_calibrated}, {"in_use", true}, {"power_supply", has_power}, {"ready", true}, {"started", true}}}};
  }
  json told() {
    if (const auto now = Clock::now(); now - grip_read >= grip_interval) {
      grip_read = now;
      grip_shown = grip_turn;
    }
    json arms = json::array();
    if (has_second) arms.push_back(entry("0BEE"));
    if (is_there) arms.push_back(entry(own_id));
    const json wired{{"device_id", "61548"}, {"state", {{"button", wired_button}, {"hall", 12}}}};
    const json wireless{{"device_id", "65280"},
                        {"state",
                         {{"buttons", {{"a", wireless_buttons[0]}, {"b", wireless_buttons[1]}, {"c", wireless_buttons[2]}}},
                          {"orientation", quaternion_of(grip_shown)},
                          {"battery_level", 0.75}}},
                        {"status", {{"connected", !is_grip_gone}, {"awake", true}, {"ready", true}}}};
    json all_wireless = json::array();
    if (has_grip) all_wireless.push_back(wireless);
    return {{"session_id", 3}, {"inverse3", arms}, {"verse_grip", {wired}}, {"wireless_verse_grip", all_wireless}};
  }

  boost::asio::io_context context_;
  tcp::acceptor listener_;
  std::uint16_t port_ = 0;
  std::set<std::shared_ptr<Session>> sessions_;
  std::thread thread_;

  // Owned by the server's thread.
  Vec3 position_m, velocity_m_per_s, commanded_n, last_word_n;
  Turn grip_turn, grip_shown;
  Clock::time_point last_message, grip_read;
  bool has_power = true, is_calibrated = true, is_there = true, has_second = false, is_second_touched = false;
  bool has_grip = true, is_grip_gone = false;
  double force_scale = 1.0;
  bool wired_button = false;
  std::array<bool, 3> wireless_buttons{};
  std::string version = "3.5.1";
  bool knows_vector = true, knows_values = true, tells_all = true;
  Manner manner = Manner::whole;
  std::function<std::string(const std::string&)> change;
  bool changes_snapshots = false;
  std::vector<std::string> first_messages;
  std::deque<std::string> last_messages;
  std::int64_t messages = 0, good_byes = 0;
  std::function<void(const Received&)> watch;

 private:
  void listen();
};

/// One connection. Keeps itself until it is closed.
class Inverse3StandIn::Server::Session : public std::enable_shared_from_this<Session> {
 public:
  Session(Server& server, tcp::socket socket) : server_(server), stream_(std::move(socket)), timer_(server.context_) {
    stream_.next_layer().set_option(tcp::no_delay(true));
  }
  void begin() {
    server_.sessions_.insert(shared_from_this());
    http::async_read(stream_.next_layer(), buffer_, request_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error) return self->end();
      if (!websocket::is_upgrade(self->request_)) return self->answer_page();
      self->stream_.async_accept(self->request_, [self](error_code failed) {
        if (failed) return self->end();
        const json all = self->server_.told();
        self->told_ = all;
        const auto& server = self->server_;
        const std::string text = server.change && server.changes_snapshots ? server.change(all.dump()) : all.dump();
        self->put(frame(last | text_frame, text));
        self->read();
      });
    });
  }
  void end() {
    timer_.cancel();
    error_code ignored;
    stream_.next_layer().close(ignored);
    if (server_.sessions_.erase(shared_from_this()) > 0 && has_sent_) server_.commanded_n = {};
  }

 private:
  void answer_page() {
    const bool is_known = request_.target() == "/version" && !server_.version.empty();
    page_.result(is_known ? http::status::ok : http::status::not_found);
    page_.body() =
        is_known ? json{{"ok", true}, {"data", {{"git_tag", server_.version}, {"project_version", server_.version}}}}.dump()
                 : json{{"ok", false}, {"error", "no such page"}}.dump();
    page_.prepare_payload();
    http::async_write(stream_.next_layer(), page_, [self = shared_from_this()](error_code, std::size_t) { self->end(); });
  }

  void read() {
    stream_.async_read(buffer_, [self = shared_from_this()](error_code error, std::size_t) {
      // With any error: the answer to a close frame fails where the browser has hung up by then.
      if (error && self->stream_.reason().code == websocket::close_code::normal) ++self->server_.good_byes;
      if (error) return self->end();
      self->take(beast::buffers_to_string(self->buffer_.data()));
      self->buffer_.consume(self->buffer_.size());
      self->read();
    });
  }

  void take(const std::string& text) {
    if (!has_sent_) server_.first_messages.push_back(text);
    has_sent_ = true;
    ++server_.messages;
    server_.last_messages.push_back(text);
    if (server_.last_messages.size() > most_kept_messages) server_.last_messages.pop_front();
    obey(json::parse(text));
    if (server_.watch)
      server_.watch({server_.commanded_n, std::chrono::duration<double>(server_.last_message - put_at_).count()});
    answer();
  }

  void obey(const json& message) {
    server_.last_message = Clock::now();
    server_.commanded_n = {};
    if (message.contains("session") && message["session"].contains("force_render_full_state")) told_ = json::object();
    for (const json& device : message.value("inverse3", json::array())) {
      if (device.at("device_id") != own_id) server_.is_second_touched = true;
      if (device.at("device_id") != own_id) continue;
      const json& command = device.at("commands").at("set_cursor_force");
      const char* word = command.contains("vector") && server_.knows_vector   ? "vector"
                         : command.contains("values") && server_.knows_values ? "values"
                                                                              : nullptr;
      if (word == nullptr) continue;
      const json& force = command.at(word);
      server_.commanded_n = {force.at("x").get<double>(), force.at("y").get<double>(), force.at("z").get<double>()};
      server_.last_word_n = server_.commanded_n;
    }
  }

  std::string next_text() {
    const json all = server_.told();
    json now = all;
    if (!server_.tells_all && told_.is_object() && !told_.empty()) {
      for (const char* list : {"inverse3", "verse_grip", "wireless_verse_grip"}) {
        for (json& entry : now[list]) {
          for (const json& before : told_[list]) {
            if (before["device_id"] == entry["device_id"]) entry = without_repeats(entry, before);
          }
        }
      }
    }
    told_ = all;
    return server_.change ? server_.change(now.dump()) : now.dump();
  }

  void answer() {
    const std::string text = next_text();
    switch (server_.manner) {
      case Manner::whole: return put(frame(last | text_frame, text));
      case Manner::fragments: return put(fragments(text, true));
      case Manner::pings:
        return put(frame(last | ping_frame, "a") + frame(last | text_frame, text) + frame(last | ping_frame, ""));
      case Manner::paced: return later(put_at_ + pace, frame(last | text_frame, text));
      case Manner::slow: return later(Clock::now() + slow_by, frame(last | text_frame, text));
      case Manner::drip: return drip(frame(last | text_frame, text), 0);
      case Manner::silent: return;
      case Manner::flood: return flood(frame(last | text_frame, text));
      case Manner::twice: return put(frame(last | text_frame, text) + frame(last | text_frame, text));
      case Manner::binary: return put(frame(last | binary_frame, text));
      case Manner::huge: return put(frame(last | text_frame, std::uint64_t{1} << 40, std::string(huge_bytes, ' ')));
      case Manner::endless: return put(fragments(std::string(huge_bytes, ' '), false));
      case Manner::wrong_frame: return put(frame(last | unknown_frame, text));
      case Manner::goes_away: return put(frame(0x88, std::string("\x03\xe9", 2) + "going away"));
      case Manner::hangs_up: return end();
    }
  }

  /// Queues bytes of all callers for writing in order.
  void put(std::string bytes) {
    put_at_ = Clock::now();
    waiting_.push_back(std::move(bytes));
    if (waiting_.size() == 1) put_next();
  }
  void put_next() {
    boost::asio::async_write(stream_.next_layer(), boost::asio::buffer(waiting_.front()),
                             [self = shared_from_this()](error_code error, std::size_t) {
                               if (error) return self->end();
                               self->waiting_.pop_front();
                               if (!self->waiting_.empty()) self->put_next();
                             });
  }
  void later(Clock::time_point time, std::string bytes) {
    timer_.expires_at(time);
    timer_.async_wait([self = shared_from_this(), bytes = std::move(bytes)](error_code error) {
      if (!error) self->put(bytes);
    });
  }
  void drip(std::string bytes, std::size_t at) {
    if (at >= bytes.size()) return;
    put(bytes.substr(at, 1));
    timer_.expires_after(drip_interval);
    timer_.async_wait([self = shared_from_this(), bytes = std::move(bytes), at](error_code error) {
      if (!error) self->drip(bytes, at + 1);
    });
  }
  void flood(std::string bytes) {
    if (server_.manner != Manner::flood || !stream_.next_layer().is_open()) return;
    constexpr std::size_t most_waiting = 4;
    if (waiting_.size() < most_waiting) put(bytes);
    boost::asio::post(server_.context_, [self = shared_from_this(), bytes = std::move(bytes)] { self->flood(bytes); });
  }

  Server& server_;
  websocket::stream<tcp::socket> stream_;
  boost::asio::steady_timer timer_;
  beast::flat_buffer buffer_;
  http::request<http::string_body> request_;
  http::response<http::string_body> page_;
  std::deque<std::string> waiting_;
  Clock::time_point put_at_;
  json told_;
  bool has_sent_ = false;
};

void Inverse3StandIn::Server::listen() {
  listener_.async_accept([this](error_code error, tcp::socket socket) {
    if (error) return;
    std::make_shared<Session>(*this, std::move(socket))->begin();
    listen();
  });
}

void Inverse3StandIn::Server::close_all() {
  error_code ignored;
  listener_.close(ignored);
  const auto all = sessions_;
  for (const auto& session : all) session->end();
}

Inverse3StandIn::Inverse3StandIn(std::uint16_t port) : server_(std::make_unique<Server>(port)) {}
Inverse3StandIn::~Inverse3StandIn() = default;
std::uint16_t Inverse3StandIn::port() const { return server_->port_; }

void Inverse3StandIn::hold(const Vec3& position_m, const Vec3& velocity_m_per_s) {
  server_->in_thread([&] {
    server_->position_m = position_m;
    server_->velocity_m_per_s = velocity_m_per_s;
  });
}
Vec3 Inverse3StandIn::force_n() {
  Vec3 force;
  server_->in_thread([&] { force = server_->made_force_n(); });
  return force;
}
Vec3 Inverse3StandIn::last_word_n() {
  Vec3 word;
  server_->in_thread([&] { word = server_->last_word_n; });
  return word;
}
bool Inverse3StandIn::is_second_touched() {
  bool is_touched = false;
  server_->in_thread([&] { is_touched = server_->is_second_touched; });
  return is_touched;
}
void Inverse3StandIn::turn_grip(const Turn& turn) {
  server_->in_thread([&] { server_->grip_turn = turn; });
}
void Inverse3StandIn::connect_grip(bool there) {
  server_->in_thread([&] { server_->has_grip = there; });
}
void Inverse3StandIn::tell_grip_is_gone(bool gone) {
  server_->in_thread([&] { server_->is_grip_gone = gone; });
}
void Inverse3StandIn::turn_power(bool on) {
  server_->in_thread([&] { server_->has_power = on; });
}
void Inverse3StandIn::calibrate(bool done) {
  server_->in_thread([&] { server_->is_calibrated = done; });
}
void Inverse3StandIn::connect_device(bool there) {
  server_->in_thread([&] { server_->is_there = there; });
}
void Inverse3StandIn::connect_second_device(bool there) {
  server_->in_thread([&] { server_->has_second = there; });
}
void Inverse3StandIn::scale_forces(double factor) {
  server_->in_thread([&] { server_->force_scale = factor; });
}
void Inverse3StandIn::press_wired(bool down) {
  server_->in_thread([&] { server_->wired_button = down; });
}
void Inverse3StandIn::press_wireless(int number, bool down) {
  server_->in_thread([&] { server_->wireless_buttons.at(static_cast<std::size_t>(number)) = down; });
}
void Inverse3StandIn::set_version(const std::string& version) {
  server_->in_thread([&] { server_->version = version; });
}
void Inverse3StandIn::understand(bool vector, bool values) {
  server_->in_thread([&] {
    server_->knows_vector = vector;
    server_->knows_values = values;
  });
}
void Inverse3StandIn::tell_all(bool all) {
  server_->in_thread([&] { server_->tells_all = all; });
}
void Inverse3StandIn::send(Manner manner) {
  server_->in_thread([&] { server_->manner = manner; });
}
void Inverse3StandIn::change_texts(std::function<std::string(const std::string&)> change, bool snapshots_too) {
  server_->in_thread([&] {
    server_->change = std::move(change);
    server_->changes_snapshots = snapshots_too;
  });
}
void Inverse3StandIn::stop() {
  server_->in_thread([&] { server_->close_all(); });
}
void Inverse3StandIn::start() {
  server_->in_thread([&] { server_->start(); });
}
void Inverse3StandIn::watch(std::function<void(const Received&)> watch) {
  server_->in_thread([&] { server_->watch = std::move(watch); });
}
std::vector<std::string> Inverse3StandIn::first_messages() {
  std::vector<std::string> out;
  server_->in_thread([&] { out = server_->first_messages; });
  return out;
}
std::vector<std::string> Inverse3StandIn::last_messages(std::size_t most) {
  std::vector<std::string> out;
  server_->in_thread([&] {
    const auto& kept = server_->last_messages;
    out.assign(kept.end() - static_cast<std::ptrdiff_t>(std::min(most, kept.size())), kept.end());
  });
  return out;
}
std::int64_t Inverse3StandIn::messages() {
  std::int64_t count = 0;
  server_->in_thread([&] { count = server_->messages; });
  return count;
}
std::int64_t Inverse3StandIn::good_byes() {
  std::int64_t count = 0;
  server_->in_thread([&] { count = server_->good_byes; });
  return count;
}
std::int64_t Inverse3StandIn::connections() {
  std::int64_t count = 0;
  server_->in_thread([&] { count = static_cast<std::int64_t>(server_->sessions_.size()); });
  return count;
}

}  // namespace palpa::test
