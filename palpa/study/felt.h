// Artefacts in a run's force: steps that the hand's motion does not explain, their causes, and their steepness.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/scene/scene.h"
#include "palpa/trace/trace.h"

namespace palpa {

/// Data of a tick relevant to its feel.
struct FeltTick {
  double t_s = 0.0;
  double dt_s = 0.0;
  Vec3 probe_m;
  Vec3 proxy_m;
  Vec3 command_n;              ///< force at the hand: after the guard
  Vec3 force_n;                ///< force of the coupling: before the guard, and before the break-through filter
  Vec3 torque_nm;              ///< likewise torque, of a tool
  bool usable = false;         ///< the device had a valid position
  bool limited = false;        ///< the guard limited the force
  bool onset = false;          ///< contact with a level began
  bool broke_through = false;  ///< a level was broken through
  double broke_force_n = 0.0;  ///< largest spring force at a break-through
  bool other_event = false;    ///< another event of this tick, recorded in the trace, explains it
};

/// Tick without its events, live or from a recording, where values of an invalid probe need not be finite.
FeltTick felt_tick(const TickFrame& frame) noexcept;

struct FeltMode {
  std::string name;
  bool is_directed = false;   ///< its primitives are directed forces, with strengths from the data
  std::vector<Vec3> force_n;  ///< on the proxy, by tick
};

struct FeltRun {
  double stiffness_n_per_m = 0.0;  ///< k of its coupling
  std::vector<FeltTick> ticks;
  std::vector<FeltMode> modes;
};

/// Whether modes of this type place directed forces.
bool places_directed_forces(std::string_view mode_type) noexcept;
/// Whether modes of this type drive an idle hand and may inject energy: those of directed forces, and vortex_line, whose line
/// is away from the proxy.
bool drives(std::string_view mode_type) noexcept;

/// Empty run of a scene.
FeltRun felt_run(const Scene& scene);
/// Appends the session's last tick.
void add_tick(FeltRun& run, const TickFrame& frame, const Session& session);

/// The commands, and the probes times k, the force of a spring without data for this hand. Both in intervals without gaps.
struct FeltSignals {
  std::vector<std::vector<Vec3>> command_n;
  std::vector<std::vector<Vec3>> spring_n;  ///< k · probe
};
/// Signals of all intervals with a valid probe, between `from_s` and `to_s` [s].
FeltSignals signals_of(const FeltRun& run, double from_s, double to_s);
/// Likewise, but only of ticks in contact, and none within `after_break_through_s` after an event: a hand in motion in
/// established contact.
FeltSignals quiet_signals_of(const FeltRun& run, double from_s, double to_s);

/// Ends of a scene's data: the faces of their box, and holes.
class EdgesOfData {
 public:
  /// Stores the scene's fields, at the first moment of its data.
  explicit EdgesOfData(const Scene& scene);
  /// Whether a field has data within a sample spacing of a hand position [m], and none in another direction.
  bool is_near(const Vec3& hand_m) const noexcept;
  /// Whether every field has data at a hand position [m].
  bool has_data(const Vec3& hand_m) const noexcept;

 private:
  Similarity hand_to_world_;
  std::vector<FieldPtr> fields_;
};

/// Cause of a step of the force.
enum class StepCause : std::uint8_t {
  break_through,  ///< break-through of a level, at most `after_break_through_s` earlier
  onset,          ///< contact with a level began
  other_event,    ///< explained by another event, at most as much earlier
  edge,           ///< data end here
  directed,       ///< a directed force changed
  release,        ///< a mode released or began contact, without an event
  strength,       ///< a mode's force grew or shrank: its strength varies with position
  turn,           ///< a mode's force rotated: the surface under the proxy has an edge
  unknown,
};
inline constexpr StepCause step_causes[] = {StepCause::break_through, StepCause::onset,    StepCause::other_event,
                                            StepCause::edge,          StepCause::directed, StepCause::release,
                                            StepCause::strength,      StepCause::turn,     StepCause::unknown};
const char* name_of(StepCause cause) noexcept;
/// Whether a session's event explains a step of this cause.
bool has_event(StepCause cause) noexcept;

/// Step of the command larger than the spring's response to the hand's motion.
struct ExcessStep {
  std::size_t tick = 0;  ///< index in the run
  double t_s = 0.0;
  double step_n = 0.0;    ///< |Δcommand|
  double excess_n = 0.0;  ///< |Δcommand| − k |Δprobe|
  StepCause cause = StepCause::unknown;
  int mode = -1;  ///< number of the mode of the largest change of force; -1: none explains the step
};

/// Threshold [N] of a step felt by itself: fingers resolve some 30 mN of a small force. Less: unfelt steps are listed; more:
/// felt ones are not.
inline constexpr double felt_step_n = 0.05;
/// Longest fall [s] after a break-through (the limit of `BreakThroughFilter`); steps in it have that cause. Longer: other steps
/// are explained away; shorter: the end of a fall has no cause.
inline constexpr double after_break_through_s = 0.02;

/// Steps with an excess above `above_n` [N], in order; none across ticks without a valid probe.
/// \param edges  of the scene's data; nullptr: unknown, no step has that cause
std::vector<ExcessStep> excess_steps(const FeltRun& run, const EdgesOfData* edges, double above_n = felt_step_n);

/// Steepest change of the command [N/ms] from a break-through to the end of its fall; 0 without a break-through.
double steepest_fall_n_per_ms(const FeltRun& run) noexcept;
/// Steepest change of the command [N/ms] near an edge of data without a level as cause.
double steepest_at_edges_n_per_ms(const FeltRun& run, const EdgesOfData& edges) noexcept;
/// Share [1] of ticks with a limited force.
double saturated_share(const FeltRun& run) noexcept;
double duration_s(const FeltRun& run) noexcept;

}  // namespace palpa
