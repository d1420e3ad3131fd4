// Measures of surfaces: drift, error on a bumpy sphere, rest in grooves.
#pragma once

#include "palpa/session/session.h"
#include "tests/path/shapes.h"
#include "tests/solver/random_problems.h"

namespace palpa::test {

/// A hand on a circle 1 mm below a sphere of 50 mm, 0.4 m/s, k = 800 N/m, in random planes.
struct DriftCase {
  int planes = 1;
  int turns = 10;
};
struct Drift {
  double per_turn_m =
      0.0;  ///< distance of the proxy after the last turn from its position after the first, per turn between; worst plane
  double off_p50_m = 0.0;  ///< distance to the true sphere along the whole path
  double off_p99_m = 0.0;
};
/// `field`: depth [m] below a sphere of 50 mm about the origin.
Drift measure_drift(const FieldPtr& field, const DriftCase& wanted);
inline constexpr double drift_sphere_m = 0.05;
/// The sphere in 12 bits and voxels of 1 mm, with an edge ramp over ±3 voxels.
FieldPtr sampled_sphere(Filter filter);

/// CHAI3D's measure: a script of approach and glide over a bumpy sphere of 0.3 cube edges, 8-bit, ±8 voxels of edge.
struct BumpyCase {
  int voxels = 128;
  Filter filter = Filter::smooth;
  double speed_m_per_s = 0.05;
  int ticks = 10000;
};
struct Bumpy {
  int contact_ticks = 0;            ///< probe more than a voxel inside
  double surface_p50_voxels = 0.0;  ///< proxy to the true surface
  double surface_p99_voxels = 0.0;
  double ideal_p50_voxels = 0.0;  ///< proxy to the surface point nearest to the probe
  double ideal_p99_voxels = 0.0;
  double direction_p50_deg = 0.0;  ///< force to the true normal at the surface point nearest to the proxy
  double direction_p99_deg = 0.0;
  double ideal_direction_p99_deg = 0.0;  ///< … nearest to the probe
  double still_direction_p99_deg = 0.0;  ///< the field's own normal at the true surface, without a tick
  int stray_ticks = 0;                   ///< proxy more than 5 voxels from the point nearest to the probe
  double sub_steps_mean = 0.0;
  double preparation_s = 0.0;  ///< from voxels in memory to the first tick
};
Bumpy measure_bumpy(const BumpyCase& wanted);

/// V-grooves in voxels of 1 mm, pressed with less than s·sin(α/2), held still and slid along.
struct GrooveCase {
  double opening_deg = 40.0;
  bool binary = false;
  Filter filter = Filter::trilinear;
  int orientations = 10;
  std::uint64_t seed = 3;
};
struct Groove {
  int ticks = 0;
  double never_rest_share = 0.0;      ///< another sub-step with an equal probe moves more than 1e-3 voxel, or is cut short
  double restless_still_share = 0.0;  ///< likewise, over the ticks with the hand still
  double sub_steps_p99 = 0.0;
  double force_jump_p99_n = 0.0;
  double force_jump_max_n = 0.0;
  int lost_ticks = 0;   ///< the surface released a hand inside of it
  int audited = 0;      ///< every fifth tick in contact that reports rest
  int false_rests = 0;  ///< of these: the proxy could be nearer (see `could_be_nearer`)
  int break_throughs = 0;
  int false_break_throughs = 0;  ///< of these: released a proxy that could have been nearer
};
Groove measure_groove(const GrooveCase& wanted);

/// True if a proxy on a solid could be nearer to its probe: of 1600 random points within 0.45 voxel one is nearer by more than
/// 0.01 voxel and free, and so is the straight path to it. A proxy that merely stops fails this test. \param solid  depth:
/// above 0 inside
bool could_be_nearer(const Field& solid, double voxel_m, const Vec3& proxy_m, const Vec3& probe_m, Random& random);

/// The proxy's move [m] in another sub-step with an equal probe, shortened or not: 0 at rest. `spare` is another session of the
/// scene.
double restless_m(const Session& session, Session& spare, const Vec3& probe_m);

}  // namespace palpa::test
