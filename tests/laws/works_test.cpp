// What every primitive brought in, and what data that move did, checked from the trace's files alone.
#include <gtest/gtest.h>
#include <unistd.h>

#include <map>

#include "palpa/palpa.h"
#include "tests/laws/shipped_scenes.h"
#include "tests/laws/trace_check.h"

namespace palpa {
namespace {

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
  std::map<std::int64_t, double> moved_j;
  int primitives = 0, carried = 0;
  test::check_works(folder_, [&](const test::CheckedWork& w) {
    ASSERT_NEAR(w.claimed_j, w.work_j, 1e-18 + 1e-12 * std::abs(w.work_j)) << "tick " << w.tick;
    if (!w.directed && w.exact) {
      ASSERT_LE(w.work_j, w.may_bring_j + 1e-15) << "tick " << w.tick << ", sub-step " << w.sub_step << ", mode " << w.mode;
    }
    works_j[{w.tick, std::string(w.mode)}] += w.work_j;
    moved_j[w.tick] += w.moved_j;
    ++primitives;
    carried += w.carried_m > 0.0;
  });
  EXPECT_GT(primitives, 300) << "the hand felt nothing";
  if (moving) {
    EXPECT_GT(carried, 100) << "nothing moved under the hand";
  } else {
    EXPECT_EQ(carried, 0);
  }

  test::CsvRows modes(folder_ / "modes.csv"), ticks(folder_ / "ticks.csv");
  while (modes.next()) {
    const double work_j = works_j[{modes.integer("tick"), std::string(modes.text("mode"))}];
    ASSERT_NEAR(modes.number("injected_j") - modes.number("dissipated_j"), work_j, 1e-15) << modes.place();
  }
  while (ticks.next()) ASSERT_NEAR(ticks.number("moved_j"), moved_j[ticks.integer("tick")], 1e-15) << ticks.place();

  const ReplayResult again = replay(folder_);
  EXPECT_TRUE(again.difference.same) << again.difference.where;
}

INSTANTIATE_TEST_SUITE_P(Scenes, Works, testing::Values("beat_phantom", "head_phantom", "many_phantom"),
                         [](const auto& scene) { return scene.param; });

}  // namespace
}  // namespace palpa
