// Session: a scene being felt. Its tick is the main path of Palpa.
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

/// The hand's point as reported by the device.
struct Probe {
  Vec3 position_m;
  std::optional<Vec3> velocity_m_per_s{};  ///< none: derived from the positions
  bool valid = true;                       ///< false: the device has no position
  std::uint32_t buttons = 0;
};

enum class TickStatus : std::uint8_t {
  resting,    ///< converged: the proxy rests where this probe position leads
  waiting,    ///< work budget exhausted: rest of the probe's path queued, no force from it
  capped,     ///< resting, but a balance's bound is above `exact_bound_m`
  bad_input,  ///< unusable probe or time step; the proxy stayed, the force is zero
};

/// Result of one tick. `force_n` is Eq. 1 for the processed part of the probe's path, before limits (see Guard).
struct Tick {
  Vec3 probe_m;
  Vec3 probe_velocity_m_per_s;
  Vec3 probe_step_m;  ///< since the last tick, under its force; zero where the proxy was put on the probe
  bool probe_valid = true;
  Vec3 proxy_m;
  Vec3 proxy_velocity_m_per_s;
  Vec3 force_n;
  double given_back_n = 0.0;   ///< part of the force that was withheld in incomplete ticks and returned in this one
  double error_bound_m = 0.0;  ///< largest of the sub-steps
  int sub_steps = 0;
  int iterations = 0;  ///< of all sub-steps
  TickStatus status = TickStatus::resting;
  int dropped = 0;  ///< primitives refused
  /// [N] part of the spring's pull that the primitives do not bear: stiffness times the distance of the proxy from its last
  /// balance. Imperceptible at rest; more: the proxy was given up on its path. 0 in an incomplete tick.
  double unborne_n = 0.0;
  Energy energy;  ///< the loop fills in work_on_hand_j and held_back_j
  int work = 0;   ///< [1] units, counted alike on every machine (docs/contracts/session.md)
};

/// A mode's part in one tick.
struct ModeForce {
  Vec3 force_n;  ///< sum over its primitives in the last sub-step, in the least split of force
  double dissipated_j = 0.0;
  double injected_j = 0.0;
  int primitives = 0;         ///< in the last sub-step
  bool split_shared = false;  ///< redundant: another split would balance too
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

/// A scene being felt: the proxy, the modes' memories, the ledger. Holds a snapshot of the scene (voxels shared). Construction
/// allocates and throws SceneError; `tick` does neither, takes no lock, does no input or output, and returns finite numbers for
/// any arguments. One thread.
class Session {
 public:
  /// Balances by `scene.law`. Laws of earlier systems move the proxy in one step a tick, as these systems did.
  /// \param encoder_step_m  [m] position step of the device, 0 if none (see Damper)
  explicit Session(const Scene& scene, double encoder_step_m = 0.0);
  /// Balances by `law`, along the path of the exact law, not by the law that the scene names.
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

  /// Sets the force limit of guard and device [N], infinity by default: a stronger level never yields.
  void set_force_limit(double most_n) noexcept;

  /// Walks the path in sub-steps `times` [1] (1…16) as short as usual, at least as many per tick; multiplies the cap on
  /// sub-steps. For studies of convergence. Allocates.
  void refine_path(int times);
  /// Copies the state of a session of an equal scene, including the force limit; clears the warm start. Programming error
  /// (assert) if the scenes differ in number of modes or memories.
  void copy_state_from(const Session& other) noexcept;
  /// Continues from a session of another scene: with all of its state if its modes use equal levels of equal data, as after a
  /// change of strengths or of the coupling, else with its proxy, its time, and fresh memories.
  void resume_in_changed_scene(const Session& other) noexcept;

  const Scene& scene() const noexcept;
  const Similarity& hand_to_world() const noexcept;
  /// Forces by mode in the last tick, in the scene's order; valid until the next. The first call after a tick computes them, in
  /// microseconds: call it after the command is sent, or not at all.
  std::span<const ModeForce> modes() const noexcept;
  /// Of the last tick; valid until the next.
  std::span<const SubStep> sub_steps() const noexcept;
  std::span<const PlacedPrimitive> placed() const noexcept;
  std::span<const SessionEvent> events() const noexcept;

  /// [1] Work budget of a tick, times that of `refine_path`; the item that exhausts it is finished.
  static const int most_work;
  /// [1] Cap per tick, times that of `refine_path`; the rest is queued. More: longer worst tick; fewer: the proxy lags earlier.
  static constexpr int max_sub_steps = 32;

 private:
  class State;
  explicit Session(std::unique_ptr<State> state) noexcept;
  std::unique_ptr<State> state_;
};

}  // namespace palpa
