// Still hands at points of every shipped scene, approached from 20 mm away: 1000 of them, others each day.
#include <gtest/gtest.h>

#include <algorithm>

#include "palpa/palpa.h"
#include "tests/laws/shipped_scenes.h"
#include "tests/solver/random_problems.h"
#include "tests/today.h"

namespace palpa {
namespace still_hand_test {

constexpr int approach_ticks = 200;
constexpr double approach_m = 0.02;  // 0.1 m/s: the approach meets surfaces and fills the modes' memory
constexpr int settling_ticks = 100;
constexpr int watched_ticks = 20;
constexpr int more_settling = 3;  // times, where drag lets the proxy creep to its rest

class EveryScene : public testing::TestWithParam<std::string> {};

TEST_P(EveryScene, HoldsAStillHandStill) {
  if (const std::string missing = test::missing_for(GetParam()); !missing.empty()) GTEST_SKIP() << missing;
  const Scene scene = load_scene(test::scene_file(GetParam()), volume_reader({.reader = test::reader()}), standard_modes(),
                                 {.data_folders = {test::shared_data_folder()}, .sets = {{"time.play", "hold"}}})
                          .scene;

  const int places = test::all_days() ? 10000 : 1000;
  test::Random random(test::today());
  Session session(scene);
  double worst_n = 0.0;
  Vec3 worst_m;
  int in_contact = 0;
  for (int place = 0; place < places; ++place) {
    session.reset();
    const Vec3 held = random.in_cube(0.075);
    const Vec3 from = held + approach_m * random.direction();
    Tick t;
    for (int i = 0; i < approach_ticks; ++i) {
      const double share = static_cast<double>(i) / approach_ticks;
      t = session.tick({.position_m = from + share * (held - from)}, 1e-3);
    }
    const auto swing_n = [&] {
      for (int i = 0; i < settling_ticks; ++i) t = session.tick({.position_m = held}, 1e-3);
      Vec3 low{1e9, 1e9, 1e9}, high = -low;
      for (int i = 0; i < watched_ticks; ++i) {
        t = session.tick({.position_m = held}, 1e-3);
        low = {std::min(low.x, t.force_n.x), std::min(low.y, t.force_n.y), std::min(low.z, t.force_n.z)};
        high = {std::max(high.x, t.force_n.x), std::max(high.y, t.force_n.y), std::max(high.z, t.force_n.z)};
      }
      return norm(high - low);
    };
    double still_n = swing_n();
    for (int more = 0; more < more_settling && still_n > 1e-3; ++more) still_n = swing_n();
    in_contact += norm(t.force_n) > 1e-3;
    if (still_n > worst_n) {
      worst_n = still_n;
      worst_m = held;
    }
  }
  std::printf("%s: %.3g mN peak to peak at most; %d of %d places in contact\n", GetParam().c_str(), 1e3 * worst_n, in_contact,
              places);
  EXPECT_GT(in_contact, places / 50) << "too few places are felt for this to say anything";
  EXPECT_LT(worst_n, 1e-3) << "at " << worst_m.x << ", " << worst_m.y << ", " << worst_m.z;
}

INSTANTIATE_TEST_SUITE_P(Scenes, EveryScene, testing::ValuesIn(test::shipped_scenes()),
                         [](const auto& scene) { return scene.param; });

}  // namespace still_hand_test
}  // namespace palpa
