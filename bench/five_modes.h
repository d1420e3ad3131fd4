// Five modes on three volumes under one hand: int16 ball with friction, a pull, float vortex with rail, drag and tube.
#pragma once

#include <palpa/palpa.h>

#include <optional>

namespace palpa::bench {

inline constexpr double edge_m = 0.256;
inline constexpr double ball_m = 0.060;
inline constexpr double deep_m = 0.001;  // of the probe below the surface
inline constexpr double hand_m_per_s = 0.1;

extern bool huge_pages;  // for voxels made later

/// Depth in a ball in steps of 1e-5 m: int16, as a scanner stores it.
Volume ball_on(int voxels);
/// A vortex along z with a drift along it; its core is as wide as the ball.
Volume flow_on(int voxels);
/// Pull field: largest at one corner.
Volume warmth_on(int voxels);

struct Volumes {
  Volume body, flow, warmth;
};

Scene in_reach(const Vec3& centre_m);
SurfaceAndFriction skin_of(const FieldRef& body);
/// \param filter  of all volumes; none: the default of each voxel type
Scene five_modes(const Volumes& volumes, std::optional<Filter> filter, const Vec3& centre_m = {});

/// A probe on slowly turning great circles around the ball, deep_m below its surface.
class Round {
 public:
  explicit Round(double reach_m) : reach_m_(reach_m) {}
  /// 1 ms later.
  Vec3 next();

 private:
  double reach_m_;
  double way_m_ = 0.0;
};

}  // namespace palpa::bench
