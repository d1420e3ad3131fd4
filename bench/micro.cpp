// Single parts of a tick, at changing positions against branch prediction.
#include <benchmark/benchmark.h>
#include <palpa/data/smooth_grid.h>
#include <palpa/mode/crossings.h>
#include <palpa/palpa.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "palpa/data/sampled.h"

namespace {

using namespace palpa;

std::vector<Vec3> positions_in(const Box& box, std::size_t count) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<Vec3> positions(count);
  for (Vec3& x : positions) {
    const Vec3 size_m = box.size_m();
    x = box.low_m + Vec3{unit(random) * size_m.x, unit(random) * size_m.y, unit(random) * size_m.z};
  }
  return positions;
}

/// A balance of `planes` planes in general position, and the line of their friction.
void solve(benchmark::State& state) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  PrimitiveSet set;
  set.clear({});
  set.begin_mode(0);
  for (std::uint16_t i = 0; i < state.range(0); ++i) {
    set.plane(i, {}, normalized({0.3 * normal(random), 0.3 * normal(random), 1.0}), 1.0);
  }
  set.line(100, {}, {0, 0, 1}, 0.1);
  Solver solver;
  double lateral_m = 0.0;
  for (auto _ : state) {
    lateral_m = lateral_m > 1e-3 ? 0.0 : lateral_m + 1e-5;
    benchmark::DoNotOptimize(solver.solve(set, {}, {lateral_m, 0.0, -1e-3}, 500.0, 1e-3));
  }
}
BENCHMARK(solve)->ArgName("planes")->Arg(1)->Arg(2)->Arg(4)->Arg(8);

void sample(benchmark::State& state, const Volume& volume) {
  const Field& field = *volume.fields.front().field;
  const std::vector<Vec3> positions = positions_in(field.bounds_m(), 4096);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(field.scalar(positions[i++ % positions.size()]));
}
BENCHMARK_CAPTURE(sample, head_phantom_formula, head_phantom());
BENCHMARK_CAPTURE(sample, head_phantom_grid_128_trilinear_anywhere, sampled(head_phantom(), 128));

/// 256³ voxels of int16, 1 mm: a ball of 1000 with an edge, in noise of ±30.
Voxels ball_in_noise(std::int64_t n) {
  const auto voxels = std::make_shared<std::vector<std::int16_t>>();
  std::mt19937 random(3);
  for (std::int64_t k = 0; k < n; ++k) {
    for (std::int64_t j = 0; j < n; ++j) {
      for (std::int64_t i = 0; i < n; ++i) {
        const double half = 0.5 * static_cast<double>(n);
        const double r = std::hypot(double(i) - half, double(j) - half, double(k) - half);
        const double value = 500.0 - 500.0 * std::tanh((r - 0.3 * static_cast<double>(n)) / 3.0);
        voxels->push_back(static_cast<std::int16_t>(value + static_cast<double>(random() % 61) - 30.0));
      }
    }
  }
  return {VoxelType::int16, 1, std::shared_ptr<const void>(voxels, voxels->data())};
}
constexpr std::int64_t bench_voxels = 256;
const GridGeometry bench_geometry{{bench_voxels, bench_voxels, bench_voxels}, 1e-3 * Mat3::identity(), {}};

FieldPtr bench_grid(bool smooth) {
  static const Voxels voxels = ball_in_noise(bench_voxels);
  static const FieldPtr grids[] = {grid_field(bench_geometry, voxels), smooth_grid_field(bench_geometry, voxels)};
  return grids[smooth ? 1 : 0];
}

/// Reads all voxels of a grid for the value ranges of grid and bricks.
void make_grid(benchmark::State& state, bool smooth) {
  const Voxels voxels = ball_in_noise(bench_voxels);
  for (auto _ : state) {
    benchmark::DoNotOptimize(smooth ? smooth_grid_field(bench_geometry, voxels) : grid_field(bench_geometry, voxels));
  }
}
BENCHMARK_CAPTURE(make_grid, trilinear, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(make_grid, smooth, true)->Unit(benchmark::kMillisecond);

/// A search along paths of this many voxels without a crossing. `levels` about the value: on both sides of the ball's inside,
/// where noise leaves no brick in doubt; or close to it, so that every cell is checked.
void first_crossing(benchmark::State& state, bool smooth, double voxels, bool bricks) {
  const std::vector<FieldPtr> fields{bench_grid(smooth)};
  Samples samples(fields, {});
  const double near = smooth ? 12.0 : 29.9;
  const Threshold levels[] = {{0, bricks ? 300.0 : 1000.0 - near}, {0, bricks ? 2000.0 : 1000.0 + near}};
  StateArena block;
  Crossings sides(block, levels, fields.size());
  const EventPolicy policy = sides.policy();
  Event event = sides.event();
  const Vec3 centre{0.128, 0.128, 0.128};
  const std::vector<Vec3> ends = positions_in({{-1, -1, -1}, {1, 1, 1}}, 4096);
  std::size_t i = 0;
  std::int64_t stopped = 0;
  for (auto _ : state) {
    const Vec3 half_m = 0.5e-3 * voxels * normalized(ends[i % ends.size()]);
    const Vec3 middle = centre + 0.003 * ends[(i + 7) % ends.size()];
    ++i;
    WorkBudget pieces(512);
    sides.first_event(0, middle - half_m, middle + half_m, policy, samples, pieces, event);
    sides.apply(0, event);
    stopped += event.kind != Event::Kind::none;
  }
  state.counters["stopped"] = benchmark::Counter(static_cast<double>(stopped), benchmark::Counter::kAvgIterations);
}
BENCHMARK_CAPTURE(first_crossing, trilinear_half_a_voxel_in_a_quiet_brick, false, 0.5, true);
BENCHMARK_CAPTURE(first_crossing, trilinear_half_a_voxel, false, 0.5, false);
BENCHMARK_CAPTURE(first_crossing, trilinear_100_voxels_over_bricks, false, 100.0, true);
BENCHMARK_CAPTURE(first_crossing, smooth_half_a_voxel_in_a_quiet_brick, true, 0.5, true);
BENCHMARK_CAPTURE(first_crossing, smooth_half_a_voxel, true, 0.5, false);
BENCHMARK_CAPTURE(first_crossing, smooth_100_voxels_over_bricks, true, 100.0, true);

/// All pieces of a path of 100 voxels: the savings by bricks.
void all_pieces(benchmark::State& state, bool smooth, bool bricks) {
  const FieldPtr field = bench_grid(smooth);
  const ValueRange quiet = bricks ? ValueRange{300.0, 2000.0} : ValueRange{1.0, -1.0};
  const std::vector<Vec3> ends = positions_in({{-1, -1, -1}, {1, 1, 1}}, 4096);
  std::size_t i = 0;
  std::int64_t pieces = 0;
  for (auto _ : state) {
    const Vec3 half_m = 0.05 * normalized(ends[i % ends.size()]);
    const Vec3 middle = Vec3{0.128, 0.128, 0.128} + 0.003 * ends[(i + 7) % ends.size()];
    ++i;
    for (double begin = 0.0; begin < 1.0; ++pieces) {
      begin = field->piece_along(middle - half_m, middle + half_m, begin, quiet).end;
    }
  }
  state.counters["pieces"] = benchmark::Counter(static_cast<double>(pieces), benchmark::Counter::kAvgIterations);
}
BENCHMARK_CAPTURE(all_pieces, trilinear_100_voxels_cell_by_cell, false, false);
BENCHMARK_CAPTURE(all_pieces, trilinear_100_voxels_over_bricks, false, true);
BENCHMARK_CAPTURE(all_pieces, smooth_100_voxels_cell_by_cell, true, false);
BENCHMARK_CAPTURE(all_pieces, smooth_100_voxels_over_bricks, true, true);

/// A tick on the plane: in free space, or pressed 1 mm deep and sliding.
void tick(benchmark::State& state, double depth_m) {
  Scene scene({.stiffness_n_per_m = 500});
  const FieldRef wall = scene.add("wall", plane_field());
  scene.add("surface", SurfaceAndFriction{.field = wall, .levels = {{.value = 0.0, .strength_n = 4.0}}, .friction_n = 0.1});
  Session session(scene);
  const Similarity map = session.hand_to_world();
  const auto hand = [&](double depth, double lateral) { return Probe{.position_m = map.to_hand({lateral, 0, -depth})}; };
  for (int i = 0; i < 100; ++i) session.tick(hand(-2e-3 + i * (2e-3 + depth_m) / 99, 0.0), 1e-3);
  double lateral_m = 0.0;
  double direction = 1.0;
  std::int64_t sub_steps = 0;
  for (auto _ : state) {
    lateral_m += 1e-5 * direction;
    if (std::abs(lateral_m) > 0.01) direction = -direction;
    const Tick answer = session.tick(hand(depth_m, lateral_m), 1e-3);
    sub_steps += answer.sub_steps;
    benchmark::DoNotOptimize(answer);
  }
  state.counters["sub_steps"] = benchmark::Counter(static_cast<double>(sub_steps), benchmark::Counter::kAvgIterations);
}
BENCHMARK_CAPTURE(tick, free_space, -1e-3);
BENCHMARK_CAPTURE(tick, surface_and_friction_on_a_formula, 1e-3);

/// State copy between sessions, as in a loop that rehearses the next tick.
void copy_state_from(benchmark::State& state) {
  Scene scene;
  const FieldRef wall = scene.add("wall", plane_field());
  for (std::int64_t mode = 0; mode < state.range(0); ++mode)
    scene.add("surface_" + std::to_string(mode),
              SurfaceAndFriction{.field = wall, .levels = {{.value = 1e-3 * static_cast<double>(mode)}}});
  Session session(scene), other(scene);
  session.tick({}, 1e-3);
  for (auto _ : state) other.copy_state_from(session);
}
BENCHMARK(copy_state_from)->Arg(1)->Arg(5)->Arg(20)->ArgName("modes");

}  // namespace
