#include "palpa/study/unyielding.h"

#include <algorithm>

#include "palpa/base/printed.h"
#include "palpa/mode/modes.h"

namespace palpa {
namespace {

double least_n(const Strength& strength, const FieldRef& field, double value) {
  if (strength.is_constant()) return strength.constant_n;
  if (strength.of == field) return std::min(strength.curve.at(value, TransferFunction::Side::below), strength.curve.at(value));
  double least = strength.curve.outside();
  for (const TransferFunction::Point& point : strength.curve.points()) least = std::min(least, point.result);
  return least;
}

}  // namespace

std::vector<UnyieldingLevel> unyielding_levels(const Scene& scene, double most_n) {
  std::vector<UnyieldingLevel> found;
  for (std::size_t m = 0; m < scene.modes().size(); ++m) {
    const SceneMode& mode = scene.modes()[m];
    const SurfaceAndFriction* surface = mode.mode.as<SurfaceAndFriction>();
    if (!mode.enabled || !surface) continue;
    for (const SurfaceAndFriction::Level& level : surface->levels) {
      const double bears_n = least_n(level.strength_n, surface->field, level.value);
      if (bears_n > most_n) found.push_back({m, level.name.empty() ? detail::text("%g", level.value) : level.name, bears_n});
    }
  }
  return found;
}

}  // namespace palpa
