// Views of the open scene: one in 3-D, three slices, with hand and forces in all.
#pragma once

#include <QSplitter>
#include <array>
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
  /// Redraws the layers on a background thread if they have changed.
  void draw_layers(const Scene& scene);
  /// True while the first surfaces are being drawn.
  bool awaits_surfaces() const;

  /// Display settings of the slices.
  const SliceLook& look() const { return look_; }
  /// Of the slices' field; without a field, of a hand's reach.
  palpa::Box bounds_m() const;  // QFrame has a Box, too
  /// Sets the slices' value window from `low` (black) to `high` (white), the field's own unit.
  void show_values(const Scene& scene, double low, double high);

  /// Shows the current moment and extends the trail. \param leads  the mouse leads the hand: slices follow the proxy
  void show_felt(const Moment& moment, double most_n, bool leads);
  /// Shows the player's moment; slices follow the proxy.
  void show_played(const Player& player, double most_n);
  /// To be called after the hand was moved elsewhere.
  void forget_trail() { trail_.clear(); }

 Q_SIGNALS:
  // Forwarded from View3D and SliceView.
  void hold_began(palpa::Vec3 at_m, palpa::Vec3 away);
  void hold_moved(palpa::Vec3 at_m, palpa::Vec3 away, double depth_m);
  void hold_ended(palpa::Vec3 away);
  void value_asked(double value, palpa::Vec3 at_m);
  void said(const QString& words, bool is_problem);

 private:
  void show_moment(const Moment& moment, double most_n, bool slices_follow);
  void show_flow_near(const Vec3& proxy_m);

  Jobs& jobs_;
  View3D* view_ = nullptr;
  std::array<SliceView*, 3> slices_{};
  SliceLook look_;
  FieldPtr flow_;  ///< vectors that a mode or a layer uses; null: none
  Vec3 flow_seen_at_m_;
  std::vector<TrailPoint> trail_;
  std::string drawn_;  ///< key of the drawn layers
};

}  // namespace palpa::explorer
