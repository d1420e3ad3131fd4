#include "palpa/far/hand_side.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpa/far/energy_account.h"
#include "palpa/far/local_model.h"
#include "palpa/guard/guard.h"
#include "palpa/guard/impact.h"
#include "palpa/solver/damper.h"

namespace palpa {

namespace {

// Between reports: 0.3 of the round trip beyond the short one, within these. Longer: models are later; shorter: more bytes.
constexpr double shortest_report_s = 0.9e-3, longest_report_s = 2.9e-3, short_trip_s = 3e-3;
constexpr double full_report_s = 0.6e-3;  // of one full of new samples. Shorter: a flood; longer: fast hands are thinned out
constexpr double hello_s = 0.25;          // between hellos that are not answered
constexpr double stale_s = 0.1;           // beyond the usual age. Longer: an old wall is felt; shorter: let go by jitter
constexpr double usual_s = 1.0;           // averaging time of age and round trip
constexpr double most_step_s = 1.0;       // [s] longer is an invalid sample, as of a session
constexpr double furthest_m = 1e3;        // [m] likewise
constexpr std::size_t most_kept = 1024;   // [1] samples. More: memory; fewer: models of long delays are not replayed whole

std::uint64_t microseconds(double time_s) noexcept { return static_cast<std::uint64_t>(std::llround(1e6 * time_s)); }

}  // namespace

const char* name_of(LinkState state) noexcept {
  switch (state) {
    case LinkState::waiting: return "waiting";
    case LinkState::up: return "up";
    case LinkState::stale: return "stale";
    case LinkState::closed: return "closed";
  }
  return "?";
}

class HandSide::State {
 public:
  explicit State(const HandSideOptions& options)
      : options_(options),
        guard_options_(guard_options()),
        guard_(guard_options_),
        damper_(0.0, options.device.encoder_step_m, false),
        impact_(0.0) {}

  void begin(const HandSample& sample, double time_step_s) noexcept;
  std::size_t give(std::span<std::byte> to) noexcept;
  bool take(std::span<const std::byte> message) noexcept;
  HandTick feel(std::uint32_t circumstances) noexcept;
  void set_connected(bool connected) noexcept;
  bool take_event(ModelEvent& event) noexcept;
  const DataWelcome& welcome() const noexcept { return welcome_; }

 private:
  struct Kept {
    Vec3 position_m;
    double time_s = 0.0, time_step_s = 0.0;
    std::uint32_t buttons = 0;
    bool usable = false;
    bool valid = false;  ///< usable, and no gap for the session to begin anew
  };

  GuardOptions guard_options() const noexcept;
  const Kept& kept(std::uint64_t number) const noexcept { return kept_[number % most_kept]; }
  bool is_kept(std::uint64_t number) const noexcept { return number > 0 && number <= newest_ && newest_ - number < most_kept; }
  double k() const noexcept { return welcome_.stiffness_n_per_m; }
  double longest_m() const noexcept { return std::min(welcome_.max_force_n, options_.device.max_force_n) / k(); }
  Vec3 cut(const Vec3& extension_m) const noexcept;
  /// Energy of an extension beyond the cut: at the largest force it gives that back to a hand that goes out.
  double beyond_j(const Vec3& extension_m) const noexcept {
    return k() * longest_m() * std::max(0.0, norm(extension_m) - longest_m());
  }
  void take_welcome(const DataWelcome& welcome) noexcept;
  bool take_model(const ModelUpdate& model) noexcept;
  void reconcile() noexcept;
  void stop_feeling() noexcept;
  void forget_model() noexcept;
  /// Model's part of a tick.
  struct Felt {
    Vec3 extension_m;
    Vec3 released_m;        // part of its change that is a spread update
    double gained_j = 0.0;  // by holding the force for a tick
    double model_j = 0.0;
  };
  Felt feel_model(const Kept& now, const Vec3& probe_step_m) noexcept;
  LinkState link_state() noexcept;
  ProbeReport report() const noexcept;

  HandSideOptions options_;
  GuardOptions guard_options_;
  // Clock and samples
  double now_s_ = 0.0;
  std::uint64_t newest_ = 0;  // number of the newest sample
  std::array<Kept, most_kept> kept_{};
  std::uint64_t first_usable_ = 1;  // sample from which on a model can be felt: after the last gap
  bool restarts_ = false;           // the next sample is sent as a gap
  // Messages
  bool connected_ = true, unknown_scene_ = false;
  double hello_at_s_ = -hello_s, report_at_s_ = -1.0;
  std::uint64_t reported_ = 0;  // newest sample of the last report
  DataWelcome welcome_{};
  ModelUpdate coming_;  // newest model, not felt yet
  bool has_coming_ = false;
  std::uint64_t answered_ = 0;  // number of the sample that the newest model answers
  double answered_s_ = 0.0;     // time of that sample
  std::uint64_t echo_us_ = 0;   // its time, by the clock of the data's side
  double arrived_s_ = 0.0;      // and its arrival
  double usual_age_s_ = 0.0, round_trip_s_ = 0.0;
  std::array<ModelEvent, 64> events_{};
  std::size_t first_event_ = 0, event_count_ = 0;
  // Felt
  LocalModel model_;
  bool feels_ = false;       // the model is felt
  bool is_session_ = false;  // the last tick was the session's own
  Vec3 proxy_m_;             // at the last sample
  Vec3 extension_m_;         // from the last probe to it, cut at the force limit
  double elastic_j_ = 0.0, beyond_j_ = 0.0;
  EnergyAccount account_;
  Guard guard_;
  Damper damper_;
  Impact impact_;
  Vec3 damping_n_;  // held since the last tick
  HandTick last_{};
  double link_total_j_ = 0.0;
};

GuardOptions HandSide::State::guard_options() const noexcept {
  GuardOptions options = guard_options_for(options_.device, options_.device.max_force_n);
  options.motors = options_.motors;
  options.dead_man_buttons = options_.dead_man_buttons;
  options.max_torque_nm = 0.0;
  return options;
}

Vec3 HandSide::State::cut(const Vec3& extension_m) const noexcept {
  const double length_m = norm(extension_m);
  return length_m > longest_m() ? (longest_m() / length_m) * extension_m : extension_m;
}

void HandSide::State::begin(const HandSample& sample, double time_step_s) noexcept {
  const bool time_usable = time_step_s > 0.0 && time_step_s <= most_step_s;
  const double step_s = time_usable ? time_step_s : 1e-3;
  now_s_ += step_s;
  ++newest_;
  const bool usable = sample.valid && time_usable && is_within(sample.position_m, furthest_m);
  const bool valid = usable && !std::exchange(restarts_, false);
  const Vec3 position_m = usable ? sample.position_m : kept(newest_ - 1).position_m;
  kept_[newest_ % most_kept] = {position_m, now_s_, step_s, sample.buttons, usable, valid};
  if (!valid) first_usable_ = newest_ + 1;
}

std::size_t HandSide::State::give(std::span<std::byte> to) noexcept {
  if (!connected_ || newest_ == 0) return 0;
  if (welcome_.scene == 0) {
    if (now_s_ - hello_at_s_ < hello_s) return 0;
    hello_at_s_ = now_s_;
    return write_message(HandHello{.token = options_.token,
                                   .max_force_n = options_.device.max_force_n,
                                   .max_stiffness_n_per_m = options_.device.max_stiffness_n_per_m,
                                   .max_damping_ns_per_m = std::min(options_.device.max_damping_ns_per_m, 1e9),
                                   .encoder_step_m = options_.device.encoder_step_m,
                                   .name = options_.name},
                         microseconds(now_s_), to);
  }
  const double report_s = std::clamp(0.3 * (round_trip_s_ - short_trip_s), shortest_report_s, longest_report_s);
  const bool is_full = newest_ - reported_ >= ProbeReport::most_samples && now_s_ - report_at_s_ >= full_report_s;
  if (now_s_ - report_at_s_ < report_s && !is_full) return 0;
  reported_ = newest_;
  report_at_s_ = now_s_;
  return write_message(report(), microseconds(now_s_), to);
}

ProbeReport HandSide::State::report() const noexcept {
  ProbeReport report;
  report.newest = newest_;
  report.count = static_cast<std::uint8_t>(std::min<std::uint64_t>(newest_, ProbeReport::most_samples));
  for (std::size_t n = 0; n < report.count; ++n) {
    const Kept& of = kept(newest_ - report.count + 1 + n);
    report.samples[n] = {of.position_m, static_cast<float>(of.time_step_s), of.buttons, of.valid};
  }
  report.proxy_m = proxy_m_;
  report.command_n = last_.command_n;
  report.guard = last_.guard, report.cause = last_.cause;
  report.model_age_s = static_cast<float>(std::min(last_.model_age_s, 1e5));
  report.model = answered_;
  report.echo_us = echo_us_;
  report.held_s = static_cast<float>(answered_ > 0 ? std::min(now_s_ - arrived_s_, 1e5) : 0.0);
  report.account_j = static_cast<float>(last_.account_j);
  report.link_total_j = static_cast<float>(link_total_j_);
  return report;
}

bool HandSide::State::take(std::span<const std::byte> message) noexcept {
  const std::optional<MessageHead> head = head_of(message);
  if (!head || !connected_) return false;
  switch (head->kind) {
    case MessageHead::Kind::welcome: {
      DataWelcome welcome;
      if (!read_message(message, welcome) || welcome.scene == 0) return false;
      if (!(std::min(welcome.stiffness_n_per_m, options_.device.max_stiffness_n_per_m) > 0.0)) return false;
      take_welcome(welcome);
      return true;
    }
    case MessageHead::Kind::model: {
      ModelUpdate model;
      if (!read_message(message, model) || !take_model(model)) return false;
      echo_us_ = head->time_us;
      return true;
    }
    case MessageHead::Kind::event: {
      ModelEvent event;
      if (!read_message(message, event)) return false;
      if (event_count_ == events_.size()) ++first_event_, --event_count_;
      events_[(first_event_ + event_count_++) % events_.size()] = event;
      return true;
    }
    default: return false;
  }
}

// Stiffness, damping and force are those of the device at most, however the data's side answers the hello.
void HandSide::State::take_welcome(const DataWelcome& welcome) noexcept {
  const double before_n_per_m = welcome_.stiffness_n_per_m;
  const bool is_new = welcome.scene != welcome_.scene;
  welcome_ = welcome;
  welcome_.stiffness_n_per_m = std::min(welcome.stiffness_n_per_m, options_.device.max_stiffness_n_per_m);
  welcome_.damping_ns_per_m = std::min(welcome.damping_ns_per_m, options_.device.max_damping_ns_per_m);
  unknown_scene_ = false;
  if (!is_new) return;
  damper_ = Damper(welcome_.damping_ns_per_m, options_.device.encoder_step_m, false);
  impact_.set_gain(welcome_.impact_ns_per_m);
  guard_.limit_to(std::min(welcome_.max_force_n, options_.device.max_force_n));
  if (!feels_) return;
  // The force stays: the extension changes with the spring.
  const double share = before_n_per_m / k();
  account_.scale(share);
  const Vec3 scaled_m = share * extension_m_;
  extension_m_ = cut(proxy_m_ - kept(newest_).position_m);
  account_.update(scaled_m, extension_m_, 0.0);
  damper_.reset({account_.felt_m(), {}});
}

bool HandSide::State::take_model(const ModelUpdate& model) noexcept {
  if (welcome_.scene == 0 || model.answers <= answered_ || model.answers > newest_) return false;
  if (model.scene != welcome_.scene) {
    unknown_scene_ = unknown_scene_ || model.scene > welcome_.scene;
    return false;
  }
  if (!is_kept(model.answers)) return false;
  answered_s_ = kept(model.answers).time_s;
  const double trip_s = std::max(0.0, now_s_ - 1e-6 * static_cast<double>(model.echo_us) - double{model.held_s});
  const double share = answered_ == 0 ? 1.0 : std::min(1.0, (now_s_ - arrived_s_) / usual_s);
  usual_age_s_ += share * (now_s_ - answered_s_ - usual_age_s_);
  round_trip_s_ += share * (trip_s - round_trip_s_);
  answered_ = model.answers;
  arrived_s_ = now_s_;
  coming_ = model;
  has_coming_ = true;
  return true;
}

void HandSide::State::stop_feeling() noexcept {
  feels_ = false;
  model_.clear();
  account_.restart();
  damper_.reset({});
  impact_.reset();
  extension_m_ = damping_n_ = {};
  elastic_j_ = beyond_j_ = 0.0;
}

// Free space in place of a model that is too old: its force falls as after an update.
void HandSide::State::forget_model() noexcept {
  model_.clear();
  account_.update(std::exchange(extension_m_, {}), {}, 0.0);
  proxy_m_ = kept(newest_ - 1).position_m;
  elastic_j_ = beyond_j_ = 0.0;
}

// Replaces the model: its proxy is the session's, moved by the samples since then. The felt extension stays.
void HandSide::State::reconcile() noexcept {
  has_coming_ = false;
  if (coming_.answers < first_usable_) return;
  const bool felt = std::exchange(feels_, true);
  model_.take(coming_);
  const std::uint64_t last = newest_ - 1;
  Vec3 proxy_m = coming_.proxy_m;
  double elastic_j = elastic_j_;
  std::uint64_t n = std::max(coming_.answers, newest_ > most_kept ? newest_ - most_kept : 0);
  while (++n <= last) {
    const Kept& at = kept(n);
    proxy_m = model_.move(proxy_m, at.position_m, at.time_step_s, at.time_s - kept(coming_.answers).time_s, k());
    if (n == last) elastic_j = model_.elastic_j();
  }
  // A session that is not behind is felt itself: its last tick is its own step.
  if (coming_.answers == newest_ && is_session_) return;
  const Vec3 whole_m = proxy_m - kept(last).position_m, extension_m = cut(whole_m);
  const double stretched_j = beyond_j(whole_m);
  account_.update(felt ? extension_m_ : Vec3{}, extension_m, felt ? elastic_j - elastic_j_ + stretched_j - beyond_j_ : 0.0);
  proxy_m_ = proxy_m;
  extension_m_ = extension_m;
  elastic_j_ = elastic_j;
  beyond_j_ = stretched_j;
}

HandSide::State::Felt HandSide::State::feel_model(const Kept& now, const Vec3& probe_step_m) noexcept {
  const bool is_session = has_coming_ && coming_.answers == newest_;
  if (has_coming_) reconcile();
  if (!feels_) return {};
  is_session_ = is_session;
  double source_j = 0.0;
  const double elastic_before_j = elastic_j_;
  const Vec3 proxy_before_m = proxy_m_;
  if (is_session) {
    proxy_m_ = coming_.proxy_m;
  } else {
    proxy_m_ = model_.move(proxy_m_, now.position_m, now.time_step_s, now.time_s - answered_s_, k());
    elastic_j_ = model_.elastic_j();
    source_j = model_.source_j();
  }
  const double beyond_before_j = std::exchange(beyond_j_, beyond_j(proxy_m_ - now.position_m));
  const Vec3 before_m = std::exchange(extension_m_, cut(proxy_m_ - now.position_m));
  const Vec3 offset_before_m = account_.offset_m();
  const double k_half = 0.5 * k();
  const double own_j = k_half * (norm_squared(extension_m_) - norm_squared(before_m - probe_step_m));
  const double stored_more_j = elastic_j_ - elastic_before_j + beyond_j_ - beyond_before_j;
  // The session's own step, and that of a spring beyond the cut, whose whole force moves the proxy, are not for the account.
  if (is_session || beyond_j_ > 0.0 || beyond_before_j > 0.0) source_j = std::max(source_j, own_j + stored_more_j);
  Felt felt;
  felt.extension_m = account_.felt_m({.before_m = before_m,
                                      .now_m = extension_m_,
                                      .probe_step_m = probe_step_m,
                                      .time_step_s = now.time_step_s,
                                      .source_j = source_j,
                                      .elastic_j = stored_more_j,
                                      .stiffness_n_per_m = k()});
  felt.released_m = account_.offset_m() - offset_before_m;
  felt.model_j = own_j;
  // k/2 |step|² where the proxy stands still, none where it follows.
  felt.gained_j = std::max(0.0, k_half * (norm_squared(probe_step_m) - norm_squared(proxy_m_ - proxy_before_m)));
  return felt;
}

LinkState HandSide::State::link_state() noexcept {
  if (!connected_ || unknown_scene_) return LinkState::closed;
  if (answered_ == 0) return LinkState::waiting;
  return now_s_ - answered_s_ > usual_age_s_ + stale_s ? LinkState::stale : LinkState::up;
}

HandTick HandSide::State::feel(std::uint32_t circumstances) noexcept {
  HandTick tick;
  if (newest_ == 0) return tick;
  const Kept& now = kept(newest_);
  const bool follows = now.valid && newest_ > 1 && kept(newest_ - 1).valid;
  const Vec3 probe_step_m = follows ? now.position_m - kept(newest_ - 1).position_m : Vec3{};
  if (!now.valid) stop_feeling();
  tick.link = link_state();
  if (tick.link == LinkState::stale && feels_) forget_model();
  const Vec3 held_m = account_.felt_m();
  const Felt felt = now.valid ? feel_model(now, probe_step_m) : Felt{};
  const double damper_j = dot(std::exchange(damping_n_, {}), probe_step_m);
  if (feels_) {
    const Motion rate = damper_.relative_velocity({felt.extension_m, {}}, {felt.released_m, {}}, now.time_step_s, k());
    damping_n_ = welcome_.damping_ns_per_m * rate.way_m;
  }
  tick.proxy_m = feels_ ? proxy_m_ : now.position_m;
  tick.force_n = k() * felt.extension_m + damping_n_;
  tick.model_age_s = now_s_ - answered_s_;
  tick.round_trip_s = round_trip_s_;
  tick.beyond = feels_ && distance(proxy_m_, model_.session_proxy_m()) > model_.valid_m();
  tick.offset_m = account_.offset_m();
  tick.account_j = account_.account_j();
  tick.work_j = k() * dot(held_m, probe_step_m);
  tick.sampling_j = feels_ ? 0.5 * k() * norm_squared(probe_step_m) : 0.0;
  tick.stored_j = 0.5 * k() * norm_squared(felt.extension_m);
  tick.model_j = felt.model_j;
  tick.link_j = feels_ ? account_.link_j() : 0.0;
  link_total_j_ = std::clamp(link_total_j_ + tick.link_j, -1e9, 1e9);
  tick.released_j = last_.stored_j - 0.5 * k() * norm_squared(held_m);

  impact_.move(probe_step_m, {}, now.time_step_s);
  if (feels_ && welcome_.impact_ns_per_m > 0.0)
    for (const HardContact& level : model_.met()) impact_.hit(level);
  const Wrench wanted = impact_.shape({tick.force_n, {}});
  if (tick.link == LinkState::closed) circumstances |= bit_of(Circumstance::link_closed);
  if (tick.link == LinkState::stale) circumstances |= bit_of(Circumstance::link_stale);
  const Guard::Passed passed = guard_.tick({.force_n = wanted.force_n,
                                            .probe_step_m = probe_step_m,
                                            .time_step_s = now.time_step_s,
                                            .usable = now.usable,
                                            .buttons = now.buttons,
                                            .circumstances = circumstances,
                                            .gained_j = damper_j + felt.gained_j});
  tick.command_n = passed.command_n;
  tick.guard = passed.state;
  tick.cause = passed.cause;
  tick.brakes = passed.brakes;
  if (passed.begins) restarts_ = true;
  return last_ = tick;
}

void HandSide::State::set_connected(bool connected) noexcept {
  if (connected == connected_) return;
  connected_ = connected;
  // A new connection is a new session at the data's side.
  welcome_.scene = 0;
  answered_ = 0, answered_s_ = now_s_;
  has_coming_ = unknown_scene_ = false;
  hello_at_s_ = now_s_ - hello_s;
  first_usable_ = newest_ + 1;
  stop_feeling();
}

bool HandSide::State::take_event(ModelEvent& event) noexcept {
  if (event_count_ == 0) return false;
  event = events_[first_event_++ % events_.size()];
  --event_count_;
  return true;
}

HandSide::HandSide(const HandSideOptions& options) : state_(std::make_unique<State>(options)) {}
HandSide::~HandSide() = default;
HandSide::HandSide(HandSide&&) noexcept = default;
HandSide& HandSide::operator=(HandSide&&) noexcept = default;

void HandSide::begin(const HandSample& sample, double time_step_s) noexcept { state_->begin(sample, time_step_s); }
std::size_t HandSide::give(std::span<std::byte> to) noexcept { return state_->give(to); }
bool HandSide::take(std::span<const std::byte> message) noexcept { return state_->take(message); }
HandTick HandSide::feel(std::uint32_t circumstances) noexcept { return state_->feel(circumstances); }
void HandSide::set_connected(bool connected) noexcept { state_->set_connected(connected); }
bool HandSide::take_event(ModelEvent& event) noexcept { return state_->take_event(event); }
const DataWelcome& HandSide::welcome() const noexcept { return state_->welcome(); }

}  // namespace palpa
