// Window parts without a display: parameter rows, valleys, presets, cursor point, replay.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include "driver.h"
#include "explorer/function_editor.h"
#include "explorer/opening.h"
#include "explorer/parameter_rows.h"
#include "explorer/player.h"
#include "explorer/presets.h"
#include "explorer/surface_finder.h"
#include "palpa/mode/plugin.h"

namespace palpa::explorer {
namespace parts_test {

TEST(ParameterRows, ShowEveryModeAndChangeOneValueAlone) {
  const ModeCatalog modes = modes_with({});
  for (const Mode& example : modes.modes()) {
    Mode mode = example;
    const Visit visit = [&](ParameterVisitor& v) { mode.visit(v); };
    for (const ParameterListSize& list : lists_of(visit)) append_to(visit, list.name);
    const std::vector<ParameterRow> before = rows_of(visit);
    EXPECT_FALSE(before.empty()) << mode.type();
    for (std::size_t row = 0; row < before.size(); ++row) {
      const auto* number = std::get_if<double>(&before[row].value);
      if (!number) continue;
      set_row(visit, row, *number + 0.25);
      const std::vector<ParameterRow> after = rows_of(visit);
      for (std::size_t other = 0; other < after.size(); ++other)
        EXPECT_EQ(after[other].value == before[other].value, other != row) << mode.type() << " " << before[row].info.name;
      set_row(visit, row, *number);
    }
    set_row(visit, before.size() + 5, 1.0);  // out of range
    EXPECT_EQ(rows_of(visit).size(), before.size());
  }
}

TEST(ParameterRows, NameTheirUnit) {
  EXPECT_EQ(named_unit("friction_n").name, "friction");
  EXPECT_EQ(named_unit("friction_n").unit, "N");
  EXPECT_EQ(named_unit("damping_ns_per_m").unit, "N·s/m");
  EXPECT_EQ(named_unit("stiffness_n_per_m").unit, "N/m");
  EXPECT_EQ(named_unit("texture_ratio").unit, "");
}

TEST(Valleys, LieBetweenHillsAndNowhereElse) {
  Histogram two{.low = 0.0, .high = 100.0, .counts = std::vector<std::int64_t>(200)};
  for (std::size_t i = 0; i < two.counts.size(); ++i) {
    const double x = 0.5 * (two.edge(i) + two.edge(i + 1));
    two.counts[i] = static_cast<std::int64_t>(1e6 * std::exp(-std::pow((x - 25.0) / 8.0, 2)) +
                                              2e5 * std::exp(-std::pow((x - 70.0) / 10.0, 2)));
  }
  const std::vector<double> valleys = valleys_of(two);
  ASSERT_EQ(valleys.size(), 1U);
  EXPECT_GT(valleys.front(), 40.0);
  EXPECT_LT(valleys.front(), 58.0);
  Histogram one = two;
  for (std::size_t i = 0; i < one.counts.size(); ++i) one.counts[i] = static_cast<std::int64_t>(1000 + i);
  EXPECT_TRUE(valleys_of(one).empty()) << "a slope has none";
}

TEST(SurfaceFinder, FindsWhereALineMeetsAnEmbeddedHead) {
  const Opened opened = open_any(embedded("head_phantom.toml"), {});
  const SurfaceFinder finder(opened.loaded.scene);
  ASSERT_TRUE(finder.has_surfaces());
  const auto front = finder.first({0.0, 0.0, 1.0}, {0.0, 0.0, -1.0});
  ASSERT_TRUE(front);
  EXPECT_NEAR(front->at_m.x, 0.0, 1e-12);
  // From any direction through the middle: a hit, in front of the hit from the other side.
  for (int i = 0; i < 40; ++i) {
    const double a = 0.3 * i;
    const Vec3 way = normalized({std::cos(a), 0.4 * std::sin(3.0 * a), std::sin(a)});
    const auto here = finder.first(-1.0 * way, way), there = finder.first(1.0 * way, -way);
    ASSERT_EQ(here.has_value(), there.has_value());
    if (here) {
      EXPECT_LE(dot(here->at_m, way), dot(there->at_m, way) + 1e-9);
    }
  }
  EXPECT_FALSE(finder.first({0.0, 0.0, 1.0}, {0.0, 0.0, 1.0})) << "away from it";
  EXPECT_FALSE(finder.first({5.0, 0.0, 1.0}, {0.0, 0.0, -1.0})) << "beside it";
}

TEST(Presets, MakeLayersThatCanBeDrawnAndSaved) {
  const Opened head = open_any(embedded("head_phantom.toml"), {});
  const Opened flow = open_any(embedded("flow_phantom.toml"), {});
  for (const Preset& preset : presets()) {
    const bool vectors = preset.for_data == Preset::For::vector;
    Scene scene = (vectors ? flow : head).loaded.scene;
    scene.layers = apply(preset, scene).layers;
    EXPECT_NO_THROW(scene.check()) << preset.name;
    EXPECT_NE(to_toml(scene).find("[[view.layer]]"), std::string::npos) << preset.name;
    if (vectors) {
      EXPECT_THROW(apply(preset, head.loaded.scene), LoadError) << preset.name;
    }
  }
}

TEST(FeelAgain, IsTheSameHandInTheSameSceneAndAnotherForceInAnother) {
  Opened opened = open_any(embedded("head_phantom.toml"), {});
  const PlayedHand hand{.trace = {}, .description = "sim:press"};
  const FeltTrace first = feel_again(hand, opened.loaded), again = feel_again(hand, opened.loaded);
  ASSERT_EQ(first.rows.size(), again.rows.size());
  double most_n = 0.0;
  for (std::size_t i = 0; i < first.rows.size(); ++i) {
    ASSERT_EQ(first.rows[i].command_n, again.rows[i].command_n);
    most_n = std::max(most_n, norm(first.rows[i].command_n));
    const Moment moment = first.moment(i);
    ASSERT_EQ(moment.proxy_m, first.rows[i].proxy_m);
    ASSERT_LE(moment.count, most_shown_primitives);
  }
  EXPECT_GT(most_n, 0.1) << "a hand that presses feels something";
  for (const SceneMode& mode : std::vector<SceneMode>(opened.loaded.scene.modes()))
    opened.loaded.scene.edit_mode(mode.name, [](SceneMode& one) { one.enabled = false; });
  const FeltTrace nothing = feel_again(hand, opened.loaded);
  for (const FeltTrace::Row& row : nothing.rows) EXPECT_EQ(norm(row.command_n), 0.0);
}

TEST(Jobs, StopWhenTheyAreCancelledAndSayNothing) {
  application();
  Jobs jobs;
  std::atomic<bool> is_over{false};
  bool was_said = false;
  const auto until_stopped = [&is_over](std::stop_token stop) {
    while (!stop.stop_requested()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    is_over = true;
    return 1;
  };
  const auto begin = [&] {
    jobs.begin<int>(
        Jobs::Purpose::look, "looking", until_stopped, [&](int) { was_said = true; }, [&](const QString&) { was_said = true; });
  };
  begin();
  EXPECT_EQ(jobs.words(), "looking");
  jobs.cancel_all();
  EXPECT_FALSE(jobs.is_under_way(Jobs::Purpose::look));
  EXPECT_TRUE(Driver::wait_for([&] { return is_over.load(); })) << "the work goes on";
  begin();  // the next replaces it
  begin();
  is_over = false;
  jobs.cancel(Jobs::Purpose::look);
  EXPECT_TRUE(Driver::wait_for([&] { return is_over.load(); }));
  Driver::live(50);
  EXPECT_FALSE(was_said);
}

TEST(OpenAny, SaysWhatIsWrong) {
  const std::filesystem::path folder = fresh_folder("open");
  EXPECT_THROW(open_any(folder / "none.nrrd", {}), LoadError);
  const std::filesystem::path text = folder / "letter.txt";
  std::FILE* file = std::fopen(text.c_str(), "w");
  std::fputs("Dear reader", file);
  std::fclose(file);
  try {
    open_any(text, {});
    FAIL() << "a letter was opened";
  } catch (const LoadError& error) {
    EXPECT_NE(std::string(error.what()).find("letter.txt"), std::string::npos) << error.what();
  }
}

}  // namespace parts_test
}  // namespace palpa::explorer
