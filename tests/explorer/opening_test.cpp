// Opening by the window: drop, series, arrays, data beside, added data.
#include <gtest/gtest.h>

#include <QComboBox>
#include <QDialogButtonBox>
#include <QDropEvent>
#include <QFileDialog>
#include <QLineEdit>
#include <QMimeData>
#include <QPushButton>
#include <QTimer>
#include <QToolButton>
#include <QTreeWidget>
#include <QUrl>
#include <cmath>
#include <fstream>
#include <random>

#include "driver.h"
#include "explorer/part_chooser.h"
#include "palpa/file/write_volume.h"
#include "palpa/mode/modes.h"
#include "tests/reader/dicom_file.h"

namespace palpa::explorer {
namespace opening_test {

namespace fs = std::filesystem;

void write(const fs::path& file, const std::string& bytes) { std::ofstream(file, std::ios::binary) << bytes; }

/// A CT of a cube of 40 HU in air, of `slices` images.
void write_series(const fs::path& folder, int series, int slices, const std::string& description,
                  const Vec3& step_mm = {0, 0, 2.5}) {
  test::DicomSeries made;
  made.columns = made.rows = 12;
  made.uid = "1.2." + std::to_string(series);
  made.step_mm = step_mm;
  fs::create_directories(folder);
  for (int k = 0; k < slices; ++k) {
    test::DicomElements image = made.image(made.at_mm({0, 0, static_cast<double>(k)}), k);
    std::string pixels;
    for (int j = 0; j < 12; ++j)
      for (int i = 0; i < 12; ++i) {
        const bool is_inside = std::max({std::abs(i - 6), std::abs(j - 6)}) < 4 && k > 0 && k + 1 < slices;
        pixels += test::bytes_of(static_cast<std::uint16_t>(is_inside ? 1064 + (i + j) % 3 : 24 + (i * j) % 5));
      }
    image.set(0x7fe00010, "OW", pixels);
    image.set(0x00200011, "IS", std::to_string(series));
    image.set(0x0008103e, "LO", description);
    write(folder / (std::to_string(series) + "-" + std::to_string(k) + ".dcm"), made.file(image));
  }
}

/// Values over a grid of cubes of 1 mm with its middle at the origin.
template <class Value>
WrittenField field_of(const std::string& name, const GridGeometry& grid, int components, Value value) {
  return {name, "", VoxelType::float32, components, [=](std::int64_t k, double* to) {
            for (std::int64_t j = 0; j < grid.dims[1]; ++j)
              for (std::int64_t i = 0; i < grid.dims[0]; ++i) {
                const Vec3 v = value(grid.to_world({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)}));
                *to++ = v.x;
                if (components == 3) *to++ = v.y, *to++ = v.z;
              }
          }};
}
GridGeometry cubes(int along_x, int along_y, int along_z, double first_x_m = NAN) {
  GridGeometry grid{{along_x, along_y, along_z}, 1e-3 * Mat3::identity(), {}};
  grid.origin_m = -5e-4 * Vec3{along_x - 1.0, along_y - 1.0, along_z - 1.0};
  if (!std::isnan(first_x_m)) grid.origin_m.x = first_x_m;
  return grid;
}
void write_fields(const fs::path& file, const GridGeometry& grid, std::vector<WrittenField> fields) {
  write_volume({.grid = grid, .length_unit = "mm", .fields = std::move(fields)}, file, detail::Existing::replaced);
}
Vec3 swirl(const Vec3& p) { return {-p.y, p.x, 2e-3}; }

PartChooser* chooser_of(Driver& driver) {
  PartChooser* chooser = nullptr;
  Driver::wait_for([&] { return (chooser = driver.window().findChild<PartChooser*>()) != nullptr && chooser->isVisible(); });
  // Without a window manager the main window may stay active, and its shortcuts take the keys.
  if (chooser && QTest::qWaitForWindowExposed(chooser)) QApplication::setActiveWindow(chooser);
  return chooser;
}

QTreeWidgetItem* row_of(PartChooser& chooser, int row) { return chooser.findChild<QTreeWidget*>()->topLevelItem(row); }

void click_row(PartChooser& chooser, int row) {
  auto* const list = chooser.findChild<QTreeWidget*>();
  QTest::mouseClick(list->viewport(), Qt::LeftButton, {}, list->visualItemRect(list->topLevelItem(row)).center());
}

QPushButton* open_button(PartChooser& chooser) {
  for (QPushButton* button : chooser.findChildren<QPushButton*>())
    if (button->isDefault()) return button;
  return nullptr;
}

std::array<std::int64_t, 3> dims_of(Driver& driver, std::size_t volume = 0) {
  return grid_behind(*driver.window().document().scene().volumes().at(volume).volume.fields.front().field)->geometry.dims;
}

bool is_opened(Driver& driver, const std::function<void()>& act) {
  bool done = false;
  const auto told = QObject::connect(&driver.window().document(), &Document::opened_another, [&] { done = true; });
  act();
  const bool opened = Driver::wait_for([&] { return done; }, 60'000);
  QObject::disconnect(told);
  if (!opened) ADD_FAILURE() << "not opened; the window: " << driver.message().toStdString();
  return opened;
}

void drop(Driver& driver, const QList<QUrl>& urls) {
  QMimeData files;
  files.setUrls(urls);
  const QPoint at(300, 300);
  QDragEnterEvent enter(at, Qt::CopyAction, &files, Qt::LeftButton, Qt::NoModifier);
  QApplication::sendEvent(&driver.window(), &enter);
  QDropEvent event(at, Qt::CopyAction, &files, Qt::LeftButton, Qt::NoModifier);
  QApplication::sendEvent(&driver.window(), &event);
}
QUrl url_of(const fs::path& path) { return QUrl::fromLocalFile(QString::fromStdString(path.string())); }

/// Types a name into the file dialog that `act` opens, and presses its button.
void choose_file(const fs::path& file, const std::function<void()>& act) {
  QTimer typing;
  int ticks = 0;
  QObject::connect(&typing, &QTimer::timeout, [&] {
    auto* const dialog = qobject_cast<QFileDialog*>(QApplication::activeModalWidget());
    auto* const name = dialog ? dialog->findChild<QLineEdit*>("fileNameEdit") : nullptr;
    auto* const buttons = dialog ? dialog->findChild<QDialogButtonBox*>() : nullptr;
    if (!name || !buttons) return;
    if (++ticks > 100) return dialog->reject();
    const QString wanted = QString::fromStdString(file.string());
    // A row that is selected in the list, which is filled meanwhile, counts before the name.
    if (name->text() != wanted || dialog->selectedFiles() != QStringList(wanted)) {
      name->selectAll();
      QTest::keyClicks(name, wanted);
    } else {
      QTest::mouseClick(buttons->button(QDialogButtonBox::Open), Qt::LeftButton);
    }
  });
  typing.start(100);
  act();
}

/// A key of the window; without a window manager it is not active again once a dialog is closed.
void press_key(Driver& driver, Qt::Key key) {
  QApplication::setActiveWindow(&driver.window());
  driver.key(key, Qt::ControlModifier | Qt::ShiftModifier);
}

void look_at(QWidget& dialog, const std::string& name) {
  QTest::qWait(80);
  dialog.grab().save(QString::fromStdString(std::string(PALPA_SCREENSHOTS) + "/" + name + ".png"));
}

TEST(ExplorerOpening, AFolderOfTwoSeriesAsksForOneByItsWordsAndImages) {
  const fs::path folder = fresh_folder("two-series");
  write_series(folder, 201, 5, "DOE JANE head bone");
  write_series(folder, 202, 9, "localizer");
  Driver driver;
  driver.window().open(folder);
  PartChooser* chooser = chooser_of(driver);
  ASSERT_TRUE(chooser);
  EXPECT_EQ(row_of(*chooser, 0)->text(0), "CT 201 head bone");
  EXPECT_EQ(row_of(*chooser, 0)->text(1), "5");
  EXPECT_TRUE(row_of(*chooser, 1)->isSelected()) << "the largest";
  look_at(*chooser, "choose-series");
  ASSERT_TRUE(is_opened(driver, [&] {
    QTest::keyClick(chooser->findChild<QTreeWidget*>(), Qt::Key_Up);
    QTest::keyClick(chooser->findChild<QTreeWidget*>(), Qt::Key_Return);
  }));
  EXPECT_EQ(dims_of(driver)[2], 5);
  // The other one, by the menu's key and the mouse.
  press_key(driver, Qt::Key_C);
  chooser = chooser_of(driver);
  ASSERT_TRUE(chooser);
  ASSERT_TRUE(is_opened(driver, [&] {
    click_row(*chooser, 1);
    QTest::mouseClick(open_button(*chooser), Qt::LeftButton);
  }));
  EXPECT_EQ(dims_of(driver)[2], 9);
  EXPECT_NE(driver.window().document().text().find("series = \"1.2.202\""), std::string::npos);
}

TEST(ExplorerOpening, AFolderIsChosenWithTheMouse) {
  const fs::path folder = fresh_folder("one-series");
  write_series(folder, 1, 5, "head");
  Driver driver;
  auto* const button = driver.window().findChild<QPushButton*>("open_folder");
  ASSERT_TRUE(is_opened(driver, [&] { choose_file(folder, [&] { QTest::mouseClick(button, Qt::LeftButton); }); }));
  EXPECT_EQ(dims_of(driver)[2], 5);
}

TEST(ExplorerOpening, OneSliceBringsAllOfItsSeries) {
  const fs::path folder = fresh_folder("slices");
  write_series(folder, 1, 6, "head");
  write_series(folder, 2, 7, "head");
  Driver driver;
  ASSERT_TRUE(is_opened(driver, [&] { driver.window().open(folder / "1-2.dcm"); }));
  EXPECT_EQ(dims_of(driver)[2], 6);
  EXPECT_TRUE(driver.message().contains("is one of 6 slices")) << driver.message().toStdString();
  QList<QUrl> all;
  for (int k = 0; k < 7; ++k) all << url_of(folder / ("2-" + std::to_string(k) + ".dcm"));
  ASSERT_TRUE(is_opened(driver, [&] { drop(driver, all); }));
  EXPECT_EQ(dims_of(driver)[2], 7);
  // Alone in its folder it is opened alone.
  const fs::path alone = fresh_folder("slice") / "1.dcm";
  fs::copy(folder / "1-2.dcm", alone);
  ASSERT_TRUE(is_opened(driver, [&] { driver.window().open(alone); }));
  EXPECT_EQ(dims_of(driver)[2], 1);
}

TEST(ExplorerOpening, ATiltedSeriesSaysGantryTilt) {
  const fs::path folder = fresh_folder("tilted");
  write_series(folder, 1, 6, "head", {0, 2.5 * std::tan(18.5 * M_PI / 180.0), 2.5});
  Driver driver;
  ASSERT_TRUE(is_opened(driver, [&] { driver.window().open(folder); }));
  EXPECT_TRUE(driver.message().contains("gantry tilt of 18.5°")) << driver.message().toStdString();
}

TEST(ExplorerOpening, ThreeArraysBecomeOneVector) {
  const fs::path file = fresh_folder("arrays") / "flow.vti";
  const GridGeometry grid = cubes(12, 12, 8);
  std::vector<WrittenField> fields;
  fields.push_back(field_of("pressure", grid, 1, [](const Vec3& p) { return Vec3{1e3 * norm(p), 0, 0}; }));
  for (const int c : {0, 1, 2})
    fields.push_back(field_of(std::string("part ") + "abc"[c], grid, 1, [c](const Vec3& p) {
      const Vec3 v = swirl(p);
      return Vec3{c == 0 ? v.x : c == 1 ? v.y : v.z, 0, 0};
    }));
  write_fields(file, grid, fields);
  Driver driver;
  ASSERT_TRUE(is_opened(driver, [&] { driver.window().open(file); }));
  press_key(driver, Qt::Key_C);
  PartChooser* const chooser = chooser_of(driver);
  ASSERT_TRUE(chooser);
  EXPECT_EQ(chooser->findChild<QTreeWidget*>()->topLevelItemCount(), 4);
  for (const int c : {0, 1, 2}) {
    EXPECT_EQ(open_button(*chooser)->isEnabled(), c == 0) << "one or two components are no vector";
    auto* const box = chooser->findChild<QComboBox*>(QString("component_") + "xyz"[c]);
    ASSERT_TRUE(box);
    box->setFocus();
    for (int n = 0; n < 2 + c; ++n) QTest::keyClick(box, Qt::Key_Down);
  }
  auto* const name = chooser->findChild<QLineEdit*>("vector_name");
  name->selectAll();
  QTest::keyClicks(name, "my wind");
  look_at(*chooser, "choose-arrays");
  ASSERT_TRUE(is_opened(driver, [&] { QTest::mouseClick(open_button(*chooser), Qt::LeftButton); }));
  const Scene& scene = driver.window().document().scene();
  const Field& wind = *scene.field({"flow.my_wind"}).field;
  ASSERT_EQ(wind.components(), 3);
  EXPECT_LT(distance(wind.vector({2e-3, 1e-3, 0}).value, swirl({2e-3, 1e-3, 0})), 1e-6);
  EXPECT_NE(driver.window().document().text().find("arrays = ["), std::string::npos);
}

TEST(ExplorerOpening, AnArrayOfAnotherShapeIsChosenByADoubleClick) {
  application();
  const FileContents contents{.format = "hdf5", .alternatives = {{"/one/p", "2 × 3 × 4", 24}, {"/two", "9 × 9 × 9", 729}}};
  PartChooser chooser(contents, {.paths = {"/data/a.h5"}});
  chooser.show();
  ASSERT_TRUE(QTest::qWaitForWindowExposed(&chooser));
  EXPECT_TRUE(row_of(chooser, 1)->isSelected()) << "the largest";
  auto* const list = chooser.findChild<QTreeWidget*>();
  const QPoint first = list->visualItemRect(row_of(chooser, 0)).center();
  QTest::mouseClick(list->viewport(), Qt::LeftButton, {}, first);
  QTest::mouseDClick(list->viewport(), Qt::LeftButton, {}, first);
  EXPECT_EQ(chooser.result(), QDialog::Accepted);
  EXPECT_EQ(chooser.chosen().paths.front(), fs::path("/data/a.h5:/one/p"));
}

TEST(ExplorerOpening, BlocksThatAreDroppedTogetherAreOneVolume) {
  const fs::path folder = fresh_folder("blocks");
  QList<QUrl> urls;
  for (const int block : {0, 1}) {
    const GridGeometry grid = cubes(8, 10, 10, 7e-3 * block);
    const fs::path file = folder / ("block_" + std::to_string(block) + ".vti");
    write_fields(file, grid, {field_of("p", grid, 1, [](const Vec3& p) {
                   return Vec3{norm(p - Vec3{7e-3, 0, 0}) < 3e-3 ? 100.0 + 1e3 * p.x : 1e3 * p.y, 0, 0};
                 })});
    urls << url_of(file);
  }
  Driver driver;
  ASSERT_TRUE(is_opened(driver, [&] { drop(driver, urls); })) << driver.message().toStdString();
  const Scene& scene = driver.window().document().scene();
  ASSERT_EQ(scene.volumes().size(), 1u);
  const Box box = scene.volumes().front().volume.bounds_m();
  EXPECT_NEAR(box.size_m().x, 14e-3, 2e-3) << "both blocks";
  EXPECT_NE(driver.window().document().text().find("block_1.vti"), std::string::npos);
}

TEST(ExplorerOpening, AMagnitudeBesideAVelocityIsOfferedAndUsed) {
  const fs::path folder = fresh_folder("beside");
  const GridGeometry grid = cubes(28, 28, 28);
  const auto is_vessel = [](const Vec3& p) { return std::hypot(p.x, p.y) < 5e-3; };
  std::mt19937 random(7);
  std::uniform_real_distribution<double> noise(-1.5, 1.5);
  write_fields(folder / "aorta_velocity.nrrd", grid, {field_of("velocity", grid, 3, [&](const Vec3& p) {
                 const Vec3 any{noise(random), noise(random), noise(random)};
                 return is_vessel(p) ? Vec3{0.05, 0, 1} + 0.02 * any : any;
               })});
  write_fields(folder / "aorta_magnitude.nrrd", grid, {field_of("magnitude", grid, 1, [&](const Vec3& p) {
                 return Vec3{(is_vessel(p) ? 200.0 : 10.0) + noise(random) + 2.0, 0, 0};
               })});
  write_fields(folder / "head_magnitude.nrrd", grid, {field_of("m", grid, 1, [](const Vec3& p) { return p; })});
  EXPECT_EQ(find_beside(folder / "aorta_velocity.nrrd"), folder / "aorta_magnitude.nrrd");
  EXPECT_EQ(find_beside(folder / "aorta_magnitude.nrrd"), fs::path());
  Driver driver;
  ASSERT_TRUE(is_opened(driver, [&] { driver.window().open(folder / "aorta_velocity.nrrd"); }));
  EXPECT_TRUE(driver.message().contains("aorta_magnitude.nrrd lies beside it")) << driver.message().toStdString();
  driver.look("beside-offered");
  QToolButton* use = nullptr;
  for (QToolButton* button : driver.window().findChildren<QToolButton*>())
    if (button->isVisible() && button->text() == "Use it") use = button;
  ASSERT_TRUE(use);
  ASSERT_TRUE(is_opened(driver, [&] { QTest::mouseClick(use, Qt::LeftButton); }));
  const Scene& scene = driver.window().document().scene();
  ASSERT_EQ(scene.volumes().size(), 2u) << driver.window().document().text();
  const bool is_masked = std::any_of(scene.modes().begin(), scene.modes().end(), [](const SceneMode& mode) {
    return std::any_of(mode.masks.begin(), mode.masks.end(),
                       [](const Mask& mask) { return mask.of.name.starts_with("aorta_magnitude"); });
  });
  EXPECT_TRUE(is_masked) << driver.window().document().text();
  ASSERT_TRUE(Driver::wait_for([&] { return !driver.window().is_busy(); }, 60'000));
  driver.look("beside-used");
}

TEST(ExplorerOpening, AddedDataKeepTheirGridAndAreFeltWhereTheyAreSeen) {
  const fs::path folder = fresh_folder("added");
  const GridGeometry grid = cubes(20, 16, 12);
  const auto ball = [](const Vec3& p) { return Vec3{100.0 / (1.0 + std::exp(4e3 * (norm(p) - 5e-3))) + 1e2 * p.x, 0, 0}; };
  write_fields(folder / "head.vti", grid, {field_of("ball", grid, 1, ball)});
  Driver driver;
  ASSERT_TRUE(driver.open(embedded("head_phantom.toml")));
  const Scene before = driver.window().document().scene();
  const auto add = [&] {
    choose_file(folder / "head.vti", [&] { press_key(driver, Qt::Key_A); });
    return Driver::wait_for([&] { return !(driver.window().document().scene() == before); }, 60'000);
  };
  ASSERT_TRUE(add()) << driver.message().toStdString();
  const Scene& scene = driver.window().document().scene();
  ASSERT_EQ(scene.volumes().size(), before.volumes().size() + 1);
  EXPECT_EQ(dims_of(driver, before.volumes().size()), grid.dims);
  EXPECT_NE(scene.volumes().back().name, before.volumes().front().name) << "both files are called head";
  EXPECT_GT(scene.modes().size(), before.modes().size());
  EXPECT_EQ(driver.window().instruments().modes().size(), scene.modes().size()) << "the curves lack the added modes";
  const auto& shown = *driver.window().findChild<QComboBox*>("slice_field");
  EXPECT_GE(shown.findData(QString::fromStdString(scene.volumes().back().name)), 0) << "the slices cannot show the added data";
  // A layer of the new data is drawn at the level at which they are felt.
  const std::string& added = scene.volumes().back().name;
  int linked = 0, of_head = 0;
  for (const ViewLayer& layer : scene.layers) {
    of_head += layer.field.name == before.volumes().front().name;
    for (const SceneMode& mode : scene.modes()) {
      const auto* surface = mode.mode.as<SurfaceAndFriction>();
      if (!surface || !layer.field.name.starts_with(added) || surface->field.name != layer.field.name) continue;
      for (const auto& level : surface->levels) linked += layer.level == level.value;
    }
  }
  EXPECT_EQ(of_head, 2) << "skin and bone are seen as before";
  EXPECT_GT(linked, 0) << driver.window().document().text();
  ASSERT_TRUE(Driver::wait_for([&] { return !driver.window().is_busy(); }, 60'000));
  EXPECT_TRUE(driver.window().touch().is_felt());
  driver.look("data-added");
  // The saved scene is read again.
  const fs::path saved = folder / "both.toml";
  driver.window().document().save(saved);
  EXPECT_EQ(load_scene(saved).scene.volumes().size(), 2u);
  QApplication::setActiveWindow(&driver.window());
  driver.key(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_TRUE(driver.window().document().scene() == before);
}

TEST(ExplorerOpening, WrongInputIsSaidAndLeavesTheSceneAsItIs) {
  const fs::path folder = fresh_folder("wrong");
  write(folder / "words.nrrd", "no data");
  write(folder / "1.dcm", std::string(300, 'x'));
  Driver driver;
  ASSERT_TRUE(driver.open(embedded("wing_phantom.toml")));
  const Scene before = driver.window().document().scene();
  const auto says = [&](const char* words) {
    const bool said = Driver::wait_for([&] { return driver.message().contains(words); });
    EXPECT_TRUE(said) << words << ": " << driver.message().toStdString();
    EXPECT_TRUE(driver.window().document().scene() == before);
  };
  drop(driver, {QUrl("http://example.org/a.nrrd")});
  says("Only files and folders of this machine");
  drop(driver, {url_of(folder / "words.nrrd"), url_of(folder / "1.dcm")});
  says("words.nrrd: ");
  drop(driver, {url_of(folder / "1.dcm")});
  says("1.dcm: ");
  drop(driver, {url_of(folder / "lost.vtm")});
  says("there is no such file");
  choose_file(embedded("head_phantom.toml"), [&] { press_key(driver, Qt::Key_A); });
  says("is a scene or a trace, not data");
  press_key(driver, Qt::Key_C);
  says("names its series and arrays itself");
}

}  // namespace opening_test
}  // namespace palpa::explorer
