#include <time.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "palpa/device/latest.h"
#include "palpa/loop/clutch_mapping.h"
#include "palpa/loop/live_scene.h"
#include "palpa/loop/loop.h"
#include "palpa/loop/time_histogram.h"

namespace palpa {

namespace {

// Consecutive missed ticks that are a fault of a device with motors. More: it holds an old force for longer; fewer: any busy
// desktop stops the hand.
constexpr std::int64_t late_ticks = 3;
// A rehearsal begins before its tick's deadline by this and twice the mean tick. Longer: caches are polluted again until the
// tick; shorter: a long rehearsal makes the tick late.
constexpr double rehearsal_lead_s = 60e-6;
// ... but by no more than this share [1] of the period. More: the processor is always busy with rehearsals; less: ticks of high
// rates are cold.
constexpr double largest_lead = 0.4;
// A rehearsal is skipped if it would end later than this share [1] of its lead. More: ticks get late; less: cold.
constexpr double latest_share = 0.7;
// Number of ticks in the mean of the tick's time [1]. More: slow response to a costlier scene; fewer: jumpy.
constexpr double averaged_ticks = 64.0;

double seconds(clockid_t clock) noexcept {
  timespec now{};
  ::clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

class MonotonicClock final : public LoopClock {
 public:
  double now_s() noexcept override { return seconds(CLOCK_MONOTONIC); }
  void wait_until_s(double time_s) noexcept override {
    const double whole_s = std::floor(time_s);
    const timespec until{.tv_sec = static_cast<time_t>(whole_s), .tv_nsec = static_cast<long>(1e9 * (time_s - whole_s))};
    while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
    }
  }
};

LoopStatistics::Times times_of(const TimeHistogram& histogram) {
  return {.mean_us = histogram.mean_us(),
          .p50_us = histogram.percentile_us(0.5),
          .p99_us = histogram.percentile_us(0.99),
          .p999_us = histogram.percentile_us(0.999),
          .max_us = histogram.max_us()};
}

/// Writes zero force to its device at the end of a loop, also where an observer's exception ends it.
class EndAtNoForce {
 public:
  explicit EndAtNoForce(Device& device) noexcept : device_(device) {}
  ~EndAtNoForce() { device_.write({}); }
  EndAtNoForce(const EndAtNoForce&) = delete;
  EndAtNoForce& operator=(const EndAtNoForce&) = delete;

 private:
  Device& device_;
};

// Single writer, any number of readers.
class Counter {
 public:
  void add(std::int64_t number) noexcept { store(load() + number); }
  void store(std::int64_t number) noexcept { value_.store(number, std::memory_order_relaxed); }
  std::int64_t load() const noexcept { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::int64_t> value_{0};
};

}  // namespace

/// One hand of a loop.
class LiveLoop::Hand {
 public:
  Hand(const LiveHand& hand, LiveScene::State& its_scene)
      : scene(its_scene),
        device(*hand.device),
        recorder(hand.recorder),
        prepared(its_scene.take()),
        loop_number(its_scene.loader() ? its_scene.loader()->begin_loop() : 0),
        guarded(prepared->felt, hand.options.guard),
        has_motors(device.limits().has_motors),
        grip({.workspace_radius_m = device.limits().workspace_radius_m,
              .clutch_buttons = hand.options.clutch_buttons,
              .goes_on_at_border = hand.options.goes_on_at_border}) {}
  ~Hand() { scene.put_back(prepared); }
  Hand(const Hand&) = delete;
  Hand& operator=(const Hand&) = delete;

  // ---- of a tick, in this order ----

  void read(double dt_s) noexcept;
  /// \param shared  bits of Circumstance that all hands have
  void note(std::uint32_t shared, std::int64_t missed) noexcept;
  /// Whether the others have to fall, before the tick and after it.
  bool has_fault() const noexcept;
  void change_scene() noexcept;
  void lay_window(double dt_s) noexcept;
  void tick(std::int64_t number, double t_s, double dt_s) noexcept;
  void write() noexcept;
  void tell() noexcept;
  void give_back() noexcept {
    if (prepared != before) scene.give_back(before);
  }
  void rehearse(double period_s) noexcept;

  static constexpr std::size_t most_modes = 64;  // with a reported cost. More: memory; fewer: large scenes report less

  LiveScene::State& scene;
  Device& device;
  Recorder* recorder;
  PreparedSession* prepared;
  PreparedSession* before = nullptr;  // at the start of the tick
  const std::uint32_t loop_number;    // for the window loader
  GuardedSession guarded;
  const bool has_motors;  // without, no old force was held in missed ticks
  ClutchMapping grip;

  Latest<Mat3> turns;  // from another thread
  // Outputs to other threads.
  Latest<LiveView> views;
  Counter unrecorded, scenes, rehearsals;
  std::array<Counter, most_modes> spent_ns;  // by mode

  // Of this tick.
  DeviceState state;
  ClutchMapping::Held held;
  WindowPlace laid;
  std::uint32_t circumstances = 0;
  TickFrame frame;

  // State between ticks.
  bool is_linked = true;
  bool brakes = false;
  bool had_fault = false;
  bool has_probe = false;
  Mat3 turn_now = Mat3::identity();
};

void LiveLoop::Hand::read(double dt_s) noexcept {
  state = device.read();
  if (turns.is_fresh()) grip.turn(turn_now = turns.take());
  held = grip.hold(state, dt_s);
}

void LiveLoop::Hand::note(std::uint32_t shared, std::int64_t missed) noexcept {
  circumstances = shared;
  const auto add = [&](Circumstance circumstance, bool is_so) { circumstances |= is_so ? bit_of(circumstance) : 0u; };
  add(Circumstance::device_fault, state.fault != nullptr);
  add(Circumstance::link_lost, !is_linked);
  add(Circumstance::late, has_motors && missed >= late_ticks);
  add(Circumstance::view_moves, held.moves);
}

bool LiveLoop::Hand::has_fault() const noexcept {
  constexpr std::uint32_t faults =
      bit_of(Circumstance::device_fault) | bit_of(Circumstance::link_lost) | bit_of(Circumstance::late);
  return had_fault || (circumstances & faults) != 0 || !state.valid;
}

// Switches to a scene set since the last tick.
void LiveLoop::Hand::change_scene() noexcept {
  before = prepared;
  PreparedSession* const next = scene.take();
  if (!next) return;
  next->felt.resume_in_changed_scene(prepared->felt);
  guarded.switch_to(next->felt, next->tool);
  prepared = next;
  circumstances |= bit_of(Circumstance::new_scene);
  scenes.add(1);
  for (Counter& spent : spent_ns) spent.store(0);
  rehearsals.store(0);
}

// Of volumes larger than memory: publishes the motion of the feet, and lays the window that has come, if any.
void LiveLoop::Hand::lay_window(double dt_s) noexcept {
  laid = {};
  if (prepared->loaded_scene == 0) return;
  WindowLoader& loader = *scene.loader();
  Session& felt = prepared->felt;
  loader.publish(
      {motion_of(felt.window_need(held.probe, dt_s), felt.hand_to_world().scale), loop_number, prepared->loaded_scene});
  WindowLoader::Loaded* const loaded = loader.take();
  if (!loaded) return;
  felt.stock().lay(*loaded->place.of, loaded->place.octave, loaded->window);
  laid = loaded->place;
  WindowLoader::give_back(loaded);
}

void LiveLoop::Hand::tick(std::int64_t number, double t_s, double dt_s) noexcept {
  lay_window(dt_s);
  const double cpu_s = seconds(CLOCK_THREAD_CPUTIME_ID);
  frame = guarded.tick(number, t_s, dt_s, held.probe, circumstances);
  frame.tick_us = 1e6 * (seconds(CLOCK_THREAD_CPUTIME_ID) - cpu_s);
  frame.laid = laid;
  // Faults found by the tick alone: a pose or a force that is none, a fast hand.
  had_fault = frame.result.status == TickStatus::bad_input || frame.command.guard == GuardState::fault || guarded.brakes();
  has_probe = held.probe.valid && is_finite(held.probe.position_m);
}

void LiveLoop::Hand::write() noexcept {
  if (guarded.brakes() != brakes) device.brake(brakes = guarded.brakes());
  const Wrench sent = grip.at_device({frame.command.force_n, frame.command.torque_nm});
  is_linked = device.write(sent.force_n, sent.torque_nm);
}

// Publishes and records a tick after its force was sent.
void LiveLoop::Hand::tell() noexcept {
  views.give({frame, turn_now, state.fault});
  if (recorder && !recorder->offer(frame, guarded.session())) unrecorded.add(1);
}

// A second session processes the expected probe: the next tick then has its code and data in the caches. Its results are
// discarded.
void LiveLoop::Hand::rehearse(double period_s) noexcept {
  if (!has_probe) return;
  prepared->rehearsal.copy_state_from(prepared->felt);
  prepared->rehearsal.tick({.position_m = held.probe.position_m + frame.result.probe_step_m,
                            .turn = turned_further(held.probe.turn, frame.result.probe_turn_step_rad)},
                           period_s);
  rehearsals.add(1);
  for (std::size_t m = 0; m < std::min(prepared->spent_ns.size(), most_modes); ++m)
    spent_ns[m].add(std::exchange(prepared->spent_ns[m], 0));
}

class LiveLoop::State {
 public:
  State(std::span<const LiveHand> given, LoopClock* given_clock)
      : options(given.front().options), clock(given_clock ? *given_clock : monotonic) {
    for (const LiveHand& hand : given) hands.push_back(std::make_unique<Hand>(hand, *hand.scene->state_));
  }

  void run(const std::atomic<bool>& stop, const HandObserver& observer);
  void read(std::span<DrivenDevice* const> driven, std::int64_t missed, double dt_s) noexcept;
  void rehearse(double deadline_s, double period_s) noexcept;

  LiveOptions options;  // rate, duration and rehearsals
  MonotonicClock monotonic;
  LoopClock& clock;
  std::vector<std::unique_ptr<Hand>> hands;

  // Inputs from other threads.
  std::atomic<bool> panics{false}, resumes{false}, view_moves{false};
  // Outputs to other threads.
  TimeHistogram late, period, tick_time;
  Counter ticks, missed_ticks;

  double mean_tick_s = 0.0;
};

// All hands, with the faults of each for the others.
void LiveLoop::State::read(std::span<DrivenDevice* const> driven, std::int64_t missed, double dt_s) noexcept {
  std::uint32_t shared = 0;
  const auto add = [&](Circumstance circumstance, bool is_so) { shared |= is_so ? bit_of(circumstance) : 0u; };
  add(Circumstance::view_moves, view_moves.load(std::memory_order_relaxed));
  add(Circumstance::panic, panics.load(std::memory_order_relaxed));
  add(Circumstance::resume, resumes.exchange(false, std::memory_order_relaxed));
  for (DrivenDevice* const one : driven) add(Circumstance::stops, one->has_to_rest());
  for (const auto& hand : hands) {
    hand->read(dt_s);
    hand->note(shared, missed);
  }
  for (const auto& hand : hands) {
    const bool others_have = std::ranges::any_of(hands, [&](const auto& other) { return other != hand && other->has_fault(); });
    if (others_have) hand->circumstances |= bit_of(Circumstance::other_hand);
    hand->change_scene();
  }
}

void LiveLoop::State::rehearse(double deadline_s, double period_s) noexcept {
  const double lead_s = std::min(rehearsal_lead_s + 2.0 * mean_tick_s, largest_lead * period_s);
  clock.wait_until_s(deadline_s - lead_s);
  for (const auto& hand : hands)
    if (clock.now_s() <= deadline_s - (1.0 - latest_share) * lead_s) hand->rehearse(period_s);
}

void LiveLoop::State::run(const std::atomic<bool>& stop, const HandObserver& observer) {
  std::vector<std::unique_ptr<DrivenDevice>> driven;
  std::vector<DrivenDevice*> all_driven;
  std::vector<std::unique_ptr<EndAtNoForce>> ends;
  for (const auto& hand : hands) {
    all_driven.push_back(driven.emplace_back(std::make_unique<DrivenDevice>(hand->device)).get());
    ends.push_back(std::make_unique<EndAtNoForce>(hand->device));
  }
  const double period_s = 1.0 / options.rate_hz;
  const double begin_s = clock.now_s() + period_s;
  double last_s = begin_s;
  std::int64_t number = 0, last_number = -1;
  while (!stop.load(std::memory_order_relaxed) && static_cast<double>(number) * period_s < options.duration_s) {
    const double deadline_s = begin_s + static_cast<double>(number) * period_s;
    if (options.rehearse) rehearse(deadline_s, period_s);
    clock.wait_until_s(deadline_s);
    const double now_s = clock.now_s();
    const auto skipped = static_cast<std::int64_t>(std::max(0.0, std::floor((now_s - deadline_s) / period_s)));
    number += skipped;
    const double dt_s = static_cast<double>(number - last_number) * period_s;
    last_number = number;

    read(all_driven, skipped, dt_s);
    const double was_read_s = clock.now_s();
    double tick_us = 0.0;
    for (const auto& hand : hands) {
      hand->tick(number, static_cast<double>(number) * period_s, std::min(dt_s, 1.0));
      tick_us += hand->frame.tick_us;
    }
    const double was_felt_s = clock.now_s();
    for (const auto& hand : hands) hand->write();
    const double device_us = 1e6 * ((was_read_s - now_s) + (clock.now_s() - was_felt_s));

    late.add(1e6 * (now_s - deadline_s));
    if (ticks.load() > 0) period.add(1e6 * (now_s - last_s));
    tick_time.add(tick_us);
    missed_ticks.add(skipped);
    ticks.add(1);
    last_s = now_s;
    mean_tick_s += (1e-6 * tick_us - mean_tick_s) / averaged_ticks;
    for (std::size_t h = 0; h < hands.size(); ++h) {
      Hand& hand = *hands[h];
      hand.frame.late_us = 1e6 * (now_s - deadline_s);
      hand.frame.device_us = device_us;
      hand.tell();
      if (observer) observer(h, hand.frame, hand.guarded.session());
      hand.give_back();
    }
    ++number;
  }
}

LiveLoop::LiveLoop(std::span<const LiveHand> hands, LoopClock* clock) : state_(std::make_unique<State>(hands, clock)) {
  for (const LiveHand& hand : hands)
    if (hand.recorder) hand.recorder->make_resident();
}
LiveLoop::LiveLoop(LiveScene& scene, Device& device, const LiveOptions& options, Recorder* recorder, LoopClock* clock)
    : LiveLoop(std::array{LiveHand{&scene, &device, options, recorder}}, clock) {}
LiveLoop::~LiveLoop() = default;

void LiveLoop::run(const std::atomic<bool>& stop, const TickObserver& observer) {
  if (!observer) return state_->run(stop, {});
  state_->run(stop, [&](std::size_t, const TickFrame& frame, const Session& felt) { observer(frame, felt); });
}
void LiveLoop::run_hands(const std::atomic<bool>& stop, const HandObserver& observer) { state_->run(stop, observer); }
void LiveLoop::panic() noexcept { state_->panics = true; }
void LiveLoop::resume() noexcept {
  state_->panics = false;
  state_->resumes = true;
}
void LiveLoop::hold_while_view_moves(bool moves) noexcept { state_->view_moves = moves; }
void LiveLoop::set_view_rotation(const Mat3& turn, std::size_t hand) noexcept { state_->hands[hand]->turns.give(turn); }
const LiveView& LiveLoop::latest(std::size_t hand) noexcept { return state_->hands[hand]->views.take(); }

LoopStatistics LiveLoop::statistics(std::size_t number) const {
  const State& s = *state_;
  const Hand& hand = *s.hands[number];
  LoopStatistics made{.ticks = s.ticks.load(),
                      .missed = s.missed_ticks.load(),
                      .unrecorded = hand.unrecorded.load(),
                      .scenes = hand.scenes.load(),
                      .late = times_of(s.late),
                      .period = times_of(s.period),
                      .tick = times_of(s.tick_time),
                      .modes = {},
                      .windows = {}};
  if (const WindowLoader* loader = hand.scene.loader()) made.windows = loader->counts();
  const auto rehearsals = static_cast<double>(std::max<std::int64_t>(1, hand.rehearsals.load()));
  const Scene scene = hand.scene.scene();
  for (std::size_t m = 0; m < std::min(scene.modes().size(), Hand::most_modes); ++m)
    made.modes.push_back({scene.modes()[m].name, 1e-3 * static_cast<double>(hand.spent_ns[m].load()) / rehearsals});
  return made;
}

}  // namespace palpa
