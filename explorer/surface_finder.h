// Ray casting onto the surfaces of a scene.
#pragma once

#include <optional>
#include <vector>

#include "palpa/data/field.h"
#include "palpa/scene/scene.h"

namespace palpa::explorer {

/// Where a ray meets a surface, hand frame.
struct SurfacePoint {
  Vec3 at_m;
  Vec3 into;  ///< [1] unit normal, on the side that the ray enters
};

/// Intersects rays with the isosurfaces of the scene's fields, not with drawn triangles: as exact as contacts.
class SurfaceFinder {
 public:
  SurfaceFinder() = default;
  /// Of a flow whose modes feel no level there are no surfaces: their shells are no obstacle. Allocates. Throws SceneError on
  /// layers with a missing field.
  explicit SurfaceFinder(const Scene& scene);

  /// First intersection of a ray with a surface, hand frame; none: no intersection.
  /// \param from_m   hand frame
  /// \param towards  [1] unit vector away from the viewer
  std::optional<SurfacePoint> first(const Vec3& from_m, const Vec3& towards) const;
  bool has_surfaces() const noexcept { return !surfaces_.empty(); }

 private:
  struct Surface {
    FieldPtr field;  ///< hand frame
    double level;    ///< the field's own unit
  };
  std::vector<Surface> surfaces_;
};

}  // namespace palpa::explorer
