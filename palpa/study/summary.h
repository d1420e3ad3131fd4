// Summary of a run.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "palpa/loop/loop.h"
#include "palpa/loop/time_histogram.h"
#include "palpa/session/session.h"
#include "palpa/study/felt_octaves.h"
#include "palpa/trace/trace.h"

namespace palpa {

/// Numbers of a mode over a run.
struct ModeSummary {
  std::string name;
  std::string type;
  double contact_share = 0.0;  ///< [1] share of ticks with force above 1 mN
  double force_mean_n = 0.0;   ///< on the proxy, over ticks in contact
  double force_max_n = 0.0;
  double dissipated_j = 0.0;
  double injected_j = 0.0;
  std::int64_t onsets = 0;
  std::int64_t break_throughs = 0;
};

struct Summary {
  std::int64_t ticks = 0;
  double duration_s = 0.0;  ///< simulated
  double wall_s = 0.0;
  double ticks_per_s = 0.0;  ///< in real time
  double tick_p50_us = 0.0, tick_p99_us = 0.0, tick_max_us = 0.0;
  double contact_share = 0.0;  ///< [1] any mode
  std::vector<ModeSummary> modes;
  double force_mean_n = 0.0, force_max_n = 0.0;  ///< on the hand: of the command, mean over ticks in contact
  double asked_force_max_n = 0.0;                ///< of the force before the guard
  double sub_steps_mean = 0.0;                   ///< [sub-steps per tick]
  int sub_steps_max = 0;
  std::int64_t waiting_ticks = 0, capped_ticks = 0, bad_input_ticks = 0, invalid_probe_ticks = 0;
  std::int64_t unborne_ticks = 0;  ///< with more than `unborne_felt_n` not borne by any strength (Tick::unborne_n)
  double unborne_max_n = 0.0;
  double unborne_lasting_n = 0.0;  ///< largest in ticks that follow 20 ms with more than `unborne_felt_n`: a catch
  double error_bound_max_m = 0.0;
  Energy energy;                                  ///< sums over the run; stored_j: at the end
  double work_on_hand_j = 0.0, withheld_j = 0.0;  ///< sums of the commands
  double unfelt_j = 0.0;                          ///< sum of the commands
  double sampling_gained_j = 0.0;                 ///< Energy::sampling_j of the ticks that injected energy
  double gaining_m2_per_s = 0.0;        ///< Σ|Δp|²/dt over these ticks: a damping dissipates at least this times itself
  double first_break_through_s = -1.0;  ///< -1: none
  std::int64_t dropped_primitives = 0;
  std::int64_t guard_limited_ticks = 0, faults = 0;
  std::optional<FeltOctaves> octaves;  ///< of volumes larger than memory
  std::optional<LoopStatistics> loop;  ///< of a live run: timing of its loop
  std::vector<std::string> notes;      ///< sentences for the reader: placement of the hand, reasons for no contact
};

/// Force of contact [N] (docs/trace.md, modes.csv). Less: rounding counts; more: light touches do not.
inline constexpr double contact_force_n = 1e-3;

/// Force [N] not borne by any strength that counts as a fault of the path (Tick::unborne_n). Less: forces below the fingers'
/// threshold count; more: an unsupported proxy is not reported.
inline constexpr double unborne_felt_n = 0.05;

/// Accumulates a summary by tick, in constant memory. `add` allocates nothing.
class SummaryBuilder {
 public:
  explicit SummaryBuilder(const Scene& scene);
  /// For modes known by name and type only, as of a trace with missing data.
  /// \param octave_spacing_m  [m] of `spacing_of_octaves_m`
  explicit SummaryBuilder(std::vector<ModeSummary> modes, double octave_spacing_m = 0.0);
  /// Adds a tick; `modes` in the scene's order.
  void add(const TickFrame& frame, std::span<const ModeForce> modes, std::span<const SessionEvent> events) noexcept;
  /// Adds the session's last tick.
  void add(const TickFrame& frame, const Session& session) noexcept { add(frame, session.modes(), session.events()); }
  /// \param wall_s  [s] real duration of the run
  Summary finish(double wall_s) const;

 private:
  Summary summary_;
  TimeHistogram tick_times_;
  FeltOctavesBuilder octaves_;
  double force_sum_n_ = 0.0;
  double unborne_s_ = 0.0;  // with more than `unborne_felt_n` up to now
  std::int64_t contact_ticks_ = 0;
  std::int64_t sub_steps_ = 0;
  std::vector<double> mode_force_sum_n_;
  std::vector<std::int64_t> mode_contact_ticks_;
  std::optional<Vec3> last_probe_m_;  ///< none: unknown, or invalid
};

std::string to_table(const Summary& summary);
/// Formats the summary as JSON; names carry their unit.
std::string to_json(const Summary& summary);

}  // namespace palpa
