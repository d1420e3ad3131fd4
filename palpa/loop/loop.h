// The loop: read → tick → release, impact, guard → write, and a recorder that can never slow it.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "palpa/core/vec3.h"
#include "palpa/device/device.h"
#include "palpa/tick/session.h"
#include "palpa/trace/trace.h"

namespace palpa {

/// Lets a force through, shortens it to a limit (keeping its direction), or, for anything that is not
/// finite, lets nothing through and reports a fault. Allocates nothing.
class Guard {
 public:
  /// \param max_force_n  [N] >= 0: the smaller of the scene's and the device's limit; a limit that is
  ///                     no such number lets nothing through
  explicit Guard(double max_force_n) noexcept : max_force_n_(max_force_n >= 0.0 ? max_force_n : 0.0) {}

  struct Passed {
    Vec3 command_n;  ///< never longer than the limit, rounding included
    GuardState state = GuardState::pass;
  };
  Passed pass(const Vec3& force_n) noexcept;

 private:
  double max_force_n_;
};

/// A level that lets go leaves a hand that pressed with newtons without any force from one tick to the next; a motor that does
/// that is heard and felt as a knock, and throws the hand. So for 20 ms what is sent goes after the command, straight towards
/// it, by 0.5 N/ms: that is the whole change of a tick, with what the spring does in the same time, as where drags hold the
/// proxy when a level has let go. What it has to go takes no less than 5 ms, so a small step is slower, and it has arrived when
/// the 20 ms are over, so a step above 10 N is faster. As much as the spring makes of the hand's own motion is never delayed: a
/// hand that draws back at once is not pushed after.
///
/// The proxy also lets go where a surface folds away below it, a strength is gone within less than the spring needs, or a
/// direction turns faster than it can follow: it snaps, further than the probe went. A step of more than 50 mN beyond the
/// hand's own, which fingers tell, then takes the whole 20 ms, so that none is left of a step of up to a newton; and so does
/// what steps while that is under way, whatever it is.
///
/// Since as much as k times the hand's way is never delayed, all that it gives to the hand is less than what the spring let go:
/// ∫ (F − k s) ds ≤ F²/2k.
///
/// What is sent lies between what was sent last and the command, so it is never longer than the longer of the two. It
/// does work on the hand like any other force: the loop books it with what the guard does to the force.
/// Allocates nothing; one thread.
class Release {
 public:
  /// What is to be sent in this tick.
  /// \param command_n    [N] what would be sent without
  /// \param is_released  a level has been pressed through in this tick
  /// \param by_hand_n    [N] >= 0: k times the probe's step
  /// \param time_step_s  [s] > 0
  /// \param has_let_go   the spring has let go of something in this tick
  Vec3 shape(const Vec3& command_n, bool is_released, double by_hand_n, double time_step_s, bool has_let_go = false) noexcept;
  /// The step [N] of a snap that was told in this tick; 0: none.
  double snap_n() const noexcept { return snap_n_; }
  /// Nothing falls any more: the next command is sent as it is.
  void reset() noexcept { *this = {}; }

 private:
  Vec3 sent_n_;              // last
  double left_s_ = 0.0;      // of the 20 ms
  double furthest_n_ = 0.0;  // that it was from the command
  bool is_snap_ = false;     // no level has been pressed through
  double snap_n_ = 0.0;
};

/// A spring alone feels like foam however stiff it is: what says "hard" is the knock as one hits it. So where a hard level is
/// met a pulse is added to the command, along the level's normal, open-loop: it grows with the speed of the impact and then
/// does not ask what the hand does (event-based feedback: Kuchenbecker, Fiene and Niemeyer, Improving contact realism through
/// event-based haptic feedback, IEEE TVCG 12(2), 2006). With v the speed along the normal and g the gain it is
///     g v (e^(−t/τ) − e^(−T/τ)) / (1 − e^(−T/τ)),  τ = 4 ms,  T = 20 ms, then it is over,
/// and never higher than the level is strong. Hard is what is rigid, and an elastic level that is stiffer than the coupling.
/// A free hand of mass m is given no energy by it as long as g is at most 2m over the pulse's 3.9 ms (docs/concepts.md).
///
/// It does work on the hand like any other force: the loop books it with what the guard does to the force.
/// Allocates nothing; one thread.
class Impact {
 public:
  /// \param gain_ns_per_m  [N·s/m] >= 0; 0: there are no pulses, and nothing is done to a command
  explicit Impact(double gain_ns_per_m) noexcept : gain_ns_per_m_(gain_ns_per_m) {}

  /// What is to be sent in this tick. The guard comes after it.
  /// \param command_n     [N] what would be sent without
  /// \param session       just after the tick
  /// \param probe_step_m  [m] the way of the probe since the last tick
  /// \param time_step_s   [s] > 0
  Vec3 shape(const Vec3& command_n, const Session& session, const Vec3& probe_step_m, double time_step_s) noexcept;
  /// Forgets the pulse and how fast the hand was.
  void reset() noexcept { *this = Impact(gain_ns_per_m_); }

 private:
  struct Step {
    Vec3 way_m;
    double time_s = 0.0;
  };
  Vec3 velocity_m_per_s() const noexcept;
  void hit(const PlacedPrimitive& level) noexcept;

  double gain_ns_per_m_;
  Vec3 height_n_;                 // of the pulse, where it began
  double left_s_ = 0.0;           // of it
  std::array<Step, 16> steps_{};  // the last ones of the probe, in a ring
  std::size_t newest_ = 0;
};

/// Takes whole ticks from the loop through a bounded ring and has its own thread format and write
/// them. What it took is in the operating system's hands at the latest 10 ms and 100 ticks later.
class Recorder {
 public:
  /// \param writer      stays, and is left alone, until `finish` returned
  /// \param ring_bytes  memory of the ring, taken at construction
  explicit Recorder(TraceWriter& writer, std::size_t ring_bytes = std::size_t{16} << 20);
  /// Writes what is left; says nothing of a full disk.
  ~Recorder();
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Puts one whole tick, with what the session has to say of it, into the ring. Never blocks,
  /// allocates or throws: false when there is no room, or nobody to make it (the disk is full).
  bool offer(const TickFrame& frame, const Session& session) noexcept;
  /// The same from the parts of a tick.
  bool offer(const TickFrame& frame, std::span<const ModeTick> modes, std::span<const SubStep> sub_steps,
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

/// The most that reaches a hand [N]: the smaller of the scene's limit and the device's [N].
double let_through_n(const Scene& scene, double device_max_force_n) noexcept;

/// One turn of the loop without its device: tick → guard → release → impact. Both a live loop and a replay go through it,
/// so that the same probes give the same frames. Allocates nothing after construction; one thread.
class GuardedSession {
 public:
  /// Tells the session what it lets through.
  /// \param device_max_force_n  [N] the device's limit; the scene's holds as well
  GuardedSession(Session& session, double device_max_force_n) noexcept;

  /// A tick and what becomes of it; `command_n` is what is to be sent to the device: zero where the
  /// probe cannot be used. The frame's probe is what was given, finite or not, so that the frame's own
  /// probe, velocity, validity, buttons and time step give the same frame again. `late_us`, `tick_us`
  /// and `device_us` stay 0.
  TickFrame tick(std::int64_t number, double t_s, double dt_s, const Probe& probe) noexcept;

 private:
  Session& session_;
  Guard guard_;
  Release release_;
  Impact impact_;
  Vec3 held_force_n_;
  Vec3 held_command_n_;
};

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

}  // namespace palpa
