// Sessions on volumes in octaves: the bits of memory at the finest octave, and how a change of the felt octave is felt.
#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "palpa/data/analytic.h"
#include "palpa/data/sampled.h"
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
        kept_.push_back(test::window_about(stock.octaves(n), octave, about_m, size_));
        stock.lay(n, octave, kept_.back());
      }
    }
  }

 private:
  Session& session_;
  std::int64_t size_;
  std::vector<OctaveWindow> kept_;
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
  scene.add("surface", SurfaceAndFriction{.field = field,
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
  for (int tick = 0; tick < 3000; ++tick) {
    const Probe probe{.position_m = hand.at(5e-4 * tick)};
    if (tick % 3 == 0) windows.lay(tick == 0 ? probe.position_m : proxy_m, 0, &places);
    const Tick a = in_memory.tick(probe, 1e-3), b = in_octaves.tick(probe, 1e-3);
    ASSERT_EQ(b.felt_octave, 0.0) << tick;
    expect_same(a, b, tick);
    felt_n = std::max(felt_n, norm(a.force_n));
    proxy_m = a.proxy_m;
  }
  EXPECT_GT(felt_n, 1.0);
}

/// A fade of the felt octave under a still hand.
struct Fade {
  double worst_n = 0.0;  ///< [N] change of the force in a tick
  int let_go = 0;        ///< break-throughs
  double felt_n = 0.0;   ///< before
};

Fade fade_under(Session& session, const Vec3& probe_m, int to_octave) {
  Fade fade;
  session.stock().set_finest(to_octave);
  Vec3 before_n;
  for (int tick = 0; tick < 200; ++tick) {
    const Tick t = session.tick({.position_m = probe_m}, 1e-3);
    if (tick == 0) fade.felt_n = norm(t.force_n);
    if (tick > 0) fade.worst_n = std::max(fade.worst_n, norm(t.force_n - before_n));
    before_n = t.force_n;
    for (const SessionEvent& event : session.events()) fade.let_go += event.kind == SessionEventKind::break_through;
  }
  return fade;
}

/// Presses at many places and lets the felt octave go to 2 and back.
void press_and_fade(const Scene& scene, const std::vector<Vec3>& towards_m, double depth_m) {
  for (const Vec3& end_m : towards_m) {
    Session session(scene);
    Windows windows(session, 64);
    Vec3 probe_m, proxy_m;
    // From outside along a straight line until it is pressed in by `depth_m`.
    const Vec3 start_m = end_m;
    proxy_m = start_m;
    bool rests = false;
    for (int tick = 0; tick < 3000 && !rests; ++tick) {
      probe_m = start_m + (1.0 - tick / 3000.0 - 1.0) * start_m;
      if (tick % 100 == 0) windows.lay(proxy_m, 0);
      const Tick t = session.tick({.position_m = probe_m}, 1e-3);
      proxy_m = t.proxy_m;
      rests = norm(t.force_n) > 0.0 && distance(proxy_m, probe_m) > depth_m;
    }
    if (!rests) continue;
    windows.lay(proxy_m, 0);
    for (int tick = 0; tick < 300; ++tick) session.tick({.position_m = probe_m}, 1e-3);
    const Fade coarser = fade_under(session, probe_m, 2);
    const Fade finer = fade_under(session, probe_m, 0);
    std::printf("%8.2f N: coarser %6.1f mN %d, finer %6.1f mN %d\n", coarser.felt_n, 1e3 * coarser.worst_n, coarser.let_go,
                1e3 * finer.worst_n, finer.let_go);
  }
}

std::vector<Vec3> ring(double radius_m) {
  std::vector<Vec3> places;
  for (int n = 0; n < 12; ++n) {
    const double a = 2.39996 * n, z = 1.0 - (n + 0.5) / 6.0, r = std::sqrt(1.0 - z * z);
    places.push_back(radius_m * Vec3{r * std::cos(a), r * std::sin(a), z});
  }
  return places;
}

TEST(SessionsInOctaves, TryPhantom) {
  const Volume head = filtered(sampled(head_phantom(), 256), Filter::smooth);
  press_and_fade(head_of(octaves_of(head, 4)), ring(0.14), 0.002);
}

TEST(SessionsInOctaves, TryHead) {
  const auto folder = test::shared_data();
  SceneOptions options;
  options.data_folders = {folder};
  const VolumeReader reader = [](const VolumeRequest& request) {
    return octaves_of(read_volume(request), 4);
  };
  for (const char* scale : {"4", "12"}) {
  options.sets = {{"workspace.scale", scale}};
  std::printf("scale %s\n", scale), std::fflush(stdout);
  const Scene scene = load_scene(std::filesystem::path(PALPA_SCENES_FOLDER) / "head.toml", reader, standard_modes(), options).scene;
  press_and_fade(scene, ring(0.1), 0.002);
  }
}

}  // namespace
}  // namespace palpa
