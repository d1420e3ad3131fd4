#include "explorer/surface_finder.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "explorer/linked_levels.h"
#include "explorer/parameter_rows.h"
#include "palpa/scene/parts.h"
#include "palpa/view/layers.h"

namespace palpa::explorer {
namespace {

/// Ray interval inside a box, distances [m] from its start; empty if `first` is beyond `last`.
struct Interval {
  double first = 0.0, last = std::numeric_limits<double>::infinity();
};
Interval within(const Box& box, const Vec3& from_m, const Vec3& towards) {
  Interval interval;
  const double low[] = {box.low_m.x, box.low_m.y, box.low_m.z}, high[] = {box.high_m.x, box.high_m.y, box.high_m.z};
  const double from[] = {from_m.x, from_m.y, from_m.z}, way[] = {towards.x, towards.y, towards.z};
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(way[axis]) < 1e-12) {
      if (from[axis] < low[axis] || from[axis] > high[axis]) return {1.0, 0.0};
      continue;
    }
    const double a = (low[axis] - from[axis]) / way[axis], b = (high[axis] - from[axis]) / way[axis];
    interval.first = std::max(interval.first, std::min(a, b));
    interval.last = std::min(interval.last, std::max(a, b));
  }
  return interval;
}

// [1] Samples along a ray. More: slower; fewer: thin parts are missed.
constexpr double most_looks = 1500.0;
// [spacings] Over which normals are averaged. More: edges are pressed askew; less: noise turns the press.
constexpr double calm_spacings = 1.5;

bool feels_vectors(const Scene& scene) {
  for (const SceneMode& mode : scene.modes()) {
    for (const ParameterRow& row : rows_of([&](ParameterVisitor& v) { look_through(mode.mode, v); })) {
      const auto* field = std::get_if<FieldRef>(&row.value);
      if (field && !field->name.empty() && scene.field(*field).field->components() == 3) return true;
    }
  }
  return false;
}

/// [1] Mean unit gradient around a position, turned to the side of `towards`.
Vec3 normal_into(const Field& field, const Vec3& at_m, const Vec3& towards) {
  const double reach_m = calm_spacings * field.spacing_m();
  Vec3 sum = normalized(field.scalar(at_m).gradient);
  for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}})
    for (const double side : {-reach_m, reach_m}) sum += normalized(field.scalar(at_m + side * axis).gradient);
  const Vec3 normal = normalized(sum);
  if (norm_squared(normal) == 0.0) return towards;
  return dot(normal, towards) < 0.0 ? -normal : normal;
}

}  // namespace

SurfaceFinder::SurfaceFinder(const Scene& scene) {
  if (felt_levels(scene).empty() && feels_vectors(scene)) return;
  const std::vector<ViewLayer> layers = detail::layers_of(scene);
  for (std::size_t i = 0; i < layers.size(); ++i) {
    if (layers[i].show != ViewLayer::Show::surface) continue;
    const FieldPtr field = frozen(scene.field(layers[i].field).field, scene.time().at(0.0));
    surfaces_.push_back(
        {detail::in_hand_frame(field, scene.hand_to_world()), detail::surface_style(scene, layers, i, true).level});
  }
}

std::optional<SurfacePoint> SurfaceFinder::first(const Vec3& from_m, const Vec3& towards) const {
  const Field* hit = nullptr;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const Surface& surface : surfaces_) {
    const Interval interval = within(surface.field->bounds_m(), from_m, towards);
    if (!(interval.first < interval.last)) continue;
    const double step_m = std::max(0.5 * surface.field->spacing_m(), (interval.last - interval.first) / most_looks);
    const auto beyond = [&](double way_m, bool& inside) {
      const ScalarSample sample = surface.field->scalar(from_m + way_m * towards);
      inside = sample.inside;
      return sample.value - surface.level;
    };
    bool known = false;
    double before = 0.0, before_m = 0.0;
    for (double way_m = interval.first; way_m <= std::min(interval.last, nearest_m); way_m += step_m) {
      bool inside = false;
      const double now = beyond(way_m, inside);
      if (inside && known && (before < 0.0) != (now < 0.0)) {
        double low_m = before_m, high_m = way_m;
        for (int halving = 0; halving < 24; ++halving) {
          const double middle_m = 0.5 * (low_m + high_m);
          bool here = false;
          ((beyond(middle_m, here) < 0.0) == (before < 0.0) ? low_m : high_m) = middle_m;
        }
        if (high_m < nearest_m) nearest_m = high_m, hit = surface.field.get();
        break;
      }
      known = inside;
      before = now;
      before_m = way_m;
    }
  }
  if (!hit) return {};
  const Vec3 at_m = from_m + nearest_m * towards;
  return SurfacePoint{at_m, normal_into(*hit, at_m, towards)};
}

}  // namespace palpa::explorer
