// Sessions on volumes in octaves: the bits of memory at the finest octave, and how a change of the felt octave is felt.
#include <gtest/gtest.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <optional>
#include <random>
#include <utility>

#include "palpa/data/analytic.h"
#include "palpa/data/octave_parts.h"
#include "palpa/data/sampled.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/volume.h"
#include "palpa/file/read_volume.h"
#include "palpa/mode/modes.h"
#include "palpa/scene/load_scene.h"
#include "palpa/session/session.h"
#include "tests/data/pyramid.h"
#include "tests/session/hands.h"
#include "tests/shared_data.h"

namespace palpa {
namespace {

/// Volumes with their grids in octaves.
Volume octaves_of(Volume volume, int count) {
  for (VolumeField& field : volume.fields) {
    if (grid_behind(*field.field)) field.field = test::in_octaves(*field.field, count);
  }
  return volume;
}

/// Lays windows about the proxy.
class Windows {
 public:
  Windows(Session& session, std::int64_t size) : session_(session), size_(size) {}
  /// Of each octave from `finest` on, off the proxy by a random way if `random` is given.
  void lay(const Vec3& proxy_m, int finest, std::mt19937* random = nullptr) {
    Stock& stock = session_.stock();
    const Vec3 world_m = session_.hand_to_world().to_world(proxy_m);
    for (std::size_t n = 0; n < stock.size(); ++n) {
      for (int octave = finest; octave + 1 < stock.octaves(n).count(); ++octave) {
        Vec3 about_m = world_m;
        if (random) {
          const double way_m = std::ldexp(10.0, octave) * stock.octaves(n).spacing_m();
          std::uniform_real_distribution<double> along(-way_m, way_m);
          about_m += {along(*random), along(*random), along(*random)};
        }
        stock.lay(n, octave, test::window_about(stock.octaves(n), octave, about_m, size_));
      }
    }
  }

 private:
  Session& session_;
  std::int64_t size_;
};

void expect_same(const Tick& a, const Tick& b, int tick) {
  ASSERT_EQ(a.proxy_m, b.proxy_m) << tick;
  ASSERT_EQ(a.force_n, b.force_n) << tick;
  ASSERT_EQ(a.status, b.status) << tick;
  ASSERT_EQ(a.sub_steps, b.sub_steps) << tick;
  ASSERT_EQ(a.iterations, b.iterations) << tick;
  ASSERT_EQ(a.work, b.work) << tick;
  ASSERT_EQ(a.error_bound_m, b.error_bound_m) << tick;
  ASSERT_EQ(a.unborne_n, b.unborne_n) << tick;
  ASSERT_EQ(a.energy.stored_j, b.energy.stored_j) << tick;
  ASSERT_EQ(a.energy.injected_j, b.energy.injected_j) << tick;
  ASSERT_EQ(a.energy.dissipated_j, b.energy.dissipated_j) << tick;
}

/// A head felt at skin and bone.
Scene head_of(const Volume& head) {
  Scene scene({.stiffness_n_per_m = 600, .damping_ns_per_m = 0.3});
  const FieldRef field = scene.add("head", head, {}, Filter::smooth);
  scene.add("surface",
            SurfaceAndFriction{
                .field = field,
                .levels = {{.name = "skin", .value = -300, .strength_n = 0.8, .stiffness_n_per_m = 300, .friction_n = 0.1},
                           {.name = "bone", .value = 300, .strength_n = 12.0, .friction_coefficient = 0.15}}});
  return scene;
}

// Law 1: at λ = 0 a session feels the bits of the volume in memory, wherever the windows lie.
TEST(SessionsInOctaves, FeelTheBitsOfMemoryAtTheFinestOctave) {
  const Volume head = filtered(sampled(head_phantom(), 256), Filter::smooth);
  Session in_memory(head_of(head)), in_octaves(head_of(octaves_of(head, 3)));
  in_octaves.stock().set_complete(true);
  Windows windows(in_octaves, 96);
  test::Random random{7};
  const test::Wander hand(random, 0.13);
  std::mt19937 places(3);
  double felt_n = 0.0;
  Vec3 proxy_m;
  for (int tick = 0; tick < 2000; ++tick) {
    const Probe probe{.position_m = hand.at(2.5e-4 * tick)};
    if (tick % 4 == 0) windows.lay(tick == 0 ? probe.position_m : proxy_m, 0, &places);
    const Tick a = in_memory.tick(probe, 1e-3), b = in_octaves.tick(probe, 1e-3);
    ASSERT_EQ(b.felt_octave, 0.0) << tick;
    expect_same(a, b, tick);
    felt_n = std::max(felt_n, norm(a.force_n));
    proxy_m = a.proxy_m;
  }
  EXPECT_GT(felt_n, 1.0);
}

/// A window that came before a tick.
struct Came {
  int tick = 0;
  int octave = 0;
  OctaveWindow window;
};

/// Feels a hand while windows come late: one each `every` ticks, coarse before fine, about the proxy of that moment.
std::vector<Tick> felt_with_late_windows(Session& session, const test::Wander& hand, int ticks, int every,
                                         std::vector<Came>& came) {
  std::vector<Tick> felt;
  const Octaves& octaves = session.stock().octaves(0);
  int next = octaves.count() - 2;
  for (int tick = 0; tick < ticks; ++tick) {
    if (!felt.empty() && tick % every == 0) {
      const Vec3 world_m = session.hand_to_world().to_world(felt.back().proxy_m);
      came.push_back({tick, next, test::window_about(octaves, next, world_m, 96)});
      session.stock().lay(0, next, came.back().window);
      next = next > 0 ? next - 1 : octaves.count() - 2;
    }
    felt.push_back(session.tick({.position_m = hand.at(1e-3 * tick)}, 1e-3));
  }
  return felt;
}

// Law 2: which window came before which tick determines all; a session copied on the way goes on as the other.
TEST(SessionsInOctaves, FeelTheSameAgainFromTheWindowsThatCame) {
  const Scene scene = head_of(octaves_of(filtered(sampled(head_phantom(), 256), Filter::smooth), 4));
  test::Random random{11};
  const test::Wander hand(random, 0.11);
  Session session(scene);
  std::vector<Came> came;
  const std::vector<Tick> felt = felt_with_late_windows(session, hand, 1500, 15, came);

  double finest = 1e9, before = felt.front().felt_octave;
  for (const Tick& tick : felt) {
    finest = std::min(finest, tick.felt_octave);
    EXPECT_GE(tick.felt_octave, before - 1.0 / 25.0 - 1e-12);  // finer by an octave in 25 ms
    EXPECT_LE(tick.felt_octave, 3.0);
    EXPECT_TRUE(is_finite(tick.force_n));
    before = tick.felt_octave;
  }
  EXPECT_LT(finest, 1.0);

  Session again(scene), copy(scene);
  std::size_t next = 0;
  for (int tick = 0; tick < static_cast<int>(felt.size()); ++tick) {
    if (tick == 700) copy.copy_state_from(again);
    for (; next < came.size() && came[next].tick == tick; ++next) {
      again.stock().lay(0, came[next].octave, came[next].window);
      if (tick >= 700) copy.stock().lay(0, came[next].octave, came[next].window);
    }
    const Probe probe{.position_m = hand.at(1e-3 * tick)};
    const Tick same = again.tick(probe, 1e-3);
    ASSERT_EQ(same.felt_octave, felt[static_cast<std::size_t>(tick)].felt_octave) << tick;
    expect_same(felt[static_cast<std::size_t>(tick)], same, tick);
    if (tick < 700) continue;
    const Tick of_copy = copy.tick(probe, 1e-3);  // without the solver's memory: equal to its tolerance
    ASSERT_EQ(of_copy.felt_octave, same.felt_octave) << tick;
    if (tick < 720) {
      ASSERT_LT(distance(of_copy.proxy_m, same.proxy_m), 1e-6) << tick;
    }
  }
}

/// Waves of 128³ voxels of 1 mm, float, with 14 balls without data; in memory, and in octaves.
std::pair<Volume, Volume> waves_with_holes() {
  constexpr std::int64_t n = 128;
  GridGeometry grid{.dims = {n, n, n}, .index_to_world_m = 1e-3 * Mat3::identity()};
  grid.origin_m = grid.index_to_world_m * Vec3{-63.5, -63.5, -63.5};
  test::Random random{23};
  std::vector<std::pair<Vec3, double>> balls;  // [voxels]
  for (int ball = 0; ball < 14; ++ball)
    balls.push_back({{random.uniform(20, 108), random.uniform(20, 108), random.uniform(20, 108)}, random.uniform(0.5, 9)});
  const auto values = std::make_shared<std::vector<float>>();
  for (std::int64_t at = 0; at < grid.voxels(); ++at) {
    const Vec3 x{static_cast<double>(at % n), static_cast<double>(at / n % n), static_cast<double>(at / n / n)};
    const bool is_hole = std::ranges::any_of(balls, [&](const auto& ball) { return distance(x, ball.first) < ball.second; });
    values->push_back(is_hole
                          ? std::numeric_limits<float>::quiet_NaN()
                          : static_cast<float>(100.0 * (std::sin(0.15 * x.x) * std::cos(0.12 * x.y) + std::sin(0.1 * x.z))));
  }
  Volume volume;
  volume.fields.push_back({"value", "", smooth_grid_field(grid, {VoxelType::float32, 1, {values, values->data()}})});
  return {volume, octaves_of(volume, 3)};
}

Scene waves_of(const Volume& waves) {
  Scene scene({.stiffness_n_per_m = 600, .damping_ns_per_m = 0.3});
  const FieldRef field = scene.add("waves", waves, {}, Filter::smooth);
  scene.add("surface", SurfaceAndFriction{.field = field,
                                          .levels = {{.name = "low", .value = 0, .strength_n = 1.5, .friction_n = 0.1},
                                                     {.name = "high", .value = 60, .strength_n = 3.0}}});
  scene.add("thick", Viscosity{.field = field, .strength_n = 0.3, .drag_ns_per_m = 0.5});
  scene.edit<Workspace>([](Workspace& workspace) { workspace.scale = 1.0; });
  return scene;
}

// Where voxels are missing, too: at λ = 0 the bits of memory wherever windows lie, and finite forces where they come late.
TEST(SessionsInOctaves, FeelHolesAsMemoryDoes) {
  const auto [whole, octaves] = waves_with_holes();
  Session in_memory(waves_of(whole)), in_octaves(waves_of(octaves)), live(waves_of(octaves));
  in_octaves.stock().set_complete(true);
  Windows windows(in_octaves, 96);
  test::Random random{5};
  const test::Wander hand(random, 0.05);
  std::mt19937 places(9);
  int at_edges = 0, in_holes = 0;
  Vec3 proxy_m;
  const TimedField& field = *timed(*octaves.fields.front().field);
  for (int tick = 0; tick < 3000; ++tick) {
    const Probe probe{.position_m = hand.at(4e-4 * tick)};
    if (tick % 4 == 0) windows.lay(tick == 0 ? probe.position_m : proxy_m, 0, &places);
    const Tick a = in_memory.tick(probe, 1e-3), b = in_octaves.tick(probe, 1e-3);
    ASSERT_EQ(b.felt_octave, 0.0) << tick;
    expect_same(a, b, tick);
    proxy_m = a.proxy_m;
    DataTime at;
    at.stock = &in_octaves.stock();
    const double depth_m = field.depth_at(proxy_m, at);
    at_edges += depth_m > 0.0 && depth_m < 0.003;
    in_holes += depth_m <= 0.0;
  }
  EXPECT_GT(at_edges, 100);
  EXPECT_GT(in_holes, 50);
  std::vector<Came> came;
  double finest = 9.0;
  for (const Tick& tick : felt_with_late_windows(live, hand, 1500, 15, came)) {
    EXPECT_TRUE(is_finite(tick.force_n) && is_finite(tick.proxy_m));
    finest = std::min(finest, tick.felt_octave);
  }
  EXPECT_LT(finest, 1.0);
}

/// Position [m, world] nearest to `near_m` along the gradient at which the octave has the value; none within ten spacings of
/// it.
std::optional<Vec3> level_in(const TimedField& field, DataTime at, const Vec3& near_m, const Vec3& direction, double value) {
  const double h = field.local_spacing_at(near_m, at);
  const auto side = [&](double way) {
    const ScalarSample s = field.scalar_at(near_m + way * h * direction, at);
    return s.inside ? s.value - value : std::numeric_limits<double>::quiet_NaN();
  };
  constexpr double step = 1.0 / 16.0;
  for (double way = 0.0; way < 10.0; way += step) {
    for (const double sign : {1.0, -1.0}) {
      const double a = side(sign * way), b = side(sign * (way + step));
      if (a * b <= 0.0)
        return near_m + sign * (way + step * std::abs(a) / (std::abs(a) + std::abs(b) + 1e-300)) * h * direction;
    }
  }
  return std::nullopt;
}

/// A fade of the felt octave under a still hand.
struct Fade {
  double worst_n = 0.0;  ///< [N] change of the force in a tick
  int slips = 0;         ///< ticks of many sub-steps: the proxy slips at a fold of its balances, as a hand's motion makes it
  int waiting = 0;       ///< ticks without work left
  int let_go = 0;        ///< ticks in which a level was broken through or vanished
};

Fade fade_under(Session& session, const Vec3& probe_m, int to_octave) {
  Fade fade;
  session.stock().set_finest(to_octave);
  Vec3 before_n;
  for (int tick = 0; tick < 200; ++tick) {
    const Tick t = session.tick({.position_m = probe_m}, 1e-3);
    if (tick > 0) fade.worst_n = std::max(fade.worst_n, norm(t.force_n - before_n));
    fade.slips += t.sub_steps > 8;
    fade.waiting += t.status == TickStatus::waiting;
    fade.let_go += tick > 0 && norm(before_n) > 0.1 && !(norm(t.force_n) > 0.0);
    before_n = t.force_n;
    for (const SessionEvent& event : session.events()) fade.let_go += event.kind == SessionEventKind::break_through;
  }
  EXPECT_EQ(session.tick({.position_m = probe_m}, 1e-3).felt_octave, to_octave);
  return fade;
}

/// Presses at places on a ball about the middle, until the coupling is stretched by `depth_m`, and lets the felt octave go to 2
/// and back. Law 5: a tick changes the force by the stiffness times the way of the level in a 25th of an octave, where the
/// proxy slips by 10 mN more, and no level lets go at once.
void press_and_fade(const Scene& scene, double radius_m, double depth_m, int least_compared) {
  int compared = 0, waited = 0;
  for (int n = 0; n < 16; ++n) {
    const double angle = 2.39996 * n, z = 1.0 - (n + 0.5) / 8.0, r = std::sqrt(1.0 - z * z);
    const Vec3 start_m = radius_m * Vec3{r * std::cos(angle), r * std::sin(angle), z};
    Session session(scene);
    Windows windows(session, 64);
    Vec3 probe_m = start_m, proxy_m = start_m;
    bool rests = false;
    for (int tick = 0; tick < 3000 && !rests; ++tick) {
      probe_m = (1.0 - tick / 3000.0) * start_m;
      if (tick % 50 == 0) windows.lay(proxy_m, 0);
      proxy_m = session.tick({.position_m = probe_m}, 1e-3).proxy_m;
      rests = distance(proxy_m, probe_m) > depth_m;
    }
    if (!rests) continue;
    windows.lay(proxy_m, 0);
    for (int tick = 0; tick < 300; ++tick) proxy_m = session.tick({.position_m = probe_m}, 1e-3).proxy_m;
    const TimedField& field = *timed(*scene.volumes().front().volume.fields.front().field);
    const Vec3 world_m = session.hand_to_world().to_world(proxy_m);
    const auto at = [&](double octave) {
      DataTime t;
      t.octave = octave, t.stock = &session.stock();
      return t;
    };
    const ScalarSample here = field.scalar_at(world_m, at(0.0));
    double difference = 0.0, step_m = 0.0;  // [voxels of octave 0]; [m, world] in an eighth of an octave
    Vec3 last_m = world_m;
    for (double octave = 0.125; octave <= 2.0; octave += 0.125) {
      const auto there = level_in(field, at(octave), world_m, normalized(here.gradient), here.value);
      difference = there ? std::max(difference, distance(*there, world_m) / field.spacing_m()) : 1e9;
      step_m = there ? std::max(step_m, distance(*there, last_m)) : step_m;
      last_m = there.value_or(last_m);
    }
    const Fade coarser = fade_under(session, probe_m, 2);
    EXPECT_EQ(coarser.let_go, 0) << n;
    if (difference > 10.0) continue;
    const Fade finer = fade_under(session, probe_m, 0);
    EXPECT_EQ(finer.let_go, 0) << n;
    if (coarser.waiting + finer.waiting > 0) {
      ++waited;
      continue;
    }
    ++compared;
    // Along the gradient; across it the proxy moves by up to twice as much again, where the level turns.
    const double way_m = 8.0 / 25.0 * step_m / session.hand_to_world().scale;
    const double level_n = 3.0 * scene.coupling().stiffness_n_per_m * way_m;
    EXPECT_LT(coarser.worst_n, level_n + (coarser.slips > 0 ? 10e-3 : 1e-3)) << n;
    EXPECT_LT(finer.worst_n, level_n + (finer.slips > 0 ? 10e-3 : 1e-3)) << n;
  }
  EXPECT_GE(compared, least_compared);
  EXPECT_LE(2 * waited, compared);
}

/// A scene at another scale [1] of its workspace.
Scene scaled(Scene scene, double scale) {
  scene.edit<Workspace>([&](Workspace& workspace) { workspace.scale = scale, workspace.fit.clear(); });
  return scene;
}

/// Grid of n³ voxels of 1 mm about the origin, in octaves.
template <class Value>
Volume voxels_in_octaves(std::int64_t n, int count, Value&& value,
                         double coarsest_m = std::numeric_limits<double>::infinity()) {
  GridGeometry grid{.dims = {n, n, n}, .index_to_world_m = 1e-3 * Mat3::identity()};
  const double half = 0.5 * static_cast<double>(n - 1);
  grid.origin_m = grid.index_to_world_m * Vec3{-half, -half, -half};
  const std::shared_ptr<float[]> values(new float[static_cast<std::size_t>(grid.voxels())]);
  float* to = values.get();
  for (std::int64_t k = 0; k < n; ++k) {
    for (std::int64_t j = 0; j < n; ++j) {
      for (std::int64_t i = 0; i < n; ++i) *to++ = static_cast<float>(value(static_cast<double>(i) - half));
    }
  }
  Volume volume;
  volume.fields.emplace_back().name = "value";
  volume.fields.front().field = test::in_octaves(*smooth_grid_field(grid, {VoxelType::float32, 1, values}), count, coarsest_m);
  return volume;
}

/// Work on a hand in a tick by its ledger [J].
double work_by_ledger_j(const Energy& before, const Energy& now) {
  return before.stored_j + before.elastic_j - now.stored_j - now.elastic_j + now.sampling_bound_j + now.injected_j -
         now.dissipated_j + now.data_motion_j + now.path_and_release_j + now.damper_j;
}

// Law 5, where a level vanishes: a wall of one and a half voxels is gone in octave 1. While it is there the proxy moves by the
// way of hand and level, then as changes the force by 10 mN a tick beyond the way of the hand, until it is at the probe; under
// a still hand the ledger closes all the time.
TEST(SessionsInOctaves, LetALevelThatVanishesGoSlowly) {
  for (const auto& [strength_n, slide_m] : std::to_array<std::pair<double, double>>({{12.0, 0.0}, {1.6, 0.0}, {12.0, 4e-5}})) {
    Scene scene({.stiffness_n_per_m = 600});
    const Volume wall =
        voxels_in_octaves(128, 4, [](double x) { return std::clamp(1250.0 - 1000.0 * std::abs(x), 0.0, 1000.0); });
    const FieldRef field = scene.add("wall", wall, {}, Filter::smooth);
    scene.add("surface", SurfaceAndFriction{.field = field, .levels = {{.value = 400, .strength_n = strength_n}}});
    Session session(scaled(scene, 1.0));
    Vec3 probe_m{-0.01, 0.0003, 0.0002};
    Windows(session, 64).lay({}, 0);
    Tick last;
    for (int tick = 0; tick < 300; ++tick) {
      probe_m.x = std::min(1e-3, -0.01 + 5e-5 * tick);
      last = session.tick({.position_m = probe_m}, 1e-3);
    }
    ASSERT_GT(norm(last.force_n), 1.0);
    const TimedField& data = *timed(*wall.fields.front().field);
    const auto level = [&](double octave) {
      DataTime at;
      at.octave = octave, at.stock = &session.stock();
      return level_in(data, at, {-0.0008, 0.0003, 0.0002}, {1, 0, 0}, 400);
    };
    session.stock().set_finest(2);
    int without_level = 0;
    for (int tick = 0; tick < 250; ++tick) {
      probe_m.y += slide_m;
      const Tick now = session.tick({.position_m = probe_m}, 1e-3);
      const auto before = level(last.felt_octave), there = level(now.felt_octave);
      const double level_m = before && there ? distance(*before, *there) : 0.0;
      // The proxy's way is limited by that of the level to first order.
      EXPECT_LE(600.0 * (distance(now.proxy_m, last.proxy_m) - slide_m), std::max(606.0 * level_m + 3e-4, 10e-3) + 1e-6)
          << tick;
      if (slide_m == 0.0) {
        EXPECT_NEAR(work_by_ledger_j(last.energy, now.energy), 0.0, 1e-15) << tick;
      }
      EXPECT_EQ(now.status, TickStatus::complete) << tick;
      without_level += !there;
      last = now;
    }
    EXPECT_GT(without_level, 100);
    EXPECT_EQ(last.felt_octave, 2.0);
    EXPECT_NEAR(distance(last.proxy_m, probe_m), 0.0, 1e-9);
  }
}

/// Scene of a mode on data that are the same in all octaves, of voxels up to 2 mm: a slope of 1000 units a metre along x, or a
/// flow along x.
template <class Mode>
Scene scene_up_to_2_mm(Mode mode, int components) {
  constexpr double widest_m = 2e-3;
  Volume volume = voxels_in_octaves(128, 4, [](double x) { return x; }, widest_m);
  if (components == 3) {
    const GridGeometry& grid = palpa::octaves_of(*volume.fields.front().field)->shape().finest;
    const auto flow = std::make_shared<std::vector<float>>(static_cast<std::size_t>(3 * grid.voxels()), 1.0F);
    volume.fields.front().field =
        test::in_octaves(*grid_field(grid, {VoxelType::float32, 3, {flow, flow->data()}}), 4, widest_m);
  }
  Scene scene({.stiffness_n_per_m = 600});
  mode.field = scene.add("data", volume);
  scene.add("mode", std::move(mode));
  return scaled(scene, 1.0);
}

/// Presses on, lets the felt octave go to 2, where there are no data, and back: coming and going the force changes by 10 mN a
/// tick. Returns the force before.
double fade_to_no_data(const Scene& scene) {
  Session session(scene);
  Windows(session, 64).lay({}, 0);
  Vec3 probe_m{-0.01, 0.0003, 0.0002};
  Tick last;
  for (int tick = 0; tick < 400; ++tick) {
    probe_m.x = std::min(2e-3, -0.01 + 5e-5 * tick);
    last = session.tick({.position_m = probe_m}, 1e-3);
  }
  const double before_n = norm(last.force_n);
  for (const int octave : {1, 2, 0}) {
    session.stock().set_finest(octave);
    for (int tick = 0; tick < 600; ++tick) {
      const Tick now = session.tick({.position_m = probe_m}, 1e-3);
      EXPECT_LE(norm(now.force_n - last.force_n), 10e-3 + 1e-6) << octave << " " << tick;
      EXPECT_NEAR(work_by_ledger_j(last.energy, now.energy), 0.0, 1e-15) << octave << " " << tick;
      for (const SessionEvent& event : session.events())
        EXPECT_NE(event.kind, SessionEventKind::break_through) << octave << " " << tick;
      last = now;
    }
    EXPECT_NEAR(norm(last.force_n), octave == 2 ? 0.0 : before_n, octave == 0 ? before_n : 1e-6);
  }
  return before_n;
}

TEST(SessionsInOctaves, FadeWhereOctavesAreCoarserThanAllowed) {
  const SurfaceAndFriction wall{.levels = {{.value = 0.0, .strength_n = 6.0, .friction_n = 0.1}}};
  EXPECT_GT(fade_to_no_data(scene_up_to_2_mm(wall, 1)), 1.0);
  EXPECT_GT(fade_to_no_data(scene_up_to_2_mm(Viscosity{.strength_n = 0.5, .drag_ns_per_m = 2.0}, 1)), 0.3);
  EXPECT_GT(fade_to_no_data(scene_up_to_2_mm(VectorForce{.strength_n = 0.8}, 3)), 0.5);
}

// A wall breaks, and the proxy would fly on in the same tick further than its window reaches, onto another wall: it stops at
// the face, feels nothing of what is beyond, goes on in coarser octaves, and through the next windows to where it rests in
// memory.
TEST(SessionsInOctaves, StopAtTheFaceOfAWindowInFreeFlight) {
  Scene scene({.stiffness_n_per_m = 100});
  const Volume walls = voxels_in_octaves(160, 3, [](double x) { return std::abs(x + 60.0) < 3.0 || x > -10.0 ? 400.0 : 0.0; });
  const FieldRef field = scene.add("walls", walls, {}, Filter::smooth);
  scene.add("surface", SurfaceAndFriction{.field = field, .levels = {{.value = 200, .strength_n = 6.0}}});
  scene = scaled(scene, 1.0);
  Session in_memory(scene), in_window(scene);
  in_memory.stock().set_complete(true);
  Vec3 probe_m{-0.079, 0.0003, 0.0002};
  Windows(in_memory, 160).lay(probe_m, 0);
  Windows window(in_window, 64);
  window.lay({-0.063, probe_m.y, probe_m.z}, 0);
  const auto room_m = [&](const Vec3& at_m) { return in_window.stock().room_m(0, {&at_m, 1}, {}, Stock::sample_voxels); };

  Tick a, b;
  while (b.status == TickStatus::complete && probe_m.x < 0.0) {
    probe_m.x += 5e-5;
    a = in_memory.tick({.position_m = probe_m}, 1e-3), b = in_window.tick({.position_m = probe_m}, 1e-3);
  }
  ASSERT_EQ(b.status, TickStatus::waiting);
  EXPECT_NEAR(probe_m.x, -0.003, 1e-3);
  EXPECT_NEAR(a.proxy_m.x, -0.010, 2e-3);  // on the wall beyond, in the tick in which the first one broke
  EXPECT_LT(b.proxy_m.x, -0.015);
  EXPECT_NEAR(room_m(b.proxy_m), 0.0, 1e-9);
  EXPECT_EQ(in_window.sub_steps().back().primitives, 0u);

  for (int tick = 0; tick < 300; ++tick) {
    if (tick % 20 == 19) window.lay(b.proxy_m, 0);
    a = in_memory.tick({.position_m = probe_m}, 1e-3), b = in_window.tick({.position_m = probe_m}, 1e-3);
    EXPECT_EQ(b.status, TickStatus::complete) << tick;
    EXPECT_LE(b.proxy_m.x, a.proxy_m.x + 2e-3) << tick;  // of octave 1
  }
  EXPECT_EQ(b.felt_octave, 0.0);
  EXPECT_NEAR(distance(a.proxy_m, b.proxy_m), 0.0, 1e-9);
  EXPECT_NEAR(norm(a.force_n - b.force_n), 0.0, 1e-6);
  EXPECT_GT(norm(b.force_n), 0.5);
}

TEST(SessionsInOctaves, FadeUnderAStillHandOnThePhantom) {
  Scene scene({.stiffness_n_per_m = 600, .damping_ns_per_m = 0.3});
  const Volume head = octaves_of(filtered(sampled(head_phantom(), 256), Filter::smooth), 4);
  const FieldRef field = scene.add("head", head, {}, Filter::smooth);
  // One level that holds whatever the fade does: at the limit of its strength a level breaks by any change.
  scene.add("surface",
            SurfaceAndFriction{
                .field = field, .levels = {{.name = "skin", .value = -300, .strength_n = 12.0}}, .friction_coefficient = 0.15});
  press_and_fade(scaled(scene, 4.0), 0.03, 0.002, 8);
}

TEST(SessionsInOctaves, FadeUnderAStillHandOnARealHead) {
  const auto folder = test::shared_data();
  ReadOptions read;
  if (const char* bin = std::getenv("PALPA_BIN")) read.reader = std::filesystem::path(bin) / "palpa-read";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the real head is not on this machine";
  if (!std::filesystem::exists(read.reader)) GTEST_SKIP() << "palpa-read is not built";
  SceneOptions options;
  options.data_folders = {folder};
  const VolumeReader reader = [&](const VolumeRequest& request) { return octaves_of(read_volume(request, read), 4); };
  const Scene head =
      load_scene(std::filesystem::path(PALPA_SCENES_FOLDER) / "head.toml", reader, standard_modes(), options).scene;
  press_and_fade(scaled(head, 4.0), 0.05, 0.002, 2);
  press_and_fade(scaled(head, 10.0), 0.05, 0.002, 2);
}

}  // namespace
}  // namespace palpa
