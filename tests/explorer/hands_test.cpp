// Several hands in the window: all felt and seen, one led by the mouse.
#include <gtest/gtest.h>

#include <QComboBox>
#include <QGroupBox>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <thread>

#include "driver.h"
#include "explorer/hand_frame.h"
#include "explorer/opening.h"
#include "explorer/player.h"
#include "palpa/study/run.h"

namespace palpa::explorer {
namespace hands_test {

namespace fs = std::filesystem;

/// Thumb and forefinger on a head with few samples.
fs::path two_fingers() {
  std::ifstream in(embedded("tools/two_fingers_phantom.toml"));
  std::string text(std::istreambuf_iterator<char>(in), {});
  const std::string key = "sampled = 160";
  text.replace(text.find(key), key.size(), "sampled = 56");
  const fs::path file = fresh_folder("fingers") / "fingers.toml";
  std::ofstream(file) << text;
  return file;
}

/// Share of pixels within `radius_px` of a place that differ between two pictures.
double change_at(const QImage& a, const QImage& b, const QPointF& at, int radius_px) {
  int all = 0, changed = 0;
  for (int y = -radius_px; y <= radius_px; ++y) {
    for (int x = -radius_px; x <= radius_px; ++x) {
      const QPoint px(static_cast<int>(at.x()) + x, static_cast<int>(at.y()) + y);
      if (!a.valid(px) || !b.valid(px)) continue;
      ++all;
      changed += a.pixel(px) != b.pixel(px);
    }
  }
  return all > 0 ? static_cast<double>(changed) / all : 0.0;
}

/// Presses at a point of the surface until the led hand feels it.
void press(Driver& driver, const QPoint& at) {
  driver.press(driver.view(), at);
  ASSERT_TRUE(driver.is_let_out());
  driver.wheel(driver.view(), at, 8, Qt::LeftButton);
  ASSERT_TRUE(Driver::wait_for([&] { return driver.force_n() > 0.05; }));
  ASSERT_TRUE(driver.hand_rests());
}

TEST(ExplorerHands, AreFeltWhereTheSceneOfEachHasThem) {
  Driver driver;
  ASSERT_TRUE(driver.open(two_fingers()));
  Touch& touch = driver.window().touch();
  ASSERT_EQ(touch.hands(), 2U);
  ASSERT_TRUE(driver.run_ticks(50));
  ASSERT_TRUE(Driver::wait_for([&] { return touch.moment(1).tick > 50; }));
  const Scene& scene = driver.window().document().scene();
  for (std::size_t hand = 0; hand < 2; ++hand) {
    const Vec3 own_m = touch.loop()->latest(hand).frame.result.probe_m;
    EXPECT_LT(distance(scene.hand_to_world().to_world(touch.moment(hand).probe_m),
                       scene.of_hand(hand).hand_to_world().to_world(own_m)),
              1e-9)
        << hand;
    EXPECT_TRUE(touch.moment(hand).has_tool);
  }
  EXPECT_NEAR(distance(touch.moment(0).probe_m, touch.moment(1).probe_m), 0.03, 1e-9) << "as far apart as in the scene";
}

/// A device that is held still.
class Held final : public Device {
 public:
  std::string name() const override { return "held"; }
  DeviceLimits limits() const override { return {.has_motors = false}; }
  DeviceState read() noexcept override { return {.position_m = {0.01, 0, 0.1}, .valid = true}; }
  bool write(const Vec3&) noexcept override { return true; }
  bool rests() const noexcept override { return true; }
};

TEST(TouchOfHands, ADeviceIsTheFirstAndTheMouseLeadsTheOther) {
  const Opened opened = open_any(two_fingers(), {});
  Touch touch;
  touch.start(opened.loaded.scene, 0.1);
  touch.begin(opened.loaded, std::make_unique<Held>());
  EXPECT_FALSE(touch.is_by_mouse());
  const auto comes = [&](const auto& condition) {
    for (int n = 0; n < 4000 && !condition(); ++n) {
      touch.beat(1e-3);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return condition();
  };
  ASSERT_TRUE(comes([&] { return touch.moment(0).tick > 10 && touch.moment(1).tick > 10; }));
  const Vec3 held_m = touch.moment(0).probe_m, led_from_m = touch.moment(1).probe_m;
  EXPECT_EQ(held_m, (Vec3{0.01, 0, 0.1}));
  touch.lead(1);
  EXPECT_TRUE(touch.is_by_mouse());
  touch.turn_view(Mat3{{{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}}});  // of the device, whose probe stays
  touch.lead_hand(led_from_m + Vec3{0.005, 0, 0});
  EXPECT_TRUE(comes([&] {
    return distance(touch.moment(1).probe_m, led_from_m + Vec3{0.005, 0, 0}) < 1e-4;
  })) << "to the right on the screen";
  EXPECT_EQ(touch.moment(0).probe_m, held_m);
  EXPECT_EQ(touch.end(), "");
}

TEST(ExplorerHands, TheMouseLeadsTheChosenOneAndTheOtherRests) {
  Driver driver;
  ASSERT_TRUE(driver.open(two_fingers()));
  ASSERT_TRUE(driver.is_done());
  auto* box = driver.window().findChild<QComboBox*>("hand");
  ASSERT_TRUE(box && box->isVisible());
  EXPECT_EQ(box->count(), 2);
  Touch& touch = driver.window().touch();
  const auto at = driver.surface_px();
  ASSERT_TRUE(at);
  for (std::size_t led : {std::size_t{0}, std::size_t{1}}) {
    if (led == 1) driver.key(Qt::Key_H);
    ASSERT_EQ(touch.led(), led);
    EXPECT_EQ(box->currentIndex(), static_cast<int>(led));
    ASSERT_TRUE(driver.run_ticks(50));
    const Vec3 other_m = touch.moment(1 - led).probe_m;
    const QPoint there = *at + QPoint(led == 0 ? -40 : 40, 0);
    press(driver, there);
    EXPECT_GT(norm(touch.moment(led).command_n), 0.05);
    EXPECT_LT(distance(touch.moment(1 - led).probe_m, other_m), 1e-6);
    driver.look(led == 0 ? "hands-first" : "hands-second");
    if (led == 1) break;
    driver.release(driver.view(), there);
    ASSERT_TRUE(driver.hand_rests());
  }
  const auto& curve = driver.window().instruments().shown();
  ASSERT_FALSE(curve.empty());
  EXPECT_LT(distance(curve.back().probe_m + frame_origin_m(driver.window().document().scene(), 1), touch.moment(1).probe_m),
            1e-3)
      << "of the led hand";
  box->setCurrentIndex(0);
  Q_EMIT box->activated(0);
  EXPECT_EQ(touch.led(), 0U);
}

TEST(ExplorerHands, AreAllSeenInTheViewAndInTheSlices) {
  Driver driver;
  ASSERT_TRUE(driver.open(two_fingers()));
  ASSERT_TRUE(driver.is_done());
  Touch& touch = driver.window().touch();
  ASSERT_TRUE(driver.run_ticks(100));
  View3D& view = driver.view();
  const Moment led = touch.moment(0), other = touch.moment(1);
  const Scene& scene = driver.window().document().scene();
  const Tool tool(scene.tool_of(1), scene.coupling());
  const QImage with = view.picture();
  view.show_hands({});
  const QImage without = view.picture();
  EXPECT_GT(change_at(with, without, on_screen(view.view(), other.proxy_m), 4), 0.5) << "the ball";
  EXPECT_LT(change_at(with, without, on_screen(view.view(), led.proxy_m), 4), 0.01) << "it is the other one's";
  std::size_t seen = 0;
  for (std::size_t foot = 0; foot < tool.feet(); ++foot) {
    const Vec3 foot_m = tool.foot_m({other.proxy_m, other.proxy_turn}, foot);
    seen += change_at(with, without, on_screen(view.view(), foot_m), 2) > 0.5;
  }
  EXPECT_EQ(seen, tool.feet());
  for (SliceView* slice : driver.window().findChildren<SliceView*>()) {
    const QImage both = slice->grab().toImage();
    slice->show_touch({}, {}, 1.0);
    const QImage none = slice->grab().toImage();
    for (const Moment& moment : {led, other}) {
      const QPointF at = on_screen(slice->view(), moment.proxy_m);
      if (!slice->rect().adjusted(8, 8, -8, -8).contains(at.toPoint())) continue;
      EXPECT_GT(change_at(both, none, at, 4), 0.5) << slice->title().toStdString();
    }
  }
}

TEST(ExplorerHands, HaveAToolEachInThePanel) {
  Driver driver;
  ASSERT_TRUE(driver.open(two_fingers()));
  driver.key(Qt::Key_H);
  auto* group = driver.window().findChild<QGroupBox*>("tool");
  ASSERT_TRUE(group);
  auto* shape = group->findChild<QComboBox*>();
  ASSERT_TRUE(shape);
  const Scene before = driver.window().document().scene();
  shape->setCurrentText("rod");
  Q_EMIT shape->activated(shape->currentIndex());
  const Scene& after = driver.window().document().scene();
  EXPECT_EQ(after.hands()[0], before.hands()[0]);
  EXPECT_EQ(after.hands()[1].tool.shape, ToolOptions::Shape::rod);
  EXPECT_TRUE(Driver::wait_for([&] { return driver.window().touch().loop()->statistics(1).scenes > 0; }))
      << "the session goes on with it";
  EXPECT_TRUE(Driver::wait_for([&] {
    const Moment& moment = driver.window().touch().moment(1);
    return moment.has_tool && moment.tick > 0;
  }));
}

TEST(ExplorerHands, AreRecordedTogetherAndReplayToTheBit) {
  Driver driver;
  ASSERT_TRUE(driver.open(two_fingers()));
  ASSERT_TRUE(driver.is_done());
  driver.key(Qt::Key_R);
  ASSERT_TRUE(Driver::wait_for([&] { return driver.window().touch().is_recorded(); }));
  const fs::path folder = driver.window().touch().trace();
  const auto at = driver.surface_px();
  ASSERT_TRUE(at);
  press(driver, *at);
  driver.release(driver.view(), *at);
  driver.key(Qt::Key_R);
  ASSERT_FALSE(driver.window().touch().is_recorded());
  for (const char* name : {"thumb", "forefinger"}) {
    ASSERT_TRUE(fs::exists(folder / name / "trace.toml")) << driver.message().toStdString();
    const ReplayResult again = replay(folder / name);
    EXPECT_TRUE(again.difference.same) << name << ": " << again.difference.where << again.cut;
  }
  // Played together; the led one changes at the same moment.
  ASSERT_TRUE(driver.open(folder));
  auto* player = driver.window().findChild<Player*>();
  ASSERT_TRUE(Driver::wait_for([&] { return player->has_trace(); }));
  ASSERT_EQ(player->hands().size(), 1U);
  player->seek(0.7 * player->duration_s());
  driver.look("hands-played");
  const Moment thumb = player->moment(), finger = player->hands()[0];
  EXPECT_GT(norm(thumb.command_n) + norm(finger.command_n), 0.0);
  EXPECT_GT(distance(thumb.proxy_m, finger.proxy_m), 0.01);
  const double at_s = player->at_s();
  driver.key(Qt::Key_H);
  EXPECT_EQ(player->at_s(), at_s);
  ASSERT_EQ(player->hands().size(), 1U);
  EXPECT_EQ(player->moment().proxy_m, finger.proxy_m);
  EXPECT_EQ(player->hands()[0].proxy_m, thumb.proxy_m);
  driver.window().open_chosen({QString::fromStdString(folder.string()), QString::fromStdString(folder.string())});
  ASSERT_TRUE(Driver::wait_for([&] { return player->other_trace() != nullptr; })) << driver.message().toStdString();
  EXPECT_EQ(player->other_moment()->proxy_m, player->moment().proxy_m) << "the same traces side by side";
  driver.key(Qt::Key_Escape);
  EXPECT_TRUE(Driver::wait_for([&] { return driver.window().touch().is_felt(); })) << "one's own hands again";
  EXPECT_EQ(driver.window().touch().hands(), 2U);
  fs::remove_all(folder / "forefinger");
  ASSERT_TRUE(driver.open(folder / "thumb"));
  EXPECT_EQ(driver.window().touch().hands(), 1U) << "a hand's trace alone";
  fs::remove_all(folder);
}

TEST(ExplorerHands, OneHandHasNoChoice) {
  Driver driver;
  ASSERT_TRUE(driver.open(small_head()));
  EXPECT_EQ(driver.window().touch().hands(), 1U);
  EXPECT_FALSE(driver.window().findChild<QComboBox*>("hand")->isVisible());
  driver.key(Qt::Key_H);
  EXPECT_EQ(driver.window().touch().led(), 0U);
}

// A simulated hand of the second finger: its path lies where that finger is.
TEST(ExplorerHands, ASimulatedHandIsThatOfTheLedOne) {
  Driver driver;
  ASSERT_TRUE(driver.open(two_fingers()));
  const LoadedScene loaded = driver.window().document().loaded();
  LoadedScene alone = loaded;
  alone.scene = loaded.scene.of_hand(1);
  const PlayedHand hand{.trace = {}, .description = "sim:press", .number = 1}, only{.trace = {}, .description = "sim:press"};
  const FeltTrace in_window = feel_again(hand, loaded), by_itself = feel_again(only, alone);
  ASSERT_EQ(in_window.rows.size(), by_itself.rows.size());
  const Similarity window = loaded.scene.hand_to_world(), own = alone.scene.hand_to_world();
  double apart_m = 0.0;
  for (std::size_t i = 0; i < in_window.rows.size(); ++i) {
    ASSERT_EQ(in_window.rows[i].command_n, by_itself.rows[i].command_n);
    apart_m = std::max(apart_m, distance(window.to_world(in_window.rows[i].proxy_m), own.to_world(by_itself.rows[i].proxy_m)));
  }
  EXPECT_LT(apart_m, 1e-12);
}

}  // namespace hands_test
}  // namespace palpa::explorer
