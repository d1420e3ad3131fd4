// The loop: read → tick → release, impact, guard → write, on a simulated clock or live, and a recorder that can never slow it.
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
#include "palpa/session/session.h"
#include "palpa/solver/vec3.h"
#include "palpa/trace/trace.h"

namespace palpa {

/// Takes whole ticks from the loop through a bounded ring and has its own thread format and write
/// them. What it took is in the operating system's hands at the latest 10 ms and 100 ticks later.
class Recorder {
 public:
  /// \param writer      stays, and is left alone, until `finish` returned
  /// \param ring_bytes  memory of the ring, taken at construction, given by the system as it is used
  explicit Recorder(TraceWriter& writer, std::size_t ring_bytes = std::size_t{16} << 20);
  /// Writes what is left; says nothing of a full disk.
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Has the system give all memory of the ring now, not as it is used: a real-time loop must not wait for it.
  /// Before the first tick is offered.
  void make_resident() noexcept;
  /// Puts one whole tick, with what the session has to say of it, into the ring. Never blocks,
  /// allocates or throws: false when there is no room, or nobody to make it (the disk is full).
  bool offer(const TickFrame& frame, const Session& session) noexcept;
  /// The same from the parts of a tick.
  bool offer(const TickFrame& frame, std::span<const ModeForce> modes, std::span<const SubStep> sub_steps,
             std::span<const PlacedPrimitive> placed, std::span<const SessionEvent> events) noexcept;
  /// Has the writer begin at once, and blocks until at most `most_pending_ticks` that were taken are not
  /// yet in the operating system's hands. Not for a real-time loop. Throws what the writer threw.
  void keep_up(std::int64_t most_pending_ticks);
  /// Writes what is left, joins the thread. Throws what the writer threw.
  void finish();

 private:
  class Ring;
  std::unique_ptr<Ring> ring_;
};

/// What the guard is to hold to (docs/safety.md).
struct GuardOptions {
  double max_force_n = 3.3;  ///< no command is longer
  bool motors = true;        ///< a person holds a device; false: a simulated hand, for which the limit is all
  double continuous_force_n = std::numeric_limits<double>::infinity();    ///< that the motors bear for ever
  double thermal_s = 20.0;                                                ///< > 0: time constant of their warmth
  double slew_n_per_s = 1000.0;                                           ///< > 0: the most by which a command grows or turns
  double max_speed_m_per_s = 2.0;                                         ///< > 0: of the hand
  double ramp_s = 0.7;                                                    ///< > 0: from nothing to all of a force
  double max_damping_ns_per_m = std::numeric_limits<double>::infinity();  ///< of the device
  double device_damping_ns_per_m = 0.0;                                   ///< of the device's own mechanics
  std::uint32_t dead_man_buttons = 0;                                     ///< one of these has to be held; 0: none
};
/// Those of a device, and a scene's limit [N].
GuardOptions guard_options_for(const DeviceLimits& limits, double scene_max_force_n) noexcept;

/// The most that reaches a hand [N]: the smaller of the scene's limit and the device's [N].
double force_limit_n(const Scene& scene, double device_max_force_n) noexcept;

/// One turn of the loop without its device: tick → release → impact → guard. Both a live loop and a replay go through it,
/// so that the same probes give the same frames. Allocates nothing after construction; one thread.
class GuardedSession {
 public:
  /// Tells the session what it lets through. For a hand without motors: of the guard there is the limit.
  /// \param device_max_force_n  [N] the device's limit; the scene's holds as well
  GuardedSession(Session& session, double device_max_force_n);
  /// With all of the guard.
  /// \param options  whose `max_force_n` is the device's; the scene's holds as well
  GuardedSession(Session& session, const GuardOptions& options);
  ~GuardedSession();
  GuardedSession(const GuardedSession&) = delete;
  GuardedSession& operator=(const GuardedSession&) = delete;

  /// A tick and what becomes of it; `command_n` is what is to be sent to the device: zero where the
  /// probe cannot be used. The frame's probe is what was given, finite or not, so that the frame's own
  /// probe, velocity, validity, buttons, circumstances and time step give the same frame again. `late_us`, `tick_us`
  /// and `device_us` stay 0.
  /// \param circumstances  bits of Circumstance
  TickFrame tick(std::int64_t number, double t_s, double dt_s, const Probe& probe, std::uint32_t circumstances = 0) noexcept;
  /// From the next tick on another session is felt; it has to go on from where this one is (`Session::copy_state_from` or
  /// `resume_in_changed_scene`). In that tick both are asked, and the step from one's force to the other's is spread over the
  /// ramp's time. The old one is left alone after that tick.
  void switch_to(Session& next) noexcept;
  /// Whether the device should hold the hand by its brake.
  bool brakes() const noexcept;
  const Session& session() const noexcept;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// How a loop on a simulated clock runs.
struct LoopOptions {
  double rate_hz = 1000.0;   ///< > 0
  double duration_s = 10.0;  ///< ticks begin at n / rate_hz for all n with n / rate_hz below this; infinite: until `stop`
  bool time_ticks = true;    ///< measure each tick with the monotonic clock
};

/// Called after every tick, on the loop's thread; what a summary is gathered with.
using TickObserver = std::function<void(const TickFrame&, const Session&)>;

/// Runs `session` with `device` on a simulated clock: as fast as it can, the same bits every time.
/// Tick n begins at exactly n / rate_hz; the time step is 1 / rate_hz, in the first as well. With a
/// recorder it waits for the writer, so that nothing is lost, and a kill loses at most 100 ticks.
/// Returns the number of ticks. `stop` ends it after the tick under way (an interrupt). Throws what
/// the recorder's writer threw, and what `observer` throws.
std::int64_t run_simulated(Session& session, SimulatedDevice& device, const LoopOptions& options, Recorder* recorder,
                           const TickObserver& observer, const std::atomic<bool>* stop = nullptr);

// ---- live: with a person's hand, on the clock of the wall ----

/// The scene as a device bears it: neither stiffer nor more damped than its limits.
Scene clamped_to(Scene scene, const DeviceLimits& limits);

/// A scene that is being felt, and can be changed while it is. Any thread may ask and change; only a LiveLoop feels it, and
/// never waits for the others.
class LiveScene {
 public:
  /// \param limits  of the device that it is felt with, which holds for whatever it is changed to (`within`)
  /// Throws SceneError.
  explicit LiveScene(const Scene& scene, const DeviceLimits& limits = {});
  ~LiveScene();
  LiveScene(const LiveScene&) = delete;
  LiveScene& operator=(const LiveScene&) = delete;

  /// The scene as it was set last.
  Scene scene() const;
  /// Replaces it: a session of it is made here, on the caller's thread, and felt from the next tick on, going on from where the
  /// hand is. Of several that are set between two ticks the last is felt. Throws SceneError: nothing is changed then.
  void set(const Scene& scene);
  /// Sets what `edit` makes of the scene; of two threads that do so neither loses its change. Throws what `edit` throws.
  void change(const std::function<void(Scene&)>& edit);

 private:
  friend class LiveLoop;
  class State;
  std::unique_ptr<State> state_;
};

/// A clock that a loop runs by. `now_s` never goes back; neither throws.
class LoopClock {
 public:
  virtual ~LoopClock() = default;
  virtual double now_s() noexcept = 0;
  /// Returns at `time_s` or later; at once if that is over.
  virtual void wait_until_s(double time_s) noexcept = 0;
};

/// How a live loop runs, and what of the device it makes use of.
struct LiveOptions {
  double rate_hz = 1000.0;                                      ///< [100, 20000]
  double duration_s = std::numeric_limits<double>::infinity();  ///< > 0
  bool rehearse = true;              ///< a second session takes the expected probe before each tick, so that the tick is warm
  GuardOptions guard{};              ///< whose `max_force_n` is the device's; the scene's holds as well
  std::uint32_t clutch_buttons = 0;  ///< while one of these is held, the handle moves and the probe does not
  bool goes_on_at_border = false;    ///< a handle at the border of its workspace takes the probe further
};

/// What a loop counted, as it is shown while it runs.
struct LoopStatistics {
  struct Times {
    double mean_us = 0.0, p50_us = 0.0, p99_us = 0.0, p999_us = 0.0, max_us = 0.0;
  };
  struct ModeCost {
    std::string name;
    double mean_us = 0.0;  ///< of a tick: to place its primitives, measured in rehearsals
  };
  std::int64_t ticks = 0;
  std::int64_t missed = 0;      ///< ticks that were skipped because the loop came too late for them
  std::int64_t unrecorded = 0;  ///< ticks that the recorder had no room for
  std::int64_t scenes = 0;      ///< that took another's place
  Times late;                   ///< how late ticks began
  Times period;                 ///< from one tick's beginning to the next one's
  Times tick;                   ///< time of the processor in `GuardedSession::tick`
  std::vector<ModeCost> modes;
};

/// What a viewer sees of a tick.
struct LiveView {
  TickFrame frame;
  Mat3 turn = Mat3::identity();
  const char* device_fault = nullptr;  ///< a literal: what the device says is wrong with it
};

/// A loop in real time: one thread, absolute deadlines; in each tick read → tick → guard → write, then what is told of it, then
/// a rehearsal. Ticks that it comes too late for are skipped and counted, never bunched: the next one has the whole time step.
/// In its thread there is no allocation, no lock, and nothing is waited for but the clock.
class LiveLoop {
 public:
  /// \param recorder  or nullptr
  /// \param clock     nullptr: the monotonic one
  LiveLoop(LiveScene& scene, Device& device, const LiveOptions& options, Recorder* recorder = nullptr,
           LoopClock* clock = nullptr);
  ~LiveLoop();
  LiveLoop(const LiveLoop&) = delete;
  LiveLoop& operator=(const LiveLoop&) = delete;

  /// Runs on this thread until `stop` or the duration is over; the motors then have no force. `observer` may be empty; it must
  /// not do what a tick may not do.
  void run(const std::atomic<bool>& stop, const TickObserver& observer = {});

  // Any thread, while it runs.

  /// No force from the next tick on, until `resume`.
  void panic() noexcept;
  /// Lets it go on after a panic, with the gate and the ramp of a start.
  void resume() noexcept;
  /// While the view or the map moves nothing is felt; what is felt begins anew when it has come to rest.
  void hold_while_view_moves(bool moves) noexcept;
  LoopStatistics statistics() const;

  // One other thread, the viewer's.

  /// The hand's axes lie as these in the scene's hand frame: pushing right goes to the right of the screen.
  void set_view_rotation(const Mat3& rotation) noexcept;
  /// The latest tick.
  const LiveView& latest() noexcept;

 private:
  class State;
  std::unique_ptr<State> state_;
};

/// A device that this program drives, from construction to destruction: whatever stops the program and can be known of, has its
/// motors without force first (docs/safety.md). A LiveLoop has one while it runs; a program that writes to a device itself
/// makes one on the thread that does so.
///
/// While there is any, the signals that would end or stop the program, or that a fault of its own raises, have a handler of the
/// library's, which waits for the motors, at most 0.25 s, and then does what the system, or the fault's handler before, does.
/// What the program takes or ignores itself stays with the program, but for faults: its handlers make a `MotorsAtRest`. `exit`,
/// `quick_exit`, `abort` and `terminate` are known of, too; `_exit`, `exec`, SIGKILL, SIGSTOP and a driver's thread that fails
/// are not.
class DrivenDevice {
 public:
  /// \param device  stays. Throws std::runtime_error where the program drives 64 already.
  explicit DrivenDevice(Device& device);
  /// Waits until the motors have no force, at most 20 ms.
  ~DrivenDevice();
  DrivenDevice(const DrivenDevice&) = delete;
  DrivenDevice& operator=(const DrivenDevice&) = delete;

  /// Whether the program is being stopped: the next force that is written is zero, or falls to zero within a few writes. Before
  /// each write, on its thread; neither allocates nor waits.
  bool has_to_rest() noexcept;

 private:
  std::size_t place_ = 0;
};

/// All devices that this program drives have no force, from construction, which waits for it, at most 0.25 s, until none of
/// these is left: then it comes back by the ramp. For a program's own handlers of signals: it only does what a handler may.
class MotorsAtRest {
 public:
  MotorsAtRest() noexcept;
  ~MotorsAtRest();
  MotorsAtRest(const MotorsAtRest&) = delete;
  MotorsAtRest& operator=(const MotorsAtRest&) = delete;

 private:
  bool is_counted_ = false;  // a process that was forked has no devices
};

/// Asks the system for a thread that nothing holds up: first in, first out at a high priority, memory that stays, short timers.
/// What it does not give is said in a sentence each, with what would give it. Given back by the destructor. For the
/// thread that makes it.
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
