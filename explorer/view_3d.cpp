#include "explorer/view_3d.h"

#include <vtkCamera.h>
#include <vtkGPUVolumeRayCastMapper.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkPlane.h>
#include <vtkProp.h>
#include <vtkRenderer.h>
#include <vtkVolume.h>

#include <QKeyEvent>
#include <QMouseEvent>
#include <QPainter>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "explorer/picture_file.h"
#include "palpa/view/shapes.h"

namespace palpa::explorer {
namespace {

constexpr double first_depth_m = 1e-3;     // initial, of a press. Deeper: the first touch is a blow; less: not felt
constexpr double deepest_m = 0.05;         // largest, of a press
constexpr int still_after_ms = 250;        // from the last motion to the fine picture
constexpr int hover_after_ms = 30;         // from the cursor's motion to its cue. Shorter: a ray for each event
constexpr double near_stream_px = 80.0;    // within which a touch takes the depth of a streamline
constexpr double one_stream_px = 6.0;      // between points of one streamline: of these, the front one
constexpr float coarse_image_step = 3.0F;  // [pixels] between rays of a moving cloud

constexpr Vec3 from_front = {0.35, 0.25, 1.0};

}  // namespace

/// Overlay over VTK's picture.
class View3D::Overlay : public QWidget {
 public:
  explicit Overlay(View3D* view) : QWidget(view), view_(*view) {
    setAttribute(Qt::WA_TransparentForMouseEvents);
    setAttribute(Qt::WA_NoSystemBackground);
  }

 protected:
  void paintEvent(QPaintEvent*) override {
    QPainter painter(this);
    painter.setRenderHint(QPainter::Antialiasing);
    Texts texts(painter);
    const QColor ink = view_.dark_ ? QColor(235, 235, 235) : QColor(25, 25, 30);
    const QColor ground = view_.dark_ ? QColor(20, 20, 24, 210) : QColor(255, 255, 255, 220);
    if (view_.stereo_ == Stereo::side_by_side) {
      for (const double side : {0.0, 0.5}) {
        painter.save();
        painter.setClipRect(QRectF(side * width(), 0, 0.5 * width(), height()));
        painter.translate(side * width(), 0);
        painter.scale(0.5, 1.0);
        touch(painter);
        painter.restore();
      }
    } else {
      touch(painter);
    }
    // In the middle, or as near to it as what stands at the right allows.
    const auto paint_line = [&](const QString& words, double y_px, Qt::Alignment side, const QColor& color, const QColor& card,
                                double taken_px) {
      if (words.isEmpty()) return;
      const double room_px = std::max(0.5 * width(), width() - taken_px - 24.0);
      const double half_px = 0.5 * std::min(room_px, painter.fontMetrics().horizontalAdvance(words) + 12.0);
      texts.paint_card({std::min(0.5 * width(), room_px + 12.0 - half_px), y_px}, words, side, color, card, room_px);
    };
    paint_line(view_.top_, top_px, Qt::AlignTop, Qt::white, QColor(176, 42, 20, 235), view_.legend_px());
    paint_line(view_.bottom_, height() - bottom_px, Qt::AlignBottom, ink, ground, axes_px);
    if (view_.marks_) {
      paint_explanations(texts, QRect(width() - 260, 24, 260, height() - 48), view_.drawing_.signs.legend,
                         view_.drawing_.signs.bars, ink, ground);
      paint_scale_bar(texts, view_.view_, view_.world_per_hand_, ink);
      paint_directions(texts, view_.view_, view_.axes_, view_.medical_, ink);
      paint_axes(painter, view_.view_, QPointF(width() - 52, height() - 52), view_.axes_, view_.medical_, ink);
    }
    if (view_.stereo_ != Stereo::side_by_side) paint_force(texts, view_.view_, view_.moment_, ink, ground);
    view_.texts_ = texts.shown();
  }

 private:
  static constexpr double axes_px = 92.0;    // of the right edge
  static constexpr double top_px = 46.0;     // below the name of the direction
  static constexpr double bottom_px = 40.0;  // above the scale
  void touch(QPainter& painter) {
    paint_streamlines(painter, view_.view_, view_.streamlines_);
    paint_trail(painter, view_.view_, view_.trail_, view_.most_n_);
    paint_hands(painter, view_.view_, view_.hands_, view_.most_n_);
    if (view_.other_) {
      painter.setOpacity(0.5);
      paint_moment(painter, view_.view_, *view_.other_, view_.most_n_);
      paint_tool(painter, view_.view_, view_.tool_, *view_.other_);
      painter.setOpacity(1.0);
    }
    if (view_.ghost_m_) paint_ghost(painter, view_.view_, *view_.ghost_m_);
    paint_moment(painter, view_.view_, view_.moment_, view_.most_n_);
    paint_tool(painter, view_.view_, view_.tool_, view_.moment_);
  }
  View3D& view_;
};

View3D::View3D(QWidget* parent) : QVTKOpenGLNativeWidget(parent), overlay_(new Overlay(this)) {
  window_->SetMultiSamples(0);
  setRenderWindow(window_);
  window_->SetNumberOfLayers(2);
  int number = 0;
  for (vtkRenderer* renderer : {solid_.Get(), shells_.Get()}) {
    renderer->SetLayer(number++);
    detail::add_light(renderer);
    window_->AddRenderer(renderer);
  }
  shells_->PreserveDepthBufferOn();
  shells_->SetActiveCamera(solid_->GetActiveCamera());
  set_dark(false);
  setEnableHiDPI(true);
  setFocusPolicy(Qt::StrongFocus);
  setMouseTracking(true);
  setMinimumSize(240, 180);
  setAccessibleName(tr("Scene in three dimensions"));
  setAccessibleDescription(tr("Drag on the surface to touch it, elsewhere to turn the view; the wheel presses or zooms."));
  still_.setSingleShot(true);
  still_.setInterval(still_after_ms);
  connect(&still_, &QTimer::timeout, this, [this] { move_ends(); });
  hover_.setSingleShot(true);
  hover_.setInterval(hover_after_ms);
  connect(&hover_, &QTimer::timeout, this, &View3D::show_hover);
}

View3D::~View3D() = default;

void View3D::start(const Scene& scene) {
  is_cut_ = false;
  show_drawing({}, scene);
  moment_ = {};
  trail_.clear();
  hands_.clear();
  streamlines_.clear();
  hidden_.clear();
  other_.reset();
  ghost_m_.reset();
  by_keys_ = false;
  setFocus();  // keys touch and turn at once
  Vec3 from = from_front;
  if (scene.view.from) from = scene.hand_to_world().direction_to_hand(*scene.view.from);
  const Vec3 up = norm(cross(normalized(from), {0, 1, 0})) > 1e-3 ? Vec3{0, 1, 0} : Vec3{0, 0, -1};
  look_from(from, up);
}

void View3D::show_drawing(Drawing drawing, const Scene& scene) {
  for (const auto& part : drawing_.solid) {
    solid_->RemoveViewProp(part.fine);
    if (part.coarse) solid_->RemoveViewProp(part.coarse);
  }
  for (const auto& part : drawing_.shells) {
    shells_->RemoveViewProp(part.fine);
    if (part.coarse) shells_->RemoveViewProp(part.coarse);
  }
  const bool first = !(largest_component(drawing_.bounds_m.size_m()) > 0.0);
  drawing_ = std::move(drawing);
  for (const auto& part : drawing_.solid) {
    solid_->AddViewProp(part.fine);
    if (part.coarse) solid_->AddViewProp(part.coarse);
  }
  for (const auto& part : drawing_.shells) {
    shells_->AddViewProp(part.fine);
    if (part.coarse) shells_->AddViewProp(part.coarse);
  }
  const Similarity map = scene.hand_to_world();
  axes_ = {map.direction_to_hand({1, 0, 0}), map.direction_to_hand({0, 1, 0}), map.direction_to_hand({0, 0, 1})};
  world_per_hand_ = map.scale;
  medical_ = std::any_of(scene.volumes().begin(), scene.volumes().end(),
                         [](const SceneVolume& volume) { return volume.volume.medical_frame; });
  finder_ = SurfaceFinder(scene);
  for (const detail::Shell& shell : drawing_.fine_shells) detail::shade(shell, view_.towards);
  cut_parts();
  show_parts(false);
  if (first) show_all();
  redraw();
}

void View3D::show_touch(const Moment& moment, std::vector<TrailPoint> trail, double most_n) {
  const bool seen = moment.looks_like(moment_) && trail.size() == trail_.size() && most_n == most_n_;
  moment_ = moment;
  trail_ = std::move(trail);
  most_n_ = most_n;
  if (!seen) overlay_->update();
}

void View3D::show_hands(std::vector<SeenHand> others) {
  const bool seen = look_alike(others, hands_);
  hands_ = std::move(others);
  if (!seen) overlay_->update();
}

void View3D::set_tool(const Tool& tool) {
  tool_ = tool;
  overlay_->update();
}

void View3D::show_streamlines(std::vector<detail::Streamline> lines) {
  streamlines_ = std::move(lines);
  overlay_->update();
}

void View3D::show_words(const QString& top, const QString& bottom) {
  if (top == top_ && bottom == bottom_) return;
  top_ = top;
  bottom_ = bottom;
  overlay_->update();
}

void View3D::show_marks(bool shown) {
  marks_ = shown;
  overlay_->update();
}

void View3D::look_from(const Vec3& from, const Vec3& up) {
  view_.towards = normalized(from);
  view_.right = normalized(cross(up, view_.towards));
  view_.up = cross(view_.towards, view_.right);
  move_ends();
  Q_EMIT turned();
}

double View3D::legend_px() const {
  return marks_ ? width_of_explanations(font(), drawing_.signs.legend, drawing_.signs.bars) : 0.0;
}

void View3D::show_all() {
  const Box& box = drawing_.bounds_m;
  const Vec3 size = box.size_m();
  if (!(largest_component(size) > 0.0)) return;
  view_.centre_m = box.centre_m();
  const auto extent = [&](const Vec3& axis) {
    return std::abs(axis.x) * size.x + std::abs(axis.y) * size.y + std::abs(axis.z) * size.z;
  };
  const double beside_px = std::min(legend_px(), 0.35 * width());
  const double aspect = std::max(1.0, width() - beside_px) / std::max(1, height());
  view_.half_height_m = 0.57 * std::max(extent(view_.up), extent(view_.right) / aspect);
  view_.centre_m += (0.5 * beside_px / view_.px_per_m()) * view_.right;
  redraw();
}

void View3D::zoom(double factor) {
  view_.half_height_m = std::clamp(view_.half_height_m / factor, 1e-4, 10.0);
  move_begins();
  redraw();
}

void View3D::turn(double right_deg, double up_deg) {
  const double a = right_deg * M_PI / 180.0, b = up_deg * M_PI / 180.0;
  // Turntable: about the hand frame's y and the picture's right, so up stays up.
  const Vec3 y{0, 1, 0};
  const auto about = [](const Vec3& axis, double angle, const Vec3& v) {
    return std::cos(angle) * v + std::sin(angle) * cross(axis, v) + (1.0 - std::cos(angle)) * dot(axis, v) * axis;
  };
  Vec3 towards = about(y, -a, view_.towards), right = about(y, -a, view_.right);
  const Vec3 tilted = about(right, -b, towards);
  if (std::abs(tilted.y) < 0.995) towards = tilted;
  view_.towards = normalized(towards);
  view_.right = normalized(right - dot(right, view_.towards) * view_.towards);
  view_.up = cross(view_.towards, view_.right);
  move_begins();
  redraw();
  Q_EMIT turned();
}

void View3D::set_stereo(Stereo stereo) {
  stereo_ = stereo;
  window_->SetStereoRender(stereo == Stereo::off ? 0 : 1);
  if (stereo == Stereo::anaglyph) window_->SetStereoTypeToAnaglyph();
  if (stereo == Stereo::side_by_side) window_->SetStereoTypeToSplitViewportHorizontal();
  redraw();
}

void View3D::set_dark(bool dark) {
  dark_ = dark;
  color_ground(dark ? detail::Color{0.11, 0.11, 0.125} : detail::ground_color);
}

void View3D::color_ground(const detail::Color& color) {
  solid_->SetBackground(color.red, color.green, color.blue);
  redraw();
}

QImage View3D::picture(const QSize& size, Ground ground) {
  const QString top = std::exchange(top_, {}), bottom = std::exchange(bottom_, {});  // of the moment, not of the data
  const QRect own = geometry();
  const detail::View view = view_;
  const bool is_resized = !size.isEmpty() && size != own.size();
  if (is_resized) {
    resize(size);
    redraw();
  }
  // Where VTK draws translucent surfaces, the picture of the widget is transparent: alpha comes from two grounds.
  const auto grabbed = [this] { return grab().toImage().convertToFormat(QImage::Format_RGB32); };
  QImage picture;
  if (ground == Ground::transparent) {
    color_ground({0.0, 0.0, 0.0});
    const QImage on_black = grabbed();
    color_ground({1.0, 1.0, 1.0});
    picture = with_alpha(on_black, grabbed());
    set_dark(dark_);
  } else {
    picture = grabbed();
  }
  if (is_resized) {
    setGeometry(own);
    view_ = view;
    redraw();
  }
  show_words(top, bottom);
  return picture;
}

void View3D::set_turning(bool on) {
  turning_ = on;
  show_hover();
}

void View3D::hide_layers(const std::set<std::size_t>& hidden) {
  if (hidden == hidden_) return;
  hidden_ = hidden;
  show_parts(coarse_);
  redraw();
}

void View3D::show_other(const std::optional<Moment>& other) {
  if (!other && !other_) return;
  other_ = other;
  overlay_->update();
}

Vec3 View3D::at_m(const QPointF& px) const {
  const double per_px = 1.0 / view_.px_per_m();
  return view_.centre_m + (px.x() - 0.5 * view_.width_px) * per_px * view_.right +
         (0.5 * view_.height_px - px.y()) * per_px * view_.up;
}

std::optional<SurfacePoint> View3D::surface_at(const QPointF& px) const {
  // From in front of all data.
  const double far_m = 2.0 * norm(drawing_.bounds_m.size_m()) + distance(view_.centre_m, drawing_.bounds_m.centre_m());
  const auto met = finder_.first(start_behind_cut(at_m(px) + far_m * view_.towards), -view_.towards);
  return met && is_left(met->at_m) ? met : std::nullopt;
}

double View3D::flow_depth_m(const QPointF& px) const {
  const auto away_px = [&](const Vec3& point_m) {
    const QPointF way = on_screen(view_, point_m) - px;
    return std::hypot(way.x(), way.y());
  };
  double nearest_px = near_stream_px;
  for (const Vec3& point_m : drawing_.stream_points_m) nearest_px = std::min(nearest_px, away_px(point_m));
  if (nearest_px == near_stream_px) return dot(view_.centre_m - cross_m_, view_.towards);
  double depth_m = std::numeric_limits<double>::infinity();
  for (const Vec3& point_m : drawing_.stream_points_m)
    if (away_px(point_m) <= nearest_px + one_stream_px)
      depth_m = std::min(depth_m, dot(view_.centre_m - point_m, view_.towards));
  return depth_m;
}

std::optional<View3D::Target> View3D::target_at(const QPointF& px) const {
  if (turning_) return {};
  if (const auto surface = surface_at(px)) return Target{surface->at_m, surface->into, true};
  if (finder_.has_surfaces()) return {};
  return Target{at_m(px) - flow_depth_m(px) * view_.towards, -view_.towards, false};
}

void View3D::begin_touch(const Target& target) {
  depth_m_ = target.on_surface ? first_depth_m : 0.0;
  plane_depth_m_ = dot(view_.centre_m - target.at_m, view_.towards);
  Q_EMIT hold_began(target.at_m, target.into);
  lead(last_px_);
}

void View3D::press_deeper(double notches) {
  // Finer steps for a light press.
  depth_m_ = std::clamp(depth_m_ + notches * (4e-4 + 0.15 * std::abs(depth_m_)), -deepest_m, deepest_m);
  lead(last_px_);
}

void View3D::lead(const QPointF& px) {
  if (const auto surface = surface_at(px)) {
    plane_depth_m_ = dot(view_.centre_m - surface->at_m, view_.towards);
    into_ = surface->into;
    Q_EMIT hold_moved(surface->at_m, into_, depth_m_);
  } else {
    into_ = -view_.towards;
    Q_EMIT hold_moved(at_m(px) - plane_depth_m_ * view_.towards, into_, depth_m_);
  }
}

void View3D::show_hover() {
  const auto before_m = ghost_m_;
  ghost_m_.reset();
  if (drag_ == Drag::none && underMouse()) {
    const auto target = target_at(last_px_);
    if (target) ghost_m_ = target->at_m;
    setCursor(target ? Qt::PointingHandCursor : Qt::OpenHandCursor);
    if (target)
      Q_EMIT pointed(target->at_m);
    else
      Q_EMIT pointed_nowhere();
  }
  if (ghost_m_ != before_m) overlay_->update();
}

void View3D::mousePressEvent(QMouseEvent* event) {
  end_touch_by_keys();
  last_px_ = event->localPos();
  const bool shifted = (event->modifiers() & Qt::ShiftModifier) != 0;
  if (event->button() == Qt::MiddleButton || (event->button() == Qt::LeftButton && shifted)) {
    drag_ = Drag::move;
  } else if (event->button() == Qt::LeftButton && is_of_tool(event->modifiers())) {
    drag_ = Drag::tool;
  } else if (event->button() == Qt::LeftButton && !(event->modifiers() & Qt::AltModifier)) {
    if (const auto target = target_at(last_px_)) {
      drag_ = Drag::touch;
      begin_touch(*target);
    } else {
      drag_ = Drag::turn;
    }
  } else if (event->button() == Qt::RightButton || event->button() == Qt::LeftButton) {
    drag_ = Drag::turn;
  }
  ghost_m_.reset();
  overlay_->update();
  setCursor(drag_ == Drag::touch ? Qt::CrossCursor : drag_ == Drag::move ? Qt::SizeAllCursor : Qt::ClosedHandCursor);
}

void View3D::mouseMoveEvent(QMouseEvent* event) {
  if (by_keys_) return;
  const QPointF way = event->localPos() - last_px_;
  last_px_ = event->localPos();
  switch (drag_) {
    case Drag::none:
      if (!hover_.isActive()) hover_.start();
      break;
    case Drag::touch:
      if (is_of_tool(event->modifiers())) return turn_tool(way);
      lead(last_px_);
      Q_EMIT pointed(moment_.proxy_m);
      break;
    case Drag::tool: turn_tool(way); break;
    case Drag::turn: turn(degrees_per_px * way.x(), degrees_per_px * way.y()); break;
    case Drag::move:
      view_.centre_m += (-way.x() / view_.px_per_m()) * view_.right + (way.y() / view_.px_per_m()) * view_.up;
      move_begins();
      redraw();
      break;
  }
}

void View3D::mouseReleaseEvent(QMouseEvent*) {
  if (drag_ == Drag::touch) Q_EMIT hold_ended(into_);
  drag_ = Drag::none;
  unsetCursor();
  hover_.start();
}

void View3D::mouseDoubleClickEvent(QMouseEvent* event) {
  if (event->button() == Qt::LeftButton) Q_EMIT enlarge_asked();
}

void View3D::leaveEvent(QEvent* event) {
  QVTKOpenGLNativeWidget::leaveEvent(event);
  if (ghost_m_) overlay_->update();
  ghost_m_.reset();
  Q_EMIT pointed_nowhere();
}

void View3D::wheelEvent(QWheelEvent* event) {
  const double notches = event->angleDelta().y() / 120.0;
  if (is_of_tool(event->modifiers())) {
    roll_tool(notches);
  } else if (drag_ == Drag::touch) {
    press_deeper(notches);
  } else {
    zoom(std::pow(1.15, notches));
  }
  event->accept();
}

void View3D::resizeEvent(QResizeEvent* event) {
  QVTKOpenGLNativeWidget::resizeEvent(event);
  view_.width_px = width();
  view_.height_px = height();
  overlay_->resize(size());
  still_.start();
}

bool View3D::event(QEvent* event) {
  if (event->type() == QEvent::ShortcutOverride && takes_shortcut(static_cast<const QKeyEvent&>(*event))) {
    event->accept();
    return true;
  }
  // Keep mouse and keys from VTK's own interactor.
  switch (event->type()) {
    case QEvent::KeyPress:
    case QEvent::KeyRelease:
    case QEvent::MouseButtonPress:
    case QEvent::MouseButtonRelease:
    case QEvent::MouseButtonDblClick:
    case QEvent::MouseMove:
    case QEvent::Wheel: return QOpenGLWidget::event(event);
    default: return QVTKOpenGLNativeWidget::event(event);
  }
}

void View3D::paintGL() {
  Q_EMIT draws(true);
  QVTKOpenGLNativeWidget::paintGL();
  Q_EMIT draws(false);
}

bool View3D::is_slow() {
  if (!is_slow_) {
    const char* capabilities = window_->ReportCapabilities();
    const std::string words = capabilities ? capabilities : "";
    is_slow_ = words.find("llvmpipe") != words.npos || words.find("softpipe") != words.npos;
  }
  return *is_slow_;
}

void View3D::move_begins() {
  if (!is_slow()) {
    for (const detail::Shell& shell : drawing_.fine_shells) detail::shade(shell, view_.towards);
    return;
  }
  if (!coarse_) show_parts(true);
  for (CoarseSurface& surface : drawing_.coarse_surfaces) surface.light(view_.right, view_.up, view_.towards);
  still_.start();
}

void View3D::move_ends() {
  for (const detail::Shell& shell : drawing_.fine_shells) detail::shade(shell, view_.towards);
  cut_parts();
  show_parts(false);
  redraw();
}

void View3D::show_parts(bool coarse) {
  coarse_ = coarse;
  for (const auto* parts : {&drawing_.solid, &drawing_.shells}) {
    for (const Drawing::Part& part : *parts) {
      const bool shown = !hidden_.contains(part.layer);
      part.fine->SetVisibility(shown && (!coarse || !part.coarse));
      if (part.coarse) part.coarse->SetVisibility(shown && coarse);
    }
  }
  for (const auto& cloud : drawing_.clouds) {
    if (auto* mapper = vtkGPUVolumeRayCastMapper::SafeDownCast(cloud->GetMapper())) {
      mapper->SetAutoAdjustSampleDistances(0);
      mapper->SetImageSampleDistance(coarse ? coarse_image_step : 1.0F);
    }
  }
}

void View3D::apply_camera() {
  const double reach_m = 4.0 * std::max(norm(drawing_.bounds_m.size_m()), view_.half_height_m) +
                         distance(view_.centre_m, drawing_.bounds_m.centre_m());
  vtkCamera& camera = *solid_->GetActiveCamera();
  const Vec3 eye = view_.centre_m + reach_m * view_.towards;
  // Stereo needs perspective.
  camera.SetParallelProjection(stereo_ == Stereo::off);
  if (stereo_ != Stereo::off) {
    const double away_m = view_.half_height_m / std::tan(15.0 * M_PI / 180.0);
    const Vec3 near_eye = view_.centre_m + away_m * view_.towards;
    camera.SetViewAngle(30.0);
    camera.SetPosition(near_eye.x, near_eye.y, near_eye.z);
    camera.SetFocalPoint(view_.centre_m.x, view_.centre_m.y, view_.centre_m.z);
    camera.SetViewUp(view_.up.x, view_.up.y, view_.up.z);
    camera.SetClippingRange(0.05 * away_m, away_m + 2.0 * reach_m);
    return;
  }
  camera.SetFocalPoint(view_.centre_m.x, view_.centre_m.y, view_.centre_m.z);
  camera.SetPosition(eye.x, eye.y, eye.z);
  camera.SetViewUp(view_.up.x, view_.up.y, view_.up.z);
  camera.SetParallelScale(view_.half_height_m);
  camera.SetClippingRange(0.01 * reach_m, 2.0 * reach_m);
}

void View3D::redraw() {
  apply_camera();
  // The widget shows VTK's last rendering.
  if (isVisible()) {
    Q_EMIT draws(true);
    window_->Render();
    Q_EMIT draws(false);
  }
  update();
  overlay_->update();
}

}  // namespace palpa::explorer
