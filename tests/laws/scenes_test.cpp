// Every shipped scene under the demo's hand: forces of all its modes.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>

#include "palpa/device/hand.h"
#include "palpa/file/read_volume.h"
#include "palpa/palpa.h"
#include "palpa/scene/load_scene.h"
#include "palpa/study/check.h"
#include "palpa/study/run.h"
#include "palpa/study/summary.h"
#include "palpa/trace/trace.h"
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
    options.scene_options.data_folders = {test::shared_data_folder()};
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

class SceneWithATool : public testing::TestWithParam<std::string> {};

// Under a hand that swings the tool: in less than 5 % of the ticks the proxy lags behind.
TEST_P(SceneWithATool, IsFeltWithForceAndTorque) {
  if (const std::string missing = test::missing_for(GetParam()); !missing.empty()) GTEST_SKIP() << missing;
  RunOptions options;
  options.scene = test::scene_file(GetParam());
  options.read.reader = test::reader();
  options.scene_options.data_folders = {test::shared_data_folder()};
  options.hand = "sim:stroke,tilt_rad=0.2";
  options.duration_s = 2.0;
  options.out = std::filesystem::temp_directory_path() / ("palpa-tool-scene-" + std::to_string(::getpid()));
  const Summary s = run(options).summary;
  double torque_nm = 0.0, turned_rad = 0.0;
  for (const auto& [frame] : TraceReader(options.out).ticks()) {
    torque_nm = std::max(torque_nm, norm(frame.result.torque_nm));
    turned_rad = std::max(turned_rad, norm(rotation_between_rad(frame.result.probe_turn, frame.result.proxy_turn)));
  }
  std::filesystem::remove_all(options.out);
  EXPECT_GE(s.contact_share, 0.2);
  for (const ModeSummary& mode : s.modes) EXPECT_GT(mode.contact_share, 0.01) << mode.name << " is idle";
  EXPECT_GT(torque_nm, 1e-3);
  EXPECT_GT(turned_rad, 1e-3);
  EXPECT_LE(s.waiting_ticks, 0.05 * static_cast<double>(s.ticks));
  EXPECT_EQ(s.bad_input_ticks, 0);
  EXPECT_EQ(s.dropped_primitives, 0);
  EXPECT_EQ(s.faults, 0);
}

// A CT head on an omega: soft it is fine, stiffer it hums, stiffer still it shakes, and no stiffer one is judged better.
TEST(CheckOfARealHead, IsFineThenWarnsThenStops) {
  if (const std::string missing = test::missing_for("head"); !missing.empty()) GTEST_SKIP() << missing;
  ReadOptions read;
  read.reader = test::reader();
  SceneOptions options;
  options.data_folders = {test::shared_data_folder()};
  Scene scene = load_scene(test::scene_file("head"), volume_reader(read), standard_modes(), options).scene;
  std::vector<Grade> grades;
  std::string verdicts;
  for (const double k : {300.0, 500.0, 1000.0, 1300.0, 1800.0, 2500.0, 5000.0}) {
    scene.edit<CouplingOptions>([&](auto& coupling) { coupling.stiffness_n_per_m = k; });
    const CheckReport report = check(scene, device_plant("omega"), {.advise = false});
    grades.push_back(report.grade);
    verdicts += std::to_string(k) + ": " + report.verdict + "\n";
  }
  EXPECT_TRUE(std::ranges::is_sorted(grades)) << verdicts;
  EXPECT_EQ(grades.front(), Grade::fine) << verdicts;
  EXPECT_EQ(std::ranges::count(grades, Grade::warn), 2) << verdicts;
  EXPECT_EQ(grades.back(), Grade::stop) << verdicts;
}

INSTANTIATE_TEST_SUITE_P(Tools, SceneWithATool, testing::ValuesIn(test::tool_scenes()),
                         [](const auto& scene) { return scene.param.substr(scene.param.find('/') + 1); });
INSTANTIATE_TEST_SUITE_P(Scenes, ShippedScene, testing::ValuesIn(test::shipped_scenes()),
                         [](const auto& scene) { return scene.param; });

}  // namespace scenes_test
}  // namespace palpa
