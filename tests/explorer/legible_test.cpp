// Legibility of the window: messages, slices, legends, rows, its pictures.
#include <gtest/gtest.h>
#include <qwt_plot.h>
#include <qwt_scale_div.h>

#include <QClipboard>
#include <QComboBox>
#include <QGroupBox>
#include <QLabel>
#include <QLineEdit>
#include <QMessageBox>
#include <QProcess>
#include <QPushButton>
#include <QRegularExpression>
#include <QTableWidget>
#include <QTextBrowser>
#include <QTimer>
#include <QToolButton>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <set>

#include "driver.h"
#include "explorer/help_sheet.h"
#include "explorer/linked_levels.h"
#include "explorer/live_plot.h"
#include "explorer/paint.h"
#include "palpa/file/write_volume.h"
#include "palpa/version.h"

namespace palpa::explorer {
namespace legible_test {

namespace fs = std::filesystem;

QRect place_of(const QWidget& widget) { return {widget.mapToGlobal(QPoint(0, 0)), widget.size()}; }

/// Three balls of labels 1, 2 and 7 in a background of 0, with names as 3D Slicer writes them.
fs::path write_labels() {
  constexpr int n = 24;
  std::string bytes;
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const auto in = [&](int x, int radius) { return std::hypot(i - x, j - 12.0, k - 12.0) < radius; };
        bytes += static_cast<char>(in(6, 4) ? 1 : in(13, 3) ? 2 : in(19, 3) ? 7 : 0);
      }
  std::string header =
      "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 24 24 24\n"
      "space directions: (2,0,0) (0,2,0) (0,0,2)\nspace origin: (0,0,0)\nspace units: \"mm\" \"mm\" \"mm\"\n"
      "encoding: raw\n";
  int number = 0;
  for (const auto& [value, name] : {std::pair(1, "liver"), std::pair(2, "tumour"), std::pair(7, "left kidney")}) {
    const std::string key = "Segment" + std::to_string(number++) + "_";
    header += key + "LabelValue:=" + std::to_string(value) + "\n" + key + "Name:=" + name + "\n";
  }
  const fs::path file = fresh_folder("labels") / "organs.seg.nrrd";
  std::ofstream(file, std::ios::binary) << header << "\n" << bytes;
  return file;
}

TEST(ExplorerMessages, CoverNeitherDataNorControlsAndFoldTheirLines) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  const QRect before = place_of(driver.window().views());
  driver.key(Qt::Key_R, Qt::NoModifier);
  auto& bar = *driver.window().findChild<MessageBar*>();
  ASSERT_TRUE(bar.isVisible());
  Driver::live(50);
  EXPECT_EQ(place_of(driver.window().views()), before);
  EXPECT_FALSE(place_of(bar).intersects(before)) << "it covers the views, their boxes or the legend";
  EXPECT_TRUE(place_of(driver.window()).contains(place_of(bar)));
  for (QToolButton* button : driver.window().findChildren<QToolButton*>())
    EXPECT_TRUE(bar.isAncestorOf(button) || !button->isVisible() || !place_of(bar).intersects(place_of(*button)))
        << button->text().toStdString();

  const QString first =
      "a scene: volume 'fin': has no affine grid: resampled to 193 x 109 x 199 voxels; crop_m makes a part finer";
  bar.say(first + "\nsecond remark\nthird remark", true);
  Driver::live(20);
  EXPECT_EQ(place_of(driver.window().views()), before);
  auto& more = *bar.findChild<QToolButton*>("more_message");
  EXPECT_TRUE(more.isVisible());
  EXPECT_EQ(more.text(), "2 more");
  EXPECT_FALSE(bar.findChild<QLabel*>("message")->text().contains("second"));
  driver.look("message-folded");
  QTest::mouseClick(&more, Qt::LeftButton);
  auto* whole = bar.findChild<QLabel*>("whole_message");
  ASSERT_TRUE(whole && whole->isVisible());
  EXPECT_TRUE(whole->text().contains("third remark"));
  whole->close();
  // On the full screen there is no tool bar.
  driver.key(Qt::Key_F11);
  EXPECT_TRUE(bar.isVisible());
  Driver::live(50);
  for (QComboBox* box : driver.window().views().findChildren<QComboBox*>())
    EXPECT_FALSE(place_of(bar).intersects(place_of(*box))) << box->objectName().toStdString();
  driver.key(Qt::Key_F11);
  Driver::live(50);
  EXPECT_FALSE(place_of(bar).intersects(place_of(driver.window().views())));
  driver.key(Qt::Key_R, Qt::NoModifier);
}

TEST(ExplorerSlices, OfAFlowShowItsSpeedAndSayThatTheFileHasNoUnit) {
  const fs::path file = fresh_folder("unnamed") / "flow.vti";
  GridGeometry grid{{24, 24, 24}, 1e-3 * Mat3::identity(), {-0.0115, -0.0115, -0.0115}};
  const WrittenField vectors{"vectors", "", VoxelType::float32, 3, [=](std::int64_t k, double* to) {
                               for (std::int64_t j = 0; j < 24; ++j)
                                 for (std::int64_t i = 0; i < 24; ++i) {
                                   const Vec3 p = grid.to_world({1.0 * static_cast<double>(i), 1.0 * static_cast<double>(j),
                                                                 1.0 * static_cast<double>(k)});
                                   const double fall = std::exp(-1e5 * (p.x * p.x + p.y * p.y));
                                   *to++ = -100.0 * p.y * fall, *to++ = 100.0 * p.x * fall, *to++ = 0.1;
                                 }
                             }};
  write_volume({.grid = grid, .length_unit = "mm", .fields = {vectors}}, file, detail::Existing::replaced);
  Driver driver;
  ASSERT_TRUE(driver.open(file)) << driver.message().toStdString();
  ASSERT_TRUE(driver.is_done());
  const SliceLook& look = driver.window().views().look();
  ASSERT_TRUE(look.field);
  EXPECT_EQ(look.field->components(), 3) << look.name << ": not the speed";
  EXPECT_EQ(look.words, "speed, no unit in the file");
  EXPECT_EQ(driver.window().findChild<QComboBox*>("slice_field")->currentText(), "speed");
  const auto& bars = driver.view().drawing().signs.bars;
  ASSERT_FALSE(bars.empty());
  EXPECT_EQ(bars.front().title, "speed, no unit in the file");
  driver.look("flow-without-unit");
}

TEST(ExplorerSlices, OfLabelsHaveTheColoursOfTheirSurfacesAndTheNamesOfTheFile) {
  Driver driver;
  ASSERT_TRUE(driver.open(write_labels())) << driver.message().toStdString();
  ASSERT_TRUE(driver.is_done());
  const SliceLook& look = driver.window().views().look();
  std::set<std::string> names;
  for (const SeenLabel& label : look.labels) names.insert(label.name);
  EXPECT_EQ(names, (std::set<std::string>{"left_kidney", "liver", "tumour"}));
  SliceView* axial = nullptr;
  for (SliceView* one : driver.window().findChildren<SliceView*>())
    if (one->title() == "Axial") axial = one;
  ASSERT_TRUE(axial);
  Driver::live(200);  // the fine slice
  const QImage picture = axial->grab().toImage();
  for (const SeenLabel& label : look.labels) {
    int pixels = 0;
    for (int x = 0; x < picture.width(); ++x)
      for (int y = 0; y < picture.height(); ++y) pixels += picture.pixel(x, y) == to_qt(label.color).rgb();
    EXPECT_GT(pixels, 100) << label.name << " is not seen in its colour";
    const auto& legend = driver.view().drawing().signs.legend;
    EXPECT_TRUE(std::any_of(legend.begin(), legend.end(), [&](const auto& entry) { return entry.words == label.name; }))
        << label.name;
  }
  // Beside it, within the map: no third label between two.
  const detail::View& view = axial->view();
  const QPoint at = on_screen(view, look.map.to_hand({0.012, 0.024, 0.024})).toPoint();
  driver.move(*axial, at - QPoint(3, 0), at, Qt::NoButton, 2);
  EXPECT_TRUE(driver.window().findChild<QLabel*>("pointed")->text().contains("liver (1)"))
      << driver.window().findChild<QLabel*>("pointed")->text().toStdString();
  QTest::mouseDClick(axial, Qt::LeftButton, {}, axial->rect().center());
  Driver::live(400);
  driver.look("labels-large");
}

TEST(ExplorerRows, FoldedOnesLeaveNoGapAboveMore) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  auto& form = *driver.window().findChild<QGroupBox*>("mode_surface")->findChild<ParameterForm*>();
  auto& more = *form.findChild<QToolButton*>("more");
  const auto gap_px = [&] {
    int bottom = 0;
    for (QWidget* one : form.findChildren<QWidget*>())
      if (one->isVisible() && one != &more) bottom = std::max(bottom, one->mapTo(&form, QPoint(0, one->height())).y());
    return more.y() - bottom;
  };
  Driver::live(30);
  EXPECT_LE(gap_px(), 8);
  EXPECT_GE(gap_px(), 0);
  QTest::mouseClick(&more, Qt::LeftButton);
  Driver::live(30);
  EXPECT_LE(gap_px(), 8);
  QTest::mouseClick(&more, Qt::LeftButton);
  Driver::live(30);
  EXPECT_LE(gap_px(), 8);
  driver.look("rows-folded");
}

/// Clicks the first "By value …" of a panel; true when the editor shows the strength.
bool opens_first_function(QWidget& panel, FunctionEditor& editor) {
  for (QPushButton* one : panel.findChildren<QPushButton*>()) {
    if (!one->isVisible() || !one->text().startsWith("By value")) continue;
    QTest::mouseClick(one, Qt::LeftButton);
    return Driver::wait_for([&] { return editor.isVisible() && editor.shown().strength.has_value(); });
  }
  return false;
}

TEST(ExplorerRows, AFunctionIsOnlyLookedAtUntilAValueIsEdited) {
  Driver driver;
  ASSERT_TRUE(driver.open(embedded("flow_phantom.toml")));
  const Scene before = driver.window().document().scene();
  FunctionEditor& editor = *driver.window().findChild<FunctionEditor*>();
  ASSERT_TRUE(opens_first_function(*driver.window().findChild<FeelPanel*>(), editor)) << driver.message().toStdString();
  EXPECT_TRUE(driver.window().document().scene() == before) << "changed by looking at it";
  EXPECT_TRUE(driver.window().document().undo().isClean());
  ASSERT_TRUE(driver.is_done());
  QTableWidget& table = *editor.findChild<QTableWidget*>("function_table");
  table.item(1, 1)->setText("0.4");
  EXPECT_FALSE(driver.window().document().scene() == before);
  EXPECT_EQ(editor.shown().strength->points()[1].result, 0.4);
  driver.key(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_TRUE(driver.window().document().scene() == before);
}

TEST(ExplorerRows, AFunctionOfALevelIsNotOfTheFieldThatIsConstantThere) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  const Scene before = driver.window().document().scene();
  auto& form = *driver.window().findChild<QGroupBox*>("mode_surface")->findChild<ParameterForm*>();
  FunctionEditor& editor = *driver.window().findChild<FunctionEditor*>();
  ASSERT_TRUE(opens_first_function(form, editor)) << driver.message().toStdString();
  EXPECT_EQ(editor.shown().field, "gradient_magnitude(head)");
  EXPECT_EQ(editor.shown().unit, "HU/m");
  EXPECT_GT(editor.shown().high, editor.shown().low);
  EXPECT_TRUE(driver.window().document().scene() == before) << "changed by looking at it";
  ASSERT_TRUE(driver.is_done());
  editor.findChild<QTableWidget*>("function_table")->item(0, 1)->setText("0.4");
  const Strength strength = felt_levels(driver.window().document().scene()).empty() ? Strength() : [&] {
    for (const ParameterRow& row :
         rows_of([&](ParameterVisitor& v) { Mode(driver.window().document().scene().modes()[0].mode).visit(v); }))
      if (const auto* one = std::get_if<Strength>(&row.value); one && !one->is_constant()) return *one;
    return Strength();
  }();
  EXPECT_EQ(strength.of.name, "gradient_magnitude(head)") << driver.message().toStdString();
  driver.look("function-of-a-level");
}

TEST(ExplorerRows, ALevelTakesANameWithASpace) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  auto& form = *driver.window().findChild<QGroupBox*>("mode_surface")->findChild<ParameterForm*>();
  QTest::mouseClick(form.findChild<QToolButton*>("more"), Qt::LeftButton);
  QLineEdit* name = nullptr;
  for (QLineEdit* one : form.findChildren<QLineEdit*>())
    if (one->text() == "bone") name = one;
  ASSERT_TRUE(name);
  name->setFocus();
  name->selectAll();
  QApplication::clipboard()->setText("inner table");  // the space bar turns the force off with any focus
  QTest::keyClick(name, Qt::Key_V, Qt::ControlModifier);
  QTest::keyClick(name, Qt::Key_Return);
  EXPECT_EQ(felt_levels(driver.window().document().scene()).at(1).name, "inner_table") << driver.message().toStdString();
}

TEST(ExplorerPictures, HaveNoTransparentPixels) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  ASSERT_TRUE(driver.is_done());
  for (const QSize& size : {QSize(), QSize(900, 700)}) EXPECT_FALSE(driver.view().picture(size).hasAlphaChannel());
}

TEST(ExplorerPictures, AFilmOfTheWindowShowsItWhole) {
  const fs::path folder = fresh_folder("window-film");
  const std::string settings = (folder / "palpa.ini").string();
  QSettings(QString::fromStdString(settings), QSettings::IniFormat)
      .setValue("pictures", QString::fromStdString(folder.string()));
  Driver driver({.settings_file = settings});
  ASSERT_TRUE(driver.open(small_head()));
  driver.key(Qt::Key_T, Qt::ControlModifier);
  Player& player = *driver.window().findChild<Player*>();
  ASSERT_TRUE(Driver::wait_for([&] { return player.has_trace(); }, 60'000));
  ASSERT_TRUE(driver.is_done());
  driver.key(Qt::Key_F, Qt::ControlModifier | Qt::ShiftModifier);
  ASSERT_TRUE(Driver::wait_for([&] { return driver.message().contains("Filming"); })) << driver.message().toStdString();
  const QString into = driver.message().section(" into ", 1);
  driver.key(Qt::Key_F, Qt::ControlModifier | Qt::ShiftModifier);
  const QImage first(into + "/00000.png");
  EXPECT_EQ(first.size(), driver.window().size()) << into.toStdString();
}

TEST(ExplorerSmall, NumbersOfAPlotDoNotMeet) {
  LivePlot plot("force", "time / s", "force / N");
  plot.set_y_range(0.0, 0.7);
  plot.show();
  for (const int height : {120, 140, 200, 300, 600}) {
    plot.resize(400, height);
    Driver::live(20);
    plot.draw();
    const QwtPlot& drawn = *plot.findChild<QwtPlot*>();
    const QList<double> numbers = drawn.axisScaleDiv(QwtPlot::yLeft).ticks(QwtScaleDiv::MajorTick);
    ASSERT_GE(numbers.size(), 2) << height;
    const double apart_px = std::abs(drawn.transform(QwtPlot::yLeft, numbers[0]) - drawn.transform(QwtPlot::yLeft, numbers[1]));
    EXPECT_GE(apart_px, QFontMetrics(drawn.axisFont(QwtPlot::yLeft)).ascent()) << height;
  }
}

TEST(ExplorerForce, IsSaidToBeOffBesideTheLegend) {
  Driver driver;
  driver.window().resize(1001, 760);
  ASSERT_TRUE(driver.open(embedded("wing_phantom.toml")));
  ASSERT_TRUE(driver.is_done());
  driver.key(Qt::Key_Space);
  const auto box = [&]() -> std::optional<QRectF> {
    for (const PlacedText& text : driver.view().texts())
      if (text.words.contains("press Space")) return text.box;
    return {};
  };
  ASSERT_TRUE(Driver::wait_for([&] { return box().has_value(); }));
  const auto& signs = driver.view().drawing().signs;
  const double legend_px = width_of_explanations(driver.view().font(), signs.legend, signs.bars);
  ASSERT_GT(legend_px, 0.0);
  EXPECT_LE(box()->right(), driver.view().width() - legend_px);
  EXPECT_GE(box()->left(), 0.0);
  driver.look("force-off-beside-legend");
}

TEST(ExplorerForce, IsANumberAtTheHandWhileThereIsOne) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  ASSERT_TRUE(driver.is_done());
  const auto number = [&]() -> std::optional<PlacedText> {
    for (const PlacedText& text : driver.view().texts())
      if (QRegularExpression("^[0-9.]+ N$").match(text.words).hasMatch()) return text;
    return {};
  };
  EXPECT_FALSE(number()) << "nothing is felt yet";
  const auto at = driver.surface_px();
  ASSERT_TRUE(at);
  driver.press(driver.view(), *at);
  ASSERT_TRUE(driver.is_let_out());
  driver.wheel(driver.view(), *at, 4, Qt::LeftButton);
  ASSERT_TRUE(Driver::wait_for([&] { return driver.force_n() > 0.1 && number(); }));
  ASSERT_TRUE(driver.hand_rests());
  ASSERT_TRUE(Driver::wait_for([&] {
    const auto shown = number();
    return shown && std::abs(shown->words.section(' ', 0, 0).toDouble() - driver.force_n()) <= 0.0051;
  })) << (number() ? number()->words.toStdString() : "none")
      << " for " << driver.force_n();
  const QPointF ball = on_screen(driver.view().view(), driver.window().touch().moment().proxy_m);
  const QPointF middle = number()->box.center();
  EXPECT_LT(std::hypot(middle.x() - ball.x(), middle.y() - ball.y()), 90.0);
  EXPECT_FALSE(number()->box.contains(ball)) << "on the ball";
  driver.look("force-at-hand");
  driver.view().set_dark(true);
  driver.look("force-at-hand-dark");
  driver.view().set_dark(false);
  const Vec3 from = driver.view().view().towards, up = driver.view().view().up;
  driver.view().look_from(-from, up);
  EXPECT_TRUE(Driver::wait_for([&] { return !number(); })) << "the touched side is turned away";
  driver.view().look_from(from, up);
  // Without a force there is none: a busy machine may draw a view for longer than the watchdog allows, which ends the contact.
  EXPECT_TRUE(Driver::wait_for([&] { return number() || driver.force_n() == 0.0; }));
  driver.release(driver.view(), *at);
  ASSERT_TRUE(driver.hand_rests());
  driver.press(driver.view(), *at);
  driver.wheel(driver.view(), *at, 4, Qt::LeftButton);
  EXPECT_TRUE(Driver::wait_for([&] { return driver.force_n() > 0.1 && number(); }));
  driver.key(Qt::Key_Space);
  EXPECT_TRUE(Driver::wait_for([&] { return !number(); })) << "the force is off";
  driver.release(driver.view(), *at);
}

TEST(ExplorerHelp, PagesShowTheDocumentation) {
  Driver driver;
  QTest::keyClick(&driver.window(), Qt::Key_F1, Qt::ShiftModifier);
  auto* const pages = driver.window().findChild<Pages*>();
  ASSERT_TRUE(pages) << driver.message().toStdString();
  auto& text = *pages->findChild<QTextBrowser*>();
  EXPECT_TRUE(text.toPlainText().startsWith("The explorer")) << text.toPlainText().left(100).toStdString();
  QTest::qWait(50);
  pages->grab().save(QString(PALPA_SCREENSHOTS) + "/pages.png");
  Q_EMIT text.anchorClicked(QUrl("trace.md"));
  EXPECT_TRUE(text.source().path().endsWith("trace.md"));
  QTest::mouseClick(pages->findChild<QPushButton*>("back"), Qt::LeftButton);
  EXPECT_TRUE(text.source().path().endsWith("explorer.md"));
  pages->close();
}

TEST(ExplorerHelp, PagesAreFoundWhereTheyAreInstalled) {
  const fs::path prefix = fresh_folder("prefix"), scenes = prefix / "share/palpa/scenes",
                 docs = prefix / "share/doc/palpa/docs";
  fs::create_directories(scenes);
  const char* const before = std::getenv("PALPA_SCENES");
  const std::string kept = before ? before : "";
  ::setenv("PALPA_SCENES", scenes.c_str(), 1);
  EXPECT_TRUE(pages_folder().empty());
  {
    Driver driver;
    QTest::keyClick(&driver.window(), Qt::Key_F1, Qt::ShiftModifier);
    EXPECT_TRUE(driver.message().contains("libpalpa-dev")) << driver.message().toStdString();
  }
  fs::create_directories(docs);
  std::ofstream(docs / "explorer.md") << "# The explorer\n";
  EXPECT_EQ(pages_folder(), docs);
  before ? ::setenv("PALPA_SCENES", kept.c_str(), 1) : ::unsetenv("PALPA_SCENES");
}

TEST(ExplorerHelp, AboutSaysTheVersionAndTheLicence) {
  Driver driver;
  QString said;
  const std::function<void()> close = [&] {
    auto* box = qobject_cast<QMessageBox*>(QApplication::activeModalWidget());
    if (!box) return QTimer::singleShot(50, close);
    said = box->text();
    QTest::mouseClick(box->button(QMessageBox::Ok), Qt::LeftButton);
  };
  QTimer::singleShot(50, close);
  for (QAction* one : driver.window().actions())
    if (one->text().contains("About")) one->trigger();
  EXPECT_TRUE(said.contains(version)) << said.toStdString();
  EXPECT_TRUE(said.contains("Apache")) << said.toStdString();
}

/// One of two blocks of a grid of 8 x 8 x 15 points along z, as a structured grid.
void write_block(const fs::path& file, int first, int last) {
  std::string points, values;
  for (int k = first; k <= last; ++k)
    for (int j = 0; j < 8; ++j)
      for (int i = 0; i < 8; ++i) {
        points += std::to_string(i) + " " + std::to_string(j) + " " + std::to_string(k) + "\n";
        values += std::to_string(i + 10 * (std::hypot(i - 4.0, j - 4.0, k - 7.0) < 3.0)) + "\n";
      }
  const std::string extent = "0 7 0 7 " + std::to_string(first) + " " + std::to_string(last);
  std::ofstream(file) << "<VTKFile type=\"StructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n<StructuredGrid "
                         "WholeExtent=\""
                      << extent << "\"><Piece Extent=\"" << extent
                      << "\"><PointData Scalars=\"heat\"><DataArray type=\"Float32\" Name=\"heat\" format=\"ascii\">\n"
                      << values
                      << "</DataArray></PointData><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" "
                         "format=\"ascii\">\n"
                      << points << "</DataArray></Points></Piece></StructuredGrid></VTKFile>\n";
}

TEST(ExplorerProgram, OpensBlocksOfOneGridAsOneVolume) {
  application();  // starts the display
  const fs::path folder = fresh_folder("blocks");
  write_block(folder / "A.vts", 0, 7);
  write_block(folder / "B.vts", 7, 14);
  Driver driver;
  bool is_open = false;
  QObject::connect(&driver.window().document(), &Document::opened_another, [&] { is_open = true; });
  driver.window().open_chosen(
      {QString::fromStdString((folder / "A.vts").string()), QString::fromStdString((folder / "B.vts").string())});
  ASSERT_TRUE(Driver::wait_for([&] { return is_open || driver.message().contains(".vts"); }, 30'000));
  ASSERT_TRUE(is_open) << driver.message().toStdString();
  const Scene& scene = driver.window().document().scene();
  ASSERT_EQ(scene.volumes().size(), 1u);
  EXPECT_NEAR(scene.volumes().front().volume.bounds_m().size_m().z, 14.0, 0.1);
  const char* bin = std::getenv("PALPA_BIN");
  const QString picture = QString::fromStdString((folder / "both.png").string());
  QProcess program;
  program.start(QString(bin ? bin : "") + "/palpa",
                {"explore", QString::fromStdString((folder / "A.vts").string()),
                 QString::fromStdString((folder / "B.vts").string()), "--screenshot", picture, "--quit-after-s", "60"});
  EXPECT_TRUE(
      Driver::wait_for([&] { return fs::exists(picture.toStdString()) || program.state() == QProcess::NotRunning; }, 60'000));
  EXPECT_EQ(program.state(), QProcess::Running) << program.readAllStandardError().toStdString();
  program.kill();
  program.waitForFinished();
}

}  // namespace legible_test
}  // namespace palpa::explorer
