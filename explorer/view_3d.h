// 3-D view of the scene: layers drawn by VTK, hand and forces painted over them, mouse input.
#pragma once

#include <QVTKOpenGLNativeWidget.h>
#include <vtkNew.h>

#include <QTimer>
#include <array>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "explorer/drawing.h"
#include "explorer/paint.h"
#include "explorer/surface_finder.h"

class vtkGenericOpenGLRenderWindow;
class vtkPlane;
class vtkRenderer;

namespace palpa::explorer {

/// Left drag on a surface touches it, elsewhere turns the view, like the right button anywhere; without surfaces (a flow) it
/// touches at the depth of the nearest streamline or of the cross. Cursor and a pale ball show which. Middle button: pan;
/// wheel: presses along the surface's normal during a touch, else zooms; double click: `enlarge_asked`; keys: `lead_by_key`.
/// Ctrl and drag turns the tool in the hand, also during a touch, Ctrl and wheel about the line of sight. All lengths are in
/// the hand frame.
class View3D : public QVTKOpenGLNativeWidget {
  Q_OBJECT
 public:
  explicit View3D(QWidget* parent = nullptr);
  ~View3D() override;

  /// Resets the layers for a new scene and shows all data from the scene's viewpoint.
  void start(const Scene& scene);
  /// Replaces the layers.
  void show_drawing(Drawing drawing, const Scene& scene);
  const Drawing& drawing() const { return drawing_; }
  /// Sets the led hand, its forces and trail. \param trail  oldest first
  void show_touch(const Moment& moment, std::vector<TrailPoint> trail, double most_n);
  /// Sets the scene's other hands.
  void show_hands(std::vector<SeenHand> others);
  /// Sets the led hand's tool, whose feet are drawn with the hand. Of one that is no point a drag with Ctrl turns the hand.
  void set_tool(const Tool& tool);
  /// Flow near the proxy, hand frame.
  void show_streamlines(std::vector<detail::Streamline> lines);
  /// Sets the position whose depth a touch takes where there is no streamline.
  void set_cross(const Vec3& at_m) { cross_m_ = at_m; }
  /// Sets whether a left drag turns the view everywhere.
  void set_turning(bool on);
  /// Hides layers, by their indices in the scene's.
  void hide_layers(const std::set<std::size_t>& hidden);
  /// Second trace's moment, drawn paler; none: not drawn.
  void show_other(const std::optional<Moment>& other);
  /// Text at the top (a fault) and at the bottom (a hint); empty: none.
  void show_words(const QString& top, const QString& bottom);
  const QString& fault() const { return top_; }
  const QString& hint() const { return bottom_; }
  /// Texts of the last picture, without legend and axes.
  const std::vector<PlacedText>& texts() const { return texts_; }
  void show_marks(bool shown);
  bool shows_marks() const { return marks_; }

  const detail::View& view() const { return view_; }
  /// Sets the viewing direction, hand frame. \param from  [1]  \param up  [1]
  void look_from(const Vec3& from, const Vec3& up);
  void show_all();
  void zoom(double factor);
  void turn(double right_deg, double up_deg);
  /// Off: flat; else red-cyan or side by side.
  enum class Stereo { off, anaglyph, side_by_side };
  void set_stereo(Stereo stereo);
  Stereo stereo() const { return stereo_; }
  void set_dark(bool dark);
  /// Hides what is in front of the slice that faces the viewer most; there is nothing to touch then. The cut stays where it
  /// is while the view turns.
  void set_cut(bool on);
  bool is_cut() const { return is_cut_; }
  /// Moves the cut to this place, hand frame [m].
  void move_cut(const Vec3& at_m);
  enum class Ground { own, transparent };
  /// Picture including the overlay, without fault and hint. \param size  [pixels]; empty: the widget's
  QImage picture(const QSize& size = {}, Ground ground = Ground::own);
  /// Where a press would touch; none: it would turn the view.
  struct Target {
    Vec3 at_m;
    Vec3 into;  ///< [1] unit vector of a press
    bool on_surface;
  };
  std::optional<Target> target_at(const QPointF& px) const;
  bool has_surfaces() const { return finder_.has_surfaces(); }

 Q_SIGNALS:
  /// A touch began on the surface here. \param at_m  hand frame  \param away  [1] into the surface, or the screen
  void hold_began(palpa::Vec3 at_m, palpa::Vec3 away);
  /// The touch moved to this surface point, pressed in by the depth [m] along `away`.
  void hold_moved(palpa::Vec3 at_m, palpa::Vec3 away, double depth_m);
  void hold_ended(palpa::Vec3 away);
  /// The hand's tool was turned by this rotation vector [rad], hand frame.
  void tool_turned(palpa::Vec3 rotation_rad);
  void turned();
  void enlarge_asked();
  /// The cursor is over this position of the data.
  void pointed(palpa::Vec3 at_m);
  void pointed_nowhere();
  /// A picture begins or ends to be drawn.
  void draws(bool on);

 protected:
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void mouseDoubleClickEvent(QMouseEvent* event) override;
  void leaveEvent(QEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;
  void keyPressEvent(QKeyEvent* event) override;
  void focusOutEvent(QFocusEvent* event) override;
  void resizeEvent(QResizeEvent* event) override;
  void paintGL() override;
  bool event(QEvent* event) override;

 private:
  class Overlay;
  enum class Drag { none, touch, turn, move, tool };
  Vec3 at_m(const QPointF& px) const;
  std::optional<SurfacePoint> surface_at(const QPointF& px) const;
  /// Depth of the nearest streamline on the screen, else of the cross; behind the view's centre.
  double flow_depth_m(const QPointF& px) const;
  double legend_px() const;  // at the right edge; 0 without marks
  void show_hover();
  static constexpr double degrees_per_px = 0.4;  // of a rotation
  /// True if these keys turn the tool instead of leading the hand.
  bool is_of_tool(Qt::KeyboardModifiers keys) const { return (keys & Qt::ControlModifier) != 0 && !tool_.is_point(); }
  void turn_tool(const QPointF& way_px);
  /// About the line of sight.
  void roll_tool(double notches);
  void begin_touch(const Target& target);
  void lead(const QPointF& px);
  void press_deeper(double notches);
  /// Return begins and ends a touch, arrows lead it, Page Down and Page Up press. False: another key.
  bool lead_by_key(int key);
  void end_touch_by_keys();
  bool takes_shortcut(const QKeyEvent& event) const;
  /// Position nearest to the middle where a press would touch.
  std::optional<QPointF> nearest_target_px() const;
  /// Applies the cut to all drawn parts.
  void cut_parts();
  /// The start of a ray in front of all data, moved to the cut if that is on its way.
  Vec3 start_behind_cut(const Vec3& from_m) const;
  /// False for a place that the cut hides.
  bool is_left(const Vec3& at_m) const { return !is_cut_ || dot(at_m - cut_m_, cut_away_) >= -1e-9; }
  void apply_camera();
  /// True for software rendering: moving pictures are drawn coarser.
  bool is_slow();
  void move_begins();
  void move_ends();
  void show_parts(bool coarse);
  void color_ground(const detail::Color& color);
  void redraw();

  vtkNew<vtkGenericOpenGLRenderWindow> window_;
  vtkNew<vtkRenderer> solid_, shells_;
  vtkNew<vtkPlane> cut_;
  bool is_cut_ = false;
  Vec3 cut_m_, cut_away_;  // a place on the cut, and [1] its normal to what is left
  Drawing drawing_;
  Overlay* overlay_;
  SurfaceFinder finder_;
  detail::View view_;
  QTimer still_, hover_;
  std::array<Vec3, 3> axes_{};
  bool medical_ = false;
  double world_per_hand_ = 1.0;
  double depth_m_ = 0.0;
  double plane_depth_m_ = 0.0;  // of the hand's plane behind the view's centre, without a surface
  Vec3 cross_m_;
  Vec3 into_;                     // of the last press
  std::optional<Vec3> ghost_m_;   // where a press would touch
  std::set<std::size_t> hidden_;  // layers
  bool turning_ = false;
  bool by_keys_ = false;  // a touch that keys lead
  Tool tool_;
  Moment moment_;
  std::optional<Moment> other_;  // of a second trace
  std::vector<SeenHand> hands_;  // but the led one
  std::vector<TrailPoint> trail_;
  std::vector<PlacedText> texts_;
  std::vector<detail::Streamline> streamlines_;
  double most_n_ = 1.0;
  QString top_, bottom_;
  bool marks_ = true, coarse_ = false, dark_ = false;
  Stereo stereo_ = Stereo::off;
  Drag drag_ = Drag::none;
  QPointF last_px_;
  std::optional<bool> is_slow_;
};

}  // namespace palpa::explorer
