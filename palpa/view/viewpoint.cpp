// Viewpoints for pictures of a path or a moment.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "palpa/view/layers.h"
#include "palpa/view/picture.h"

namespace palpa {
namespace {

// Smallest force of a contact. Less: rounding counts; more: light contacts do not.
constexpr double contact_n = 1e-3;

/// Occlusion by the surfaces of a scene's picture.
class Sight {
 public:
  Sight(const Scene& scene, DataTime at) {
    const std::vector<ViewLayer> layers = detail::layers_of(scene);
    for (std::size_t i = 0; i < layers.size(); ++i) {
      if (layers[i].show != ViewLayer::Show::surface) continue;
      const FieldPtr field = scene.field(layers[i].field).field;
      if (field->components() != 1) continue;
      const detail::SurfaceStyle look = detail::surface_style(scene, layers, i, true);
      surfaces_.push_back(
          {detail::in_hand_frame(frozen(field, at), scene.hand_to_world()), look.level, look.opacity * look.opacity});
    }
  }

  /// Visibility of a position from direction `towards` [1], 0…1.
  double clear(const Vec3& p_m, const Vec3& towards) const {
    double clear = 1.0;
    for (const Surface& surface : surfaces_) {
      if (hides(surface, p_m, towards)) clear *= 1.0 - surface.hides;
    }
    return clear;
  }

 private:
  struct Surface {
    FieldPtr field;
    double level;
    double hides;  ///< [1] share of the background that it hides: 1 if opaque, little if translucent
  };

  static bool hides(const Surface& surface, const Vec3& p_m, const Vec3& towards) {
    const Box box = surface.field->bounds_m();
    const double way_m = norm(box.size_m());
    const double step_m = std::max(surface.field->spacing_m(), way_m / 200.0);
    int side = 0;
    for (double at_m = 2.0 * step_m; at_m < way_m; at_m += step_m) {
      const ScalarSample sample = surface.field->scalar(p_m + at_m * towards);
      const int now = !sample.inside ? 0 : sample.value > surface.level ? 1 : -1;
      if (side * now < 0) return true;
      side = now;
    }
    return false;
  }

  std::vector<Surface> surfaces_;
};

/// Directions to a viewer in front of the data who may lean to the sides, up and down; the default view first.
std::vector<Vec3> viewpoints() {
  constexpr double degree = std::numbers::pi / 180.0;
  std::vector<Vec3> directions{normalized(ScenePictureOptions{}.from)};
  for (double right = -50; right <= 50; right += 10) {
    for (double up = -20; up <= 50; up += 10) {
      directions.push_back({std::cos(up * degree) * std::sin(right * degree), std::sin(up * degree),
                            std::cos(up * degree) * std::cos(right * degree)});
    }
  }
  return directions;
}

/// Best viewpoint by `worth`, weighted down with distance from the default view.
template <class Worth>
Vec3 best_viewpoint(Worth worth) {
  const std::vector<Vec3> directions = viewpoints();
  Vec3 best = directions.front();
  double most = -1.0;
  for (const Vec3& direction : directions) {
    const double value = worth(direction) * (0.5 + 0.5 * dot(direction, directions.front()));
    if (value > most + 1e-9) {
      most = value;
      best = direction;
    }
  }
  return best;
}

/// True if the hand stayed in a plane across the line of sight of a user who looks straight on.
bool is_across(std::span<const PathPoint> path) {
  // [1] Depth over the longest side. More: motion in depth is invisible; less: tremor tilts the picture of a plane motion.
  constexpr double flat = 0.02;
  Vec3 low{1e300, 1e300, 1e300};
  Vec3 high = -low;
  for (const PathPoint& point : path) {
    const Vec3& p = point.probe_m;
    if (!is_finite(p)) continue;
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Vec3 size = high - low;
  return size.z <= flat * std::max(size.x, size.y);
}

}  // namespace

ScenePictureOptions overview(const Scene& scene, std::span<const PathPoint> path) {
  ScenePictureOptions options;
  if (scene.view.from) {
    options.from = scene.hand_to_world().direction_to_hand(*scene.view.from);
    return options;
  }
  if (path.empty()) return options;
  if (is_across(path)) {
    options.from = {0, 0, 1};
    return options;
  }
  // [1] Contact positions tried from each viewpoint. More: slower; fewer: a worse viewpoint.
  constexpr std::size_t most = 48;
  std::vector<Vec3> felt;
  for (const PathPoint& point : path) {
    if (is_finite(point.proxy_m) && norm(point.force_n) > contact_n) felt.push_back(point.proxy_m);
  }
  if (felt.empty()) return options;
  std::vector<Vec3> some;
  for (std::size_t i = 0; i < std::min(most, felt.size()); ++i)
    some.push_back(felt[i * felt.size() / std::min(most, felt.size())]);
  Vec3 middle;
  for (const Vec3& p : some) middle += p / static_cast<double>(some.size());
  const Sight sight(scene, scene.time().at(0.0));
  options.from = best_viewpoint([&](const Vec3& towards) {
    double clear = 0.0, spread = 0.0, seen = 1e-300;
    for (const Vec3& p : some) {
      clear += sight.clear(p, towards) / static_cast<double>(some.size());
      const double along = dot(p - middle, towards);
      spread += norm_squared(p - middle) - along * along;
      seen += norm_squared(p - middle);
    }
    return clear * (0.5 + 0.5 * spread / seen);
  });
  return options;
}

ScenePictureOptions close_up(const Scene& scene, const Moment& moment) {
  // [rad] Wanted angle between spring and line of sight. More: planes, which lie across the spring, appear edge-on; less: the
  // spring, and lines along it, appear end-on.
  constexpr double oblique = std::numbers::pi / 3.0;
  const Vec3 spring = normalized(moment.probe_m - moment.proxy_m);
  const Sight sight(scene, scene.time().at(moment.time_s));
  ScenePictureOptions options;
  options.from = best_viewpoint([&](const Vec3& towards) {
    const double angle = std::acos(std::min(std::abs(dot(spring, towards)), 1.0));
    return (0.2 + sight.clear(moment.proxy_m, towards)) * (1.0 - 0.5 * std::abs(angle - oblique));
  });
  options.half_height_m = std::clamp(12.0 * distance(moment.probe_m, moment.proxy_m), 0.02, 0.06);
  // All feet of a tool, whose middle is about half of its reach away, with a margin.
  const Tool tool(scene.tool(), scene.coupling());
  options.half_height_m = std::max(options.half_height_m, 0.7 * tool.reach_m());
  return options;
}

}  // namespace palpa
