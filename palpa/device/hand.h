// Hands without a device: simulated ones and recorded ones.
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
  static constexpr int longest_delay_ticks = 64;
  std::string name;  ///< empty: ideal
  double mass_kg = 0.0;
  double damping_ns_per_m = 0.0;    ///< of its mechanics
  double coulomb_friction_n = 0.0;  ///< holds every motion up to this force
  int delay_ticks = 0;              ///< between a write and its force; 0 … 64
  DeviceLimits limits;  ///< no force goes beyond its limit; every position that is read is rounded to its encoder step
};
/// Devices that can be had: touch, omega, falcon, inverse3 and desktop. Mass, damping and friction are of the right size, not
/// measurements of one device.
std::span<const DevicePlant> device_presets();
/// A preset by its name, with single values changed: `touch`, or `touch,encoder_step_m=2e-5,delay_ticks=2`. The keys are the
/// members of DevicePlant and of its limits. In place of a preset the name of a file, `mine.toml`, which says the same keys,
/// after `like = "touch"` where it begins from a preset, else from an ideal device. Its name is the whole description. Throws
/// LoadError that says what would be right.
DevicePlant device_plant(const std::string& description);
/// Its values with their units, for a person.
std::string words_of(const DevicePlant& plant);

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
  /// Whether the positions are meant for the workspace as they are; else the hand was recorded who knows where.
  virtual bool knows_its_place() const noexcept { return true; }
  /// What a person should know of it, a sentence each.
  virtual std::vector<std::string> warnings() const { return {}; }
};

/// The target with all its positions x at `scale` · x + `offset_m` [m].
/// \param scale  [1] > 0
std::unique_ptr<Target> displaced(std::shared_ptr<const Target> target, const Vec3& offset_m, double scale = 1.0);

/// The seed of a simulated hand whose description names none.
inline constexpr std::uint64_t default_hand_seed = 1;

/// What a simulated hand is to do: `sim:press|stroke|circle|helix|random[,KEY=VALUE…]`, read.
struct SimulatedMotion {
  enum class Kind : std::uint8_t { press, stroke, circle, helix, random };
  Kind kind = Kind::press;
  std::optional<double>
      speed_m_per_s;  ///< press: the largest; random: mean square root. None: 0.1, but at most one round a second
  std::optional<double>
      radius_m;  ///< how far beside the place the hand goes; helix: about the axis. None: what the place has room for
  std::optional<double> depth_m;  ///< how far behind the front the hand wants to be; none: half of what can be borne there
  std::uint64_t seed = default_hand_seed;
};
/// Throws LoadError that says what would be right.
SimulatedMotion simulated_motion(const std::string& description);

class Front;  // a surface that a hand follows at a depth of its choice: what the two below make
/// The round front that hands without a scene are made for: a ball of 0.075 m about the origin, seen from the user; u and v are
/// x and y [m]. Beyond 0.8 of its radius it goes on as the cone that touches it there.
std::shared_ptr<const Front> ball_facing();
/// A cylinder about an axis along y through `centre_m` [m], of `radius_m` [m] > 0: u are turns from the user's side, to the
/// right first, v is the height above the centre [m].
std::shared_ptr<const Front> cylinder_around(const Vec3& centre_m, double radius_m);
/// What a simulated hand comes upon. `palpa run` makes it of a scene; this one is a ball of 0.075 m
/// about the middle of the workspace.
struct Encounter {
  std::shared_ptr<const Front> facing = ball_facing();  ///< u and v: x and y [m] beside the place where the hand meets it
  std::shared_ptr<const Front> around = cylinder_around({}, 0.075);  ///< u and v: turns and height [m]; for the helix
  Vec3 axis_m{};                                                     ///< what the helix goes round, along y
  double before_m = 0.015;                                           ///< how far before the front the hand begins
  double retreat_m = 0.015;                                          ///< how far before the front a press goes back to
  bool lifts = false;           ///< every other second, out to `retreat_m` before the front: what gives way is felt again
  double depth_m = 0.02;        ///< how deep the hand goes where its description does not say it
  double radius_m = 0.03;       ///< how far beside the place it goes where its description does not say it
  double half_height_m = 0.05;  ///< how far up and down the helix goes
};

/// A simulated hand's path. It begins at rest `before_m` before the front, comes in at up to 0.1 m/s, slowly over the last 3
/// mm, and from the front on does what it is named for, at a depth behind the front that is the motion's or the encounter's:
///   press   in to the depth and back to `retreat_m` before the front
///   stroke  sideways and up and down over the front, `radius_m` to either side
///   circle  round a circle of `radius_m` on the front
///   helix   round the axis, slowly up and down; a motion's own `radius_m` is that of a cylinder in place of the front
///   random  sums of sines below 8 Hz, seeded, `radius_m` to any side about half of the depth, now and then out of the front
/// The same motion gives the same bits on every machine with IEEE arithmetic.
std::unique_ptr<Target> simulated_target(const SimulatedMotion& motion, const Encounter& encounter = {});
/// The same of a description, before the ball.
std::unique_ptr<Target> simulated_target(const std::string& description);

/// What the file of a recorded hand leaves open.
struct RecordingOptions {
  double hand_rate_hz = 0.0;   ///< of a file without time, > 0; 0: not given
  std::optional<bool> center;  ///< the middle of its box to the middle of the workspace; none: unless it is our own ticks.csv
};

/// A recorded hand, in one of four forms that its header decides:
///   our own ticks.csv               probe columns, probe_valid and buttons; every row counts
///   t_s,x_m,y_m,z_m[,buttons]       hand frame; also with time, time_s, timestamp or t for t_s, and x,y,z
///   Time,Cursor Position X,Y,Z …    Haply logs: z is flipped, all-zero rows are dropped
///   x,y,z …                         no time: `hand_rate_hz` is needed
/// Unknown columns are skipped. Time starts at the first row and must not fall; of rows at one time
/// the last counts. But in our own, rows that repeat the last position are dropped where their pattern is that of
/// a logger that is faster than its device (`detail::repeat_by_logger`; in Haply logs always), but never so many that a resting
/// hand would look like a gap. Rows whose position is not finite are dropped, and so is a last line without its end; `warnings`
/// names both assumptions. Between rows the position follows a monotone cubic
/// (Fritsch and Carlson), which never leaves the interval of its two neighbours; where rows are more
/// than 100 ms apart, and after the last, it is not valid; a warning says so. Names that say no unit are taken as seconds and
/// metres, and refused where a hand would then be too slow or too large. Throws LoadError.
std::unique_ptr<Target> recorded_target(const std::filesystem::path& file, const RecordingOptions& options = {});

/// A hand at given positions, one for each tick of `time_step_s`, in the hand frame; never moved. At a row's time it is exactly
/// there, between rows on the monotone cubic of a recorded hand; rows that are not finite are not valid.
/// \param positions_m  [m]; at least one is finite, none is further away than 1000 m
/// \param time_step_s  [s] above 0 and at most 1
/// Throws LoadError.
std::unique_ptr<Target> sampled_target(std::span<const Vec3> positions_m, double time_step_s);

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
std::unique_ptr<SimulatedDevice> hand_device(std::shared_ptr<const Target> target, Hold hold, const DevicePlant& plant = {});

/// The hand that `--hand` names, as a device: `sim:…` or a file. Without `hold` a recording is rigid
/// and a simulated hand relaxed.
std::unique_ptr<SimulatedDevice> open_hand(const std::string& description, std::optional<Hold> hold,
                                           const RecordingOptions& options = {}, const DevicePlant& plant = {});

}  // namespace palpa
