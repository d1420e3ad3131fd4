// Surfaces: in-trajectories over smooth shapes, grooves, thin parts, friction, shells, drift.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/haptics/cases.h"
#include "bench/haptics/surface_hands.h"

namespace palpa::haptics {

using nlohmann::json;

namespace {

const std::vector<std::string> on_surfaces{"surface", "direction", "force", "lost", "rest", "ripple"};
const std::vector<std::string> on_thin_parts{"direction", "force", "lost", "ripple"};

void add_in_trajectory(Suite& suite, const std::string& family, const Body& body, const Walk& walk, const Sampling& sampling,
                       bool quick = false) {
  add_surface_case(suite, body, sampling,
                   {.name = body.name + format_sampling(sampling),
                    .family = family,
                    .shape = body.shape,
                    .scores = on_surfaces,
                    .touches = in_trajectory(body, walk),
                    .quick = quick});
}

void add_smooth(Suite& suite) {
  const Walk over_bumps = over_bumpy();
  const Sampling fine{};
  add_in_trajectory(suite, "surfaces", plane, over_plane, fine);
  add_in_trajectory(suite, "surfaces", sphere, over_sphere, fine);
  add_in_trajectory(suite, "surfaces", bumpy, over_bumps, fine);
  add_in_trajectory(suite, "surfaces", torus, over_torus, fine);
  const Sampling soft{.ramp_voxels = 9};  // 5 mm, more than any hand's depth
  add_in_trajectory(suite, "ramps", plane, over_plane, soft);
  add_in_trajectory(suite, "ramps", sphere, over_sphere, soft);
  add_in_trajectory(suite, "ramps", bumpy, over_bumps, soft);
  add_in_trajectory(suite, "ramps", torus, over_torus, soft);
  add_in_trajectory(suite, "sampling", bumpy, over_bumps, {.samples = 48, .bits = 8}, true);
  add_in_trajectory(suite, "sampling", bumpy, over_bumps, {.samples = 64, .bits = 8});
  add_in_trajectory(suite, "sampling", bumpy, over_bumps, {.samples = 128, .bits = 8});
  add_in_trajectory(suite, "sampling", bumpy, over_bumps, {.samples = 256, .bits = 8});
  add_in_trajectory(suite, "sampling", bumpy, over_bumps, {.samples = 128, .bits = 16});
  add_in_trajectory(suite, "sampling", torus, over_torus, {.samples = 64, .bits = 8});
  add_in_trajectory(suite, "noise", bumpy, over_bumps, {.noise = 0.01});
  add_in_trajectory(suite, "noise", bumpy, over_bumps, {.noise = 0.03});
  add_in_trajectory(suite, "noise", torus, over_torus, {.samples = 64, .noise = 0.03});
}

void add_groove(Suite& suite, int opening_deg, bool quick) {
  const Body groove{"groove-" + std::to_string(opening_deg),
                    {{"kind", "groove"}, {"opening_deg", opening_deg}, {"turn", {3, 1, -2, 1}}}};
  const Sampling sampling{.edge_m = 0.048};  // filters and voxels raise the bottom: finer than elsewhere
  add_surface_case(suite, groove, sampling,
                   {.name = groove.name,
                    .family = "grooves",
                    .shape = groove.shape,
                    .scores = on_surfaces,
                    .touches = into_groove(groove.shape),
                    .quick = quick});
}

void add_knife(Suite& suite, int opening_deg) {
  const Body knife{"knife-" + std::to_string(opening_deg),
                   {{"kind", "wedge"}, {"opening_deg", opening_deg}, {"turn", {3, -1, 1, 1}}}};
  add_surface_case(suite, knife, {.edge_m = 0.064},
                   {.name = knife.name, .family = "thin", .scores = on_thin_parts, .touches = over_knife(knife.shape)});
}

void add_plate(Suite& suite, const std::string& name, double thickness_m, bool quick) {
  const Body plate{name, {{"kind", "plate"}, {"thickness_m", thickness_m}, {"turn", {4, 1, 2, -1}}}};
  add_surface_case(
      suite, plate, {.samples = 64, .edge_m = 0.064},
      {.name = name, .family = "thin", .scores = on_thin_parts, .touches = through_plate(plate.shape), .quick = quick});
}

void add_friction(Suite& suite, const std::string& name, double coefficient, const Sampling& sampling, bool quick = false) {
  add_surface_case(suite, plane, sampling,
                   {.name = name,
                    .family = "friction",
                    .rule = surface_rule(sampling, coefficient),
                    .shape = plane.shape,
                    .scores = {"surface", "force", "lost", "friction", "rest", "ripple"},
                    .touches = with_friction(coefficient),
                    .quick = quick,
                    .friction_deg = std::round(1e6 * std::atan(coefficient) * 180.0 / std::numbers::pi) / 1e6});
}

void add_shells(Suite& suite, const std::string& name, double noise, bool quick) {
  json levels = json::array();
  for (const Shell& shell : shells) {
    const bool holds = &shell == std::end(shells) - 1;
    levels.push_back({{"value", 900 + 1000 * levels.size()}, {"strength_n", holds ? json(nullptr) : json(shell.strength_n)}});
  }
  suite.volumes[name] = [=] {
    constexpr double ramp_m = 2e-3;
    SampledVolume volume{.grid = cube(96, 0.072), .type = "uint16"};
    Noise random(7);
    volume.grid.each([&](const Vec3& x_m) {
      const double r = norm(x_m);
      double value = 400.0;
      for (const Shell& shell : shells) value += 500.0 + 500.0 * std::clamp((shell.radius_m - r) / ramp_m, -1.0, 1.0);
      if (noise > 0.0) value += 1000.0 * noise * random.next();
      volume.samples.push_back(static_cast<float>(std::round(std::clamp(value, 0.0, 4095.0))));
    });
    return volume;
  };
  suite.cases.push_back({.name = name,
                         .family = "shells",
                         .volume = name,
                         .rule = {{"kind", "surface"}, {"solid", "high"}, {"levels", levels}, {"friction_coefficient", 0}},
                         .shape = nullptr,
                         .scores = {"direction", "force", "lost", "break", "rest", "ripple"},
                         .touches = through_shells(),
                         .quick = quick});
}

void add_round(Suite& suite, const Body& body, const Walk& around, int period_ticks, int turns, const Sampling& sampling,
               bool quick = false) {
  add_surface_case(suite, body, sampling,
                   {.name = body.name + "-turns" + format_sampling(sampling),
                    .family = "turns",
                    .shape = body.shape,
                    .scores = {"surface", "direction", "force", "drift", "energy", "ripple"},
                    .touches = round_and_round(body, around, period_ticks, turns),
                    .quick = quick,
                    .period_ticks = period_ticks});
}

void add_rounds(Suite& suite) {
  constexpr int sphere_ticks = 785, torus_ticks = 283;  // 0.2 m/s
  add_round(suite, sphere, around_sphere, sphere_ticks, 6, {});
  add_round(suite, torus, through_torus, torus_ticks, 12, {});
  add_round(suite, sphere, around_sphere, sphere_ticks, 3, {.samples = 48, .bits = 8}, true);
  add_round(suite, sphere, around_sphere, sphere_ticks, 6, {.samples = 64, .noise = 0.03});
}

}  // namespace

void add_surface_cases(Suite& suite) {
  add_smooth(suite);
  add_groove(suite, 30, false);
  add_groove(suite, 60, true);
  add_groove(suite, 90, false);
  add_knife(suite, 30);
  add_knife(suite, 60);
  add_plate(suite, "plate-1.5voxels", 1.5e-3, false);
  add_plate(suite, "plate-3voxels", 3e-3, true);
  add_friction(suite, "friction-0.3", 0.3, {});
  add_friction(suite, "friction-0.6", 0.6, {});
  add_friction(suite, "friction-0.3-64-8bit", 0.3, {.samples = 64, .bits = 8}, true);
  add_friction(suite, "friction-0.3-noise3", 0.3, {.samples = 64, .noise = 0.03});
  add_shells(suite, "shells", 0.0, true);
  add_shells(suite, "shells-noise3", 0.03, false);
  add_rounds(suite);
}

}  // namespace palpa::haptics
