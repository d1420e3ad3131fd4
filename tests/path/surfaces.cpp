#include "tests/path/surfaces.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "palpa/data/filter.h"
#include "palpa/data/sampled.h"
#include "palpa/mode/modes.h"
#include "tests/solver/random_problems.h"

namespace palpa::test {

namespace {

constexpr double period_s = 1e-3;
constexpr double degree = std::numbers::pi / 180.0;

Scene surface_scene(const FieldPtr& field, double strength_n, double stiffness_n_per_m = 800.0) {
  Scene scene = plain_scene({.stiffness_n_per_m = stiffness_n_per_m});
  const FieldRef solid = scene.add("solid", volume_of(field), {}, filter_of(*field));
  scene.add("surface",
            SurfaceAndFriction{.field = solid, .levels = {{.name = "skin", .value = 0.0, .strength_n = strength_n}}});
  return scene;
}

double angle_deg(const Vec3& a, const Vec3& b) { return std::atan2(norm(cross(a, b)), dot(a, b)) / degree; }

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// The sub-step of a break-through in the last tick.
const SubStep& break_through_step(const Session& session, const SessionEvent& event) {
  const auto off_m = [&](const SubStep& step) {
    return std::abs(distance(step.balance.position_m, step.probe_m) - event.depth_m);
  };
  return *std::ranges::min_element(session.sub_steps(), {}, off_m);
}

}  // namespace

double restless_m(const Session& session, Session& spare, const Vec3& probe_m) {
  spare.copy_state_from(session);
  spare.tick({.position_m = probe_m}, period_s);
  if (spare.sub_steps().empty()) return 0.0;
  const SubStep& next = spare.sub_steps().front();
  const double moved_m = distance(next.proxy_m, next.start_m);
  return next.stop == Stop::full ? moved_m : std::max(moved_m, distance(next.balance.position_m, next.start_m));
}

bool could_be_nearer(const Field& solid, double voxel_m, const Vec3& proxy_m, const Vec3& probe_m, Random& random) {
  constexpr int tries = 1600;
  const double near_m = distance(proxy_m, probe_m) - 0.01 * voxel_m;
  const double deepest = std::max(0.0, solid.scalar(proxy_m).value);  // the proxy itself may be inside by rounding
  for (int i = 0; i < tries; ++i) {
    Vec3 ahead = random.direction();
    if (dot(ahead, probe_m - proxy_m) < 0.0) ahead = -ahead;
    const double length_m = random.uniform(0.01, 0.45) * voxel_m;
    const Vec3 place = proxy_m + length_m * ahead;
    if (distance(place, probe_m) >= near_m || solid.scalar(place).value > 0.0) continue;
    const int pieces = static_cast<int>(std::ceil(length_m / (0.02 * voxel_m)));
    bool free = true;
    for (int piece = 1; piece < pieces && free; ++piece) {
      free = solid.scalar(proxy_m + static_cast<double>(piece) / pieces * (place - proxy_m)).value <= deepest;
    }
    if (free) return true;
  }
  return false;
}

FieldPtr sampled_sphere(Filter filter) {
  const Depth depth = [](const Vec3& x) { return drift_sphere_m - norm(x); };
  return sampled_depth(depth, cube_of(114, 1e-3), {.bits = 12, .ramp_voxels = 3.0}, filter);
}

Drift measure_drift(const FieldPtr& field, const DriftCase& wanted) {
  const Scene scene = surface_scene(field, 10.0);
  const double radius_m = drift_sphere_m - 1e-3;
  const int ticks = static_cast<int>(std::ceil(2.0 * std::numbers::pi * radius_m / (0.4 * period_s)));  // whole ticks per turn
  Random random(1);
  Drift drift;
  std::vector<double> off;
  for (int plane = 0; plane < wanted.planes; ++plane) {
    const Mat3 turn = random.rotation();
    Session session(scene);
    session.tick({.position_m = turn * Vec3{drift_sphere_m + 2e-3, 0, 0}}, period_s);
    for (int i = 1; i <= 20; ++i) session.tick({.position_m = turn * Vec3{drift_sphere_m + 2e-3 - 1.5e-4 * i, 0, 0}}, period_s);
    Vec3 after_first;
    for (int t = 0; t < wanted.turns + 1; ++t) {
      Tick tick;
      for (int i = 1; i <= ticks; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / ticks;
        tick = session.tick({.position_m = turn * Vec3{radius_m * std::cos(angle), radius_m * std::sin(angle), 0}}, period_s);
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
  session.tick({.position_m = first}, period_s);
  Bumpy bumpy;
  bumpy.preparation_s = seconds_since(begin);

  // Approach in a line, then a glide along a curve that covers the sphere, depth between −0.005 and 0.035 edges.
  const auto at = [&](double angle, double time_s) {
    const double polar = 0.5 * std::numbers::pi + 1.2 * std::sin(0.377 * angle);
    const Vec3 n{std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle), std::cos(polar)};
    const double depth_m = edge_m * (0.015 - 0.020 * std::cos(2.0 * std::numbers::pi * 0.5 * time_s));
    return (sphere.reach_m(n) - depth_m) * n;
  };
  const double step_m = wanted.speed_m_per_s * period_s;
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
      glide_s += period_s;
      const double turn_m = distance(at(angle + 1e-4, glide_s), at(angle, glide_s)) / 1e-4;
      angle += step_m / turn_m;
      probe = at(angle, glide_s);
    }
    const Tick tick = session.tick({.position_m = probe}, period_s);
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

namespace {

constexpr double groove_voxel_m = 1e-3, groove_n_per_m = 800.0, groove_strength_n = 4.0;

struct GrooveTicks {
  Groove groove;
  std::vector<double> jumps, sub_steps;
  int restless = 0, restless_still = 0, still = 0;
};

// A groove at a random pose in the grid, its bottom along `turn_`'s third column, through `bottom_`; and a hand in it.
class GrooveRun {
 public:
  GrooveRun(const GrooveCase& wanted, Random& random, Random& tries, GrooveTicks& ticks)
      : press_m_(0.85 * groove_strength_n * std::sin(0.5 * wanted.opening_deg * degree) / groove_n_per_m),
        turn_(random.rotation()),
        bottom_(random.in_cube(0.5 * groove_voxel_m)),
        field_(sampled(wanted)),
        session_(surface_scene(field_, groove_strength_n, groove_n_per_m)),
        spare_(session_.scene()),
        aside_m_(random.uniform(-0.1, 0.1) * groove_voxel_m),
        tries_(&tries),
        ticks_(&ticks) {}

  void feel() {
    constexpr double step_m = 0.05 * period_s;  // 5 cm/s
    constexpr int hold = 100;
    // In from above, a little to one side, until the bottom is pressed.
    const double first_bottom_m = bottom_at(0.0);
    for (double y = 8e-3; y > first_bottom_m - press_m_; y -= step_m) {
      go_to({aside_m_, y, 0}, y < first_bottom_m - 0.5 * press_m_, false);
    }
    Vec3 last{aside_m_, first_bottom_m - press_m_, 0};
    for (int i = 0; i < hold; ++i) go_to(last, true, true);
    // Along the groove, swaying across it.
    for (int i = 1; i <= 240; ++i) {
      const double z = step_m * i;
      const double x = aside_m_ + 0.1 * groove_voxel_m * std::sin(2.0 * std::numbers::pi * z / 5e-3);
      last = {x, bottom_at(z) - press_m_ * (1.0 - 1e-3 * i), z};
      go_to(last, true, false);
    }
    for (int i = 0; i < hold; ++i) go_to(last, true, true);
  }

 private:
  FieldPtr sampled(const GrooveCase& wanted) const {
    const Depth upright = groove(wanted.opening_deg * degree);
    const Depth depth = [&](const Vec3& x) { return upright(transposed(turn_) * (x - bottom_)); };
    const Sampling sampling{.bits = 12, .ramp_voxels = wanted.binary ? 0.0 : 3.0};
    return sampled_depth(depth, cube_of(44, groove_voxel_m), sampling, wanted.filter);
  }

  // The level's true bottom: filters and voxels raise it, more in narrow grooves.
  double bottom_at(double z) const {
    double highest = -1e-2;
    for (double around = -groove_voxel_m; around <= groove_voxel_m; around += 0.25 * groove_voxel_m) {
      double y = 8e-3;
      while (y > highest && field_->scalar(bottom_ + turn_ * Vec3{0, y, z + around}).value < 0.0) y -= 0.02 * groove_voxel_m;
      highest = std::max(highest, y);
    }
    return highest;
  }

  void go_to(const Vec3& in_groove, bool pressed, bool still) {
    const Vec3 probe = bottom_ + turn_ * in_groove;
    const Tick tick = session_.tick({.position_m = probe}, period_s);
    if (pressed) {
      ++ticks_->groove.ticks;
      ticks_->sub_steps.push_back(tick.sub_steps);
      ticks_->jumps.push_back(norm(tick.force_n - force_before_n_));
      const ScalarSample under = field_->scalar(probe);
      const bool inside = under.value > 0.05 * groove_voxel_m * norm(under.gradient);
      ticks_->groove.lost_ticks += norm(tick.force_n) < felt_n && inside;
      const bool moves = tick.status == TickStatus::waiting || restless_m(session_, spare_, probe) > 1e-3 * groove_voxel_m;
      ticks_->restless += moves;
      ticks_->restless_still += still && moves;
      ticks_->still += still;
      audit(tick);
    }
    force_before_n_ = tick.force_n;
  }

  void audit(const Tick& tick) {
    Groove& found = ticks_->groove;
    if (tick.status == TickStatus::complete && found.ticks % 5 == 0 && norm(tick.force_n) > felt_n) {
      ++found.audited;
      found.false_rests += could_be_nearer(*field_, groove_voxel_m, tick.proxy_m, tick.probe_m, *tries_);
    }
    for (const SessionEvent& event : session_.events()) {
      if (event.kind != SessionEventKind::break_through) continue;
      ++found.break_throughs;
      const SubStep& step = break_through_step(session_, event);
      const bool still_on_it = field_->scalar(step.proxy_m).value < 0.02 * groove_voxel_m;
      const Vec3& stood_m = still_on_it ? step.proxy_m : step.start_m;
      found.false_break_throughs += could_be_nearer(*field_, groove_voxel_m, stood_m, step.probe_m, *tries_);
    }
  }

  static constexpr double felt_n = 1e-3;
  double press_m_;
  Mat3 turn_;
  Vec3 bottom_;
  FieldPtr field_;
  Session session_, spare_;
  double aside_m_;
  Vec3 force_before_n_;
  Random* tries_;
  GrooveTicks* ticks_;
};

}  // namespace

Groove measure_groove(const GrooveCase& wanted) {
  Random random(wanted.seed), tries(wanted.seed + 1);
  GrooveTicks ticks;
  for (int o = 0; o < wanted.orientations; ++o) GrooveRun(wanted, random, tries, ticks).feel();
  Groove& found = ticks.groove;
  found.never_rest_share = static_cast<double>(ticks.restless) / found.ticks;
  found.restless_still_share = static_cast<double>(ticks.restless_still) / ticks.still;
  found.sub_steps_p99 = quantile(ticks.sub_steps, 0.99);
  found.force_jump_p99_n = quantile(ticks.jumps, 0.99);
  found.force_jump_max_n = quantile(ticks.jumps, 1.0);
  return found;
}

}  // namespace palpa::test
