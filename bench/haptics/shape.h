// Bodies and curves whose surface is known in closed form: what volumes are made of, and what answers are held against.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "palpa/solver/vec3.h"

namespace palpa::haptics {

/// A body, or a curve, which has no inside.
struct Shape {
  /// How deep [m] a place lies in the body: above zero inside, and near the surface the distance to it. Of a curve: minus the
  /// distance.
  std::function<double(const Vec3&)> depth_m;
  /// Unit vector [1] out of the body, where a place on the surface or near it is nearest to it. None of a curve.
  std::function<Vec3(const Vec3&)> outward;
};

/// What a description says:
///   plane                      below y = 0
///   sphere, bumpy_sphere       radius_m; the second is |x| = R (1 + 0.05 sin 5n_x sin 5n_y sin 5n_z), n = x/|x|
///   torus                      radius_m, tube_m; about z
///   plate                      thickness_m, below y = 0
///   wedge                      opening_deg: between y = 0 where x < 0 and a plane through z that is so far below it
///   groove                     opening_deg: all but a wedge along z that opens towards +y
///   helix                      radius_m, rise_m: a curve about z that rises so far per radian; 0: a circle
///   scan                       file, level: the surface of a measured volume, at the resolution of that file
/// `turn`, a quaternion in whole numbers, turns it about the origin. The same bits on every machine with IEEE arithmetic.
/// \param folder  that files of the description are in
/// Throws LoadError.
Shape shape_of(const nlohmann::json& description, const std::filesystem::path& folder);

/// A quaternion of whole numbers [1] as a rotation: all entries are fractions, so that nothing depends on a sine.
Mat3 turn_of(const nlohmann::json& quaternion);
/// That of a description, or none.
Mat3 turn_in(const nlohmann::json& description);

/// The foot [m] of a place in a convex wedge along z, bounded by two planes through the origin: the nearest place that is
/// behind both. \param outward_a, outward_b  [1] unit normals, away from the wedge
Vec3 foot_in_wedge(const Vec3& x_m, const Vec3& outward_a, const Vec3& outward_b);

/// Unit normals [1] of a groove's two faces, away from the solid.
struct Faces {
  Vec3 a;
  Vec3 b;
};
Faces faces_of_groove(double opening_deg);

}  // namespace palpa::haptics
