// The window without a mouse, and before a scene is open.
#include <gtest/gtest.h>

#include <QDoubleSpinBox>
#include <QGroupBox>
#include <QLabel>
#include <QLineEdit>
#include <QToolButton>
#include <algorithm>
#include <filesystem>

#include "driver.h"
#include "explorer/linked_levels.h"
#include "explorer/slice_view.h"

namespace palpa::explorer {
namespace keyboard_test {

/// A key where the focus is, as a keyboard sends it.
void key_at_focus(Driver& driver, Qt::Key key) {
  if (!QApplication::activeWindow()) QApplication::setActiveWindow(&driver.window());  // of no window manager
  QWidget* const focus = QApplication::focusWidget();
  QTest::keyClick(focus ? focus : &driver.window(), key);
  Driver::live(10);
}

TEST(ExplorerKeyboard, LeadsFromTheStartPageToATouch) {
  Driver driver;
  const auto is_tile = [](const QWidget* widget) { return widget && widget->objectName() == "tile_head_phantom"; };
  QStringList met;
  for (int i = 0; i < 12 && !is_tile(QApplication::focusWidget()); ++i) {
    key_at_focus(driver, Qt::Key_Tab);
    met << (QApplication::focusWidget() ? QApplication::focusWidget()->objectName() : "none");
  }
  ASSERT_TRUE(is_tile(QApplication::focusWidget())) << met.join(", ").toStdString();
  key_at_focus(driver, Qt::Key_Return);
  ASSERT_TRUE(Driver::wait_for([&] { return largest_component(driver.view().drawing().bounds_m.size_m()) > 0.0; }, 120'000));
  ASSERT_EQ(QApplication::focusWidget(), &driver.view());
  key_at_focus(driver, Qt::Key_Return);
  ASSERT_TRUE(driver.is_let_out());
  const Vec3 before_m = driver.window().touch().led_to_m();
  for (int i = 0; i < 6; ++i) key_at_focus(driver, Qt::Key_PageDown);
  EXPECT_GT(distance(driver.window().touch().led_to_m(), before_m), 1e-3) << "Page Down does not press";
  EXPECT_TRUE(Driver::wait_for([&] { return driver.force_n() > 0.05; })) << "nothing is felt";
  const Vec3 towards = driver.view().view().towards, pressed_m = driver.window().touch().led_to_m();
  for (int i = 0; i < 4; ++i) key_at_focus(driver, Qt::Key_Right);
  const Vec3 way_m = driver.window().touch().led_to_m() - pressed_m;
  EXPECT_NEAR(dot(way_m, driver.view().view().right), 16.0 / driver.view().view().px_per_m(), 3e-3);
  EXPECT_EQ(driver.view().view().towards, towards) << "the arrows turn the view during a touch";
  driver.look("touch-by-keys");
  key_at_focus(driver, Qt::Key_Return);
  EXPECT_TRUE(Driver::wait_for([&] { return driver.force_n() < 0.05; })) << "let go, and it is still felt";
  key_at_focus(driver, Qt::Key_Right);
  EXPECT_NE(driver.view().view().towards, towards) << "the arrows turn the view again";
}

TEST(ExplorerKeyboard, LetsGoWhenAnotherWidgetHasTheKeysOrTheMouse) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  const auto touch = [&] {
    driver.view().setFocus();
    key_at_focus(driver, Qt::Key_Return);
    ASSERT_TRUE(driver.is_let_out());
    for (int i = 0; i < 6; ++i) key_at_focus(driver, Qt::Key_PageDown);
    ASSERT_TRUE(Driver::wait_for([&] { return driver.force_n() > 0.05; }));
  };
  const auto is_let_go = [&] { return Driver::wait_for([&] { return driver.force_n() < 0.05; }); };
  touch();
  driver.window().findChildren<SliceView*>().front()->setFocus();
  EXPECT_TRUE(is_let_go());
  touch();
  driver.drag(driver.view(), {6, 6}, {40, 6}, Qt::RightButton);
  EXPECT_TRUE(is_let_go());
}

TEST(ExplorerSmall, TheForceKeepsMostOfTheRoom) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  const auto plot = [&](const char* name) -> QWidget* {
    for (QWidget* one : driver.window().instruments().findChildren<QWidget*>())
      if (one->accessibleName() == name) return one;
    return nullptr;
  };
  QWidget* const force = plot("Force over the last seconds");
  QWidget* const spectrum = plot("Spectrum of the force");
  ASSERT_TRUE(force && spectrum);
  EXPECT_TRUE(spectrum->isVisible());
  driver.window().resize(1001, 560);
  ASSERT_TRUE(Driver::wait_for([&] { return !spectrum->isVisible(); }, 3000));
  EXPECT_TRUE(Driver::wait_for([&] { return force->width() > 350; }, 3000))  // axis and legend take 150
      << force->width() << " of " << driver.window().instruments().width();
  driver.look("small");
  driver.window().resize(1280, 800);
  EXPECT_TRUE(Driver::wait_for([&] { return spectrum->isVisible(); }, 3000));
}

/// Each text is within the widget, and none meets another.
void expect_apart(const QWidget& on, const std::vector<PlacedText>& texts) {
  for (std::size_t i = 0; i < texts.size(); ++i) {
    EXPECT_TRUE(QRectF(on.rect()).contains(texts[i].box)) << texts[i].words.toStdString() << " is cut";
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_FALSE(texts[i].box.adjusted(0, 1, 0, -1).intersects(texts[j].box))
          << texts[i].words.toStdString() << " meets " << texts[j].words.toStdString();
  }
}

bool has(const std::vector<PlacedText>& texts, const QString& words) {
  return std::ranges::any_of(texts, [&](const PlacedText& text) { return text.words == words; });
}

TEST(ExplorerSmall, NoTextIsCutOrMeetsAnother) {
  Driver driver;
  driver.window().resize(1001, 560);
  for (const std::filesystem::path& scene : {small_head(), embedded("flow_phantom.toml")}) {
    ASSERT_TRUE(driver.open(scene));
    driver.window().resize(1001, 560);
    ASSERT_TRUE(Driver::wait_for([&] { return driver.view().hint().contains("Press"); }, 20'000));
    driver.look("small-texts-" + scene.stem().string());
    expect_apart(driver.view(), driver.view().texts());
    EXPECT_TRUE(has(driver.view().texts(), driver.view().hint())) << "the hint is not whole";
    for (const SliceView* slice : driver.window().findChildren<SliceView*>()) {
      expect_apart(*slice, slice->texts());
      EXPECT_TRUE(std::ranges::any_of(slice->texts(),
                                      [&](const PlacedText& text) { return text.words.startsWith(slice->title() + " · "); }));
      EXPECT_TRUE(has(slice->texts(), driver.window().views().look().words));
    }
  }
  // Narrower still: the less important ones are left out.
  SliceView& narrow = *driver.window().findChildren<SliceView*>().front();
  narrow.resize(120, 100);
  narrow.grab();
  expect_apart(narrow, narrow.texts());
  EXPECT_GE(narrow.texts().size(), 4U);
}

TEST(ExplorerKeyboard, ASpaceIsALetterOfANameOnlyWithoutForce) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  auto& form = *driver.window().findChild<QGroupBox*>("mode_surface")->findChild<ParameterForm*>();
  QTest::mouseClick(form.findChild<QToolButton*>("more"), Qt::LeftButton);
  QLineEdit* name = nullptr;
  QDoubleSpinBox* number = nullptr;
  for (QLineEdit* one : form.findChildren<QLineEdit*>())
    if (one->text() == "bone") name = one;
  for (QDoubleSpinBox* one : form.findChildren<QDoubleSpinBox*>())
    if (!number && one->isVisible() && one->isEnabled()) number = one;
  ASSERT_TRUE(name && number);
  name->setFocus();
  name->selectAll();
  QTest::keyClicks(name, "inner");
  ASSERT_FALSE(driver.window().touch().is_held());
  QTest::keyClick(name, Qt::Key_Space);
  EXPECT_TRUE(driver.window().touch().is_held()) << "the force must go off with any focus";
  EXPECT_EQ(name->text(), "inner");
  QTest::keyClick(name, Qt::Key_Space);
  QTest::keyClicks(name, "table");
  EXPECT_EQ(name->text(), "inner table");
  EXPECT_TRUE(driver.window().touch().is_held()) << "a letter turned the force on";
  QTest::keyClick(name, Qt::Key_Return);
  EXPECT_EQ(felt_levels(driver.window().document().scene()).at(1).name, "inner_table") << driver.message().toStdString();
  number->setFocus();
  QTest::keyClick(number, Qt::Key_Space);
  EXPECT_FALSE(driver.window().touch().is_held()) << "a number has no space";
}

TEST(ExplorerKeyboard, SaysWhatAnActionWithoutASceneNeeds) {
  Driver driver;
  for (const auto& [key, modifiers] : std::initializer_list<std::pair<Qt::Key, Qt::KeyboardModifiers>>{
           {Qt::Key_S, Qt::ControlModifier}, {Qt::Key_R, Qt::NoModifier}, {Qt::Key_P, Qt::ControlModifier}}) {
    driver.key(key, modifiers);
    EXPECT_TRUE(driver.message().contains("open one")) << driver.message().toStdString();
    driver.window().findChild<QLabel*>("message")->clear();
  }
}

TEST(ExplorerKeyboard, TheTitleHasAStarWhileChangesAreNotSaved) {
  const std::filesystem::path folder = fresh_folder("title"), file = folder / "mine.toml";
  std::filesystem::copy_file(small_head(), file);
  Driver driver;
  ASSERT_TRUE(driver.open(file));
  EXPECT_FALSE(driver.window().isWindowModified());
  driver.key(Qt::Key_1, Qt::ControlModifier);
  EXPECT_TRUE(driver.window().isWindowModified()) << "the first change";
  driver.key(Qt::Key_Z, Qt::ControlModifier);
  EXPECT_FALSE(driver.window().isWindowModified()) << "taken back";
  driver.key(Qt::Key_1, Qt::ControlModifier);
  driver.key(Qt::Key_S, Qt::ControlModifier);
  EXPECT_FALSE(driver.window().isWindowModified());
  EXPECT_TRUE(driver.window().windowTitle().contains("mine.toml")) << driver.window().windowTitle().toStdString();
}

}  // namespace keyboard_test
}  // namespace palpa::explorer
