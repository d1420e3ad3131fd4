// Work of every primitive, and of moving data, checked from the trace's files alone.
#include <gtest/gtest.h>
#include <unistd.h>

#include <map>

#include "palpa/palpa.h"
#include "palpa/study/run.h"
#include "tests/laws/shipped_scenes.h"
#include "tests/laws/trace_check.h"

namespace palpa {
namespace works_test {

namespace fs = std::filesystem;

class Works : public testing::TestWithParam<std::string> {
 protected:
  const fs::path folder_ = fs::temp_directory_path() / ("palpa-works-" + GetParam() + "-" + std::to_string(::getpid()));
  void SetUp() override { fs::remove_all(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
};

TEST_P(Works, AreThoseThatTheLedgerBooks) {
  RunOptions options;
  options.scene = test::scene_file(GetParam());
  options.out = folder_;
  options.primitives = true;
  options.duration_s = 3.0;
  options.hand = "sim:random";
  run(options);

  const bool moving = GetParam().starts_with("beat");
  std::map<std::pair<std::int64_t, std::string>, double> works_j;
  std::map<std::int64_t, double> data_motion_j;
  int primitives = 0, carried = 0;
  test::check_works(folder_, [&](const test::CheckedWork& w) {
    ASSERT_NEAR(w.claimed_j, w.work_j, 1e-18 + 1e-12 * std::abs(w.work_j)) << "tick " << w.tick;
    if (!w.directed && w.exact) {
      ASSERT_LE(w.work_j, w.may_bring_j + 1e-15) << "tick " << w.tick << ", sub-step " << w.sub_step << ", mode " << w.mode;
    }
    works_j[{w.tick, std::string(w.mode)}] += w.work_j;
    data_motion_j[w.tick] += w.data_motion_j;
    ++primitives;
    carried += w.carried_m > 0.0;
  });
  EXPECT_GT(primitives, 300) << "the hand felt nothing";
  if (moving) {
    EXPECT_GT(carried, 100) << "nothing moved under the hand";
  } else {
    EXPECT_EQ(carried, 0);
  }

  // Energy stored by an elastic level is neither injected nor lost; the tick reports it as stored. One mode has elastic levels.
  std::map<std::int64_t, double> took_j;
  std::string elastic_mode;
  double before_j = 0.0, most_j = 0.0;
  const auto held = test::elastic_energies(folder_);
  for (test::CsvRows ticks(folder_ / "ticks.csv"); ticks.next();) {
    const std::int64_t tick = ticks.integer("tick");
    ASSERT_NEAR(ticks.number("moved_j"), data_motion_j[tick], 1e-15) << ticks.place();
    const double now_j = ticks.number("elastic_j");
    const auto found = held.find(tick);
    const test::ElasticEnergy levels = found != held.end() ? found->second : test::ElasticEnergy{};
    ASSERT_GE(now_j, levels.least_j - 1e-15) << ticks.place();
    ASSERT_LE(now_j, levels.most_j + 1e-15) << ticks.place();
    took_j[tick] = now_j - std::exchange(before_j, now_j);
    most_j = std::max(most_j, now_j);
    if (!levels.mode.empty()) elastic_mode = levels.mode;
  }
  for (test::CsvRows modes(folder_ / "modes.csv"); modes.next();) {
    const std::pair key{modes.integer("tick"), std::string(modes.text("mode"))};
    const double books_j = works_j[key] + (key.second == elastic_mode ? took_j[key.first] : 0.0);
    ASSERT_NEAR(modes.number("injected_j") - modes.number("dissipated_j"), books_j, 1e-15) << modes.place();
  }
  if (GetParam() != "many_phantom") {
    EXPECT_GT(most_j, 1e-4) << "its surface is soft";
  }

  const ReplayResult again = replay(folder_);
  EXPECT_TRUE(again.difference.same) << again.difference.where;
}

INSTANTIATE_TEST_SUITE_P(Scenes, Works, testing::Values("beat_phantom", "head_phantom", "many_phantom"),
                         [](const auto& scene) { return scene.param; });

}  // namespace works_test
}  // namespace palpa
