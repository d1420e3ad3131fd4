#include <time.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <utility>

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

class LiveLoop::State {
 public:
  State(LiveScene::State& given, Device& driven, const LiveOptions& wanted, Recorder* records, LoopClock* given_clock)
      : scene(given),
        device(driven),
        options(wanted),
        recorder(records),
        clock(given_clock ? *given_clock : monotonic),
        prepared(given.take()),
        guarded(prepared->felt, wanted.guard),
        has_motors(driven.limits().has_motors),
        grip({.workspace_radius_m = driven.limits().workspace_radius_m,
              .clutch_buttons = wanted.clutch_buttons,
              .goes_on_at_border = wanted.goes_on_at_border}) {}
  ~State() { scene.put_back(prepared); }

  void run(const std::atomic<bool>& stop, const TickObserver& observer);
  std::uint32_t circumstances_now(const DeviceState& state, std::int64_t missed, bool grip_moves, bool stops) noexcept;
  void change_scene(std::uint32_t& circumstances) noexcept;
  void tell(TickFrame& frame, const char* device_fault) noexcept;
  void rehearse(double deadline_s, double period_s) noexcept;

  static constexpr std::size_t most_modes = 64;  // with a reported cost. More: memory; fewer: large scenes report less

  LiveScene::State& scene;
  Device& device;
  LiveOptions options;
  Recorder* recorder;
  MonotonicClock monotonic;
  LoopClock& clock;
  PreparedSession* prepared;
  GuardedSession guarded;
  const bool has_motors;  // without, no old force was held in missed ticks
  ClutchMapping grip;

  // Inputs from other threads.
  std::atomic<bool> panics{false}, resumes{false}, view_moves{false};
  Latest<Mat3> turns;
  // Outputs to other threads.
  Latest<LiveView> views;
  TimeHistogram late, period, tick_time;
  Counter ticks, missed_ticks, unrecorded, scenes, rehearsals;
  std::array<Counter, most_modes> spent_ns;  // by mode

  // State between ticks.
  bool is_linked = true;
  bool brakes = false;
  double mean_tick_s = 0.0;
  Vec3 probe_m, probe_step_m, probe_turn_step_rad;
  Turn probe_turn;
  bool has_probe = false;
  Mat3 turn_now = Mat3::identity();
};

std::uint32_t LiveLoop::State::circumstances_now(const DeviceState& state, std::int64_t missed, bool grip_moves,
                                                 bool stops) noexcept {
  std::uint32_t bits = 0;
  const auto add = [&](Circumstance circumstance, bool is_so) { bits |= is_so ? bit_of(circumstance) : 0u; };
  add(Circumstance::device_fault, state.fault != nullptr);
  add(Circumstance::link_lost, !is_linked);
  add(Circumstance::late, has_motors && missed >= late_ticks);
  add(Circumstance::view_moves, grip_moves || view_moves.load(std::memory_order_relaxed));
  add(Circumstance::panic, panics.load(std::memory_order_relaxed));
  add(Circumstance::stops, stops);
  add(Circumstance::resume, resumes.exchange(false, std::memory_order_relaxed));
  return bits;
}

// Switches to a scene set since the last tick.
void LiveLoop::State::change_scene(std::uint32_t& circumstances) noexcept {
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

// Publishes and records a tick after its force was sent.
void LiveLoop::State::tell(TickFrame& frame, const char* device_fault) noexcept {
  views.give({frame, turn_now, device_fault});
  if (recorder && !recorder->offer(frame, guarded.session())) unrecorded.add(1);
}

// A second session processes the expected probe: the next tick then has its code and data in the caches. Its results are
// discarded.
void LiveLoop::State::rehearse(double deadline_s, double period_s) noexcept {
  const double lead_s = std::min(rehearsal_lead_s + 2.0 * mean_tick_s, largest_lead * period_s);
  clock.wait_until_s(deadline_s - lead_s);
  if (clock.now_s() > deadline_s - (1.0 - latest_share) * lead_s || !has_probe) return;
  prepared->rehearsal.copy_state_from(prepared->felt);
  prepared->rehearsal.tick({.position_m = probe_m + probe_step_m, .turn = turned_further(probe_turn, probe_turn_step_rad)},
                           period_s);
  rehearsals.add(1);
  for (std::size_t m = 0; m < std::min(prepared->spent_ns.size(), most_modes); ++m)
    spent_ns[m].add(std::exchange(prepared->spent_ns[m], 0));
}

void LiveLoop::State::run(const std::atomic<bool>& stop, const TickObserver& observer) {
  DrivenDevice driven(device);
  const EndAtNoForce end(device);
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

    const DeviceState state = device.read();
    if (turns.is_fresh()) grip.turn(turn_now = turns.take());
    const ClutchMapping::Held held = grip.hold(state, dt_s);
    std::uint32_t circumstances = circumstances_now(state, skipped, held.moves, driven.has_to_rest());
    PreparedSession* const before = prepared;
    change_scene(circumstances);
    const double was_read_s = clock.now_s();

    const double cpu_s = seconds(CLOCK_THREAD_CPUTIME_ID);
    TickFrame frame =
        guarded.tick(number, static_cast<double>(number) * period_s, std::min(dt_s, 1.0), held.probe, circumstances);
    frame.tick_us = 1e6 * (seconds(CLOCK_THREAD_CPUTIME_ID) - cpu_s);

    const double was_felt_s = clock.now_s();
    if (guarded.brakes() != brakes) device.brake(brakes = guarded.brakes());
    const Wrench sent = grip.at_device({frame.command.force_n, frame.command.torque_nm});
    is_linked = device.write(sent.force_n, sent.torque_nm);
    frame.late_us = 1e6 * (now_s - deadline_s);
    frame.device_us = 1e6 * ((was_read_s - now_s) + (clock.now_s() - was_felt_s));

    late.add(frame.late_us);
    if (ticks.load() > 0) period.add(1e6 * (now_s - last_s));
    tick_time.add(frame.tick_us);
    missed_ticks.add(skipped);
    ticks.add(1);
    last_s = now_s;
    mean_tick_s += (1e-6 * frame.tick_us - mean_tick_s) / averaged_ticks;
    probe_m = held.probe.position_m;
    probe_turn = held.probe.turn;
    probe_step_m = frame.result.probe_step_m;
    probe_turn_step_rad = frame.result.probe_turn_step_rad;
    has_probe = held.probe.valid && is_finite(probe_m);

    tell(frame, state.fault);
    if (observer) observer(frame, guarded.session());
    if (prepared != before) scene.give_back(before);
    ++number;
  }
}

LiveLoop::LiveLoop(LiveScene& scene, Device& device, const LiveOptions& options, Recorder* recorder, LoopClock* clock)
    : state_(std::make_unique<State>(*scene.state_, device, options, recorder, clock)) {
  if (recorder) recorder->make_resident();
}
LiveLoop::~LiveLoop() = default;

void LiveLoop::run(const std::atomic<bool>& stop, const TickObserver& observer) { state_->run(stop, observer); }
void LiveLoop::panic() noexcept { state_->panics = true; }
void LiveLoop::resume() noexcept {
  state_->panics = false;
  state_->resumes = true;
}
void LiveLoop::hold_while_view_moves(bool moves) noexcept { state_->view_moves = moves; }
void LiveLoop::set_view_rotation(const Mat3& turn) noexcept { state_->turns.give(turn); }
const LiveView& LiveLoop::latest() noexcept { return state_->views.take(); }

LoopStatistics LiveLoop::statistics() const {
  const State& s = *state_;
  LoopStatistics made{.ticks = s.ticks.load(),
                      .missed = s.missed_ticks.load(),
                      .unrecorded = s.unrecorded.load(),
                      .scenes = s.scenes.load(),
                      .late = times_of(s.late),
                      .period = times_of(s.period),
                      .tick = times_of(s.tick_time),
                      .modes = {}};
  const auto rehearsals = static_cast<double>(std::max<std::int64_t>(1, s.rehearsals.load()));
  const Scene scene = s.scene.scene();
  for (std::size_t m = 0; m < std::min(scene.modes().size(), State::most_modes); ++m)
    made.modes.push_back({scene.modes()[m].name, 1e-3 * static_cast<double>(s.spent_ns[m].load()) / rehearsals});
  return made;
}

}  // namespace palpa
