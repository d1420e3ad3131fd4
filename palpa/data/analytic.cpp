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

std::span<const AnalyticVolume> analytic_volumes() noexcept {
  static constexpr AnalyticVolume volumes[] = {
      {"plane", "a half space: depth below the plane z = 0, in metres", [] { return plane_field(); }},
      {"sphere", "a ball of 50 mm radius: depth below its surface, in metres", [] { return sphere_field(); }},
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
