#include "explorer/scene_views.h"

#include "explorer/drawing.h"
#include "explorer/panel.h"
#include "palpa/data/timed_field.h"
#include "palpa/scene/scene.h"
#include "palpa/view/layers.h"
#include "palpa/view/streamlines.h"

namespace palpa::explorer {
namespace {

constexpr std::size_t trail_points = 400;
constexpr double trail_step_m = 2e-4;
constexpr double jump_m = 0.03;  // more than the mouse leads a hand between two pictures: the hand was moved
// Streamlines near the proxy: radius, count, and proxy motion before the next update.
constexpr double flow_reach_m = 0.012, flow_step_m = 0.0015;
constexpr std::size_t flow_lines = 10;

bool is_dark(const QPalette& palette) { return palette.color(QPalette::Window).lightness() < 128; }

/// First vector field of the scene, at its start; null: none.
FieldPtr flow_of(const Scene& scene) {
  for (const std::string& name : field_names(scene)) {
    const FieldPtr field = scene.field({name}).field;
    if (field->components() == 3) return detail::in_hand_frame(frozen(field, scene.time().at(0.0)), scene.hand_to_world());
  }
  return nullptr;
}

}  // namespace

SceneViews::SceneViews(Jobs& jobs, bool has_opengl) : QSplitter(Qt::Horizontal), jobs_(jobs) {
  if (has_opengl) {
    view_ = new View3D;
    view_->set_dark(is_dark(palette()));
    addWidget(view_);
    connect(view_, &View3D::hold_began, this, &SceneViews::hold_began);
    connect(view_, &View3D::hold_moved, this, &SceneViews::hold_moved);
    connect(view_, &View3D::hold_ended, this, &SceneViews::hold_ended);
  }
  auto* column = new QSplitter(has_opengl ? Qt::Vertical : Qt::Horizontal);
  for (int axis = 2; axis >= 0; --axis) {
    auto* slice = new SliceView(axis);
    slices_[static_cast<std::size_t>(axis)] = slice;
    column->addWidget(slice);
    connect(slice, &SliceView::hold_began, this, &SceneViews::hold_began);
    connect(slice, &SliceView::hold_moved, this, &SceneViews::hold_moved);
    connect(slice, &SliceView::hold_ended, this, &SceneViews::hold_ended);
    connect(slice, &SliceView::value_asked, this, &SceneViews::value_asked);
    connect(slice, &SliceView::cross_moved, this, [this](const Vec3& at_m) {
      for (SliceView* other : slices_) other->set_cross(at_m);
    });
    connect(slice, &SliceView::window_dragged, this, [this](double low, double high) {
      look_.low = low;
      look_.high = high;
      for (SliceView* other : slices_) other->set_look(look_);
    });
  }
  addWidget(column);
  setStretchFactor(0, 3);
  setStretchFactor(1, 1);
  if (has_opengl) setSizes({660, 240});
}

void SceneViews::start(const Scene& scene) {
  trail_.clear();
  drawn_.clear();
  look_ = slice_look_of(scene);
  flow_ = flow_of(scene);
  flow_seen_at_m_ = {1e9, 1e9, 1e9};
  if (view_) view_->start(scene);
  for (SliceView* slice : slices_) slice->start(look_, bounds_m());
}

void SceneViews::draw_layers(const Scene& scene) {
  if (!view_) return;
  // Compare only the settings that change the picture.
  Scene seen = scene;
  // Disabled modes are drawn, too.
  for (const SceneMode& mode : scene.modes()) seen.edit_mode(mode.name, [](SceneMode& all) { all.enabled = true; });
  seen.layers = detail::layers_of(seen);
  Scene compared = seen;
  while (!compared.modes().empty()) compared.remove_mode(std::string(compared.modes().front().name));
  compared.set(CouplingOptions{});
  const std::string key = to_toml(compared);
  if (key == drawn_) return;
  drawn_ = key;
  const Vec3 towards = view_->view().towards;
  jobs_.begin<Drawing>(
      Jobs::Purpose::draw, tr("drawing"), [seen, towards](std::stop_token) { return draw_for_window(seen, towards); },
      [this, seen](Drawing drawing) { view_->show_drawing(std::move(drawing), seen); },
      [this](const QString& why) { Q_EMIT said(why, true); });
}

bool SceneViews::awaits_surfaces() const {
  if (!view_) return false;
  const Drawing& drawing = view_->drawing();
  return drawing.solid.empty() && drawing.shells.empty() && jobs_.is_under_way(Jobs::Purpose::draw);
}

palpa::Box SceneViews::bounds_m() const {
  return look_.field ? look_.field->bounds_m() : palpa::Box{{-0.08, -0.08, -0.08}, {0.08, 0.08, 0.08}};
}

void SceneViews::show_values(const Scene& scene, double low, double high) {
  look_ = slice_look_of(scene);
  look_.low = low;
  look_.high = high;
  for (SliceView* slice : slices_) slice->set_look(look_);
}

void SceneViews::show_felt(const Moment& moment, double most_n, bool leads) {
  // Clear the trail of a hand that was moved elsewhere.
  if (!trail_.empty() && distance(trail_.back().at_m, moment.proxy_m) > jump_m) trail_.clear();
  if (trail_.empty() || distance(trail_.back().at_m, moment.proxy_m) > trail_step_m)
    trail_.push_back({moment.proxy_m, norm(moment.command_n)});
  if (trail_.size() > trail_points) trail_.erase(trail_.begin());
  show_moment(moment, most_n, leads);
}

void SceneViews::show_played(const Player& player, double most_n) {
  const FeltTrace& trace = *player.trace();
  trail_.clear();
  for (const std::size_t row : player.trail(trail_points))
    trail_.push_back({trace.rows[row].proxy_m, norm(trace.rows[row].command_n)});
  show_moment(player.moment(), most_n, true);
}

void SceneViews::show_moment(const Moment& moment, double most_n, bool slices_follow) {
  if (view_) view_->show_touch(moment, trail_, most_n);
  show_flow_near(moment.proxy_m);
  for (SliceView* slice : slices_) {
    if (slices_follow) slice->set_cross(moment.proxy_m);
    slice->show_touch(moment, trail_, most_n);
  }
}

void SceneViews::show_flow_near(const Vec3& proxy_m) {
  if (!view_ || !flow_ || distance(proxy_m, flow_seen_at_m_) < flow_step_m) return;
  flow_seen_at_m_ = proxy_m;
  const Vec3 reach{flow_reach_m, flow_reach_m, flow_reach_m};
  const palpa::Box near = detail::shared_part(flow_->bounds_m(), {proxy_m - reach, proxy_m + reach});
  if (!(largest_component(near.size_m()) > 0.0)) return view_->show_streamlines({});
  view_->show_streamlines(detail::streamlines(*flow_, near, flow_lines));
}

}  // namespace palpa::explorer
