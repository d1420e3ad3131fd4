// The figures of docs/path.md, drawn from sessions of this program.
#pragma once

#include <string>
#include <vector>

#include "tools/figures/paper_figures.h"

namespace palpa {

/// Drift round a sphere, a groove, a thin wall, convergence. All but what names things is felt by a Session. Takes a few
/// seconds.
std::vector<Figure> path_figures();

namespace detail {

/// How the proxy is led after the probe. Every balance is the exact one.
enum class Walked {
  one_step,  ///< one balance per tick, as in all earlier systems
  path,      ///< the proxy's path
};

/// A hand goes round once, 1 mm below a sphere of 50 mm, 800 N/m, ticks of 1 ms.
/// \param on_level  a plane on the captured level; else one through the proxy, with the local normal, as the paper has it
/// \return          [m] how far off the sphere the proxy is, tick by tick
std::vector<double> off_sphere_m(Walked walked, bool on_level, double speed_m_per_s, double turns = 1.0);
inline constexpr double drift_depth_m = 1e-3;
inline constexpr double drift_radius_m = 0.05;

/// A hand presses into a V-groove of 40° in voxels of 1 mm, holds still, and slides along it.
struct InGroove {
  std::vector<Vec3> force_n;            ///< tick by tick; z along the groove, y out of it
  std::vector<Vec3> proxies_m;          ///< tick by tick
  std::size_t still_from = 0;           ///< tick in which the hand has come to a halt …
  std::size_t slides_from = 0;          ///< … and in which it sets off again
  Vec3 probe_m;                         ///< while it is still
  std::vector<PlacedPrimitive> planes;  ///< of its last balance then
  std::vector<Vec3> level_m;            ///< seen along the groove, from left to right
};
InGroove press_into_groove(Walked walked);

/// A straight stroke across a wall of 0.3 mm that is stronger than the whole stroke.
struct ThroughWall {
  std::vector<double> probe_m;  ///< along the stroke, 0 on the wall's near side
  std::vector<double> proxy_m;
};
inline constexpr double wall_m = 3e-4;
/// \param first_m  where on its way, within one tick, the hand begins
ThroughWall stroke_through_wall(Walked walked, double speed_m_per_s, double first_m);

/// How the path converges: largest distances between the paths in 1 and 2, 2 and 4, 4 and 8, 8 and 16 steps per tick of a hand
/// that goes 0.3 mm in each.
struct Convergence {
  std::string mode;
  std::vector<double> steps_m;        ///< the longer ones
  std::vector<double> differences_m;  ///< as many
};
std::vector<Convergence> convergence_in_scalars();
std::vector<Convergence> convergence_in_vectors();

}  // namespace detail
}  // namespace palpa
