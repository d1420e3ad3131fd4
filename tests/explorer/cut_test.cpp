// The view cut open at a slice.
#include <gtest/gtest.h>

#include "driver.h"
#include "explorer/slice_view.h"

namespace palpa::explorer {
namespace cut_test {

/// Share [1] of pixels in the middle of the view that two pictures differ in.
double changed(const QImage& a, const QImage& b) {
  int differ = 0, all = 0;
  for (int y = a.height() / 3; y < 2 * a.height() / 3; ++y) {
    for (int x = a.width() / 3; x < 2 * a.width() / 3; ++x, ++all)
      differ += std::abs(qGray(a.pixel(x, y)) - qGray(b.pixel(x, y))) > 8;
  }
  return 1.0 * differ / all;
}

TEST(ExplorerCut, HidesWhatIsInFrontOfTheSliceFromTheEyeAndFromTheHand) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  ASSERT_TRUE(driver.is_done());
  View3D& view = driver.view();
  const Vec3 cross_m = driver.window().views().bounds_m().centre_m(), towards = view.view().towards;
  const QPointF middle(0.5 * view.width(), 0.5 * view.height());
  const auto depth_m = [&] {
    const auto target = view.target_at(middle);
    return target && target->on_surface ? dot(target->at_m - cross_m, towards) : 1.0;
  };
  const double whole_m = depth_m();
  ASSERT_GT(whole_m, 0.0) << "the face is in front of the middle";
  ASSERT_LT(whole_m, 1.0);
  const QImage whole = view.picture();

  driver.key(Qt::Key_C);
  ASSERT_TRUE(view.is_cut());
  Driver::live(800);
  EXPECT_LE(depth_m(), 1e-6) << "what is hidden would be touched";
  EXPECT_GT(changed(whole, view.picture()), 0.2) << "the face is still seen";
  driver.look("cut-open");
  // A press touches what is left.
  const auto target = view.target_at(middle);
  ASSERT_TRUE(target);
  driver.press(view, middle.toPoint());
  EXPECT_LT(distance(driver.window().touch().led_to_m(), target->at_m), 0.02);
  ASSERT_TRUE(driver.run_ticks(50));
  driver.release(view, middle.toPoint());
  // Turned, the cut stays in the head.
  view.turn(50.0, 10.0);
  Driver::live(800);
  driver.look("cut-turned");
  view.turn(0.0, -10.0);
  view.turn(-50.0, 0.0);

  // The wheel over the facing slice moves the cut: towards the viewer until nothing is cut.
  SliceView* facing = nullptr;
  for (SliceView* slice : driver.window().findChildren<SliceView*>())
    if (std::abs(dot(slice->view().towards, towards)) > 0.9) facing = slice;
  ASSERT_TRUE(facing);
  const bool along = dot(facing->view().towards, towards) > 0.0;
  const QPoint over = facing->rect().center();
  QWheelEvent spun(over, facing->mapToGlobal(over), {}, QPoint(0, (along ? 60 : -60) * 120), {}, {}, Qt::NoScrollPhase, false);
  QApplication::sendEvent(facing, &spun);
  Driver::live(800);
  EXPECT_NEAR(depth_m(), whole_m, 1e-6);
  const QImage cut_before_all = view.picture();

  driver.key(Qt::Key_C);
  EXPECT_FALSE(view.is_cut());
  EXPECT_NEAR(depth_m(), whole_m, 1e-6);
  Driver::live(800);
  EXPECT_LT(changed(cut_before_all, view.picture()), 0.005) << "a cut in front of the head cuts it";
}

}  // namespace cut_test
}  // namespace palpa::explorer
