// Views of the open scene: one in 3-D, three slices, with hand and forces in all.
#pragma once

#include <QComboBox>
#include <QSplitter>
#include <QTimer>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "explorer/jobs.h"
#include "explorer/player.h"
#include "explorer/slice_view.h"
#include "explorer/view_3d.h"

namespace palpa::explorer {

/// The slices share one crosshair and one value window. All lengths are in the hand frame.
class SceneViews : public QSplitter {
  Q_OBJECT
 public:
  /// \param has_opengl  false: slices only
  SceneViews(Jobs& jobs, bool has_opengl);

  /// Null without OpenGL.
  View3D* view() const { return view_; }
  /// Resets views and trail for a new scene. Layers follow by `draw_layers`.
  void start(const Scene& scene);
  /// Redraws the layers on a background thread if they have changed; of moving data, at the start of the scene's time.
  /// \param moves  the next moment follows at once: only a preview is drawn, and the window is not busy with it
  void draw_layers(const Scene& scene, bool moves = false);
  /// True until all layers and slices are drawn finely.
  bool is_drawing() const {
    return jobs_.is_under_way(Jobs::Purpose::tiles) ||
           (!moves_ && (finer_.isActive() || jobs_.is_under_way(Jobs::Purpose::draw)));
  }
  /// True while the first surfaces are being drawn.
  bool awaits_surfaces() const;

  /// Display settings of the slices.
  const SliceLook& look() const { return look_; }
  /// Of the slices' field; without a field, of a hand's reach.
  palpa::Box bounds_m() const;  // QFrame has a Box, too
  /// Sets the slices' value window from `low` (black) to `high` (white), the field's own unit.
  void show_values(const Scene& scene, double low, double high);
  /// Sets whether a double click in a slice picks a value; else it enlarges the slice.
  void pick_values(bool on);
  enum class Layout { slices_beside, slices_below, without_slices, slices_alone };
  void set_layout_of_views(Layout layout);
  Layout layout_of_views() const { return layout_; }
  /// The view alone; again: all views of the layout.
  void enlarge(QWidget* view);
  /// False for flows, which are touched anywhere.
  bool touches_surfaces() const { return !view_ || view_->has_surfaces(); }

  /// Sets the hand whose trail and forces are shown, and whose tool the mouse turns. \param hand  of the scene
  void lead(std::size_t hand);
  /// Shows the current moment of each hand and extends the led one's trail.
  /// \param hands  of the scene, in its order
  /// \param leads  the mouse leads the hand: slices follow the proxy
  void show_felt(std::span<const Moment> hands, double most_n, bool leads);
  /// Shows the player's moment; slices follow the proxy.
  void show_played(const Player& player, double most_n);
  /// To be called after the hand was moved elsewhere.
  void forget_trail() { trail_.clear(); }

 Q_SIGNALS:
  // Forwarded from View3D and SliceView.
  void hold_began(palpa::Vec3 at_m, palpa::Vec3 away);
  void hold_moved(palpa::Vec3 at_m, palpa::Vec3 away, double depth_m);
  void hold_ended(palpa::Vec3 away);
  void tool_turned(palpa::Vec3 rotation_rad);
  void value_asked(double value, palpa::Vec3 at_m);
  /// Position, values and fields under the cursor; empty: none.
  void pointed(const QString& words);
  void said(const QString& words, bool is_problem);

 protected:
  void changeEvent(QEvent* event) override;

 private:
  void make_slices(bool has_opengl);
  void list_fields();
  void take_flow();
  void show_look(const SliceLook& look);
  void refine_slices();
  void read_tiles();
  void draw(bool rough);
  QString words_at(const Vec3& at_m, const SliceView* slice = nullptr) const;
  void take_tools();
  /// \param hands  the led one last
  void show_hands(std::vector<SeenHand> hands, double most_n, bool slices_follow);
  void show_flow_near(const Vec3& proxy_m);

  Jobs& jobs_;
  View3D* view_ = nullptr;
  std::array<SliceView*, 3> slices_{};
  QWidget* column_ = nullptr;  ///< of the slices and their boxes
  QSplitter* cuts_ = nullptr;  ///< the slices
  QComboBox *fields_, *windows_;
  std::vector<std::string> listed_;  ///< of the scene, in `fields_`
  QWidget* enlarged_ = nullptr;
  Layout layout_ = Layout::slices_beside;
  std::optional<Scene> scene_;
  std::optional<Scene> next_;  ///< to be drawn
  bool is_rough_ = false;      ///< the running drawing
  bool moves_ = false;         ///< data that play
  bool is_first_ = true;       ///< the drawing of a new scene
  QTimer finer_;               ///< until the fine drawing, which a further change cancels
  SliceLook look_;
  FieldPtr flow_;  ///< vectors that a mode or a layer uses; null: none
  std::string flow_name_;
  QString flow_unit_;
  Vec3 flow_seen_at_m_;
  std::vector<TrailPoint> trail_;
  std::vector<Tool> tools_;  ///< of the scene's hands
  std::size_t led_ = 0;      ///< of the scene's hands
  std::string drawn_;        ///< key of the drawn layers
};

}  // namespace palpa::explorer
