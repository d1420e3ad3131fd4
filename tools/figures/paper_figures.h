// The paper's Figs. 1–5 and one of all laws beside each other, drawn from the answers of this library's own laws.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "palpa/solver/primitives.h"
#include "palpa/study/compare_laws.h"
#include "palpa/view/plot.h"

namespace palpa {

/// A drawing with the sentence that belongs under it.
struct Figure {
  std::string name;     ///< of its files, without the ending
  std::string caption;  ///< one or two sentences
  int width_px = 0;
  int height_px = 0;
  Sheet sheet;
};

/// Figs. 1–5. Each number in them comes from a Solver, `residual` or the law of 2003; nothing is drawn by hand
/// but what names it.
std::vector<Figure> paper_figures();

/// Every law beside the exact one, under a simulated hand: in many_phantom.toml, whose constraints are oblique,
/// and in head_phantom.toml, whose are orthogonal. Feels the scenes, which takes seconds. Throws LoadError where
/// `scenes_folder` does not have them.
Figure laws_figure(const std::filesystem::path& scenes_folder);

/// Writes each figure as NAME.svg and NAME.png into `folder`, which is made where it is not there; returns
/// the files in order. Throws LoadError.
std::vector<std::filesystem::path> write_figures(const std::filesystem::path& folder,
                                                 const std::vector<Figure>& figures = paper_figures());

namespace detail {

/// Fig. 1: a primitive at 0, along one axis through it.
struct ForceLaw {
  std::vector<double> places_mm;  ///< of the proxy, or of the probe
  std::vector<double> exerted_n;  ///< by the primitive on a proxy held at the place
  std::vector<double> felt_n;     ///< by a hand whose probe is at the place, through the spring
};
ForceLaw force_law(PrimitiveKind kind, double strength_n, double stiffness_n_per_m);

/// Fig. 2: a plane and a point in balance with the spring.
struct PlaneAndPoint {
  double stiffness_n_per_m = 0.0;
  Primitive plane, point;
  Vec3 probe_m, proxy_m;
  Vec3 plane_force_n, point_force_n, spring_force_n;  ///< on the proxy; their sum is zero
};
PlaneAndPoint plane_and_point();

/// Fig. 3: the proxy of a plane through 0 with its normal up, for a probe at each height.
std::vector<double> proxies_over_plane_mm(const std::vector<double>& probes_mm, double strength_n, double stiffness_n_per_m);

/// Fig. 4: a probe below a surface is dragged to the right and back; plane and line stand at the proxy, anew in each step.
struct FrictionLoop {
  std::vector<double> probe_mm, proxy_mm;  ///< along the surface
  std::vector<double> friction_n;          ///< of the line on the proxy, to the right
  std::vector<double> normal_n;            ///< of the plane on the proxy, up
};
FrictionLoop friction_loop(double depth_m, double plane_n, double line_n, double stiffness_n_per_m, double stroke_m, int steps);

/// Fig. 5: where a proxy goes with two planes of zero strength whose normals are `angle_deg` apart, by the law
/// named `law`; the proxy starts at 0, the hand waits at `probe_m`.
Vec3 proxy_between_free_planes(const std::string& law, double angle_deg, const Vec3& probe_m);

/// The share of values up to each place, as the points of a curve that never falls. Values below `low` count at `low`.
/// \param ascending  above or at zero, in the x axis' own unit
/// \param low        > 0, in the x axis' own unit
Series shares_up_to(const std::vector<double>& ascending, double low);

}  // namespace detail
}  // namespace palpa
