// Bodies and curves in closed form: sources of volumes and references of answers.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "palpa/solver/vec3.h"

namespace palpa::haptics {

/// A body, or a curve, which has no inside.
struct Shape {
  /// Depth [m]: above 0 inside; the distance to the surface near it. Of a curve: minus the distance.
  std::function<double(const Vec3&)> depth_m;
  /// Outward unit normal [1] at the nearest surface point, for points near the surface. None of a curve.
  std::function<Vec3(const Vec3&)> outward;
};

/// Descriptions:
///   plane                      below y = 0
///   sphere, bumpy_sphere       radius_m; the second is |x| = R (1 + 0.05 sin 5n_x sin 5n_y sin 5n_z), n = x/|x|
///   torus                      radius_m, tube_m; about z
///   plate                      thickness_m, below y = 0
///   wedge                      opening_deg: between y = 0 where x < 0 and a plane through z that is so far below it
///   groove                     opening_deg: all but a wedge along z that opens towards +y
///   helix                      radius_m, rise_m: a curve about z with this rise per radian; 0: a circle
///   scan                       file, level: the surface of a measured volume, at that file's resolution
/// `turn`, an integer quaternion, rotates it about the origin. Bit-identical on every machine with IEEE arithmetic.
/// \param folder  of the description's files
/// Throws LoadError.
Shape shape_of(const nlohmann::json& description, const std::filesystem::path& folder);

/// Rotation of an integer quaternion [1]: all entries are fractions, without sines.
Mat3 turn_of(const nlohmann::json& quaternion);
Mat3 turn_in(const nlohmann::json& description);

/// The nearest position [m] to a point in a convex wedge along z between two planes through the origin, behind both.
/// \param outward_a, outward_b  [1] unit normals, away from the wedge
Vec3 nearest_in_wedge(const Vec3& x_m, const Vec3& outward_a, const Vec3& outward_b);

/// Unit normals [1] of a groove's two faces, away from the solid.
struct Faces {
  Vec3 a;
  Vec3 b;
};
Faces faces_of_groove(double opening_deg);

}  // namespace palpa::haptics
