// Every shipped scene under the demo's hand: forces of all its modes.
#include <gtest/gtest.h>

#include "palpa/device/hand.h"
#include "palpa/palpa.h"
#include "palpa/study/run.h"
#include "palpa/study/summary.h"
#include "tests/laws/shipped_scenes.h"

namespace palpa {
namespace scenes_test {

class ShippedScene : public testing::TestWithParam<std::string> {};

TEST_P(ShippedScene, IsFeltAndSoIsEachOfItsModes) {
  if (const std::string missing = test::missing_for(GetParam()); !missing.empty()) GTEST_SKIP() << missing;
  RunOptions options;
  options.scene = test::scene_file(GetParam());
  options.read.reader = test::reader();
  if (GetParam().ends_with("_phantom")) {
    options.hand = "sim:stroke";
    options.duration_s = 10.0;
  } else {
    options.hand = (test::shared_data() / "trajectories/inverse3_woodcarving_20231121_102837.csv").string();
    options.hold = Hold::relaxed;
    options.scene_options.data_folders = {test::shared_data()};
  }
  const RunResult result = run(options);
  const Summary& s = result.summary;
  EXPECT_GE(s.contact_share, 0.2);
  for (const ModeSummary& mode : s.modes) EXPECT_GT(mode.contact_share, 0.01) << mode.name << " is idle";
  EXPECT_EQ(s.waiting_ticks, 0);
  EXPECT_EQ(s.bad_input_ticks, 0);
  EXPECT_EQ(s.dropped_primitives, 0);
  EXPECT_EQ(s.faults, 0);
  EXPECT_TRUE(result.warnings.empty()) << result.warnings.front();
}

INSTANTIATE_TEST_SUITE_P(Scenes, ShippedScene, testing::ValuesIn(test::shipped_scenes()),
                         [](const auto& scene) { return scene.param; });

}  // namespace scenes_test
}  // namespace palpa
