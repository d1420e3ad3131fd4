#include "palpa/serve/data_side.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <deque>
#include <string>
#include <utility>

#include "palpa/far/local_model.h"
#include "palpa/loop/window_feed.h"
#include "palpa/serve/model_of.h"

namespace palpa {

namespace {

// Look-ahead of a model (docs/far.md). Longer: a rail swings; shorter: a wall comes late.
constexpr double most_ahead_s = 0.04;
constexpr double whole_speed_m_per_s = 0.03;  // of the hand, from which on it is whole. Less: a still hand swings
constexpr double step_s = 0.004;              // of a tick ahead. Longer: coarser paths; shorter: more work
constexpr double further_m = 0.01;            // Levels so far beyond are in the model, too. More: work; less: met late
constexpr int further_ticks = 4;
// [1] units of all ticks ahead (Tick::work). More: the session comes late; less: walls and ways ahead are left out.
constexpr int most_ahead_work = 2048;
constexpr double least_speed_m_per_s = 0.002;  // of a hand that goes anywhere
constexpr double velocity_s = 0.008;           // averaging time of the hand's velocity. Longer: late; shorter: encoder noise
// A model is sent where the balance would move by more, by less on links with a shorter round trip, or after so long.
constexpr double moves_m = 30e-6;
constexpr double whole_trip_s = 0.014;
constexpr double longest_silence_s = 0.02;
constexpr double usual_s = 1.0;  // averaging time of the round trip
constexpr double loss_s = 5.0;   // of the lost samples
constexpr double most_gap_s = 1.0;
constexpr std::size_t most_events = 64;
constexpr double least_n_per_m = 1.0;

std::uint64_t microseconds(double time_s) noexcept {
  return static_cast<std::uint64_t>(std::llround(1e6 * std::max(0.0, time_s)));
}

bool gives_way(const Session& session) noexcept {
  return std::ranges::any_of(session.events(), [](const SessionEvent& e) { return e.kind == SessionEventKind::break_through; });
}

template <std::size_t N>
void copy_text(const char* text, std::array<char, N>& to) noexcept {
  to = {};
  if (text) std::memcpy(to.data(), text, std::min(N, std::strlen(text)));
}

}  // namespace

/// A session with the one that runs ahead of it.
struct FarSession {
  FarSession(const Scene& scene, double encoder_step_m)
      : felt(scene, encoder_step_m), ahead(scene, encoder_step_m), tool(scene.tool(), scene.coupling()), feed(felt) {
    for (const SceneVolume& volume : scene.volumes())
      for (const auto& field : volume.volume.fields)
        spacing_m = std::min(spacing_m, felt.hand_to_world().length_to_hand(field.field->spacing_m()));
  }

  Session felt, ahead;
  Tool tool;
  WindowFeed feed;
  double spacing_m = 0.01;  // finest of the samples, in hand metres; at most 10 mm
};

class DataSide::State {
 public:
  explicit State(const Scene& given) : scene_(given) { check(given); }

  void record(Recorder* recorder, Observer observer) {
    recorder_ = recorder;
    observer_ = std::move(observer);
  }
  bool take(std::span<const std::byte> message, double now_s);
  std::size_t give(std::span<std::byte> to, double now_s);
  void change(const Scene& scene);
  const DataSideFacts& facts() const noexcept { return facts_; }
  const Scene& scene() const noexcept { return scene_; }

 private:
  static void check(const Scene& scene);
  void begin(const HandHello& hello);
  bool take_report(const ProbeReport& report, const MessageHead& head, double now_s);
  void tick(const ProbeReport::Sample& sample, double time_step_s);
  void write_tick();
  void keep_rows();
  void keep_events();
  void measure(const ProbeReport& report, double now_s);
  void make_model(double now_s);
  void look_ahead();
  bool find_level(Vec3 probe_m, const Vec3& way_m);
  bool differs_from_sent();
  std::size_t give_welcome(std::span<std::byte> to, double now_s);
  std::size_t give_model(std::span<std::byte> to, double now_s);

  Scene scene_;
  Recorder* recorder_ = nullptr;
  Observer observer_;
  DeviceLimits limits_;
  std::unique_ptr<FarSession> session_, before_;
  std::unique_ptr<GuardedSession> guarded_;
  std::uint32_t scene_number_ = 0;
  bool owes_welcome_ = false;
  std::uint32_t circumstances_ = 0;

  // Samples
  std::uint64_t newest_ = 0;  // number of the last that was ticked
  std::int64_t ticks_ = 0;
  double time_s_ = 0.0;
  Vec3 last_m_, velocity_m_per_s_;
  Vec3 along_;  // direction of the last motion
  int ahead_work_ = 0;
  bool last_valid_ = false;
  std::uint64_t echo_us_ = 0;
  double arrived_s_ = 0.0;
  // Model
  ModelUpdate own_;  // of the session, without what lies ahead
  ModelUpdate model_;
  bool needs_model_ = false, owes_model_ = false, is_first_ = true;
  double sent_s_ = 0.0;
  LocalModel sent_, next_;
  std::array<Vec3, 3> compared_m_{};  // probes at which models are compared
  std::deque<ModelEvent> events_;
  DataSideFacts facts_;
  double measured_s_ = 0.0;
};

void DataSide::State::check(const Scene& scene) {
  const Tool tool(scene.tool(), scene.coupling());
  if (!tool.is_point())
    throw SceneError("[tool] shape: a far hand has a point; write shape = \"point\", or feel this scene beside its data");
  if (scene.law() != "exact") throw SceneError("[law] method: a far hand balances by the exact law; write method = \"exact\"");
}

void DataSide::State::begin(const HandHello& hello) {
  if (!(hello.max_stiffness_n_per_m >= least_n_per_m))
    throw SceneError("hello: a device of less than 1 N/m cannot be held at data; name its real limit");
  limits_ = {};
  limits_.max_force_n = hello.max_force_n;
  limits_.max_stiffness_n_per_m = hello.max_stiffness_n_per_m;
  limits_.max_damping_ns_per_m = hello.max_damping_ns_per_m;
  limits_.encoder_step_m = hello.encoder_step_m;
  session_ = std::make_unique<FarSession>(clamped_to(scene_, limits_), limits_.encoder_step_m);
  guarded_ = std::make_unique<GuardedSession>(session_->felt, limits_.max_force_n);
  session_->ahead.set_force_limit(force_limit_n(session_->felt.scene(), limits_.max_force_n));
  ++scene_number_;
  owes_welcome_ = true;
  newest_ = 0;
  is_first_ = true;
  own_ = {};
  events_.clear();
}

void DataSide::State::change(const Scene& scene) {
  check(scene);
  if (session_) {
    auto next = std::make_unique<FarSession>(clamped_to(scene, limits_), limits_.encoder_step_m);
    next->felt.resume_in_changed_scene(session_->felt);
    next->ahead.set_force_limit(force_limit_n(next->felt.scene(), limits_.max_force_n));
    guarded_->switch_to(next->felt, next->tool);
    before_ = std::exchange(session_, std::move(next));
    circumstances_ |= bit_of(Circumstance::new_scene);
    ++scene_number_;
    owes_welcome_ = true;
    is_first_ = true;
  }
  scene_ = scene;
}

bool DataSide::State::take(std::span<const std::byte> message, double now_s) {
  const std::optional<MessageHead> head = head_of(message);
  if (!head) return false;
  if (head->kind == MessageHead::Kind::hello) {
    HandHello hello;
    if (!read_message(message, hello)) return false;
    if (session_) return owes_welcome_ = newest_ == 0;  // said again: the welcome was lost
    begin(hello);
    return true;
  }
  ProbeReport report;
  return head->kind == MessageHead::Kind::probes && session_ && read_message(message, report) &&
         take_report(report, *head, now_s);
}

bool DataSide::State::take_report(const ProbeReport& report, const MessageHead& head, double now_s) {
  if (report.newest <= newest_ || report.newest < report.count) return false;  // late, or twice
  facts_.felt = report;
  measure(report, now_s);
  const std::uint64_t first = report.newest - report.count + 1;
  const std::uint64_t missing = newest_ > 0 && first > newest_ + 1 ? first - newest_ - 1 : 0;
  double gap_s = static_cast<double>(missing) * double{report.samples[0].time_step_s};
  double new_ones = static_cast<double>(missing);
  for (std::size_t n = 0; n < report.count; ++n) {
    if (first + n <= newest_) continue;
    newest_ = first + n;
    ++new_ones;
    const ProbeReport::Sample& sample = report.samples[n];
    tick(sample, std::min(most_gap_s, double{sample.time_step_s} + std::exchange(gap_s, 0.0)));
  }
  const double share = std::min(1.0, new_ones * double{report.samples[0].time_step_s} / loss_s);
  facts_.lost += share * (static_cast<double>(missing) / new_ones - facts_.lost);
  echo_us_ = head.time_us;
  arrived_s_ = now_s;
  needs_model_ = true;
  return true;
}

void DataSide::State::tick(const ProbeReport::Sample& sample, double time_step_s) {
  const Probe probe{.position_m = sample.position_m, .valid = sample.valid, .buttons = sample.buttons};
  session_->feed.lay_for(probe, time_step_s);
  facts_.frame = guarded_->tick(ticks_++, time_s_, time_step_s, probe, std::exchange(circumstances_, 0));
  before_.reset();
  time_s_ += time_step_s;
  ++facts_.samples;
  if (recorder_) write_tick();
  if (observer_) observer_(facts_.frame, session_->felt, facts_.felt);
  if (sample.valid && last_valid_) {
    const double share = std::min(1.0, time_step_s / velocity_s);
    velocity_m_per_s_ += share * ((sample.position_m - last_m_) / time_step_s - velocity_m_per_s_);
  } else {
    velocity_m_per_s_ = {};
    own_.count = 0;
  }
  last_m_ = sample.position_m;
  last_valid_ = sample.valid;
  keep_rows();
  keep_events();
}

// A kill loses at most 0.1 s of ticks, as of a loop on a simulated clock.
void DataSide::State::write_tick() {
  constexpr std::int64_t ticks_between_looks = 32, most_pending_ticks = 64;
  if (facts_.frame.tick % ticks_between_looks == 0) recorder_->keep_up(most_pending_ticks);
  if (recorder_->offer(facts_.frame, session_->felt)) return;
  recorder_->keep_up(0);
  recorder_->offer(facts_.frame, session_->felt);
}

// A tick without a sub-step has the primitives of the last one.
void DataSide::State::keep_rows() {
  const Vec3 moved_m = facts_.frame.result.proxy_m - own_.proxy_m;
  for (std::size_t n = 0; n < own_.count; ++n)
    if (!own_.rows[n].rides) own_.rows[n].offset_m -= moved_m;
  own_.proxy_m = facts_.frame.result.proxy_m;
  if (last_valid_) take_rows(session_->felt, own_);
}

void DataSide::State::keep_events() {
  for (const SessionEvent& event : session_->felt.events()) {
    ModelEvent kept;
    kept.kind = static_cast<ModelEvent::Kind>(event.kind);
    kept.mode = event.mode;
    kept.sample = newest_;
    kept.value = event.value;
    kept.depth_m = static_cast<float>(event.depth_m);
    copy_text(event.text, kept.text);
    if (events_.size() == most_events) events_.pop_front();
    events_.push_back(kept);
  }
}

void DataSide::State::measure(const ProbeReport& report, double now_s) {
  if (report.model == 0) return;
  const double trip_s = std::clamp(now_s - 1e-6 * static_cast<double>(report.echo_us) - double{report.held_s}, 0.0, 10.0);
  const double share = facts_.round_trip_s == 0.0 ? 1.0 : std::min(1.0, (now_s - measured_s_) / usual_s);
  facts_.round_trip_s += share * (trip_s - facts_.round_trip_s);
  measured_s_ = now_s;
}

void DataSide::State::make_model(double now_s) {
  model_ = own_;
  model_.answers = newest_;
  model_.scene = scene_number_;
  model_.valid_m = static_cast<float>(2.0 * session_->spacing_m);
  facts_.ahead_s = 0.0;
  compared_m_.fill(last_m_);
  if (last_valid_) look_ahead();
  owes_model_ = owes_model_ || is_first_ || now_s - sent_s_ >= longest_silence_s || differs_from_sent();
}

// Runs the second session along the hand's velocity: for the time of a round trip, then up to the next level.
void DataSide::State::look_ahead() {
  const double speed_m_per_s = norm(velocity_m_per_s_);
  const double ahead_s = std::min(facts_.round_trip_s, most_ahead_s) * std::min(1.0, speed_m_per_s / whole_speed_m_per_s);
  if (speed_m_per_s > least_speed_m_per_s) along_ = velocity_m_per_s_ / speed_m_per_s;
  Session& ahead = session_->ahead;
  ahead_work_ = 0;
  ahead.copy_state_from(session_->felt);
  const int ticks = static_cast<int>(std::ceil(ahead_s / step_s));
  Vec3 probe_m = last_m_;
  bool breaks = false;
  for (int n = 0; n < ticks && ahead_work_ < most_ahead_work; ++n) {
    const double time_step_s = ahead_s / ticks;
    probe_m += time_step_s * velocity_m_per_s_;
    ahead_work_ += ahead.tick({.position_m = probe_m}, time_step_s).work;
    // A break-through is the session's: it is not felt before.
    breaks = gives_way(ahead);
    if (breaks) break;
    facts_.ahead_s += time_step_s;
    take_rows(ahead, model_);
  }
  for (std::size_t n = 0; n < model_.count; ++n) model_.rows[n].offset_m -= facts_.ahead_s * model_.rows[n].velocity_m_per_s;
  model_.ahead_s = static_cast<float>(facts_.ahead_s);
  model_.valid_m = std::max(model_.valid_m, static_cast<float>(distance(probe_m, last_m_)));
  compared_m_[1] = probe_m;
  if (breaks || along_ == Vec3{} || find_level(probe_m, further_m * along_)) return;
  // A hand that turns back meets what it has left.
  ahead.copy_state_from(session_->felt);
  find_level(last_m_, -further_m * along_);
}

// Moves the session ahead from `probe_m` by `way_m` [m], until a level is met that the model has not. False if there is none.
bool DataSide::State::find_level(Vec3 probe_m, const Vec3& way_m) {
  Session& ahead = session_->ahead;
  for (int n = 0; n < further_ticks && ahead_work_ < most_ahead_work; ++n) {
    probe_m += way_m / further_ticks;
    ahead_work_ += ahead.tick({.position_m = probe_m}, step_s).work;
    compared_m_[2] = probe_m;
    if (gives_way(ahead)) return true;
    if (add_levels_ahead(ahead, model_) > 0) return true;
  }
  return false;
}

// Whether the balance by the new model is elsewhere than by the last one that was sent.
bool DataSide::State::differs_from_sent() {
  next_.take(model_);
  const double least_m = moves_m * std::min(1.0, facts_.round_trip_s / whole_trip_s);
  if (least_m == 0.0) return true;
  const double k = session_->felt.scene().coupling().stiffness_n_per_m;
  return std::ranges::any_of(compared_m_, [&](const Vec3& probe_m) {
    const Vec3 by_sent_m = sent_.move(model_.proxy_m, probe_m, 1e-3, 0.0, k);
    return distance(by_sent_m, next_.move(model_.proxy_m, probe_m, 1e-3, 0.0, k)) > least_m;
  });
}

std::size_t DataSide::State::give(std::span<std::byte> to, double now_s) {
  std::size_t bytes = 0;
  // Of several reports at once, as after a pause, only the last is answered: the look-ahead of each would make it later.
  if (std::exchange(needs_model_, false)) make_model(now_s);
  if (owes_welcome_) {
    bytes = give_welcome(to, now_s);
  } else if (!events_.empty()) {
    bytes = write_message(events_.front(), microseconds(now_s), to);
    events_.pop_front();
  } else if (owes_model_) {
    bytes = give_model(to, now_s);
  }
  facts_.bytes += static_cast<std::int64_t>(bytes);
  return bytes;
}

std::size_t DataSide::State::give_welcome(std::span<std::byte> to, double now_s) {
  owes_welcome_ = false;
  const Scene& scene = session_->felt.scene();
  const CouplingOptions& coupling = scene.coupling();
  DataWelcome welcome;
  welcome.scene = scene_number_;
  welcome.stiffness_n_per_m = coupling.stiffness_n_per_m;
  welcome.damping_ns_per_m = coupling.damping_ns_per_m;
  welcome.max_force_n = coupling.max_force_n;
  welcome.impact_ns_per_m = coupling.impact_ns_per_m;
  welcome.modes = static_cast<std::uint16_t>(std::min(scene.modes().size(), DataWelcome::most_modes));
  for (std::size_t n = 0; n < welcome.modes; ++n) copy_text(scene.modes()[n].name.c_str(), welcome.names[n]);
  return write_message(welcome, microseconds(now_s), to);
}

std::size_t DataSide::State::give_model(std::span<std::byte> to, double now_s) {
  owes_model_ = is_first_ = false;
  model_.echo_us = echo_us_;
  model_.held_s = static_cast<float>(std::max(0.0, now_s - arrived_s_));
  sent_.take(model_);
  sent_s_ = now_s;
  ++facts_.models;
  return write_message(model_, microseconds(now_s), to);
}

DataSide::DataSide(const Scene& scene) : state_(std::make_unique<State>(scene)) {}
DataSide::~DataSide() = default;
DataSide::DataSide(DataSide&&) noexcept = default;
DataSide& DataSide::operator=(DataSide&&) noexcept = default;

void DataSide::record(Recorder* recorder, Observer observer) { state_->record(recorder, std::move(observer)); }
bool DataSide::take(std::span<const std::byte> message, double now_s) { return state_->take(message, now_s); }
std::size_t DataSide::give(std::span<std::byte> to, double now_s) { return state_->give(to, now_s); }
void DataSide::change(const Scene& scene) { state_->change(scene); }
const DataSideFacts& DataSide::facts() const noexcept { return state_->facts(); }
const Scene& DataSide::scene() const noexcept { return state_->scene(); }

}  // namespace palpa
