#include "tests/path/lines.h"

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

#include "palpa/data/volume.h"
#include "palpa/file/read_volume.h"
#include "palpa/mode/modes.h"
#include "palpa/scene/load_scene.h"

namespace palpa::test {

namespace {

constexpr double step_s = 1e-3;

struct Streamline {
  double radius_m;
  double turned_m;  // along z, where the axis x = 0 … is crossed: constant on a helix
};

}  // namespace

FieldPtr helical_field(double rise_m, double sign) {
  return vector_formula(
      [rise_m, sign](const Vec3& x) {
        return VectorSample{sign * Vec3{-x.y, x.x, rise_m}, sign * Mat3{{{0, -1, 0}, {1, 0, 0}, {0, 0, 0}}}, true};
      },
      0.4, 1e-3);
}

FollowDrift measure_follow(const FieldPtr& field, double radius_m, double rise_m, int turns) {
  constexpr double offset_m = 1e-3;
  Scene scene = plain_scene({.stiffness_n_per_m = 800});
  const FieldRef flow = scene.add("flow", volume_of(field, "m/s"));
  scene.add("rail", Follow{.field = flow, .strength_n = 2.0});
  Session session(scene);

  const auto at = [&](double angle, double r) { return Vec3{r * std::cos(angle), r * std::sin(angle), rise_m * angle}; };
  const int ticks = static_cast<int>(std::ceil(2.0 * std::numbers::pi * std::hypot(radius_m, rise_m) / follow_step_m));
  const double first_angle = -turns * std::numbers::pi;  // the middle of the path at z = 0
  Tick tick = session.tick({.position_m = at(first_angle, radius_m)}, step_s);
  for (int i = 1; i <= 10; ++i) tick = session.tick({.position_m = at(first_angle, radius_m - 0.1 * i * offset_m)}, step_s);
  // A streamline's invariants: its radius, and its position turned back to angle 0.
  const auto streamline = [&](const Vec3& x, double turned) {
    const double beyond = std::remainder(std::atan2(x.y, x.x) - turned, 2.0 * std::numbers::pi);
    return Streamline{std::hypot(x.x, x.y), x.z - rise_m * (turned + beyond)};
  };
  std::vector<Streamline> after;
  double angle = first_angle;
  after.push_back(streamline(tick.proxy_m, angle));
  for (int turn = 0; turn < turns; ++turn) {
    for (int i = 1; i <= ticks; ++i) {
      angle = first_angle + 2.0 * std::numbers::pi * (turn + static_cast<double>(i) / ticks);
      tick = session.tick({.position_m = at(angle, radius_m - offset_m)}, step_s);
    }
    after.push_back(streamline(tick.proxy_m, angle));
  }
  const auto apart_m = [&](const Streamline& a, const Streamline& b) {
    const double across = radius_m / std::hypot(radius_m, rise_m);  // a helix shifted along z
    return std::hypot(a.radius_m - b.radius_m, across * (a.turned_m - b.turned_m));
  };
  FollowDrift drift;
  drift.first_turn_m = apart_m(after[0], after[1]);
  drift.per_turn_m = turns > 1 ? apart_m(after[1], after.back()) / (turns - 1) : drift.first_turn_m;
  return drift;
}

Scene scene_of(const std::string& toml, const ModeCatalog& modes) {
  return parse_scene(toml, "scene", ".", volume_reader(), modes).scene;
}

std::vector<OrderCase> order_cases() {
  const std::string head =
      "palpa = 1\n[coupling]\nstiffness_n_per_m = 500\n[workspace]\nscale = 1\ncenter = [0, 0, 0]\n"
      "towards_user = \"+z\"\nup = \"+y\"\n";
  const std::string ball = head + "[volume.ball]\nanalytic = \"sphere\"\n";
  const std::string flow = head + "[volume.flow]\nanalytic = \"lamb_oseen_vortex\"\n";
  const auto mode = [](const std::string& type, const std::string& keys) {
    return "[[mode]]\nname = \"" + type + "\"\ntype = \"" + type + "\"\n" + keys;
  };
  // The hand's path lies in the ball, 1 to 3 mm below its surface; in the vortex, around its core.
  const Vec3 in_ball{0, 0, 0.0465}, in_core{0.004, 0, 0};
  const std::string skin = "[[mode.level]]\nname = \"skin\"\nvalue = 0\nstrength_n = 20\n";
  std::vector<OrderCase> all{
      {"surface", ball + mode("surface_and_friction", "field = \"ball\"\n" + skin), in_ball, 0.010},
      {"surface, friction_n", ball + mode("surface_and_friction", "field = \"ball\"\nfriction_n = 0.2\n" + skin), in_ball,
       0.010},
      {"surface, coefficient", ball + mode("surface_and_friction", "field = \"ball\"\nfriction_coefficient = 0.15\n" + skin),
       in_ball, 0.010},
      {"material, friction_n",
       ball + mode("surface_and_friction",
                   "field = \"ball\"\nfriction_n = 0.1\nstrength_n = {of = \"ball\", points = [[-0.01, 0.2], [0.05, 0.4]]}\n"),
       in_ball, 0.010},
      {"follow", flow + mode("follow", "field = \"flow\"\nstrength_n = 0.5\n"), {0.010, 0, 0}, 0.006},
      {"follow, drag", flow + mode("follow", "field = \"flow\"\nstrength_n = 0\ndrag_ns_per_m = 1\n"), {0.010, 0, 0}, 0.006},
      {"viscosity", ball + mode("viscosity", "field = \"ball\"\nstrength_n = 0.5\n"), in_ball, 0.010},
      {"viscosity, drag", ball + mode("viscosity", "field = \"ball\"\ndrag_ns_per_m = 1\n"), in_ball, 0.010},
      {"viscosity of field",
       flow + mode("viscosity", "strength_n = {of = \"magnitude(flow)\", points = [[0, 0.1], [1, 3]]}\n"),
       {0.010, 0, 0},
       0.006},
      {"gradient_force", ball + mode("gradient_force", "field = \"ball\"\nstrength_n = 1\n"), in_ball, 0.010},
      {"vector_force", flow + mode("vector_force", "field = \"flow\"\nstrength_n = 0.5\n"), {0.015, 0, 0}, 0.006},
      {"vortex_force", flow + mode("vortex_force", "field = \"flow\"\nstrength_n = 0.3\n"), in_core, 0.005},
      // Round the core: a hand that approaches and recedes is caught at its turning point, within a step.
      {"vortex_plane", flow + mode("vortex_plane", "field = \"flow\"\nstrength_n = 0.3\n"), {}, 0.005, 6e-4},
      {"front_shape", flow + mode("front_shape", "field = \"flow\"\nstrength_n = 0.3\n"), {0.010, 0, 0}, 0.006},
      {"transverse_damping", flow + mode("transverse_damping", "field = \"flow\"\ndrag_ns_per_m = 1\n"), {0.010, 0, 0}, 0.006},
      {"vortex_line", flow + mode("vortex_line", "field = \"flow\"\nstrength_n = 0.3\n"), in_core, 0.005},
  };
  std::erase_if(all, [](const OrderCase& one) {
    const std::size_t type = one.scene.rfind("type = \"") + 8;
    return !standard_modes().find(one.scene.substr(type, one.scene.find('"', type) - type));
  });
  return all;
}

Order measure_order(const OrderCase& wanted, bool in_steps) {
  constexpr int warm_up = 200, ticks = 150;
  const Scene scene = scene_of(wanted.scene);
  const auto session_of = [&] { return in_steps ? Session(scene) : Session::in_one_step(scene); };
  // A circle that tilts and breathes: curved in space everywhere.
  const double rate = wanted.step_m / wanted.radius_m;
  const auto hand = [&](int tick) {
    const double a = rate * tick;
    const double r = wanted.radius_m * (1.0 + 0.1 * std::sin(0.7 * a));
    return wanted.centre_m + Vec3{r * std::cos(a), r * std::sin(a), 0.1 * wanted.radius_m * std::sin(1.3 * a)};
  };
  // From the hand's position to its position a step later, straight, in this many ticks.
  const auto follow = [&](Session& session, const Vec3& from_m, const Vec3& to_m, int parts) {
    Tick tick;
    for (int part = 1; part <= parts; ++part) {
      const double share = static_cast<double>(part) / parts;
      tick = session.tick({.position_m = from_m + share * (to_m - from_m)}, step_s / parts);
    }
    return tick.proxy_m;
  };
  Session begun = session_of();
  // From outside, so that surfaces are met.
  const Vec3 outside_m = hand(0) + Vec3{0, 0, 0.012};
  begun.tick({.position_m = outside_m}, step_s);
  follow(begun, outside_m, hand(0), 200);
  for (int i = 1; i < warm_up; ++i) follow(begun, hand(i - 1), hand(i), Order::steps.back());

  Order order;
  std::array<std::vector<Vec3>, Order::steps.size()> paths;
  double way_m = 0.0;
  for (std::size_t s = 0; s < Order::steps.size(); ++s) {
    Session session = session_of();
    session.copy_state_from(begun);
    for (int i = warm_up; i < warm_up + ticks; ++i) {
      const Vec3 proxy_m = follow(session, hand(i - 1), hand(i), Order::steps[s]);
      if (!paths[s].empty()) way_m += distance(paths[s].back(), proxy_m);
      paths[s].push_back(proxy_m);
      for (const SessionEvent& event : session.events()) order.events += of_a_shell(scene, event);
    }
  }
  order.settled_m = 5e-4 * finest_spacing_m(scene);
  order.slides = way_m > 0.1 * wanted.step_m * ticks * static_cast<double>(Order::steps.size());
  const auto apart_m = [&](std::size_t a, std::size_t b) {
    double most = 0.0;
    for (int i = 0; i < ticks; ++i) {
      const auto at = static_cast<std::size_t>(i);
      most = std::max(most, distance(paths[a][at], paths[b][at]));
    }
    return most;
  };
  for (std::size_t s = 0; s < 4; ++s) {
    order.errors_m[s] = apart_m(s, 4);
    order.differences_m[s] = apart_m(s, s + 1);
  }
  for (std::size_t s = 0; s < 3; ++s) order.orders[s] = std::log2(order.differences_m[s] / order.differences_m[s + 1]);
  return order;
}

bool of_a_shell(const Scene& scene, const SessionEvent& event) {
  if (event.kind != SessionEventKind::onset && event.kind != SessionEventKind::break_through) return false;
  const auto* surface = scene.modes()[static_cast<std::size_t>(event.mode)].mode.as<SurfaceAndFriction>();
  return surface && !surface->levels.empty();
}

double finest_spacing_m(const Scene& scene) {
  double finest = std::numeric_limits<double>::infinity();
  for (const SceneVolume& volume : scene.volumes()) {
    for (const VolumeField& field : volume.volume.fields) finest = std::min(finest, field.field->spacing_m());
  }
  return scene.hand_to_world().length_to_hand(finest);
}

Rate measure_rate(const RateCase& wanted) {
  const double h = 0.5 * finest_spacing_m(*wanted.scene);
  struct Felt {
    std::vector<Tick> at_corners;
    std::vector<std::vector<int>> events;  // until each corner: modes met, and modes pressed through as −1 − mode
  };
  const auto feel = [&](int ticks_a_chord) {
    Session session(*wanted.scene);
    Felt felt;
    felt.at_corners.push_back(session.tick({.position_m = wanted.corners_m.front()}, step_s));
    felt.events.emplace_back();
    for (std::size_t c = 1; c < wanted.corners_m.size(); ++c) {
      const Vec3 a = wanted.corners_m[c - 1], b = wanted.corners_m[c];
      Tick tick;
      std::vector<int> events = felt.events.back();
      for (int i = 1; i <= ticks_a_chord; ++i) {
        tick = session.tick({.position_m = a + (static_cast<double>(i) / ticks_a_chord) * (b - a)}, step_s);
        for (const SessionEvent& event : session.events()) {
          if (!of_a_shell(*wanted.scene, event)) continue;
          events.push_back(event.kind == SessionEventKind::onset ? event.mode : -1 - event.mode);
        }
      }
      felt.at_corners.push_back(tick);
      felt.events.push_back(std::move(events));
    }
    return felt;
  };
  const Felt slow = feel(100), same = feel(10), fast = feel(1);
  Rate rate;
  std::vector<double> slow_h, fast_h;
  for (std::size_t c = 0; c < wanted.corners_m.size(); ++c) {
    const auto contact = [&](const Felt& f) { return norm(f.at_corners[c].force_n) > 1e-3; };
    if (!contact(slow) && !contact(same) && !contact(fast)) continue;
    const auto waits = [&](const Felt& f) { return f.at_corners[c].status == TickStatus::waiting; };
    if (waits(slow) || waits(same) || waits(fast)) {
      ++rate.waiting;
      continue;
    }
    if (slow.events[c] != same.events[c] || fast.events[c] != same.events[c]) {
      ++rate.differing;
      continue;
    }
    ++rate.corners;
    slow_h.push_back(distance(slow.at_corners[c].proxy_m, same.at_corners[c].proxy_m) / h);
    fast_h.push_back(distance(fast.at_corners[c].proxy_m, same.at_corners[c].proxy_m) / h);
  }
  rate.slow_p99_h = quantile(slow_h, 0.99);
  rate.slow_max_h = quantile(slow_h, 1.0);
  rate.fast_p99_h = quantile(fast_h, 0.99);
  rate.fast_max_h = quantile(fast_h, 1.0);
  return rate;
}

}  // namespace palpa::test
