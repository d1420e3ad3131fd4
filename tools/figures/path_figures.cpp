#include "tools/figures/path_figures.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "palpa/data/analytic.h"
#include "palpa/data/grid.h"
#include "palpa/data/volume.h"
#include "palpa/mode/modes.h"
#include "palpa/report/html.h"
#include "palpa/session/session.h"

namespace palpa {
namespace detail {
namespace {

constexpr double tick_s = 1e-3;
constexpr double pi = std::numbers::pi;

Session session_of(const Scene& scene, Walked walked) {
  return walked == Walked::path ? Session(scene) : Session::in_one_step(scene);
}

/// A plane through the proxy, wherever it is: Eq. 7 of the paper with the local normal.
struct PlaneAtProxy {
  static constexpr auto type = "figures.plane_at_proxy";
  static constexpr auto summary = "A plane through the proxy.";
  FieldRef field{};
  double strength_n = 0.0;
  static constexpr auto parameters() {
    return std::tuple{param("field", &PlaneAtProxy::field, "scalar field, high where it is solid"),
                      param("strength_n", &PlaneAtProxy::strength_n, "force that the plane bears", Range{0, 1000})};
  }
  void place(const ModeContext& here, PrimitiveSink out) const noexcept {
    const ScalarSample sample = here.scalar(field);
    if (sample.inside && sample.gradient != Vec3{}) out.plane(0, here.proxy_m, -normalized(sample.gradient), strength_n);
  }
};

/// A plate across x: value = how deep [m] a place lies in it.
class Plate final : public Field {
 public:
  explicit Plate(double thickness_m) : half_m_(0.5 * thickness_m) {}
  int components() const noexcept override { return 1; }
  ScalarSample scalar(const Vec3& x) const noexcept override {
    if (!(depth_m(x) >= 0.0)) return {};
    return {half_m_ - std::abs(x.x - half_m_), {x.x < half_m_ ? 1.0 : -1.0, 0, 0}, true};
  }
  double spacing_m() const noexcept override { return 1e-3; }
  Box bounds_m() const noexcept override { return {{-box_m, -box_m, -box_m}, {box_m, box_m, box_m}}; }
  double depth_m(const Vec3& x) const noexcept override {
    return is_finite(x) ? box_m - std::max({std::abs(x.x), std::abs(x.y), std::abs(x.z)}) : -box_m;
  }
  std::vector<ValueRange> value_ranges() const override { return {{-box_m - half_m_, half_m_}}; }

 private:
  static constexpr double box_m = 0.2;
  double half_m_;
};

/// One hand metre is one metre of the data, axes and origins together.
Scene plain_scene(double stiffness_n_per_m) {
  Scene scene({.stiffness_n_per_m = stiffness_n_per_m});
  scene.workspace.scale = 1.0;
  scene.workspace.center_m = Vec3{};
  scene.workspace.towards_user = "+z";
  scene.workspace.up = "+y";
  return scene;
}

Volume volume_of(FieldPtr field) {
  Volume volume;
  volume.fields = {{"depth", "m", std::move(field)}};
  volume.format = "formula";
  return volume;
}

SurfaceAndFriction skin(const FieldRef& field, double strength_n) {
  return {.field = field, .levels = {{.name = "skin", .value = 0.0, .strength_n = strength_n}}};
}

}  // namespace

std::vector<double> off_sphere_m(Walked walked, bool on_level, double speed_m_per_s, double turns) {
  Scene scene = plain_scene(800.0);
  const FieldRef ball = scene.add("ball", sphere_field(drift_radius_m));
  if (on_level) {
    scene.add("surface", skin(ball, 100.0));
  } else {
    scene.add("surface", PlaneAtProxy{.field = ball, .strength_n = 100.0});
  }
  // A plane through the proxy that lies anyhow in space.
  const Vec3 e1 = normalized({1.0, 0.3, 0.2}), e2 = normalized(cross(e1, Vec3{0.2, -0.1, 1.0}));
  const auto at = [&](double angle, double radius_m) { return radius_m * (std::cos(angle) * e1 + std::sin(angle) * e2); };
  const double radius_m = drift_radius_m - drift_depth_m;
  Session session = session_of(scene, walked);
  // The plane at the proxy is where the hand begins, the level is where it is met.
  if (on_level) session.tick({.position_m = at(0.0, drift_radius_m + 1e-4)}, tick_s);
  session.tick({.position_m = at(0.0, drift_radius_m)}, tick_s);
  for (int i = 1; i <= 20; ++i) session.tick({.position_m = at(0.0, drift_radius_m - 0.05 * i * drift_depth_m)}, tick_s);
  const int ticks = static_cast<int>(std::ceil(2.0 * pi * radius_m / (speed_m_per_s * tick_s)));
  std::vector<double> off_m;
  for (int i = 1; i <= turns * ticks; ++i)
    off_m.push_back(norm(session.tick({.position_m = at(2.0 * pi * i / ticks, radius_m)}, tick_s).proxy_m) - drift_radius_m);
  return off_m;
}

InGroove press_into_groove(Walked walked) {
  constexpr double voxel_m = 1e-3, k = 800.0, strength_n = 4.0, opening_rad = 40.0 * pi / 180.0;
  constexpr int voxels = 44;
  // The grid is turned about the groove, so that its cells lie anyhow across.
  constexpr double turn_rad = 0.15;
  const double c = std::cos(0.5 * opening_rad), s = std::sin(0.5 * opening_rad);
  GridGeometry geometry;
  geometry.dims = {voxels, voxels, voxels};
  geometry.index_to_world_m =
      voxel_m * Mat3{{{std::cos(turn_rad), -std::sin(turn_rad), 0}, {std::sin(turn_rad), std::cos(turn_rad), 0}, {0, 0, 1}}};
  const double half = 0.5 * (voxels - 1);
  geometry.origin_m = -(geometry.index_to_world_m * Vec3{half, half, half});
  auto raw = std::make_shared<std::vector<float>>();
  raw->reserve(static_cast<std::size_t>(geometry.voxels()));
  for (int l = 0; l < voxels; ++l) {
    for (int j = 0; j < voxels; ++j) {
      for (int i = 0; i < voxels; ++i) {
        const Vec3 x = geometry.to_world({double(i), double(j), double(l)});
        const double depth_m = std::max(-(c * x.x + s * x.y), -(-c * x.x + s * x.y));
        raw->push_back(static_cast<float>(std::clamp(depth_m, -3 * voxel_m, 3 * voxel_m)));
      }
    }
  }
  const FieldPtr field = grid_field(geometry, {VoxelType::float32, 1, std::shared_ptr<const void>(raw, raw->data())});
  Scene scene = plain_scene(k);
  const FieldRef solid = scene.add("solid", volume_of(field));
  scene.add("surface", skin(solid, strength_n));
  Session session = session_of(scene, walked);

  InGroove found;
  const auto go_to = [&](const Vec3& probe_m) {
    const Tick tick = session.tick({.position_m = probe_m}, tick_s);
    found.force_n.push_back(tick.force_n);
    found.proxies_m.push_back(tick.proxy_m);
  };
  const double press_m = 0.85 * strength_n * s / k;
  const double aside_m = 0.1 * voxel_m, top_m = 3e-3;
  double y_m = top_m;
  for (; y_m > -press_m; y_m -= 0.05 * tick_s) go_to({aside_m, y_m, 0});
  found.still_from = found.force_n.size();
  for (int i = 0; i < 100; ++i) go_to({aside_m, y_m, 0});
  found.probe_m = {aside_m, y_m, 0};
  found.planes.assign(session.placed().begin() + session.sub_steps().back().first_primitive, session.placed().end());
  found.slides_from = found.force_n.size();
  for (int i = 1; i <= 150; ++i) {
    const double z = 0.05 * tick_s * i;
    go_to({aside_m + 0.1 * voxel_m * std::sin(2.0 * pi * z / 5e-3), y_m, z});
  }

  // From above down to the level, once across.
  constexpr double top_of_section_m = 4e-3;
  for (double x = -2.4e-3; x <= 2.4e-3; x += 0.01 * voxel_m) {
    double open = top_of_section_m, shut = open;
    const auto is_open = [&](double y) { return field->scalar({x, y, 0}).value < 0.0; };
    if (!is_open(open)) continue;
    while (is_open(shut)) shut = (open = shut) - 0.02 * voxel_m;
    for (int i = 0; i < 30; ++i) {
      const double middle = 0.5 * (open + shut);
      (is_open(middle) ? open : shut) = middle;
    }
    found.level_m.push_back({x, open, 0});
  }
  return found;
}

ThroughWall stroke_through_wall(Walked walked, double speed_m_per_s, double first_m) {
  Scene scene = plain_scene(800.0);
  const FieldRef wall = scene.add("wall", volume_of(std::make_shared<Plate>(wall_m)));
  scene.add("surface", skin(wall, 20.0));
  Session session = session_of(scene, walked);
  ThroughWall found;
  for (double x = -0.012 + first_m; x < 0.010 + speed_m_per_s * tick_s; x += speed_m_per_s * tick_s) {
    const Tick tick = session.tick({.position_m = {x, 1e-3, 2e-3}}, tick_s);
    found.probe_m.push_back(x);
    found.proxy_m.push_back(tick.proxy_m.x);
  }
  return found;
}

namespace {

/// A hand on a circle that tilts and breathes, curved in space everywhere; it comes from outside, so that surfaces are met.
Convergence converge(std::string name, const Scene& scene, const Vec3& centre_m, double radius_m) {
  constexpr int most = 16, warm_up = 200, ticks = 150;
  constexpr double way_m = 3e-4;
  const auto hand = [&](int tick) {
    const double a = way_m / radius_m * tick, r = radius_m * (1.0 + 0.1 * std::sin(0.7 * a));
    return Probe{centre_m + Vec3{r * std::cos(a), r * std::sin(a), 0.1 * radius_m * std::sin(1.3 * a)}};
  };
  Session begun(scene);
  begun.refine_path(most);
  for (double above_m = 0.012; above_m > 0.0; above_m -= 1e-4) begun.tick({hand(0).position_m + Vec3{0, 0, above_m}}, tick_s);
  for (int i = 0; i < warm_up; ++i) begun.tick(hand(i), tick_s);

  Convergence found{std::move(name), {}, {}};
  std::vector<Vec3> before;
  for (int steps = 1; steps <= most; steps *= 2) {
    Session session(scene);
    session.refine_path(steps);
    session.copy_state_from(begun);
    std::vector<Vec3> path;
    for (int i = warm_up; i < warm_up + ticks; ++i) path.push_back(session.tick(hand(i), tick_s).proxy_m);
    double apart_m = 0.0;
    for (std::size_t i = 0; i < before.size(); ++i) apart_m = std::max(apart_m, distance(before[i], path[i]));
    if (!before.empty()) {
      found.steps_m.push_back(2.0 * way_m / steps);
      found.differences_m.push_back(apart_m);
    }
    before = std::move(path);
  }
  return found;
}

Convergence converge_in_ball(std::string name, const Mode& mode) {
  Scene scene = plain_scene(500.0);
  scene.add("ball", sphere_field());
  scene.add("felt", mode);
  return converge(std::move(name), scene, {0, 0, 0.0465}, 0.010);
}

Convergence converge_in_vortex(std::string name, const Mode& mode, double centre_m) {
  Scene scene = plain_scene(500.0);
  scene.add("flow", lamb_oseen_vortex());
  scene.add("felt", mode);
  return converge(std::move(name), scene, {centre_m, 0, 0}, centre_m < 0.005 ? 0.005 : 0.006);
}

}  // namespace

std::vector<Convergence> convergence_in_scalars() {
  const FieldRef ball{"ball"};
  SurfaceAndFriction constant = skin(ball, 20.0), coulomb = skin(ball, 20.0);
  constant.friction_n = 0.2;
  coulomb.friction_coefficient = 0.15;
  const SurfaceAndFriction material{
      .field = ball, .strength_n = Strength(ball, TransferFunction({{-0.01, 0.2}, {0.05, 0.4}})), .friction_n = 0.1};
  return {converge_in_ball("surface", skin(ball, 20.0)),
          converge_in_ball("surface, friction_n", constant),
          converge_in_ball("surface, coefficient", coulomb),
          converge_in_ball("material, friction_n", material),
          converge_in_ball("viscosity", Viscosity{.field = ball, .strength_n = 0.5}),
          converge_in_ball("viscosity, drag", Viscosity{.field = ball, .drag_ns_per_m = 1.0}),
          converge_in_ball("gradient_force", GradientForce{.field = ball, .strength_n = 1.0})};
}

std::vector<Convergence> convergence_in_vectors() {
  const FieldRef flow{"flow"};
  const Strength viscous(FieldRef{"magnitude(flow)"}, TransferFunction({{0.0, 0.1}, {1.0, 3.0}}));
  return {converge_in_vortex("follow", Follow{.field = flow, .strength_n = 0.5}, 0.010),
          converge_in_vortex("follow, drag", Follow{.field = flow, .strength_n = 0.0, .drag_ns_per_m = 1.0}, 0.010),
          converge_in_vortex("viscosity of field", Viscosity{.strength_n = viscous}, 0.010),
          converge_in_vortex("front_shape", FrontShape{.field = flow, .strength_n = 0.3}, 0.010),
          converge_in_vortex("vector_force", VectorForce{.field = flow, .strength_n = 0.5}, 0.015),
          converge_in_vortex("vortex_force", VortexForce{.field = flow, .strength_n = 0.3}, 0.004),
          converge_in_vortex("vortex_plane", VortexPlane{.field = flow, .strength_n = 0.3}, 0.0),
          converge_in_vortex("transverse_damping", TransverseDamping{.field = flow, .drag_ns_per_m = 1.0}, 0.010),
          converge_in_vortex("vortex_line", VortexLine{.field = flow, .strength_n = 0.3}, 0.004)};
}

namespace {

struct Scheme {
  const char* name;
  Walked walked;
  bool on_level;
  CurveColor color;
  Stroke stroke;
};
constexpr Scheme schemes[] = {{"at the proxy, one step", Walked::one_step, false, CurveColor::vermilion, Stroke::solid},
                              {"at the proxy, path", Walked::path, false, CurveColor::orange, Stroke::dashed},
                              {"on the level, one step", Walked::one_step, true, CurveColor::green, Stroke::solid},
                              {"on the level, path (ours)", Walked::path, true, CurveColor::blue, Stroke::solid}};

Figure drift_figure() {
  constexpr double least_um = 1e-10, speed = 0.4, turns = 3.0;
  Plot turning{.title = text("Turn by turn, at %.1f m/s", speed),
               .x_label = "turns",
               .y_label = "off the sphere / mm",
               .x_range = std::pair{0.0, turns},
               .y_range = std::pair{-0.5, 4.5}};
  Plot drift{.title = "After one turn",
             .x_label = "speed of the hand / (m/s)",
             .y_label = "off the sphere / \u00b5m",
             .x_range = std::pair{0.01, 10.0},
             .y_range = std::pair{least_um, 1e6},
             .x_log = true,
             .y_log = true};
  for (const Scheme& scheme : schemes) {
    Series once{.name = scheme.name, .color = scheme.color, .stroke = scheme.stroke};
    for (const double at : {0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0}) {
      once.xs.push_back(at);
      once.ys.push_back(std::max(least_um, 1e6 * std::abs(off_sphere_m(scheme.walked, scheme.on_level, at).back())));
    }
    drift.series.push_back(std::move(once));
    Series series{.color = scheme.color, .stroke = scheme.stroke};
    const std::vector<double> off_m = off_sphere_m(scheme.walked, scheme.on_level, speed, turns);
    for (std::size_t i = 0; i < off_m.size(); ++i) {
      series.xs.push_back(turns * static_cast<double>(i + 1) / static_cast<double>(off_m.size()));
      series.ys.push_back(1e3 * off_m[i]);
    }
    turning.series.push_back(std::move(series));
  }
  drift.series.push_back({.name = "pi v T",
                          .xs = {0.01, 10.0},
                          .ys = {1e6 * pi * 0.01 * tick_s, 1e6 * pi * 10.0 * tick_s},
                          .color = CurveColor::black,
                          .stroke = Stroke::dotted});
  return {.name = "path-drift",
          .caption =
              "A hand goes round 1 mm below a sphere of 50 mm, ticks of T = 1 ms, balances exact. A plane through the "
              "proxy leaves the sphere by \u03c0 v T in each turn; on the path its normal is that of the middle of the "
              "step, and far less is left. On the level that was met there is no drift, only, in one step a tick, the sag "
              "of one step; on the path none but rounding.",
          .width_px = 1120,
          .height_px = 400,
          .sheet = {.columns = 2, .panels = {turning, drift}}};
}

Figure groove_figure() {
  const InGroove ours = press_into_groove(Walked::path), theirs = press_into_groove(Walked::one_step);
  const auto mm = [](const Vec3& at_m) { return DrawingPoint{1e3 * at_m.x, 1e3 * at_m.y}; };
  Drawing section{.title = "Across the groove, hand still", .low = {-2.4, -2.0}, .high = {2.4, 4.0}};
  std::vector<DrawingPoint> level;
  for (const Vec3& at_m : ours.level_m) level.push_back(mm(at_m));
  std::vector<DrawingPoint> solid = level;
  solid.insert(solid.end(), {{2.4, 4.0}, {2.4, -2.0}, {-2.4, -2.0}, {-2.4, 4.0}});
  section.area(solid, CurveColor::grey);
  section.path(level, CurveColor::black, Stroke::solid, 2.0f);
  constexpr double mm_per_n = 0.5;
  const Vec3 proxy_m = ours.proxies_m[ours.slides_from - 1];
  for (const PlacedPrimitive& placed : ours.planes) {
    if (!(norm(placed.force_n) > 1e-3)) continue;
    const Vec3 n = placed.primitive.direction;
    const Vec3 along = normalized({n.y, -n.x, 0});
    section.path({mm(proxy_m - 1.5e-3 * along), mm(proxy_m + 1.5e-3 * along)}, CurveColor::vermilion, Stroke::dashed);
    section.arrow(mm(proxy_m), mm(proxy_m + 1e-3 * mm_per_n * placed.force_n), CurveColor::vermilion);
  }
  section.path({mm(ours.probe_m), mm(proxy_m)}, CurveColor::blue, Stroke::dotted);
  section.dot(mm(ours.probe_m), CurveColor::blue);
  section.ring(mm(proxy_m), CurveColor::blue, 5.0f);
  section.text({mm(ours.probe_m).x_mm + 0.2, mm(ours.probe_m).y_mm}, "probe", -1, CurveColor::blue);
  section.path({{-2.2, -1.7}, {-1.2, -1.7}}, CurveColor::black, Stroke::solid, 2.0f);
  section.text({-1.7, -1.5}, "1 mm");

  const double end_s = tick_s * static_cast<double>(ours.force_n.size());
  Plot up{.title = "Force out of the groove",
          .x_label = "time / s",
          .y_label = "force / N",
          .x_range = std::pair{0.0, end_s},
          .y_range = std::pair{-0.1, 2.4}};
  Plot across{.title = "Force across it",
              .x_label = "time / s",
              .y_label = "force / N",
              .x_range = std::pair{0.0, end_s},
              .y_range = std::pair{-1.1, 1.1}};
  for (const std::size_t tick : {ours.still_from, ours.slides_from}) {
    const double t = tick_s * static_cast<double>(tick);
    for (Plot* plot : {&up, &across})
      plot->series.push_back({.xs = {t, t},
                              .ys = {plot->y_range->first, plot->y_range->second},
                              .color = CurveColor::grey,
                              .stroke = Stroke::dotted});
  }
  for (const auto& [groove, color] : {std::pair{&theirs, CurveColor::vermilion}, std::pair{&ours, CurveColor::blue}}) {
    Series y{.color = color}, x{.name = groove == &ours ? "ours" : "one step a tick", .color = color};
    for (std::size_t i = 0; i < groove->force_n.size(); ++i) {
      const double t = tick_s * static_cast<double>(i);
      y.xs.push_back(t);
      y.ys.push_back(groove->force_n[i].y);
      x.xs.push_back(t);
      x.ys.push_back(groove->force_n[i].x);
    }
    up.series.push_back(std::move(y));
    across.series.push_back(std::move(x));
  }
  return {.name = "path-groove",
          .caption =
              "A hand presses into a groove of 40 degrees in voxels of 1 mm, then holds still, then slides along it "
              "(dotted lines); 800 N/m, strength 4 N. Left: the level, and the planes that hold the proxy (ring) in one "
              "balance, with their forces. With one plane at a time each side leads into the other: the proxy is "
              "thrown from side to side and sinks in, the hand still or not.",
          .width_px = 1240,
          .height_px = 400,
          .sheet = {.columns = 3, .panels = {section, up, across}}};
}

Figure wall_figure() {
  constexpr double speed = 2.0;
  constexpr int strokes = 40;
  Plot stroke{.title = text("One stroke, %.0f m/s", speed),
              .x_label = "probe / mm",
              .y_label = "proxy / mm",
              .x_range = std::pair{-6.0, 10.0},
              .y_range = std::pair{-6.0, 10.0}};
  Plot passed{.title = text("%d strokes at each speed", strokes),
              .x_label = "speed / (m/s)",
              .y_label = "proxies behind the wall / %",
              .x_range = std::pair{0.01, 10.0},
              .y_range = std::pair{-3.0, 103.0},
              .x_log = true};
  for (const double face_mm : {0.0, 1e3 * wall_m})
    stroke.series.push_back({.xs = {-6.0, 10.0}, .ys = {face_mm, face_mm}, .color = CurveColor::grey});
  for (const auto& [walked, color] :
       {std::pair{Walked::one_step, CurveColor::vermilion}, std::pair{Walked::path, CurveColor::blue}}) {
    Series points{.color = color, .points_only = true};
    const ThroughWall found = stroke_through_wall(walked, speed, 0.7e-3);
    for (std::size_t i = 0; i < found.probe_m.size(); ++i) {
      points.xs.push_back(1e3 * found.probe_m[i]);
      points.ys.push_back(1e3 * found.proxy_m[i]);
    }
    Series line = points;
    line.points_only = false;
    stroke.series.push_back(std::move(line));
    stroke.series.push_back(std::move(points));
    Series share{.name = walked == Walked::path ? "ours" : "one step a tick", .color = color};
    for (const double at : {0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0}) {
      int behind = 0;
      for (int i = 0; i < strokes; ++i)
        behind += stroke_through_wall(walked, at, at * tick_s * (i + 0.5) / strokes).proxy_m.back() > wall_m;
      share.xs.push_back(at);
      share.ys.push_back(100.0 * behind / strokes);
    }
    passed.series.push_back(std::move(share));
  }
  return {.name = "path-wall",
          .caption =
              "Straight strokes into a wall of 0.3 mm (grey) that bears more than the whole stroke, 800 N/m, ticks of "
              "1 ms. A step that ends behind the wall has never seen it, or finds itself nearer to its back. On the path "
              "the wall is met where it is, at any speed.",
          .width_px = 1120,
          .height_px = 400,
          .sheet = {.columns = 2, .panels = {stroke, passed}}};
}

Plot order_plot(std::string title, const std::vector<Convergence>& modes) {
  constexpr CurveColor colors[] = {CurveColor::blue,   CurveColor::vermilion, CurveColor::green, CurveColor::orange,
                                   CurveColor::purple, CurveColor::sky,       CurveColor::black};
  Plot plot{.title = std::move(title),
            .x_label = "step of the hand / \u00b5m",
            .y_label = "change when the step is halved / \u00b5m",
            .x_range = std::pair{10.0, 1000.0},
            .y_range = std::pair{1e-5, 1e3},
            .x_log = true,
            .y_log = true};
  const auto slope = [&](const char* name, int order, double at_left_um, Stroke stroke) {
    plot.series.push_back({.name = name,
                           .xs = {37.5, 300.0},
                           .ys = {at_left_um, at_left_um * std::pow(8.0, order)},
                           .color = CurveColor::grey,
                           .stroke = stroke});
  };
  slope("order 1", 1, 20.0, Stroke::dashed);
  slope("order 2", 2, 2e-5, Stroke::dotted);
  for (std::size_t i = 0; i < modes.size(); ++i) {
    Series series{.name = modes[i].mode,
                  .color = colors[i % std::size(colors)],
                  .stroke = i < std::size(colors) ? Stroke::solid : Stroke::dashed};
    for (std::size_t n = 0; n < modes[i].steps_m.size(); ++n) {
      series.xs.push_back(1e6 * modes[i].steps_m[n]);
      series.ys.push_back(std::max(1e-5, 1e6 * modes[i].differences_m[n]));
    }
    plot.series.push_back(std::move(series));
  }
  return plot;
}

Figure order_figure() {
  return {.name = "path-order",
          .caption =
              "How the path converges: a hand on a curved way, 0.3 mm a tick, in 1, 2, 4, 8 and 16 steps a tick; the "
              "largest distance between the paths of each and of twice as many. Left in a ball, right in a "
              "Lamb-Oseen vortex.",
          .width_px = 1240,
          .height_px = 520,
          .sheet = {.columns = 2,
                    .panels = {order_plot("Scalar fields", convergence_in_scalars()),
                               order_plot("Vector fields", convergence_in_vectors())}}};
}

}  // namespace
}  // namespace detail

std::vector<Figure> path_figures() {
  return {detail::drift_figure(), detail::groove_figure(), detail::wall_figure(), detail::order_figure()};
}

}  // namespace palpa
