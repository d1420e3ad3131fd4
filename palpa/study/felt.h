// What is felt in a run besides the data: steps of the force that the hand's motion does not explain, their causes, and how
// steep they are.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/scene/scene.h"
#include "palpa/trace/trace.h"

namespace palpa {

/// What of a tick matters for what is felt.
struct FeltTick {
  double t_s = 0.0;
  double dt_s = 0.0;
  Vec3 probe_m;
  Vec3 proxy_m;
  Vec3 command_n;              ///< what reached the hand: after the guard
  Vec3 force_n;                ///< what the coupling asked for: before the guard, and before what a level leaves behind falls
  bool usable = false;         ///< the device knew where it is
  bool limited = false;        ///< the guard held some of the force back
  bool onset = false;          ///< a level was met
  bool broke_through = false;  ///< a level was broken through
  double broke_force_n = 0.0;  ///< the largest force of the spring at which a level was broken through
  bool told = false;           ///< another event was recorded in this tick, which explains it to the reader
};

/// A tick without its events, live or from a recording, where values of a probe that was not usable need not be finite.
FeltTick felt_tick(const TickFrame& frame) noexcept;

/// A mode of a run.
struct FeltMode {
  std::string name;
  bool is_directed = false;   ///< its primitives are directed forces, which are as strong as the data say
  std::vector<Vec3> force_n;  ///< on the proxy, tick by tick
};

/// A run, tick by tick.
struct FeltRun {
  double stiffness_n_per_m = 0.0;  ///< k of its coupling
  std::vector<FeltTick> ticks;
  std::vector<FeltMode> modes;
};

/// Whether modes of this type place directed forces.
bool places_directed_forces(std::string_view mode_type) noexcept;
/// Whether modes of this type drive an idle hand and may bring energy in: those of directed forces, and vortex_line, whose line
/// lies away from the proxy.
bool drives(std::string_view mode_type) noexcept;

/// An empty run of a scene.
FeltRun felt_run(const Scene& scene);
/// One more tick: the session's last.
void add_tick(FeltRun& run, const TickFrame& frame, const Session& session);

/// The commands, and the probes times k, which is the force that a spring without data would make of the same hand. Both in
/// stretches without gaps.
struct FeltSignals {
  std::vector<std::vector<Vec3>> command_n;
  std::vector<std::vector<Vec3>> spring_n;  ///< k · probe
};
/// The signals of all stretches in which the probe was usable, between `from_s` and `to_s` [s].
FeltSignals signals_of(const FeltRun& run, double from_s, double to_s);
/// The same, but only of ticks in contact, and none within `after_break_through_s` after an event: a hand that moves on
/// something that it has met before.
FeltSignals quiet_signals_of(const FeltRun& run, double from_s, double to_s);

/// Where the data of a scene end: at the faces of their box, and at holes in them.
class EdgesOfData {
 public:
  /// Keeps the fields of the scene, as they are at the moment its data begin.
  explicit EdgesOfData(const Scene& scene);
  /// Whether some field has data within one sample spacing of a place of the hand [m], and none in another direction.
  bool is_near(const Vec3& hand_m) const noexcept;
  /// Whether every field has data at a place of the hand [m].
  bool has_data(const Vec3& hand_m) const noexcept;

 private:
  Similarity hand_to_world_;
  std::vector<FieldPtr> fields_;
};

/// Why the force stepped.
enum class StepCause : std::uint8_t {
  break_through,  ///< a level gave way, at most `after_break_through_s` earlier
  onset,          ///< a level was met
  told,           ///< another event says why, at most as much earlier
  edge,           ///< data end here
  directed,       ///< a directed force changed
  release,        ///< a mode let go or began to hold, and no event says so
  strength,       ///< a mode's force became larger or smaller: its strength changes with the place
  turn,           ///< a mode's force turned: the surface under the proxy has an edge
  unknown,
};
inline constexpr StepCause step_causes[] = {StepCause::break_through, StepCause::onset,    StepCause::told,
                                            StepCause::edge,          StepCause::directed, StepCause::release,
                                            StepCause::strength,      StepCause::turn,     StepCause::unknown};
const char* name_of(StepCause cause) noexcept;
/// Whether an event of the session explains a step with this cause.
bool is_told(StepCause cause) noexcept;

/// A step of the command that is larger than the spring makes of the hand's motion.
struct ExcessStep {
  std::size_t tick = 0;  ///< index in the run
  double t_s = 0.0;
  double step_n = 0.0;    ///< |Δcommand|
  double excess_n = 0.0;  ///< |Δcommand| − k |Δprobe|
  StepCause cause = StepCause::unknown;
  int mode = -1;  ///< number of the mode whose force changed most; -1: none explains the step
};

/// A step beyond this [N] is felt as a tick of its own: fingers tell apart some 30 mN of a small force. Less: steps that nobody
/// feels are listed; more: felt ones are not.
inline constexpr double felt_step_n = 0.05;
/// A fall lasts at most this long [s] after its break-through (`BreakThroughFilter`, whose limit this repeats); steps in it
/// have that as their cause. Longer: other steps are explained away; shorter: the end of a fall has no cause.
inline constexpr double after_break_through_s = 0.02;

/// The steps whose excess is above `above_n` [N], in order. Between ticks where the probe was not usable there is none.
/// \param edges  of the scene's data; nullptr: not known, and no step has that cause
std::vector<ExcessStep> excess_steps(const FeltRun& run, const EdgesOfData* edges, double above_n = felt_step_n);

/// The steepest change of the command [N/ms] from a break-through on until its fall is over; 0 where nothing broke.
double steepest_fall_n_per_ms(const FeltRun& run) noexcept;
/// The steepest change of the command [N/ms] near an edge of data that no level explains.
double steepest_at_edges_n_per_ms(const FeltRun& run, const EdgesOfData& edges) noexcept;
/// The share [1] of ticks in which the guard held some of the force back.
double saturated_share(const FeltRun& run) noexcept;
/// The duration [s] of all ticks.
double duration_s(const FeltRun& run) noexcept;

}  // namespace palpa
