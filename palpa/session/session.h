// Session: state of a scene in use. Its `tick` computes the force.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "palpa/scene/scene.h"
#include "palpa/solver/coupling.h"
#include "palpa/solver/law.h"

namespace palpa {

class Octaves;

/// The hand's point as reported by the device.
struct Probe {
  Vec3 position_m;
  std::optional<Vec3> velocity_m_per_s{};  ///< none: derived from the positions
  bool valid = true;                       ///< false: the device has no position
  std::uint32_t buttons = 0;
  Turn turn{};  ///< orientation of the handle, a unit quaternion to within 1e-3; unused by a point tool
};

enum class TickStatus : std::uint8_t {
  complete,   ///< converged: the proxy is at the balance for this probe position
  waiting,    ///< work budget exhausted: rest of the probe's path queued, no force from it
  capped,     ///< complete, but a balance's error bound is above `exact_bound_m`
  bad_input,  ///< unusable probe or time step; the proxy stayed, the force is zero
};

/// Result of one tick. `force_n` is the coupling force (Eq. 1) for the processed part of the probe's path, before the guard.
struct Tick {
  Vec3 probe_m;                 ///< as given, finite or not
  Vec3 probe_velocity_m_per_s;  ///< likewise, or of the last step
  Vec3 probe_step_m;            ///< since the last tick, while its force acted; zero after a reset of the proxy to the probe
  bool probe_valid = true;
  Vec3 proxy_m;
  Vec3 proxy_velocity_m_per_s;
  Vec3 force_n;
  double given_back_n = 0.0;   ///< part of the force that was withheld in incomplete ticks and returned in this one
  double error_bound_m = 0.0;  ///< largest of the sub-steps
  int sub_steps = 0;
  int iterations = 0;  ///< of all sub-steps
  TickStatus status = TickStatus::complete;
  int dropped = 0;  ///< primitives refused
  /// [N] part of the spring force that the primitives do not balance: stiffness times the distance of the proxy from its last
  /// balance. Imperceptible at rest; larger where the path stopped before the balance. 0 in a `waiting` tick, and where the
  /// proxy is held back while octaves fade.
  double unborne_n = 0.0;
  Energy energy;
  int work = 0;                ///< [1] units, counted alike on every machine (docs/contracts/session.md)
  double felt_octave = 0.0;    ///< [1] of volumes larger than memory, 0 the finest
  bool forced_octave = false;  ///< it was raised at once: the windows would not have held the way of this tick
  // Of a tool with an orientation; else no rotation and zero:
  Turn probe_turn;  ///< as given, finite or not: a replay of it gives equal bits
  Turn proxy_turn;
  Vec3 probe_turn_step_rad;  ///< rotation vector of the probe since the last tick
  Vec3 torque_nm;            ///< about the device's point, before the guard
};

/// A mode's part in one tick.
struct ModeForce {
  Vec3 force_n;  ///< sum over its primitives in the last sub-step; if redundant, the split with the least Σ|force|²/strength
  double dissipated_j = 0.0;
  double injected_j = 0.0;
  int primitives = 0;         ///< in the last sub-step
  bool split_shared = false;  ///< redundant primitives: another split would balance too
};

enum class SessionEventKind : std::uint8_t { onset, break_through, fault, warning };

/// Event of a tick. Texts are literals: no event allocates.
struct SessionEvent {
  SessionEventKind kind = SessionEventKind::warning;
  std::int32_t mode = -1;      ///< mode's number; -1: the session
  double value = 0.0;          ///< of onset and break_through: the level, in the field's own unit
  const char* text = nullptr;  ///< of fault and warning: the cause
  double depth_m = 0.0;        ///< [m] of break_through: |proxy − probe| where the strength was reached
};

/// Place of a window. Trivially copyable.
struct WindowPlace {
  const Octaves* of = nullptr;  ///< nullptr: no window
  int octave = 0;
  std::array<std::int64_t, 3> first{};  ///< [voxels] of the octave as it is sampled, multiples of 8
  std::array<std::int64_t, 3> dims{};   ///< [voxels] along i, j, k
};

/// Places for which a tick needs windows of volumes larger than memory.
struct WindowNeed {
  std::span<const Vec3> feet_m;  ///< [m, world] of the proxy, or of the probe where the proxy begins on it
  /// [m, world] Likewise where the proxy flies to if all levels give way: at the probe. In the order of `feet_m`.
  std::span<const Vec3> ahead_m;
  double way_m = 0.0;       ///< [m, world] of a foot in the tick, as the probe moves
  Vec3 velocity_m_per_s{};  ///< [world] of the proxy, mean of the last 5 ms
  DataTime time;            ///< at which the data are posed: at the end of the tick
  DataTime from;            ///< up to which the proxy has followed the data: the tick samples those from there to `time`
};

/// A scene in use: its proxy, the modes' memories, the ledger. Holds a snapshot of the scene (voxels shared). Construction
/// allocates and throws SceneError; `tick` does neither, takes no lock, does no input or output, and returns finite numbers for
/// any arguments. One thread.
class Session {
 public:
  /// Balances by `scene.law()`. Laws of earlier systems move the proxy in one step a tick, as these systems did.
  /// \param encoder_step_m  [m] position step of the device, 0 if none (see Damper)
  explicit Session(const Scene& scene, double encoder_step_m = 0.0);
  /// Balances by `law` instead of the law that the scene names, along the path of the exact law.
  Session(const Scene& scene, std::unique_ptr<Law> law, double encoder_step_m = 0.0);
  /// Session of the exact law that moves the proxy in one step a tick: its differences from `Session(scene)` come from the
  /// path, not from the balance. For studies.
  static Session in_one_step(const Scene& scene);
  ~Session();
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;

  /// The modes place primitives, the balance is solved, the proxy moves along its path, and the coupling pulls the hand (Eq.
  /// 1).
  /// \param probe        current probe
  /// \param time_step_s  [s] since the last tick; (0, 1]
  Tick tick(const Probe& probe, double time_step_s) noexcept;

  /// Puts the proxy on the next probe position and resets all memories: after a gap or a clutch.
  void reset() noexcept;

  /// Sets the force limit of guard and device [N], infinity by default: a stronger level cannot be broken through.
  void set_force_limit(double most_n) noexcept;

  /// Windows of volumes larger than memory, to be laid between ticks. Empty for a scene without such volumes.
  Stock& stock() noexcept;
  const Stock& stock() const noexcept;
  /// Need of the next tick, with these arguments; valid until then.
  WindowNeed window_need(const Probe& probe, double time_step_s) noexcept;

  /// Divides sub-steps by `times` [1] (1…16), at least `times` per tick; multiplies a tick's limits by it. For studies of
  /// convergence. Allocates.
  void refine_path(int times);
  /// Copies the state of a session of an equal scene, including the force limit; clears the warm start. Programming error
  /// (assert) if the scenes differ in number of modes or memories.
  void copy_state_from(const Session& other) noexcept;
  /// Continues from `other`, a session of another scene: with its whole state if both scenes' modes use equal levels of equal
  /// data, as after a change of strengths or coupling; else with its proxy and time, and fresh memories.
  void resume_in_changed_scene(const Session& other) noexcept;

  const Scene& scene() const noexcept;
  const Similarity& hand_to_world() const noexcept;
  /// Forces by mode in the last tick, in the scene's order; valid until the next. The first call after a tick computes them, in
  /// microseconds: call it after the command is sent, or not at all.
  std::span<const ModeForce> modes() const noexcept;
  /// Of the last tick; valid until the next.
  std::span<const SubStep> sub_steps() const noexcept;
  std::span<const PlacedPrimitive> primitives() const noexcept;
  std::span<const SessionEvent> events() const noexcept;

  /// [1] Work budget of a tick, multiplied by `refine_path`; the balance that exhausts it is completed.
  static const int most_work;
  /// [1] Limit per tick, multiplied by `refine_path`; the rest of the probe's path is queued. More: longer worst tick; fewer:
  /// the proxy lags earlier.
  static constexpr int max_sub_steps = 32;

 private:
  class State;
  explicit Session(std::unique_ptr<State> state) noexcept;
  std::unique_ptr<State> state_;
};

}  // namespace palpa
