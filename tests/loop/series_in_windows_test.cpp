// Series of frames larger than memory: equal to the series in memory on a simulated clock, and felt live by pairs of windows.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "palpa/data/smooth_grid.h"
#include "palpa/loop/window_feed.h"
#include "palpa/loop/window_policy.h"
#include "palpa/mode/modes.h"
#include "palpa/session/session.h"
#include "tests/data/pyramid.h"
#include "tests/session/hands.h"

namespace palpa {
namespace series_in_windows_test {

constexpr double period_s = 0.1;
constexpr int frames = 8;

/// A ball that beats, of 128³ voxels of 1 mm: its radius changes by 2 voxels from frame to frame at most.
std::vector<FieldPtr> ball_frames() {
  constexpr std::int64_t n = 128;
  constexpr double half = 0.5 * (n - 1);
  GridGeometry grid{.dims = {n, n, n}, .index_to_world_m = 1e-3 * Mat3::identity()};
  grid.origin_m = grid.index_to_world_m * Vec3{-half, -half, -half};
  std::vector<FieldPtr> all;
  for (int frame = 0; frame < frames; ++frame) {
    const double radius = 40.0 + 1.5 * std::sin(2.0 * 3.141592653589793 * frame / frames);
    const std::shared_ptr<float[]> values(new float[static_cast<std::size_t>(grid.voxels())]);
    float* to = values.get();
    for (std::int64_t k = 0; k < n; ++k)
      for (std::int64_t j = 0; j < n; ++j)
        for (std::int64_t i = 0; i < n; ++i)
          *to++ = static_cast<float>(
              radius - norm(Vec3{static_cast<double>(i) - half, static_cast<double>(j) - half, static_cast<double>(k) - half}));
    all.push_back(smooth_grid_field(grid, {VoxelType::float32, 1, values}));
  }
  return all;
}

Scene scene_of(const std::vector<FieldPtr>& all, BetweenFrames between, const TimeOptions& time) {
  Scene scene({.stiffness_n_per_m = 600, .damping_ns_per_m = 0.3});
  Volume volume;
  volume.fields.push_back({"value", "", time_series(all, period_s, between)});
  const FieldRef field = scene.add("ball", volume, {}, Filter::smooth);
  scene.add("surface", SurfaceAndFriction{.field = field, .levels = {{.value = 0.0, .strength_n = 4.0, .friction_n = 0.1}}});
  scene.add("thick", Viscosity{.field = field, .drag_ns_per_m = 0.5});
  scene.edit<Workspace>([](Workspace& workspace) { workspace.scale = 1.0; });
  scene.set(time);
  return scene;
}

std::vector<FieldPtr> in_octaves(const std::vector<FieldPtr>& all) {
  std::vector<FieldPtr> made;
  for (const FieldPtr& frame : all) made.push_back(test::in_octaves(*frame, 3));
  return made;
}

/// A hand that presses on the ball and slides.
Vec3 hand_m(int tick) {
  const double t = 1e-3 * tick, depth_m = 0.040 + 0.004 * std::cos(3.0 * t);
  const double angle = 0.6 * std::sin(2.1 * t), lift = 0.5 * std::sin(1.3 * t);
  return depth_m * Vec3{std::cos(angle) * std::cos(lift), std::sin(angle) * std::cos(lift), std::sin(lift)};
}

void expect_same(const Tick& a, const Tick& b, int tick) {
  ASSERT_EQ(a.proxy_m, b.proxy_m) << tick;
  ASSERT_EQ(a.force_n, b.force_n) << tick;
  ASSERT_EQ(a.status, b.status) << tick;
  ASSERT_EQ(a.sub_steps, b.sub_steps) << tick;
  ASSERT_EQ(a.work, b.work) << tick;
  ASSERT_EQ(a.energy.data_motion_j, b.energy.data_motion_j) << tick;
}

// A simulated clock feels the bits of the series in memory, however fast it plays.
TEST(SeriesInWindows, FeelTheBitsOfMemoryOnASimulatedClock) {
  const std::vector<FieldPtr> all = ball_frames(), octaves = in_octaves(all);
  struct Case {
    BetweenFrames between;
    TimeOptions time;
  };
  for (const auto& [between, time] : {Case{BetweenFrames::linear, {TimeOptions::Play::loop}},
                                      Case{BetweenFrames::linear, {TimeOptions::Play::once, 0.2, 0.03}},
                                      Case{BetweenFrames::linear, {TimeOptions::Play::loop, 130.0}},
                                      Case{BetweenFrames::linear, {TimeOptions::Play::hold, 1.0, 0.25}},
                                      Case{BetweenFrames::nearest, {TimeOptions::Play::loop, 0.7}}}) {
    Session in_memory(scene_of(all, between, time)), in_windows(scene_of(octaves, between, time));
    WindowFeed feed(in_windows);
    SCOPED_TRACE(time.speed);
    double felt_n = 0.0, moved_j = 0.0;
    for (int tick = 0; tick < 1200; ++tick) {
      const Probe probe{.position_m = hand_m(tick)};
      const Tick a = in_memory.tick(probe, 1e-3), b = feed.tick(probe, 1e-3);
      ASSERT_EQ(b.felt_octave, 0.0) << tick;
      expect_same(a, b, tick);
      if (HasFatalFailure()) return;
      felt_n = std::max(felt_n, norm(a.force_n)), moved_j = std::max(moved_j, std::abs(a.energy.data_motion_j));
    }
    EXPECT_GT(felt_n, 0.3);
    EXPECT_EQ(moved_j > 0.0, time.play != TimeOptions::Play::hold);
  }
}

/// Window that came before a tick.
struct Came {
  int tick = 0;
  WindowPlace place;
};

/// Feels the hand while the policy's windows come, one each `every` ticks.
std::vector<Tick> felt_live(Session& session, int ticks, int every, std::vector<Came>& came) {
  WindowPolicy policy(session.stock());
  std::vector<Tick> felt;
  const Stock& stock = session.stock();
  for (int tick = 0; tick < ticks; ++tick) {
    const Probe probe{.position_m = hand_m(tick)};
    const WindowNeed need = session.window_need(probe, 1e-3);
    if (tick % every == 0) {
      if (const auto place = policy.next(motion_of(need, 1.0))) {
        session.stock().lay(*place->of, place->octave, place->of->window(place->octave, place->first, place->dims));
        policy.made(*place);
        came.push_back({tick, *place});
      }
    }
    felt.push_back(session.tick(probe, 1e-3));
    // An octave is felt where all frames of the moment have a window of it.
    int sampled = 0;
    stock.for_each_sampled(need.time, [&](std::size_t n) {
      ++sampled;
      const auto octave = static_cast<int>(felt.back().felt_octave);
      EXPECT_GE(stock.room_of_m(n, octave, {&felt.back().proxy_m, 1}, need.time, 0.0), 0.0) << tick;
    });
    EXPECT_GE(sampled, 1);
    EXPECT_LE(sampled, 2);
    int kept = 0;  // frames with windows: those of the moment, and of the next 0.1 s
    for (std::size_t n = 0; n < stock.size(); ++n) kept += stock.corners_m(n, 0, {}) || stock.corners_m(n, 1, {});
    EXPECT_LE(kept, 4);
  }
  return felt;
}

// Live the windows of a frame come before it is sampled; a source that is too slow for them holds coarser octaves, without
// steps; which window came before which tick determines all.
TEST(SeriesInWindows, AreFeltLiveByPairsOfWindows) {
  const Scene scene = scene_of(in_octaves(ball_frames()), BetweenFrames::linear, {TimeOptions::Play::loop});
  for (const int every : {2, 10, 45}) {
    Session session(scene), again(scene);
    std::vector<Came> came;
    const std::vector<Tick> felt = felt_live(session, 2000, every, came);
    int finest = 0, forced = 0;
    double worst_n = 0.0;
    for (std::size_t tick = 1000; tick < felt.size(); ++tick) {
      finest += felt[tick].felt_octave == 0.0;
      forced += felt[tick].forced_octave;
      worst_n = std::max(worst_n, norm(felt[tick].force_n - felt[tick - 1].force_n));
    }
    if (every <= 10) {
      EXPECT_EQ(finest, 1000) << every;
    }
    EXPECT_EQ(forced, 0) << every;
    EXPECT_LT(worst_n, 0.08) << every;
    std::size_t next = 0;
    for (int tick = 0; tick < static_cast<int>(felt.size()); ++tick) {
      for (; next < came.size() && came[next].tick == tick; ++next) {
        const WindowPlace& place = came[next].place;
        again.stock().lay(*place.of, place.octave, place.of->window(place.octave, place.first, place.dims));
      }
      const Tick same = again.tick({.position_m = hand_m(tick)}, 1e-3);
      ASSERT_EQ(same.felt_octave, felt[static_cast<std::size_t>(tick)].felt_octave) << tick;
      expect_same(felt[static_cast<std::size_t>(tick)], same, tick);
    }
  }
}

}  // namespace series_in_windows_test
}  // namespace palpa
