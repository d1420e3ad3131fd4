// Surfaces: drift, the bumpy sphere, grooves.
#include <palpa/data/analytic.h>

#include <cstdio>

#include "bench/path.h"
#include "tests/path/surfaces.h"

namespace palpa::bench {

using namespace palpa::test;

void drift(const PathOptions&) {
  std::printf("%-20s %6s %6s %18s %16s %16s\n", "sphere of 50 mm", "planes", "turns", "drift per turn", "off it, p50",
              "off it, p99");
  const auto row = [](const char* name, const FieldPtr& field, const DriftCase& wanted) {
    const Drift found = measure_drift(field, wanted);
    std::printf("%-20s %6d %6d %15.6f um %13.3f um %13.3f um\n", name, wanted.planes, wanted.turns, 1e6 * found.per_turn_m,
                1e6 * found.off_p50_m, 1e6 * found.off_p99_m);
  };
  row("formula", sphere_field(drift_sphere_m).fields.front().field, {.planes = 10, .turns = 100});
  for (const Filter filter : {Filter::trilinear, Filter::smooth, Filter::cubic}) {
    row(name_of(filter), sampled_sphere(filter), {.planes = filter == Filter::cubic ? 50 : 5, .turns = 100});
  }
}

void bumpy(const PathOptions&) {
  std::printf("%-9s %4s %5s | %5s | %15s | %15s | %15s | %6s %6s | %5s %5s %8s\n", "filter", "N", "cm/s", "ticks",
              "surface, voxels", "ideal, voxels", "direction, deg", "ideal", "still", "stray", "steps", "ready");
  std::printf("%-9s %4s %5s | %5s | %7s %7s | %7s %7s | %7s %7s | %6s %6s | %5s %5s %8s\n", "", "", "", "", "p50", "p99", "p50",
              "p99", "p50", "p99", "p99", "p99", "", "mean", "s");
  for (const int voxels : {128, 256}) {
    for (const Filter filter : {Filter::smooth, Filter::trilinear}) {
      for (const double speed : {0.05, 0.20}) {
        const Bumpy b = measure_bumpy({.voxels = voxels, .filter = filter, .speed_m_per_s = speed});
        std::printf("%-9s %4d %5.0f | %5d | %7.4f %7.4f | %7.4f %7.4f | %7.3f %7.3f | %6.3f %6.3f | %5d %5.2f %8.4f\n",
                    name_of(filter), voxels, 100 * speed, b.contact_ticks, b.surface_p50_voxels, b.surface_p99_voxels,
                    b.ideal_p50_voxels, b.ideal_p99_voxels, b.direction_p50_deg, b.direction_p99_deg, b.ideal_direction_p99_deg,
                    b.still_direction_p99_deg, b.stray_ticks, b.sub_steps_mean, b.preparation_s);
      }
    }
  }
}

void grooves(const PathOptions& options) {
  std::printf("%-9s %-7s %7s | %6s %12s %12s %9s %12s %12s %6s | %17s | %s\n", "filter", "edge", "opening", "ticks",
              "never rest", "…, still", "steps p99", "jump p99 N", "jump max N", "lost", "false rests",
              "break-throughs, false");
  for (const Filter filter : {Filter::trilinear, Filter::smooth}) {
    for (const bool binary : {false, true}) {
      for (const double opening : {20.0, 30.0, 40.0, 50.0, 60.0, 90.0, 120.0}) {
        const Groove g = measure_groove({.opening_deg = opening,
                                         .binary = binary,
                                         .filter = filter,
                                         .orientations = options.count > 0 ? options.count : 20});
        std::printf("%-9s %-7s %5.0f ° | %6d %10.2f %% %10.2f %% %9.0f %12.4f %12.4f %6d | %6d of %7d | %6d %6d\n",
                    name_of(filter), binary ? "binary" : "smooth", opening, g.ticks, 100 * g.never_rest_share,
                    100 * g.restless_still_share, g.sub_steps_p99, g.force_jump_p99_n, g.force_jump_max_n, g.lost_ticks,
                    g.false_rests, g.audited, g.break_throughs, g.false_break_throughs);
      }
    }
  }
}

}  // namespace palpa::bench
