#include "devices/inverse3_link.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <atomic>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>
#include <exception>
#include <system_error>
#include <thread>
#include <utility>

#include "devices/inverse3_connection.h"
#include "palpa/device/latest.h"
#include "palpa/device/rest.h"
#include "palpa/loop/loop.h"

namespace palpa::inverse3 {

namespace {

using Clock = std::chrono::steady_clock;
using boost::system::error_code;

// Interval of deadline checks. Longer: late reactions; shorter: more wake-ups.
constexpr std::chrono::milliseconds look_interval{2};
// Of a snapshot. Longer: a silent service blocks longer; shorter: a busy service is not found.
constexpr std::chrono::seconds snapshot_deadline{1};

double now_s() { return std::chrono::duration<double>(Clock::now().time_since_epoch()).count(); }

}  // namespace

/// Everything except the exchanged values belongs to the link's thread.
class Link::Driver final : public ConnectionUser {
 public:
  explicit Driver(const LinkOptions& options);
  ~Driver();
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;

  // ---- called by the haptic thread ----

  DeviceState read() noexcept { return state_at(now_s(), states_.take()); }
  bool write(const Vec3& force_n) noexcept;
  bool rests() const noexcept { return rest_.is_reached(); }
  bool is_settled() const noexcept { return is_settled_.load(std::memory_order_acquire); }

 private:
  // ---- called by the link's thread ----

  void run() noexcept;
  void wait_for_writes();
  void look_again();
  void look_at_deadlines();
  void lose();

  void on_open(std::optional<ForceWord> word) override { exchange_.open(word); }
  void on_message(std::string_view text) override;
  void on_written() override { send_what_is_due(); }
  void on_lost() override { lose(); }

  void take_force();
  void follow();
  void send_what_is_due();

  const boost::asio::ip::tcp::endpoint service_;
  Latest<WrittenForce> forces_;
  Latest<DeviceState> states_;
  Rest rest_;
  std::atomic<bool> is_linked_{false};
  std::atomic<bool> is_settled_{false};
  std::atomic<bool> has_to_end_{false};
  const int wake_;  // eventfd: the io_context's post() allocates and locks

  boost::asio::io_context context_{1};
  boost::asio::posix::stream_descriptor wakes_{context_};
  boost::asio::steady_timer timer_{context_};
  std::uint64_t wake_count_ = 0;
  std::shared_ptr<Connection> connection_;
  Exchange exchange_;
  std::uint64_t given_states_ = 0;  // of the exchange
  std::thread thread_;
};

Link::Driver::Driver(const LinkOptions& options)
    : service_(options.service), wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)), exchange_(options.exchange) {
  if (wake_ < 0) throw std::system_error(errno, std::generic_category(), "device inverse3: eventfd");
  wakes_.assign(wake_);  // closes it
  states_.give(exchange_.state());
  thread_ = std::thread([this] { run(); });
}

Link::Driver::~Driver() {
  has_to_end_.store(true, std::memory_order_release);
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(wake_, &one, sizeof one);
  thread_.join();
}

// ---- called by the haptic thread ----

bool Link::Driver::write(const Vec3& force_n) noexcept {
  const Vec3 wanted_n = limited_force_n(force_n);
  forces_.give({.force_n = wanted_n, .number = rest_.ask(wanted_n != Vec3{}), .time_s = now_s()});
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(wake_, &one, sizeof one);
  return is_linked_.load(std::memory_order_relaxed);
}

// ---- deadlines ----

void Link::Driver::run() noexcept {
  // As urgent as the loop's thread: forces pass through both.
  const RealTimeThread real_time;
  for (bool has_begun = false;;) {
    try {
      if (!std::exchange(has_begun, true)) {
        wait_for_writes();
        look_again();
        look_at_deadlines();
      }
      context_.run();
      return;
    } catch (const std::exception&) {
      // No memory or no socket: retry later, as after a lost connection.
      lose();
      if (has_to_end_) return;
    }
  }
}

void Link::Driver::wait_for_writes() {
  wakes_.async_read_some(boost::asio::buffer(&wake_count_, sizeof wake_count_), [this](error_code error, std::size_t) {
    if (error) return;
    wait_for_writes();
    if (has_to_end_) look_at_deadlines();
    send_what_is_due();
  });
}

void Link::Driver::look_again() {
  timer_.expires_after(look_interval);
  timer_.async_wait([this](error_code error) {
    if (error) return;
    look_again();
    look_at_deadlines();
  });
}

void Link::Driver::look_at_deadlines() {
  if (has_to_end_) exchange_.end(now_s());
  take_force();
  exchange_.look(now_s());
  follow();
  if (!connection_ && exchange_.wants_connection()) connection_ = connect(context_, service_, exchange_.wants_version(), *this);
  send_what_is_due();
}

void Link::Driver::lose() {
  exchange_.lose(now_s());
  follow();
}

void Link::Driver::on_message(std::string_view text) {
  exchange_.take(text, now_s());
  follow();
  send_what_is_due();
}

// ---- what is to be done ----

void Link::Driver::take_force() {
  if (forces_.is_fresh()) exchange_.write(forces_.take());
}

void Link::Driver::follow() {
  if (connection_ && !exchange_.wants_connection()) {
    connection_->close();
    connection_.reset();
  }
  rest_.give_none(exchange_.resting_number());
  if (std::exchange(given_states_, exchange_.states()) != exchange_.states()) {
    states_.give(exchange_.state());
    is_linked_.store(exchange_.is_linked(), std::memory_order_relaxed);
    if (exchange_.is_settled()) is_settled_.store(true, std::memory_order_release);
  }
  if (exchange_.is_over()) context_.stop();
}

void Link::Driver::send_what_is_due() {
  if (!connection_ || connection_->is_writing()) return;
  take_force();
  switch (exchange_.due(now_s())) {
    case Exchange::Due::nothing: return;
    case Exchange::Due::handshake: exchange_.say_goodbye(); return connection_->say_goodbye();
    case Exchange::Due::message:
      // The next message is unsolicited: taken as the answer, it would give an old position.
      if (connection_->has_unread()) return;
      [[fallthrough]];
    case Exchange::Due::zero: connection_->send(exchange_.message(now_s()));
  }
  follow();
}

// ---- public interface ----

Link::Link(const LinkOptions& options) : driver_(std::make_unique<Driver>(options)) {}
Link::~Link() = default;
DeviceState Link::read() noexcept { return driver_->read(); }
bool Link::write(const Vec3& force_n) noexcept { return driver_->write(force_n); }
bool Link::rests() const noexcept { return driver_->rests(); }

bool Link::wait(double longest_s) {
  const double end_s = now_s() + longest_s;
  while (!driver_->is_settled() && now_s() < end_s) std::this_thread::sleep_for(look_interval);
  return driver_->is_settled();
}

std::optional<ServiceView> look(const boost::asio::ip::tcp::endpoint& service) {
  struct Looker final : ConnectionUser {
    void on_open(std::optional<ForceWord>) override {}
    void on_message(std::string_view text) override {
      ServiceView received;
      if (read_message(text, {}, received)) view = std::move(received);
      context.stop();
    }
    void on_written() override {}
    void on_lost() override { context.stop(); }

    boost::asio::io_context context{1};
    std::optional<ServiceView> view;
  };
  Looker looker;
  const std::shared_ptr<Connection> connection = connect(looker.context, service, false, looker);
  looker.context.run_for(snapshot_deadline);
  connection->close();
  return looker.view;
}

}  // namespace palpa::inverse3
