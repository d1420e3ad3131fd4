#include "explorer/scene_views.h"

#include <sys/resource.h>

#include <QEvent>
#include <QHBoxLayout>
#include <QVBoxLayout>
#include <utility>

#include "explorer/drawing.h"
#include "explorer/panel.h"
#include "palpa/data/timed_field.h"
#include "palpa/scene/scene.h"
#include "palpa/view/layers.h"
#include "palpa/view/streamlines.h"

namespace palpa::explorer {
namespace {

constexpr std::size_t trail_points = 400;
constexpr int finer_after_ms = 150;  // from a preview to the fine drawing. Longer: it comes late; shorter: begun while dragging
constexpr double trail_step_m = 2e-4;
constexpr double jump_m = 0.03;  // more than the mouse leads a hand between two pictures: the hand was moved
// Streamlines near the proxy: radius, count, and proxy motion before the next update.
constexpr double flow_reach_m = 0.012, flow_step_m = 0.0015;
constexpr std::size_t flow_lines = 10;
// Of reading tiles. More: a busy machine shows coarse slices; less: the hand's windows come later.
constexpr int nice_value = 10;

bool is_dark(const QPalette& palette) { return palette.color(QPalette::Window).lightness() < 128; }

/// First vector field of the scene; empty: none.
std::string name_of_flow(const Scene& scene) {
  for (const std::string& name : field_names(scene))
    if (scene.field({name}).field->components() == 3) return name;
  return {};
}

QComboBox* slice_box(const QString& name, const QString& tip) {
  auto* box = new QComboBox;
  box->setObjectName(name);
  box->setAccessibleName(tip);
  box->setToolTip(tip);
  box->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  box->setMinimumContentsLength(6);
  return box;
}

}  // namespace

SceneViews::SceneViews(Jobs& jobs, bool has_opengl)
    : QSplitter(Qt::Horizontal),
      jobs_(jobs),
      fields_(slice_box("slice_field", tr("Field that the slices show"))),
      windows_(slice_box("slice_window", tr("Window of values, from black to white"))) {
  if (has_opengl) {
    view_ = new View3D;
    view_->set_dark(is_dark(palette()));
    addWidget(view_);
    connect(view_, &View3D::hold_began, this, &SceneViews::hold_began);
    connect(view_, &View3D::hold_moved, this, &SceneViews::hold_moved);
    connect(view_, &View3D::hold_ended, this, &SceneViews::hold_ended);
    connect(view_, &View3D::tool_turned, this, &SceneViews::tool_turned);
    connect(view_, &View3D::enlarge_asked, this, [this] { enlarge(view_); });
    connect(view_, &View3D::pointed, this, [this](const Vec3& at_m) { Q_EMIT pointed(words_at(at_m)); });
    connect(view_, &View3D::pointed_nowhere, this, [this] { Q_EMIT pointed({}); });
  }
  make_slices(has_opengl);
  finer_.setSingleShot(true);
  finer_.setInterval(finer_after_ms);
  connect(&finer_, &QTimer::timeout, this, [this] { draw(false); });
  setStretchFactor(0, 3);
  setStretchFactor(1, 1);
  if (has_opengl) setSizes({660, 240});
}

void SceneViews::make_slices(bool has_opengl) {
  column_ = new QWidget;
  cuts_ = new QSplitter(has_opengl ? Qt::Vertical : Qt::Horizontal);
  auto* boxes = new QHBoxLayout;
  boxes->addWidget(fields_, 1);
  boxes->addWidget(windows_, 1);
  auto* all = new QVBoxLayout(column_);
  all->setContentsMargins(0, 0, 0, 0);
  all->setSpacing(2);
  all->addLayout(boxes);
  all->addWidget(cuts_, 1);
  addWidget(column_);
  connect(fields_, qOverload<int>(&QComboBox::activated), this,
          [this] { show_look(slice_look_of(*scene_, fields_->currentData().toString().toStdString())); });
  connect(windows_, qOverload<int>(&QComboBox::activated), this, [this](int index) {
    const std::vector<ValueWindow> windows = windows_of(look_);
    if (static_cast<std::size_t>(index) >= windows.size()) return;
    look_.low = windows[static_cast<std::size_t>(index)].low;
    look_.high = windows[static_cast<std::size_t>(index)].high;
    for (SliceView* slice : slices_) slice->set_look(look_);
  });
  for (int axis = 2; axis >= 0; --axis) {
    auto* slice = new SliceView(axis);
    slices_[static_cast<std::size_t>(axis)] = slice;
    cuts_->addWidget(slice);
    connect(slice, &SliceView::hold_began, this, &SceneViews::hold_began);
    connect(slice, &SliceView::hold_moved, this, &SceneViews::hold_moved);
    connect(slice, &SliceView::hold_ended, this, &SceneViews::hold_ended);
    connect(slice, &SliceView::value_asked, this, &SceneViews::value_asked);
    connect(slice, &SliceView::enlarge_asked, this, [this, slice] { enlarge(slice); });
    connect(slice, &SliceView::pointed, this, [this, slice](const Vec3& at_m) { Q_EMIT pointed(words_at(at_m, slice)); });
    connect(slice, &SliceView::pointed_nowhere, this, [this] { Q_EMIT pointed({}); });
    connect(slice, &SliceView::tiles_missing, this, &SceneViews::read_tiles);
    connect(slice, &SliceView::cross_moved, this, [this](const Vec3& at_m) {
      for (SliceView* other : slices_) other->set_cross(at_m);
      if (view_) view_->set_cross(at_m), view_->move_cut(at_m);
    });
    connect(slice, &SliceView::window_dragged, this, [this](double low, double high) {
      look_.low = low;
      look_.high = high;
      for (SliceView* other : slices_) other->set_look(look_);
      windows_->setCurrentIndex(-1);
    });
  }
}

void SceneViews::start(const Scene& scene) {
  trail_.clear();
  drawn_.clear();
  is_first_ = true;
  scene_ = scene;
  led_ = 0;
  jobs_.cancel(Jobs::Purpose::tiles);
  look_ = slice_look_of(scene);
  take_flow();
  list_fields();
  if (view_) view_->start(scene);
  for (SliceView* slice : slices_) slice->start(look_, bounds_m());
  if (view_) view_->set_cross(bounds_m().centre_m());
  show_look(look_);
}

void SceneViews::take_tools() {
  tools_.clear();
  for (std::size_t hand = 0; hand < std::max<std::size_t>(1, scene_->hands().size()); ++hand)
    tools_.emplace_back(scene_->tool_of(hand), scene_->coupling());
  if (view_) view_->set_tool(tools_[led_]);
}

void SceneViews::lead(std::size_t hand) {
  led_ = hand;
  trail_.clear();
  take_tools();
}

void SceneViews::take_flow() {
  flow_ = nullptr;
  if (const std::string name = name_of_flow(*scene_); !name.empty()) {
    const VolumeField named = scene_->field({name});
    const DataTime at = scene_->time().at(0.0);
    flow_ = detail::drawn_flow(*scene_, {name}, detail::in_hand_frame(frozen(named.field, at), scene_->hand_to_world()), at);
    flow_name_ = name;
    flow_unit_ = QString::fromStdString(named.unit);
  }
  flow_seen_at_m_ = {1e9, 1e9, 1e9};
}

void SceneViews::list_fields() {
  listed_ = field_names(*scene_);
  fields_->clear();
  for (const std::string& one : listed_) {
    if (one.starts_with("magnitude(")) continue;  // a slice shows vectors by their magnitudes
    const std::string& name = look_.name.starts_with(one + ".") ? look_.name : one;  // of a volume's only field
    fields_->addItem(field_words(*scene_, name), QString::fromStdString(name));
  }
  fields_->setCurrentIndex(fields_->findData(QString::fromStdString(look_.name)));
}

void SceneViews::show_look(const SliceLook& look) {
  const std::shared_ptr<SliceTiles> last = look_.tiles;
  look_ = look;
  take_tiles(*scene_, last, look_);
  for (SliceView* slice : slices_) slice->set_look(look_);
  fields_->setCurrentIndex(fields_->findData(QString::fromStdString(look_.name)));
  fields_->setToolTip(QString::fromStdString(look_.name));
  windows_->clear();
  for (const ValueWindow& window : windows_of(look_)) {
    windows_->addItem(window.name);
    if (window.low == look_.low && window.high == look_.high && windows_->currentIndex() < 0)
      windows_->setCurrentIndex(windows_->count() - 1);
  }
  refine_slices();
}

/// Replaces the coarsest octave of a volume larger than memory, which is shown at once.
void SceneViews::refine_slices() {
  if (!look_.octave || *look_.octave == 0) return;
  jobs_.begin<SliceLook>(
      Jobs::Purpose::slices, tr("reading finer octaves"),
      [scene = *scene_, look = look_](std::stop_token) { return in_fine_octave(scene, look); },
      [this](const SliceLook& fine) {
        if (fine.name != look_.name) return;
        look_.field = fine.field, look_.octave = fine.octave;
        for (SliceView* slice : slices_) slice->set_look(look_);
      },
      [this](const QString& why) { Q_EMIT said(why, true); });
}

/// Reads the missing tiles of all slices, some before each picture, until there are none.
void SceneViews::read_tiles() {
  if (!look_.tiles || jobs_.is_under_way(Jobs::Purpose::tiles)) return;
  std::vector<TilePlace> missing;
  for (const SliceView* slice : slices_)
    if (slice->isVisible()) missing.insert(missing.end(), slice->missing_tiles().begin(), slice->missing_tiles().end());
  if (missing.empty()) return;
  std::ranges::stable_sort(missing, std::greater(), &TilePlace::octave);
  jobs_.begin<std::vector<SliceTile>>(
      Jobs::Purpose::tiles, QString(),
      [tiles = look_.tiles, missing](std::stop_token stop) {
        ::setpriority(PRIO_PROCESS, 0, nice_value);  // of the job's thread alone, and of the reader that it starts
        return tiles->read(missing, stop);
      },
      [this, tiles = look_.tiles](std::vector<SliceTile> read) {
        std::vector<TilePlace> places;
        for (const SliceTile& tile : read) places.push_back(tile.place);
        tiles->keep(std::move(read));
        for (SliceView* slice : slices_) slice->show_tiles(places);
        read_tiles();
      },
      [this, tiles = look_.tiles](const QString& why) {
        if (tiles != look_.tiles) return;
        look_.tiles = nullptr;
        for (SliceView* slice : slices_) slice->set_look(look_);
        Q_EMIT said(why, true);
      });
}

void SceneViews::pick_values(bool on) {
  for (SliceView* slice : slices_) slice->pick_values(on);
}

void SceneViews::changeEvent(QEvent* event) {
  QSplitter::changeEvent(event);
  if (event->type() == QEvent::PaletteChange && view_) view_->set_dark(is_dark(palette()));
}

void SceneViews::set_layout_of_views(Layout layout) {
  layout_ = layout;
  enlarged_ = nullptr;
  const bool below = layout == Layout::slices_below;
  setOrientation(below ? Qt::Vertical : Qt::Horizontal);
  cuts_->setOrientation(view_ && layout == Layout::slices_beside ? Qt::Vertical : Qt::Horizontal);
  if (view_) view_->setVisible(layout != Layout::slices_alone);
  column_->setVisible(!view_ || layout != Layout::without_slices);
  for (SliceView* slice : slices_) slice->show();
  if (view_) below ? setSizes({600, 400}) : setSizes({660, 240});
  cuts_->setSizes({100, 100, 100});
}

void SceneViews::enlarge(QWidget* view) {
  if (enlarged_ == view) return set_layout_of_views(layout_);
  enlarged_ = view;
  if (view_) view_->setVisible(view == view_);
  column_->setVisible(view != view_);
  for (SliceView* slice : slices_) slice->setVisible(slice == view);
}

QString SceneViews::words_at(const Vec3& at_m, const SliceView* slice) const {
  QStringList words;
  const auto add = [&](std::optional<double> value, const QString& shown, const QString& unit) {
    words << (value ? QString("%1 = %2 %3").arg(shown).arg(*value, 0, 'g', 4).arg(unit) : tr("%1: no data").arg(shown));
  };
  const Vec3 world_m = look_.map.to_world(at_m);
  const double along_m[] = {world_m.x, world_m.y, world_m.z};
  for (int axis = 0; axis < 3; ++axis) words << coordinate_words(axis, along_m[axis], look_.medical, look_.map.scale);
  if (look_.field && !look_.labels.empty()) {
    const auto value = value_at(*look_.field, at_m);
    const SeenLabel* label = value ? label_at(look_.labels, *value) : nullptr;
    words << (label   ? QString("%1 (%2)").arg(QString::fromStdString(label->name)).arg(label->value)
              : value ? tr("label %1").arg(*value)
                      : tr("no data"));
  } else if (look_.field) {
    add(slice ? slice->value_at(at_m) : value_at(*look_.field, at_m), field_words(*scene_, look_.name),
        QString::fromStdString(look_.unit));
  }
  if (flow_ && flow_name_ != look_.name) add(value_at(*flow_, at_m), field_words(*scene_, flow_name_), flow_unit_);
  return words.join("   ");
}

void SceneViews::draw_layers(const Scene& scene, bool moves) {
  const bool moved = std::exchange(moves_, moves);
  const bool is_later = scene_ && scene_->time() != scene.time();
  scene_ = scene;
  take_tools();
  if (field_names(scene) != listed_) list_fields();  // data were added
  if (is_later) {
    const SliceLook now = slice_look_of(scene, look_.name);
    look_.field = now.field, look_.octave = now.octave;
    take_tiles(scene, look_.tiles, look_);
    for (SliceView* slice : slices_) slice->set_look(look_);
    refine_slices();
    take_flow();
  }
  if (!view_) return;
  // Compare only the settings that change the picture.
  Scene seen = scene;
  // Disabled modes are drawn, too.
  for (const SceneMode& mode : scene.modes()) seen.edit_mode(mode.name, [](SceneMode& all) { all.enabled = true; });
  seen.layers = detail::layers_of(seen);
  Scene compared = seen.of_hand(0);
  while (!compared.modes().empty()) compared.remove_mode(std::string(compared.modes().front().name));
  compared.set(CouplingOptions{});
  compared.set(ToolOptions{});
  const std::string key = to_toml(compared);
  if (key == drawn_) {
    if (moved && !moves) finer_.start();
    return;
  }
  drawn_ = key;
  next_ = std::move(seen);
  finer_.stop();
  // A preview is quick: the next begins when it is done. Nothing piles up while a value is dragged.
  if (!(is_rough_ && jobs_.is_under_way(Jobs::Purpose::draw))) draw(true);
}

void SceneViews::draw(bool rough) {
  const Vec3 towards = view_->view().towards;
  is_rough_ = rough;
  jobs_.begin<Drawing>(
      Jobs::Purpose::draw,
      moves_  ? QString()
      : rough ? tr("drawing")
              : tr("drawing finely"),
      [seen = *next_, towards, rough](std::stop_token) { return draw_for_window(seen, towards, rough); },
      [this, seen = *next_, rough](Drawing drawing) {
        view_->show_drawing(std::move(drawing), seen);
        if (!(*next_ == seen)) return draw(true);
        if (!rough || moves_) return;
        // A scene that was just opened is not being dragged.
        std::exchange(is_first_, false) ? draw(false) : finer_.start();
      },
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
  SliceLook look = slice_look_of(scene);
  look.low = low;
  look.high = high;
  show_look(look);
}

void SceneViews::show_felt(std::span<const Moment> hands, double most_n, bool leads) {
  const Moment& moment = hands[led_];
  // Clear the trail of a hand that was moved elsewhere.
  if (!trail_.empty() && distance(trail_.back().at_m, moment.proxy_m) > jump_m) trail_.clear();
  if (trail_.empty() || distance(trail_.back().at_m, moment.proxy_m) > trail_step_m)
    trail_.push_back({moment.proxy_m, norm(moment.command_n)});
  if (trail_.size() > trail_points) trail_.erase(trail_.begin());
  if (view_) view_->show_other({});
  std::vector<SeenHand> seen;
  for (std::size_t hand = 0; hand < hands.size(); ++hand)
    if (hand != led_) seen.push_back({tools_[hand], hands[hand]});
  seen.push_back({tools_[led_], moment});
  show_hands(std::move(seen), most_n, leads);
}

void SceneViews::show_played(const Player& player, double most_n) {
  const FeltTrace& trace = *player.trace();
  trail_.clear();
  for (const std::size_t row : player.trail(trail_points))
    trail_.push_back({trace.rows[row].proxy_m, norm(trace.rows[row].command_n)});
  if (view_) view_->show_other(player.other_moment());
  std::vector<SeenHand> seen;
  for (const Moment& other : player.hands()) {
    const std::size_t hand = seen.size() < led_ ? seen.size() : seen.size() + 1;
    seen.push_back({tools_[hand], other});
  }
  seen.push_back({tools_[led_], player.moment()});
  show_hands(std::move(seen), most_n, true);
}

void SceneViews::show_hands(std::vector<SeenHand> hands, double most_n, bool slices_follow) {
  const Vec3 proxy_m = hands.back().moment.proxy_m;
  for (SliceView* slice : slices_) {
    if (slices_follow) slice->set_cross(proxy_m);
    slice->show_touch(hands, trail_, most_n);
  }
  show_flow_near(proxy_m);
  if (!view_) return;
  view_->show_touch(hands.back().moment, trail_, most_n);
  if (slices_follow) view_->set_cross(proxy_m);
  hands.pop_back();
  view_->show_hands(std::move(hands));
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
