#include "tests/path/scenes.h"

#include <cmath>
#include <numbers>
#include <sstream>

#include "palpa/loop/loop.h"
#include "tests/path/lines.h"
#include "tests/session/hands.h"

namespace palpa::test {

namespace {

constexpr double dt = 1e-3;
constexpr double felt_n = 1e-3;

class LargestDrag final : public ParameterVisitor {
 public:
  void number(const ParameterInfo& info, double& value) override {
    if (info.name == "drag_ns_per_m") largest = std::max(largest, value);
  }
  void list(const ParameterInfo&, ParameterList& list) override {
    for (std::size_t i = 0; i < list.size(); ++i) list.visit(i, *this);
  }
  double largest = 0.0;
};

struct Bounds {
  Vec3 low{1e9, 1e9, 1e9};
  Vec3 high{-1e9, -1e9, -1e9};
  void take(const Vec3& v) {
    low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
    high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
  }
  double size() const { return norm(high - low); }
};

// Shells met and pressed through in a run, in order.
struct EventList {
  std::vector<std::string> all;
  void take(const Scene& scene, const Session& session) {
    for (const SessionEvent& event : session.events()) {
      if (of_a_shell(scene, event)) all.push_back(std::string(name_of(event.kind)) + " " + std::to_string(event.mode));
    }
  }
};

}  // namespace

std::vector<Probe> felt_probes(const RunOptions& options) {
  PreparedRun prepared = prepare(options);
  Session session(prepared.loaded.scene);
  std::vector<Probe> probes;
  run_simulated(session, *prepared.hand, {.rate_hz = options.rate_hz, .duration_s = prepared.duration_s}, nullptr,
                [&](const TickFrame& frame, const Session&) {
                  probes.push_back({.position_m = frame.result.probe_m, .valid = frame.result.probe_valid});
                });
  return probes;
}

double scene_drag_ns_per_m(const Scene& scene) {
  LargestDrag drag;
  for (const SceneMode& mode : scene.modes()) {
    Mode copy = mode.mode;
    if (mode.enabled) copy.visit(drag);
  }
  return drag.largest;
}

Halving measure_halving(const Scene& scene, const std::vector<Probe>& probes) {
  constexpr std::size_t window = 50;
  const double voxel_m = finest_spacing_m(scene);
  Session usual(scene), halved(scene);
  halved.refine_path(2);
  Halving halving;
  std::vector<double> apart;
  int contact_ticks = 0;
  for (std::size_t begin = 0; begin < probes.size(); begin += window) {
    halved.copy_state_from(usual);
    EventList events, halved_events;
    int unmatched_since = -1;
    for (std::size_t i = begin; i < std::min(begin + window, probes.size()); ++i) {
      const Tick a = usual.tick(probes[i], dt);
      const Tick b = halved.tick(probes[i], dt);
      events.take(scene, usual);
      halved_events.take(scene, halved);
      if (events.all == halved_events.all) {
        unmatched_since = -1;
      } else if (unmatched_since < 0) {
        unmatched_since = static_cast<int>(i);
      }
      if (norm(a.force_n) <= felt_n) continue;
      ++contact_ticks;
      if (unmatched_since >= 0) {
        ++halving.after_differing;
      } else if (a.proxy_m == b.proxy_m) {
        ++halving.identical;
      } else {
        ++halving.compared;
        apart.push_back(distance(a.proxy_m, b.proxy_m) / voxel_m);
        if (apart.back() > halving.max_voxels) {
          halving.max_voxels = apart.back();
          halving.worst_tick = static_cast<int>(i);
        }
      }
    }
    if (unmatched_since >= 0) {
      ++halving.differing_events;
      halving.differing_ticks.push_back(unmatched_since);
    }
  }
  halving.contact_s = contact_ticks * dt;
  halving.p50_voxels = quantile(apart, 0.5);
  halving.p99_voxels = quantile(apart, 0.99);
  if (contact_ticks > 0) halving.differing_per_10_s = halving.differing_events / (halving.contact_s / 10.0);
  return halving;
}

Still measure_still(const Scene& scene, const StillCase& wanted) {
  constexpr int approach = 200;
  constexpr double from_m = 0.02;
  const double k = scene.coupling().stiffness_n_per_m;
  const int settling = 100 + static_cast<int>(std::ceil(8.0 * scene_drag_ns_per_m(scene) / k / dt));
  const int watched = wanted.tremor ? 250 : 20;
  Random random(wanted.seed);
  Scene held_still = scene;
  held_still.edit<TimeOptions>([&](auto& time) { time.play = TimeOptions::Play::hold; });
  Session session(held_still, wanted.encoder_step_m);
  Still still;
  std::vector<double> forces;
  for (int place = 0; place < wanted.places; ++place) {
    session.reset();
    const Vec3 held = random.in_cube(0.075);
    const Vec3 from = held + from_m * random.direction();
    Vec3 swing, hz, phase;
    if (wanted.tremor) {
      swing = random.uniform(2e-5, 1e-4) * random.direction();
      hz = {random.uniform(8, 12), random.uniform(8, 12), random.uniform(8, 12)};
      phase = random.in_cube(std::numbers::pi);
    }
    const auto read = [&](const Vec3& x) {
      const double q = wanted.encoder_step_m;
      return q > 0.0 ? q * Vec3{std::round(x.x / q), std::round(x.y / q), std::round(x.z / q)} : x;
    };
    Bounds forces_n, probes_m;
    Tick tick;
    for (int i = 0; i < approach + settling + watched; ++i) {
      const double share = std::min(1.0, static_cast<double>(i) / approach);
      const double turn = 2.0 * std::numbers::pi * i * dt;
      const Vec3 shake{swing.x * std::sin(hz.x * turn + phase.x), swing.y * std::sin(hz.y * turn + phase.y),
                       swing.z * std::sin(hz.z * turn + phase.z)};
      const Vec3 probe = read(from + share * (held - from) + shake);
      tick = session.tick({.position_m = probe}, dt);
      if (i < approach + settling) continue;
      forces_n.take(tick.force_n);
      probes_m.take(probe);
    }
    still.in_contact += norm(tick.force_n) > felt_n;
    // A drag follows an encoder step slowly: the extension is the step itself, then its reverse.
    const double reach = scene_drag_ns_per_m(scene) > 0.0 ? 2.0 : 1.0;
    const double slope = reach * k + 2.0 * std::numbers::pi * 150.0 * scene.coupling().damping_ns_per_m;
    const double beyond = forces_n.size() - slope * probes_m.size() - 1e-3;
    still.beyond += beyond > 0.0;
    if (beyond > still.beyond_max_n) {
      still.beyond_max_n = beyond;
      still.worst_m = held;
    }
    forces.push_back(forces_n.size());
  }
  still.force_p99_n = quantile(forces, 0.99);
  still.force_max_n = quantile(forces, 1.0);
  return still;
}

void measure_booked(const Scene& scene, int ticks, double reach_m, Random& random, Booked& booked) {
  const double k = scene.coupling().stiffness_n_per_m;
  Session session(scene);
  const Wander hand(random, reach_m);
  Vec3 proxy_before, probe_before;
  double stored_before_j = 0.0;
  for (int i = 0; i < ticks; ++i) {
    // Occasional jumps of the hand, as after a gap in the link.
    const Vec3 jump = random.below(500) == 0 ? random.in_cube(0.01) : Vec3{};
    const Vec3 probe = hand.at(i * dt) + jump;
    const Tick tick = session.tick({.position_m = probe}, dt);
    ++booked.ticks;
    booked.waiting += tick.status == TickStatus::waiting;
    std::vector<double> works(scene.modes().size());
    const Vec3 x0 = session.sub_steps().empty() ? tick.proxy_m : session.sub_steps().front().start_m;
    double spring_work_j = 0.0, path_limit_j = 0.0, forces_j = 0.0;
    Vec3 walked = session.sub_steps().empty() ? probe : session.sub_steps().front().probe_m;
    for (const SubStep& step : session.sub_steps()) {
      ++booked.sub_steps;
      const Vec3 moved = step.proxy_m - step.start_m;
      path_limit_j += k * distance(step.start_m, x0) * distance(step.probe_m, walked);
      walked = step.probe_m;
      spring_work_j += k * dot(step.balance.position_m - step.probe_m, moved);
      double beyond = 0.0;
      for (std::uint32_t p = 0; p < step.primitives; ++p) {
        const PlacedPrimitive& placed = session.primitives()[step.first_primitive + p];
        const double work = work_j(step, placed);
        works[placed.primitive.id.mode] += work;
        forces_j += norm(placed.force_n) * norm(moved);
        if (placed.primitive.kind == PrimitiveKind::directed) continue;
        // Of a slipping corner no facet by itself: the proxy may be in front of a facet on its way back to P.
        beyond += work - norm(placed.force_n) * distance(placed.primitive.position_m, step.start_m + placed.carried_m);
        const bool goes_on = placed.primitive.kind == PrimitiveKind::corner && p + 1 < step.primitives &&
                             session.primitives()[step.first_primitive + p + 1].primitive.id == placed.primitive.id;
        if (goes_on) continue;
        ++booked.primitives;
        if (step.balance.status != BalanceStatus::exact) beyond -= k * step.balance.error_bound_m * step.balance.error_bound_m;
        booked.primitive_beyond_j = std::max(booked.primitive_beyond_j, beyond);
        booked.primitives_beyond += beyond > 1e-15;
        beyond = 0.0;
      }
    }
    path_limit_j += k * distance(tick.proxy_m, x0) * distance(probe, walked);
    const std::span<const ModeForce> modes = session.modes();
    for (std::size_t m = 0; m < modes.size(); ++m) {
      booked.works_differ_j = std::max(booked.works_differ_j, std::abs(modes[m].injected_j - modes[m].dissipated_j - works[m]));
    }
    const double path_and_release_j = k * dot(tick.proxy_m - x0, 0.5 * (tick.proxy_m + x0) - probe) - spring_work_j;
    const double rounding_j = 1e-9 * forces_j;  // forces and k (b − p) agree to the balance's bound only
    booked.largest_path_j = std::max(booked.largest_path_j, tick.energy.path_and_release_j);
    booked.path_differs_j =
        std::max(booked.path_differs_j, std::abs(tick.energy.path_and_release_j - path_and_release_j) - rounding_j);
    booked.path_beyond_j = std::max(booked.path_beyond_j, tick.energy.path_and_release_j - path_limit_j - rounding_j);
    if (i > 0) {
      const Vec3 step = probe - probe_before;
      const double gained_j =
          tick.energy.injected_j - tick.energy.dissipated_j + tick.energy.path_and_release_j + tick.energy.data_motion_j;
      const double left_j = k * dot(proxy_before - probe_before, step);
      const double right_j = stored_before_j - tick.energy.stored_j + 0.5 * k * norm_squared(step) + gained_j;
      booked.identity_differs_j = std::max(booked.identity_differs_j, std::abs(left_j - right_j));
    }
    proxy_before = tick.proxy_m;
    probe_before = probe;
    stored_before_j = tick.energy.stored_j;
  }
}

void measure_closed_loop(const Scene& scene, int ticks, double reach_m, Random& random, ClosedLoop& loop) {
  constexpr double mass_kg = 0.2, arm_n_per_m = 200.0;
  constexpr int parts = 20;
  const double k = scene.coupling().stiffness_n_per_m;
  const double b = 0.5 * k * dt + scene.coupling().damping_ns_per_m;
  Session session(scene);
  const Wander wish(random, reach_m);
  Vec3 x = wish.at(0.0), v;
  Tick tick = session.tick({.position_m = x}, dt);
  double allowed_j = 0.0, floor_j = 0.0;
  const auto held_j = [&] { return 0.5 * mass_kg * norm_squared(v) + 0.5 * k * norm_squared(tick.proxy_m - x); };
  for (int i = 0; i < ticks; ++i, ++loop.ticks) {
    if (i % 1000 == 0) floor_j = held_j() - allowed_j;
    for (int part = 0; part < parts; ++part) {
      // Backward Euler: v⁺ = (m v + h F) / (m + h b), which gains no energy.
      const double h = dt / parts;
      const Vec3 arm_n = arm_n_per_m * (wish.at((i + (part + 0.5) / parts) * dt) - x);
      v = (mass_kg * v + h * (tick.force_n + arm_n)) / (mass_kg + h * b);
      x += h * v;
      allowed_j += dot(arm_n, h * v);
      loop.arm_work_j += std::abs(dot(arm_n, h * v));
    }
    tick = session.tick({.position_m = x}, dt);
    allowed_j += tick.energy.injected_j - tick.energy.dissipated_j + tick.energy.data_motion_j;
    loop.injected_j += tick.energy.injected_j;
    loop.path_and_release_j += std::max(0.0, tick.energy.path_and_release_j);
    loop.gained_j = std::max(loop.gained_j, held_j() - allowed_j - floor_j);
  }
}

std::string random_modes(Random& random, const std::vector<std::string>& scalars, const std::vector<std::string>& vectors) {
  const auto of = [&](const std::vector<std::string>& fields) {
    return fields[static_cast<std::size_t>(random.below(static_cast<int>(fields.size())))];
  };
  const auto newtons = [&](double low, double high) { return std::to_string(random.uniform(low, high)); };
  std::ostringstream out;
  int number = 0;
  const auto mode = [&](const char* type, const std::string& keys) {
    if (!standard_modes().find(type)) return;
    out << "[[mode]]\nname = \"m" << ++number << "\"\ntype = \"" << type << "\"\n" << keys;
  };
  const auto likely = [&] { return random.below(5) < 3; };
  const std::string solid = std::string("solid = \"") + (random.below(2) ? "high" : "low") + "\"\n";
  const std::string friction =
      random.below(2) ? "friction_n = " + newtons(0.05, 0.3) + "\n" : "friction_coefficient = " + newtons(0.05, 0.5) + "\n";
  if (!scalars.empty()) {
    // LEVEL and SPAN are numbers of the caller's data: NAME|LEVEL|SPAN.
    const std::string entry = of(scalars);
    const std::size_t first = entry.find('|'), second = entry.find('|', first + 1);
    const std::string name = entry.substr(0, first);
    const double level = std::stod(entry.substr(first + 1)), span = std::stod(entry.substr(second + 1));
    if (random.below(3) < 2) {
      std::string keys = "field = \"" + name + "\"\n" + solid + friction;
      for (int l = 0; l < 2; ++l) {
        keys += "[[mode.level]]\nname = \"l" + std::to_string(l) + "\"\nvalue = " + std::to_string(level + l * span) +
                "\nstrength_n = " + newtons(0.3, 6) + "\n";
      }
      mode("surface_and_friction", keys);
    } else {
      mode("surface_and_friction", "field = \"" + name + "\"\n" + solid + friction + "strength_n = {of = \"" + name +
                                       "\", points = [[" + std::to_string(level - span) + ", 0.1], [" +
                                       std::to_string(level + span) + ", " + newtons(0.3, 3) + "]], outside = 0.1}\n");
    }
    if (likely()) mode("gradient_force", "field = \"" + name + "\"\nstrength_n = " + newtons(0.1, 1) + "\n");
  }
  if (!vectors.empty()) {
    const auto field = [&] { return "field = \"" + of(vectors) + "\"\n"; };
    if (likely()) mode("follow", field() + "strength_n = " + newtons(0.1, 1) + "\ndrag_ns_per_m = " + newtons(0, 2) + "\n");
    if (likely()) mode("vector_force", field() + "strength_n = " + newtons(0.1, 1) + "\n");
    if (likely()) mode("vortex_force", field() + "strength_n = " + newtons(0.1, 1) + "\n");
    if (likely()) mode("vortex_plane", field() + "strength_n = " + newtons(0.1, 1) + "\n");
    if (likely()) mode("vortex_line", field() + "strength_n = " + newtons(0.1, 1) + "\n");
    if (likely()) mode("front_shape", field() + "strength_n = " + newtons(0.1, 1) + "\n");
    if (likely()) mode("transverse_damping", field() + "drag_ns_per_m = " + newtons(0.1, 2) + "\n");
  }
  if (number == 0 || likely()) {
    mode("viscosity", "strength_n = " + newtons(0.02, 0.3) + "\ndrag_ns_per_m = " + newtons(0.1, 2) + "\n");
  }
  return out.str();
}

}  // namespace palpa::test
