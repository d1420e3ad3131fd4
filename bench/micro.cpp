// The parts of a tick, one at a time. Positions change from call to call, so nothing is predicted away.
#include <benchmark/benchmark.h>
#include <palpa/palpa.h>

#include <random>
#include <vector>

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

}  // namespace
