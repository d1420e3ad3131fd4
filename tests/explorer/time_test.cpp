// Data that change with time in the window: held, stepped and played.
#include <gtest/gtest.h>
#include <vtkProp.h>

#include <QLabel>
#include <QSlider>
#include <QToolButton>
#include <algorithm>
#include <cmath>
#include <fstream>

#include "driver.h"
#include "explorer/surface_finder.h"

namespace palpa::explorer {
namespace time_test {

constexpr int frames = 8;
constexpr double beat_s = 0.8, frame_s = beat_s / frames;

/// The embedded chamber with few samples and frames.
std::filesystem::path small_beat() {
  std::ifstream in(embedded("beat_phantom.toml"));
  std::string text(std::istreambuf_iterator<char>(in), {});
  for (const auto& [key, value] : {std::pair("sampled = ", "32"), {"frames = ", "8"}}) {
    const std::size_t at = text.find(key) + std::string(key).size();
    text.replace(at, text.find_first_not_of("0123456789", at) - at, value);
  }
  const std::filesystem::path file = fresh_folder("beat") / "small_beat.toml";
  std::ofstream(file) << text;
  return file;
}

/// Height [m] of a scene's surface towards the viewer, at the middle of the view.
double nearest_m(Driver& driver, const Scene& scene) {
  const detail::View& view = driver.view().view();
  const auto met = SurfaceFinder(scene).first(view.centre_m + 1.0 * view.towards, -view.towards);
  return met ? dot(met->at_m, view.towards) : -1.0;
}

/// Likewise of the drawn surface, at its largest.
double drawn_m(Driver& driver) {
  const Drawing& drawing = driver.view().drawing();
  const auto& parts = drawing.solid.empty() ? drawing.shells : drawing.solid;
  return parts.empty() ? -1.0 : parts.front().fine->GetBounds()[5];
}

TEST(ExplorerTime, ASliderHoldsTheDataWhereTheyAreSeenAndFeltAndAButtonPlaysThem) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_beat()));
  const auto scene = [&]() -> const Scene& { return driver.window().document().scene(); };
  auto& bar = *driver.window().findChild<TimeBar*>();
  auto& slider = *bar.findChild<QSlider*>("data_time");
  auto& play = *bar.findChild<QToolButton*>("play");
  ASSERT_TRUE(bar.isVisible());
  ASSERT_TRUE(bar.plays()) << "as the scene says";
  ASSERT_TRUE(driver.run_ticks(100));
  const double before_s = bar.at_s();
  EXPECT_TRUE(Driver::wait_for([&] { return std::abs(bar.at_s() - before_s) > 0.05; })) << "the time stands";
  driver.look("time-plays");

  EXPECT_TRUE(driver.is_done()) << "the window is busy as long as the data play";
  driver.key(Qt::Key_P);
  EXPECT_FALSE(bar.plays());
  EXPECT_EQ(scene().time().play, TimeOptions::Play::hold);
  // The frames at which the wall is nearest to the viewer and farthest.
  int near = 0, far = 0;
  std::vector<double> walls_m;
  for (int frame = 0; frame < frames; ++frame) {
    Scene at = scene();
    at.set(TimeOptions{.start_s = frame * frame_s});
    walls_m.push_back(nearest_m(driver, at));
    if (walls_m.back() > walls_m[static_cast<std::size_t>(near)]) near = frame;
    if (walls_m.back() < walls_m[static_cast<std::size_t>(far)]) far = frame;
  }
  const double moved_m = walls_m[static_cast<std::size_t>(near)] - walls_m[static_cast<std::size_t>(far)];
  ASSERT_GT(moved_m, 5e-3);
  const auto go_to = [&](int frame) {
    slider.setFocus();  // else arrow keys turn the view
    for (int i = 0; i <= frames; ++i) QTest::keyClick(&slider, Qt::Key_Left);
    for (int i = 0; i < frame; ++i) QTest::keyClick(&slider, Qt::Key_Right);
    EXPECT_NEAR(scene().time().start_s, frame * frame_s, 1e-9) << "arrow keys stop at frames";
    EXPECT_NEAR(bar.at_s(), frame * frame_s, 1e-9);
    EXPECT_TRUE(bar.findChild<QLabel*>("data_time_words")->text().contains(QString::number(frame * frame_s, 'f', 3)));
    EXPECT_TRUE(driver.is_done());
    EXPECT_FALSE(driver.view().drawing().is_rough);
  };
  go_to(far);
  const double far_m = drawn_m(driver);
  go_to(near);
  EXPECT_NEAR(drawn_m(driver) - far_m, moved_m, 0.3 * moved_m) << "the picture is of another moment";

  // Touched where the wall is near, it is not felt when it is far.
  ASSERT_TRUE(driver.run_ticks(300));
  const QPoint middle(driver.view().width() / 2, driver.view().height() / 2);
  driver.press(driver.view(), middle);
  ASSERT_TRUE(driver.is_let_out());
  for (int notch = 0; notch < 10 && driver.force_n() < 0.05; ++notch) {
    driver.wheel(driver.view(), middle, 1, Qt::LeftButton);
    driver.hand_rests();
  }
  ASSERT_GT(driver.force_n(), 0.05) << driver.message().toStdString();
  driver.look("time-held-near");
  go_to(far);
  EXPECT_TRUE(Driver::wait_for([&] { return driver.force_n() < 0.01; })) << driver.force_n() << " N of a wall that is gone";
  driver.look("time-held-far");
  driver.release(driver.view(), middle);

  // A drag with the mouse is one step of undo.
  const int steps = driver.window().document().undo().count();
  const double share = static_cast<double>(slider.value()) / slider.maximum();
  const QPoint handle(static_cast<int>(share * (slider.width() - 12)) + 6, slider.height() / 2);
  driver.drag(slider, handle, handle + QPoint(slider.width() / 4, 0));
  EXPECT_NEAR(scene().time().start_s, far * frame_s + beat_s / 4, 0.05);
  EXPECT_LE(driver.window().document().undo().count(), steps + 1);

  // Played on from where it was held.
  const double held_s = bar.at_s();
  const auto clock_s = [&] { return driver.window().touch().moment().t_s; };
  const double unclicked_s = clock_s();
  QTest::mouseClick(&play, Qt::LeftButton);
  const double most_s = clock_s() - unclicked_s;
  EXPECT_TRUE(bar.plays());
  // Between the two readings of the clock lies the click, at which the data were where they had been held.
  const double ahead_s = held_s - scene().time().at(unclicked_s).within(beat_s);
  EXPECT_LT(std::fmod(ahead_s + beat_s + 1e-3, beat_s), most_s + 2e-3)
      << "the data jumped from " << held_s << " by " << ahead_s;
  EXPECT_TRUE(Driver::wait_for([&] { return std::abs(bar.at_s() - held_s) > 0.1; }));
}

TEST(ExplorerTime, DataThatStandHaveNoTimeBar) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  EXPECT_FALSE(driver.window().findChild<TimeBar*>()->isVisible());
}

}  // namespace time_test
}  // namespace palpa::explorer
