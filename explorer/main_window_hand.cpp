// Hand of the main window: led by the mouse, one of the scene's hands at a time.
#include <QComboBox>

#include "explorer/main_window.h"

namespace palpa::explorer {
namespace {

constexpr double in_front_m = 6e-3;  // of the surface: start and end of a press

}  // namespace

void MainWindow::lead_hand_by_mouse() {
  connect(views_, &SceneViews::hold_began, this, &MainWindow::touch_began);
  connect(views_, &SceneViews::hold_moved, this, [this](const Vec3& at_m, const Vec3& away, double depth_m) {
    led_away_ = away;
    if (mouse_leads_) touch_.lead_hand(at_m + depth_m * away - foremost_lever_m(away));
  });
  connect(views_, &SceneViews::tool_turned, this, [this](const Vec3& rotation_rad) { touch_.turn_hand(rotation_rad); });
  connect(views_, &SceneViews::hold_ended, this, [this](const Vec3& away) {
    mouse_leads_ = false;
    if (norm(away) == 0.0) return;
    // After a long drawing press and release come at once: the last tick is then of the hand before.
    const Moment& moment = touch_.moment();
    touch_.lead_hand(moment.tick >= put_from_tick_ ? moment.proxy_m - in_front_m * away : put_at_m_);
  });
  View3D* view = views_->view();
  if (!view) return;
  connect(view, &View3D::draws, this, [this](bool on) { touch_.draws(on); });
  connect(view, &View3D::turned, this, [this, view] {
    const detail::View& seen = view->view();
    touch_.turn_view(transposed(Mat3{{seen.right, seen.up, seen.towards}}));  // a device's right to the screen's right
  });
}

Vec3 MainWindow::foremost_lever_m(const Vec3& away) {
  constexpr double same_m = 1e-6;
  const Tool tool(document_.scene().tool_of(touch_.led()), document_.scene().coupling());
  if (tool.is_point() || norm(away) == 0.0) return {};
  const Turn turn = touch_.moment().probe_turn;
  double furthest_m = -tool.reach_m();
  for (std::size_t foot = 0; foot < tool.feet(); ++foot) furthest_m = std::max(furthest_m, dot(tool.lever_m(turn, foot), away));
  Vec3 sum_m;
  double count = 0.0;
  for (std::size_t foot = 0; foot < tool.feet(); ++foot) {
    const Vec3 lever_m = tool.lever_m(turn, foot);
    if (dot(lever_m, away) < furthest_m - same_m) continue;
    sum_m += lever_m;
    count += 1.0;
  }
  return sum_m / count;
}

void MainWindow::touch_began(const Vec3& at_m, const Vec3& away) {
  if (player_->has_trace()) return say(tr("A trace is open: Escape leaves it and returns to your own hand."));
  mouse_leads_ = true;
  hint_followed_ = true;
  // Far away: jump without contacts on the way; near: slide.
  const Vec3 front_m = at_m - in_front_m * away - foremost_lever_m(away);
  if (distance(touch_.led_to_m(), front_m) <= 2.0 * in_front_m) return;
  put_at_m_ = front_m;
  put_from_tick_ = touch_.moment().tick + 2 * ticks_per_moment;
  touch_.put_hand(front_m);
  views_->forget_trail();
}

Vec3 MainWindow::before_surface_m() { return touch_.moment().proxy_m - in_front_m * led_away_; }

bool MainWindow::has_tool() const { return document_.scene().tool_of(touch_.led()).shape != ToolOptions::Shape::point; }

void MainWindow::make_hand_box() {
  hand_box_ = new QComboBox;
  hand_box_->setObjectName("hand");
  hand_box_->setAccessibleName(tr("Hand that the mouse leads"));
  hand_box_->setToolTip(tr("The mouse leads this hand; the others stay where they are (H)"));
  connect(hand_box_, qOverload<int>(&QComboBox::activated), this, &MainWindow::lead_hand);
}

void MainWindow::list_hands(const Scene& scene) {
  hand_box_->clear();
  for (const SceneHand& hand : scene.hands()) hand_box_->addItem(QString::fromStdString(hand.name));
  const bool has_several = scene.hands().size() > 1;
  hand_box_action_->setVisible(has_several);
  next_hand_->setVisible(has_several);
  feel_->show_tool_of(0);
}

void MainWindow::lead_hand(int number) {
  hand_box_->setCurrentIndex(static_cast<int>(touch_.led()));
  if (!document_.is_open() || touch_.hands() < 2) return;
  const bool plays = player_->has_trace();
  if (plays && replay_->hands() < 2) return say(tr("A trace is open: Escape leaves it and returns to your own hands."));
  const std::size_t hand = static_cast<std::size_t>(number) % touch_.hands();
  mouse_leads_ = false;
  put_from_tick_ = 0;
  touch_.lead(hand);
  views_->lead(hand);
  feel_->show_tool_of(hand);
  start_curves();
  hand_box_->setCurrentIndex(static_cast<int>(hand));
  if (plays) replay_->lead(hand);
}

}  // namespace palpa::explorer
