// The window under a user's actions, with pictures of each state.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <QDockWidget>
#include <QDropEvent>
#include <QGroupBox>
#include <QImageReader>
#include <QLabel>
#include <QLineEdit>
#include <QMimeData>
#include <QPushButton>
#include <QSlider>
#include <QStandardPaths>
#include <QTableWidget>
#include <QToolButton>
#include <QUrl>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <set>

#include "driver.h"
#include "palpa/study/run.h"
#include "tests/shared_data.h"

namespace palpa::explorer {
namespace explorer_test {

namespace fs = std::filesystem;

struct SceneCase {
  const char* name;
  const char* file;
  bool is_shared;
  bool is_solid;  ///< surface modes only
};
void PrintTo(const SceneCase& one, std::ostream* out) { *out << one.name; }
class ExplorerScene : public testing::TestWithParam<SceneCase> {};

fs::path file_of(const SceneCase& one) {
  return one.is_shared && fs::path(one.file).has_parent_path() ? test::shared_data(one.file) : embedded(one.file);
}

/// Presses on the surface nearest to the middle, deeper with the wheel, and holds.
std::optional<QPoint> touch(Driver& driver, int notches) {
  const auto at = driver.surface_px();
  if (!at) return at;
  driver.press(driver.view(), *at);
  driver.is_let_out();
  driver.wheel(driver.view(), *at, notches, Qt::LeftButton);
  driver.hand_rests();
  return at;
}

bool is_felt(Driver& driver) {
  return Driver::wait_for([&] { return driver.force_n() > 0.05; });
}

/// Touches and waits for a force; none after the limit.
std::optional<QPoint> touch_until_felt(Driver& driver, int notches) {
  const auto at = touch(driver, notches);
  return is_felt(driver) ? at : std::nullopt;
}

TEST_P(ExplorerScene, IsOpenedTurnedAndTouched) {
  if (GetParam().is_shared && !fs::exists(test::shared_data())) GTEST_SKIP() << "the shared data are not here";
  Driver driver;
  ASSERT_TRUE(driver.open(file_of(GetParam()))) << driver.message().toStdString();
  ASSERT_TRUE(driver.is_done());
  const std::string name = GetParam().name;
  const QImage before = driver.look(name + "-opened");
  std::set<QRgb> colors;
  for (int x = 0; x < driver.view().width(); x += 5)
    for (int y = 0; y < driver.view().height(); y += 5)
      colors.insert(before.pixel(driver.view().mapTo(&driver.window(), QPoint(x, y))));
  EXPECT_GT(colors.size(), 40U) << "the picture is empty";

  // The start page's picture of an embedded scene (tools/make-pictures).
  if (!GetParam().is_shared) {
    driver.view().show_marks(false);
    driver.view().show_words({}, {});
    driver.view()
        .grab()
        .toImage()
        .scaled(440, 330, Qt::KeepAspectRatioByExpanding, Qt::SmoothTransformation)
        .copy(0, 0, 440, 330)
        .save(QString::fromStdString(PALPA_SCREENSHOTS "/tile-" + name + ".png"));
    driver.view().show_marks(true);
  }

  const Vec3 towards = driver.view().view().towards;
  driver.drag(driver.view(), {40, 40}, {140, 70}, Qt::RightButton);
  EXPECT_LT(dot(driver.view().view().towards, towards), 0.9) << "it did not turn";
  EXPECT_NEAR(norm(driver.view().view().towards), 1.0, 1e-12);
  EXPECT_NEAR(dot(driver.view().view().towards, driver.view().view().up), 0.0, 1e-12);

  const int notches = GetParam().is_shared ? 3 : 6;
  const auto at = GetParam().is_solid ? touch_until_felt(driver, notches) : touch(driver, 6);
  EXPECT_TRUE(at || !GetParam().is_solid) << "nothing was felt";
  if (at) {
    double most_n = driver.force_n();
    if (!GetParam().is_solid) {
      const QPoint to = *at + QPoint(30, 10);
      driver.move(driver.view(), *at, to);
      driver.move(driver.view(), to, *at);
    }
    for (const Instruments::Shown& shown : driver.window().instruments().shown())  // skin may be broken through by now
      most_n = std::max(most_n, norm(shown.command_n));
    EXPECT_TRUE(most_n > 0.05 || Driver::wait_for([&] { return driver.force_n() > 0.05; }, 3000)) << "nothing was felt";
    driver.look(name + "-touched");
    const Moment moment = driver.window().touch().moment();
    const QPointF px = on_screen(driver.view().view(), moment.proxy_m);
    const QImage seen = driver.view().grab().toImage();
    int dark = 0;
    for (int dx = -4; dx <= 4; ++dx)
      for (int dy = -4; dy <= 4; ++dy)
        if (seen.rect().contains(px.toPoint() + QPoint(dx, dy))) dark += qGray(seen.pixel(px.toPoint() + QPoint(dx, dy))) < 130;
    EXPECT_GT(dark, 30) << "the proxy is not where it should be";
    driver.release(driver.view(), *at);
    if (GetParam().is_solid) {
      EXPECT_TRUE(Driver::wait_for([&] { return driver.force_n() < 0.05; }, 5000)) << "let go, and it is still felt";
    }
  } else {
    // A flow: the hand moves in a plane through the view's focus.
    const QPoint middle = driver.view().rect().center();
    driver.press(driver.view(), middle);
    driver.move(driver.view(), middle, middle + QPoint(60, 20));
    driver.look(name + "-touched");
    driver.release(driver.view(), middle + QPoint(60, 20));
  }
  EXPECT_TRUE(driver.window().touch().is_felt());
}

INSTANTIATE_TEST_SUITE_P(InFolder, ExplorerScene,
                         testing::Values(SceneCase{"head_phantom", "head_phantom.toml", false, true},
                                         SceneCase{"flow_phantom", "flow_phantom.toml", false, false},
                                         SceneCase{"wing_phantom", "wing_phantom.toml", false, false},
                                         SceneCase{"beat_phantom", "beat_phantom.toml", false, true},
                                         SceneCase{"head", "head.toml", true, true},
                                         SceneCase{"flow", "flow.toml", true, false},
                                         SceneCase{"wing", "wing.toml", true, false},
                                         SceneCase{"many", "many.toml", true, false},
                                         SceneCase{"bare_ct", "ct_head_cranium/cranium.mhd", true, true}),
                         [](const auto& one) { return std::string(one.param.name); });

TEST(ExplorerInFolder, ARecordedTouchIsATraceThatCanBeFeltAgainAndScrubbed) {
  const fs::path folder = fresh_folder("traces");
  const std::string settings = (folder / "palpa.ini").string();
  QSettings(QString::fromStdString(settings), QSettings::IniFormat).setValue("traces", QString::fromStdString(folder.string()));
  fs::path trace;
  {
    Driver driver({.settings_file = settings});
    ASSERT_TRUE(driver.open(small_head()));
    driver.key(Qt::Key_R);
    ASSERT_TRUE(driver.window().touch().is_recorded()) << driver.message().toStdString();
    trace = driver.window().touch().trace();
    ASSERT_TRUE(driver.run_ticks(300));
    const auto at = touch_until_felt(driver, 8);
    ASSERT_TRUE(at);
    driver.look("recording");
    driver.release(driver.view(), *at);
    ASSERT_TRUE(driver.run_ticks(600));
    ASSERT_TRUE(Driver::wait_for([&] { return driver.window().touch().moment().tick > 1100; }));
    driver.key(Qt::Key_R);
    EXPECT_FALSE(driver.window().touch().is_recorded());
  }
  const TraceReader reader(trace);
  EXPECT_TRUE(reader.header().complete);
  const std::vector<TraceTick> ticks = reader.ticks();
  ASSERT_GT(ticks.size(), 1000U);
  // The trace: no force before the surface, a force where the proxy lags the probe.
  EXPECT_EQ(norm(ticks.front().frame.command.force_n), 0.0);
  double most_n = 0.0;
  for (const TraceTick& tick : ticks) {
    most_n = std::max(most_n, norm(tick.frame.command.force_n));
    if (norm(tick.frame.command.force_n) > 0.1) {
      const double stretched_m = distance(tick.frame.result.probe_m, tick.frame.result.proxy_m);
      EXPECT_GT(stretched_m, 1e-5) << "at " << tick.frame.t_s << " s a force without a spring";
    }
  }
  EXPECT_GT(most_n, 0.1);
  EXPECT_TRUE(replay(trace).difference.same) << replay(trace).difference.where;

  Driver driver;
  driver.window().open(trace);
  Player& player = *driver.window().findChild<Player*>();
  ASSERT_TRUE(Driver::wait_for([&] { return player.has_trace() && player.isVisible(); }));
  EXPECT_FALSE(driver.window().touch().is_felt()) << "a trace is looked at";
  QSlider& bar = *player.findChild<QSlider*>("time_bar");
  QTest::mouseClick(&bar, Qt::LeftButton, {}, {bar.width() / 2, bar.height() / 2});
  bar.setFocus();
  for (int i = 0; i < 5; ++i) QTest::keyClick(&bar, Qt::Key_PageUp);
  EXPECT_GT(player.at_s(), 0.1);
  driver.look("trace-scrubbed");
  driver.key(Qt::Key_P);
  const double from_s = player.at_s();
  EXPECT_TRUE(Driver::wait_for([&] { return player.at_s() > from_s; }, 3000)) << "it does not play";
  driver.key(Qt::Key_P);
  // A film of it: its pictures, to its end. Small ones are drawn and written in a quarter of the time.
  driver.window().resize(800, 500);
  QTest::keyClick(&driver.window(), Qt::Key_F, Qt::ControlModifier);
  EXPECT_TRUE(Driver::wait_for(
      [&] {
        return driver.message().contains("pictures in") || driver.message().contains("film.") ||
               driver.message().contains("no film");
      },
      300'000))  // seven seconds of touch are 180 pictures, at two a second on a busy machine
      << driver.message().toStdString();
  const bool has_ffmpeg = !QStandardPaths::findExecutable("ffmpeg").isEmpty();
  EXPECT_TRUE(driver.message().contains(has_ffmpeg ? "film.mp4" : "film.gif")) << driver.message().toStdString();
  std::size_t pictures = 0, moments = 0;
  for (const auto& entry : fs::recursive_directory_iterator(std::getenv("HOME"))) {
    pictures += entry.path().extension() == ".png";
    if (entry.path().extension() != ".gif") continue;
    QImageReader film(QString::fromStdString(entry.path().string()));
    for (QImage one = film.read(); !one.isNull(); one = film.read()) {
      if (moments++ == 0) {
        EXPECT_EQ(film.nextImageDelay(), 40) << "25 a second";
      }
      one.save(PALPA_SCREENSHOTS "/film.png");
    }
  }
  if (!has_ffmpeg) {
    EXPECT_EQ(moments, pictures);
  }
  EXPECT_NEAR(static_cast<double>(pictures), 25.0 * player.trace()->duration_s, 2.0);
  driver.key(Qt::Key_1, Qt::ControlModifier);
  ASSERT_TRUE(Driver::wait_for([&] { return player.other_moment().has_value(); }));
  QTest::mouseClick(driver.window().findChild<QToolButton*>("close_message"), Qt::LeftButton);
  driver.look("trace-what-if");
  const fs::path second = fresh_folder("second-trace") / "press";
  RunOptions options;
  options.scene = small_head();
  options.hand = "sim:press";
  options.out = second;
  run(options);
  const double alone_s = player.trace()->duration_s;
  driver.window().compare_with(second);
  const double second_s = TraceReader(second).ticks().back().frame.t_s;
  ASSERT_TRUE(Driver::wait_for([&] { return player.other_trace() && player.other_trace()->name == "press"; }))
      << driver.message().toStdString();
  EXPECT_EQ(player.duration_s(), std::max(alone_s, second_s)) << "the longer one is seen to its end";
  for (const TraceTick& tick : TraceReader(second).ticks()) {
    if (tick.frame.tick % 200 != 0) continue;
    player.seek(tick.frame.t_s);
    EXPECT_LT(distance(player.other_moment()->command_n, tick.frame.command.force_n), 1e-12) << "not what was recorded";
  }
  driver.look("two-traces");
  driver.key(Qt::Key_Escape);
  EXPECT_TRUE(Driver::wait_for([&] { return driver.window().touch().is_felt(); })) << "the hand is not one's own again";
}

TEST(ExplorerInFolder, AnotherSceneEndsTheHandThatIsFeltAgain) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  driver.key(Qt::Key_T, Qt::ControlModifier);
  Player& player = *driver.window().findChild<Player*>();
  ASSERT_TRUE(Driver::wait_for([&] { return player.has_trace(); }));
  ASSERT_TRUE(driver.open(embedded("wing_phantom.toml")));
  EXPECT_TRUE(Driver::wait_for([&] { return driver.window().touch().is_felt(); }));
  // A started replay of the scene before is done by then.
  EXPECT_FALSE(Driver::wait_for([&] { return player.has_trace(); }, 5000)) << "the trace of another scene";
}

TEST(ExplorerInFolder, AStrengthThatIsSlidIsFeltAtOnceAndUndone) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  const Scene before = driver.window().document().scene();
  const auto at = touch_until_felt(driver, 8);
  ASSERT_TRUE(at);
  const double felt_n = driver.force_n();
  // The force falls with the stiffness of the coupling.
  FeelPanel& panel = *driver.window().findChild<FeelPanel*>();
  QSlider* slider = nullptr;
  for (ParameterForm* form : panel.findChildren<ParameterForm*>())
    for (QSlider* one : form->findChildren<QSlider*>("slider_0"))
      if (one->accessibleName() == "stiffness") slider = one;
  ASSERT_TRUE(slider);
  driver.release(driver.view(), *at);
  ASSERT_TRUE(touch_until_felt(driver, 8));
  const double pressed_n = driver.force_n();
  EXPECT_NEAR(pressed_n, felt_n, 0.5 * felt_n + 0.1);
  panel.ensureWidgetVisible(slider);
  Driver::live(20);
  const int handle = slider->width() * slider->value() / slider->maximum();
  driver.drag(*slider, {handle, slider->height() / 2}, {handle / 3, slider->height() / 2});
  EXPECT_LT(driver.window().document().scene().coupling().stiffness_n_per_m, 0.8 * before.coupling().stiffness_n_per_m);
  EXPECT_EQ(driver.window().document().undo().count(), 1) << "a drag is one step";
  EXPECT_TRUE(Driver::wait_for([&] { return driver.force_n() < 0.9 * pressed_n; }, 3000)) << "the change is not felt";
  driver.look("stiffness-slid");
  driver.key(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_TRUE(driver.window().document().scene() == before);
  driver.key(Qt::Key_Z, Qt::ControlModifier | Qt::ShiftModifier);
  EXPECT_FALSE(driver.window().document().scene() == before);
}

TEST(ExplorerInFolder, AModeThatIsSwitchedOffIsNotFelt) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  const auto at = touch_until_felt(driver, 8);
  ASSERT_TRUE(at);
  for (QGroupBox* box : driver.window().findChild<FeelPanel*>()->findChildren<QGroupBox*>()) {
    if (!box->isCheckable()) continue;
    QTest::mouseClick(box, Qt::LeftButton, {}, {10, 8});
    EXPECT_FALSE(box->isChecked()) << box->title().toStdString();
  }
  EXPECT_TRUE(Driver::wait_for([&] { return driver.force_n() < 1e-3; }, 3000)) << driver.force_n() << " N";
  driver.look("modes-off");
  driver.release(driver.view(), *at);
}

TEST(ExplorerInFolder, AFunctionThatTheSceneRulesOutIsSaidAndNoEditorOpens) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  const Scene before = driver.window().document().scene();
  for (QToolButton* more : driver.window().findChild<FeelPanel*>()->findChildren<QToolButton*>("more"))
    QTest::mouseClick(more, Qt::LeftButton);
  std::vector<QPushButton*> strengths;
  for (QPushButton* one : driver.window().findChild<FeelPanel*>()->findChildren<QPushButton*>())
    if (one->accessibleName().startsWith("strength as")) strengths.push_back(one);
  ASSERT_GE(strengths.size(), 3u);
  // Of skin, of bone, then of the whole mode, which has levels instead.
  QPushButton* function = strengths[2];
  QTest::mouseClick(function, Qt::LeftButton);
  EXPECT_TRUE(Driver::wait_for([&] { return driver.message().contains("levels and strength_n"); }))
      << driver.message().toStdString();
  EXPECT_FALSE(driver.window().findChild<FunctionEditor*>()->isVisible());
  EXPECT_TRUE(driver.window().document().scene() == before);
}

TEST(ExplorerInFolder, APointOfAFunctionIsDraggedAndTyped) {
  Driver driver;
  ASSERT_TRUE(driver.open(embedded("flow_phantom.toml")));
  QPushButton* function = nullptr;
  for (QPushButton* one : driver.window().findChild<FeelPanel*>()->findChildren<QPushButton*>())
    if (one->objectName().startsWith("function_") && !one->text().startsWith("By value")) function = one;
  ASSERT_TRUE(function) << "the scene has no strength by a field";
  QTest::mouseClick(function, Qt::LeftButton);
  FunctionEditor& editor = *driver.window().findChild<FunctionEditor*>();
  ASSERT_TRUE(Driver::wait_for([&] { return editor.isVisible() && editor.shown().strength.has_value(); }));
  ASSERT_TRUE(driver.is_done());
  driver.look("function-editor");
  const Scene before = driver.window().document().scene();
  QTableWidget& table = *editor.findChild<QTableWidget*>("function_table");
  ASSERT_GE(table.rowCount(), 2);
  const QRect cell = table.visualItemRect(table.item(1, 1));
  QTest::mouseClick(table.viewport(), Qt::LeftButton, {}, cell.center());
  table.setFocus();
  QTest::keyClick(&table, Qt::Key_F2);
  auto* cell_editor = table.findChild<QLineEdit*>();
  ASSERT_TRUE(cell_editor);
  QTest::keyClick(cell_editor, Qt::Key_A, Qt::ControlModifier);
  QTest::keyClicks(cell_editor, "0.7");
  QTest::keyClick(cell_editor, Qt::Key_Return);
  EXPECT_TRUE(Driver::wait_for([&] { return editor.shown().strength->points()[1].result == 0.7; }, 2000));
  EXPECT_NEAR(editor.shown().strength->points()[1].result, 0.7, 1e-12);
  EXPECT_FALSE(driver.window().document().scene() == before);
  QWidget& chart = *editor.findChild<QWidget*>("function_chart");
  const TransferFunction typed = *editor.shown().strength;
  const auto changed = [&] { return !(*editor.shown().strength == typed); };
  const TransferFunction::Point point = typed.points()[1];
  const auto at = editor.place_of(point.value, point.result / editor.shown().largest);
  ASSERT_TRUE(at && chart.rect().contains(*at));
  driver.move(chart, *at - QPoint(3, 3), *at, Qt::NoButton, 3);
  driver.drag(chart, *at, *at + QPoint(25, -20));
  EXPECT_TRUE(Driver::wait_for(changed, 2000)) << "the chart does not hear the mouse";
  EXPECT_EQ(editor.shown().strength->points().size(), typed.points().size());
  EXPECT_GT(editor.shown().strength->points()[1].result, point.result);
  EXPECT_GT(editor.shown().strength->points()[1].value, point.value);
  const Strength* felt = nullptr;
  std::vector<ParameterRow> rows;
  for (const SceneMode& mode : driver.window().document().scene().modes()) {
    rows = rows_of([&](ParameterVisitor& v) { Mode(mode.mode).visit(v); });
    for (const ParameterRow& row : rows)
      if (const auto* one = std::get_if<Strength>(&row.value); one && !felt && !one->is_constant()) felt = one;
    if (felt) break;
  }
  ASSERT_TRUE(felt);
  EXPECT_EQ(felt->curve, *editor.shown().strength) << "what is shown is not what is felt";
  driver.look("function-dragged");
}

TEST(ExplorerInFolder, WindowAndLevelFollowTheRightButton) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  SliceView& slice = *driver.window().findChildren<SliceView*>().front();
  ASSERT_TRUE(driver.is_done());
  Driver::live(200);  // the fine slice
  const QImage before = slice.grab().toImage();
  driver.drag(slice, slice.rect().center(), slice.rect().center() + QPoint(70, 50), Qt::RightButton);
  EXPECT_TRUE(Driver::wait_for([&] { return slice.grab().toImage() != before; }));
  driver.wheel(slice, slice.rect().center(), 4);
  driver.look("window-level");
}

TEST(ExplorerInFolder, ASavedSceneIsTheSameBytesWhenItIsSavedAgain) {
  const fs::path folder = fresh_folder("saved"), file = folder / "mine.toml";
  const auto bytes = [](const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  fs::copy_file(small_head(), file);
  const std::string original = bytes(file);
  std::string saved;
  {
    Driver driver;
    ASSERT_TRUE(driver.open(file));
    driver.key(Qt::Key_S, Qt::ControlModifier);
    EXPECT_EQ(bytes(file), original) << "nothing was changed";
    driver.key(Qt::Key_1, Qt::ControlModifier);
    driver.key(Qt::Key_S, Qt::ControlModifier);
    saved = bytes(file);
    EXPECT_NE(saved, original);
    EXPECT_EQ(bytes(file.string() + "~"), original) << "what was there before is kept";
  }
  Driver driver;
  ASSERT_TRUE(driver.open(file));
  driver.key(Qt::Key_1, Qt::ControlModifier);
  driver.key(Qt::Key_1, Qt::ControlModifier);
  driver.key(Qt::Key_S, Qt::ControlModifier);
  EXPECT_EQ(bytes(file), saved);
}

TEST(ExplorerInFolder, TheStartPageOpensAnEmbeddedScene) {
  Driver driver;
  driver.look("start-page");
  auto* tile = driver.window().findChild<QToolButton*>("tile_head_phantom");
  ASSERT_TRUE(tile);
  QTest::mouseClick(tile, Qt::LeftButton);
  EXPECT_TRUE(Driver::wait_for([&] { return driver.window().touch().is_felt(); }));
}

TEST(ExplorerInFolder, WhatCannotBeOpenedSavedOrRecordedIsSaidAndNothingIsLost) {
  const fs::path folder = fresh_folder("bad");
  const std::string settings = (folder / "palpa.ini").string();
  // No folder for traces: a file has its name.
  std::ofstream(folder / "traces") << "a file";
  QSettings(QString::fromStdString(settings), QSettings::IniFormat)
      .setValue("traces", QString::fromStdString((folder / "traces").string()));
  Driver driver({.settings_file = settings});
  driver.window().open(folder / "none.nrrd");
  EXPECT_TRUE(Driver::wait_for([&] { return driver.message().contains("none.nrrd"); }));
  driver.look("cannot-open");
  const fs::path file = folder / "mine.toml";
  fs::copy_file(small_head(), file);
  ASSERT_TRUE(driver.open(file));
  driver.key(Qt::Key_R);
  EXPECT_FALSE(driver.window().touch().is_recorded());
  EXPECT_TRUE(driver.window().touch().is_felt()) << "it is felt all the same";
  EXPECT_TRUE(driver.message().contains("traces")) << driver.message().toStdString();
  // A scene that cannot be written, since its folder is gone.
  driver.key(Qt::Key_1, Qt::ControlModifier);
  fs::remove_all(folder / "mine.toml");
  fs::rename(folder, folder.string() + "-moved");
  driver.key(Qt::Key_S, Qt::ControlModifier);
  EXPECT_TRUE(driver.message().contains("mine.toml")) << driver.message().toStdString();
  EXPECT_FALSE(driver.window().document().undo().isClean()) << "not saved is not clean";
}

TEST(ExplorerInFolder, AFullDiskWhileItRecordsIsSaidAndItIsFeltOn) {
  const fs::path folder = fresh_folder("full");
  const std::string settings = (folder / "palpa.ini").string();
  QSettings(QString::fromStdString(settings), QSettings::IniFormat).setValue("traces", QString::fromStdString(folder.string()));
  Driver driver({.settings_file = settings});
  ASSERT_TRUE(driver.open(small_head()));
  ::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const rlimit little{.rlim_cur = 200'000, .rlim_max = before.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &little);
  driver.key(Qt::Key_R);
  ASSERT_TRUE(driver.window().touch().is_recorded());
  const fs::path trace = driver.window().touch().trace();
  EXPECT_TRUE(Driver::wait_for([&] { return driver.message().contains("could not be recorded"); }, 30'000));
  EXPECT_TRUE(driver.window().touch().is_felt());
  driver.key(Qt::Key_R);
  EXPECT_TRUE(driver.message().contains("the part written before is kept")) << driver.message().toStdString();
  ::setrlimit(RLIMIT_FSIZE, &before);
  driver.look("full-disk");
  EXPECT_TRUE(driver.window().touch().is_felt()) << "it is felt all the same";
  EXPECT_GT(TraceReader(trace).ticks().size(), 10U);
}

TEST(ExplorerInFolder, WithoutOpenGlThereAreSlicesAndTouch) {
  Driver driver({.has_opengl = false});
  EXPECT_EQ(driver.window().view(), nullptr);
  driver.window().open(small_head());
  ASSERT_TRUE(Driver::wait_for([&] { return driver.window().touch().is_felt(); }));
  SliceView& slice = *driver.window().findChildren<SliceView*>().front();
  const QPoint from(10, slice.height() / 2), to = slice.rect().center();
  driver.press(slice, from);
  EXPECT_TRUE(driver.is_let_out());
  driver.move(slice, from, to, Qt::LeftButton, 60);
  EXPECT_TRUE(is_felt(driver));
  driver.look("no-opengl");
  driver.release(slice, to);
}

TEST(ExplorerInFolder, AFrozenWindowTakesTheForceAwayUntilItLivesAgain) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  const auto at = touch_until_felt(driver, 8);
  ASSERT_TRUE(at);
  ::usleep(static_cast<useconds_t>(1e6 * (Touch::frozen_after_s + 0.5)));
  EXPECT_EQ(norm(driver.window().touch().loop()->latest().frame.command.force_n), 0.0) << "nobody looks, and it is felt";
  EXPECT_TRUE(Driver::wait_for(
      [&] { return driver.window().touch().loop()->latest().frame.command.cause != GuardCause::panic; }, 3000));
  driver.release(driver.view(), *at);
  driver.key(Qt::Key_Space);
  EXPECT_TRUE(driver.window().touch().is_held());
  EXPECT_TRUE(Driver::wait_for([&] { return driver.force_n() == 0.0; }));
  driver.look("no-force");
  EXPECT_EQ(driver.force_n(), 0.0);
  driver.key(Qt::Key_Space);
  EXPECT_FALSE(driver.window().touch().is_held());
}

TEST(ExplorerInFolder, ACrashLeavesTheMotorsWithoutForce) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  const MotorsAtRest motors_at_rest;
  LiveLoop& loop = *driver.window().touch().loop();
  EXPECT_TRUE(Driver::wait_for([&] { return loop.latest().frame.command.cause == GuardCause::stops; }));
  EXPECT_EQ(loop.latest().frame.command.cause, GuardCause::stops);
  EXPECT_EQ(loop.latest().frame.command.force_n, Vec3{});
}

TEST(ExplorerInFolder, AFileThatIsDroppedIsOpened) {
  Driver driver;
  QMimeData files;
  files.setUrls({QUrl::fromLocalFile(QString::fromStdString(embedded("wing_phantom.toml").string()))});
  const QPoint at(300, 300);
  QDragEnterEvent enter(at, Qt::CopyAction, &files, Qt::LeftButton, Qt::NoModifier);
  QApplication::sendEvent(&driver.window(), &enter);
  EXPECT_TRUE(enter.isAccepted());
  QDropEvent drop(at, Qt::CopyAction, &files, Qt::LeftButton, Qt::NoModifier);
  QApplication::sendEvent(&driver.window(), &drop);
  EXPECT_TRUE(Driver::wait_for([&] { return driver.window().windowTitle().contains("wing_phantom"); }, 180'000));
}

TEST(ExplorerInFolder, FitsTheScreenOfALaptop) {
  Driver driver;
  ASSERT_TRUE(driver.open(embedded("flow_phantom.toml")));
  driver.key(Qt::Key_T, Qt::ControlModifier);
  ASSERT_TRUE(Driver::wait_for([&] { return driver.window().findChild<Player*>()->has_trace(); }));
  const QSize least = driver.window().minimumSizeHint();
  EXPECT_LE(least.width(), 1366);
  EXPECT_LE(least.height(), 720) << "768 less what the desktop keeps";
}

TEST(ExplorerInFolder, EveryWidgetThatIsUsedHasANameForWhoCannotSeeIt) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  for (QWidget* widget : driver.window().findChildren<QWidget*>()) {
    if (!widget->isVisible() || widget->focusPolicy() == Qt::NoFocus) continue;
    if (qobject_cast<QAbstractButton*>(widget) && !qobject_cast<QAbstractButton*>(widget)->text().isEmpty()) continue;
    if (widget->metaObject()->className() == std::string("QTabBar") || qobject_cast<QScrollArea*>(widget)) continue;
    if (widget->inherits("QLineEdit") && widget->parentWidget()->inherits("QAbstractSpinBox")) continue;
    const auto named = [](const QWidget* one) { return !one->accessibleName().isEmpty() || !one->objectName().isEmpty(); };
    EXPECT_TRUE(named(widget) || named(widget->parentWidget()) || widget->inherits("QLabel"))
        << widget->metaObject()->className() << " in " << widget->parentWidget()->metaObject()->className();
  }
}

/// A program's message without a display, and its exit code.
std::string said_without_display(const std::string& words) {
  const char* bin = std::getenv("PALPA_BIN");
  const fs::path folder = bin ? bin : "";
  EXPECT_TRUE(fs::exists(folder / "palpa-explorer")) << folder;
  const std::string command = "env -u DISPLAY -u WAYLAND_DISPLAY -u QT_QPA_PLATFORM " + folder.string() + "/" + words +
                              " 2>&1 >/dev/null; echo code $?";
  std::FILE* pipe = ::popen(command.c_str(), "r");
  EXPECT_TRUE(pipe);
  std::string said;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) said += static_cast<char>(c);
  ::pclose(pipe);
  return said;
}

TEST(ExplorerProgram, SaysWhatToDoWhereThereIsNoDisplay) {
  const std::string said = said_without_display("palpa-explorer");
  EXPECT_NE(said.find("no display"), std::string::npos) << said;
  EXPECT_NE(said.find("palpa run"), std::string::npos) << said;
  EXPECT_NE(said.find("code 2"), std::string::npos) << said;
}

TEST(ExplorerProgram, TakesAFileBehindAFolderOfDataForAFile) {
  // Two files are one too many; this message shows that both were taken for files.
  for (const std::string program : {"palpa-explorer", "palpa explore"}) {
    const std::string said = said_without_display(program + " --data /tmp one.toml two.toml");
    EXPECT_NE(said.find("two.toml: one file at a time"), std::string::npos) << said;
    const std::string dashed = said_without_display(program + " --data /tmp -- one.toml -two.toml");
    EXPECT_NE(dashed.find("-two.toml: one file at a time"), std::string::npos) << dashed;
  }
}

}  // namespace explorer_test
}  // namespace palpa::explorer
