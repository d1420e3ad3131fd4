#include "tools/figures/theory_figures.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "palpa/report/html.h"
#include "palpa/solver/solver.h"
#include "tools/figures/draw.h"

namespace palpa {
namespace detail {
namespace {

constexpr double tick_s = 1e-3;
constexpr double pi = std::numbers::pi;
constexpr double reached_m = 1e-9;

Balance solve(Solver& solver, PrimitiveSet& set, std::span<const Primitive> primitives, const Vec3& start_m,
              const Vec3& probe_m, double stiffness_n_per_m) {
  set.clear(start_m);
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    Primitive primitive = primitives[i];
    primitive.id.slot = static_cast<std::uint16_t>(i);
    set.add(primitive);
  }
  return solver.solve(set, start_m, probe_m, stiffness_n_per_m, tick_s);
}

Vec3 total(std::span<const Vec3> forces_n) {
  Vec3 sum;
  for (const Vec3& force_n : forces_n) sum += force_n;
  return sum;
}

}  // namespace

Vec3 sweep(std::span<const Primitive> primitives, std::vector<Vec3>& forces_n, const Vec3& probe_m, double stiffness_n_per_m) {
  const double k = stiffness_n_per_m;
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    const Primitive& p = primitives[i];
    if (p.kind == PrimitiveKind::directed) continue;
    const Vec3 without_m = probe_m + (total(forces_n) - forces_n[i]) / k;
    forces_n[i] = shortened(k * residual(p, without_m), p.strength_n);
  }
  return probe_m + total(forces_n) / k;
}

std::vector<NearBalance> sweeps_towards_balance(unsigned seed, int sweeps) {
  constexpr double k = 600.0;
  Draw draw(seed);
  const Vec3 normal = draw.direction();
  const Vec3 other =
      normalized(normal + std::tan(draw.uniform(20, 70) * pi / 180.0) * normalized(cross(normal, draw.direction())));
  const Primitive primitives[] = {
      {.kind = PrimitiveKind::plane, .position_m = draw.in_cube(1e-3), .direction = normal, .strength_n = draw.uniform(0.5, 3)},
      {.kind = PrimitiveKind::plane, .position_m = draw.in_cube(1e-3), .direction = other, .strength_n = draw.uniform(0.5, 3)},
      {.kind = PrimitiveKind::line,
       .position_m = draw.in_cube(1e-3),
       .direction = draw.direction(),
       .strength_n = draw.uniform(0.2, 1)},
      {.kind = PrimitiveKind::point, .position_m = draw.in_cube(1e-3), .strength_n = draw.uniform(0.1, 0.5)}};
  const Vec3 probe_m = -0.003 * normalized(normal + other) + draw.in_cube(0.002);
  PrimitiveSet set;
  Solver solver;
  const Balance balance = solve(solver, set, primitives, {}, probe_m, k);
  std::vector<Vec3> forces_n(std::size(primitives));
  std::vector<NearBalance> way;
  for (int i = 0; i < sweeps; ++i) {
    const Vec3 x_m = sweep(primitives, forces_n, probe_m, k);
    Vec3 left_n = -k * (x_m - probe_m);
    for (const Primitive& p : primitives) left_n += p.strength_n * normalized(residual(p, x_m));
    way.push_back({.error_m = distance(x_m, balance.position_m),
                   .bound_m = error_bound_m(primitives, forces_n, x_m, probe_m, k, tick_s),
                   .residual_n = norm(left_n)});
  }
  return way;
}

namespace {

/// Two planes of 5 N through zero, and a probe 4 mm below the edge in which they meet.
struct Edge {
  Primitive planes[2];
  Vec3 probe_m{0, -0.004, 0};
  double stiffness_n_per_m = 500.0;
};

Edge edge_of(double angle_deg) {
  const double half_rad = 0.5 * angle_deg * pi / 180.0;
  Edge edge;
  for (int i = 0; i < 2; ++i) {
    edge.planes[i] = {.kind = PrimitiveKind::plane,
                      .direction = normalized({(i == 0 ? 1.0 : -1.0) * std::sin(half_rad), std::cos(half_rad), 0}),
                      .strength_n = 5.0};
  }
  return edge;
}

}  // namespace

std::vector<double> sweeps_into_edge(double angle_deg, int cap) {
  const Edge edge = edge_of(angle_deg);
  std::vector<Vec3> forces_n(2);
  std::vector<double> distances_m;
  for (int i = 0; i < cap && (distances_m.empty() || distances_m.back() >= reached_m); ++i)
    distances_m.push_back(norm(sweep(edge.planes, forces_n, edge.probe_m, edge.stiffness_n_per_m)));
  return distances_m;
}

std::vector<EnergyOfStep> random_steps(bool elsewhere, int count) {
  constexpr double k = 500.0;
  constexpr std::size_t primitives_at_most = 5;
  Draw draw(elsewhere ? 12 : 11);
  PrimitiveSet set;
  Solver solver;
  std::vector<EnergyOfStep> steps;
  Vec3 proxy_m, probe_m;
  while (steps.size() < static_cast<std::size_t>(count)) {
    std::vector<Primitive> primitives(1 + static_cast<std::size_t>(draw.uniform(0, primitives_at_most)));
    for (Primitive& p : primitives) {
      p.kind = static_cast<PrimitiveKind>(static_cast<int>(draw.uniform(0, elsewhere ? 4 : 3)));
      p.position_m = proxy_m + (elsewhere ? draw.in_cube(0.003) : Vec3{});
      p.direction = draw.direction();
      p.strength_n = draw.uniform(0, p.kind == PrimitiveKind::directed ? 0.3 : 1.0);
    }
    const Vec3 next_probe_m = probe_m + std::pow(10.0, draw.uniform(-2, 0)) * draw.in_cube(0.003);
    const Vec3 step_m = next_probe_m - probe_m;
    const Vec3 next_m = solve(solver, set, primitives, proxy_m, next_probe_m, k).position_m;
    const double released_j = 0.5 * k * (norm_squared(proxy_m - probe_m) - norm_squared(next_m - next_probe_m));
    steps.push_back({.leak_j = k * dot(proxy_m - probe_m, step_m) - released_j, .bound_j = 0.5 * k * norm_squared(step_m)});
    proxy_m = next_m;
    probe_m = next_probe_m;
  }
  return steps;
}

namespace {

Figure energy_figure() {
  constexpr double k = 400.0, s = 1.0, drag_ns_per_m = 0.2;
  const Primitive plane{.kind = PrimitiveKind::plane, .direction = {1, 0, 0}, .strength_n = s};
  PrimitiveSet set;
  Solver solver;
  Plot energies{.title = "Energy of three probes p",
                .x_label = "place of the proxy / mm",
                .y_label = "energy / mJ",
                .x_range = std::pair{-6.0, 4.0},
                .y_range = std::pair{-0.2, 8.0}};
  Plot forces{.title = "Spring and plane agree",
              .x_label = "place of the proxy / mm",
              .y_label = "force / N",
              .x_range = std::pair{-6.0, 4.0},
              .y_range = std::pair{-0.4, 1.6}};
  forces.series.push_back({.name = "plane", .xs = {-6, -1e-9}, .ys = {s, s}, .color = CurveColor::black});
  forces.series.push_back({.name = "any of it at 0", .xs = {0, 0}, .ys = {0, s}, .color = CurveColor::vermilion});
  forces.series.push_back({.xs = {1e-9, 4}, .ys = {0, 0}, .color = CurveColor::black});
  struct Case {
    double probe_mm;
    const char* name;
    CurveColor color;
  };
  std::vector<Series> rests, crossings;
  for (const Case& c : {Case{1.5, "p = 1.5 mm", CurveColor::green},
                        {-1.5, "p = -1.5 mm", CurveColor::blue},
                        {-4.0, "p = -4 mm", CurveColor::purple}}) {
    const Vec3 probe_m{1e-3 * c.probe_mm, 0, 0};
    Series energy{.name = c.name, .color = c.color};
    for (int i = -600; i <= 400; i += 5) {
      const Vec3 x_m{1e-5 * i, 0, 0};
      const double j = 0.5 * k * norm_squared(x_m - probe_m) + s * norm(residual(plane, x_m));
      if (1e3 * j > 8.0) continue;
      energy.xs.push_back(1e3 * x_m.x);
      energy.ys.push_back(1e3 * j);
    }
    const Vec3 x_m = solve(solver, set, {&plane, 1}, {}, probe_m, k).position_m;
    const double j = 0.5 * k * norm_squared(x_m - probe_m) + s * norm(residual(plane, x_m));
    rests.push_back({.xs = {1e3 * x_m.x}, .ys = {1e3 * j}, .color = c.color, .points_only = true});
    energies.series.push_back(std::move(energy));
    Series spring{.color = c.color, .stroke = Stroke::dashed};
    for (const double x_mm : {std::max(-6.0, c.probe_mm - 1e3 * 0.4 / k), std::min(4.0, c.probe_mm + 1e3 * 1.6 / k)}) {
      spring.xs.push_back(x_mm);
      spring.ys.push_back(1e-3 * k * (x_mm - c.probe_mm));
    }
    forces.series.push_back(std::move(spring));
    crossings.push_back({.xs = {1e3 * x_m.x}, .ys = {k * (x_m - probe_m).x}, .color = c.color, .points_only = true});
  }
  energies.series.insert(energies.series.end(), rests.begin(), rests.end());
  forces.series.insert(forces.series.end(), crossings.begin(), crossings.end());

  Plot felt{.title = "What is felt",
            .x_label = "way in one tick / mm",
            .y_label = "force / N",
            .x_range = std::pair{0.0, 6.0},
            .y_range = std::pair{0.0, 1.6}};
  struct Kind {
    const char* name;
    double strength_n, drag_ns_per_m;
    CurveColor color;
    Stroke stroke;
  };
  for (const Kind& kind : {Kind{"strength", s, 0.0, CurveColor::blue, Stroke::solid},
                           {"drag", 0.0, drag_ns_per_m, CurveColor::green, Stroke::dashed},
                           {"both", s, drag_ns_per_m, CurveColor::vermilion, Stroke::solid}}) {
    Series series{.name = kind.name, .color = kind.color, .stroke = kind.stroke};
    Primitive point{.kind = PrimitiveKind::point, .strength_n = kind.strength_n, .drag_ns_per_m = kind.drag_ns_per_m};
    for (int i = 0; i <= 120; ++i) {
      const Vec3 probe_m{5e-5 * i, 0, 0};
      series.xs.push_back(1e3 * probe_m.x);
      series.ys.push_back(k * distance(solve(solver, set, {&point, 1}, {}, probe_m, k).position_m, probe_m));
    }
    felt.series.push_back(std::move(series));
  }
  return {
      .name = "theory-energy",
      .caption = text("A plane of %.0f N at 0 and a spring of %.0f N/m. The energy has a kink at the plane; its lowest point "
                      "is where the spring's force is one that the plane can exert, at the kink any up to %.0f N. To the "
                      "right a point with strength, drag (%.1f N s/m, ticks of 1 ms), or both.",
                      s, k, s, drag_ns_per_m),
      .width_px = 1240,
      .height_px = 360,
      .sheet = {.columns = 3, .panels = {energies, forces, felt}}};
}

/// Where in the force set of a primitive, in the drawing's plane, a direction reaches furthest.
Vec3 furthest(const Primitive& p, const Vec3& e) {
  switch (p.kind) {
    case PrimitiveKind::point: return p.strength_n * e;
    case PrimitiveKind::line: return p.strength_n * normalized(e - dot(p.direction, e) * p.direction);
    case PrimitiveKind::plane:
    case PrimitiveKind::corner: return (dot(p.direction, e) > 0.0 ? p.strength_n : 0.0) * p.direction;
    case PrimitiveKind::directed: break;
  }
  return p.strength_n * p.direction;
}

std::vector<DrawingPoint> outline(std::span<const Primitive> primitives, const DrawingPoint& middle, double mm_per_n) {
  std::vector<DrawingPoint> corners;
  for (int i = 0; i <= 360; ++i) {
    const double turn = (i + 0.5) * pi / 180.0;  // never exactly across a direction
    Vec3 sum_n;
    for (const Primitive& p : primitives) sum_n += furthest(p, {std::cos(turn), std::sin(turn), 0});
    corners.push_back({middle.x_mm + mm_per_n * sum_n.x, middle.y_mm + mm_per_n * sum_n.y});
  }
  return corners;
}

Figure sum_figure() {
  constexpr double k = 200.0, mm_per_n = 10.0;
  const double tilt_rad = 60.0 * pi / 180.0;
  const Primitive primitives[] = {
      {.kind = PrimitiveKind::plane, .direction = {0, 1, 0}, .strength_n = 1.0},
      {.kind = PrimitiveKind::line, .direction = {std::cos(tilt_rad), std::sin(tilt_rad), 0}, .strength_n = 0.8},
      {.kind = PrimitiveKind::point, .strength_n = 0.4}};
  const CurveColor colors[] = {CurveColor::black, CurveColor::green, CurveColor::purple};
  const char* names[] = {"plane, 1 N", "line, 0.8 N", "point, 0.4 N"};

  Drawing sets{.title = "What each can exert", .low = {-20, -19}, .high = {20, 19}};
  const DrawingPoint middles[] = {{-11, -4}, {0, 3}, {12, 2}};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::vector<DrawingPoint> corners = outline({primitives + i, 1}, middles[i], mm_per_n);
    if (i == 2) sets.area(corners, colors[i]);
    sets.path(corners, colors[i], Stroke::solid, 2.4f);
    sets.dot(middles[i], colors[i], 3.0f);
    sets.text({middles[i].x_mm, -10}, names[i], 0, colors[i]);
  }
  sets.path({{-5, -15}, {5, -15}}, CurveColor::grey, Stroke::solid, 2.0f);
  sets.text({0, -17.5}, "1 N", 0, CurveColor::grey);

  Drawing sum{.title = "Their sum, and what hands demand", .low = {-20, -14}, .high = {20, 24}};
  const std::vector<DrawingPoint> border = outline(primitives, {}, mm_per_n);
  sum.area(border, CurveColor::sky);
  sum.path(border, CurveColor::blue, Stroke::solid, 2.0f);
  sum.dot({}, CurveColor::black, 3.0f);
  sum.text({0.8, -1.6}, "0", -1);

  Drawing space{.title = "The same in space", .low = {-10, -12}, .high = {10, 7}};
  space.area({{-9, 0}, {9, 0}, {9, -11}, {-9, -11}}, CurveColor::grey);
  space.path({{-9, 0}, {9, 0}}, CurveColor::black, Stroke::solid, 2.0f);
  space.path({{-6.3 * std::cos(tilt_rad), -6.3 * std::sin(tilt_rad)}, {6.3 * std::cos(tilt_rad), 6.3 * std::sin(tilt_rad)}},
             CurveColor::green, Stroke::solid, 2.0f);
  space.dot({}, CurveColor::purple, 5.0f);

  PrimitiveSet set;
  Solver solver;
  int number = 0;
  for (const Vec3& demand_n : {Vec3{-0.45, 0.75, 0}, {1.1, 1.55, 0}, {-0.9, -0.6, 0}, {-1.55, 1.4, 0}}) {
    const Vec3 probe_m = -(1.0 / k) * demand_n;
    const Balance balance = solve(solver, set, primitives, {}, probe_m, k);
    const Vec3 given_n = total(solver.forces_n());
    const auto at = [&](const Vec3& force_n) { return DrawingPoint{mm_per_n * force_n.x, mm_per_n * force_n.y}; };
    const auto place = [](const Vec3& at_m) { return DrawingPoint{1e3 * at_m.x, 1e3 * at_m.y}; };
    const std::string name = text("%d", ++number);
    if (distance(given_n, demand_n) > 1e-6) sum.arrow(at(demand_n), at(given_n), CurveColor::vermilion);
    sum.ring(at(given_n), CurveColor::vermilion, 6.5f);
    sum.dot(at(demand_n), CurveColor::blue, 4.5f);
    sum.text({at(demand_n).x_mm + 1.6, at(demand_n).y_mm + 1.2}, name, -1, CurveColor::blue);
    space.path({place(probe_m), place(balance.position_m)}, CurveColor::blue, Stroke::dashed);
    space.ring(place(balance.position_m), CurveColor::vermilion, 6.5f);
    space.dot(place(probe_m), CurveColor::blue, 4.5f);
    space.text({place(probe_m).x_mm + 0.6, place(probe_m).y_mm - 0.7}, name, -1, CurveColor::blue);
  }
  return {
      .name = "theory-sum",
      .caption = text("A plane, a line and a point at one place. Left: the forces that each can exert. Middle: the sums of "
                      "them, four demands of a hand (blue), and the nearest force that can be given (red). Demand 1 lies "
                      "inside: the proxy rests. Elsewhere what is missing, as the arrow, moves the proxy. Right: probes and "
                      "proxies of these demands, k = %.0f N/m.",
                      k),
      .width_px = 1200,
      .height_px = 430,
      .sheet = {.columns = 3, .panels = {sets, sum, space}}};
}

Figure bound_figure() {
  constexpr double k = 600.0;
  constexpr int sweeps = 40, sets = 400;
  const std::pair<double, double> range_mm{1e-7, 20.0};
  Plot way{.title = "One set, sweep by sweep",
           .x_label = "sweeps",
           .y_label = "distance / mm",
           .x_range = std::pair{0.0, static_cast<double>(sweeps)},
           .y_range = range_mm,
           .y_log = true};
  Series error{.name = "error", .color = CurveColor::blue}, bound{.name = "proven bound", .color = CurveColor::vermilion},
      residual{.name = "residual force / k", .color = CurveColor::grey, .stroke = Stroke::dashed};
  int at = 0;
  for (const NearBalance& near : sweeps_towards_balance(29, sweeps)) {
    ++at;
    for (Series* series : {&error, &bound, &residual}) series->xs.push_back(at);
    error.ys.push_back(1e3 * near.error_m);
    bound.ys.push_back(1e3 * near.bound_m);
    residual.ys.push_back(1e3 * near.residual_n / k);
  }
  way.series = {bound, error, residual};

  Plot all{.title = text("%d sets", sets),
           .x_label = "error / mm",
           .y_label = "distance / mm",
           .x_range = std::pair{1e-6, 10.0},
           .y_range = range_mm,
           .x_log = true,
           .y_log = true};
  Series bounds{.name = "proven bound", .color = CurveColor::vermilion, .points_only = true},
      residuals{.name = "residual force / k", .color = CurveColor::grey, .points_only = true};
  for (unsigned seed = 1; seed <= sets; ++seed) {
    const NearBalance near = sweeps_towards_balance(seed, 1 + static_cast<int>(seed % 12)).back();
    bounds.xs.push_back(1e3 * near.error_m);
    bounds.ys.push_back(1e3 * near.bound_m);
    residuals.xs.push_back(1e3 * near.error_m);
    residuals.ys.push_back(1e3 * near.residual_n / k);
  }
  all.series = {residuals, bounds, {.name = "error itself", .xs = {1e-6, 10}, .ys = {1e-6, 10}, .color = CurveColor::blue}};
  return {.name = "theory-bound",
          .caption =
              text("Two oblique planes, a line and a point, k = %.0f N/m, with the forces of the first sweeps. The bound lies "
                   "above the error and falls with it, as its root where something holds that is not quite reached. What the "
                   "printed forces leave over falls only where nothing holds; elsewhere no test of it tells 1 mm from 1 nm.",
                   k),
          .width_px = 1120,
          .height_px = 400,
          .sheet = {.columns = 2, .panels = {way, all}}};
}

Figure sweeps_figure() {
  constexpr int cap = 200000;
  Plot way{.title = "Two planes: sweep by sweep",
           .x_label = "sweeps",
           .y_label = "error / mm",
           .x_range = std::pair{0.0, 60.0},
           .y_range = std::pair{1e-7, 10.0},
           .y_log = true};
  const std::pair<double, CurveColor> angles[] = {{10, CurveColor::vermilion},
                                                  {20, CurveColor::orange},
                                                  {40, CurveColor::green},
                                                  {60, CurveColor::sky},
                                                  {80, CurveColor::blue}};
  for (const auto& [angle_deg, color] : angles) {
    Series series{.name = text("%.0f degrees", angle_deg), .color = color};
    for (const double distance_m : sweeps_into_edge(angle_deg, 60)) {
      series.xs.push_back(static_cast<double>(series.xs.size() + 1));
      series.ys.push_back(1e3 * distance_m);
    }
    way.series.push_back(std::move(series));
  }
  Plot count{.title = "Until the error is 1 nm",
             .x_label = "angle between the planes / degrees",
             .y_label = "sweeps, iterations",
             .x_range = std::pair{1.0, 100.0},
             .y_range = std::pair{0.5, 1e5},
             .x_log = true,
             .y_log = true};
  Series counted{.name = "sweeps", .color = CurveColor::vermilion, .points_only = true};
  Series formula{.name = "cos\u00b2 a sweep", .color = CurveColor::grey, .stroke = Stroke::dashed};
  Series ours{.name = "exact law", .color = CurveColor::blue, .points_only = true};
  PrimitiveSet set;
  Solver solver;
  for (int i = 0; i < 32; ++i) {
    const double angle_deg = std::pow(90.0, (i + 0.5) / 32.0);
    const std::vector<double> distances_m = sweeps_into_edge(angle_deg, cap);
    const double squared = std::pow(std::cos(angle_deg * pi / 180.0), 2);
    counted.xs.push_back(angle_deg);
    counted.ys.push_back(static_cast<double>(distances_m.size()));
    formula.xs.push_back(angle_deg);
    formula.ys.push_back(std::max(1.0, 1.0 + std::log(reached_m / distances_m.front()) / std::log(squared)));
    const Edge edge = edge_of(angle_deg);
    solver.reset();
    const Balance balance = solve(solver, set, edge.planes, {}, edge.probe_m, edge.stiffness_n_per_m);
    if (norm(balance.position_m) >= reached_m) continue;
    ours.xs.push_back(angle_deg);
    ours.ys.push_back(std::max(1, balance.iterations));
  }
  count.series = {formula, counted, ours};
  return {.name = "theory-sweeps",
          .caption =
              "A proxy is pressed into the edge of two planes. A sweep leaves cos\u00b2 of the angle of the error, so "
              "nearly parallel planes take thousands. The exact law (cold start; its iterations, of any stage) "
              "hardly feels the angle.",
          .width_px = 1120,
          .height_px = 400,
          .sheet = {.columns = 2, .panels = {way, count}}};
}

/// The work on a hand that goes in circles, tick by tick [mJ], against the time [s].
Series work_on_circling_hand(std::string name, CurveColor color,
                             const std::function<std::vector<Primitive>(const Vec3&)>& placed) {
  constexpr double k = 500.0, radius_m = 0.005, turns_per_s = 5.0;
  constexpr int ticks = 1000;
  PrimitiveSet set;
  Solver solver;
  Series series{.name = std::move(name), .xs = {0.0}, .ys = {0.0}, .color = color};
  const auto probe_at = [](int n) {
    const double turn = 2.0 * pi * turns_per_s * tick_s * n;
    return Vec3{radius_m * std::cos(turn), radius_m * std::sin(turn), 0};
  };
  Vec3 proxy_m = probe_at(0);
  double work_j = 0.0;
  for (int n = 0; n < ticks; ++n) {
    proxy_m = solve(solver, set, placed(proxy_m), proxy_m, probe_at(n), k).position_m;
    work_j += k * dot(proxy_m - probe_at(n), probe_at(n + 1) - probe_at(n));
    series.xs.push_back(tick_s * (n + 1));
    series.ys.push_back(1e3 * work_j);
  }
  return series;
}

Figure passivity_figure() {
  constexpr int steps = 350;
  Plot ratios{.title = "Random steps",
              .x_label = "k/2 |step of the hand|\u00b2 / \u00b5J",
              .y_label = "leaked / (k/2 |step|\u00b2)",
              .x_range = std::pair{1e-2, 1e4},
              .y_range = std::pair{-4.0, 4.0},
              .x_log = true};
  const auto ratio = [&](const char* name, CurveColor color, bool elsewhere) {
    Series series{.name = name, .color = color, .points_only = true};
    for (const EnergyOfStep& step : random_steps(elsewhere, steps)) {
      series.xs.push_back(1e6 * step.bound_j);
      series.ys.push_back(step.leak_j / step.bound_j);
    }
    return series;
  };
  ratios.series = {
      ratio("elsewhere", CurveColor::orange, true),
      ratio("through the proxy", CurveColor::blue, false),
      {.name = "theorem B", .xs = {1e-2, 1e4}, .ys = {1, 1}, .color = CurveColor::black, .stroke = Stroke::dashed}};

  Plot turns{.title = "A hand that goes in circles",
             .x_label = "time / s",
             .y_label = "work on the hand / mJ",
             .x_range = std::pair{0.0, 1.0},
             .y_range = std::pair{-10.0, 20.0}};
  constexpr double k = 500.0, radius_m = 0.005, turns_per_s = 5.0;
  const double step_m = 2.0 * radius_m * std::sin(pi * turns_per_s * tick_s);
  using Primitives = std::vector<Primitive>;
  turns.series = {
      work_on_circling_hand(
          "directed, turning", CurveColor::vermilion,
          [](const Vec3& at) {
            return Primitives{{.kind = PrimitiveKind::directed, .direction = normalized({-at.y, at.x, 0}), .strength_n = 0.12}};
          }),
      work_on_circling_hand("strong point", CurveColor::sky,
                            [](const Vec3&) { return Primitives{{.kind = PrimitiveKind::point, .strength_n = 10.0}}; }),
      work_on_circling_hand("surface", CurveColor::green,
                            [](const Vec3&) {
                              return Primitives{{.kind = PrimitiveKind::plane, .direction = {0, 1, 0}, .strength_n = 10.0}};
                            }),
      work_on_circling_hand("turning rail", CurveColor::purple,
                            [n = 0](const Vec3& at) mutable {
                              const double turn = 0.4 * ++n;
                              return Primitives{{.kind = PrimitiveKind::line,
                                                 .position_m = at,
                                                 .direction = {std::cos(turn), std::sin(turn), 0},
                                                 .strength_n = 0.15}};
                            }),
      {.name = "theorem B",
       .xs = {0.0, 1.0},
       .ys = {0.0, 1e3 * 1000 * 0.5 * k * step_m * step_m},
       .color = CurveColor::black,
       .stroke = Stroke::dashed}};
  return {.name = "theory-passivity",
          .caption =
              "Energy that a hand gets beyond what the spring releases, k = 500 N/m. Left: random steps, with other "
              "primitives in each; through the proxy none leaks more than k/2 |step|\u00b2, elsewhere and with directed "
              "forces some do. Right: a hand goes in circles of 5 mm five times a second, ticks of 1 ms. A strong fixed point "
              "uses up all that theorem B allows, a directed force that turns along knows no limit.",
          .width_px = 1120,
          .height_px = 400,
          .sheet = {.columns = 2, .panels = {ratios, turns}}};
}

}  // namespace
}  // namespace detail

std::vector<Figure> theory_figures() {
  return {detail::energy_figure(), detail::sum_figure(), detail::bound_figure(), detail::sweeps_figure(),
          detail::passivity_figure()};
}

}  // namespace palpa
