// Simulated and recorded hands.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "palpa/device/device.h"

namespace palpa {

/// Mechanics of a hand that holds a device: a mass on a spring and a damper to the intended position, pushed by the rendered
/// force.
struct Arm {
  double mass_kg = 0.5;
  double damping_ns_per_m = 6.0;
  double stiffness_n_per_m = 135.0;
};
inline constexpr Arm relaxed_arm{};
inline constexpr Arm firm_arm{.stiffness_n_per_m = 500.0};

/// Device's contribution to the arm. Default: an ideal device, nothing.
struct DevicePlant {
  static constexpr int longest_delay_ticks = 64;
  std::string name;  ///< empty: ideal
  double mass_kg = 0.0;
  double damping_ns_per_m = 0.0;    ///< of its mechanics
  double coulomb_friction_n = 0.0;  ///< holds any motion up to this force
  int delay_ticks = 0;              ///< between a write and its force; 0 … 64
  DeviceLimits limits;              ///< limits the force; read positions are rounded to its encoder step
};
/// Presets of commercial devices: touch, omega, falcon, inverse3 and desktop. Mass, damping and friction are of the right
/// magnitude, not measurements of a device.
std::span<const DevicePlant> device_presets();
/// Preset by name, with changed values: `touch`, or `touch,encoder_step_m=2e-5,delay_ticks=2`. The keys are the members of
/// DevicePlant and of its limits. Instead of a preset the name of a file, `mine.toml`, with these keys, after `like = "touch"`
/// to begin from a preset, else from an ideal device. Its name is the whole description. Throws LoadError with the remedy.
DevicePlant device_plant(const std::string& description);
/// Formats its values with their units, for a person.
std::string format_plant(const DevicePlant& plant);

/// Intended position of a hand by time.
class Target {
 public:
  virtual ~Target() = default;
  struct Point {
    Vec3 position_m;
    bool valid = true;  ///< false: unknown; the position is the last known
    std::uint32_t buttons = 0;
    std::optional<Turn> turn{};  ///< orientation of the handle, of unit length; none: the hand has none
  };
  /// For any time, in any order; never allocates.
  virtual Point at(double time_s) const noexcept = 0;
  /// Infinite for endless motion.
  virtual double duration_s() const noexcept = 0;
  /// Whether the positions are in the workspace already; else the recording's origin is unknown.
  virtual bool has_own_placement() const noexcept { return true; }
  /// Sentences for the user.
  virtual std::vector<std::string> warnings() const { return {}; }
};

/// Target with all its positions x at `scale` · x + `offset_m` [m]; its turns are unchanged.
/// \param scale  [1] > 0
std::unique_ptr<Target> displaced(std::shared_ptr<const Target> target, const Vec3& offset_m, double scale = 1.0);

/// Seed of a simulated hand if its description has none.
inline constexpr std::uint64_t default_hand_seed = 1;

/// Parsed motion of a simulated hand: `sim:press|stroke|circle|helix|random[,KEY=VALUE…]`.
struct SimulatedMotion {
  enum class Kind : std::uint8_t { press, stroke, circle, helix, random };
  Kind kind = Kind::press;
  std::optional<double>
      speed_m_per_s;               ///< press: the largest; random: mean square root. None: 0.1, but at most a round a second
  std::optional<double> radius_m;  ///< lateral extent of the motion; helix: about the axis. None: the available extent
  std::optional<double> depth_m;   ///< intended depth behind the front; none: half of the bearable depth there
  std::uint64_t seed = default_hand_seed;
  double tilt_rad = 0.0;  ///< the handle swings by this about x and about z; [0, 3]; 0: it has no orientation
};
/// Throws LoadError with the remedy.
SimulatedMotion simulated_motion(const std::string& description);

class Front;  // surface that a hand follows at any depth, made by the functions below
/// Front of hands without a scene: a ball of 0.075 m about the origin, facing the user; u and v are x and y [m]. Beyond 0.8 of
/// its radius it continues as the tangent cone.
std::shared_ptr<const Front> ball_facing();
/// Cylinder about an axis along y through `centre_m` [m], of `radius_m` [m] > 0: u are turns from the user's side, to the right
/// first, v is the height above the centre [m].
std::shared_ptr<const Front> cylinder_around(const Vec3& centre_m, double radius_m);
/// Object of a simulated hand. `palpa run` makes it from a scene; the default is a ball of 0.075 m about the centre of the
/// workspace.
struct Encounter {
  std::shared_ptr<const Front> facing = ball_facing();               ///< u and v: x and y [m] relative to the point of contact
  std::shared_ptr<const Front> around = cylinder_around({}, 0.075);  ///< u and v: turns and height [m]; for the helix
  Vec3 axis_m{};                                                     ///< point on the axis of the helix, along y
  double before_m = 0.015;                                           ///< distance of the start before the front
  double retreat_m = 0.015;                                          ///< distance before the front to which a press returns
  bool lifts = false;           ///< every other second, to `retreat_m` before the front: broken levels are felt again
  double depth_m = 0.02;        ///< default depth of the motion
  double radius_m = 0.03;       ///< default lateral extent of the motion
  double half_height_m = 0.05;  ///< of the helix
};

/// Path of a simulated hand. Begins at rest `before_m` before the front, approaches at up to 0.1 m/s, slowly over the last 3
/// mm, and from the front on performs its motion, at the depth behind the front of the motion or the encounter:
///   press   in to the depth and back to `retreat_m` before the front
///   stroke  sideways and up and down over the front, `radius_m` to either side
///   circle  on a circle of `radius_m` on the front
///   helix   round the axis, slowly up and down; a motion's own `radius_m` is that of a cylinder in place of the front
///   random  sums of sines below 8 Hz, seeded, `radius_m` to any side about half of the depth, now and then out of the front
/// With `tilt_rad` the handle swings about x once in 2 s, and about z once in 3.2 s, beginning upright.
/// Equal motions give equal bits on every machine with IEEE arithmetic.
std::unique_ptr<Target> simulated_target(const SimulatedMotion& motion, const Encounter& encounter = {});
/// `simulated_target` of a description, before the ball.
std::unique_ptr<Target> simulated_target(const std::string& description);

/// Properties that a recorded hand's file leaves open.
struct RecordingOptions {
  double hand_rate_hz = 0.0;   ///< of a file without time, > 0; 0: not given
  std::optional<bool> center;  ///< centre of its box to the centre of the workspace; none: unless it is a trace's ticks.csv
};

/// Recorded hand, in a form determined by its header:
///   ticks.csv of a trace            probe columns, probe_valid and buttons; every row counts
///   t_s,x_m,y_m,z_m[,buttons]       hand frame; also with time, time_s, timestamp or t for t_s, and x,y,z
///   Time,Cursor Position X,Y,Z …    Haply logs: z is flipped, all-zero rows are dropped
///   x,y,z …                         no time: `hand_rate_hz` is needed
/// All but Haply's logs may have the handle's orientation, a unit quaternion to within 1e-3: turn_w, turn_x, turn_y, turn_z; in
/// a trace of a tool probe_turn_w, …. Between rows it turns evenly, by the shorter way.
/// Unknown columns are skipped. Time starts at the first row and must not fall; of rows at equal times the last counts. Except
/// in a trace, rows that repeat the last position are dropped if their pattern is that of a logger faster than its device
/// (`detail::repeat_by_logger`; in Haply logs always), but never so many that a resting hand becomes a gap. Rows with a
/// non-finite position are dropped, as is a last line without its end; `warnings` names both assumptions. Between rows the
/// position follows a monotone cubic (Fritsch and Carlson), which stays between its neighbours; in gaps of more than 100 ms,
/// and after the last row, it is not valid; a warning reports it. Names without a unit mean seconds and metres, and are refused
/// if a hand would then be too slow or too large. Throws LoadError.
std::unique_ptr<Target> recorded_target(const std::filesystem::path& file, const RecordingOptions& options = {});

/// Hand at given positions, one for each tick of `time_step_s`, in the hand frame; never displaced. Exact at a row's time,
/// between rows on the monotone cubic of a recorded hand; non-finite rows are not valid.
/// \param positions_m  [m]; at least one is finite, none is further away than 1000 m
/// \param time_step_s  [s] above 0 and at most 1
/// Throws LoadError.
std::unique_ptr<Target> sampled_target(std::span<const Vec3> positions_m, double time_step_s);

/// Hold of a hand: rigid, unmoved by forces, or by an arm, which yields.
enum class Hold { rigid, relaxed, firm };

/// Hand that follows `target`, holding a device of kind `plant`.
///
/// With an arm, mass m (arm + device), damping b, stiffness K and Coulomb friction c follow
///     m dv/dt = K (target − x) − b v + force − c v/|v|
/// in at least 20 sub-steps per `advance`, of at most 50 µs, under the force held since the last write (or the one
/// `delay_ticks` advances earlier), each by backward Euler: the sub-step's end is the minimiser of a convex function, in closed
/// form, with sticking friction. Backward Euler because it cannot gain energy for any parameters: with the target still,
/// kinetic + spring energy grow by at most force·Δx. Its numerical damping is K h/2 ≈ 0.01 N·s/m. Within an `advance` the
/// target moves in a straight line.
///
/// The orientation is that of the target: no torque turns the hand.
///
/// While the target is not valid the device is released: it is not valid either, and restarts at rest on the target.
std::unique_ptr<SimulatedDevice> hand_device(std::shared_ptr<const Target> target, Hold hold, const DevicePlant& plant = {});

/// The hand of `--hand`, as a device: `sim:…` or a file. Without `hold` a recording is rigid and a simulated hand relaxed.
std::unique_ptr<SimulatedDevice> open_hand(const std::string& description, std::optional<Hold> hold,
                                           const RecordingOptions& options = {}, const DevicePlant& plant = {});

}  // namespace palpa
