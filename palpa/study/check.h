// Check of a scene on a device: closed loops at its worst places, graded, with proposed changes.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "palpa/study/bounds.h"
#include "palpa/study/check_trial.h"
#include "palpa/study/expected_octaves.h"

namespace palpa {

/// Severity of a finding.
enum class Grade : std::uint8_t {
  fine,
  warn,  ///< felt, and not in the data
  stop,  ///< unsuitable for that device
};
const char* name_of(Grade grade) noexcept;

// Thresholds, with their reasons in docs/check.md; people differ, and these are of one finger, one arm, one day.

/// [m/s²] Root mean square of a device's own motion at the skin's threshold: 10 µm at 40 Hz, falling by 12 dB an octave up to
/// 250 Hz (Bolanowski et al. 1988), a constant acceleration. Lower: unfelt motion is reported; higher: felt motion is not.
inline constexpr double felt_acceleration_m_per_s2 = 0.45;
/// [m/s²] Tenfold, 20 dB above: clearly no data. Higher: devices buzz and kick; lower: scenes with a hardly felt hum are
/// refused.
inline constexpr double borne_acceleration_m_per_s2 = 10.0 * felt_acceleration_m_per_s2;
/// [N] In a tick: half of the guard's limit of growth in a millisecond, and the limit of a break-through. There is no threshold
/// of people for it. Higher: kicks pass; lower: break-throughs are refused.
inline constexpr double borne_jump_n = 0.55;
/// [J] Energy injected in a trial by a mode that should inject none: the budget of the guard's account.
inline constexpr double borne_energy_j = 5e-3;

/// Result of a test.
struct CheckFinding {
  std::string key;  ///< "let_go", "held", "jump", …: as in JSON
  Grade grade = Grade::fine;
  double measured = 0.0;   ///< [`unit`]
  double threshold = 0.0;  ///< [`unit`]
  std::string unit;
  std::string where;  ///< trial and place; empty: whole scene
  std::string words;  ///< a sentence
};

/// Proposed setting.
struct Change {
  std::string table, key;  ///< "coupling", "stiffness_n_per_m"
  double from = 0.0;       ///< in the key's own unit
  double to = 0.0;         ///< in the key's own unit
  std::string why;         ///< half a sentence
};

/// Largest stable stiffness at a damping.
struct StableStiffness {
  double damping_ns_per_m = 0.0;  ///< D
  double alone_n_per_m = 0.0;     ///< device alone on a wall, without Coulomb friction
  double friction_n_per_m = 0.0;  ///< with it
  StiffnessBounds bounds;
};

/// Behaviour at a point (k, D) of the map when the device is released at the report's places.
struct MarginPoint {
  double stiffness_n_per_m = 0.0, damping_ns_per_m = 0.0;
  Grade grade = Grade::fine;  ///< rests, hums, shakes
};

/// Octaves to expect of a volume larger than memory, in the scene's zoom.
struct CheckedOctaves {
  std::string volume;  ///< its name in the scene
  OctaveExpectation expected;
};

struct CheckReport {
  DevicePlant plant;
  CouplingOptions coupling;  ///< as felt on the device
  Grade grade = Grade::fine;
  std::string verdict;  ///< a line: the gravest finding
  std::vector<CheckPlace> places;
  std::vector<CheckFinding> findings;     ///< the gravest first
  StableStiffness stable;                 ///< at the scene's D
  double largest_damping_ns_per_m = 0.0;  ///< largest stable D at the scene's k, of the device alone on a wall; 0: none
  double most_force_n = 0.0;
  // Of a tool, else 0:
  double turning_radius_m = 0.0;                 ///< as felt on the device
  double reach_m = 0.0;                          ///< largest lever of a foot
  double most_torque_nm = 0.0;                   ///< asked for, before the limit
  std::vector<std::string> modes;                ///< names
  std::vector<double> injected_j, dissipated_j;  ///< by mode, the largest of a trial
  std::vector<Change>
      changes;  ///< proposed changes; empty: none helps, or is needed. The search improves the report (`detail::is_better`)
  std::vector<std::string> advice;  ///< sentences beyond changes of numbers
  Grade grade_after = Grade::fine;  ///< the gravest finding with `changes`
  std::string verdict_after;        ///< that finding in a line; empty without changes
  /// Of the felt volumes that are larger than memory. The verdict is of the device alone.
  std::vector<CheckedOctaves> octaves;
  std::vector<StableStiffness> curve;  ///< for the picture, D ascending
  std::vector<MarginPoint> map;
};

struct CheckOptions {
  bool advise = true;                    ///< searches for improvements, and checks them
  bool map = false;                      ///< computes `curve` and `map`
  ReadOptions read;                      ///< of stores, for the time of their chunks
  std::function<void(double)> progress;  ///< called with the share done, from this thread; may be empty
};

/// The scene clamped to the device's limits of force, stiffness and damping, of a tool also of turning, as in a live run.
Scene within(Scene scene, const DevicePlant& plant);
/// Plant for the check: with a delay of at least one tick, because a force never acts in the tick of its computation. \param
/// plant  Throws LoadError on one without mass.
DevicePlant checked_plant(DevicePlant plant);

/// Mechanics of a `--device`: a preset's, also for a real device of that name with settings of its own; none if unknown.
std::optional<DevicePlant> plant_like(const std::string& description);

/// Checks the scene: seconds to a minute, on all cores. Deterministic. Throws SceneError on a scene that cannot be felt,
/// LoadError on a plant without mass.
CheckReport check(const Scene& scene, const DevicePlant& plant, const CheckOptions& options = {});
/// Quick check, in a second or two: two trials at the strongest place, no advice.
CheckReport check_quickly(const Scene& scene, const DevicePlant& plant);

/// The scene with changes applied.
Scene changed(Scene scene, const std::vector<Change>& changes);

std::string to_table(const CheckReport& report);
/// Formats the report as JSON; names carry their unit.
std::string to_json(const CheckReport& report);

namespace detail {
/// Whether a report is better than another: its gravest finding is less grave, or it has fewer of that grade.
bool is_better(const CheckReport& report, const CheckReport& than) noexcept;
/// Findings of trials at places; without `advise` and `map`.
CheckReport judged(const Scene& scene, const DevicePlant& plant, std::vector<CheckPlace> places, bool quick,
                   const std::function<void(double)>& progress);
/// Grade of a device at rest.
Grade grade_of_rest(const TrialFigures& figures) noexcept;
/// Largest stable stiffness of the device alone on a wall, at a damping.
StableStiffness stable_stiffness(const DevicePlant& plant, double damping_ns_per_m);
/// Its largest stable damping at a stiffness; 0 if none.
double largest_stable_damping_ns_per_m(const DevicePlant& plant, double stiffness_n_per_m);
void advise(const Scene& scene, CheckReport& report, const std::function<void(double)>& progress);
void draw_map(const Scene& scene, CheckReport& report, const std::function<void(double)>& progress);
}  // namespace detail

}  // namespace palpa
