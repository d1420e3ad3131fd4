// Views beside touch: linked levels, values under the cursor, cues of touch and turn, coarse and fine drawings.
#include <gtest/gtest.h>
#include <unistd.h>
#include <vtkCallbackCommand.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkNew.h>

#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QElapsedTimer>
#include <QGroupBox>
#include <QLabel>
#include <QLineEdit>
#include <QSlider>
#include <QTabWidget>
#include <cmath>
#include <ctime>

#include "driver.h"
#include "explorer/linked_levels.h"
#include "explorer/paint.h"
#include "explorer/slice_view.h"
#include "palpa/view/layers.h"

namespace palpa::explorer {
namespace seen_felt_test {

double seen_level(const Scene& scene, std::size_t layer) { return *detail::layers_of(scene).at(layer).level; }

/// Types a number into a box as a person does.
void type(QDoubleSpinBox& box, double value) {
  box.setFocus();
  box.selectAll();
  QTest::keyClicks(&box, QString::number(value));
  QTest::keyClick(&box, Qt::Key_Return);
}

/// The box of the first felt level.
QDoubleSpinBox& level_box(Driver& driver) {
  const FeltLevel skin = felt_levels(driver.window().document().scene()).at(0);
  auto* mode = driver.window().findChild<QGroupBox*>("mode_surface");
  return *mode->findChild<QDoubleSpinBox*>(QString("box_%1").arg(skin.row));
}

TEST(ExplorerLevels, FeltAndSeenAreOneUntilTheLinkIsCutAndThatShows) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  const auto scene = [&]() -> const Scene& { return driver.window().document().scene(); };
  // Layers of their own, as a suggested scene has them.
  driver.window().document().edit("layers", -1, [](Scene& changed) { changed.layers = detail::layers_of(changed); });
  ASSERT_EQ(scene().layers.size(), 2u);
  type(level_box(driver), 100.0);
  EXPECT_EQ(felt_levels(scene()).at(0).value, 100.0);
  EXPECT_EQ(seen_level(scene(), 0), 100.0) << "what is felt is not seen";
  EXPECT_EQ(seen_level(scene(), 1), 400.0) << "bone stays";
  driver.key(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_EQ(seen_level(scene(), 0), felt_levels(scene()).at(0).value) << "one step back for both";

  auto& see = *driver.window().findChild<SeePanel*>();
  auto& link = *see.findChild<QCheckBox*>("link_0");
  see.ensureWidgetVisible(&link);
  driver.window().findChild<QTabWidget*>()->setCurrentWidget(&see);
  EXPECT_TRUE(link.isChecked());
  EXPECT_TRUE(link.text().contains("skin")) << link.text().toStdString();
  QTest::mouseClick(&link, Qt::LeftButton, {}, {8, link.height() / 2});
  EXPECT_FALSE(link.isChecked());
  type(level_box(driver), 50.0);
  EXPECT_EQ(felt_levels(scene()).at(0).value, 50.0);
  EXPECT_EQ(seen_level(scene(), 0), -300.0) << "cut by the user";
  EXPECT_TRUE(link.text().contains("-300") && link.text().contains("50")) << link.text().toStdString();
  driver.look("broken-link");
  QTest::mouseClick(&link, Qt::LeftButton, {}, {8, link.height() / 2});
  EXPECT_TRUE(link.isChecked());
  EXPECT_EQ(seen_level(scene(), 0), 50.0);
}

TEST(ExplorerLevels, ALayerThatIsMovedTakesTheFeltLevelAlong) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  driver.window().document().edit("level", -1, [](Scene& scene) {
    scene.layers = detail::layers_of(scene);
    scene.layers[1].level = 700.0;
  });
  EXPECT_EQ(felt_levels(driver.window().document().scene()).at(1).value, 700.0);
}

TEST(ExplorerLevels, ALayerIsHiddenAndTurnedPale) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  ASSERT_TRUE(driver.is_done());
  auto& see = *driver.window().findChild<SeePanel*>();
  driver.window().findChild<QTabWidget*>()->setCurrentWidget(&see);
  Driver::live(20);
  auto& skin = *see.findChild<QGroupBox*>("layer_0");
  EXPECT_TRUE(skin.title().contains("skin")) << skin.title().toStdString();
  EXPECT_EQ(skin.findChild<QLineEdit*>("name")->placeholderText(), skin.title()) << "the scene names no layer";
  const QImage shown = driver.view().grab().toImage();
  QTest::mouseClick(&skin, Qt::LeftButton, {}, {10, 8});
  EXPECT_FALSE(skin.isChecked());
  EXPECT_NE(driver.view().grab().toImage(), shown) << "it is still seen";
  driver.look("layer-hidden");
  QTest::mouseClick(&skin, Qt::LeftButton, {}, {10, 8});
  EXPECT_TRUE(skin.isChecked());
  auto& opacity = *see.findChild<QSlider*>("opacity_0");
  opacity.setFocus();
  for (int i = 0; i < 3; ++i) QTest::keyClick(&opacity, Qt::Key_PageUp);
  const ViewLayer layer = driver.window().document().scene().layers.at(0);
  ASSERT_EQ(layer.colors.size(), 1u);
  EXPECT_NEAR(layer.colors[0].opacity, 0.7, 1e-12);
  EXPECT_EQ(driver.window().document().undo().count(), 1) << "one slide, one step";
}

// As after a long drawing, when both wait in the window's queue.
TEST(ExplorerPointer, APressThatIsReleasedAtOnceLeadsTheHandOffTheTouchedPlace) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  ASSERT_TRUE(driver.is_done());
  View3D& view = driver.view();
  const QPoint middle = view.rect().center();
  driver.press(view, middle);
  ASSERT_TRUE(driver.run_ticks(200));
  driver.release(view, middle);
  ASSERT_TRUE(driver.run_ticks(200));
  view.turn(180.0, 0.0);
  const auto target = view.target_at(middle);
  ASSERT_TRUE(target && target->on_surface);
  driver.press(view, middle);
  driver.release(view, middle);
  ASSERT_TRUE(driver.run_ticks(500));
  EXPECT_LT(distance(driver.window().touch().moment().probe_m, target->at_m), 0.02) << "the hand goes through the head";
  EXPECT_LT(driver.force_n(), 0.01);
}

TEST(ExplorerPointer, SaysPositionValueAndFieldUnderTheCursorAlways) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  auto& words = *driver.window().findChild<QLabel*>("pointed");
  SliceView& slice = *driver.window().findChildren<SliceView*>().front();
  driver.move(slice, slice.rect().center() - QPoint(20, 0), slice.rect().center(), Qt::NoButton, 3);
  EXPECT_TRUE(Driver::wait_for([&] { return words.text().contains("head = ") && words.text().contains("HU"); }, 2000))
      << words.text().toStdString();
  EXPECT_EQ(words.text().count("mm"), 3) << words.text().toStdString();
  const auto at = driver.surface_px();
  ASSERT_TRUE(at);
  QTest::mouseMove(&driver.view(), *at - QPoint(2, 0));
  driver.move(driver.view(), *at - QPoint(2, 0), *at, Qt::NoButton, 2);
  // On the skin, to the step of the search for it.
  EXPECT_TRUE(Driver::wait_for([&] { return words.text().contains("head = -3") || words.text().contains("head = -29"); }, 3000))
      << words.text().toStdString();
  driver.look("value-under-cursor");
}

TEST(ExplorerPointer, ShowsTouchOrTurnBeforeThePressAndCanBeSwitched) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  const auto at = driver.surface_px();
  ASSERT_TRUE(at);
  const auto has_cursor_at = [&](const QPoint& px, Qt::CursorShape shape) {
    QTest::mouseMove(&driver.view(), px - QPoint(1, 0));
    driver.move(driver.view(), px - QPoint(1, 0), px, Qt::NoButton, 1);
    return Driver::wait_for([&] { return driver.view().cursor().shape() == shape; }, 3000);
  };
  EXPECT_TRUE(has_cursor_at(*at, Qt::PointingHandCursor));
  driver.look("hover-touch");
  EXPECT_TRUE(has_cursor_at({6, 6}, Qt::OpenHandCursor));
  driver.key(Qt::Key_T);
  EXPECT_TRUE(has_cursor_at(*at, Qt::OpenHandCursor)) << "turn is on";
  const Vec3 towards = driver.view().view().towards;
  driver.drag(driver.view(), *at, *at + QPoint(60, 0));
  EXPECT_LT(dot(driver.view().view().towards, towards), 0.99) << "it did not turn";
  EXPECT_FALSE(driver.force_n() > 0.05);
  driver.key(Qt::Key_T);
  EXPECT_TRUE(driver.view().target_at(driver.surface_px().value_or(*at)));
}

TEST(ExplorerPointer, TheWheelPressesAlongTheNormalOfTheSurface) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  const auto middle = driver.surface_px();
  ASSERT_TRUE(middle);
  // A place that is seen askew.
  QPoint askew = *middle;
  std::optional<View3D::Target> target;
  for (int x = 0; x < 400; x += 4) {
    const auto there = driver.view().target_at(*middle + QPoint(x, 0));
    if (there && there->on_surface && dot(there->into, -driver.view().view().towards) < 0.8) {
      target = there;
      askew = *middle + QPoint(x, 0);
      break;
    }
  }
  ASSERT_TRUE(target);
  driver.press(driver.view(), askew);
  const Vec3 before_m = driver.window().touch().led_to_m();
  driver.wheel(driver.view(), askew, 5, Qt::LeftButton);
  const Vec3 way_m = driver.window().touch().led_to_m() - before_m;
  EXPECT_GT(norm(way_m), 1e-3);
  EXPECT_GT(dot(normalized(way_m), target->into), 0.9999) << "not into the surface";
  driver.release(driver.view(), askew);
}

TEST(ExplorerPointer, AFlowIsTouchedAtTheDepthOfItsNearestLineOrOfTheCross) {
  Driver driver;
  ASSERT_TRUE(driver.open(embedded("wing_phantom.toml")));
  ASSERT_TRUE(driver.is_done());
  const detail::View& view = driver.view().view();
  const std::vector<Vec3>& lines_m = driver.view().drawing().stream_points_m;
  ASSERT_FALSE(lines_m.empty());
  const Vec3 on_line_m = lines_m[lines_m.size() / 2];
  const auto target = driver.view().target_at(on_screen(view, on_line_m));
  ASSERT_TRUE(target);
  EXPECT_FALSE(target->on_surface);
  double nearest_m = 1.0;
  for (const Vec3& point_m : lines_m) nearest_m = std::min(nearest_m, distance(point_m, target->at_m));
  EXPECT_LT(nearest_m, 8.0 / view.px_per_m()) << "beside all lines";
  EXPECT_GE(dot(target->at_m - on_line_m, view.towards), -1e-9) << "behind the line that is seen";
  const Vec3 cross_m{0.0, 0.0, 0.02};
  driver.view().set_cross(cross_m);
  const auto aside = driver.view().target_at({-400.0, -400.0});
  ASSERT_TRUE(aside);
  EXPECT_NEAR(dot(aside->at_m - cross_m, view.towards), 0.0, 1e-12);
  driver.look("flow-lines");
}

/// Opens a file, and prints when its pictures were drawn.
void expect_coarse_then_fine(const std::filesystem::path& file) {
  Driver driver;
  QElapsedTimer timer;
  timer.start();
  const std::clock_t before = std::clock();
  driver.window().open(file);
  const auto drawn = [&] { return largest_component(driver.view().drawing().bounds_m.size_m()) > 0.0; };
  ASSERT_TRUE(Driver::wait_for([&] { return driver.window().document().is_open(); }, 120'000));
  const double read_s = 1e-3 * static_cast<double>(timer.elapsed());
  ASSERT_TRUE(Driver::wait_for(drawn, 60'000));
  const double coarse_s = 1e-3 * static_cast<double>(timer.elapsed());
  EXPECT_TRUE(driver.view().drawing().is_rough);
  const std::size_t few = driver.view().drawing().fine_triangles;
  ASSERT_TRUE(driver.is_done());
  const double fine_s = 1e-3 * static_cast<double>(timer.elapsed());
  EXPECT_FALSE(driver.view().drawing().is_rough);
  EXPECT_GT(driver.view().drawing().fine_triangles, 3 * few);
  std::printf("%s: read in %.2f s, coarse picture after %.2f s, fine after %.2f s (%.2f s of processors)\n",
              file.filename().c_str(), read_s, coarse_s, fine_s, static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC);
}

TEST(ExplorerFirstPicture, IsCoarseAtOnceAndFineAfter) { expect_coarse_then_fine(embedded("head_phantom.toml")); }

TEST(ExplorerFirstPicture, OfADicomFolderIsCoarseAtOnceAndFineAfter) {
  const std::filesystem::path folder = test::shared_data_folder() / "ct_headphantom_dicom";
  if (!std::filesystem::is_directory(folder)) GTEST_SKIP() << folder << " is not here";
  expect_coarse_then_fine(folder);
}

TEST(ExplorerFirstPicture, ThatIsSlowToDrawCutsNoForce) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  ASSERT_TRUE(driver.is_done());
  const auto at = driver.surface_px();
  ASSERT_TRUE(at);
  driver.press(driver.view(), *at);
  ASSERT_TRUE(driver.is_let_out());
  driver.wheel(driver.view(), *at, 6, Qt::LeftButton);
  ASSERT_TRUE(Driver::wait_for([&] { return driver.force_n() > 0.05; }));
  ASSERT_TRUE(driver.hand_rests());
  // A scene that takes longer to draw than a dead window is trusted.
  vtkNew<vtkCallbackCommand> slow;
  slow->SetCallback(
      [](vtkObject*, unsigned long, void*, void*) { ::usleep(static_cast<useconds_t>(1.5e6 * Touch::frozen_after_s)); });
  driver.view().renderWindow()->AddObserver(vtkCommand::StartEvent, slow);
  driver.view().zoom(1.01);
  driver.view().renderWindow()->RemoveObserver(slow);
  EXPECT_NE(driver.window().touch().loop()->latest().frame.command.cause, GuardCause::panic);
  Driver::live(50);
  const auto& shown = driver.window().instruments().shown();
  ASSERT_FALSE(shown.empty());
  const double end_s = shown.back().t_s;
  for (const Instruments::Shown& one : shown) {
    if (one.t_s > end_s - 1.4 * Touch::frozen_after_s) {
      ASSERT_GT(norm(one.command_n), 0.02) << "lost " << end_s - one.t_s << " s ago";
    }
  }
  driver.release(driver.view(), *at);
}

TEST(ExplorerFirstPicture, NoiseIsNotDrawnAsFlow) {
  Driver driver;
  ASSERT_TRUE(driver.open(embedded("flow_phantom.toml")));
  ASSERT_TRUE(driver.is_done());
  const Scene& scene = driver.window().document().scene();
  const FieldPtr signal = detail::in_hand_frame(scene.field({"heart.signal"}).field, scene.hand_to_world());
  const std::vector<Vec3>& lines_m = driver.view().drawing().stream_points_m;
  ASSERT_FALSE(lines_m.empty());
  std::size_t noise = 0;
  for (const Vec3& point_m : lines_m) noise += signal->scalar(point_m).value < 0.3;
  // Tubes have a width.
  EXPECT_LT(static_cast<double>(noise), 0.02 * static_cast<double>(lines_m.size()));
  driver.look("flow-masked");
}

}  // namespace seen_felt_test
}  // namespace palpa::explorer
