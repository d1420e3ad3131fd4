#include "bench/haptics/surface_hands.h"

#include <algorithm>
#include <cmath>

#include "bench/haptics/shape.h"
#include "palpa/device/sine_cosine.h"

namespace palpa::haptics {

using detail::sine_cosine;
using nlohmann::json;

namespace {

Vec3 on_unit_sphere(double azimuth_turns, double elevation_turns) {
  const auto around = sine_cosine(azimuth_turns), up = sine_cosine(elevation_turns);
  return {up.cosine * around.cosine, up.sine, up.cosine * around.sine};
}

/// Steps of at most `step_m` from one point to another, without the first: `at` gets each point and the share [1] of the path
/// behind it.
void straight(Vec3 from, Vec3 to, double step_m, const std::function<void(const Vec3&, double)>& at) {
  const int ticks = static_cast<int>(std::ceil(distance(from, to) / step_m));
  for (int i = 1; i <= ticks; ++i) {
    const double share = static_cast<double>(i) / ticks;
    at(from + share * (to - from), share);
  }
}

}  // namespace

const Body plane{"plane", {{"kind", "plane"}, {"turn", {5, 1, 2, -1}}}};
const Body sphere{"sphere", {{"kind", "sphere"}, {"radius_m", 0.025}, {"turn", {4, 1, -1, 2}}}};
const Body bumpy{"bumpy", {{"kind", "bumpy_sphere"}, {"radius_m", 0.025}}};
const Body torus{"torus", {{"kind", "torus"}, {"radius_m", 0.020}, {"tube_m", 0.009}, {"turn", {4, 2, 1, 1}}}};

Standing over_plane(double t) {
  return {{0.020 * sine_cosine(0.35 * t).sine, 0, 0.020 * sine_cosine(0.23 * t).cosine}, {0, 1, 0}};
}

Standing over_sphere(double t) {
  const Vec3 n = on_unit_sphere(0.4 * t, 0.15 * sine_cosine(0.3 * t).sine);
  return {0.025 * n, n};
}

Walk over_bumpy() {
  const Shape shape = shape_of(bumpy.shape, {});
  return [shape](double t) {
    const Vec3 n = on_unit_sphere(0.4 * t, 0.15 * sine_cosine(0.3 * t).sine);
    Vec3 place = 0.025 * n;
    for (int i = 0; i < 30; ++i) place += shape.depth_m(place) * n;  // along the ray: nearly along the normal
    return Standing{place, shape.outward(place)};
  };
}

Standing over_torus(double t) {
  const auto around = sine_cosine(0.4 * t), tube = sine_cosine(0.55 * t);
  const Vec3 from_axis{around.cosine, around.sine, 0};
  const Vec3 n = tube.cosine * from_axis + Vec3{0, 0, tube.sine};
  return {0.020 * from_axis + 0.009 * n, n};
}

Standing around_sphere(double turn) {
  const auto around = sine_cosine(turn);
  const Vec3 n = normalized(Vec3{around.cosine, 0.6 * around.sine, 0.8 * around.sine});
  return Standing{0.025 * n, n};
}

Standing through_torus(double turn) {
  const auto tube = sine_cosine(turn);
  const Vec3 from_axis = normalized(Vec3{3, 2, 0});
  const Vec3 n = tube.cosine * from_axis + Vec3{0, 0, tube.sine};
  return Standing{0.020 * from_axis + 0.009 * n, n};
}

std::vector<Touch> in_trajectory(const Body& body, const Walk& walk) {
  constexpr int moving = 3125, still = 300;
  Trajectory trajectory(turn_in(body.shape));
  for (int i = 0; i < moving + still; ++i) {
    const double t = time_step_s * std::min(i, moving);
    const Standing at = walk(t);
    trajectory.press(at.place_m, at.outward, 0.9 + 1.2 * sine_cosine(0.8 * t - 0.25).sine,
                     i < moving ? Phase::moving : Phase::still);
  }
  return std::move(trajectory.touches);
}

std::vector<Touch> round_and_round(const Body& body, const Walk& walk, int period_ticks, int turns) {
  Trajectory trajectory(turn_in(body.shape));
  for (int i = 0; i < 40; ++i) {
    const Standing at = walk(0.0);
    trajectory.press(at.place_m, at.outward, -0.2 + 0.03 * i);
  }
  for (int i = 0; i <= turns * period_ticks; ++i) {
    const Standing at = walk(static_cast<double>(i % period_ticks) / period_ticks);
    trajectory.press(at.place_m, at.outward, 1.0);
  }
  return std::move(trajectory.touches);
}

std::vector<Touch> into_groove(const json& groove) {
  const Faces faces = faces_of_groove(groove.at("opening_deg"));
  Trajectory trajectory(turn_in(groove));
  const auto at = [&](const Vec3& probe, Phase phase) {
    trajectory.held(probe, nearest_in_wedge(probe, -faces.a, -faces.b), phase);
  };
  constexpr double aside_m = 1e-4, deepest_m = -2.5e-3, step_m = 5e-5;
  constexpr int down = 210, hold = 200, along = 400;
  for (int i = 0; i <= down; ++i) at({aside_m, deepest_m + step_m * (down - i), -0.010}, Phase::moving);
  const auto sway = [&](int i) { return Vec3{aside_m + 4e-4 * sine_cosine(i / 160.0).sine, deepest_m, -0.010 + step_m * i}; };
  for (int i = 0; i < hold; ++i) at(sway(0), Phase::still);
  for (int i = 0; i < along; ++i) at(sway(i), Phase::moving);
  for (int i = 0; i < hold; ++i) at(sway(along), Phase::still);
  for (int i = 0; i < along; ++i) at(sway(along - i) + Vec3{0, 2e-6 * i, 0}, Phase::moving);
  for (int i = 0; i < hold; ++i) at(sway(0) + Vec3{0, 2e-6 * along, 0}, Phase::still);
  return std::move(trajectory.touches);
}

std::vector<Touch> over_knife(const json& wedge) {
  Trajectory trajectory(turn_in(wedge));
  constexpr double deep_m = 2e-3, step_m = 8e-5;
  double z = -0.008;
  for (int pass = 0; pass < 3; ++pass) {
    for (double y = 4e-3; y > -deep_m; y -= step_m) trajectory.held({-0.018, y, z}, {-0.018, std::max(y, 0.0), z});
    double x = -0.018;
    for (; x < 0.0; x += step_m) trajectory.held({x, -deep_m, z}, {x, 0, z});
    for (; x < 4e-3; x += step_m) trajectory.held({x, -deep_m, z}, {x, -deep_m, z});
    for (double y = -deep_m; y < 4e-3; y += step_m) trajectory.held({x, y, z}, {x, y, z});
    for (; x > -0.018; x -= step_m, z += 0.4 * step_m) trajectory.held({x, 4e-3, z}, {x, 4e-3, z});
  }
  return std::move(trajectory.touches);
}

std::vector<Touch> through_plate(const json& plate) {
  Trajectory trajectory(turn_in(plate));
  Vec3 hand{0, 8e-3, 0};
  const auto go = [&](const Vec3& to, double step_m) {
    straight(hand, to, step_m, [&](const Vec3& probe, double) {
      hand = probe;
      trajectory.held(hand, {hand.x, std::max(hand.y, 0.0), hand.z});
    });
  };
  int stroke = 0;
  for (const double step_m : {1e-4, 1e-3, 5e-3}) {
    for (int i = 0; i < 4; ++i, ++stroke) {
      const auto around = sine_cosine(0.19 * stroke);
      const Vec3 place{0.006 * around.cosine, 0, 0.006 * around.sine};
      go({place.x, 8e-3, place.z}, 1e-3);
      go({place.x + 1.1e-3 * i, -8e-3, place.z}, step_m);
      for (int k = 0; k < 120; ++k) trajectory.held(hand, {hand.x, 0, hand.z}, Phase::still);
      go({hand.x, 8e-3, hand.z}, 1e-3);
    }
  }
  return std::move(trajectory.touches);
}

std::vector<Touch> with_friction(double coefficient) {
  Trajectory trajectory(turn_in(plane.shape));
  Vec3 held{};
  const auto at = [&](const Vec3& probe, bool still) {
    const double cone_m = coefficient * std::max(-probe.y, 0.0);
    const Vec3 along{probe.x - held.x, 0, probe.z - held.z};
    const double off_m = norm(along);
    const bool slides = off_m > cone_m;
    if (slides) held += (1.0 - cone_m / off_m) * along;
    const bool pressed = probe.y < 0.0;
    trajectory.held(probe, pressed ? held : probe, still ? Phase::still : slides && pressed ? Phase::sliding : Phase::moving);
  };
  constexpr double step_m = 4e-5;
  Vec3 hand{-0.012, 3e-3, -0.006};
  const auto go = [&](const Vec3& to, double wave_m) {
    straight(hand, to, step_m, [&](const Vec3& probe, double share) {
      at(probe + Vec3{0, wave_m * sine_cosine(2.0 * share).sine, 0}, false);
    });
    hand = to;
    for (int i = 0; i < 200; ++i) at(hand, true);
  };
  go({-0.012, -2e-3, -0.006}, 0.0);
  go({0.013, -2e-3, -0.002}, 5e-4);
  go({-0.010, -2e-3, 0.004}, 5e-4);
  go({-0.010, -3e-3, 0.004}, 0.0);
  go({0.0, -3e-3, -0.016}, 0.0);
  go({0.0, 3e-3, -0.016}, 0.0);
  return std::move(trajectory.touches);
}

std::vector<Touch> through_shells() {
  Trajectory trajectory(turn_of({4, 1, 2, 1}));
  constexpr std::size_t count = std::size(shells);
  std::size_t shell = 0;
  bool inwards = true;
  const auto at = [&](double r, Phase phase) {
    while (inwards && shell < count && stiffness_n_per_m * (shells[shell].radius_m - r) > shells[shell].strength_n) ++shell;
    const double held_m = shell < count ? std::max(r, shells[shell].radius_m) : r;
    trajectory.held({r, 0, 0}, {held_m, 0, 0}, phase);
  };
  constexpr double deepest_m = 0.015;
  for (int i = 0; i <= 1900; ++i) at(deepest_m + 1e-5 * (1900 - i), Phase::moving);
  inwards = false;
  for (int i = 0; i < 200; ++i) at(deepest_m, Phase::still);
  for (int i = 0; i <= 475; ++i) at(deepest_m + 4e-5 * i, Phase::moving);
  return std::move(trajectory.touches);
}

}  // namespace palpa::haptics
