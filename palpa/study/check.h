// Whether a scene should be felt on a device: closed loops at its worst places, graded, with what to change.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "palpa/study/bounds.h"
#include "palpa/study/check_trial.h"

namespace palpa {

/// How grave a finding is.
enum class Grade : std::uint8_t {
  fine,
  warn,  ///< felt, and not in the data
  stop,  ///< should not be felt on that device
};
const char* name_of(Grade grade) noexcept;

// Thresholds. Each has its reason in docs/check.md; people differ, and these are of one finger, one arm, one day.

/// [m/s²] Root mean square of a device's own motion that skin feels: 10 µm at 40 Hz, falling by 12 dB an octave up to 250 Hz
/// (Bolanowski et al. 1988), which is one acceleration. Lower: what nobody feels is told; higher: what is felt is not.
inline constexpr double felt_acceleration_m_per_s2 = 0.45;
/// [m/s²] Ten times as much, 20 dB above it: nobody takes it for the data. Higher: devices buzz and kick; lower: scenes whose
/// hum is hardly felt are refused.
inline constexpr double borne_acceleration_m_per_s2 = 10.0 * felt_acceleration_m_per_s2;
/// [N] In a tick: half of what the guard lets a force grow in a millisecond, and what a level that breaks is held to. There is
/// no threshold of people for it. Higher: kicks pass; lower: levels that break are refused.
inline constexpr double borne_jump_n = 0.55;
/// [J] Brought into one trial by a mode that should bring in nothing: the budget of the guard's account.
inline constexpr double borne_energy_j = 5e-3;

/// One thing that was looked at.
struct CheckFinding {
  std::string key;  ///< "let_go", "held", "jump", …: as in JSON
  Grade grade = Grade::fine;
  double measured = 0.0;   ///< [`unit`]
  double threshold = 0.0;  ///< [`unit`]
  std::string unit;
  std::string where;  ///< trial and place; empty: the scene as a whole
  std::string words;  ///< one sentence
};

/// A setting that would be better.
struct Change {
  std::string table, key;  ///< "coupling", "stiffness_n_per_m"
  double from = 0.0;       ///< in the key's own unit
  double to = 0.0;         ///< in the key's own unit
  std::string why;         ///< half a sentence
};

/// The largest stable stiffness at one damping.
struct StableStiffness {
  double damping_ns_per_m = 0.0;  ///< D
  double alone_n_per_m = 0.0;     ///< of the device alone on a wall, without Coulomb friction
  double friction_n_per_m = 0.0;  ///< with it
  StiffnessBounds bounds;
};

/// What one place of the map (k, D) does when the device is let go at the scene's strongest place.
struct MarginPoint {
  double stiffness_n_per_m = 0.0, damping_ns_per_m = 0.0;
  Grade grade = Grade::fine;  ///< rests, hums, shakes
};

struct CheckReport {
  DevicePlant plant;
  CouplingOptions coupling;  ///< as it is felt on the device
  Grade grade = Grade::fine;
  std::string verdict;  ///< one line: the gravest finding
  std::vector<CheckPlace> places;
  std::vector<CheckFinding> findings;     ///< the gravest first
  StableStiffness stable;                 ///< at the scene's D
  double largest_damping_ns_per_m = 0.0;  ///< largest stable D at the scene's k, of the device alone on a wall; 0: none
  double most_force_n = 0.0;
  std::vector<std::string> modes;                ///< names
  std::vector<double> injected_j, dissipated_j;  ///< by mode, the most of one trial
  std::vector<Change> changes;                   ///< what to change; empty: nothing is known that would help, or need be.
                                                 ///< What was searched makes the report better (`detail::is_better`)
  std::vector<std::string> advice;               ///< what a number cannot say, a sentence each
  Grade grade_after = Grade::fine;               ///< the gravest finding once `changes` were followed
  std::string verdict_after;                     ///< that finding in one line; empty where there are no changes
  std::vector<StableStiffness> curve;            ///< for the picture, D rising
  std::vector<MarginPoint> map;
};

struct CheckOptions {
  bool advise = true;                    ///< searches what would be better, and checks that
  bool map = false;                      ///< fills `curve` and `map`
  std::function<void(double)> progress;  ///< called with the share that is done, from this thread; may be empty
};

/// The scene as that device bears it: neither stronger nor stiffer than its limits, as a live run does it.
Scene within(Scene scene, const DevicePlant& plant);
/// The plant that is checked: with at least one tick of delay, because a force is never felt in the tick that it is worked out
/// in. \param plant  Throws LoadError on one without mass.
DevicePlant checked_plant(DevicePlant plant);

/// The mechanics of a device that `--device` describes: a preset's, also where a real device of that name has settings of its
/// own; none where nothing is known of it.
std::optional<DevicePlant> plant_like(const std::string& description);

/// Checks it: seconds to a minute, in as many threads as there are processors. The same scene and device give the same report.
/// Throws SceneError on a scene that cannot be felt, LoadError on a plant without mass.
CheckReport check(const Scene& scene, const DevicePlant& plant, const CheckOptions& options = {});
/// The same in a second or two: two trials at the strongest place, no advice.
CheckReport check_quickly(const Scene& scene, const DevicePlant& plant);

/// The scene with changes made.
Scene changed(Scene scene, const std::vector<Change>& changes);

/// The report as a table for a person.
std::string to_table(const CheckReport& report);
/// The report as JSON; names carry their unit.
std::string to_json(const CheckReport& report);

namespace detail {
/// Whether one report is better than another: its gravest finding is less grave, or it has fewer that are as grave.
bool is_better(const CheckReport& report, const CheckReport& than) noexcept;
/// The findings of trials at places; `advise` and `map` are not looked at.
CheckReport judged(const Scene& scene, const DevicePlant& plant, std::vector<CheckPlace> places, bool quick,
                   const std::function<void(double)>& progress);
/// How a device at rest is graded.
Grade grade_of_rest(const TrialFigures& figures) noexcept;
/// The largest stable stiffness of the device alone on a wall, at a damping.
StableStiffness stable_stiffness(const DevicePlant& plant, double damping_ns_per_m);
/// The largest stable damping of it at a stiffness; 0 where there is none.
double largest_stable_damping_ns_per_m(const DevicePlant& plant, double stiffness_n_per_m);
/// Fills `changes`, `advice` and `grade_after`.
void advise(const Scene& scene, CheckReport& report, const std::function<void(double)>& progress);
/// Fills `curve` and `map`.
void draw_map(const Scene& scene, CheckReport& report, const std::function<void(double)>& progress);
}  // namespace detail

}  // namespace palpa
