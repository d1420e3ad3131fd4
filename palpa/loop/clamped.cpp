#include <algorithm>
#include <cmath>

#include "palpa/base/printed.h"
#include "palpa/loop/loop.h"

namespace palpa {
namespace {

// A device without stiffness still needs a turning radius above zero. Larger: it may exceed the device's stiffness; smaller:
// rounding in the balance of torques.
constexpr double least_turning_radius_m = 1e-4;

/// Lowers the turning radius and the damping of turning of a tool to the device's limits.
void clamp_turning(Scene& scene, const DeviceLimits& limits) {
  const Tool tool(scene.tool(), scene.coupling());
  if (tool.is_point()) return;
  const double stiffness_n_per_m = scene.coupling().stiffness_n_per_m;
  double radius_m = tool.turning_radius_m();
  if (stiffness_n_per_m * radius_m * radius_m > limits.max_turn_stiffness_nm_per_rad) {
    radius_m = std::max(least_turning_radius_m, std::sqrt(limits.max_turn_stiffness_nm_per_rad / stiffness_n_per_m));
    scene.edit<ToolOptions>([&](auto& options) { options.turning_radius_m = radius_m; });
  }
  const double damping_nms_per_rad =
      scene.coupling().turn_damping_nms_per_rad.value_or(scene.coupling().damping_ns_per_m * radius_m * radius_m);
  if (damping_nms_per_rad > limits.max_turn_damping_nms_per_rad)
    scene.edit<CouplingOptions>(
        [&](auto& coupling) { coupling.turn_damping_nms_per_rad = limits.max_turn_damping_nms_per_rad; });
}

}  // namespace

Scene clamped_to(Scene scene, const DeviceLimits& limits) {
  scene.edit<CouplingOptions>([&](auto& coupling) {
    coupling.stiffness_n_per_m = std::min(coupling.stiffness_n_per_m, limits.max_stiffness_n_per_m);
    coupling.damping_ns_per_m = std::min(coupling.damping_ns_per_m, limits.max_damping_ns_per_m);
  });
  clamp_turning(scene, limits);
  return scene;
}

std::vector<TakenLimit> taken_limits(const Scene& scene, const Scene& clamped) {
  std::vector<TakenLimit> taken;
  const auto note = [&](double wanted, double held, std::string path, const char* unit) {
    if (wanted == held) return;
    taken.push_back({path, held,
                     detail::text("%s: the scene has %g %s, the device allows %g %s, which is used.", path.c_str(), wanted,
                                  unit, held, unit)});
  };
  const CouplingOptions& asked = scene.coupling();
  const CouplingOptions& held = clamped.coupling();
  const std::string of_tool = scene.hands().empty() ? "tool." : "hand." + scene.hands().front().name + ".tool.";
  note(asked.stiffness_n_per_m, held.stiffness_n_per_m, "coupling.stiffness_n_per_m", "N/m");
  note(asked.damping_ns_per_m, held.damping_ns_per_m, "coupling.damping_ns_per_m", "N·s/m");
  if (scene.tool() != clamped.tool())
    note(Tool(scene.tool(), asked).turning_radius_m(), *clamped.tool().turning_radius_m, of_tool + "turning_radius_m", "m");
  if (asked.turn_damping_nms_per_rad != held.turn_damping_nms_per_rad) {
    const double radius_m = Tool(scene.tool(), asked).turning_radius_m();
    note(asked.turn_damping_nms_per_rad.value_or(asked.damping_ns_per_m * radius_m * radius_m), *held.turn_damping_nms_per_rad,
         "coupling.turn_damping_nms_per_rad", "N·m·s/rad");
  }
  return taken;
}

}  // namespace palpa
