#include "tests/path/surfaces.h"

#include <chrono>
#include <cmath>
#include <numbers>

#include "palpa/field/filter.h"
#include "palpa/mode/surface_and_friction.h"
#include "tests/core/random_problems.h"

namespace palpa::test {

namespace {

constexpr double dt = 1e-3;
constexpr double degree = std::numbers::pi / 180.0;

Scene surface_scene(const FieldPtr& field, double strength_n, double stiffness_n_per_m = 800.0) {
  Scene scene = plain_scene({.stiffness_n_per_m = stiffness_n_per_m});
  const FieldRef solid = scene.add("solid", volume_of(field));
  scene.add("surface",
            SurfaceAndFriction{.field = solid, .levels = {{.name = "skin", .value = 0.0, .strength_n = strength_n}}});
  return scene;
}

double angle_deg(const Vec3& a, const Vec3& b) { return std::atan2(norm(cross(a, b)), dot(a, b)) / degree; }

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

double restless_m(const Session& session, Session& spare, const Vec3& probe_m) {
  spare.continue_from(session);
  spare.tick({.position_m = probe_m}, dt);
  if (spare.sub_steps().empty()) return 0.0;
  const SubStep& next = spare.sub_steps().front();
  const double moved_m = distance(next.proxy_m, next.start_m);
  return next.stop == Stop::full ? moved_m : std::max(moved_m, distance(next.balance.position_m, next.start_m));
}

FieldPtr sampled_sphere(Filter filter) {
  const Depth depth = [](const Vec3& x) { return drift_sphere_m - norm(x); };
  return sampled_depth(depth, cube_of(114, 1e-3), {.bits = 12, .ramp_voxels = 3.0}, filter);
}

Drift measure_drift(const FieldPtr& field, const DriftCase& wanted) {
  const Scene scene = surface_scene(field, 10.0);
  const double radius_m = drift_sphere_m - 1e-3;
  const int ticks = static_cast<int>(std::ceil(2.0 * std::numbers::pi * radius_m / (0.4 * dt)));  // whole ticks a turn
  Random random(1);
  Drift drift;
  std::vector<double> off;
  for (int plane = 0; plane < wanted.planes; ++plane) {
    const Mat3 turn = random.rotation();
    Session session(scene);
    session.tick({.position_m = turn * Vec3{drift_sphere_m + 2e-3, 0, 0}}, dt);
    for (int i = 1; i <= 20; ++i) session.tick({.position_m = turn * Vec3{drift_sphere_m + 2e-3 - 1.5e-4 * i, 0, 0}}, dt);
    Vec3 after_first;
    for (int t = 0; t < wanted.turns + 1; ++t) {
      Tick tick;
      for (int i = 1; i <= ticks; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / ticks;
        tick = session.tick({.position_m = turn * Vec3{radius_m * std::cos(angle), radius_m * std::sin(angle), 0}}, dt);
        off.push_back(std::abs(norm(tick.proxy_m) - drift_sphere_m));
      }
      if (t == 0) after_first = tick.proxy_m;
      if (t == wanted.turns) drift.per_turn_m = std::max(drift.per_turn_m, distance(tick.proxy_m, after_first) / wanted.turns);
    }
  }
  drift.off_p50_m = quantile(off, 0.5);
  drift.off_p99_m = quantile(off, 0.99);
  return drift;
}

Bumpy measure_bumpy(const BumpyCase& wanted) {
  // 0.6 of the cube's edge are 50 mm of hand, as in CHAI3D's examples on a device of that reach.
  const double edge_m = 0.05 / 0.6;
  const double voxel_m = edge_m / wanted.voxels;
  const BumpySphere sphere(0.30 * edge_m);
  const auto depth = [&](const Vec3& x) {
    const double r = norm(x);
    const double ramp_m = 9.0 * voxel_m + 0.06 * 0.30 * edge_m;
    if (std::abs(r - 0.30 * edge_m) > 1.2 * ramp_m) return 0.30 * edge_m - r;
    return sphere.depth_m(x);
  };
  const FieldPtr voxels =
      sampled_depth(depth, cube_of(wanted.voxels, voxel_m), {.bits = 8, .ramp_voxels = 8.0}, Filter::trilinear);

  const auto begin = std::chrono::steady_clock::now();
  const FieldPtr field = filtered(voxels, wanted.filter);
  Session session(surface_scene(field, 100.0));
  const Vec3 first{0, 0, 0.40 * edge_m};
  session.tick({.position_m = first}, dt);
  Bumpy bumpy;
  bumpy.preparation_s = seconds_since(begin);

  // Approach in a line, then a glide along a curve that comes round everywhere, depth between −0.005 and 0.035 edges.
  const auto at = [&](double angle, double time_s) {
    const double polar = 0.5 * std::numbers::pi + 1.2 * std::sin(0.377 * angle);
    const Vec3 n{std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle), std::cos(polar)};
    const double depth_m = edge_m * (0.015 - 0.020 * std::cos(2.0 * std::numbers::pi * 0.5 * time_s));
    return (sphere.reach_m(n) - depth_m) * n;
  };
  const double step_m = wanted.speed_m_per_s * dt;
  Vec3 probe = first;
  double angle = 0.0, glide_s = 0.0;
  bool gliding = false;
  std::vector<double> surface, ideal, direction, ideal_direction, still_direction;
  double sub_steps = 0.0;
  for (int i = 0; i < wanted.ticks; ++i) {
    if (!gliding) {
      const Vec3 goal = at(0.0, 0.0);
      gliding = distance(goal, probe) <= step_m;
      probe = gliding ? goal : probe + step_m * normalized(goal - probe);
    } else {
      glide_s += dt;
      const double turn_m = distance(at(angle + 1e-4, glide_s), at(angle, glide_s)) / 1e-4;
      angle += step_m / turn_m;
      probe = at(angle, glide_s);
    }
    const Tick tick = session.tick({.position_m = probe}, dt);
    sub_steps += tick.sub_steps;
    if (sphere.depth_m(probe) <= 0.0) continue;
    const Vec3 ideal_m = sphere.nearest_m(probe);
    if (distance(ideal_m, probe) <= voxel_m) continue;
    ++bumpy.contact_ticks;
    const Vec3 under_proxy = sphere.nearest_m(tick.proxy_m);
    surface.push_back(distance(under_proxy, tick.proxy_m) / voxel_m);
    ideal.push_back(distance(ideal_m, tick.proxy_m) / voxel_m);
    bumpy.stray_ticks += ideal.back() > 5.0;
    direction.push_back(angle_deg(tick.force_n, sphere.normal(under_proxy)));
    ideal_direction.push_back(angle_deg(tick.force_n, sphere.normal(ideal_m)));
    still_direction.push_back(angle_deg(-field->scalar(ideal_m).gradient, sphere.normal(ideal_m)));
  }
  bumpy.surface_p50_voxels = quantile(surface, 0.5);
  bumpy.surface_p99_voxels = quantile(surface, 0.99);
  bumpy.ideal_p50_voxels = quantile(ideal, 0.5);
  bumpy.ideal_p99_voxels = quantile(ideal, 0.99);
  bumpy.direction_p50_deg = quantile(direction, 0.5);
  bumpy.direction_p99_deg = quantile(direction, 0.99);
  bumpy.ideal_direction_p99_deg = quantile(ideal_direction, 0.99);
  bumpy.still_direction_p99_deg = quantile(still_direction, 0.99);
  bumpy.sub_steps_mean = sub_steps / wanted.ticks;
  return bumpy;
}

Groove measure_groove(const GrooveCase& wanted) {
  constexpr double voxel_m = 1e-3, k = 800.0, strength_n = 4.0;
  const double opening = wanted.opening_deg * degree;
  const double press_m = 0.85 * strength_n * std::sin(0.5 * opening) / k;
  Random random(wanted.seed);
  Groove groove_found;
  std::vector<double> jumps, sub_steps;
  int restless = 0, restless_still = 0, still_ticks = 0;
  for (int o = 0; o < wanted.orientations; ++o) {
    // The groove lies anyhow in the grid: its bottom along `along`, through `bottom`.
    const Mat3 turn = random.rotation();
    const Vec3 bottom = random.in_cube(0.5 * voxel_m);
    const Depth upright = groove(opening);
    const Depth depth = [&](const Vec3& x) { return upright(transposed(turn) * (x - bottom)); };
    const FieldPtr field =
        sampled_depth(depth, cube_of(44, voxel_m), {.bits = 12, .ramp_voxels = wanted.binary ? 0.0 : 3.0}, wanted.filter);
    const Scene scene = surface_scene(field, strength_n, k);
    Session session(scene), spare(scene);

    Vec3 force_before;
    Vec3 probe;
    const auto go_to = [&](const Vec3& in_groove, bool pressed, bool still) {
      probe = bottom + turn * in_groove;
      const Tick tick = session.tick({.position_m = probe}, dt);
      if (!pressed) {
        force_before = tick.force_n;
        return;
      }
      ++groove_found.ticks;
      sub_steps.push_back(tick.sub_steps);
      jumps.push_back(norm(tick.force_n - force_before));
      force_before = tick.force_n;
      const ScalarSample under = field->scalar(probe);
      groove_found.lost_ticks += norm(tick.force_n) < 1e-3 && under.value > 0.05 * voxel_m * norm(under.gradient);
      const bool moves = tick.status == TickStatus::waiting || restless_m(session, spare, probe) > 1e-3 * voxel_m;
      restless += moves;
      restless_still += still && moves;
      still_ticks += still;
    };
    // Where the level's bottom really is: filters and voxels raise it, more the narrower the groove.
    const auto bottom_at = [&](double z) {
      double highest = -1e-2;
      for (double around = -voxel_m; around <= voxel_m; around += 0.25 * voxel_m) {
        double y = 8e-3;
        while (y > highest && field->scalar(bottom + turn * Vec3{0, y, z + around}).value < 0.0) y -= 0.02 * voxel_m;
        highest = std::max(highest, y);
      }
      return highest;
    };
    // In from above at 5 cm/s, a little to one side, until the bottom is pressed.
    const double aside_m = random.uniform(-0.1, 0.1) * voxel_m;
    const double first_bottom_m = bottom_at(0.0);
    for (double y = 8e-3; y > first_bottom_m - press_m; y -= 0.05 * dt) {
      go_to({aside_m, y, 0}, y < first_bottom_m - 0.5 * press_m, false);
    }
    const int hold = 100;
    for (int i = 0; i < hold; ++i) go_to({aside_m, first_bottom_m - press_m, 0}, true, true);
    // Along the groove at 5 cm/s, swaying across it.
    for (int i = 1; i <= 240; ++i) {
      const double z = 0.05 * dt * i;
      const double x = aside_m + 0.1 * voxel_m * std::sin(2.0 * std::numbers::pi * z / 5e-3);
      go_to({x, bottom_at(z) - press_m * (1.0 - 1e-3 * i), z}, true, false);
    }
    for (int i = 0; i < hold; ++i) go_to(transposed(turn) * (probe - bottom), true, true);
  }
  groove_found.never_rest_share = static_cast<double>(restless) / groove_found.ticks;
  groove_found.restless_still_share = static_cast<double>(restless_still) / still_ticks;
  groove_found.sub_steps_p99 = quantile(sub_steps, 0.99);
  groove_found.force_jump_p99_n = quantile(jumps, 0.99);
  groove_found.force_jump_max_n = quantile(jumps, 1.0);
  return groove_found;
}

}  // namespace palpa::test
