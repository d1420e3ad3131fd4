// Tool in the hand: the contact points of the proxy with the data.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "palpa/solver/coupling.h"
#include "palpa/solver/pose.h"

namespace palpa {

/// [1] Largest number of feet of a tool. More: longer worst ticks and more memory; fewer: coarser tools.
inline constexpr std::size_t most_feet = 256;

/// Shape of the tool in the hand ([tool] of a scene). Positions are in the axes of the handle, which are those of the hand
/// frame for a device that is not turned: x right, y up, z towards the user.
struct ToolOptions {
  enum class Shape : std::uint8_t {
    point,   ///< a single foot, at the device's point
    points,  ///< the feet of `points_m`
    rod,     ///< on a straight line along z of `length_m`; with a radius on rings of a cylinder about it
    pad,     ///< on a disc of `radius_m` across z
    ball,    ///< on a sphere of `radius_m`
  };
  Shape shape = Shape::point;
  std::vector<Vec3> points_m{};  ///< [m] feet of the shape `points`: 1 to 256 within 1 m
  double length_m = 0.0;         ///< of a rod; (0, 1]
  double radius_m = 0.0;         ///< of a pad, a ball (0, 0.5], or a rod [0, 0.5]
  int points = 16;               ///< [1] feet of a rod, pad or ball; 1 to 256
  double share = 1.0;            ///< [1] of each primitive's strength and drag that a foot bears; (0, 1]
  /// Position of the device's point in the shape [m], which the hand's force and torque act on.
  Vec3 centre_m{};
  /// ρ [m], (0, 1], below 1e-6 as 1e-6: the coupling's rotational stiffness is its stiffness times ρ². None: from levers,
  /// stiffness and force limit.
  std::optional<double> turning_radius_m{};

  friend bool operator==(const ToolOptions&, const ToolOptions&) = default;
};

/// First fault of the options, as half a sentence; nullptr if valid. Allocates nothing; any thread.
const char* problem_with(const ToolOptions& options) noexcept;

/// Contact points of the proxy with the data, its *feet*, rigidly joined. Modes sample the data at each foot and place
/// primitives that act there. A point tool, the default, has a single foot, at the proxy itself, and no orientation. Any
/// thread.
class Tool {
 public:
  Tool() = default;
  /// Allocates. Throws std::invalid_argument for options or a coupling that are not valid.
  Tool(const ToolOptions& options, const CouplingOptions& coupling);

  friend bool operator==(const Tool&, const Tool&) = default;

  std::size_t feet() const noexcept { return levers_m_.size(); }
  bool is_point() const noexcept { return is_point_; }
  /// [1] of each primitive's strength and drag that a foot bears.
  double share() const noexcept { return share_; }
  /// ρ [m].
  double turning_radius_m() const noexcept { return turning_radius_m_; }
  /// Largest distance of a foot from the device's point [m].
  double reach_m() const noexcept { return reach_m_; }

  // These allocate nothing.

  /// Vector [m] from the device's point to a foot of a tool with this orientation.
  Vec3 lever_m(const Turn& turn, std::size_t foot) const noexcept {
    return is_point_ ? Vec3{} : rotated(turn, levers_m_[foot]);
  }
  /// Position of a foot [m] of a tool in this pose; of a point tool the position of the pose to the bit.
  Vec3 foot_m(const Pose& pose, std::size_t foot) const noexcept {
    return is_point_ ? pose.position_m : pose.position_m + rotated(pose.turn, levers_m_[foot]);
  }
  /// Motion between two poses.
  [[gnu::always_inline]] Motion motion(const Pose& from, const Pose& to) const noexcept {
    return is_point_ ? Motion{to.position_m - from.position_m, {}} : body_motion(from, to);
  }
  /// `from`, moved.
  [[gnu::always_inline]] Pose moved(const Pose& from, const Motion& motion) const noexcept {
    return is_point_ ? Pose{from.position_m + motion.way_m, from.turn} : body_moved(from, motion);
  }
  /// Pose halfway between two.
  Pose middle(const Pose& a, const Pose& b) const noexcept {
    const Vec3 position_m = 0.5 * (a.position_m + b.position_m);
    return {position_m, is_point_ ? a.turn : turned_further(a.turn, 0.5 * rotation_between_rad(a.turn, b.turn))};
  }
  /// Upper bound [m] on the way of any foot in a motion; of a point its length.
  [[gnu::always_inline]] double way_m(const Motion& motion) const noexcept {
    return is_point_ ? norm(motion.way_m) : norm(motion.way_m) + reach_m_ / turning_radius_m_ * norm(motion.arc_m);
  }
  /// Force of the coupling, stretched by `motion`, on a single foot, divided by its stiffness [m]: two neighbouring feet bear
  /// the torque.
  double pull_m(const Motion& motion) const noexcept {
    return norm(motion.way_m) + turning_radius_m_ / least_span_m_ * norm(motion.arc_m);
  }
  /// Likewise between two poses.
  [[gnu::always_inline]] double way_m(const Pose& from, const Pose& to) const noexcept {
    return is_point_ ? distance(from.position_m, to.position_m) : way_m(body_motion(from, to));
  }

 private:
  Motion body_motion(const Pose& from, const Pose& to) const noexcept;
  Pose body_moved(const Pose& from, const Motion& motion) const noexcept;

  std::vector<Vec3> levers_m_{1};  // in the handle's axes
  bool is_point_ = true;
  double share_ = 1.0, turning_radius_m_ = 1.0, reach_m_ = 0.0;
  double least_span_m_ = 1.0;  // between different feet
};

}  // namespace palpa
