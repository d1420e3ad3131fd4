// A tool in the window's hand: its feet and torque seen, turned by the mouse, changed in the panel.
#include <gtest/gtest.h>

#include <QComboBox>
#include <QGroupBox>
#include <QLabel>
#include <QMouseEvent>
#include <algorithm>
#include <fstream>

#include "driver.h"

namespace palpa::explorer {
namespace tool_test {

/// The small head with a rod that is held at its end.
std::filesystem::path small_head_with_a_rod() {
  const std::filesystem::path file = small_head();
  std::ofstream(file, std::ios::app) << "\n[tool]\nshape = \"rod\"\nlength_m = 0.06\npoints = 7\ncentre_m = [0, 0, 0.03]\n";
  return file;
}

void drag_with_ctrl(View3D& view, const QPoint& from, const QPoint& to) {
  QTest::mousePress(&view, Qt::LeftButton, Qt::ControlModifier, from);
  QMouseEvent event(QEvent::MouseMove, to, view.mapTo(view.window(), to), view.mapToGlobal(to), Qt::NoButton, Qt::LeftButton,
                    Qt::ControlModifier);
  QApplication::sendEvent(&view, &event);
  QTest::mouseRelease(&view, Qt::LeftButton, Qt::ControlModifier, to);
}

TEST(ExplorerTool, ItsTipTouchesUnderTheCursorAndForceAndTorqueAreSaid) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head_with_a_rod()));
  ASSERT_TRUE(driver.is_done());
  View3D& view = driver.view();
  const auto at = driver.surface_px();
  ASSERT_TRUE(at);
  const auto target = view.target_at(*at);
  ASSERT_TRUE(target && target->on_surface);
  driver.press(view, *at);
  ASSERT_TRUE(driver.is_let_out());
  driver.wheel(view, *at, 6, Qt::LeftButton);
  ASSERT_TRUE(Driver::wait_for([&] { return driver.force_n() > 0.05; }));
  ASSERT_TRUE(driver.hand_rests());
  const Moment moment = driver.window().touch().moment();
  ASSERT_TRUE(moment.has_tool);
  EXPECT_GT(moment.feet_n[0], 0.03) << "the tip";
  EXPECT_EQ(moment.feet_n[6], 0.0F) << "the end in the hand";
  const Scene& scene = driver.window().document().scene();
  const Tool tool(scene.tool(), scene.coupling());
  EXPECT_LT(distance(tool.foot_m({moment.proxy_m, moment.proxy_turn}, 0), target->at_m), 0.01);
  const auto says = [](const QString& words) { return words.contains(" N, ") && words.contains(QString::fromUtf8("mN·m")); };
  driver.look("tool");
  EXPECT_TRUE(std::ranges::any_of(view.texts(), [&](const PlacedText& text) { return says(text.words); }));
  EXPECT_TRUE(Driver::wait_for([&] {
    const QList<QLabel*> labels = driver.window().instruments().findChildren<QLabel*>();
    return std::ranges::any_of(labels, [&](QLabel* label) { return says(label->text().replace(", torque", ",")); });
  }));
  const auto& curve = driver.window().instruments().shown();
  const auto most = std::ranges::max_element(curve, {}, [](const Instruments::Shown& one) { return norm(one.command_nm); });
  ASSERT_NE(most, curve.end());
  EXPECT_GE(norm(most->command_nm), 0.9 * norm(moment.torque_nm));
  EXPECT_GT(norm(most->command_nm), 0.0);
  driver.release(view, *at);
}

TEST(ExplorerTool, HasACurveOfItsTorqueAndAPointHasNone) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  auto* torque = driver.window().findChild<QWidget*>("torque");
  ASSERT_TRUE(torque);
  EXPECT_FALSE(torque->isVisible());
  ASSERT_TRUE(driver.open(small_head_with_a_rod()));
  EXPECT_TRUE(torque->isVisible());
  driver.look("tool-torque");
  auto* of_trace = driver.window().findChild<QWidget*>("torque_of_trace");
  ASSERT_TRUE(of_trace);
  driver.key(Qt::Key_T, Qt::ControlModifier);
  EXPECT_TRUE(Driver::wait_for([&] { return of_trace->isVisible(); }, 60'000)) << "of a simulated hand's trace";
  driver.look("tool-trace");
  driver.key(Qt::Key_Escape);
  driver.window().document().edit("point", -1, [](Scene& scene) { scene.set(ToolOptions{}); });
  EXPECT_FALSE(torque->isVisible());
}

TEST(ExplorerTool, ADragWithCtrlTurnsItAndNotTheView) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head_with_a_rod()));
  ASSERT_TRUE(driver.is_done());
  View3D& view = driver.view();
  ASSERT_TRUE(driver.run_ticks(50));
  EXPECT_EQ(driver.window().touch().moment().probe_turn, Turn{});
  const Vec3 towards = view.view().towards;
  drag_with_ctrl(view, {20, 20}, {120, 20});
  EXPECT_EQ(view.view().towards, towards) << "the view was turned";
  const Turn wanted = turn_by(100.0 * 0.4 * M_PI / 180.0 * view.view().up);
  EXPECT_TRUE(Driver::wait_for([&] {
    return norm(rotation_between_rad(driver.window().touch().moment().probe_turn, wanted)) < 1e-3;
  })) << "40 degrees about the picture's vertical";
  driver.look("tool-turned");
}

TEST(ExplorerTool, IsFeltAfterTheEndOfARecordingOfAPoint) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  driver.key(Qt::Key_R);
  Touch& touch = driver.window().touch();
  ASSERT_TRUE(Driver::wait_for([&] { return touch.is_recorded() && touch.moment().tick > 0; }));
  const std::filesystem::path trace = touch.trace();
  driver.window().document().edit(
      "rod", -1, [](Scene& scene) { scene.set(ToolOptions{.shape = ToolOptions::Shape::rod, .length_m = 0.04}); });
  EXPECT_TRUE(Driver::wait_for([&] { return driver.message().contains("no columns for a tool; end it"); }));
  EXPECT_FALSE(touch.moment().has_tool);
  driver.key(Qt::Key_R);
  EXPECT_TRUE(Driver::wait_for([&] { return touch.moment().has_tool; })) << "felt once the recording has ended";
  std::filesystem::remove_all(trace);
}

TEST(ExplorerTool, IsChosenInThePanelAndTakenBack) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  ASSERT_TRUE(driver.is_done());
  auto* group = driver.window().findChild<QGroupBox*>("tool");
  ASSERT_TRUE(group);
  auto* shape = group->findChild<QComboBox*>();
  ASSERT_TRUE(shape);
  EXPECT_EQ(shape->currentText(), "point");
  const auto tool = [&] { return driver.window().document().scene().tool(); };
  for (const auto& [name, chosen] :
       {std::pair("rod", ToolOptions::Shape::rod), std::pair("pad", ToolOptions::Shape::pad),
        std::pair("points", ToolOptions::Shape::points), std::pair("ball", ToolOptions::Shape::ball)}) {
    shape->setCurrentText(name);
    Q_EMIT shape->activated(shape->currentIndex());
    EXPECT_EQ(tool().shape, chosen) << driver.message().toStdString();
    EXPECT_EQ(problem_with(tool()), nullptr);
  }
  EXPECT_TRUE(Driver::wait_for([&] { return driver.window().touch().moment().has_tool; })) << "the session goes on with it";
  driver.look("tool-panel");
  for (int n = 0; n < 4; ++n) driver.key(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_EQ(tool(), ToolOptions{});
  EXPECT_TRUE(Driver::wait_for([&] { return !driver.window().touch().moment().has_tool; }));
}

}  // namespace tool_test
}  // namespace palpa::explorer
