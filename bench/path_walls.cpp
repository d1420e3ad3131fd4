// Walls: none is passed by a stroke weaker than it.
#include <palpa/file/read_volume.h>
#include <palpa/scene/load_scene.h>

#include <cstdio>

#include "bench/path.h"
#include "tests/path/walls.h"

namespace palpa::bench {

using namespace palpa::test;

namespace {
constexpr WallKind kinds[] = {WallKind::plate_formula, WallKind::shell_formula,    WallKind::trilinear,
                              WallKind::smooth,        WallKind::trilinear_binary, WallKind::smooth_binary};
}

void walls(const PathOptions& options) {
  const int strokes = options.count > 0 ? options.count : 1000;
  std::printf("stronger than the stroke, 0.3 to 8 voxels thick, 0.1 to 10 m/s; depths in the solid in voxels\n");
  std::printf("%-18s %8s %8s %10s %10s %10s %10s %10s %11s %6s\n", "wall", "strokes", "passed", "not felt", "at a rim",
              "by a hole", "depth p99", "depth max", "unfinished", "first");
  for (const WallKind kind : kinds) {
    const Held h = measure_held_walls({.kind = kind, .strokes = strokes / 6 + 1});
    std::printf("%-18s %8d %8d %10d %10d %10d %10.4f %10.4f %11d %6d\n", name_of(kind), h.strokes, h.passed, h.never_felt,
                h.past_rims, h.through_holes, h.excess_p99_voxels, h.excess_max_voxels, h.unfinished, h.first_passed);
  }
  std::printf("weaker than the stroke\n");
  std::printf("%-18s %8s %14s %14s %10s\n", "wall", "strokes", "break-throughs", "without onset", "not told");
  for (const WallKind kind : kinds) {
    const WeakWallCounts l = measure_weak_walls({.kind = kind, .strokes = strokes / 6 + 1});
    std::printf("%-18s %8d %14d %14d %10d\n", name_of(kind), l.strokes, l.break_throughs, l.without_onset, l.missing);
  }
  const BreakThrough b = measure_break_through(strokes);
  std::printf("ball, formula: %d strokes, %d break-throughs, %d without onset; ||proxy - probe| - s/k| at most %.4f um\n",
              b.strokes, b.break_throughs, b.without_onset, 1e6 * b.depth_error_max_m);
}

void skull(const PathOptions& options) {
  if (options.data_folder.empty()) {
    std::printf("needs the folder of data\n");
    return;
  }
  const LoadedScene loaded = parse_scene(
      "palpa = 1\n[volume.head]\nfile = \"ct_head_cranium/cranium.mhd\"\nlength_unit = \"mm\"\n[[mode]]\nname = "
      "\"skull\"\ntype = \"surface_and_friction\"\nfield = \"head\"\n[[mode.level]]\nname = \"bone\"\nvalue = 300\n",
      "skull", options.data_folder, volume_reader(), standard_modes());
  const Field& head = *loaded.scene.volumes().front().volume.fields.front().field;
  std::printf("ct_head_cranium, 300 HU, 1 to 10 m/s from outside; depths in the solid in voxels of %.3f mm\n",
              1e3 * head.spacing_m());
  std::printf("%-10s %8s %8s %10s %10s %10s %10s %11s %6s\n", "filter", "strokes", "passed", "not felt", "> 0.1 deep",
              "depth p99", "depth max", "unfinished", "first");
  for (const Filter filter : {Filter::trilinear, Filter::smooth}) {
    const Skull s = measure_skull(in_floats(head, filter), {.strokes = options.count > 0 ? options.count : 1000});
    std::printf("%-10s %8d %8d %10d %10d %10.4f %10.4f %11d %6d\n", name_of(filter), s.strokes, s.passed, s.never_felt, s.deep,
                s.excess_p99_voxels, s.excess_max_voxels, s.unfinished, s.first_passed);
  }
}

}  // namespace palpa::bench
