#include "devices/inverse3_link.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
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

#include "devices/grip_turn.h"
#include "devices/inverse3_connection.h"
#include "palpa/device/latest.h"
#include "palpa/device/rest.h"
#include "palpa/loop/loop.h"

namespace palpa::inverse3 {

namespace {

using Clock = std::chrono::steady_clock;
using boost::system::error_code;
using std::chrono::milliseconds;

// Interval of deadline checks. Longer: late reactions; shorter: more wake-ups.
constexpr milliseconds look_interval{2};
// An answer takes about 0.1 ms. Longer: an old force is held longer; shorter: a busy machine's pause is a fault.
constexpr milliseconds answer_deadline{10};
// Silence after which the connection counts as lost. Longer: later back; shorter: a pausing service loses its session.
constexpr milliseconds give_up_after{500};
// From connecting to the first message, including the version's 0.3 s. As above.
constexpr milliseconds begin_deadline{1000};
// From a lost connection to the next attempt. Longer: later back; shorter: more futile attempts.
constexpr milliseconds retry_interval{300};
// Between messages while no force is written. Longer: older states; shorter: more idle work.
constexpr milliseconds idle_interval{10};
// Between messages while the device is absent. Longer: found later; shorter: more idle work.
constexpr milliseconds absent_interval{200};
// Age at which a force is no longer sent. Longer: a hung program pushes longer; shorter: a busy machine's pause drops the
// force.
constexpr milliseconds force_lifetime{20};
// Age at which a state is invalid, even if the link's thread is stalled. Must exceed the idle interval plus the answer's
// deadline. Longer: stale positions count; shorter: a busy machine's pause is a fault.
constexpr milliseconds state_lifetime{50};
// For the final zero force and the closing handshake. Longer: with a silent service the program ends later; shorter: a slow
// service gets no handshake.
constexpr milliseconds end_deadline{250};
// Consecutive answers in time before states and forces are used, initially and after a late answer. More: later back; fewer: an
// unsteady service causes a stuttering force.
constexpr int answers_to_trust = 10;
// Consecutive messages that are invalid or unsolicited. More: an old state is held longer; fewer: a single bad message ends a
// session.
constexpr int refused_to_give_up = 3;
// Smallest force that must be rendered, largest that counts as none, and how long the first may be reported as the second. A
// smaller first or a larger second: the service's rounding or scaling is a fault; shorter: its latency is.
constexpr double felt_n = 0.3;
constexpr double none_n = 1e-3;
constexpr milliseconds longest_without_force{200};
// Turn from its first orientation by which a grip counts as used [rad]. More: a handle that was hardly turned leaves without a
// fault; less: a grip that lies on the table does not.
constexpr double used_turn_rad = 0.1;
// Watched grips. More: memory that a service can fill with names; fewer: the loss of a grip is not reported.
constexpr std::size_t most_used_grips = 64;

constexpr const char* not_there = "the Inverse Service is not there";
constexpr const char* beginning = "the Inverse Service has only just answered";
constexpr const char* silent = "the service does not answer";
constexpr const char* nonsense = "the service sends what cannot be understood";
constexpr const char* unasked = "the service sends what it was not asked for";
constexpr const char* absent = "the Inverse3 is not connected to the service";
constexpr const char* placeless = "the service does not say where the Inverse3 is";
constexpr const char* uncalibrated = "the Inverse3 is not calibrated";
constexpr const char* grip_gone =
    "a grip that was used is not connected any more; its buttons are up, its turn is the last known";
constexpr const char* powerless = "the power supply is off: no force";
constexpr const char* no_force_by_vector =
    "the service takes forces but makes none: its force scale is 0, or it wants force=values";
constexpr const char* no_force_by_values =
    "the service takes forces but makes none: its force scale is 0, or it wants force=vector";

double seconds(Clock::time_point time) { return std::chrono::duration<double>(time.time_since_epoch()).count(); }

struct WrittenForce {
  Vec3 force_n;
  std::uint64_t number = 0;
  Clock::time_point time;
};

/// Time for which the motors have not rendered the sent force.
class MissingForce {
 public:
  void note(const Vec3& sent_n, const std::optional<Vec3>& reported_n, Clock::duration since_last) noexcept {
    if (!reported_n || !(norm(sent_n) > felt_n)) return;
    // Capped: the motors' force during a pause is unknown.
    time_ = norm(*reported_n) < none_n ? time_ + std::min<Clock::duration>(since_last, answer_deadline) : Clock::duration{};
  }
  bool is_too_long() const noexcept { return time_ > longest_without_force; }

 private:
  Clock::duration time_{};
};

}  // namespace

/// Everything except the exchanged values belongs to the link's thread.
class Link::Exchange final : public ConnectionUser {
 public:
  explicit Exchange(const LinkOptions& options);
  ~Exchange();
  Exchange(const Exchange&) = delete;
  Exchange& operator=(const Exchange&) = delete;

  // ---- called by the haptic thread ----

  DeviceState read() noexcept;
  bool write(const Vec3& force_n) noexcept;
  bool rests() const noexcept { return rest_.is_reached(); }
  bool is_settled() const noexcept { return is_settled_.load(std::memory_order_acquire); }

 private:
  // ---- called by the link's thread ----

  void run() noexcept;
  void wait_for_writes();
  void look_again();
  void look_at_deadlines();
  void look_at_age(Clock::time_point now);
  void begin();
  void lose(const char* why);

  void on_open(std::optional<ForceWord> word) override;
  void on_message(std::string_view text) override;
  void on_written() override { send_what_is_due(); }
  void on_lost() override { lose(not_there); }

  void take(std::string_view text);
  void note_grips();
  void note_turn();
  void note_use(const Grip& grip);
  bool has_lost_grip() const noexcept;
  void refuse(const char* why);
  bool is_anything_due() const noexcept;
  void send_what_is_due();
  Vec3 force_to_send_n() noexcept;
  const char* fault() const noexcept;
  void publish();

  const LinkOptions options_;
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

  enum class End : std::uint8_t { none, wanted, at_rest, said };
  End end_ = End::none;                    // at rest: zero force sent; said: closing handshake sent
  const char* fault_of_link_ = not_there;  // until enough answers are in time
  bool has_view_ = false;                  // the first message has been read
  bool is_named_ = false;                  // the session's profile was sent
  bool is_awaiting_ = false;               // of an answer
  int answers_in_time_ = 0;                // consecutive
  int refused_ = 0;                        // consecutive
  DeviceState state_;                      // as published
  ForceWord word_ = ForceWord::vector;
  View view_;
  std::vector<Grip> used_grips_;  // with buttons pressed, or turned as the handle, since construction
  std::optional<Grip> handle_;    // grip whose orientation is the handle's, as first seen
  GripTurn handle_turn_;
  Vec3 sent_n_;
  std::uint64_t sent_number_ = 0;  // of the force sent last
  MissingForce missing_force_;
  Clock::time_point began_{}, ended_{}, sent_at_{}, answered_at_{};
  WrittenForce written_;
  std::thread thread_;
};

Link::Exchange::Exchange(const LinkOptions& options) : options_(options), wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (wake_ < 0) throw std::system_error(errno, std::generic_category(), "device inverse3: eventfd");
  wakes_.assign(wake_);  // closes it
  states_.give({.fault = not_there});
  thread_ = std::thread([this] { run(); });
}

Link::Exchange::~Exchange() {
  has_to_end_.store(true, std::memory_order_release);
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(wake_, &one, sizeof one);
  thread_.join();
}

// ---- called by the haptic thread ----

DeviceState Link::Exchange::read() noexcept {
  DeviceState state = states_.take();
  if (state.valid && seconds(Clock::now()) - state.time_s > std::chrono::duration<double>(state_lifetime).count()) {
    state.valid = false;
    state.buttons = 0;
    state.fault = silent;
  }
  return state;
}

bool Link::Exchange::write(const Vec3& force_n) noexcept {
  const Vec3 wanted_n = is_finite(force_n) ? shortened(force_n, max_force_n) : Vec3{};
  forces_.give({.force_n = wanted_n, .number = rest_.ask(wanted_n != Vec3{}), .time = Clock::now()});
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(wake_, &one, sizeof one);
  return is_linked_.load(std::memory_order_relaxed);
}

// ---- deadlines ----

void Link::Exchange::run() noexcept {
  // As urgent as the loop's thread: forces pass through both.
  const RealTimeThread real_time;
  for (bool has_begun = false;;) {
    try {
      if (!std::exchange(has_begun, true)) {
        wait_for_writes();
        look_again();
        begin();
      }
      context_.run();
      return;
    } catch (const std::exception&) {
      // No memory or no socket: retry later, as after a lost connection.
      if (connection_) lose(not_there);
      if (has_to_end_) return;
    }
  }
}

void Link::Exchange::wait_for_writes() {
  wakes_.async_read_some(boost::asio::buffer(&wake_count_, sizeof wake_count_), [this](error_code error, std::size_t) {
    if (error) return;
    wait_for_writes();
    if (has_to_end_) look_at_deadlines();
    send_what_is_due();
  });
}

void Link::Exchange::look_again() {
  timer_.expires_after(look_interval);
  timer_.async_wait([this](error_code error) {
    if (error) return;
    look_again();
    look_at_deadlines();
  });
}

void Link::Exchange::look_at_deadlines() {
  const Clock::time_point now = Clock::now();
  if (has_to_end_ && end_ == End::none) {
    end_ = End::wanted;
    ended_ = now;
  }
  if (end_ != End::none) {
    const bool can_say = connection_ && has_view_ && now - ended_ <= end_deadline;
    if (can_say) return send_what_is_due();
    if (connection_) connection_->close();
    return context_.stop();
  }
  if (!connection_) {
    rest_.give_none(forces_.take().number);
    if (now - began_ >= retry_interval) begin();
    return;
  }
  if (!has_view_) {
    if (now - began_ > begin_deadline) lose(silent);
    return;
  }
  if (is_awaiting_ && now - sent_at_ > give_up_after) return lose(silent);
  look_at_age(now);
  send_what_is_due();
}

// Also before each send and each answer: after a pause of this thread their handlers may run before the timer's.
void Link::Exchange::look_at_age(Clock::time_point now) {
  const bool is_late = is_awaiting_ && now - sent_at_ > answer_deadline;
  if (!is_late && !(view_.arm && now - answered_at_ > state_lifetime)) return;
  const bool is_news = answers_in_time_ > 0 || fault_of_link_ != silent;
  answers_in_time_ = 0;
  fault_of_link_ = silent;
  if (is_news) publish();
}

void Link::Exchange::begin() {
  began_ = Clock::now();
  has_view_ = is_named_ = is_awaiting_ = false;
  answers_in_time_ = refused_ = 0;
  missing_force_ = {};
  handle_turn_.reset();
  sent_n_ = {};
  view_ = {};
  connection_ = connect(context_, options_.service, !options_.word, *this);
}

void Link::Exchange::lose(const char* why) {
  connection_->close();
  connection_.reset();
  has_view_ = is_awaiting_ = false;
  answers_in_time_ = 0;
  view_ = {};
  sent_n_ = {};
  fault_of_link_ = why;
  began_ = Clock::now();  // restarts the retry interval
  publish();
  if (end_ != End::none) context_.stop();
}

// ---- receiving ----

void Link::Exchange::on_open(std::optional<ForceWord> word) {
  word_ = options_.word.value_or(word.value_or(ForceWord::vector));
}

void Link::Exchange::on_message(std::string_view text) {
  if (!has_view_) {
    if (!read_message(text, options_.device_id, view_)) return lose(nonsense);
    has_view_ = true;
    note_grips();
    fault_of_link_ = fault_of_link_ == not_there ? beginning : fault_of_link_;
    answered_at_ = Clock::now();
  } else {
    take(text);
  }
  if (!connection_) return;  // closed meanwhile
  publish();
  send_what_is_due();
}

void Link::Exchange::take(std::string_view text) {
  if (!is_awaiting_) return refuse(unasked);
  const Clock::time_point now = Clock::now();
  look_at_age(now);
  is_awaiting_ = false;
  const bool had_arm = view_.arm.has_value();
  if (!read_message(text, options_.device_id, view_)) return refuse(nonsense);
  refused_ = 0;
  note_grips();
  if (sent_n_ == Vec3{}) rest_.give_none(sent_number_);
  answers_in_time_ = now - sent_at_ > answer_deadline ? 0 : std::min(answers_in_time_ + 1, answers_to_trust);
  // Check a returned or newly powered device from the start.
  if (!view_.arm || !had_arm || !view_.arm->has_power)
    missing_force_ = {};
  else if (!missing_force_.is_too_long())
    missing_force_.note(sent_n_, view_.arm->reported_force_n, now - answered_at_);
  answered_at_ = now;
}

void Link::Exchange::note_grips() {
  for (const Grip& grip : view_.grips)
    if (grip.buttons != 0) note_use(grip);
  note_turn();
}

// The handle stays the same grip throughout. While it is gone its turn is the last known.
void Link::Exchange::note_turn() {
  const auto is_handle = [&](const Grip& grip) {
    const bool is_meant = options_.grip_id.empty() || grip.device_id == options_.grip_id;
    return is_meant && grip.turn && grip.is_connected && grip.is_awake;
  };
  if (!handle_) {
    const auto found = std::ranges::find_if(view_.grips, is_handle);
    if (found == view_.grips.end()) return;
    handle_ = *found;
  }
  const Grip* const grip = view_.find(*handle_);
  if (grip == nullptr || !grip->is_connected || !grip->turn) return handle_turn_.reset();
  state_.turn = handle_turn_.at(seconds(Clock::now()), *grip->turn);
  if (norm(rotation_between_rad(*handle_->turn, *grip->turn)) > used_turn_rad) note_use(*grip);
}

void Link::Exchange::note_use(const Grip& grip) {
  const bool is_noted = std::ranges::any_of(
      used_grips_, [&](const Grip& used) { return used.is_wireless == grip.is_wireless && used.device_id == grip.device_id; });
  if (!is_noted && used_grips_.size() < most_used_grips) used_grips_.push_back(grip);
}

bool Link::Exchange::has_lost_grip() const noexcept {
  return !std::ranges::all_of(used_grips_, [this](const Grip& grip) { return view_.has(grip); });
}

void Link::Exchange::refuse(const char* why) {
  if (++refused_ >= refused_to_give_up) lose(why);
}

// ---- sending ----

bool Link::Exchange::is_anything_due() const noexcept {
  const Clock::duration since = Clock::now() - sent_at_;
  if (!is_named_ || end_ != End::none) return true;
  if (!view_.arm) return since >= absent_interval;
  if (forces_.is_fresh()) return true;
  if (answers_in_time_ < answers_to_trust) return since >= look_interval / 2;
  // An expired force is zeroed at once.
  return since >= idle_interval || (sent_n_ != Vec3{} && Clock::now() - written_.time > force_lifetime);
}

void Link::Exchange::send_what_is_due() {
  if (!connection_ || !has_view_ || connection_->is_writing() || end_ == End::said) return;
  // Send the final zero force before the pending answer.
  if ((is_awaiting_ && end_ != End::wanted) || !is_anything_due()) return;
  // The next message is unsolicited: taken as the answer, it would give an old position.
  if (end_ == End::none && connection_->has_unread()) return;
  if (end_ == End::at_rest) {
    end_ = End::said;
    return connection_->say_goodbye();
  }
  const std::string profile = is_named_ ? std::string{} : options_.profile;
  const Clock::time_point now = Clock::now();
  look_at_age(now);
  sent_n_ = force_to_send_n();
  sent_number_ = written_.number;
  sent_at_ = now;
  is_named_ = is_awaiting_ = true;
  if (end_ == End::wanted) end_ = End::at_rest;
  connection_->send(view_.arm ? force_message(options_.device_id, sent_n_, word_, profile) : snapshot_request(profile));
}

// Zero during a fault, and for an expired force.
Vec3 Link::Exchange::force_to_send_n() noexcept {
  written_ = forces_.take();
  if (end_ != End::none || fault() != nullptr || Clock::now() - written_.time > force_lifetime) return {};
  return written_.force_n;
}

// ---- state ----

const char* Link::Exchange::fault() const noexcept {
  if (!has_view_) return fault_of_link_;
  if (!view_.arm) return absent;
  if (!view_.arm->position_m) return placeless;
  if (answers_in_time_ < answers_to_trust) return fault_of_link_;
  if (!view_.arm->is_calibrated) return uncalibrated;
  if (!view_.arm->has_power) return powerless;
  if (has_lost_grip()) return grip_gone;
  if (missing_force_.is_too_long()) return word_ == ForceWord::vector ? no_force_by_vector : no_force_by_values;
  return nullptr;
}

void Link::Exchange::publish() {
  const bool is_linked = has_view_ && answers_in_time_ == answers_to_trust;
  state_.valid = false;
  state_.buttons = 0;
  state_.fault = fault();
  state_.time_s = seconds(answered_at_);
  if (view_.arm && view_.arm->position_m) {
    state_.position_m = *view_.arm->position_m;
    state_.velocity_m_per_s = view_.arm->velocity_m_per_s;
    state_.valid = is_linked && view_.arm->is_calibrated;
    state_.buttons = state_.valid ? view_.buttons() : 0u;
  }
  states_.give(state_);
  is_linked_.store(is_linked, std::memory_order_relaxed);
  if (is_linked || (has_view_ && !view_.arm)) is_settled_.store(true, std::memory_order_release);
}

// ---- public interface ----

Link::Link(const LinkOptions& options) : exchange_(std::make_unique<Exchange>(options)) {}
Link::~Link() = default;
DeviceState Link::read() noexcept { return exchange_->read(); }
bool Link::write(const Vec3& force_n) noexcept { return exchange_->write(force_n); }
bool Link::rests() const noexcept { return exchange_->rests(); }

bool Link::wait(double longest_s) {
  const Clock::time_point end =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(longest_s));
  while (!exchange_->is_settled() && Clock::now() < end) std::this_thread::sleep_for(look_interval);
  return exchange_->is_settled();
}

std::optional<View> look(const boost::asio::ip::tcp::endpoint& service) {
  struct Looker final : ConnectionUser {
    void on_open(std::optional<ForceWord>) override {}
    void on_message(std::string_view text) override {
      View received;
      if (read_message(text, {}, received)) view = std::move(received);
      context.stop();
    }
    void on_written() override {}
    void on_lost() override { context.stop(); }

    boost::asio::io_context context{1};
    std::optional<View> view;
  };
  Looker looker;
  const std::shared_ptr<Connection> connection = connect(looker.context, service, false, looker);
  looker.context.run_for(begin_deadline);
  connection->close();
  return looker.view;
}

}  // namespace palpa::inverse3
