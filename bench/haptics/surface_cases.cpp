// Surfaces: in-trajectories over smooth shapes, grooves, thin parts, friction, shells, drift, a recorded hand.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numbers>

#include "bench/haptics/cases.h"
#include "bench/haptics/shape.h"
#include "palpa/core/load_error.h"
#include "palpa/device/sine_cosine.h"

namespace palpa::haptics {

using detail::sine_cosine;
using nlohmann::json;

namespace {

const json plane{{"kind", "plane"}, {"turn", {5, 1, 2, -1}}};
const json ball{{"kind", "sphere"}, {"radius_m", 0.025}, {"turn", {4, 1, -1, 2}}};
const json bumpy{{"kind", "bumpy_sphere"}, {"radius_m", 0.025}};
const json ring{{"kind", "torus"}, {"radius_m", 0.020}, {"tube_m", 0.009}, {"turn", {4, 2, 1, 1}}};

const std::vector<std::string> on_surfaces{"surface", "direction", "force", "lost", "rest", "ripple"};

/// A place on a shape at a moment, in its own frame.
struct Standing {
  Vec3 place_m;
  Vec3 outward;  // [1]
};
using Walk = std::function<Standing(double time_s)>;

Vec3 on_unit_sphere(double azimuth_turns, double elevation_turns) {
  const auto around = sine_cosine(azimuth_turns), up = sine_cosine(elevation_turns);
  return {up.cosine * around.cosine, up.sine, up.cosine * around.sine};
}

Standing over_plane(double t) {
  return {{0.020 * sine_cosine(0.35 * t).sine, 0, 0.020 * sine_cosine(0.23 * t).cosine}, {0, 1, 0}};
}

Standing over_ball(double t) {
  const Vec3 n = on_unit_sphere(0.4 * t, 0.15 * sine_cosine(0.3 * t).sine);
  return {0.025 * n, n};
}

Walk over_bumpy() {
  const Shape shape = shape_of(bumpy, {});
  return [shape](double t) {
    const Vec3 n = on_unit_sphere(0.4 * t, 0.15 * sine_cosine(0.3 * t).sine);
    Vec3 place = 0.025 * n;
    for (int i = 0; i < 30; ++i) place += shape.depth_m(place) * n;  // along the ray: not far from along the normal
    return Standing{place, shape.outward(place)};
  };
}

Standing over_ring(double t) {
  const auto around = sine_cosine(0.4 * t), tube = sine_cosine(0.55 * t);
  const Vec3 from_axis{around.cosine, around.sine, 0};
  const Vec3 n = tube.cosine * from_axis + Vec3{0, 0, tube.sine};
  return {0.020 * from_axis + 0.009 * n, n};
}

/// Ruffaldi's in-trajectory: the hand walks, presses with up to 2.1 N, lifts off, and is held still at the end.
Trajectory in_trajectory(const json& shape, const Walk& walk) {
  constexpr int moving = 3125, still = 300;
  Trajectory trajectory(turn_in(shape));
  for (int i = 0; i < moving + still; ++i) {
    const double t = time_step_s * std::min(i, moving);
    const Standing at = walk(t);
    trajectory.press(at.place_m, at.outward, 0.9 + 1.2 * sine_cosine(0.8 * t - 0.25).sine,
                     i < moving ? Phase::moving : Phase::still);
  }
  return trajectory;
}

std::string words_of(const Sampling& s) {
  std::string words = "-" + std::to_string(s.samples) + "-" + std::to_string(s.bits) + "bit";
  if (s.noise > 0.0) words += "-noise" + std::to_string(std::lround(100.0 * s.noise));
  if (s.ramp_voxels != Sampling{}.ramp_voxels) words += "-ramp" + std::to_string(s.ramp_voxels);
  return words;
}

void add_in_trajectory(Suite& suite, const std::string& family, const std::string& name, const json& shape, const Walk& walk,
                       const Sampling& sampling, bool quick = false) {
  suite.cases.push_back({.name = name + words_of(sampling),
                         .family = family,
                         .volume = add_volume(suite, name, shape, sampling),
                         .rule = surface_rule(sampling),
                         .shape = shape,
                         .scores = on_surfaces,
                         .touches = in_trajectory(shape, walk).touches,
                         .quick = quick});
}

void add_smooth(Suite& suite) {
  const Walk bumps = over_bumpy();
  const Sampling fine{};
  add_in_trajectory(suite, "surfaces", "plane", plane, over_plane, fine);
  add_in_trajectory(suite, "surfaces", "sphere", ball, over_ball, fine);
  add_in_trajectory(suite, "surfaces", "bumpy", bumpy, bumps, fine);
  add_in_trajectory(suite, "surfaces", "torus", ring, over_ring, fine);
  const Sampling soft{.ramp_voxels = 9};  // 5 mm, more than any hand is deep
  add_in_trajectory(suite, "ramps", "plane", plane, over_plane, soft);
  add_in_trajectory(suite, "ramps", "sphere", ball, over_ball, soft);
  add_in_trajectory(suite, "ramps", "bumpy", bumpy, bumps, soft);
  add_in_trajectory(suite, "ramps", "torus", ring, over_ring, soft);
  add_in_trajectory(suite, "sampling", "bumpy", bumpy, bumps, {.samples = 48, .bits = 8}, true);
  add_in_trajectory(suite, "sampling", "bumpy", bumpy, bumps, {.samples = 64, .bits = 8});
  add_in_trajectory(suite, "sampling", "bumpy", bumpy, bumps, {.samples = 128, .bits = 8});
  add_in_trajectory(suite, "sampling", "bumpy", bumpy, bumps, {.samples = 256, .bits = 8});
  add_in_trajectory(suite, "sampling", "bumpy", bumpy, bumps, {.samples = 128, .bits = 16});
  add_in_trajectory(suite, "sampling", "torus", ring, over_ring, {.samples = 64, .bits = 8});
  add_in_trajectory(suite, "noise", "bumpy", bumpy, bumps, {.noise = 0.01});
  add_in_trajectory(suite, "noise", "bumpy", bumpy, bumps, {.noise = 0.03});
  add_in_trajectory(suite, "noise", "torus", ring, over_ring, {.samples = 64, .noise = 0.03});
}

// Into a groove from above, pressed into its bottom, along it with a sway across, and held. The free space is convex, so the
// hand is held at the nearest free place.
void add_groove(Suite& suite, int opening_deg, bool quick) {
  const json shape{{"kind", "groove"}, {"opening_deg", opening_deg}, {"turn", {3, 1, -2, 1}}};
  const Sampling sampling{.edge_m = 0.048};  // filters and voxels raise the bottom: finer than elsewhere
  const Faces faces = faces_of_groove(opening_deg);
  Trajectory trajectory(turn_in(shape));
  const auto at = [&](const Vec3& probe, Phase phase) {
    trajectory.held(probe, foot_in_wedge(probe, -faces.a, -faces.b), phase);
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
  const std::string name = "groove-" + std::to_string(opening_deg);
  suite.cases.push_back({.name = name,
                         .family = "grooves",
                         .volume = add_volume(suite, name, shape, sampling),
                         .rule = surface_rule(sampling),
                         .shape = shape,
                         .scores = on_surfaces,
                         .touches = std::move(trajectory.touches),
                         .quick = quick});
}

// Over a knife's edge: on the face, whatever is below it, until the edge is passed.
void add_knife(Suite& suite, int opening_deg) {
  const json shape{{"kind", "wedge"}, {"opening_deg", opening_deg}, {"turn", {3, -1, 1, 1}}};
  const Sampling sampling{.edge_m = 0.064};
  Trajectory trajectory(turn_in(shape));
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
  const std::string name = "knife-" + std::to_string(opening_deg);
  suite.cases.push_back({.name = name,
                         .family = "thin",
                         .volume = add_volume(suite, name, shape, sampling),
                         .rule = surface_rule(sampling),
                         .shape = nullptr,
                         .scores = {"direction", "force", "lost", "ripple"},
                         .touches = std::move(trajectory.touches)});
}

// Straight strokes through a plate, from 0.1 to 5 m/s, each held 8 mm below its front: the front holds.
void add_plate(Suite& suite, const std::string& name, double thickness_m, bool quick) {
  const json shape{{"kind", "plate"}, {"thickness_m", thickness_m}, {"turn", {4, 1, 2, -1}}};
  const Sampling sampling{.samples = 64, .edge_m = 0.064};
  Trajectory trajectory(turn_in(shape));
  Vec3 hand{0, 8e-3, 0};
  const auto go = [&](const Vec3& to, double step_m) {
    const Vec3 from = hand;
    const int ticks = static_cast<int>(std::ceil(distance(from, to) / step_m));
    for (int i = 1; i <= ticks; ++i) {
      hand = from + (static_cast<double>(i) / ticks) * (to - from);
      trajectory.held(hand, {hand.x, std::max(hand.y, 0.0), hand.z});
    }
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
  suite.cases.push_back({.name = name,
                         .family = "thin",
                         .volume = add_volume(suite, name, shape, sampling),
                         .rule = surface_rule(sampling),
                         .shape = nullptr,
                         .scores = {"direction", "force", "lost", "ripple"},
                         .touches = std::move(trajectory.touches),
                         .quick = quick});
}

// A plane with Coulomb friction: where the pull along it is within the cone the hand is held where it is, else it follows until
// the pull is on the cone. Exact tick by tick, whatever the path.
void add_friction(Suite& suite, const std::string& name, double coefficient, const Sampling& sampling, bool quick = false) {
  Trajectory trajectory(turn_in(plane));
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
    const Vec3 from = hand;
    const int ticks = static_cast<int>(std::ceil(distance(from, to) / step_m));
    for (int i = 1; i <= ticks; ++i) {
      const double share = static_cast<double>(i) / ticks;
      hand = from + share * (to - from) + Vec3{0, wave_m * sine_cosine(2.0 * share).sine, 0};
      at(hand, false);
    }
    hand = to;
    for (int i = 0; i < 200; ++i) at(hand, true);
  };
  go({-0.012, -2e-3, -0.006}, 0.0);
  go({0.013, -2e-3, -0.002}, 5e-4);
  go({-0.010, -2e-3, 0.004}, 5e-4);
  go({-0.010, -3e-3, 0.004}, 0.0);
  go({0.0, -3e-3, -0.016}, 0.0);
  go({0.0, 3e-3, -0.016}, 0.0);
  suite.cases.push_back({.name = name,
                         .family = "friction",
                         .volume = add_volume(suite, "plane", plane, sampling),
                         .rule = surface_rule(sampling, coefficient),
                         .shape = plane,
                         .scores = {"surface", "force", "lost", "friction", "rest", "ripple"},
                         .touches = std::move(trajectory.touches),
                         .quick = quick,
                         .friction_deg = std::round(1e6 * std::atan(coefficient) * 180.0 / std::numbers::pi) / 1e6});
}

// Three shells around each other, of 1 N, of 2 N, and one that never lets go, pressed through one after another.
void add_shells(Suite& suite, const std::string& name, double noise, bool quick) {
  constexpr double radii_m[] = {0.030, 0.024, 0.018}, ramp_m = 2e-3, edge_m = 0.072;
  constexpr double strengths_n[] = {1.0, 2.0, 1e9};
  json levels = json::array();
  for (int s = 0; s < 3; ++s)
    levels.push_back({{"value", 900 + 1000 * s}, {"strength_n", s < 2 ? json(strengths_n[s]) : json(nullptr)}});
  suite.volumes[name] = [=] {
    SampledVolume volume{.grid = cube(96, edge_m), .type = "uint16"};
    Noise random(7);
    for (int k = 0; k < 96; ++k) {
      for (int j = 0; j < 96; ++j) {
        for (int i = 0; i < 96; ++i) {
          const double r = norm(volume.grid.place_m(i, j, k));
          double value = 400.0;
          for (const double radius_m : radii_m) value += 500.0 + 500.0 * std::clamp((radius_m - r) / ramp_m, -1.0, 1.0);
          if (noise > 0.0) value += 1000.0 * noise * random.next();
          volume.samples.push_back(static_cast<float>(std::round(std::clamp(value, 0.0, 4095.0))));
        }
      }
    }
    return volume;
  };
  Trajectory trajectory(turn_of({4, 1, 2, 1}));
  int shell = 0;
  bool inwards = true;
  const auto at = [&](double r, Phase phase) {
    while (inwards && shell < 3 && stiffness_n_per_m * (radii_m[shell] - r) > strengths_n[shell]) ++shell;
    const double held_m = shell < 3 ? std::max(r, radii_m[shell]) : r;
    trajectory.held({r, 0, 0}, {held_m, 0, 0}, phase);
  };
  constexpr double deepest_m = 0.015;
  for (int i = 0; i <= 1900; ++i) at(deepest_m + 1e-5 * (1900 - i), Phase::moving);
  inwards = false;
  for (int i = 0; i < 200; ++i) at(deepest_m, Phase::still);
  for (int i = 0; i <= 475; ++i) at(deepest_m + 4e-5 * i, Phase::moving);
  suite.cases.push_back({.name = name,
                         .family = "shells",
                         .volume = name,
                         .rule = {{"kind", "surface"}, {"solid", "high"}, {"levels", levels}, {"friction_coefficient", 0}},
                         .shape = nullptr,
                         .scores = {"direction", "force", "lost", "break", "rest", "ripple"},
                         .touches = std::move(trajectory.touches),
                         .quick = quick});
}

// Round and round, 1 N deep, 0.2 m/s. What is felt is the same in every turn.
void add_round(Suite& suite, const std::string& name, const json& shape, const Sampling& sampling, const Walk& walk,
               int period_ticks, int turns, bool quick = false) {
  Trajectory trajectory(turn_in(shape));
  for (int i = 0; i < 40; ++i) {
    const Standing at = walk(0.0);
    trajectory.press(at.place_m, at.outward, -0.2 + 0.03 * i);
  }
  for (int i = 0; i <= turns * period_ticks; ++i) {
    const Standing at = walk(static_cast<double>(i % period_ticks) / period_ticks);
    trajectory.press(at.place_m, at.outward, 1.0);
  }
  suite.cases.push_back({.name = name + "-turns" + words_of(sampling),
                         .family = "turns",
                         .volume = add_volume(suite, name, shape, sampling),
                         .rule = surface_rule(sampling),
                         .shape = shape,
                         .scores = {"surface", "direction", "force", "drift", "energy", "ripple"},
                         .touches = std::move(trajectory.touches),
                         .quick = quick,
                         .period_ticks = period_ticks});
}

void add_rounds(Suite& suite) {
  const auto circle = [](double turn) {
    const auto around = sine_cosine(turn);
    const Vec3 n = normalized(Vec3{around.cosine, 0.6 * around.sine, 0.8 * around.sine});
    return Standing{0.025 * n, n};
  };
  const auto through_hole = [](double turn) {
    const auto tube = sine_cosine(turn);
    const Vec3 from_axis = normalized(Vec3{3, 2, 0});
    const Vec3 n = tube.cosine * from_axis + Vec3{0, 0, tube.sine};
    return Standing{0.020 * from_axis + 0.009 * n, n};
  };
  add_round(suite, "sphere", ball, {}, circle, 785, 6);
  add_round(suite, "torus", ring, {}, through_hole, 283, 12);
  add_round(suite, "sphere", ball, {.samples = 48, .bits = 8}, circle, 785, 3, true);
  add_round(suite, "sphere", ball, {.samples = 64, .noise = 0.03}, circle, 785, 6);
}

}  // namespace

void Trajectory::press(const Vec3& place_m, const Vec3& outward, double force_n, Phase phase) {
  const Vec3 probe_m = place_m - (force_n / stiffness_n_per_m) * outward;
  touches.push_back({turn_ * probe_m, turn_ * (std::max(force_n, 0.0) * outward), phase});
}

void Trajectory::held(const Vec3& probe_m, const Vec3& place_m, Phase phase) {
  touches.push_back({turn_ * probe_m, turn_ * (stiffness_n_per_m * (place_m - probe_m)), phase});
}

nlohmann::json surface_rule(const Sampling& sampling, double friction_coefficient) {
  const double top = std::exp2(sampling.bits) - 1.0;
  return {{"kind", "surface"},
          {"solid", "high"},
          {"levels", json::array({{{"value", 0.5 * top}, {"strength_n", nullptr}}})},
          {"friction_coefficient", friction_coefficient}};
}

SampledVolume sampled(const json& description, const Sampling& sampling) {
  const Shape shape = shape_of(description, {});
  SampledVolume volume{.grid = cube(sampling.samples, sampling.edge_m), .type = sampling.bits > 8 ? "uint16" : "uint8"};
  const double top = std::exp2(sampling.bits) - 1.0, ramp_m = sampling.ramp_voxels * volume.grid.spacing_m.x;
  volume.samples.reserve(volume.grid.samples());
  Noise random(11);
  const auto& size = volume.grid.size;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const double inside = std::clamp(0.5 + 0.5 * shape.depth_m(volume.grid.place_m(i, j, k)) / ramp_m, 0.0, 1.0);
        double share = 0.1 + 0.8 * inside;
        if (sampling.noise > 0.0) share += 0.8 * sampling.noise * random.next();
        volume.samples.push_back(static_cast<float>(std::round(top * std::clamp(share, 0.0, 1.0))));
      }
    }
  }
  return volume;
}

std::string add_volume(Suite& suite, const std::string& shape_name, const json& shape, const Sampling& sampling) {
  const std::string name = shape_name + words_of(sampling);
  suite.volumes.emplace(name, [=] { return sampled(shape, sampling); });
  return name;
}

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

// The recorded hand, a tenth as large and as fast, about a place of the surface: of a plane, a ball and the outside of a torus
// the nearest free place is known for any hand that does not go as deep as their centres.
void add_hand_cases(Suite& suite, const std::filesystem::path& hand_file) {
  std::ifstream file(hand_file);
  if (!file) throw LoadError(hand_file.string() + ": cannot be read; name the folder of the benchmark's sources");
  std::vector<std::pair<double, Vec3>> rows;
  for (std::string line; std::getline(file, line);) {
    double t_s = 0.0;
    Vec3 x;
    if (std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf", &t_s, &x.x, &x.y, &x.z) == 4) rows.emplace_back(t_s, x);
  }
  if (rows.size() < 2) throw LoadError(hand_file.string() + ": has no rows of t_s,x_m,y_m,z_m; take it from the sources anew");
  struct Body {
    std::string name;
    json shape;
    Vec3 middle_m;
    std::function<Vec3(const Vec3&)> outward;
    double size;  // [1] of the recorded hand
  };
  const Body bodies[] = {{"plane",
                          plane,
                          {0, 2e-3, 0},
                          [](const Vec3&) {
                            return Vec3{0, 1, 0};
                          },
                          0.1},
                         {"sphere", ball, {0, 0.027, 0}, [](const Vec3& x) { return normalized(x); }, 0.1},
                         {"torus",
                          ring,
                          {0.031, 0, 0},
                          [](const Vec3& x) {
                            return normalized(x - 0.020 * normalized(Vec3{x.x, x.y, 0}));
                          },
                          0.08}};
  for (const Body& body : bodies) {
    const Shape upright = [&] {
      json description = body.shape;
      description.erase("turn");
      return shape_of(description, {});
    }();
    Trajectory trajectory(turn_in(body.shape));
    const auto at = [&](const Vec3& probe) {
      const double depth_m = upright.depth_m(probe);
      trajectory.held(probe, depth_m > 0.0 ? probe + depth_m * body.outward(probe) : probe);
    };
    std::size_t row = 0;
    for (int i = 0; time_step_s * i < rows.back().first; ++i) {
      const double t_s = time_step_s * i;
      while (rows[row + 1].first <= t_s) ++row;
      const double share = (t_s - rows[row].first) / (rows[row + 1].first - rows[row].first);
      const Vec3 hand = rows[row].second + share * (rows[row + 1].second - rows[row].second);
      const Vec3 probe = body.middle_m + body.size * hand;
      // From far outside to where the recording begins.
      if (i == 0) {
        const Vec3 begin = probe + (0.010 + std::max(upright.depth_m(probe), 0.0)) * body.outward(probe);
        for (int k = 0; k < 200; ++k) at(begin + (k / 200.0) * (probe - begin));
      }
      at(probe);
    }
    suite.cases.push_back({.name = "hand-" + body.name,
                           .family = "hands",
                           .volume = add_volume(suite, body.name, body.shape, {}),
                           .rule = surface_rule({}),
                           .shape = body.shape,
                           .scores = {"surface", "direction", "force", "lost", "ripple"},
                           .touches = std::move(trajectory.touches)});
  }
}

}  // namespace palpa::haptics
