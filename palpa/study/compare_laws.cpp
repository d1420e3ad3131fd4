#include "palpa/study/compare_laws.h"

#include <algorithm>
#include <cmath>

#include "palpa/base/printed.h"
#include "palpa/baseline/law.h"
#include "palpa/data/quantile.h"
#include "palpa/loop/loop.h"
#include "palpa/loop/window_feed.h"
#include "palpa/mode/modes.h"

namespace palpa {

namespace {

// [1] Cosine of the angle between two planes' normals up to which they count as orthogonal. Less: rounded normals count as
// oblique; more: oblique primitives, which earlier laws balance wrongly, are missed.
constexpr double orthogonal_share = 1e-9;

bool are_orthogonal(const Primitive& a, const Primitive& b) noexcept {
  using enum PrimitiveKind;
  if (a.kind == directed || a.kind == point || b.kind == directed || b.kind == point) return true;
  if (a.kind == plane && b.kind == plane) return std::abs(dot(a.direction, b.direction)) <= orthogonal_share;
  // A line's span is perpendicular to it. Only a plane with its normal along the line is orthogonal to that.
  if ((a.kind == line && b.kind == plane) || (a.kind == plane && b.kind == line)) {
    return norm(cross(a.direction, b.direction)) <= orthogonal_share;
  }
  return false;
}

Scene with_law(Scene scene, const std::string& law) {
  scene.set_law(law);
  return scene;
}

// Earlier systems had no elastic levels.
Scene with_rigid_levels(Scene scene) {
  for (const SceneMode& mode : scene.modes()) {
    if (!mode.mode.as<SurfaceAndFriction>()) continue;
    scene.edit<SurfaceAndFriction>(mode.name, [](SurfaceAndFriction& surface) {
      for (SurfaceAndFriction::Level& level : surface.levels) level.stiffness_n_per_m = std::nullopt;
    });
  }
  return scene;
}

Spread spread_of(std::vector<double>& values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) { return values[detail::rank_of(share, values.size())]; };
  return {at(0.5), at(0.99), values.back()};
}

Spread times(double factor, const Spread& spread) { return {factor * spread.p50, factor * spread.p99, factor * spread.max}; }

// Proxy and force on the hand of a tick.
struct Felt {
  bool valid = false;
  Vec3 proxy_m;
  Vec3 force_n;
};

// Law applied to the balances of another law's session.
struct Asked {
  std::unique_ptr<Law> law;
  std::vector<double> errors_m;
};

void pose(PrimitiveSet& set, const SubStep& step, std::span<const PlacedPrimitive> placed) {
  set.clear(step.start_m);
  for (const PlacedPrimitive& p : placed) {
    set.begin_mode(p.primitive.id.mode,
                   p.primitive.position_m);  // a drag is at the start of the step, which this sub-step may continue
    set.add(p.primitive);
  }
}

}  // namespace

bool has_oblique_primitives(std::span<const PlacedPrimitive> placed) noexcept {
  for (std::size_t i = 0; i < placed.size(); ++i) {
    for (std::size_t j = i + 1; j < placed.size(); ++j) {
      if (!are_orthogonal(placed[i].primitive, placed[j].primitive)) return true;
    }
  }
  return false;
}

LawComparison compare_laws(const Scene& given, std::span<const Probe> probes, double time_step_s,
                           std::span<const std::string> laws) {
  const Scene scene = with_rigid_levels(given);
  const double k = scene.coupling().stiffness_n_per_m;
  LawComparison result;
  std::vector<Asked> asked;
  for (const std::string& name : laws) asked.push_back({baseline::law(with_law(scene, name).law()), {}});

  std::vector<Felt> exact;
  PrimitiveSet set;
  Session session(with_law(scene, "exact"));
  session.set_force_limit(scene.coupling().max_force_n);
  WindowFeed feed(session);
  for (const Probe& probe : probes) {
    const Tick tick = feed.tick(probe, time_step_s);
    exact.push_back({tick.probe_valid && tick.status != TickStatus::bad_input, tick.proxy_m, tick.force_n});
    result.ticks += exact.back().valid;
    for (const SubStep& step : session.sub_steps()) {
      if (step.primitives == 0) continue;
      const auto placed = session.primitives().subspan(step.first_primitive, step.primitives);
      const bool in_hollow = std::any_of(placed.begin(), placed.end(),
                                         [](const PlacedPrimitive& p) { return p.primitive.kind == PrimitiveKind::corner; });
      if (step.balance.status != BalanceStatus::exact || in_hollow) {
        ++result.left_out;
        continue;
      }
      ++result.balances;
      result.oblique_balances += has_oblique_primitives(placed);
      pose(set, step, placed);
      for (Asked& one : asked) {
        const Balance answer = one.law->solve(set, step.start_m, step.probe_m, step.stiffness_n_per_m, step.time_step_s);
        one.errors_m.push_back(distance(answer.position_m, step.balance.position_m));
      }
    }
  }

  for (std::size_t i = 0; i < laws.size(); ++i) {
    LawErrors errors{.law = laws[i]};
    errors.posed_m = spread_of(asked[i].errors_m);
    errors.posed_n = times(k, errors.posed_m);
    errors.posed_errors_m = std::move(asked[i].errors_m);

    Session alone(with_law(scene, laws[i]));
    alone.set_force_limit(scene.coupling().max_force_n);
    WindowFeed feed_alone(alone);
    std::vector<double> apart_m, apart_n;
    for (std::size_t t = 0; t < probes.size(); ++t) {
      const Tick tick = feed_alone.tick(probes[t], time_step_s);
      if (!exact[t].valid) continue;
      apart_m.push_back(distance(tick.proxy_m, exact[t].proxy_m));
      apart_n.push_back(distance(tick.force_n, exact[t].force_n));
      errors.alone_mean_n += apart_n.back() / static_cast<double>(result.ticks);
    }
    errors.alone_m = spread_of(apart_m);
    errors.alone_n = spread_of(apart_n);
    errors.alone_errors_n = std::move(apart_n);
    result.laws.push_back(std::move(errors));
  }
  return result;
}

LawComparison compare_laws(RunOptions options, std::span<const std::string> laws) {
  options.scene_options.sets.emplace_back("law.method", "exact");
  options.out.clear();
  const PreparedRun prepared = prepare(options);
  const Scene& scene = prepared.loaded.scene;
  std::vector<Probe> probes;
  Session session(scene);
  run_simulated(session, *prepared.hand, {.rate_hz = options.rate_hz, .duration_s = prepared.duration_s}, nullptr,
                [&](const TickFrame& frame, const Session&) {
                  probes.push_back({.position_m = frame.result.probe_m,
                                    .velocity_m_per_s = frame.result.probe_velocity_m_per_s,
                                    .valid = frame.result.probe_valid});
                });
  return compare_laws(scene, probes, 1.0 / options.rate_hz, laws);
}

std::string to_markdown(const LawComparison& comparison) {
  std::string text;
  const auto say = [&](const char* format, auto... values) { text += detail::text(format, values...); };
  const auto share = [](std::int64_t part, std::int64_t whole) {
    return whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0.0;
  };
  say("%lld balances of %lld ticks, %.1f %% of them with planes or lines that are not orthogonal; %lld left out.\n\n",
      static_cast<long long>(comparison.balances), static_cast<long long>(comparison.ticks),
      share(comparison.oblique_balances, comparison.balances), static_cast<long long>(comparison.left_out));
  text += "| the same balances | p50 mm | p99 mm | max mm | p50 N | p99 N | max N |\n|---|---|---|---|---|---|---|\n";
  for (const LawErrors& e : comparison.laws) {
    say("| `%s` | %.3g | %.3g | %.3g | %.3g | %.3g | %.3g |\n", e.law.c_str(), 1e3 * e.posed_m.p50, 1e3 * e.posed_m.p99,
        1e3 * e.posed_m.max, e.posed_n.p50, e.posed_n.p99, e.posed_n.max);
  }
  text += "\n| the same hand | p50 mm | p99 mm | mean N | p99 N |\n|---|---|---|---|---|\n";
  for (const LawErrors& e : comparison.laws) {
    say("| `%s` | %.3g | %.3g | %.3g | %.3g |\n", e.law.c_str(), 1e3 * e.alone_m.p50, 1e3 * e.alone_m.p99, e.alone_mean_n,
        e.alone_n.p99);
  }
  return text;
}

}  // namespace palpa
