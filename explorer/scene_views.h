// The open scene as it is seen: in three dimensions and in three slices, with what is felt in all of them.
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

/// The slices share one crosshair and one window of values. All sizes are in the hand frame.
class SceneViews : public QSplitter {
  Q_OBJECT
 public:
  /// \param has_opengl  false: slices only
  SceneViews(Jobs& jobs, bool has_opengl);

  /// Null without OpenGL.
  View3D* view() const { return view_; }
  /// Forgets another scene, and what was felt in it. Its layers come with `draw_layers`.
  void start(const Scene& scene);
  /// Draws the scene's layers on a thread of their own, if others are drawn now.
  void draw_layers(const Scene& scene);
  /// Whether no surface is seen yet, because the first are being drawn.
  bool awaits_surfaces() const;

  /// What the slices show of the scene.
  const SliceLook& look() const { return look_; }
  /// Of the data that the slices show; without such data of a hand's reach.
  palpa::Box bounds_m() const;  // a QFrame has a Box of its own
  /// Has the slices show values of the scene from `low`, black, to `high`, white, in the field's own unit.
  void show_values(const Scene& scene, double low, double high);

  /// What is felt now; its trail grows. \param leads  whether the mouse leads the hand: the slices then go with the proxy
  void show_felt(const Moment& moment, double most_n, bool leads);
  /// What the player's trace felt at its moment; the slices go with the proxy.
  void show_played(const Player& player, double most_n);
  /// The hand was put elsewhere.
  void forget_trail() { trail_.clear(); }

 Q_SIGNALS:
  // As those of View3D and SliceView.
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
  FieldPtr flow_;  ///< vectors that are felt or seen; null: there are none
  Vec3 flow_seen_at_m_;
  std::vector<TrailPoint> trail_;
  std::string drawn_;  ///< what the layers that are drawn depend on
};

}  // namespace palpa::explorer
