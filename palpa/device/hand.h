// Hands without a device: simulated ones and recorded ones.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "palpa/device/device.h"

namespace palpa {

/// The mechanics of a hand that holds a device: one mass on a spring and a damper to where the hand
/// wants to be, pushed by the force that the device renders.
struct Arm {
  double mass_kg = 0.5;
  double damping_ns_per_m = 6.0;
  double stiffness_n_per_m = 135.0;
};
inline constexpr Arm relaxed_arm{};
inline constexpr Arm firm_arm{.stiffness_n_per_m = 500.0};

/// What a device adds to the arm. The default is an ideal device: nothing.
struct DevicePlant {
  std::string name;  ///< empty: ideal
  double mass_kg = 0.0;
  double damping_ns_per_m = 0.0;    ///< of its mechanics
  double coulomb_friction_n = 0.0;  ///< holds every motion up to this force
  int delay_ticks = 0;              ///< between a write and its force; 0 … 64
  DeviceLimits limits;  ///< no force goes beyond its limit; every position that is read is rounded to its encoder step
};
/// A preset: touch, omega, falcon or inverse3; throws LoadError that lists them. Mass, damping and
/// friction are of the right size, not measurements of one device.
DevicePlant device_plant(const std::string& name);

/// Where a hand wants to be at a time.
class Target {
 public:
  virtual ~Target() = default;
  struct Point {
    Vec3 position_m;
    bool valid = true;  ///< false: nobody knows; the position is the last known
    std::uint32_t buttons = 0;
  };
  /// For any time, in any order; never allocates.
  virtual Point at(double time_s) const noexcept = 0;
  /// Infinite for one that goes on for ever.
  virtual double duration_s() const noexcept = 0;
};

/// The seed of a simulated hand whose description names none.
inline constexpr std::uint64_t default_hand_seed = 1;

/// A simulated hand's path, `sim:press|stroke|circle|helix|random[,KEY=VALUE…]`, in front of the user,
/// for an object that fills ±0.075 m around the middle of the workspace. Each path starts at rest at
/// z = 0.09 m, outside.
///   press   along z, from the start in to `depth_m` behind the object's front (z = 0.075 m) and out again
///   stroke  in to `depth_m`, then sideways and up and down, `radius_m` to either side, over a dome
///   circle  in to `depth_m`, then round a circle of `radius_m` on that dome
///   helix   round the object's y axis at `radius_m` − `depth_m`, slowly up and down
///   random  sums of sines below 8 Hz, seeded, around the point `depth_m` behind the front
/// `speed_m_per_s` is the speed of the motion (press: its largest; random: its mean square root, less
/// where `radius_m`, the largest excursion along an axis, leaves no room). Keys that a path has no use
/// for are accepted. The same text gives the same bits on every machine with IEEE arithmetic. Throws
/// LoadError that says what would be right.
std::unique_ptr<Target> simulated_target(const std::string& description);

struct RecordingOptions {
  double hand_rate_hz = 0.0;   ///< of a file without time, > 0; 0: not given
  std::optional<bool> center;  ///< the middle of its box to the middle of the workspace; none: unless it is our own ticks.csv
};

/// A recorded hand, in one of four forms that its header decides:
///   our own ticks.csv               probe columns, probe_valid and buttons; every row counts
///   t_s,x_m,y_m,z_m[,buttons]       hand frame
///   Time,Cursor Position X,Y,Z …    Haply logs: z is flipped, all-zero rows are dropped
///   x,y,z …                         no time: `hand_rate_hz` is needed
/// Unknown columns are skipped. Time starts at the first row and must not fall; of rows at one time
/// the last counts. But in our own, rows that repeat the last position are dropped (a logger that is
/// faster than its device), but never so many that a resting hand would look like a gap. Rows whose
/// position is not finite are dropped. Between rows the position follows a monotone cubic
/// (Fritsch and Carlson), which never leaves the interval of its two neighbours; where rows are more
/// than 100 ms apart, and after the last, it is not valid. Throws LoadError.
std::unique_ptr<Target> recorded_target(const std::filesystem::path& file, const RecordingOptions& options = {});

/// How a hand is held: rigidly, where no force moves it, or by an arm, which a force can hold.
enum class Hold { rigid, relaxed, firm };

/// A hand that follows `target`, with a device of kind `plant` in it.
///
/// Held by an arm, mass m (arm + device), damping b, stiffness K and Coulomb friction c follow
///     m dv/dt = K (target − x) − b v + force − c v/|v|
/// in at least 20 sub-steps per `advance`, of at most 50 µs, under the force held since the last write
/// (or the one `delay_ticks` advances earlier), each by backward Euler: the sub-step's end is the
/// minimiser of a convex function, found in closed form, friction's sticking included. Backward Euler
/// because it cannot gain energy for any parameters: with the target still, kinetic + spring energy
/// grow by at most force·Δx. Its own damping is that of K h/2 ≈ 0.01 N·s/m. Within one `advance` the
/// target moves in a straight line.
///
/// While the target is not valid nobody holds the device: it is not valid either, and starts again at
/// rest on the target.
std::unique_ptr<SimulatedDevice> hand_device(std::unique_ptr<Target> target, Hold hold, const DevicePlant& plant = {});

/// The hand that `--hand` names, as a device: `sim:…` or a file. Without `hold` a recording is rigid
/// and a simulated hand relaxed.
std::unique_ptr<SimulatedDevice> open_hand(const std::string& description, std::optional<Hold> hold,
                                           const RecordingOptions& options = {}, const DevicePlant& plant = {});

}  // namespace palpa
