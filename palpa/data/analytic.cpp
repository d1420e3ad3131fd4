#include "palpa/data/analytic.h"

#include "palpa/data/phantom_parts.h"

namespace palpa {

using namespace detail::phantom;

Volume plane_field(double size_m) {
  check_length("the size of a plane's box", size_m);
  const double half_m = 0.5 * size_m;
  return volume_of("depth", "m", cube(half_m), size_m / 64.0, {{-half_m, half_m}}, [](const Vec3& x) noexcept {
    return ScalarSample{-x.z, {0.0, 0.0, -1.0}, true};
  });
}

Volume sphere_field(double radius_m) {
  check_length("a sphere's radius", radius_m);
  const double half_m = 1.5 * radius_m;
  return volume_of("depth", "m", cube(half_m), radius_m / 32.0, {{radius_m - norm({half_m, half_m, half_m}), radius_m}},
                   [radius_m](const Vec3& x) noexcept {
                     return ScalarSample{radius_m - norm(x), -normalized(x), true};
                   });
}

namespace {

/// `bored_block`, in the half plane of the distance from the axis and the height.
struct BoredBlock {
  double radius_m, depth_m, rim_m;

  struct Depth {
    double value_m, along_radius, along_z;
  };
  static Depth larger(const Depth& a, const Depth& b) noexcept { return a.value_m < b.value_m ? b : a; }
  static Depth smaller(const Depth& a, const Depth& b) noexcept { return b.value_m < a.value_m ? b : a; }

  Depth at(double r, double z) const noexcept {
    const Depth top{-z, 0.0, -1.0}, wall{r - radius_m, 1.0, 0.0}, floor{-(z + depth_m), 0.0, -1.0};
    const double rim_r = r - (radius_m + rim_m), rim_z = z + rim_m;
    if (rim_z > 0.0) {
      if (rim_r >= 0.0) return top;
      const double from_centre = std::sqrt(rim_r * rim_r + rim_z * rim_z);
      return larger({rim_m - from_centre, -rim_r / from_centre, -rim_z / from_centre}, floor);
    }
    if (floor.value_m < 0.0) return wall.value_m < 0.0 ? larger(wall, floor) : smaller(wall, top);
    if (wall.value_m <= 0.0) return floor;
    const double from_corner = std::sqrt(wall.value_m * wall.value_m + floor.value_m * floor.value_m);
    return smaller({from_corner, wall.value_m / from_corner, -floor.value_m / from_corner}, top);
  }
  ScalarSample operator()(const Vec3& x) const noexcept {
    const double r = std::sqrt(x.x * x.x + x.y * x.y);
    const Depth depth = at(r, x.z);
    const double across = r > 0.0 ? depth.along_radius / r : 0.0;
    return {depth.value_m, {across * x.x, across * x.y, depth.along_z}, true};
  }
};

}  // namespace

Volume bored_block(double radius_m, double depth_m, double rim_m) {
  check_length("the radius of a hole", radius_m);
  check_length("the depth of a hole", depth_m);
  check_length("the rounding of a hole's rim", rim_m);
  if (rim_m > depth_m) throw std::invalid_argument("a hole's rim is rounded by more than its depth; it must be less");
  const double half_m = 4.0 * radius_m, below_m = depth_m + 2.0 * radius_m;
  const BoredBlock block{radius_m, depth_m, rim_m};
  const double lowest_m = block.at(0.0, depth_m).value_m;
  const double highest_m = block.at(std::numbers::sqrt2 * half_m, -below_m).value_m;
  return volume_of("depth", "m", {{-half_m, -half_m, -below_m}, {half_m, half_m, depth_m}},
                   std::min(radius_m / 16.0, rim_m / 4.0), {{lowest_m, highest_m}}, block);
}

std::span<const AnalyticVolume> analytic_volumes() noexcept {
  static constexpr AnalyticVolume volumes[] = {
      {"plane", "a half space: depth below the plane z = 0, in metres", [] { return plane_field(); }},
      {"sphere", "a ball of 50 mm radius: depth below its surface, in metres", [] { return sphere_field(); }},
      {"bored_block", "a block with a hole of 11 mm and 30 mm deep, its rim rounded: depth below its surface, in metres",
       [] { return bored_block(); }},
      {"head_phantom", "a head as CT sees it: skin, skull, brain, air cavities, in HU", [] { return head_phantom(); }},
      {"lamb_oseen_vortex", "a decaying vortex along z with a core of 10 mm, in m/s", [] { return lamb_oseen_vortex(); }},
      {"burgers_vortex", "a vortex along z held steady by strain, core of 10 mm, in m/s", [] { return burgers_vortex(); }},
      {"ring_vortex", "blood in a heart's chamber: a vortex ring of 14 mm radius, in m/s, and the MR signal",
       [] { return ring_vortex(); }},
      {"wing_wake", "the air behind a wing of 3 m span: two tip vortices, in m/s, and the pressure",
       [] { return wing_wake(); }},
  };
  return volumes;
}

std::span<const AnalyticVolume> beating_volumes() noexcept {
  static constexpr AnalyticVolume volumes[] = {
      {"beating_chamber", "the chamber and the ring of `ring_vortex`, beating once in 0.8 s: its fields change with time",
       [] { return beating_chamber(); }},
  };
  return volumes;
}

const AnalyticVolume* analytic_volume(std::string_view name) noexcept {
  for (const std::span<const AnalyticVolume> volumes : {analytic_volumes(), beating_volumes()}) {
    const auto found = std::ranges::find(volumes, name, &AnalyticVolume::name);
    if (found != volumes.end()) return &*found;
  }
  return nullptr;
}

}  // namespace palpa
