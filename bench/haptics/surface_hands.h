// Hands on surfaces, with the right force of every tick in closed form.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "bench/haptics/cases.h"

namespace palpa::haptics {

extern const Body plane, sphere, bumpy, torus;

/// A point on a body, in the body's own frame.
struct Standing {
  Vec3 place_m;
  Vec3 outward;  ///< [1]
};
/// Point on a body over time [s] or over a share [1] of a turn.
using Walk = std::function<Standing(double)>;

Standing over_plane(double t_s);
Standing over_sphere(double t_s);
Walk over_bumpy();
Standing over_torus(double t_s);
/// Once around: a great circle of the sphere, the torus through its hole.
Standing around_sphere(double turn);
Standing through_torus(double turn);

/// Ruffaldi's in-trajectory: the hand walks, presses with up to 2.1 N, lifts off, and is held still at the end.
std::vector<Touch> in_trajectory(const Body& body, const Walk& over_time);
/// Turns at a depth of 1 N; the right force repeats in every turn.
std::vector<Touch> round_and_round(const Body& body, const Walk& around, int period_ticks, int turns);
/// Into a groove from above, pressed into its bottom, along it with a sway, and held. The free space is convex: the proxy is
/// the nearest free point.
std::vector<Touch> into_groove(const nlohmann::json& groove);
/// Over a knife's edge: the proxy stays on the face until the hand passes the edge.
std::vector<Touch> over_knife(const nlohmann::json& wedge);
/// Straight strokes into a plate, 0.1 to 5 m/s, each held 8 mm below its front, which holds.
std::vector<Touch> through_plate(const nlohmann::json& plate);
/// Over the plane with Coulomb friction: the proxy sticks while the tangential pull is within the cone, else it follows until
/// the pull is on the cone. Exact tick by tick for any path.
std::vector<Touch> with_friction(double coefficient);

struct Shell {
  double radius_m;
  double strength_n;
};
/// The last shell is unbreakable.
inline constexpr Shell shells[] = {{0.030, 1.0}, {0.024, 2.0}, {0.018, 1e9}};
/// Pressed through one after another, and out again.
std::vector<Touch> through_shells();

}  // namespace palpa::haptics
