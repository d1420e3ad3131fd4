// The window itself: keys with any focus, start page, size, slices.
#include <gtest/gtest.h>

#include <QDockWidget>
#include <QDoubleSpinBox>
#include <QLabel>
#include <QProcess>
#include <QPushButton>
#include <QScreen>
#include <QToolButton>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>

#include "driver.h"
#include "explorer/slice_view.h"
#include "explorer/start_page.h"
#include "palpa/data/analytic.h"
#include "tests/data/pyramid.h"

namespace palpa::explorer {
namespace window_test {

TEST(ExplorerWindow, UndoAndForceOffWorkWhileANumberIsTyped) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  const Scene before = driver.window().document().scene();
  QDoubleSpinBox* box = nullptr;
  for (QDoubleSpinBox* one : driver.window().findChildren<QDoubleSpinBox*>())
    if (!box && one->isVisible() && one->isEnabled()) box = one;
  ASSERT_TRUE(box);
  box->setFocus();
  box->selectAll();
  QTest::keyClicks(box, QString::number(0.5 * (box->minimum() + std::min(box->maximum(), box->value() + 10.0))));
  QTest::keyClick(box, Qt::Key_Return);
  ASSERT_FALSE(driver.window().document().scene() == before) << "nothing was typed";
  ASSERT_TRUE(box->hasFocus());
  QTest::keyClick(box, Qt::Key_Z, Qt::ControlModifier);
  EXPECT_TRUE(driver.window().document().scene() == before);
  QTest::keyClick(box, Qt::Key_Z, Qt::ControlModifier | Qt::ShiftModifier);
  EXPECT_FALSE(driver.window().document().scene() == before);
  box->setFocus();
  QTest::keyClick(box, Qt::Key_Space);
  EXPECT_TRUE(driver.window().touch().is_held());
}

TEST(ExplorerWindow, APictureOfTheStartPageOpensByReturn) {
  Driver driver;
  auto* const tile = driver.window().findChild<QToolButton*>("tile_wing_phantom");
  ASSERT_TRUE(tile);
  tile->setFocus();
  driver.look("start-page-by-keys");
  QTest::keyClick(tile, Qt::Key_Return);
  EXPECT_TRUE(Driver::wait_for([&] { return driver.window().document().is_open(); }));
  EXPECT_FALSE(driver.window().touch().is_held());
}

TEST(ExplorerWindow, TheWindowFitsTheScreenAndKeepsItsSize) {
  application();  // has the screen
  WindowOptions options;
  options.settings_file = (fresh_folder("window") / "palpa.ini").string();
  const QSize screen = QGuiApplication::primaryScreen()->availableGeometry().size();
  const QSize small(900, 640);
  {
    Driver driver(options);
    EXPECT_LE(driver.window().width(), screen.width());
    EXPECT_LE(driver.window().height(), screen.height());
    driver.window().resize(small);
    driver.window().close();
  }
  Driver driver(options);
  EXPECT_EQ(driver.window().size(), small.expandedTo(driver.window().minimumSizeHint()));
}

TEST(ExplorerWindow, ItsPanelsAreKept) {
  WindowOptions options;
  options.settings_file = (fresh_folder("panels") / "palpa.ini").string();
  int width_px = 0;
  const auto dock = [](Driver& driver, const char* name) { return driver.window().findChild<QDockWidget*>(name); };
  {
    Driver driver(options);
    ASSERT_TRUE(driver.open(small_head()));
    QDockWidget* const panel = dock(driver, "panel");
    const int before_px = panel->width();
    driver.window().resizeDocks({panel}, {before_px + 90}, Qt::Horizontal);
    ASSERT_TRUE(Driver::wait_for([&] { return panel->width() > before_px + 60; }, 3000));
    dock(driver, "instruments")->hide();
    dock(driver, "function")->show();
    width_px = panel->width();
  }
  Driver driver(options);
  EXPECT_FALSE(dock(driver, "panel")->isVisible()) << "the start page is alone";
  ASSERT_TRUE(driver.open(small_head()));
  EXPECT_TRUE(Driver::wait_for([&] { return std::abs(dock(driver, "panel")->width() - width_px) <= 2; }, 3000))
      << dock(driver, "panel")->width() << " and " << width_px;
  EXPECT_FALSE(dock(driver, "instruments")->isVisible());
  EXPECT_FALSE(dock(driver, "function")->isVisible()) << "of no strength";
}

TEST(ExplorerWindow, RecordingsStandBelowRecentFiles) {
  WindowOptions options;
  const std::filesystem::path folder = fresh_folder("recent"), trace = folder / "touch";
  options.settings_file = (folder / "palpa.ini").string();
  std::filesystem::create_directory(trace);
  std::ofstream(trace / "trace.toml") << "palpa_trace = 1";
  const QString scan = QString::fromStdString((folder / "scan.nrrd").string()), touch = QString::fromStdString(trace.string());
  QSettings(QString::fromStdString(options.settings_file), QSettings::IniFormat).setValue("recent", QStringList{touch, scan});
  Driver driver(options);
  std::map<QString, int> top_px;
  const auto* const page = driver.window().findChild<StartPage*>();
  for (const QLabel* label : page->findChildren<QLabel*>()) top_px[label->text()] = label->y();
  for (const QPushButton* button : page->findChildren<QPushButton*>()) top_px[button->toolTip()] = button->y();
  EXPECT_LT(top_px.at("<b>Recent files</b>"), top_px.at(scan));
  EXPECT_LT(top_px.at(scan), top_px.at("<b>My recordings</b>"));
  EXPECT_LT(top_px.at("<b>My recordings</b>"), top_px.at(touch));
  driver.look("start-page-recent");
}

TEST(ExplorerWindow, ASliceHasTheWindowOfCtOnlyForHounsfieldUnits) {
  const auto window_of = [](const std::string& unit) {
    Volume volume = head_phantom();
    volume.fields[0].unit = unit;
    Scene scene;
    const FieldRef field = scene.add("scan", sampled(volume, 40));
    scene.layers.push_back({.show = ViewLayer::Show::slices, .field = field});
    const SliceLook look = slice_look_of(scene);
    return look.high - look.low;
  };
  EXPECT_EQ(window_of("HU"), 1500.0);
  EXPECT_GT(window_of("1/s2"), 1900.0) << "of other units the whole range";
}

TEST(ExplorerWindow, ASliceOfAVolumeInOctavesNamesTheOneThatItShows) {
  Volume volume = sampled(head_phantom(), 96);
  volume.fields[0].field = test::in_octaves(*volume.fields[0].field, 3);
  Scene scene;
  const FieldRef field = scene.add("scan", volume);
  scene.layers.push_back({.show = ViewLayer::Show::slices, .field = field});
  const SliceLook look = slice_look_of(scene), fine = in_fine_octave(scene, look);
  EXPECT_EQ(look.octave, 2) << "at once";
  EXPECT_EQ(fine.octave, 0);
  EXPECT_EQ(fine.name, look.name);
  const Vec3 middle = look.field->bounds_m().centre_m();
  EXPECT_NEAR(*value_at(*fine.field, middle), *value_at(*look.field, middle), 200.0);
  EXPECT_FALSE(slice_look_of(Scene()).octave);
}

/// Exit code of `palpa explore` with these words.
int explored(const std::string& words) {
  const char* bin = std::getenv("PALPA_BIN");
  const int status = std::system(((bin ? bin : "") + ("/palpa explore " + words) + " 2>/dev/null").c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(ExplorerWindow, AProgramSavesItAsAPictureAndClosesIt) {
  application();  // starts the display
  const std::filesystem::path folder = fresh_folder("screenshot");
  const std::string scene = embedded("wing_phantom.toml").string(), file = (folder / "wing.png").string();
  QProcess program;
  const char* bin = std::getenv("PALPA_BIN");
  program.start(QString(bin ? bin : "") + "/palpa", {"explore", QString::fromStdString(scene), "--screenshot",
                                                     QString::fromStdString(file), "--quit-after-s", "120"});
  EXPECT_TRUE(Driver::wait_for([&] { return std::filesystem::exists(file); }, 120'000));
  EXPECT_EQ(program.state(), QProcess::Running) << "it is closed at its time, not before";
  program.kill();
  program.waitForFinished();
  const QImage picture(QString::fromStdString(file));
  ASSERT_GT(picture.width(), 600);
  std::set<QRgb> colors;
  for (int x = 0; x < picture.width(); x += 7)
    for (int y = 0; y < picture.height(); y += 7) colors.insert(picture.pixel(x, y));
  EXPECT_GT(colors.size(), 200u) << "the scene is not drawn";
  EXPECT_EQ(explored("--screenshot " + (folder / "start.png").string() + " --quit-after-s 1"), 0);
  EXPECT_FALSE(QImage(QString::fromStdString((folder / "start.png").string())).isNull()) << "in time, drawn or not";
  EXPECT_EQ(explored("--screenshot " + file + " --quit-after-s 1"), 2) << "no file is replaced";
  EXPECT_EQ(explored("--screenshot " + (folder / "wing.jpg").string()), 2);
  EXPECT_EQ(explored("--quit-after-s -1"), 2);
  EXPECT_EQ(explored("--quit-after-s 1"), 0);
}

}  // namespace window_test
}  // namespace palpa::explorer
