// Touch by the keys alone.
#include <QKeyEvent>
#include <cmath>
#include <optional>

#include "explorer/view_3d.h"

namespace palpa::explorer {
namespace {

constexpr double key_step_px = 4.0;      // of an arrow key. Longer: the hand jumps; shorter: a way takes many presses
constexpr double search_step_px = 18.0;  // between positions on the way from the middle to the nearest surface

/// [1] way of an arrow key on the screen.
std::optional<QPointF> way_of(int key) {
  switch (key) {
    case Qt::Key_Left: return QPointF(-1.0, 0.0);
    case Qt::Key_Right: return QPointF(1.0, 0.0);
    case Qt::Key_Up: return QPointF(0.0, -1.0);
    case Qt::Key_Down: return QPointF(0.0, 1.0);
    default: return {};
  }
}

}  // namespace

std::optional<QPointF> View3D::nearest_target_px() const {
  const QPointF middle(0.5 * width(), 0.5 * height());
  const int rings = static_cast<int>(0.5 * std::hypot(width(), height()) / search_step_px);
  for (int ring = 0; ring <= rings; ++ring) {
    const int sides = std::max(1, 8 * ring);
    for (int side = 0; side < sides; ++side) {
      const double angle = 2.0 * M_PI * side / sides, away_px = search_step_px * ring;
      const QPointF px = middle + away_px * QPointF(std::cos(angle), std::sin(angle));
      if (rect().contains(px.toPoint()) && target_at(px)) return px;
    }
  }
  return {};
}

bool View3D::lead_by_key(int key) {
  if (key == Qt::Key_Return || key == Qt::Key_Enter) {
    if (by_keys_) return end_touch_by_keys(), true;
    const auto px = drag_ == Drag::none ? nearest_target_px() : std::nullopt;
    if (!px) return false;
    by_keys_ = true;
    last_px_ = *px;
    begin_touch(*target_at(*px));
    return true;
  }
  if (!by_keys_) return false;
  if (const auto way = way_of(key)) {
    last_px_ += key_step_px * *way;
    lead(last_px_);
  } else if (key == Qt::Key_PageDown || key == Qt::Key_PageUp) {
    press_deeper(key == Qt::Key_PageDown ? 1.0 : -1.0);
  } else {
    return false;
  }
  Q_EMIT pointed(moment_.proxy_m);
  return true;
}

void View3D::end_touch_by_keys() {
  if (!by_keys_) return;
  by_keys_ = false;
  Q_EMIT hold_ended(into_);
}

void View3D::keyPressEvent(QKeyEvent* event) {
  if (!lead_by_key(event->key())) QWidget::keyPressEvent(event);
}

void View3D::focusOutEvent(QFocusEvent* event) {
  end_touch_by_keys();
  QVTKOpenGLNativeWidget::focusOutEvent(event);
}

// During a touch by keys the arrows lead it instead of turning the view.
bool View3D::takes_shortcut(const QKeyEvent& event) const { return by_keys_ && way_of(event.key()); }

}  // namespace palpa::explorer
