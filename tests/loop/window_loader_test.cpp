// A live hand in volumes larger than memory: the loop never waits for windows, and what came when determines what is felt.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <random>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "palpa/data/sampled.h"
#include "palpa/device/hand.h"
#include "palpa/loop/loop.h"
#include "palpa/loop/window_feed.h"
#include "tests/data/pyramid.h"
#include "tests/loop/scenes.h"
#include "tests/solver/counted_allocations.h"
#include "tests/solver/counted_locks.h"

namespace palpa {
namespace window_loader_test {

/// Source that can fail in all ways; the coarsest octave is read once, before.
class Troubled final : public VoxelSource {
 public:
  enum class Kind { quick, sleeps, loses, dies, hangs };
  Troubled(const GridView& grid, int count, Kind kind)
      : voxels_(grid.geometry, grid.voxels, count), kind_(kind), last_(count - 1) {}
  ~Troubled() override = default;

  bool read(int octave, const std::array<std::int64_t, 3>& first, const std::array<std::int64_t, 3>& dims,
            std::byte* to) override {
    if (octave == last_) return voxels_.read(octave, first, dims, to);
    ++reads;
    if (kind_ == Kind::sleeps) std::this_thread::sleep_for(std::chrono::milliseconds(random_() % 8));
    if (kind_ == Kind::dies && reads > 1) throw std::runtime_error("the reader has ended");
    if (kind_ == Kind::hangs) {
      std::unique_lock lock(mutex_);
      released_.wait(lock, [&] { return is_released_; });
    }
    return voxels_.read(octave, first, dims, to) && !(kind_ == Kind::loses && random_() % 3 == 0);
  }
  void release() {
    const std::lock_guard lock(mutex_);
    is_released_ = true;
    released_.notify_all();
  }
  std::atomic<int> reads{0};

 private:
  test::Pyramid voxels_;
  Kind kind_;
  int last_;
  std::mt19937 random_{5};
  std::mutex mutex_;
  std::condition_variable released_;
  bool is_released_ = false;
};

/// The phantom's head in octaves, of 256³ voxels.
struct Head {
  explicit Head(Troubled::Kind kind) {
    static const Volume sampled_head = filtered(sampled(head_phantom(), 256), Filter::smooth);
    Volume head = sampled_head;
    const FieldPtr& field = head.fields.front().field;
    const GridView& view = *grid_behind(*field);
    source = std::make_shared<Troubled>(view, 4, kind);
    octaves = std::make_shared<const Octaves>(Octaves::Shape{view.geometry, 4, view.voxels.type, 1, view.filter, view.scale,
                                                             view.offset, field->value_ranges(), source});
    in_memory = scene_of(head);
    head.fields.front().field = octaves;
    scene = scene_of(head);
  }
  static Scene scene_of(const Volume& head) {
    Scene scene({.stiffness_n_per_m = 800, .damping_ns_per_m = 0.5});
    const FieldRef ref = scene.add("head", head);
    scene.add("skin", SurfaceAndFriction{.field = ref,
                                         .levels = {{.name = "skin", .value = -300, .strength_n = 0.8, .friction_n = 0.1},
                                                    {.name = "bone", .value = 300, .strength_n = 4.0}}});
    return scene;
  }
  std::shared_ptr<Troubled> source;
  std::shared_ptr<const Octaves> octaves;
  Scene scene, in_memory;
};

/// Simulated time, a tick of which takes 50 µs at least, so that windows come.
class SlowedTime final : public LoopClock {
 public:
  explicit SlowedTime(SimulatedDevice& hand) : hand_(hand) {}
  double now_s() noexcept override { return now_s_; }
  void wait_until_s(double time_s) noexcept override {
    if (time_s <= now_s_) return;
    hand_.advance(time_s - now_s_);
    now_s_ = time_s;
    std::this_thread::sleep_for(std::chrono::microseconds(50));
  }

 private:
  SimulatedDevice& hand_;
  double now_s_ = 100.0;
};

struct Felt {
  std::vector<TickFrame> frames;
  std::int64_t windows = 0;
  LoopStatistics statistics;
};

Felt felt_live(Head& head, double duration_s, const std::function<void(LiveScene&, std::int64_t)>& meanwhile = {}) {
  Felt felt;
  felt.frames.reserve(static_cast<std::size_t>(2e3 * duration_s));
  LiveScene live(head.scene);
  const auto hand = open_hand("sim:stroke,depth_m=0.03", Hold::rigid);
  SlowedTime clock(*hand);
  LiveLoop loop(live, *hand, {.duration_s = duration_s, .guard = {.max_force_n = 10.0, .motors = false}}, nullptr, &clock);
  const std::atomic<bool> never{false};
  long allocated = 0, locked = 0, in_ticks = 0;
  loop.run(never, [&](const TickFrame& frame, const Session&) {
    if (frame.tick > 0) in_ticks += test::allocations - allocated + test::locks - locked;
    felt.frames.push_back(frame);
    felt.windows += frame.laid.of != nullptr;
    if (meanwhile) meanwhile(live, frame.tick);
    allocated = test::allocations, locked = test::locks;
  });
  felt.statistics = loop.statistics();
  head.source->release();
  EXPECT_EQ(in_ticks, 0) << "allocations and locks";
  return felt;
}

// Law 1 where the proxy flies in one tick: the windows of a simulated clock reach as far as the probe.
TEST(CompleteOctaves, FeelABreakThroughOfManyVoxelsAsMemoryDoes) {
  Head head(Troubled::Kind::quick);
  for (Scene* scene : {&head.scene, &head.in_memory}) scene->set(Workspace{.scale = 20.0, .center_m = Vec3{}});
  Session in_windows(head.scene), in_memory(head.in_memory);
  WindowFeed feed(in_windows);
  int broken = 0;
  double widest_m = 0.0;
  for (int tick = 0; tick < 1500; ++tick) {
    const Probe probe{.position_m = {2e-4, 1e-4, 7e-3 * std::cos(8e-3 * tick)}};
    const Tick a = in_memory.tick(probe, 1e-3), b = feed.tick(probe, 1e-3);
    ASSERT_EQ(a.force_n, b.force_n) << tick;
    ASSERT_EQ(a.proxy_m, b.proxy_m) << tick;
    ASSERT_EQ(b.felt_octave, 0.0) << tick;
    widest_m = std::max(widest_m, distance(a.proxy_m, a.probe_m));
    for (const SessionEvent& event : in_memory.events()) broken += event.kind == SessionEventKind::break_through;
  }
  EXPECT_GT(broken, 1);
  EXPECT_GT(widest_m * 20.0, 60.0 * head.octaves->spacing_m());
}

class LiveOctaves : public testing::TestWithParam<Troubled::Kind> {};

// Laws 2 and 7: with any source the loop neither allocates, locks nor fails; the windows that came, laid again before the same
// ticks, give the same ticks.
TEST_P(LiveOctaves, AreFeltAgainFromTheWindowsThatCame) {
  Head head(GetParam());
  const Felt felt = felt_live(head, 1.6);
  ASSERT_EQ(felt.frames.size(), 1600u);
  const bool must_come = GetParam() != Troubled::Kind::hangs;
  EXPECT_EQ(felt.windows > 0, must_come);
  if (GetParam() == Troubled::Kind::dies) {
    ASSERT_EQ(felt.statistics.windows.notes.size(), 1u);
    EXPECT_NE(felt.statistics.windows.notes.front().find("the reader has ended"), std::string::npos);
  }

  Head calm(Troubled::Kind::quick);
  Session again(calm.scene);
  GuardedSession guarded(again, 10.0);
  double finest = 9.0;
  int in_contact = 0;
  for (const TickFrame& frame : felt.frames) {
    const WindowPlace& laid = frame.laid;
    if (laid.of) again.stock().lay(0, laid.octave, calm.octaves->window(laid.octave, laid.first, laid.dims));
    const Probe probe{.position_m = frame.result.probe_m};
    const TickFrame same = guarded.tick(frame.tick, frame.t_s, frame.dt_s, probe);
    ASSERT_EQ(same.result.felt_octave, frame.result.felt_octave) << frame.tick;
    ASSERT_EQ(same.command.force_n, frame.command.force_n) << frame.tick;
    ASSERT_EQ(same.result.work, frame.result.work) << frame.tick;
    ASSERT_TRUE(is_finite(frame.command.force_n));
    finest = std::min(finest, frame.result.felt_octave);
    in_contact += norm(frame.command.force_n) > 1e-3;
  }
  EXPECT_GT(in_contact, 300);
  if (GetParam() == Troubled::Kind::quick) {
    EXPECT_EQ(finest, 0.0);
  }
  if (GetParam() == Troubled::Kind::hangs) {
    EXPECT_EQ(finest, 3.0) << "the coarsest octave is all that there is";
  }
}

INSTANTIATE_TEST_SUITE_P(Sources, LiveOctaves,
                         testing::Values(Troubled::Kind::quick, Troubled::Kind::sleeps, Troubled::Kind::loses,
                                         Troubled::Kind::dies, Troubled::Kind::hangs));

// A series, too, whose windows come and are dropped as it plays.
TEST(LiveOctavesOfASeries, AreFeltAgainFromTheWindowsThatCame) {
  Head head(Troubled::Kind::quick);
  std::vector<FieldPtr> frames{head.octaves};
  while (frames.size() < 6) frames.push_back(std::make_shared<const Octaves>(head.octaves->shape()));
  Volume series;
  series.fields.push_back({"head", "", time_series(frames, 1.0)});
  head.scene = Head::scene_of(series);
  head.scene.set(TimeOptions{TimeOptions::Play::loop});
  const Felt felt = felt_live(head, 1.6);

  Session again(head.scene);
  GuardedSession guarded(again, 10.0);
  double finest = 9.0;
  std::set<const Octaves*> laid_frames;
  for (const TickFrame& frame : felt.frames) {
    const WindowPlace& laid = frame.laid;
    if (laid.of) laid_frames.insert(laid.of);
    if (laid.of) again.stock().lay(*laid.of, laid.octave, laid.of->window(laid.octave, laid.first, laid.dims));
    const TickFrame same = guarded.tick(frame.tick, frame.t_s, frame.dt_s, {.position_m = frame.result.probe_m});
    ASSERT_EQ(same.result.felt_octave, frame.result.felt_octave) << frame.tick;
    ASSERT_EQ(same.command.force_n, frame.command.force_n) << frame.tick;
    finest = std::min(finest, frame.result.felt_octave);
  }
  EXPECT_LT(finest, 2.0);
  EXPECT_GE(laid_frames.size(), 2u);
}

// Scenes that change on the way keep their windows: no change is felt as another volume.
TEST(LiveOctavesOfChangedScenes, KeepTheirWindows) {
  Head head(Troubled::Kind::quick);
  double before = 0.0;
  const Felt felt = felt_live(head, 1.0, [&](LiveScene& live, std::int64_t tick) {
    if (tick % 200 != 150) return;
    live.change([&](Scene& changed) {
      changed.edit<CouplingOptions>(
          [&](auto& coupling) { coupling.damping_ns_per_m = 0.5 + 0.1 * static_cast<double>(tick % 400 > 200); });
    });
  });
  for (const TickFrame& frame : felt.frames) {
    if ((frame.circumstances & bit_of(Circumstance::new_scene)) != 0) {
      EXPECT_TRUE(frame.result.forced_octave || std::abs(frame.result.felt_octave - before) <= 0.5) << frame.tick;
    }
    before = frame.result.felt_octave;
  }
  EXPECT_EQ(felt.frames.back().result.felt_octave, 0.0);
}

}  // namespace window_loader_test
}  // namespace palpa
