#include "palpa/device/inverse3_exchange.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace palpa::inverse3 {

namespace {

// Silence after which the connection counts as lost. Longer: later back; shorter: a pausing service loses its session.
constexpr double give_up_after_s = 0.5;
// From connecting to the first message, including the version's 0.3 s. As above.
constexpr double begin_deadline_s = 1.0;
// From a lost connection to the next attempt. Longer: later back; shorter: more futile attempts.
constexpr double retry_interval_s = 0.3;
// Between messages while no force is written. Longer: older states; shorter: more idle work.
constexpr double idle_interval_s = 0.01;
// Between messages until answers are trusted. Longer: later back; shorter: more idle work.
constexpr double trial_interval_s = 0.001;
// Between messages while the device is absent. Longer: found later; shorter: more idle work.
constexpr double absent_interval_s = 0.2;
// Consecutive messages that are invalid or unsolicited. More: an old state is held longer; fewer: a single bad message ends a
// session.
constexpr int refused_to_give_up = 3;
// Smallest force that must be rendered, largest that counts as none, and how long the first may be reported as the second. A
// smaller first or a larger second: the service's rounding or scaling is a fault; shorter: its latency is.
constexpr double felt_n = 0.3;
constexpr double none_n = 1e-3;
constexpr double longest_without_force_s = 0.2;
// Turn from its first orientation by which a grip counts as used. More: a handle that was hardly turned leaves without a fault;
// less: a grip that lies on the table does not.
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

}  // namespace

DeviceState state_at(double time_s, DeviceState state) noexcept {
  if (state.valid && !(time_s - state.time_s <= state_lifetime_s)) {
    state.valid = false;
    state.buttons = 0;
    state.fault = silent;
  }
  return state;
}

void Exchange::MissingForce::note(const Vec3& sent_n, const std::optional<Vec3>& reported_n, double since_last_s) noexcept {
  if (!reported_n || !(norm(sent_n) > felt_n)) return;
  // Capped: the motors' force during a pause is unknown.
  time_s_ = norm(*reported_n) < none_n ? time_s_ + std::min(since_last_s, answer_deadline_s) : 0.0;
}

bool Exchange::MissingForce::is_too_long() const noexcept { return time_s_ > longest_without_force_s; }

Exchange::Exchange(ExchangeOptions options)
    : options_(std::move(options)), device_id_(options_.device_id), fault_of_link_(not_there) {
  publish();
}

void Exchange::advance(double time_s) noexcept { now_s_ = later(time_s); }

double Exchange::later(double time_s) const noexcept { return std::isfinite(time_s) && time_s > now_s_ ? time_s : now_s_; }

// ---- deadlines ----

void Exchange::look(double time_s) {
  advance(time_s);
  if (end_ != End::none) {
    const bool can_say = is_connected_ && has_view_ && now_s_ - ended_s_ <= end_deadline_s;
    if (can_say) return;
    if (is_connected_) lose(not_there);
    is_over_ = true;
    return;
  }
  if (!is_connected_) {
    resting_number_ = written_.number;
    if (now_s_ - began_s_ >= retry_interval_s) begin();
    return;
  }
  if (!has_view_) {
    if (now_s_ - began_s_ > begin_deadline_s) lose(silent);
    return;
  }
  if (is_awaiting_ && now_s_ - sent_s_ > give_up_after_s) return lose(silent);
  look_at_age();
}

// Also before each message and each answer: after a pause of the caller their events may come before a look.
void Exchange::look_at_age() {
  const bool is_late = is_awaiting_ && now_s_ - sent_s_ > answer_deadline_s;
  if (!is_late && !(view_.arm && now_s_ - answered_s_ > state_lifetime_s)) return;
  const bool is_news = answers_in_time_ > 0 || fault_of_link_ != silent;
  answers_in_time_ = 0;
  fault_of_link_ = silent;
  if (is_news) publish();
}

void Exchange::begin() {
  is_connected_ = true;
  began_s_ = now_s_;
  has_view_ = is_named_ = is_awaiting_ = false;
  answers_in_time_ = refused_ = 0;
  missing_force_ = {};
  handle_turn_.reset();
  sent_n_ = {};
  view_ = {};
  word_ = options_.word.value_or(ForceWord::vector);
}

void Exchange::lose(double time_s) {
  advance(time_s);
  if (is_connected_) lose(not_there);
}

void Exchange::lose(const char* why) {
  is_connected_ = has_view_ = is_awaiting_ = false;
  answers_in_time_ = 0;
  view_ = {};
  sent_n_ = {};
  fault_of_link_ = why;
  began_s_ = now_s_;  // restarts the retry interval
  publish();
  is_over_ = end_ != End::none;
}

void Exchange::end(double time_s) noexcept {
  advance(time_s);
  if (end_ != End::none) return;
  end_ = End::wanted;
  ended_s_ = now_s_;
}

// ---- receiving ----

void Exchange::open(std::optional<ForceWord> word_of_version) noexcept {
  word_ = options_.word.value_or(word_of_version.value_or(ForceWord::vector));
}

bool Exchange::take(std::string_view text, double time_s) {
  advance(time_s);
  if (!is_connected_) return false;
  const bool is_taken = has_view_ ? take_answer(text) : take_first(text);
  if (is_connected_) publish();
  return is_taken;
}

bool Exchange::read(std::string_view text) {
  if (text.size() > longest_message_bytes || !read_message(text, device_id_, view_)) return false;
  if (device_id_.empty() && !view_.device_ids.empty()) device_id_ = view_.device_ids.front();
  note_grips();
  return true;
}

bool Exchange::take_first(std::string_view text) {
  if (!read(text)) {
    lose(nonsense);
    return false;
  }
  has_view_ = true;
  fault_of_link_ = fault_of_link_ == not_there ? beginning : fault_of_link_;
  answered_s_ = now_s_;
  return true;
}

bool Exchange::take_answer(std::string_view text) {
  if (!is_awaiting_) {  // no later message certainly answers its request
    answers_in_time_ = 0;
    fault_of_link_ = unasked;
    return refuse(unasked);
  }
  look_at_age();
  is_awaiting_ = false;
  const bool had_arm = view_.arm.has_value();
  if (!read(text)) return refuse(nonsense);
  refused_ = 0;
  if (sent_n_ == Vec3{}) resting_number_ = sent_number_;
  answers_in_time_ = now_s_ - sent_s_ > answer_deadline_s ? 0 : std::min(answers_in_time_ + 1, answers_to_trust);
  // Check a returned or newly powered device from the start.
  if (!view_.arm || !had_arm || !view_.arm->has_power)
    missing_force_ = {};
  else if (!missing_force_.is_too_long())
    missing_force_.note(sent_n_, view_.arm->reported_force_n, now_s_ - answered_s_);
  answered_s_ = now_s_;
  return true;
}

bool Exchange::refuse(const char* why) {
  if (++refused_ >= refused_to_give_up) lose(why);
  return false;
}

void Exchange::note_grips() {
  for (const ServiceGrip& grip : view_.grips)
    if (grip.buttons != 0) note_use(grip);
  note_turn();
}

// The handle stays the same grip throughout. While it is gone its turn is the last known.
void Exchange::note_turn() {
  const auto is_handle = [&](const ServiceGrip& grip) {
    const bool is_meant = options_.grip_id.empty() || grip.device_id == options_.grip_id;
    return is_meant && grip.turn && grip.is_connected && grip.is_awake;
  };
  if (!handle_) {
    const auto found = std::ranges::find_if(view_.grips, is_handle);
    if (found == view_.grips.end()) return;
    handle_ = *found;
  }
  const ServiceGrip* const grip = view_.find(*handle_);
  if (grip == nullptr || !grip->is_connected || !grip->turn) return handle_turn_.reset();
  state_.turn = handle_turn_.at(now_s_, *grip->turn);
  if (norm(rotation_between_rad(*handle_->turn, *grip->turn)) > used_turn_rad) note_use(*grip);
}

void Exchange::note_use(const ServiceGrip& grip) {
  const bool is_noted = std::ranges::any_of(used_grips_, [&](const ServiceGrip& used) {
    return used.is_wireless == grip.is_wireless && used.device_id == grip.device_id;
  });
  if (!is_noted && used_grips_.size() < most_used_grips) used_grips_.push_back(grip);
}

bool Exchange::has_lost_grip() const noexcept {
  return !std::ranges::all_of(used_grips_, [this](const ServiceGrip& grip) { return view_.has(grip); });
}

// ---- sending ----

void Exchange::write(const WrittenForce& force) noexcept {
  written_ = force;
  written_.force_n = limited_force_n(force.force_n);
  has_new_force_ = true;
}

Exchange::Due Exchange::due(double time_s) const noexcept {
  if (!is_connected_ || !has_view_ || end_ == End::said) return Due::nothing;
  if (end_ == End::wanted) return Due::zero;  // also before the pending answer
  if (is_awaiting_ || !is_anything_due(later(time_s))) return Due::nothing;
  return end_ == End::at_rest ? Due::handshake : Due::message;
}

bool Exchange::is_anything_due(double now_s) const noexcept {
  const double since_s = now_s - sent_s_;
  if (!is_named_ || end_ != End::none) return true;
  if (!view_.arm) return since_s >= absent_interval_s;
  if (has_new_force_) return true;
  if (answers_in_time_ < answers_to_trust) return since_s >= trial_interval_s;
  // An expired force is zeroed at once.
  return since_s >= idle_interval_s || (sent_n_ != Vec3{} && !(now_s - written_.time_s <= force_lifetime_s));
}

std::string Exchange::message(double time_s) {
  advance(time_s);
  look_at_age();
  written_.time_s = std::min(written_.time_s, now_s_);
  sent_n_ = force_to_send_n();
  sent_number_ = written_.number;
  sent_s_ = now_s_;
  const std::string profile = is_named_ ? std::string{} : options_.profile;
  is_named_ = is_awaiting_ = true;
  has_new_force_ = false;
  if (end_ == End::wanted) end_ = End::at_rest;
  return view_.arm ? force_message(device_id_, sent_n_, word_, profile) : snapshot_request(profile);
}

void Exchange::say_goodbye() noexcept { end_ = End::said; }

// Zero during a fault, and for an expired force.
Vec3 Exchange::force_to_send_n() const noexcept {
  if (end_ != End::none || fault() != nullptr || !(now_s_ - written_.time_s <= force_lifetime_s)) return {};
  return written_.force_n;
}

// ---- state ----

const char* Exchange::fault() const noexcept {
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

void Exchange::publish() noexcept {
  state_.valid = false;
  state_.buttons = 0;
  state_.fault = fault();
  state_.time_s = answered_s_;
  if (view_.arm && view_.arm->position_m) {
    state_.position_m = *view_.arm->position_m;
    state_.velocity_m_per_s = view_.arm->velocity_m_per_s;
    state_.valid = is_linked() && view_.arm->is_calibrated;
    state_.buttons = state_.valid ? view_.buttons() : 0u;
  }
  ++states_;
  is_settled_ = is_settled_ || is_linked() || (has_view_ && !view_.arm);
}

}  // namespace palpa::inverse3
