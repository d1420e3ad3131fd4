// The scene in three dimensions: layers drawn by VTK, what is felt painted over them, the mouse as a hand.
#pragma once

#include <QVTKOpenGLNativeWidget.h>
#include <vtkNew.h>

#include <QTimer>
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "explorer/drawing.h"
#include "explorer/paint.h"
#include "explorer/surface_finder.h"

class vtkGenericOpenGLRenderWindow;
class vtkRenderer;

namespace palpa::explorer {

/// Left drag on a surface touches it, elsewhere it turns the view, as the right button does anywhere; the middle button moves
/// the view; the wheel presses while something is touched, else it zooms. All sizes are in the hand frame.
class View3D : public QVTKOpenGLNativeWidget {
  Q_OBJECT
 public:
  explicit View3D(QWidget* parent = nullptr);
  ~View3D() override;

  /// Forgets the layers of another scene, and looks at all of the data, from where the scene says.
  void start(const Scene& scene);
  /// Shows these layers in place of those before.
  void show_drawing(Drawing drawing, const Scene& scene);
  const Drawing& drawing() const { return drawing_; }
  /// What is felt. \param trail  oldest first
  void show_touch(const Moment& moment, std::vector<TrailPoint> trail, double most_n);
  /// The flow near the proxy, hand frame.
  void show_streamlines(std::vector<detail::Streamline> lines);
  /// Words over the picture, at its top (a fault) and its bottom (a hint); empty: none.
  void show_words(const QString& top, const QString& bottom);
  void show_marks(bool shown);
  bool shows_marks() const { return marks_; }

  const detail::View& view() const { return view_; }
  /// The data seen from a direction of the hand frame. \param from  [1]  \param up  [1]
  void look_from(const Vec3& from, const Vec3& up);
  void show_all();
  void zoom(double factor);
  void turn(double right_deg, double up_deg);
  /// Off: flat; else red-cyan or side by side.
  enum class Stereo { off, anaglyph, side_by_side };
  void set_stereo(Stereo stereo);
  Stereo stereo() const { return stereo_; }
  void set_dark(bool dark);
  /// [s] that the last picture took.
  double frame_s() const { return frame_s_; }
  /// The picture with all that is painted over it.
  QImage picture();

 Q_SIGNALS:
  /// The mouse has taken hold of the surface here. \param at_m  hand frame  \param away  [1] into the screen
  void hold_began(palpa::Vec3 at_m, palpa::Vec3 away);
  /// It leads the hand to this place of the surface, pressed in by the depth [m].
  void hold_moved(palpa::Vec3 at_m, palpa::Vec3 away, double depth_m);
  void hold_ended(palpa::Vec3 away);
  void turned();
  void frame_drawn(double frame_s);

 protected:
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;
  void resizeEvent(QResizeEvent* event) override;
  void paintGL() override;
  bool event(QEvent* event) override;

 private:
  class Overlay;
  enum class Drag { none, touch, turn, move };
  Vec3 at_m(const QPointF& px) const;
  std::optional<Vec3> surface_at(const QPointF& px) const;
  void lead(const QPointF& px);
  void apply_camera();
  /// Whether a processor draws, no graphics card: what moves is then drawn coarser.
  bool is_slow();
  void move_begins();
  void move_ends();
  void show_parts(bool coarse);
  void redraw();

  vtkNew<vtkGenericOpenGLRenderWindow> window_;
  vtkNew<vtkRenderer> solid_, shells_;
  Drawing drawing_;
  Overlay* overlay_;
  SurfaceFinder finder_;
  detail::View view_;
  QTimer still_;
  std::array<Vec3, 3> axes_{};
  bool medical_ = false;
  double world_per_hand_ = 1.0;
  double depth_m_ = 0.0;
  double plane_depth_m_ = 0.0;  // of the hand, where there is no surface, from the view's centre away
  Moment moment_;
  std::vector<TrailPoint> trail_;
  std::vector<detail::Streamline> streamlines_;
  double most_n_ = 1.0;
  QString top_, bottom_;
  bool marks_ = true, coarse_ = false, dark_ = false;
  Stereo stereo_ = Stereo::off;
  Drag drag_ = Drag::none;
  QPointF last_px_;
  double frame_s_ = 0.0;
  std::optional<bool> is_slow_;
};

}  // namespace palpa::explorer
