// Where a line of sight meets what is seen.
#pragma once

#include <optional>
#include <vector>

#include "palpa/data/field.h"
#include "palpa/scene/scene.h"

namespace palpa::explorer {

/// Finds the place under the cursor on the surfaces that a scene shows, in the data themselves: as exact as what is felt.
class SurfaceFinder {
 public:
  SurfaceFinder() = default;
  /// Allocates. Throws SceneError on layers whose field is not there.
  explicit SurfaceFinder(const Scene& scene);

  /// The first place where a line meets a surface, hand frame; none: it meets none.
  /// \param from_m   hand frame
  /// \param towards  [1] unit vector away from the viewer
  std::optional<Vec3> first(const Vec3& from_m, const Vec3& towards) const;
  /// Whether there is any surface to find.
  bool has_surfaces() const noexcept { return !surfaces_.empty(); }

 private:
  struct Surface {
    FieldPtr field;  ///< hand frame
    double level;    ///< the field's own unit
  };
  std::vector<Surface> surfaces_;
};

}  // namespace palpa::explorer
