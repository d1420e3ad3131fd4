// Along and across fields: drift of a follower, order of convergence, rate independence.
#include <palpa/data/analytic.h>
#include <palpa/file/read_volume.h>
#include <palpa/scene/load_scene.h>

#include <cstdio>
#include <numbers>

#include "bench/path.h"
#include "bench/path_scenes.h"
#include "palpa/data/sampled.h"
#include "tests/path/lines.h"

namespace palpa::bench {

using namespace palpa::test;

void follow(const PathOptions&) {
  std::printf("steps of L = 0.1 mm; bound: 1 %% of pi L = %.3f um per turn\n", 1e6 * 0.01 * std::numbers::pi * follow_step_m);
  std::printf("%-34s %10s %6s %16s %16s\n", "field", "radius mm", "turns", "first turn um", "per turn um");
  const auto row = [](const char* name, const FieldPtr& field, double radius_m, double rise_m) {
    constexpr int turns = 6;
    const FollowDrift d = measure_follow(field, radius_m, rise_m, turns);
    std::printf("%-34s %10.1f %6d %16.4f %16.4f\n", name, 1e3 * radius_m, turns, 1e6 * d.first_turn_m, 1e6 * d.per_turn_m);
  };
  for (const double radius : {0.010, 0.030}) {
    row("circles, formula", helical_field(0.0), radius, 0.0);
    row("helices, formula", helical_field(2e-3), radius, 2e-3);
  }
  const FieldPtr vortex = sampled(*lamb_oseen_vortex().fields.front().field, 128);
  for (const Filter filter : {Filter::trilinear, Filter::smooth}) {
    for (const double radius : {0.008, 0.010, 0.015}) {
      const std::string name = std::string("Lamb-Oseen in 128 samples, ") + name_of(filter);
      row(name.c_str(), in_floats(*vortex, filter), radius, 0.0);
    }
  }
}

void order(const PathOptions&) {
  std::printf(
      "steps of the hand felt in 1, 2, 4, 8 ticks, against 16; order: binary logarithm of how the difference of two "
      "shrinks; settled: within what a proxy may rest anywhere\n");
  std::printf("%-22s %7s %8s | %10s %10s %10s %10s um | %6s %6s %6s |\n", "mode", "step mm", "settled", "1", "2", "4", "8",
              "1-2-4", "2-4-8", "4-8-16");
  for (const OrderCase& one : order_cases()) {
    const Order o = measure_order(one);
    std::printf("%-22s %7.1f %8.3f | %10.4g %10.4g %10.4g %10.4g    | %6.2f %6.2f %6.2f |", one.name.c_str(), 1e3 * one.step_m,
                1e6 * o.settled_m, 1e6 * o.errors_m[0], 1e6 * o.errors_m[1], 1e6 * o.errors_m[2], 1e6 * o.errors_m[3],
                o.orders[0], o.orders[1], o.orders[2]);
    if (o.events > 0) std::printf(" %d events", o.events);
    if (!o.slides) std::printf(" does not slide");
    std::printf("\n");
  }
}

void rate(const PathOptions& options) {
  std::printf("one path of the hand at a tenth of its speed and at ten times it, beside itself; h: half the finest spacing\n");
  std::printf("%-18s %8s %8s %8s | %10s %10s h | %10s %10s h\n", "scene", "corners", "waiting", "events", "x0.1 p99", "max",
              "x10 p99", "max");
  for (const std::string& file : scene_files(options)) {
    const Scene scene = load_still(file, options, {{"coupling.damping_ns_per_m", "0"}});
    if (scene_drag_ns_per_m(scene) > 0.0) {
      std::printf("%-18s has drags: felt as fast as it is\n", short_name(file).c_str());
      continue;
    }
    std::vector<Vec3> corners;
    for (const Probe& probe : recorded_probes(file, options, 10.0)) corners.push_back(probe.position_m);
    std::vector<Vec3> every_10_ms;
    for (std::size_t i = 0; i < corners.size(); i += 10) every_10_ms.push_back(corners[i]);
    const Rate r = measure_rate({&scene, every_10_ms});
    std::printf("%-18s %8d %8d %8d | %10.4f %10.4f   | %10.4f %10.4f\n", short_name(file).c_str(), r.corners, r.waiting,
                r.differing, r.slow_p99_h, r.slow_max_h, r.fast_p99_h, r.fast_max_h);
  }
}

}  // namespace palpa::bench
