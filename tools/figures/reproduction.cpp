#include "tools/figures/reproduction.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>

#include "palpa/base/load_error.h"
#include "palpa/baseline/law.h"
#include "palpa/data/analytic.h"
#include "palpa/device/hand.h"
#include "palpa/mode/mode.h"
#include "palpa/mode/modes.h"
#include "palpa/session/session.h"
#include "palpa/solver/solver.h"
#include "palpa/study/let_go.h"
#include "tools/figures/draw.h"

namespace palpa {
namespace {

constexpr double tick_s = 1e-3;
constexpr double k_n_per_m = 400.0;  // of every claim that names no other
constexpr double pi = std::numbers::pi;

// What counts as zero where the claim says "exactly": far below an encoder's step and what rounding leaves.
constexpr double exact_m = 1e-12;
constexpr double exact_n = 1e-9;

using Primitives = std::vector<Primitive>;

Balance balance_of(Law& law, const Primitives& primitives, const Vec3& start_m, const Vec3& probe_m) {
  PrimitiveSet set;
  set.clear(start_m);
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    Primitive primitive = primitives[i];
    primitive.id.slot = static_cast<std::uint16_t>(i);
    set.add(primitive);
  }
  return law.solve(set, start_m, probe_m, k_n_per_m, tick_s);
}

std::unique_ptr<Law> law_named(const char* name) {
  Scene scene;
  scene.law = name;
  return baseline::law(scene.law);
}

double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

ClaimResult result(int number, const char* claim, std::string measured, bool holds) {
  return {number, claim, std::move(measured), holds ? Verdict::holds : Verdict::does_not_hold, {}};
}

ClaimResult result_if(int number, const char* claim, std::string measured, bool condition_holds, const char* condition) {
  return {number, claim, std::move(measured), condition_holds ? Verdict::holds_with_a_condition : Verdict::does_not_hold,
          condition_holds ? condition : ""};
}

constexpr double strength_n = 1.2;
const Primitive plane{.kind = PrimitiveKind::plane, .direction = {0, 1, 0}, .strength_n = strength_n};

ClaimResult plane_holds() {
  Solver solver;
  double off_m = 0.0;
  for (int i = 0; i <= 1000; ++i) {
    const double depth_m = strength_n / k_n_per_m * i / 1000.0;
    off_m = std::max(off_m, std::abs(balance_of(solver, {plane}, {}, {0, -depth_m, 0}).position_m.y));
  }
  return result(1, "a plane keeps the proxy on it while the feedback is below its strength (Fig. 3 a-c)",
                fmt::format("furthest from the plane {:.1e} m, 1001 depths", off_m), off_m <= exact_m);
}

ClaimResult plane_gives_way() {
  Solver solver;
  double off_m = 0.0, jump = 0.0;
  Vec3 before_m;
  const double step_m = 1e-5;
  for (int i = 0; i <= 2000; ++i) {
    const int down = i <= 1000 ? i : 2000 - i;  // in, and out again
    const Vec3 probe_m{0, -step_m * down, 0};
    const Vec3 proxy_m = balance_of(solver, {plane}, before_m, probe_m).position_m;
    if (-probe_m.y > strength_n / k_n_per_m + exact_m)
      off_m = std::max(off_m, std::abs(distance(proxy_m, probe_m) - strength_n / k_n_per_m));
    if (i > 0) jump = std::max(jump, distance(proxy_m, before_m) / step_m);
    before_m = proxy_m;
  }
  return result(
      2, "beyond it the proxy follows below the plane, s/k from the probe (Fig. 3 d)",
      fmt::format("off s/k by {:.1e} m at most; on the way in and out the proxy moves by {:.3f} of the hand's step at most",
                  off_m, jump),
      off_m <= exact_m && jump <= 1.0 + 1e-9);
}

ClaimResult point_and_line() {
  Solver solver;
  double held_m = 0.0, slipped_m = 0.0, along_m = 0.0;
  Draw draw(3);
  for (const PrimitiveKind kind : {PrimitiveKind::point, PrimitiveKind::line}) {
    for (int i = 0; i < 2000; ++i) {
      const Primitive primitive{.kind = kind, .direction = {0, 0, 1}, .strength_n = strength_n};
      Vec3 probe_m = draw.in_cube(0.006);
      const Vec3 proxy_m = balance_of(solver, {primitive}, {}, probe_m).position_m;
      if (kind == PrimitiveKind::line) along_m = std::max(along_m, std::abs(proxy_m.z - probe_m.z));
      const Vec3 pulled_m = residual(primitive, probe_m);
      const double off_m = norm(residual(primitive, proxy_m));
      if (k_n_per_m * norm(pulled_m) <= strength_n) {
        held_m = std::max(held_m, off_m);
      } else {
        slipped_m = std::max(slipped_m, std::abs(distance(proxy_m, probe_m) - strength_n / k_n_per_m));
      }
    }
  }
  return result(3, "points and lines do likewise",
                fmt::format("off what holds {:.1e} m, off s/k {:.1e} m, along the line {:.1e} m at most, 4000 pulls", held_m,
                            slipped_m, along_m),
                std::max({held_m, slipped_m, along_m}) <= exact_m);
}

ClaimResult plane_and_point_balance() {
  const detail::PlaneAndPoint at = detail::plane_and_point();
  const double left_n = norm(at.plane_force_n + at.point_force_n + at.spring_force_n);
  return result(4, "a plane and a point balance the spring (Fig. 2)",
                fmt::format("{:.2f} N and {:.2f} N against {:.2f} N: {:.1e} N left over", norm(at.plane_force_n),
                            norm(at.point_force_n), norm(at.spring_force_n), left_n),
                left_n <= exact_n);
}

/// Where two planes without strength, their normals `angle_deg` apart, leave the proxy, as a share of the hand's way [1].
double share_of_way(const std::string& law, double angle_deg, const Vec3& direction) {
  constexpr double way_m = 0.01;
  return dot(detail::proxy_between_free_planes(law, angle_deg, way_m * direction), direction) / way_m;
}

constexpr Vec3 bisector{0, -1, 0}, across{1, 0, 0};

ClaimResult orthogonality() {
  double law_off = 0.0, ours = 0.0;
  for (int angle_deg = 10; angle_deg <= 170; angle_deg += 5) {
    const double expected = std::abs(std::cos(angle_deg * pi / 180.0));
    law_off = std::max(law_off, std::abs(std::abs(share_of_way("ikits-2003", angle_deg, bisector) - 1.0) - expected));
    ours = std::max(ours, std::abs(share_of_way("exact", angle_deg, bisector) - 1.0));
  }
  const double right_angle = std::abs(share_of_way("ikits-2003", 90.0, bisector) - 1.0);
  return result(
      5, "added moves are exact for orthogonal constraints only (Fig. 5)",
      fmt::format("at 90 degrees they miss the probe by {:.1e} of the way, at 60 by {:.3f}; off |cos| by {:.1e}; the balance "
                  "misses by {:.1e} at any angle",
                  right_angle, std::abs(share_of_way("ikits-2003", 60.0, bisector) - 1.0), law_off, ours),
      right_angle < 1e-9 && law_off < 1e-9 && ours < 1e-9);
}

ClaimResult too_large() {
  const double along = share_of_way("ikits-2003", 60.0, bisector), sideways = share_of_way("ikits-2003", 60.0, across);
  return result_if(6, "the individual movements are too large",
                   fmt::format("at 60 degrees {:.3f} of the way along the bisector, {:.3f} across it", along, sideways),
                   along > 1.0 && sideways < 1.0, "along what the axes share; across it they are too small");
}

Primitive random_primitive(Draw& draw) {
  constexpr PrimitiveKind kinds[] = {PrimitiveKind::point, PrimitiveKind::line, PrimitiveKind::plane, PrimitiveKind::directed};
  Primitive primitive{.kind = kinds[draw.below(4)]};
  primitive.position_m = draw.in_cube(1e-3);
  primitive.direction = draw.direction();
  primitive.strength_n = draw.uniform(0.1, 3.0);
  return primitive;
}

Primitives random_primitives(Draw& draw, std::size_t most) {
  Primitives primitives(1 + draw.below(most));
  for (Primitive& primitive : primitives) primitive = random_primitive(draw);
  return primitives;
}

ClaimResult any_set() {
  Draw draw(7);
  double bound_m = 0.0, order_m = 0.0;
  constexpr int sets = 20000;
  for (int i = 0; i < sets; ++i) {
    Primitives primitives = random_primitives(draw, 12);
    const Vec3 probe_m = draw.in_cube(5e-3);
    Solver one, other;
    const Balance first = balance_of(one, primitives, {}, probe_m);
    for (std::size_t n = primitives.size(); n > 1; --n) std::swap(primitives[n - 1], primitives[draw.below(n)]);
    const Balance second = balance_of(other, primitives, {}, probe_m);
    bound_m = std::max({bound_m, first.error_bound_m, second.error_bound_m});
    order_m = std::max(order_m, distance(first.position_m, second.position_m));
  }
  return result(
      7, "any set of primitives may be combined",
      fmt::format("{} sets of 1 to 12: proven within {:.1e} m of their one balance; another order moves it by {:.1e} m at most",
                  sets, bound_m, order_m),
      bound_m < 1e-6 && order_m <= 2.0 * bound_m);
}

ClaimResult unifies() {
  Draw draw(8);
  double directed_n = 0.0, step_m = 0.0;
  const std::unique_ptr<Law> earlier = law_named("ikits-2003");
  for (int i = 0; i < 5000; ++i) {
    Solver solver;
    const Primitive directed{.kind = PrimitiveKind::directed, .direction = draw.direction(), .strength_n = draw.uniform(0, 3)};
    const Vec3 probe_m = draw.in_cube(5e-3);
    const Vec3 felt_n = k_n_per_m * (balance_of(solver, {directed}, {}, probe_m).position_m - probe_m);
    directed_n = std::max(directed_n, distance(felt_n, directed.strength_n * directed.direction));
    const Vec3 x = draw.direction(), y = normalized(cross(x, draw.direction())), z = cross(x, y);
    Primitives axes;
    for (const Vec3& axis : {x, y, z})
      axes.push_back({.kind = PrimitiveKind::plane, .direction = axis, .strength_n = draw.uniform(0, 3)});
    solver.reset();
    earlier->reset();
    step_m = std::max(
        step_m, distance(balance_of(solver, axes, {}, probe_m).position_m, balance_of(*earlier, axes, {}, probe_m).position_m));
  }
  return result(
      8, "force functions and proxy methods are special cases",
      fmt::format("a directed force alone is felt as itself to {:.1e} N; orthogonal planes step as in 2003 to {:.1e} m, "
                  "5000 of each",
                  directed_n, step_m),
      directed_n <= exact_n && step_m <= exact_m);
}

ClaimResult friction() {
  constexpr double plane_n = 3.0, line_n = 0.3, depth_m = 0.004;
  const detail::FrictionLoop loop = detail::friction_loop(depth_m, plane_n, line_n, k_n_per_m, 0.005, 1000);
  const double cone_mm = 1e3 * line_n / k_n_per_m;
  double slid_mm = 0.0, kinetic_n = 0.0, normal_n = 0.0;
  for (std::size_t i = 0; i < loop.probe_mm.size() / 2; ++i) {
    if (loop.probe_mm[i] <= cone_mm) slid_mm = std::max(slid_mm, std::abs(loop.proxy_mm[i]));
    if (loop.probe_mm[i] > cone_mm + 1e-9) kinetic_n = std::max(kinetic_n, std::abs(std::abs(loop.friction_n[i]) - line_n));
    normal_n = std::max(normal_n, std::abs(loop.normal_n[i] - k_n_per_m * depth_m));
  }
  return result(
      9, "a plane and a line make a surface with friction (Fig. 4)",
      fmt::format("within the cone it slides {:.1e} mm; beyond it {:.1e} N from the line's strength; {:.1e} N from k depth",
                  slid_mm, kinetic_n, normal_n),
      slid_mm <= 1e-9 && kinetic_n <= exact_n && normal_n <= exact_n);
}

/// The vortex of claims 10 and 11: along the world's z axis.
constexpr double core_m = 0.01;
Volume vortex() { return lamb_oseen_vortex(0.02, core_m); }

/// Feels one mode at `radius_m` [world m] from the vortex' axis: what the session placed when the hand rested there and then
/// went 0.1 mm on.
template <class Mode>
std::vector<PlacedPrimitive> placed_at(const Mode& mode_of_field, double radius_m) {
  Scene scene({.stiffness_n_per_m = k_n_per_m});
  Mode mode = mode_of_field;
  mode.field = scene.add("vortex", vortex());
  scene.add("mode", mode);
  Session session(scene);
  const Similarity map = session.hand_to_world();
  std::vector<PlacedPrimitive> placed;
  for (int i = 0; i < 20; ++i) {
    session.tick({.position_m = map.to_hand({radius_m + 5e-6 * i, 0, 0})}, tick_s);
    placed.assign(session.placed().begin(), session.placed().end());
  }
  for (PlacedPrimitive& p : placed) p.primitive.direction = map.turned_to_world(p.primitive.direction);
  return placed;
}

ClaimResult follows() {
  Scene scene({.stiffness_n_per_m = k_n_per_m});
  const FieldRef flow = scene.add("vortex", vortex());
  scene.add("rail", Follow{.field = flow, .strength_n = Strength(2.0)});
  Session session(scene);
  const Similarity map = session.hand_to_world();
  const double radius_m = 0.02;
  double drift_m = 0.0, along_n = 0.0, across_n = 0.0;
  // The hand pulls outwards by half of what the rail bears, and leads the proxy round three times.
  const double pull_m = map.scale * 0.5 * 2.0 / k_n_per_m;
  for (int i = 0; i < 6000; ++i) {
    const double turn = 2.0 * pi * std::max(0, i - 300) / 1900.0;
    const double out_m = radius_m + (i < 300 ? pull_m * i / 300.0 : pull_m);
    const Vec3 radial{std::cos(turn), std::sin(turn), 0};
    const Tick tick = session.tick({.position_m = map.to_hand(out_m * radial)}, tick_s);
    drift_m = std::max(drift_m, std::abs(norm(map.to_world(tick.proxy_m)) - radius_m));
    across_n = std::max(across_n, std::abs(dot(map.turned_to_world(tick.force_n), radial)));
    if (i > 300) along_n = std::max(along_n, std::abs(dot(map.turned_to_world(tick.force_n), cross({0, 0, 1}, radial))));
  }
  return result(
      10, "the follow mode restricts motion across the field",
      fmt::format(
          "three turns round a vortex, pulled outwards: {:.3f} N across the flow, {:.3f} N along it, drift {:.1e} mm of "
          "20 mm",
          across_n, along_n, 1e3 * drift_m),
      drift_m < 0.05 * radius_m && along_n < 0.05 && across_n > 0.9);
}

struct CoreDirection {
  double radius_m = 0.0;                    ///< [world m] from the axis
  double plane_deg = 0.0, force_deg = 0.0;  ///< between the direction and the way to the core
  double plane_n = 0.0, force_n = 0.0;      ///< strength with which the mode acts there
};

std::vector<CoreDirection> core_directions() {
  std::vector<CoreDirection> directions;
  for (int i = 1; i <= 36; ++i) {
    CoreDirection at{.radius_m = 0.05 * core_m * i};
    const auto to = [&](const std::vector<PlacedPrimitive>& placed, double& angle_deg, double& n) {
      for (const PlacedPrimitive& p : placed) {
        if (p.primitive.strength_n <= 0.0) continue;
        angle_deg = std::acos(std::clamp(-p.primitive.direction.x, -1.0, 1.0)) * 180.0 / pi;
        n = p.primitive.strength_n;
      }
    };
    to(placed_at(VortexPlane{.strength_n = Strength(1.0)}, at.radius_m), at.plane_deg, at.plane_n);
    to(placed_at(VortexForce{.strength_n = Strength(1.0)}, at.radius_m), at.force_deg, at.force_n);
    directions.push_back(at);
  }
  return directions;
}

/// The most that a hand feels [N] on its way in to the axis, and out again.
struct Outwards {
  double most_n = 0.0;
  double on_the_way_in_n = 0.0;
};
template <class Mode>
Outwards outwards(Mode mode) {
  Scene scene({.stiffness_n_per_m = k_n_per_m});
  mode.field = scene.add("vortex", vortex());
  scene.add("mode", mode);
  Session session(scene);
  const Similarity map = session.hand_to_world();
  Outwards felt;
  for (int i = 0; i <= 8000; ++i) {
    const double share = i <= 4000 ? 1.0 - i / 4000.0 : (i - 4000) / 4000.0;  // in to the axis, and out
    const Tick tick = session.tick({.position_m = map.to_hand({0.0001 + 0.03 * share, 0, 0})}, tick_s);
    double& most_n = i <= 4000 ? felt.on_the_way_in_n : felt.most_n;
    most_n = std::max(most_n, norm(tick.force_n));
  }
  return felt;
}

ClaimResult vortex_plane(const std::vector<CoreDirection>& directions) {
  double plane_deg = 0.0, force_deg = 0.0;
  int planes = 0, forces = 0;
  for (const CoreDirection& at : directions) {
    if (at.plane_n > 0.0) ++planes, plane_deg = std::max(plane_deg, at.plane_deg);
    if (at.force_n > 0.0) ++forces, force_deg = std::max(force_deg, at.force_deg);
  }
  const Outwards plane_felt = outwards(VortexPlane{.strength_n = Strength(1.0)});
  const Outwards force_felt = outwards(VortexForce{.strength_n = Strength(1.0)});
  return result_if(11, "the vortex plane conveys place, shape and extension better than the force",
                   fmt::format("plane and force point to the core within {:.2f} and {:.2f} degrees; the hand feels outwards "
                               "{:.2f} N and inwards {:.2f} N at most "
                               "with the plane, {:.2f} N and {:.2f} N with the force; they act at {} and {} of {} radii",
                               plane_deg, force_deg, plane_felt.most_n, plane_felt.on_the_way_in_n, force_felt.most_n,
                               force_felt.on_the_way_in_n, planes, forces, directions.size()),
                   plane_deg < 1.0 && plane_felt.on_the_way_in_n < 0.05 * plane_felt.most_n,
                   "for shape and extension: the plane lets in and holds back, so it has an inside, and a force has none; the "
                   "place both convey alike. "
                   "What people recognise was measured neither by the paper nor here");
}

ClaimResult viscosity() {
  double coulomb_n = 0.0, viscous_n = 0.0;
  for (const bool wet : {false, true}) {
    for (const double speed_m_per_s : {0.01, 0.02, 0.05, 0.1, 0.2, 0.5}) {
      Scene scene({.stiffness_n_per_m = k_n_per_m});
      scene.add("syrup", wet ? Viscosity{.drag_ns_per_m = 2.0} : Viscosity{.strength_n = Strength(0.5)});
      Session session(scene);
      Tick tick;
      for (int i = 0; i < 2000; ++i) tick = session.tick({.position_m = {speed_m_per_s * tick_s * (i - 1000), 0, 0}}, tick_s);
      const double expected_n = wet ? 2.0 * speed_m_per_s : 0.5;
      double& off_n = wet ? viscous_n : coulomb_n;
      off_n = std::max(off_n, std::abs(norm(tick.force_n) - expected_n));
    }
  }
  return result_if(
      12, "a point makes viscosity",
      fmt::format(
          "with a strength the force is 0.5 N at 0.01 to 0.5 m/s, to {:.1e} N; with a drag 2 N s/m x speed, to {:.1e} N",
          coulomb_n, viscous_n),
      coulomb_n < 1e-6 && viscous_n < 1e-6, "a strength alone is dry friction, the same at any speed; viscosity takes a drag");
}

/// A set in contact: two or three planes and lines at the proxy, pulled by less than they bear.
struct PaperError {
  double error_m = 0.0;
  double error_n = 0.0;
  int steps = 0;
};
std::vector<PaperError> paper_errors(int sets) {
  Draw draw(13);
  const std::unique_ptr<Law> paper = law_named("paper-2005");
  std::vector<PaperError> errors;
  while (static_cast<int>(errors.size()) < sets) {
    Primitives primitives{{.kind = PrimitiveKind::plane, .direction = draw.direction(), .strength_n = draw.uniform(0.5, 3)},
                          {.kind = PrimitiveKind::plane, .direction = draw.direction(), .strength_n = draw.uniform(0.5, 3)},
                          {.kind = PrimitiveKind::line, .direction = draw.direction(), .strength_n = draw.uniform(0.1, 1)}};
    const Vec3 probe_m = draw.in_cube(5e-3);
    Solver solver;
    paper->reset();
    const Balance exact = balance_of(solver, primitives, {}, probe_m);
    const Balance theirs = balance_of(*paper, primitives, {}, probe_m);
    const double off_m = distance(exact.position_m, theirs.position_m);
    errors.push_back({off_m, k_n_per_m * off_m, theirs.iterations});
  }
  return errors;
}

ClaimResult adaptive_solver(const std::vector<PaperError>& errors) {
  std::vector<double> off_n, steps;
  for (const PaperError& error : errors) {
    off_n.push_back(error.error_n);
    steps.push_back(error.steps);
  }
  constexpr double felt_n = 0.05;  // a tenth of a force of half a newton: about what a hand can tell
  const double half_n = percentile(off_n, 0.5), most_n = percentile(off_n, 0.99);
  const auto felt = std::count_if(off_n.begin(), off_n.end(), [](double n) { return n > felt_n; });
  const double felt_share = static_cast<double>(felt) / static_cast<double>(errors.size());
  std::string measured = fmt::format(
      "two planes and a line at random angles, one frame: the force is off by {:.3f} N in half of {} sets, by more than {} N "
      "in {:.0f} % "
      "and by {:.2f} N in the worst 1 %; {:.0f} steps in half, {:.0f} at most",
      half_n, errors.size(), felt_n, 100.0 * felt_share, most_n, percentile(steps, 0.5), percentile(steps, 1.0));
  return result_if(13, "an adaptive step-length solver suffices in the loop", std::move(measured), felt_share < 0.1,
                   "where an error that can be felt is allowed in few sets");
}

ClaimResult layers() {
  Scene scene({.stiffness_n_per_m = k_n_per_m});
  const FieldRef wall = scene.add("wall", plane_field());
  const double strengths_n[] = {0.5, 1.0, 2.0};
  SurfaceAndFriction skins{.field = wall, .levels = {}};
  for (int i = 0; i < 3; ++i) skins.levels.push_back({.value = 0.01 * i, .strength_n = Strength(strengths_n[i])});
  scene.add("skins", skins);
  Session session(scene);
  const Similarity map = session.hand_to_world();
  const Vec3 wall_m = map.to_hand({0, 0, 0}), into_wall = map.direction_to_hand({0, 0, -1});
  double off_n = 0.0;
  int through = 0;
  for (int i = -100; i < 6000; ++i) {
    session.tick({.position_m = wall_m + 1e-5 * i * into_wall}, tick_s);
    for (const SessionEvent& event : session.events()) {
      if (event.kind != SessionEventKind::break_through || through >= 3) continue;
      off_n = std::max(off_n, std::abs(k_n_per_m * event.depth_m - strengths_n[through++]));
    }
  }
  return result(14, "surfaces that can be pressed through, without an intermediate surface",
                fmt::format("{} of 3 nested levels, pressed through at 0.5, 1 and 2 N to {:.4f} N", through, off_n),
                through == 3 && off_n <= k_n_per_m * 1e-5 + 1e-9);  // a tick's step of the hand
}

ClaimResult modes_are_short(const std::filesystem::path& examples_folder) {
  const std::filesystem::path file = examples_folder / "03_own_mode.cpp";
  std::ifstream text(file);
  int lines = 0;
  bool inside = false;
  for (std::string line; std::getline(text, line);) {
    inside |= line.starts_with("struct ");
    lines += inside;
    if (line == "};") break;
  }
  if (lines == 0) throw LoadError(file.string() + ": has no struct of a mode; give the folder of the examples");
  return result_if(
      15, "rapid development of modes",
      fmt::format("{} modes beside a solver that knows none of them; a whole new one in {} lines (examples/03_own_mode.cpp)",
                  standard_modes().modes().size(), lines),
      lines < 50, "counted in lines; nobody was timed");
}

constexpr const char* devices[] = {"touch", "desktop", "omega", "falcon", "inverse3"};

/// A device as in docs/felt.md: without the friction that would hide what the loop does, and with some damping.
DevicePlant bare_plant(const char* name) {
  DevicePlant plant = device_plant(name);
  plant.coulomb_friction_n = 0.0;
  plant.damping_ns_per_m = std::max(0.1, plant.damping_ns_per_m);
  return plant;
}

/// The stiffness [N/m] up to which every one of a ladder comes to rest: with an encoder there are stiffer ones that do, above
/// some that do not, which bisection would hit or miss. From 100 N/m on: softer, a coarse encoder alone keeps a device moving.
double stable_n_per_m(const DevicePlant& plant, double damping_ns_per_m) {
  const LetGoOptions options{.plant = plant, .damping_ns_per_m = damping_ns_per_m};
  double stable = 0.0;
  for (double k = 100.0; k < 6000.0 && comes_to_rest(options, k); k *= 1.05) stable = k;
  return stable;
}

struct Stable {
  double at_0 = 0.0, at_1 = 0.0, at_4 = 0.0;  ///< [N/m] by D [N s/m]
  double passive = 0.0;                       ///< [N/m] 2b/T: below it no hand whatever makes the loop hum, D = 0
  double device_damping_ns_per_m = 0.0;
};
std::vector<Stable> stable_devices() {
  std::vector<Stable> all;
  for (const char* name : devices) {
    const DevicePlant plant = bare_plant(name);
    all.push_back({stable_n_per_m(plant, 0.0), stable_n_per_m(plant, 1.0), stable_n_per_m(plant, 4.0),
                   2.0 * plant.damping_ns_per_m / tick_s, plant.damping_ns_per_m});
  }
  return all;
}

std::string list_of(const std::vector<Stable>& all, double Stable::*of) {
  std::string words;
  for (std::size_t i = 0; i < all.size(); ++i) words += fmt::format("{}{} {:.0f}", i ? ", " : "", devices[i], all[i].*of);
  return words;
}

ClaimResult stable(const std::vector<Stable>& all) {
  bool usable = true;
  for (const Stable& device : all) usable &= device.at_1 >= 500.0;
  return result_if(
      16, "stable on the data that were felt",
      fmt::format("a device that is let go on a plane comes to rest up to [N/m], D = 1 N s/m: {}; D = 0: {}; 2b/T: {}",
                  list_of(all, &Stable::at_1), list_of(all, &Stable::at_0), list_of(all, &Stable::passive)),
      usable,
      "up to a stiffness that the device sets and the paper does not name; on models of devices without delay, no device was "
      "tried");
}

ClaimResult damping(const std::vector<Stable>& all) {
  int raises = 0, raises_more = 0, passive = 0;
  for (const Stable& device : all) {
    raises += device.at_1 > device.at_0;
    raises_more += device.at_4 > device.at_1;
    passive += device.device_damping_ns_per_m > 1.0;
  }
  return result_if(
      17, "the damping D of Eq. 1 steadies the loop",
      fmt::format(
          "D = 1 against 0 raises the stiffness that comes to rest on {} of {} devices, D = 4 against 1 on {}; at D = 4 "
          "[N/m]: {}; b > kT/2 + D, which would hold for any hand, can hold at D = 1 on {}",
          raises, all.size(), raises_more, list_of(all, &Stable::at_4), passive),
      raises == static_cast<int>(all.size()), "for a device that is let go, and a D that is not too large; not for every hand");
}

}  // namespace

std::vector<ClaimResult> reproduced_claims(const std::filesystem::path& examples_folder) {
  const std::vector<Stable> devices_stable = stable_devices();
  return {plane_holds(),
          plane_gives_way(),
          point_and_line(),
          plane_and_point_balance(),
          orthogonality(),
          too_large(),
          any_set(),
          unifies(),
          friction(),
          follows(),
          vortex_plane(core_directions()),
          viscosity(),
          adaptive_solver(paper_errors(5000)),
          layers(),
          modes_are_short(examples_folder),
          stable(devices_stable),
          damping(devices_stable)};
}

std::vector<Figure> reproduction_figures() {
  Plot moves{.title = "Two constraints without strength",
             .x_label = "angle between them / degrees",
             .y_label = "move / way of the hand",
             .x_range = std::pair{0.0, 180.0},
             .y_range = std::pair{0.0, 2.0}};
  Series along{.name = "2003, along the bisector", .color = CurveColor::vermilion},
      aside{.name = "2003, across it", .color = CurveColor::orange};
  Series ours{.name = "balance", .color = CurveColor::blue};
  for (int angle_deg = 5; angle_deg <= 175; angle_deg += 5) {
    for (Series* series : {&along, &aside, &ours}) series->xs.push_back(angle_deg);
    along.ys.push_back(share_of_way("ikits-2003", angle_deg, bisector));
    aside.ys.push_back(share_of_way("ikits-2003", angle_deg, across));
    ours.ys.push_back(share_of_way("exact", angle_deg, bisector));
  }
  moves.series = {along, aside, ours};

  Plot vortices{.title = "A vortex, from its axis out",
                .x_label = "distance from the axis / core radius",
                .y_label = "strength / N",
                .y_range = std::pair{0.0, 1.2}};
  Series plane_n{.name = "plane", .color = CurveColor::blue}, force_n{.name = "directed force", .color = CurveColor::vermilion};
  for (const CoreDirection& at : core_directions()) {
    plane_n.xs.push_back(at.radius_m / core_m);
    plane_n.ys.push_back(at.plane_n);
    force_n.xs.push_back(at.radius_m / core_m);
    force_n.ys.push_back(at.force_n);
  }
  vortices.series = {plane_n, force_n};

  Plot errors{.title = "The paper's solver on two planes and a line",
              .x_label = "error of the force / N",
              .y_label = "sets / %",
              .x_range = std::pair{1e-12, 10.0},
              .y_range = std::pair{0.0, 100.0},
              .x_log = true};
  std::vector<double> off_n;
  for (const PaperError& error : paper_errors(5000)) off_n.push_back(error.error_n);
  std::sort(off_n.begin(), off_n.end());
  Series shares = detail::shares_up_to(off_n, 1e-12);
  shares.name = "up to this error";
  shares.color = CurveColor::vermilion;
  errors.series = {shares};

  Plot limits{.title = "Let go on a plane", .x_label = "damping D / N s/m", .y_label = "stiffest that rests / N/m"};
  const CurveColor colors[] = {CurveColor::black, CurveColor::blue, CurveColor::vermilion, CurveColor::green,
                               CurveColor::purple};
  for (std::size_t i = 0; i < std::size(devices); ++i) {
    // The last lie on curves before them, which are seen between the dashes.
    Series series{.name = devices[i], .color = colors[i], .stroke = i >= 3 ? Stroke::dashed : Stroke::solid};
    for (const double damping : {0.0, 0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0}) {
      series.xs.push_back(damping);
      series.ys.push_back(stable_n_per_m(bare_plant(devices[i]), damping));
    }
    limits.series.push_back(series);
  }
  return {{.name = "claims",
           .caption = "Claims 5 and 6, 11, 13, and 16 and 17.",
           .width_px = 1120,
           .height_px = 760,
           .sheet = {.columns = 2, .panels = {moves, vortices, errors, limits}}}};
}

std::string to_markdown(const std::vector<ClaimResult>& claims) {
  std::string text = "| # | claim | measured | verdict |\n|---|---|---|---|\n";
  for (const ClaimResult& claim : claims) {
    const char* verdict = claim.verdict == Verdict::holds                    ? "**holds**"
                          : claim.verdict == Verdict::holds_with_a_condition ? "**holds with a condition**: "
                                                                             : "**does not hold**";
    text += fmt::format("| {} | {} | {} | {}{} |\n", claim.number, claim.claim, claim.measured, verdict, claim.condition);
  }
  return text;
}

}  // namespace palpa
