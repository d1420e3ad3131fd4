// Two traces beside each other in the window.
#include <gtest/gtest.h>

#include <QLabel>
#include <QToolButton>

#include "driver.h"
#include "palpa/study/run.h"
#include "palpa/trace/trace.h"

namespace palpa::explorer {
namespace compare_test {

namespace fs = std::filesystem;

void record(const fs::path& out, const std::string& hand, const std::string& strength) {
  RunOptions options;
  options.scene = small_head();
  options.hand = hand;
  options.out = out;
  options.duration_s = 2.0;
  options.primitives = true;
  options.scene_options.sets = {{"mode.surface.level.skin.strength_n", strength}};
  run(options);
}

/// Words of the window on two traces; empty while it shows none.
QString difference(const Player& player) {
  const auto* label = player.findChild<QLabel*>("difference");
  return label->isVisible() ? label->text() : QString();
}

bool is_stopped_at(const Player& player, double t_s) { return std::abs(player.at_s() - t_s) < 1e-9; }

TEST(ExplorerCompare, ASummarySaysTheLargestDifferenceAndAClickOrNGoesThere) {
  const fs::path folder = fresh_folder("compare");
  record(folder / "first", "sim:stroke", "1.2");
  record(folder / "second", (folder / "first/ticks.csv").string(), "0.6");
  const std::vector<TraceTick> first = TraceReader(folder / "first").ticks(), second = TraceReader(folder / "second").ticks();
  ASSERT_EQ(first.size(), second.size());
  double most_n = 0.0, at_s = 0.0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const double apart_n = distance(first[i].frame.command.force_n, second[i].frame.command.force_n);
    if (apart_n > most_n) most_n = apart_n, at_s = first[i].frame.t_s;
  }
  ASSERT_GT(most_n, 0.1);

  Driver driver;
  driver.window().open(folder / "first", folder / "second");
  Player& player = *driver.window().findChild<Player*>();
  ASSERT_TRUE(Driver::wait_for([&] { return player.other_trace() != nullptr && !difference(player).isEmpty(); }))
      << driver.message().toStdString();
  ASSERT_TRUE(driver.is_done());
  const QString words = difference(player);
  EXPECT_TRUE(words.contains(QString("largest difference is %1 N, at %2 s").arg(most_n, 0, 'f', 2).arg(at_s, 0, 'f', 3)))
      << words.toStdString();
  EXPECT_TRUE(words.contains("the hand is at ") && words.contains("root mean square")) << words.toStdString();

  auto* go = player.findChild<QToolButton*>("to_difference");
  ASSERT_TRUE(go->isVisible());
  QTest::mouseClick(go, Qt::LeftButton);
  EXPECT_TRUE(is_stopped_at(player, at_s)) << player.at_s() << " s in place of " << at_s << " s";
  EXPECT_NEAR(distance(player.moment().command_n, player.other_moment()->command_n), most_n, 1e-12);
  driver.look("compare-summary");

  player.seek(0.0);
  for (int stop = 0; stop < 100 && !driver.message().contains("largest difference"); ++stop) driver.key(Qt::Key_N);
  EXPECT_TRUE(is_stopped_at(player, at_s)) << "N stopped at " << player.at_s() << " s";

  // Beside itself nothing differs: there is no place to go to.
  driver.window().compare_with(folder / "first");
  EXPECT_TRUE(Driver::wait_for([&] { return difference(player).contains("identical"); })) << difference(player).toStdString();
  EXPECT_FALSE(go->isVisible());
  // Another hand: the summary says so, and gives no figure.
  record(folder / "other", "sim:press", "1.2");
  driver.window().compare_with(folder / "other");
  EXPECT_TRUE(Driver::wait_for([&] { return difference(player).startsWith("The hands of the two traces differ: from tick "); }))
      << difference(player).toStdString();
  EXPECT_FALSE(go->isVisible());
  driver.key(Qt::Key_Escape);
  EXPECT_TRUE(Driver::wait_for([&] { return driver.window().touch().is_felt(); }));
  EXPECT_TRUE(difference(player).isEmpty());
}

TEST(ExplorerCompare, AChangedSceneIsComparedUnderTheSimulatedHandOfTheFirst) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  driver.key(Qt::Key_T, Qt::ControlModifier);
  Player& player = *driver.window().findChild<Player*>();
  ASSERT_TRUE(Driver::wait_for([&] { return player.has_trace(); }));
  EXPECT_TRUE(difference(player).isEmpty()) << "one trace has no difference";
  driver.key(Qt::Key_1, Qt::ControlModifier);
  ASSERT_TRUE(Driver::wait_for([&] { return player.other_moment().has_value(); }));
  EXPECT_TRUE(difference(player).contains("The largest difference is ")) << difference(player).toStdString();
  driver.look("compare-changed-scene");
}

}  // namespace compare_test
}  // namespace palpa::explorer
