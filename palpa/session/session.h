// A session: a scene being felt. Its tick is the main path of Palpa.
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

/// The hand's point as the device reports it.
struct Probe {
  Vec3 position_m;
  std::optional<Vec3> velocity_m_per_s{};  ///< none: taken from the positions
  bool valid = true;                       ///< false: the device does not know where it is
  std::uint32_t buttons = 0;
};

enum class TickStatus : std::uint8_t {
  resting,    ///< the proxy is where this probe position leads
  waiting,    ///< the work of a tick is spent; the rest of the probe's path waits for the next one, and does not pull
  capped,     ///< resting, but a balance's bound is above `exact_bound_m`
  bad_input,  ///< the probe or the time step could not be used; the proxy stayed, the force is zero
};

/// One tick's answer. `force_n` is Eq. 1 without what waits, before any limit: what reaches a hand is the guard's business.
struct Tick {
  Vec3 probe_m;
  Vec3 probe_velocity_m_per_s;
  Vec3 probe_step_m;  ///< the way since the last tick, under the force of which; zero where the proxy was put on the probe
  bool probe_valid = true;
  Vec3 proxy_m;
  Vec3 proxy_velocity_m_per_s;
  Vec3 force_n;
  double given_back_n = 0.0;   ///< of the force: what was withheld while ticks waited and has come back in this one
  double error_bound_m = 0.0;  ///< worst of the sub-steps
  int sub_steps = 0;
  int iterations = 0;  ///< of all sub-steps
  TickStatus status = TickStatus::resting;
  int dropped = 0;  ///< primitives refused
  /// [N] of the spring's pull at the proxy that the primitives of its last balance do not bear there: stiffness times the way
  /// that is left to that balance. At rest less than is felt; more: the proxy was given up on its way. 0 in a tick that waits.
  double unborne_n = 0.0;
  Energy energy;  ///< work_on_hand_j and held_back_j are filled in by the loop, which knows the command
  int work = 0;   ///< [1] units that it took, counted alike on every machine (docs/contracts/session.md)
};

/// A mode's part in one tick.
struct ModeForce {
  Vec3 force_n;  ///< sum over its primitives in the last sub-step, in the least split of force
  double dissipated_j = 0.0;
  double injected_j = 0.0;
  int primitives = 0;         ///< in the last sub-step
  bool split_shared = false;  ///< redundant with other primitives: another split would balance too
};

enum class SessionEventKind : std::uint8_t { onset, break_through, fault, warning };

/// Something that happened in a tick. Texts are literals: no event allocates.
struct SessionEvent {
  SessionEventKind kind = SessionEventKind::warning;
  std::int32_t mode = -1;      ///< subject: the mode's number; -1: the session
  double value = 0.0;          ///< the level, of onset and break_through, in the field's own unit
  const char* text = nullptr;  ///< what is wrong, of fault and warning
  double depth_m = 0.0;        ///< [m] of break_through: |proxy − probe| where the strength was reached
};

/// A scene being felt: the proxy, the modes' memories, the ledger. It holds a snapshot of the scene
/// (voxels shared). Construction allocates and throws SceneError; `tick` does neither, takes no lock,
/// does no input or output, and answers with finite numbers whatever it is given. One thread.
class Session {
 public:
  /// \param encoder_step_m  [m] position step of the device, 0 if none (see Damper)
  /// Balances by `scene.law`. Laws of earlier systems move the proxy in one step a tick, as those systems did.
  explicit Session(const Scene& scene, double encoder_step_m = 0.0);
  /// A session of the exact law that moves the proxy in one step a tick, for studies: what differs from `Session(scene)` comes
  /// from the path, not from the balance.
  static Session in_one_step(const Scene& scene);
  ~Session();
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;

  /// One update: the modes place primitives, the balance is solved, the proxy moves along its path, and
  /// the coupling pulls the hand (Eq. 1).
  /// \param probe        where the hand is now
  /// \param time_step_s  [s] since the last tick; (0, 1]
  Tick tick(const Probe& probe, double time_step_s) noexcept;

  /// Puts the proxy on the next probe position and forgets all memories: after a gap or a clutch.
  void reset() noexcept;

  /// Sets the most that guard and device let reach the hand [N], at first infinity: a level that is stronger never yields.
  void set_force_limit(double most_n) noexcept;

  /// Walks the path in sub-steps `times` [1] (1…16) as short as usual, and in at least that many per tick; the cap on
  /// sub-steps is so much higher. For studies of convergence: the paths agree as the steps shrink.
  /// Allocates.
  void refine_path(int times);
  /// Copies the state of another session of the same scene, `set_force_limit` included; the warm start is forgotten.
  /// Programming error (assert) if the scenes differ in number of modes or memories.
  void copy_state_from(const Session& other) noexcept;
  /// Goes on where a session of another scene is: with all of its state where its modes hold on to the same levels of the same
  /// data, as after a change of strengths or of the coupling, else with its proxy, its time, and fresh memories.
  void resume_in_changed_scene(const Session& other) noexcept;

  const Scene& scene() const noexcept;
  const Similarity& hand_to_world() const noexcept;
  /// Who pushed in the last tick; valid until the next. Modes in the scene's order. The first call after a
  /// tick works it out, in microseconds: ask after the command is sent, or not at all.
  std::span<const ModeForce> modes() const noexcept;
  /// Of the last tick; valid until the next.
  std::span<const SubStep> sub_steps() const noexcept;
  std::span<const PlacedPrimitive> placed() const noexcept;
  std::span<const SessionEvent> events() const noexcept;

  /// [1] Work after which a tick begins nothing more, times that of `refine_path`; what takes the last of it is finished.
  static const int most_work;
  /// [1] Cap per tick, times that of `refine_path`; the rest waits. More: longer worst tick; fewer: the proxy lags earlier.
  static constexpr int max_sub_steps = 32;

 private:
  class State;
  explicit Session(std::unique_ptr<State> state) noexcept;
  std::unique_ptr<State> state_;
};

}  // namespace palpa
