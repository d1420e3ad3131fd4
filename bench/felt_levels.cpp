// Levels: break-through, stiffness and positions.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "bench/felt.h"
#include "palpa/base/printed.h"
#include "palpa/data/quantile.h"
#include "palpa/device/hand.h"
#include "palpa/loop/loop.h"
#include "palpa/study/summary.h"

namespace palpa::bench {
namespace {

using detail::text;

const SurfaceAndFriction* surface_of(const SceneMode& mode) {
  return mode.enabled ? mode.mode.as<SurfaceAndFriction>() : nullptr;
}

struct Held {
  std::vector<double> depths_m, forces_n;
};

/// A least-squares line, and its quality of fit.
struct Line {
  double slope_n_per_m = 0.0;
  double correlation = 0.0;  ///< [1]
};
Line line_through(const Held& held) {
  const double count = static_cast<double>(held.forces_n.size());
  double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  for (std::size_t i = 0; i < held.forces_n.size(); ++i) {
    x += held.depths_m[i] / count;
    y += held.forces_n[i] / count;
  }
  for (std::size_t i = 0; i < held.forces_n.size(); ++i) {
    const double dx = held.depths_m[i] - x, dy = held.forces_n[i] - y;
    xx += dx * dx;
    xy += dx * dy;
    yy += dy * dy;
  }
  return xx > 0.0 && yy > 0.0 ? Line{xy / xx, xy / std::sqrt(xx * yy)} : Line{};
}

/// A slow press: the longest stay on each level met, by value. Depth is along the force, for inclined walls.
std::map<double, Held> levels_pressed(const Scene& scene, const FeltScene& felt, double u_m, double v_m) {
  constexpr double slow_m_per_s = 0.01;
  const auto hand = hand_device(press_at(felt.rigid, u_m, v_m, slow_m_per_s), Hold::rigid, {});
  Session session(scene);
  std::map<double, Held> all;
  std::optional<double> level;
  Held now;
  const auto leave = [&] {
    if (level && now.depths_m.size() > all[*level].depths_m.size()) all[*level] = now;
    now = {};
    level.reset();
  };
  Vec3 last_probe_m;
  run_simulated(session, *hand,
                {.rate_hz = rate_hz, .duration_s = press_duration_s(felt.rigid, slow_m_per_s), .time_ticks = false}, nullptr,
                [&](const TickFrame& frame, const Session& pressed) {
                  const double force_n = norm(frame.command.force_n);
                  for (const SessionEvent& event : pressed.events()) {
                    if (event.kind != SessionEventKind::onset && event.kind != SessionEventKind::break_through) continue;
                    const SurfaceAndFriction* surface = surface_of(scene.modes()[static_cast<std::size_t>(event.mode)]);
                    if (!surface || surface->levels.empty()) continue;
                    leave();
                    if (event.kind == SessionEventKind::onset) level = event.value;
                  }
                  if (level && frame.command.guard == GuardState::pass && force_n > contact_force_n) {
                    const double gone_m = -dot(frame.result.probe_m - last_probe_m, frame.command.force_n) / force_n;
                    now.depths_m.push_back((now.depths_m.empty() ? 0.0 : now.depths_m.back()) + gone_m);
                    now.forces_n.push_back(force_n);
                  }
                  last_probe_m = frame.result.probe_m;
                });
  leave();
  return all;
}

/// Stiffness [N/m] between 10 % and 90 % of the stay's largest force; 0 if too short or not straight.
double stiffness_n_per_m(const Held& held) {
  constexpr std::size_t least = 20;
  constexpr double straight = 0.99;
  if (held.forces_n.empty()) return 0.0;
  const double most_n = *std::max_element(held.forces_n.begin(), held.forces_n.end());
  Held middle;
  for (std::size_t i = 0; i < held.forces_n.size(); ++i) {
    if (held.forces_n[i] < 0.1 * most_n || held.forces_n[i] > 0.9 * most_n) continue;
    middle.depths_m.push_back(held.depths_m[i]);
    middle.forces_n.push_back(held.forces_n[i]);
  }
  const Line line = middle.forces_n.size() < least ? Line{} : line_through(middle);
  return line.correlation >= straight ? line.slope_n_per_m : 0.0;
}

/// Presses at nine positions: the slopes [N/m] on each level met.
std::map<double, std::vector<double>> slopes_pressed(const Scene& scene, const FeltScene& felt) {
  std::map<double, std::vector<double>> found;
  const double beside_m = 0.5 * felt.rigid.radius_m;
  for (const double u_m : {0.0, beside_m, -beside_m}) {
    for (const double v_m : {0.0, beside_m, -beside_m}) {
      for (const auto& [value, held] : levels_pressed(scene, felt, u_m, v_m)) {
        if (const double k = stiffness_n_per_m(held); k > 0.0) found[value].push_back(k);
      }
    }
  }
  return found;
}

/// The scene with one surface mode and these levels only, without friction and damper: its force is the surface's.
Scene bare_surface(const Scene& scene, const SceneMode& wanted, std::vector<SurfaceAndFriction::Level> levels) {
  Scene bare = scene;
  bare.edit<CouplingOptions>([&](auto& coupling) { coupling.damping_ns_per_m = 0.0; });
  for (const SceneMode& mode : scene.modes())
    bare.edit_mode(mode.name, [&](SceneMode& one) { one.enabled = one.name == wanted.name; });
  bare.edit<SurfaceAndFriction>(wanted.name, [&](SurfaceAndFriction& surface) {
    surface.friction_n = surface.friction_coefficient = 0.0;
    surface.flat_strength_n = Strength{0.0};
    surface.levels = std::move(levels);
    for (SurfaceAndFriction::Level& level : surface.levels) level.friction_n = level.friction_coefficient = std::nullopt;
  });
  return bare;
}

/// Each level alone, rigid and with two stiffnesses of its own: measured over set stiffness.
Figure felt_by_given(const FeltScene& felt) {
  const double k = felt.scene.coupling().stiffness_n_per_m;
  Figure figure{.name = "stiffness felt : given, each level alone", .asked = "1 +- 1 %", .applies = false};
  int presses = 0;
  double low = 1.0, high = 1.0;
  for (const SceneMode& mode : felt.scene.modes()) {
    const SurfaceAndFriction* surface = surface_of(mode);
    if (!surface) continue;
    for (SurfaceAndFriction::Level level : surface->levels) {
      for (const std::optional<double> own_n_per_m : {std::optional<double>{}, {0.5 * k}, {2.0 * k}}) {
        level.stiffness_n_per_m = own_n_per_m;
        const double given_n_per_m = own_n_per_m ? 1.0 / (1.0 / k + 1.0 / *own_n_per_m) : k;
        for (const auto& [value, slopes] : slopes_pressed(bare_surface(felt.scene, mode, {level}), felt)) {
          for (const double slope_n_per_m : slopes) {
            low = std::min(low, slope_n_per_m / given_n_per_m);
            high = std::max(high, slope_n_per_m / given_n_per_m);
            ++presses;
          }
        }
      }
    }
  }
  figure.applies = presses > 0;
  figure.measured = presses > 0 ? text("%.4f to %.4f, %d presses", low, high, presses) : "no level was pressed";
  figure.badness = std::max(high - 1.0, 1.0 - low);
  figure.met = figure.badness <= 0.01;
  return figure;
}

}  // namespace

std::vector<Figure> breaks(const FeltScene& felt) {
  constexpr double press_m_per_s = 0.02;
  double fall = 0.0, strongest_n = 0.0, limit_n = 0.0;
  int broken = 0, too_strong = 0;
  DevicePlant weak = device_plants().front();
  weak.limits.encoder_step_m = 0.0;
  const double beside_m = 0.5 * felt.rigid.radius_m;
  for (const DevicePlant& plant : {DevicePlant{}, weak}) {
    const double guard_n = std::min(felt.scene.coupling().max_force_n, plant.limits.max_force_n);
    for (const auto& [u_m, v_m] : {std::pair{0.0, 0.0}, {beside_m, 0.0}, {-beside_m, 0.0}, {0.0, beside_m}, {0.0, -beside_m}}) {
      const FeltRun run =
          feel(felt.scene, press_at(felt.rigid, u_m, v_m, press_m_per_s), press_duration_s(felt.rigid, press_m_per_s), plant);
      fall = std::max(fall, steepest_fall_n_per_ms(run));
      for (const FeltTick& tick : run.ticks) {
        broken += tick.broke_through;
        if (!tick.broke_through || tick.broke_force_n <= guard_n + felt_step_n) continue;
        ++too_strong;
        if (tick.broke_force_n > strongest_n) {
          strongest_n = tick.broke_force_n;
          limit_n = guard_n;
        }
      }
    }
  }
  return {{.name = "fall of the command at a break-through",
           .measured = broken > 0 ? text("%.2f N/ms, worst of %d", fall, broken) : "nothing breaks",
           .asked = "<= 0.5 N/ms",
           .met = fall <= 0.5,
           .badness = fall,
           .applies = broken > 0},
          {.name = "levels stronger than the guard that break",
           .measured =
               too_strong > 0 ? text("%d, at %.1f N, the guard lets %.1f N through", too_strong, strongest_n, limit_n) : "none",
           .asked = "none",
           .met = too_strong == 0,
           .badness = strongest_n,
           .applies = broken > 0}};
}

std::vector<Figure> stiffness(const FeltScene& felt) {
  std::map<double, std::vector<double>> found = slopes_pressed(felt.scene, felt);
  Figure figure{.name = "stiffness, last level : first", .asked = ">= 2"};
  std::string words;
  double first = 0.0, last = 0.0;
  for (auto& [value, all] : found) {
    last = detail::median(all);
    if (first == 0.0) first = last;
    words += text("%s%.0f N/m at %g", words.empty() ? "" : ", ", last, value);
  }
  figure.applies = found.size() >= 2;
  const double ratio = figure.applies ? last / first : 0.0;
  figure.measured = figure.applies  ? text("%.2f: ", ratio) + words
                    : found.empty() ? "no level was pressed"
                                    : "one level was pressed: " + words;
  figure.met = ratio >= 2.0;
  figure.badness = -ratio;
  return {figure, felt_by_given(felt)};
}

std::vector<Figure> normals(const FeltScene& felt) {
  constexpr double least_n = 0.05;
  constexpr int directions = 8;
  std::vector<double> angles_deg;
  for (const SceneMode& mode : felt.scene.modes()) {
    const SurfaceAndFriction* surface = surface_of(mode);
    if (!surface) continue;
    // Rigid: an elastic level pushes along the normal at its footing, not at the proxy.
    std::vector<SurfaceAndFriction::Level> levels = surface->levels;
    for (SurfaceAndFriction::Level& level : levels) level.stiffness_n_per_m = std::nullopt;
    const Scene bare = bare_surface(felt.scene, mode, levels);
    const FieldPtr field = bare.field(surface->field).field;
    const Similarity map = bare.hand_to_world();
    for (int d = 0; d < directions; ++d) {
      const HandSlide slide = slide_over(felt.held, d / static_cast<double>(directions), 0.0, felt.held.depth_m);
      const auto hand = hand_device(slide.target, Hold::relaxed);  // stays on the surface
      for (const FeltTick& tick : feel(bare, *hand, slide.to_s).ticks) {
        const Vec3 normal = map.gradient_to_hand(field->scalar(map.to_world(tick.proxy_m)).gradient);
        if (tick.t_s < slide.from_s || norm(tick.force_n) < least_n || !(norm(normal) > 0.0)) continue;
        // The rest of a broken level's force fades for milliseconds in its direction: no surface force.
        const double across = norm(cross(normalized(tick.force_n), normalized(normal)));
        angles_deg.push_back(std::asin(std::min(1.0, across)) * 180.0 / std::numbers::pi);
      }
    }
  }
  const bool any = !angles_deg.empty();
  const double p99 = detail::quantile(angles_deg, 0.99), half = detail::median(angles_deg);
  return {{.name = "force against the normal, 99 %",
           .measured = any ? text("%.2f deg, half below %.2f", p99, half) : "no surface is felt",
           .asked = "<= 1 deg",
           .met = p99 <= 1.0,
           .badness = p99,
           .applies = any}};
}

}  // namespace palpa::bench
