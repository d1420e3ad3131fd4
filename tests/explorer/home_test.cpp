// A first user's ways through the window: progress, layouts, messages, recording, closing, pictures, simple panels.
#include <gtest/gtest.h>

#include <QCheckBox>
#include <QDialogButtonBox>
#include <QDockWidget>
#include <QFileDialog>
#include <QGroupBox>
#include <QLabel>
#include <QLineEdit>
#include <QMenu>
#include <QMenuBar>
#include <QMessageBox>
#include <QPushButton>
#include <QRegularExpression>
#include <QSpinBox>
#include <QStackedWidget>
#include <QTimer>
#include <QToolButton>
#include <algorithm>
#include <filesystem>

#include "driver.h"
#include "explorer/linked_levels.h"
#include "explorer/slice_view.h"

namespace palpa::explorer {
namespace home_test {

/// Does this in the dialogue that opens next.
void in_dialog(const std::function<void(QWidget&)>& act) {
  QTimer::singleShot(50, [act] {
    QWidget* const dialog = QApplication::activeModalWidget();
    if (!dialog) return in_dialog(act);
    act(*dialog);
  });
}

TEST(ExplorerHome, ReadingIsShownInTheMiddleAndCanBeCancelled) {
  Driver driver;
  driver.window().open(embedded("head_phantom.toml"));
  auto& reading = *driver.window().findChild<QFrame*>("reading");
  ASSERT_TRUE(reading.isVisible());
  Driver::live(30);
  EXPECT_NE(driver.window().findChild<QStackedWidget*>("pages")->currentIndex(), 0)
      << "the start page, as if nothing was asked";
  const QPoint middle = reading.mapTo(&driver.window(), reading.rect().center());
  EXPECT_LT(std::abs(middle.x() - driver.window().width() / 2), 20);
  driver.look("reading");
  QTest::mouseClick(reading.findChild<QToolButton*>("cancel_job"), Qt::LeftButton);
  EXPECT_FALSE(reading.isVisible());
  EXPECT_EQ(driver.window().findChild<QStackedWidget*>("pages")->currentIndex(), 0);
}

TEST(ExplorerHome, ADoubleClickMakesAViewLargeAndLTakesTheNextLayout) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  const QList<SliceView*> slices = driver.window().findChildren<SliceView*>();
  const QSize small = slices[0]->size();
  QTest::mouseDClick(slices[0], Qt::LeftButton, {}, slices[0]->rect().center());
  EXPECT_TRUE(Driver::wait_for([&] { return slices[0]->width() > 2 * small.width(); }, 2000));
  EXPECT_FALSE(driver.view().isVisible());
  driver.look("slice-large");
  QTest::mouseDClick(slices[0], Qt::LeftButton, {}, slices[0]->rect().center());
  EXPECT_TRUE(driver.view().isVisible());
  QTest::mouseDClick(&driver.view(), Qt::LeftButton, {}, {5, 5});
  EXPECT_FALSE(slices[0]->isVisible());
  QTest::mouseDClick(&driver.view(), Qt::LeftButton, {}, {5, 5});
  driver.key(Qt::Key_L);
  EXPECT_EQ(driver.window().views().layout_of_views(), SceneViews::Layout::slices_below);
  Driver::live(20);
  EXPECT_GT(slices[0]->mapTo(&driver.window(), QPoint()).y(), driver.view().mapTo(&driver.window(), QPoint()).y());
  Driver::live(400);
  driver.look("slices-below");
}

TEST(ExplorerHome, FullScreenShowsTheViewsAlone) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  driver.key(Qt::Key_F11);
  EXPECT_FALSE(driver.window().menuBar()->isVisible());
  for (QDockWidget* dock : driver.window().findChildren<QDockWidget*>()) EXPECT_FALSE(dock->isVisible());
  EXPECT_TRUE(driver.view().isVisible());
  driver.key(Qt::Key_F11);
  EXPECT_TRUE(driver.window().menuBar()->isVisible());
  EXPECT_TRUE(driver.window().findChild<QDockWidget*>("panel")->isVisible());
}

TEST(ExplorerHome, TheForceCurveComesBesideTheViewsOnTheFullScreen) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  driver.key(Qt::Key_F11);
  EXPECT_TRUE(driver.message().contains("I shows the force curve")) << driver.message().toStdString();
  ASSERT_FALSE(driver.window().instruments().isVisible());
  driver.key(Qt::Key_I);
  EXPECT_TRUE(driver.window().instruments().isVisible());
  EXPECT_FALSE(driver.window().menuBar()->isVisible());
  EXPECT_FALSE(driver.window().findChild<QDockWidget*>("panel")->isVisible());
  Driver::live(400);
  driver.look("full-screen-curve");
  driver.key(Qt::Key_I);
  EXPECT_FALSE(driver.window().instruments().isVisible());
  driver.key(Qt::Key_F11);
  EXPECT_TRUE(driver.window().instruments().isVisible());
}

TEST(ExplorerHome, TheHintComesWithEachSceneAndNothingOnIsSaid) {
  Driver driver;
  for (const std::filesystem::path& scene : {small_head(), small_head()}) {
    ASSERT_TRUE(driver.open(scene));
    ASSERT_TRUE(Driver::wait_for([&] { return driver.view().hint().contains("Press on the surface"); }, 20'000))
        << driver.view().hint().toStdString();
    const auto at = driver.surface_px();
    ASSERT_TRUE(at);
    driver.press(driver.view(), *at);
    EXPECT_TRUE(Driver::wait_for([&] { return driver.view().hint().isEmpty(); })) << "it was followed";
    driver.release(driver.view(), *at);
  }
  driver.key(Qt::Key_1, Qt::ControlModifier);
  EXPECT_TRUE(Driver::wait_for([&] { return driver.view().fault().contains("Nothing is on"); }))
      << driver.view().fault().toStdString();
  driver.look("nothing-on");
}

TEST(ExplorerHome, AMessageMovesNoPictureAndARecordingIsOpenedFromIt) {
  const std::filesystem::path folder = fresh_folder("home-traces");
  const std::string settings = (folder / "palpa.ini").string();
  QSettings(QString::fromStdString(settings), QSettings::IniFormat).setValue("traces", QString::fromStdString(folder.string()));
  Driver driver({.settings_file = settings});
  ASSERT_TRUE(driver.open(small_head()));
  const QRect before = driver.view().geometry();
  driver.key(Qt::Key_R);
  EXPECT_EQ(driver.view().geometry(), before) << "the picture jumps";
  ASSERT_TRUE(driver.run_ticks(1200));
  EXPECT_TRUE(Driver::wait_for([&] {
    auto* button = driver.window().findChild<QToolButton*>("record_button");
    return button && button->text().contains(QRegularExpression("0:0[1-9]"));
  })) << "no clock";
  driver.look("record-clock");
  driver.key(Qt::Key_R);
  QToolButton* open = nullptr;
  for (QToolButton* one : driver.window().findChild<QFrame*>("message_bar")->findChildren<QToolButton*>())
    if (one->text() == "Open") open = one;
  ASSERT_TRUE(open) << driver.message().toStdString();
  ASSERT_TRUE(Driver::wait_for([&] { return open->isVisible(); }));
  driver.look("recorded");
  QTest::mouseClick(open, Qt::LeftButton);
  Player& player = *driver.window().findChild<Player*>();
  ASSERT_TRUE(Driver::wait_for([&] { return player.has_trace(); }, 60'000)) << driver.message().toStdString();
  driver.key(Qt::Key_N);
  EXPECT_TRUE(driver.message().contains("event") || driver.message().contains("contact")) << driver.message().toStdString();
}

TEST(ExplorerHome, EventsOfAnyKindAreFound) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  driver.key(Qt::Key_T, Qt::ControlModifier);
  Player& player = *driver.window().findChild<Player*>();
  ASSERT_TRUE(Driver::wait_for([&] { return player.has_trace(); }, 60'000));
  const std::vector<FeltTrace::Event>& events = player.trace()->events;
  ASSERT_FALSE(events.empty());
  driver.key(Qt::Key_N);
  EXPECT_EQ(player.at_s(), player.trace()->rows[events.front().row].t_s);
  EXPECT_TRUE(driver.message().contains("contact: surface")) << driver.message().toStdString();
  for (std::size_t i = 0; i <= events.size(); ++i) driver.key(Qt::Key_N);
  EXPECT_TRUE(driver.message().contains("No event after this; the trace has")) << driver.message().toStdString();
  driver.look("events");
}

TEST(ExplorerHome, ClosingAsksForUnsavedChangesAndCancelKeepsTheWindow) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  driver.key(Qt::Key_1, Qt::ControlModifier);
  int asked = 0;
  const auto answer = [&](QMessageBox::StandardButton button) {
    in_dialog([&asked, button](QWidget& dialog) {
      ++asked;
      QTest::mouseClick(dynamic_cast<QMessageBox&>(dialog).button(button), Qt::LeftButton);
    });
    driver.key(Qt::Key_Q, Qt::ControlModifier);
  };
  answer(QMessageBox::Cancel);
  EXPECT_TRUE(driver.window().isVisible());
  EXPECT_FALSE(driver.window().document().undo().isClean());
  answer(QMessageBox::Save);
  EXPECT_EQ(asked, 2);
  EXPECT_FALSE(driver.window().isVisible());
  EXPECT_TRUE(driver.window().document().undo().isClean());
}

TEST(ExplorerHome, APictureHasTheChosenSize) {
  const std::filesystem::path file = fresh_folder("sized") / "large.png";
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  const QRect before = driver.view().geometry();
  in_dialog([&](QWidget& dialog) {
    dialog.findChild<QSpinBox*>("picture_width")->setValue(1400);
    dialog.findChild<QSpinBox*>("picture_height")->setValue(900);
    dialog.findChild<QLineEdit*>("picture_file")->setText(QString::fromStdString(file.string()));
    QTest::mouseClick(dialog.findChild<QDialogButtonBox*>()->button(QDialogButtonBox::Save), Qt::LeftButton);
  });
  driver.key(Qt::Key_P, Qt::ControlModifier | Qt::ShiftModifier);
  const QImage picture(QString::fromStdString(file.string()));
  EXPECT_EQ(picture.size(), QSize(1400, 900));
  EXPECT_EQ(driver.view().geometry(), before);
  driver.look("after-picture");
}

TEST(ExplorerHome, APictureHasATransparentGround) {
  const std::filesystem::path file = fresh_folder("transparent") / "head.png";
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  ASSERT_TRUE(driver.is_done());
  in_dialog([&](QWidget& dialog) {
    dialog.findChild<QSpinBox*>("picture_width")->setValue(900);
    dialog.findChild<QSpinBox*>("picture_height")->setValue(700);
    dialog.findChild<QLineEdit*>("picture_file")->setText(QString::fromStdString(file.string()));
    QTest::mouseClick(dialog.findChild<QCheckBox*>("picture_transparent"), Qt::LeftButton, {}, {8, 8});
    dialog.grab().save(QString(PALPA_SCREENSHOTS) + "/picture-dialog.png");
    QTest::mouseClick(dialog.findChild<QDialogButtonBox*>()->button(QDialogButtonBox::Save), Qt::LeftButton);
  });
  driver.key(Qt::Key_P, Qt::ControlModifier | Qt::ShiftModifier);
  const QImage picture(QString::fromStdString(file.string()));
  ASSERT_EQ(picture.size(), QSize(900, 700));
  picture.save(QString(PALPA_SCREENSHOTS) + "/picture-transparent.png");
  for (const QPoint corner : {QPoint(0, 0), QPoint(899, 0), QPoint(0, 699), QPoint(899, 699)})
    EXPECT_EQ(qAlpha(picture.pixel(corner)), 0);
  const auto at = driver.surface_px();
  ASSERT_TRUE(at);
  const double scale = 700.0 / driver.view().height();
  const QPoint data(static_cast<int>(450 + scale * (at->x() - 0.5 * driver.view().width())), static_cast<int>(scale * at->y()));
  EXPECT_EQ(qAlpha(picture.pixel(data)), 255);
  EXPECT_GT(qGray(driver.view().picture().pixel(0, 0)), 240) << "the window keeps its own ground";
}

TEST(ExplorerHome, ALevelHasTwoRowsAndMoreAndAllIsSofterAtOnce) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  auto& panel = *driver.window().findChild<FeelPanel*>();
  auto& form = *panel.findChild<QGroupBox*>("mode_surface")->findChild<ParameterForm*>();
  const auto rows = [&] {
    int count = 0;
    for (QWidget* one : form.findChildren<QWidget*>(QRegularExpression("^box_"))) count += one->isVisible();
    return count;
  };
  EXPECT_EQ(rows(), 4) << "two levels: where and how firm";
  driver.look("two-rows");
  auto& more = *form.findChild<QToolButton*>("more");
  panel.ensureWidgetVisible(&more);
  QTest::mouseClick(&more, Qt::LeftButton);
  EXPECT_GT(rows(), 12);
  driver.look("more-rows");
  const auto strengths_n = [&] {
    std::vector<double> all;
    for (const ParameterRow& row :
         rows_of([&](ParameterVisitor& v) { Mode(driver.window().document().scene().modes()[0].mode).visit(v); }))
      if (row.info.name == "strength_n") all.push_back(std::get<Strength>(row.value).constant_n);
    return all;
  };
  const std::vector<double> before_n = strengths_n();
  auto& softer = *panel.findChild<QPushButton*>("softer");
  panel.ensureWidgetVisible(&softer);
  QTest::mouseClick(&softer, Qt::LeftButton);
  const std::vector<double> after_n = strengths_n();
  for (std::size_t i = 0; i < before_n.size(); ++i) EXPECT_NEAR(after_n[i], 0.8 * before_n[i], 1e-12);
}

TEST(ExplorerHome, ModesThatCannotWorkOnTheDataAreNotOffered) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  auto& add = *driver.window().findChild<QPushButton*>("add_mode");
  QStringList offered;
  QTimer::singleShot(100, [&] {
    for (QAction* one : add.menu()->actions())
      if (one->isEnabled()) offered << one->text();
    driver.look("add-mode");
    for (QAction* one : add.menu()->actions())
      if (one->text() == "viscosity") one->trigger();
    add.menu()->close();
  });
  QTest::mouseClick(&add, Qt::LeftButton);
  EXPECT_TRUE(offered.contains("viscosity")) << offered.join(", ").toStdString();
  EXPECT_FALSE(offered.contains("follow"));
  EXPECT_EQ(driver.window().document().scene().modes().size(), 2u) << driver.message().toStdString();
}

TEST(ExplorerHome, DarkIsDarkEverywhere) {
  Driver driver;
  ASSERT_TRUE(driver.open(embedded("flow_phantom.toml")));
  const QPalette before = QApplication::palette();
  const auto trigger = [&](const QString& text) {
    for (QAction* one : driver.window().actions())
      if (one->text() == text) one->trigger();
  };
  trigger("&Dark");
  for (QPushButton* one : driver.window().findChild<FeelPanel*>()->findChildren<QPushButton*>())
    if (one->objectName().startsWith("function_") && one->isVisible()) {
      QTest::mouseClick(one, Qt::LeftButton);
      break;
    }
  driver.window().findChild<FunctionEditor*>();
  ASSERT_TRUE(driver.is_done());
  driver.key(Qt::Key_N);  // a message
  const QImage picture = driver.look("dark");
  int bright = 0, all = 0;
  for (int x = 0; x < picture.width(); x += 5)
    for (int y = 0; y < picture.height(); y += 5) ++all, bright += qGray(picture.pixel(x, y)) > 200;
  EXPECT_LT(bright, all / 12) << "something stayed white";
  trigger("&Dark");
  QApplication::setPalette(before);
}

TEST(ExplorerHome, AnUnsavedSceneIsMarkedAmongTheRecentOnes) {
  const std::string settings = (fresh_folder("unsaved") / "palpa.ini").string();
  {
    Driver driver({.settings_file = settings});
    ASSERT_TRUE(driver.open(small_head()));
    driver.key(Qt::Key_1, Qt::ControlModifier);
    driver.window().close();  // a program closes it: nothing is asked, the scene is kept
  }
  Driver driver({.settings_file = settings});
  const QList<QPushButton*> buttons = driver.window().findChildren<QPushButton*>();
  EXPECT_TRUE(std::ranges::any_of(buttons, [](auto* one) { return one->text().startsWith("small_head (unsaved changes)"); }));
  EXPECT_TRUE(std::ranges::any_of(buttons, [](auto* one) { return one->text().startsWith("small_head.toml"); }));
  driver.look("recent-unsaved");
  auto& recent = *driver.window().findChild<QMenu*>("recent");
  Q_EMIT recent.aboutToShow();
  ASSERT_FALSE(recent.isEmpty());
  EXPECT_TRUE(recent.actions().front()->text().startsWith("small_head (unsaved changes)"))
      << recent.actions().front()->text().toStdString();
}

TEST(ExplorerHome, DialogsOfRecordingsStartInTheirFolder) {
  const std::filesystem::path folder = fresh_folder("dialog-traces");
  const std::string settings = (folder / "palpa.ini").string();
  {
    QSettings kept(QString::fromStdString(settings), QSettings::IniFormat);
    kept.setValue("traces", QString::fromStdString(folder.string()));
    kept.setValue("folder", QString(PALPA_SCENES));  // of the last data
  }
  Driver driver({.settings_file = settings});
  ASSERT_TRUE(driver.open(small_head()));
  QStringList at;
  const auto look_into = [&](Qt::Key key, Qt::KeyboardModifiers modifiers) {
    in_dialog([&](QWidget& dialog) {
      at << dynamic_cast<QFileDialog&>(dialog).directory().absolutePath();
      dynamic_cast<QFileDialog&>(dialog).reject();
    });
    driver.key(key, modifiers);
  };
  look_into(Qt::Key_O, Qt::ControlModifier);
  look_into(Qt::Key_R, Qt::ControlModifier | Qt::ShiftModifier);
  driver.key(Qt::Key_T, Qt::ControlModifier);
  ASSERT_TRUE(Driver::wait_for([&] { return driver.window().findChild<Player*>()->has_trace(); }, 60'000));
  look_into(Qt::Key_T, Qt::ControlModifier | Qt::ShiftModifier);
  const QString traces = QString::fromStdString(folder.string());
  EXPECT_EQ(at, QStringList({QString(PALPA_SCENES), traces, traces})) << at.join(", ").toStdString();
}

TEST(ExplorerHome, RecentFilesAreInTheMenuAndTheModesHaveTheirNames) {
  Driver driver;
  const std::filesystem::path head = small_head();
  ASSERT_TRUE(driver.open(head));
  auto& recent = *driver.window().findChild<QMenu*>("recent");
  Q_EMIT recent.aboutToShow();
  ASSERT_FALSE(recent.isEmpty());
  EXPECT_EQ(recent.actions().front()->text().toStdString(), head.string());
  QStringList modes;
  for (QAction* one : driver.window().actions())
    if (one->isVisible() && one->shortcut().toString().startsWith("Ctrl+") && one->isCheckable()) modes << one->text();
  EXPECT_TRUE(modes.contains("surface")) << modes.join(", ").toStdString();
  for (const QString& mode : modes) EXPECT_FALSE(mode.startsWith("Mode ")) << mode.toStdString();
  EXPECT_TRUE(Driver::wait_for([&] {
    for (QLabel* one : driver.window().instruments().findChildren<QLabel*>())
      if (one->text().startsWith("Force: on")) return true;
    return false;
  }));
}

}  // namespace home_test
}  // namespace palpa::explorer
