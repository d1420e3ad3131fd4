// Changes of the scene of a run in real time that is recorded.
#include "palpa/study/live_run.h"

#include <gmock/gmock.h>

#include <chrono>
#include <thread>

#include "palpa/device/mouse_hand.h"
#include "study_fixture.h"

namespace palpa {
namespace live_run_test {

namespace fs = std::filesystem;

const ToolOptions rod{.shape = ToolOptions::Shape::rod, .length_m = 0.02, .points = 3};

/// The phantom, felt by a mouse at rest.
class Live : public StudyTest {
 protected:
  Live() : loaded(load_scene(folder / "scene.toml")) {}
  std::unique_ptr<LiveRun> start(const std::string& trace) {
    options_ = options(trace);
    options_.primitives = true;
    options_.live.emplace();
    prepared_.loaded = loaded;
    prepared_.duration_s = std::numeric_limits<double>::infinity();
    return std::make_unique<LiveRun>(options_, prepared_, mouse_, TickObserver());
  }
  static void run_ticks(LiveRun& run, std::int64_t ticks) {
    const std::int64_t end = run.loop().statistics().ticks + ticks;
    while (run.loop().statistics().ticks < end) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  static std::size_t cells_of(const std::string& line) { return 1 + static_cast<std::size_t>(std::ranges::count(line, ',')); }

  LoadedScene loaded;

 private:
  RunOptions options_;
  PreparedRun prepared_;
  MouseHand mouse_;
};

Scene with_tool(Scene scene, const ToolOptions& tool) {
  scene.set(tool);
  return scene;
}

TEST_F(Live, ARecordingOfAPointRefusesATool) {
  const auto run = start("trace");
  run_ticks(*run, 5);
  try {
    run->set_scene(with_tool(loaded.scene, rod));
    FAIL() << "its columns are those of a point";
  } catch (const SceneError& error) {
    EXPECT_STREQ(error.what(),
                 "scene: a recording of a point has no columns for a tool; end it, and record the tool from the beginning");
  }
  EXPECT_EQ(run->scene().scene().tool(), ToolOptions{}) << "it goes on as it was";
  run_ticks(*run, 5);
  EXPECT_EQ(run->loop().statistics().scenes, 0);
  EXPECT_EQ(run->finish(), "");
  EXPECT_FALSE(TraceReader(folder / "trace").header().has_tool);
}

TEST_F(Live, WithoutARecordingAPointBecomesATool) {
  const auto run = start("");
  run->set_scene(with_tool(loaded.scene, rod));
  run_ticks(*run, 5);
  EXPECT_EQ(run->loop().statistics().scenes, 1);
  EXPECT_EQ(run->scene().scene().tool(), rod);
}

TEST_F(Live, ARecordingOfAToolGoesOnAsAPointWithAllColumns) {
  loaded.scene = with_tool(loaded.scene, rod);
  const auto run = start("trace");
  run_ticks(*run, 5);
  run->set_scene(with_tool(loaded.scene, {}));
  run_ticks(*run, 20);
  EXPECT_EQ(run->loop().statistics().scenes, 1);
  EXPECT_EQ(run->finish(), "");
  const TraceReader trace(folder / "trace");
  EXPECT_TRUE(trace.header().has_tool);
  EXPECT_EQ(trace.ticks().back().frame.result.torque_nm, Vec3{});
  for (const char* file : {"ticks.csv", "balances.csv", "primitives.csv"}) {
    std::istringstream lines(read(folder / "trace" / file));
    std::string line;
    std::getline(lines, line);
    const std::size_t cells = cells_of(line);
    while (std::getline(lines, line)) ASSERT_EQ(cells_of(line), cells) << file;
  }
}

}  // namespace live_run_test
}  // namespace palpa
