// Loop: read → tick → release, impact, guard → write, on a simulated clock or live; and a recorder that never blocks it.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "palpa/device/device.h"
#include "palpa/guard/guard_state.h"
#include "palpa/session/session.h"
#include "palpa/solver/tool.h"
#include "palpa/solver/vec3.h"
#include "palpa/trace/trace.h"

namespace palpa {

/// Copies whole ticks from the loop to a bounded ring; its own thread formats and writes them. Ticks reach the operating system
/// within 10 ms and 100 ticks.
class Recorder {
 public:
  /// \param writer      must outlive `finish`, unused by others
  /// \param ring_bytes  memory of the ring, committed on use
  explicit Recorder(TraceWriter& writer, std::size_t ring_bytes = std::size_t{16} << 20);
  /// Writes the remaining ticks; ignores a full disk.
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Commits all memory of the ring now: a real-time loop must not page-fault. Before the first tick.
  void make_resident() noexcept;
  /// Copies a whole tick, with the session's records of it, to the ring. Never blocks, allocates or throws: false without room,
  /// or if the writer has failed (a full disk).
  bool offer(const TickFrame& frame, const Session& session) noexcept;
  /// Likewise from the parts of a tick.
  bool offer(const TickFrame& frame, std::span<const ModeForce> modes, std::span<const SubStep> sub_steps,
             std::span<const PlacedPrimitive> placed, std::span<const SessionEvent> events) noexcept;
  /// Wakes the writer, and blocks until at most `most_pending_ticks` [1] are outside of the operating system's hands. Not for a
  /// real-time loop. Rethrows the writer's exception.
  void keep_up(std::int64_t most_pending_ticks);
  /// Writes the remaining ticks, joins the thread. Rethrows the writer's exception.
  void finish();

 private:
  class Ring;
  std::unique_ptr<Ring> ring_;
};

/// Smaller of the scene's force limit and the device's [N].
double force_limit_n(const Scene& scene, double device_max_force_n) noexcept;
/// Smaller of the scene's torque limit and the device's [N·m]; 0: the device drives no torque.
double torque_limit_nm(const Scene& scene, double device_max_torque_nm) noexcept;

/// One turn of the loop without its device: tick → release → impact → guard. Live loops and replays share it, so that equal
/// probes give equal frames. Allocates at construction only; one thread.
class GuardedSession {
 public:
  /// The guard is the limit alone, for a hand without motors; no torque is sent. Sets the session's force limit.
  /// \param device_max_force_n  [N] the device's limit; the scene's holds as well
  GuardedSession(Session& session, double device_max_force_n);
  /// With the whole guard.
  /// \param options  with the device's `max_force_n` and `max_torque_nm`; the scene's hold as well
  GuardedSession(Session& session, const GuardOptions& options);
  ~GuardedSession();
  GuardedSession(const GuardedSession&) = delete;
  GuardedSession& operator=(const GuardedSession&) = delete;

  /// Runs a tick; `command.force_n` and `command.torque_nm` are for the device: zero for an unusable probe. The frame's own
  /// probe, velocity, turn, validity, buttons, circumstances and time step reproduce it. `late_us`, `tick_us` and `device_us`
  /// stay 0. While the view moves the turn of the probe is not the hand's: it does no work and has no speed.
  /// \param circumstances  bits of Circumstance
  TickFrame tick(std::int64_t number, double t_s, double dt_s, const Probe& probe, std::uint32_t circumstances = 0) noexcept;
  /// Switches to another session from the next tick on; it must continue from this one (`Session::copy_state_from` or
  /// `resume_in_changed_scene`). That tick runs both, and spreads the step between their forces over the ramp's time. The old
  /// session is then unused.
  /// \param tool  of the scene of `next`
  void switch_to(Session& next, const Tool& tool) noexcept;
  bool brakes() const noexcept;
  const Session& session() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Options of a loop on a simulated clock.
struct LoopOptions {
  double rate_hz = 1000.0;   ///< > 0
  double duration_s = 10.0;  ///< ticks begin at n / rate_hz for all n with n / rate_hz below this; infinite: until `stop`
  bool time_ticks = true;    ///< measure each tick with the monotonic clock
};

/// Called after every tick, on the loop's thread.
using TickObserver = std::function<void(const TickFrame&, const Session&)>;

/// Runs `session` with `device` on a simulated clock: at full speed, with reproducible bits. Tick n begins at exactly n /
/// rate_hz; the time step is 1 / rate_hz, in the first as well. With a recorder it blocks on the writer, so that nothing is
/// lost, and a kill loses at most 100 ticks. Returns the number of ticks. `stop` (an interrupt) ends it after the current tick.
/// Rethrows the exceptions of the recorder's writer and of `observer`.
std::int64_t run_simulated(Session& session, SimulatedDevice& device, const LoopOptions& options, Recorder* recorder,
                           const TickObserver& observer, const std::atomic<bool>* stop = nullptr);

/// One of several hands on a simulated clock: a session with its tool, its device, and its recorder or nullptr.
struct SimulatedHand {
  Session* session;
  SimulatedDevice* device;
  Recorder* recorder = nullptr;
};
/// Called after every tick for each hand, by its number, on the loop's thread.
using HandObserver = std::function<void(std::size_t hand, const TickFrame&, const Session&)>;

/// Likewise for several hands on one clock: in each tick all are read, then all tick, then all are written. Each feels as if it
/// were alone, to the bit.
/// \param hands  at least one
std::int64_t run_simulated(std::span<const SimulatedHand> hands, const LoopOptions& options, const HandObserver& observer,
                           const std::atomic<bool>* stop = nullptr);

// ---- live: with a person's hand, in real time ----

/// The scene with stiffness and damping within a device's limits; of a tool also those of turning, the stiffness by a smaller
/// turning radius. A damping of turning that would follow from that radius follows from the smaller one.
Scene clamped_to(Scene scene, const DeviceLimits& limits);
/// Limit that changed a scene.
struct TakenLimit {
  std::string path;  ///< of a setting that makes the change, as --set takes it
  double value;      ///< the parameter's own unit
  std::string sentence;
};
/// Limits that made `clamped` of `scene`. Allocates; any thread.
std::vector<TakenLimit> taken_limits(const Scene& scene, const Scene& clamped);

/// A scene that can be changed by any thread during a live loop, which never blocks on it.
class LiveScene {
 public:
  /// \param limits  of the device, applied to every scene (`clamped_to`)
  /// Throws SceneError.
  explicit LiveScene(const Scene& scene, const DeviceLimits& limits = {});
  ~LiveScene();
  LiveScene(const LiveScene&) = delete;
  LiveScene& operator=(const LiveScene&) = delete;

  Scene scene() const;
  /// Replaces the scene: makes its session on the caller's thread; the loop switches to it in the next tick and continues at
  /// the hand. Of several scenes between two ticks the last wins. Throws SceneError and changes nothing.
  void set(const Scene& scene);
  /// Applies `edit` to the scene; concurrent edits are all kept. Rethrows the exceptions of `edit`.
  void change(const std::function<void(Scene&)>& edit);

 private:
  friend class LiveLoop;
  class State;
  std::unique_ptr<State> state_;
};

/// Clock of a loop. `now_s` never decreases; neither throws.
class LoopClock {
 public:
  virtual ~LoopClock() = default;
  virtual double now_s() noexcept = 0;
  /// Blocks until `time_s`; returns at once if that is over.
  virtual void wait_until_s(double time_s) noexcept = 0;
};

/// Options of a live loop and its device.
struct LiveOptions {
  double rate_hz = 1000.0;                                      ///< [100, 20000]
  double duration_s = std::numeric_limits<double>::infinity();  ///< > 0
  bool rehearse = true;              ///< a second session processes the expected probe before each tick, to warm the caches
  GuardOptions guard{};              ///< with the device's `max_force_n` and `max_torque_nm`; the scene's hold as well
  std::uint32_t clutch_buttons = 0;  ///< while one of these is held, the handle moves without the probe
  bool goes_on_at_border = false;    ///< a handle at the border of its workspace moves the probe on
};

/// Counters and times of a live loop.
struct LoopStatistics {
  struct Times {
    double mean_us = 0.0, p50_us = 0.0, p99_us = 0.0, p999_us = 0.0, max_us = 0.0;
  };
  struct ModeCost {
    std::string name;
    double mean_us = 0.0;  ///< per tick, to place its primitives, measured in rehearsals
  };
  /// Windows of volumes larger than memory.
  struct Windows {
    std::int64_t made = 0;
    std::int64_t lost = 0;             ///< not made: voxels are lost or damaged, or their source has failed
    double busy_s = 0.0;               ///< time of making, reading included
    std::vector<std::string> notes{};  ///< a sentence for each volume whose source failed or falls behind
  };
  std::int64_t ticks = 0;
  std::int64_t missed = 0;      ///< ticks skipped by a late loop
  std::int64_t unrecorded = 0;  ///< ticks without room in the recorder
  std::int64_t scenes = 0;      ///< scene changes
  Times late;                   ///< delay of ticks' starts
  Times period;                 ///< between the starts of successive ticks
  Times tick;                   ///< processor time of `GuardedSession::tick`
  std::vector<ModeCost> modes;
  Windows windows;
};

/// Latest tick, for a viewer.
struct LiveView {
  TickFrame frame;
  Mat3 turn = Mat3::identity();
  const char* device_fault = nullptr;  ///< a literal: fault reported by the device
};

/// One of several hands of a live loop: its scene with its tool, and its device.
struct LiveHand {
  LiveScene* scene;
  Device* device;
  LiveOptions options{};  ///< rate, duration and rehearsals are those of the first hand
  Recorder* recorder = nullptr;
};

/// Real-time loop: one thread, absolute deadlines; in each tick read → tick → guard → write, then publish and record, then a
/// rehearsal. Late ticks are skipped and counted: the next tick has the whole time step. Its thread does not allocate or lock,
/// and blocks on the clock only.
///
/// Several hands share clock and thread: in each tick all are read, then all tick, then all are written. A fault of one, of its
/// device or of its guard, lets all fall (GuardCause::other_hand); each returns by its own gate and ramp. A panic or a stop is
/// of all.
class LiveLoop {
 public:
  /// \param hands  at least one
  /// \param clock  nullptr: the monotonic clock
  explicit LiveLoop(std::span<const LiveHand> hands, LoopClock* clock = nullptr);
  /// \param recorder  or nullptr
  /// \param clock     nullptr: the monotonic clock
  LiveLoop(LiveScene& scene, Device& device, const LiveOptions& options, Recorder* recorder = nullptr,
           LoopClock* clock = nullptr);
  ~LiveLoop();
  LiveLoop(const LiveLoop&) = delete;
  LiveLoop& operator=(const LiveLoop&) = delete;

  /// Runs on this thread until `stop` or the end of the duration; the motors then have no force. `observer` may be empty; it
  /// must not allocate or block.
  void run(const std::atomic<bool>& stop, const TickObserver& observer = {});
  /// Likewise for several hands.
  void run_hands(const std::atomic<bool>& stop, const HandObserver& observer = {});

  // Any thread, during `run`.

  /// Zero force from the next tick on, until `resume`.
  void panic() noexcept;
  /// Resumes after a panic, with the gate and the ramp of a start.
  void resume() noexcept;
  /// Zero force while the view or the map moves; contact restarts afterwards.
  void hold_while_view_moves(bool moves) noexcept;
  /// \param hand  of unrecorded ticks, scenes and modes; the times are those of all hands
  LoopStatistics statistics(std::size_t hand = 0) const;

  // One other thread, the viewer's.

  /// Sets the rotation from a hand's axes to its hand frame: a push to the right moves to the right of the screen.
  void set_view_rotation(const Mat3& rotation, std::size_t hand = 0) noexcept;
  const LiveView& latest(std::size_t hand = 0) noexcept;

 private:
  class Hand;
  class State;
  std::unique_ptr<State> state_;
};

/// A device driven by this program, from construction to destruction: any detectable stop of the program first releases the
/// force of its motors (docs/safety.md). A LiveLoop has one while it runs; a program that writes to a device itself makes one
/// on the thread that does so.
///
/// While any exists, the signals that would end or suspend the program, or that its own faults raise, have a handler of the
/// library, which blocks until the motors rest, at most 0.25 s, and then runs the default action, or the fault's previous
/// handler. Signals that the program handles or ignores stay with it, except for faults: its handlers make a `MotorsAtRest`.
/// Also covers `exit`, `quick_exit`, `abort` and `terminate`; not `_exit`, `exec`, SIGKILL, SIGSTOP and a failing driver's
/// thread.
class DrivenDevice {
 public:
  /// \param device  must outlive this. Throws std::runtime_error if the program drives 64 already.
  explicit DrivenDevice(Device& device);
  /// Blocks until the motors have no force, at most 20 ms.
  ~DrivenDevice();
  DrivenDevice(const DrivenDevice&) = delete;
  DrivenDevice& operator=(const DrivenDevice&) = delete;

  /// Whether the program is stopping: the next force must be zero, or fall to zero within a few writes. Call before each write,
  /// on its thread; neither allocates nor blocks.
  bool has_to_rest() noexcept;

 private:
  std::size_t place_ = 0;
};

/// Zero force of all devices driven by this program, during its lifetime: the constructor blocks until the motors rest, at most
/// 0.25 s; after the last object's end the force returns by the ramp. For a program's own signal handlers: async-signal-safe.
class MotorsAtRest {
 public:
  MotorsAtRest() noexcept;
  ~MotorsAtRest();
  MotorsAtRest(const MotorsAtRest&) = delete;
  MotorsAtRest& operator=(const MotorsAtRest&) = delete;

 private:
  bool is_counted_ = false;  // false in a forked process, which has no devices
};

/// Requests real-time scheduling of the calling thread: FIFO at a high priority, locked memory, precise timers. Each refusal is
/// a sentence with its remedy. The destructor restores the thread.
class RealTimeThread {
 public:
  RealTimeThread();
  ~RealTimeThread();
  RealTimeThread(const RealTimeThread&) = delete;
  RealTimeThread& operator=(const RealTimeThread&) = delete;
  const std::vector<std::string>& refused() const noexcept { return refused_; }

 private:
  std::vector<std::string> refused_;
  int policy_ = 0;
  int priority_ = 0;
  bool has_priority_ = false;
  bool has_memory_ = false;
};

}  // namespace palpa
