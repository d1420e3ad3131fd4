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

  std::size_t feet() const noexcept { return feet_; }
  bool is_point() const noexcept { return is_point_; }
  /// [1] of each primitive's strength and drag that a foot bears.
  double share() const noexcept { return share_; }
  /// ρ [m].
  double turning_radius_m() const noexcept { return turning_radius_m_; }
  /// Largest distance of a foot from the device's point [m].
  double reach_m() const noexcept { return reach_m_; }

  // These allocate nothing. The share of a point is inlined, and of a body the rotation of a lever. Calls return to variables
  // of their own: returned to those that a point computes, they would force these into memory, at the latency of a store.

  /// Vector [m] from the device's point to a foot of a tool with this orientation.
  [[gnu::always_inline]] Vec3 lever_m(const Turn& turn, std::size_t foot) const noexcept {
    return is_point_ ? Vec3{} : rotated(turn, levers_m_[foot]);
  }
  /// Position of a foot [m] of a tool in this pose; of a point tool the position of the pose to the bit.
  [[gnu::always_inline]] Vec3 foot_m(const Pose& pose, std::size_t foot) const noexcept {
    Vec3 foot_m = pose.position_m;
    if (!is_point_) foot_m += rotated(pose.turn, levers_m_[foot]);
    return foot_m;
  }
  /// Whether two poses are equal; of a point their positions.
  [[gnu::always_inline]] bool are_one(const Pose& a, const Pose& b) const noexcept {
    return a.position_m == b.position_m && (is_point_ || a.turn == b.turn);
  }
  /// Motion between two poses.
  [[gnu::always_inline]] Motion motion(const Pose& from, const Pose& to) const noexcept {
    Motion motion{to.position_m - from.position_m, {}};
    if (!is_point_) {
      const Vec3 arc_m = body_arc_m(from.turn, to.turn);
      motion.arc_m = arc_m;
    }
    return motion;
  }
  /// Its length [m] in the metric of way and arc; of a point the distance.
  [[gnu::always_inline]] double length_m(const Pose& from, const Pose& to) const noexcept {
    return is_point_ ? distance(from.position_m, to.position_m) : body_length_m(from, to);
  }
  /// `from`, moved.
  [[gnu::always_inline]] Pose moved(const Pose& from, const Motion& motion) const noexcept {
    Pose moved{from.position_m + motion.way_m, from.turn};
    if (!is_point_) {
      const Turn turn = body_turn(from.turn, motion.arc_m);
      moved.turn = turn;
    }
    return moved;
  }
  /// Pose halfway between two.
  [[gnu::always_inline]] Pose middle(const Pose& a, const Pose& b) const noexcept {
    Pose middle{0.5 * (a.position_m + b.position_m), a.turn};
    if (!is_point_) {
      const Turn turn = body_middle(a.turn, b.turn);
      middle.turn = turn;
    }
    return middle;
  }
  /// Upper bound [m] on the way of any foot in a motion; of a point its length.
  [[gnu::always_inline]] double way_m(const Motion& motion) const noexcept {
    return is_point_ ? norm(motion.way_m) : body_way_m(motion);
  }
  /// Force of the coupling, stretched by `motion`, on a single foot, divided by its stiffness [m]: two neighbouring feet bear
  /// the torque.
  double pull_m(const Motion& motion) const noexcept {
    return norm(motion.way_m) + turning_radius_m_ / least_span_m_ * norm(motion.arc_m);
  }
  /// Likewise between two poses.
  [[gnu::always_inline]] double way_m(const Pose& from, const Pose& to) const noexcept {
    return is_point_ ? distance(from.position_m, to.position_m) : body_way_m(motion(from, to));
  }
  /// Product [m²] of two motions in the metric of way and arc; of a point, which has no arcs, of the ways.
  [[gnu::always_inline]] double product_m2(const Motion& a, const Motion& b) const noexcept {
    return is_point_ ? dot(a.way_m, b.way_m) : dot(a, b);
  }

 private:
  Vec3 body_arc_m(const Turn& from, const Turn& to) const noexcept;
  Turn body_turn(const Turn& from, const Vec3& arc_m) const noexcept;
  Turn body_middle(const Turn& a, const Turn& b) const noexcept;
  double body_way_m(const Motion& motion) const noexcept;
  double body_length_m(const Pose& from, const Pose& to) const noexcept;

  std::vector<Vec3> levers_m_{1};  // in the handle's axes
  std::size_t feet_ = 1;
  bool is_point_ = true;
  double share_ = 1.0, turning_radius_m_ = 1.0, reach_m_ = 0.0;
  double least_span_m_ = 1.0;  // between different feet
};

}  // namespace palpa
