#include "explorer/slice_view.h"

#include <QElapsedTimer>
#include <QMouseEvent>
#include <QPainter>
#include <QWheelEvent>
#include <algorithm>
#include <cmath>

#include "palpa/data/octave_parts.h"
#include "palpa/scene/parts.h"
#include "palpa/view/layers.h"

namespace palpa::explorer {
namespace {

constexpr int coarse_step_px = 3;     // between samples of a moving slice
constexpr int refine_after_ms = 120;  // from the last motion to the fine slice
constexpr int looks_for_window = 4000;
constexpr int pixels_of_octave = 512;  // [1] of a slice, for the choice of an octave. More: slower; fewer: blurred
constexpr int least_legend_px = 400;   // of a slice's width: narrower, a legend covers the labels

bool flows(const ViewLayer& layer) {
  return layer.show == ViewLayer::Show::streamlines || layer.show == ViewLayer::Show::glyphs;
}

/// Finds the name of the first field that a mode reads.
class FirstField : public ParameterVisitor {
 public:
  std::string name;
  void field(const ParameterInfo&, FieldRef& ref) override {
    if (name.empty()) name = ref.name;
  }
};

/// Computed from the derivatives of another field: seldom what a slice should show at first.
bool is_derived(const std::string& field) { return field.starts_with("q(") || field.starts_with("curl("); }

/// Field of the scene's slices, else its label map, its flow, the field of a layer, then of a mode; scalars before vectors,
/// which a slice shows by magnitude.
std::string name_of_slices(const Scene& scene) {
  std::string name, vectors;
  const auto take = [&](const std::string& candidate) {
    if (candidate.empty() || !name.empty()) return;
    try {
      (scene.field({candidate}).field->components() == 1 ? name : vectors) = candidate;
    } catch (const LoadError&) {  // try the next field
    }
  };
  for (const ViewLayer& layer : scene.layers)
    if (layer.show == ViewLayer::Show::slices) take(layer.field.name);
  take(name_of_label_map(scene));
  for (const ViewLayer& layer : detail::layers_of(scene))
    if (name.empty() && flows(layer)) return layer.field.name;
  for (const ViewLayer& layer : scene.layers)
    if (!is_derived(layer.field.name)) take(layer.field.name);
  for (const SceneMode& mode : scene.modes()) {
    FirstField first;
    look_through(mode.mode, first);
    take(first.name);
  }
  if (name.empty()) name = vectors;
  if (name.empty() && !scene.volumes().empty()) {
    const SceneVolume& volume = scene.volumes().front();
    name = volume.volume.fields.size() == 1 ? volume.name : volume.name + "." + volume.volume.fields.front().name;
  }
  return name;
}

/// Values without the extreme 0.2 % at each end, of positions all over the field.
std::optional<ValueRange> usual_values(const Field& field) {
  const Box box = field.bounds_m();
  const Vec3 size = box.size_m();
  std::vector<double> values;
  for (int i = 0; i < looks_for_window; ++i) {
    // Evenly spread without a pattern (Roberts, The unreasonable effectiveness of quasirandom sequences, 2018).
    const auto share = [i](double step) { return std::fmod(0.5 + step * i, 1.0); };
    const Vec3 at_m = box.low_m + Vec3{share(0.8191725) * size.x, share(0.6710436) * size.y, share(0.5497005) * size.z};
    if (const auto value = value_at(field, at_m); value && std::isfinite(*value)) values.push_back(*value);
  }
  if (values.size() < 100) return {};
  std::sort(values.begin(), values.end());
  const std::size_t few = values.size() / 500;
  return ValueRange{values[few], values[values.size() - 1 - few]};
}

bool is_hounsfield(const SliceLook& look) {
  // Or a file without unit with air and bone.
  return look.unit == "HU" || (look.unit.empty() && look.least <= -900.0 && look.most > 1000.0);
}

}  // namespace

std::optional<double> value_at(const Field& field, const Vec3& at_m) {
  if (field.components() == 1) {
    const ScalarSample sample = field.scalar(at_m);
    return sample.inside ? std::optional(sample.value) : std::nullopt;
  }
  const VectorSample sample = field.vector(at_m);
  return sample.inside ? std::optional(norm(sample.value)) : std::nullopt;
}

std::vector<ValueWindow> windows_of(const SliceLook& look) {
  std::vector<ValueWindow> windows;
  if (!look.labels.empty()) return {{SliceView::tr("Labels"), look.least, look.most}};
  const bool scalar = look.field && look.field->components() == 1;
  if (scalar && is_hounsfield(look)) {
    windows = {{SliceView::tr("Bone and skin"), -500.0, 1000.0},
               {SliceView::tr("Soft tissue"), -160.0, 240.0},
               {SliceView::tr("Brain"), 0.0, 80.0},
               {SliceView::tr("Lung"), -1350.0, 150.0}};
  }
  if (look.field) {
    const auto usual = usual_values(*look.field);
    if (usual && usual->min < usual->max)
      windows.push_back({SliceView::tr("By the data"), scalar ? usual->min : 0.0, usual->max});
  }
  windows.push_back({SliceView::tr("Whole range"), look.least, look.most});
  return windows;
}

QString field_words(const Scene& scene, const std::string& field) {
  const VolumeField named = scene.field({field});
  std::string name = field;
  if (scene.volumes().size() == 1) {
    const std::string prefix = scene.volumes().front().name + ".";
    if (const std::size_t at = name.find(prefix); at != name.npos) name.erase(at, prefix.size());
  }
  const bool is_magnitude = name.starts_with("magnitude(");
  if (is_magnitude) name = name.substr(10, name.size() - 11);
  if (named.field->components() == 1 && !is_magnitude) {
    return detail::is_generic_name(name) ? SliceView::tr("value") : QString::fromStdString(name);
  }
  return detail::is_generic_name(name) ? SliceView::tr("speed") : "|" + QString::fromStdString(name) + "|";
}

SliceLook slice_look_of(const Scene& scene, const std::string& field) {
  SliceLook look;
  look.map = scene.hand_to_world();
  const std::string name = field.empty() ? name_of_slices(scene) : field;
  look.medical = std::any_of(scene.volumes().begin(), scene.volumes().end(),
                             [](const SceneVolume& volume) { return volume.volume.medical_frame; });
  if (name.empty()) return look;
  try {
    const VolumeField named = scene.field({name});
    look.labels = labels_of(scene, name);
    const FieldPtr now = frozen(named.field, scene.time().at(0.0));
    look.field = detail::in_hand_frame(look.labels.empty() ? now : nearest_voxels(now), look.map);
    look.name = name;
    if (const Octaves* octaves = octaves_below(*named.field)) look.octave = octaves->count() - 1;
    look.unit = named.unit;
    look.words = look.labels.empty() ? field_words(scene, name) : SliceView::tr("labels");
    const bool from_file = std::ranges::any_of(scene.volumes(), [&](const SceneVolume& volume) {
      return name.find(volume.name) != name.npos && volume.volume.request;
    });
    if (!look.unit.empty())
      look.words += " / " + QString::fromStdString(look.unit);
    else if (from_file && look.labels.empty())
      look.words += SliceView::tr(", no unit in the file");
    const std::vector<ValueRange> value_ranges = named.field->value_ranges();
    if (named.field->components() == 1) {
      look.least = look.low = value_ranges[0].min;
      look.most = look.high = value_ranges[0].max;
    } else {
      double squared = 0.0;
      for (const ValueRange& extent : value_ranges)
        squared += std::pow(std::max(std::abs(extent.min), std::abs(extent.max)), 2);
      look.least = look.low = 0.0;
      look.most = look.high = std::sqrt(squared);
      look.colors = detail::magnitude_colors(0.0, 1.0);
    }
    const ValueWindow own = windows_of(look).front();
    look.low = own.low;
    look.high = own.high;
  } catch (const LoadError&) {
    look.field = nullptr;
  }
  return look;
}

void take_tiles(const Scene& scene, const std::shared_ptr<SliceTiles>& last, SliceLook& look) {
  if (!look.octave || !look.field || !look.labels.empty()) return;
  const FieldPtr field = detail::in_hand_frame(scene.field({look.name}).field, look.map);
  const auto posed = posed_octaves(*field, scene.time().at(0.0));
  if (!posed) return;
  look.pose = posed->pose;
  const bool is_of_last = last && &last->octaves() == posed->octaves;
  look.tiles = is_of_last ? last : std::make_shared<SliceTiles>(std::shared_ptr<const Octaves>(field, posed->octaves));
}

SliceLook in_fine_octave(const Scene& scene, SliceLook look) {
  if (!look.octave || !look.field) return look;
  const FieldPtr field = detail::in_hand_frame(scene.field({look.name}).field, look.map);
  const Box box = field->bounds_m();
  const double step_m = largest_component(box.size_m()) / pixels_of_octave;
  if (const auto drawn = step_m > 0.0 ? drawn_octave(*field, scene.time().at(0.0), box, step_m) : std::nullopt)
    look.field = drawn->field, look.octave = drawn->octave;
  return look;
}

SliceView::SliceView(int axis, QWidget* parent) : QWidget(parent), axis_(axis) {
  setMinimumSize(120, 100);
  setFocusPolicy(Qt::StrongFocus);
  setAttribute(Qt::WA_OpaquePaintEvent);
  setMouseTracking(true);
  setAccessibleName(title());
  setAccessibleDescription(tr("Left drag touches, right drag changes window and level, the wheel goes through slices."));
  refine_.setSingleShot(true);
  refine_.setInterval(refine_after_ms);
  connect(&refine_, &QTimer::timeout, this, [this] {
    sample(1);
    update();
  });
}

QString SliceView::title() const {
  static const char* const patient[] = {QT_TR_NOOP("Sagittal"), QT_TR_NOOP("Coronal"), QT_TR_NOOP("Axial")};
  static const char* const plain[] = {QT_TR_NOOP("Across x"), QT_TR_NOOP("Across y"), QT_TR_NOOP("Across z")};
  return tr((look_.medical ? patient : plain)[axis_]);
}

void SliceView::start(const SliceLook& look, const Box& bounds_m) {
  bounds_m_ = bounds_m;
  look_ = look;
  const Similarity& map = look.map;
  const auto world = [&](double x, double y, double z) { return map.direction_to_hand({x, y, z}); };
  // Radiological convention: patient's right on the left, front or head above.
  if (axis_ == 2) {
    view_.right = world(1, 0, 0);
    view_.up = look.medical ? world(0, -1, 0) : world(0, 1, 0);
  } else {
    view_.right = axis_ == 1 ? world(1, 0, 0) : world(0, 1, 0);
    view_.up = world(0, 0, 1);
  }
  view_.towards = cross(view_.right, view_.up);
  view_.centre_m = cross_m_ = bounds_m.centre_m();
  const Vec3 size = bounds_m.size_m();
  const auto extent = [&](const Vec3& a) { return std::abs(a.x) * size.x + std::abs(a.y) * size.y + std::abs(a.z) * size.z; };
  const double aspect = 1.0 * std::max(1, width()) / std::max(1, height());
  view_.half_height_m = std::max(1e-4, 0.53 * std::max(extent(view_.up), extent(view_.right) / aspect));
  setAccessibleName(title());
  sample(1);
  update();
}

void SliceView::set_look(const SliceLook& look) {
  look_ = look;
  stale();
}

void SliceView::set_cross(const Vec3& at_m) {
  const double moved_m = std::abs(dot(at_m - cross_m_, view_.towards));
  cross_m_ = at_m;
  if (moved_m > 0.25 / view_.px_per_m()) stale();
  update();
}

void SliceView::show_touch(std::vector<SeenHand> hands, const std::vector<TrailPoint>& trail, double most_n) {
  const bool seen = look_alike(hands, hands_) && trail.size() == trail_.size() && most_n == most_n_;
  hands_ = std::move(hands);
  trail_ = trail;
  most_n_ = most_n;
  if (!seen) update();
}

void SliceView::stale() {
  sample(coarse_step_px);
  refine_.start();
  update();
}

Vec3 SliceView::at_m(const QPointF& px) const {
  const double per_px = 1.0 / view_.px_per_m();
  const Vec3 middle = view_.centre_m + dot(cross_m_ - view_.centre_m, view_.towards) * view_.towards;
  return middle + (px.x() - 0.5 * view_.width_px) * per_px * view_.right + (0.5 * view_.height_px - px.y()) * per_px * view_.up;
}

std::optional<double> SliceView::value_at(const Vec3& at_m) const {
  if (look_.tiles) {
    if (const auto value = look_.tiles->value_at(look_.pose.to_hand(at_m), tiles_.across, tiles_.wanted)) return value;
  }
  return look_.field ? explorer::value_at(*look_.field, at_m) : std::nullopt;
}

void SliceView::sample(int step_px) {
  if (!look_.field || width() < 2 || height() < 2) return;
  step_px_ = step_px;
  image_ = QImage(width() / step_px + 1, height() / step_px + 1, QImage::Format_RGB32);
  find_tiles();
  sample(image_.rect());
  Q_EMIT tiles_missing();
}

/// Samples a part of the image.
void SliceView::sample(const QRect& part) {
  std::array<QRgb, 256> table{};
  for (int i = 0; i < 256; ++i) table[static_cast<std::size_t>(i)] = to_qt(look_.colors.at(i / 255.0).color).rgb();
  const auto color_of_label = [this](double value) {
    const SeenLabel* label = label_at(look_.labels, value);
    return label ? to_qt(label->color).rgb() : value == 0.0 ? QColor(Qt::black).rgb() : QColor(Qt::darkGray).rgb();
  };
  const QRgb outside = QColor(46, 46, 52).rgb();
  const double span = std::max(1e-300, look_.high - look_.low);
  for (int row = part.top(); row <= part.bottom(); ++row) {
    auto* line = reinterpret_cast<QRgb*>(image_.scanLine(row));
    for (int column = part.left(); column <= part.right(); ++column) {
      const auto value = value_at(at_m({(column + 0.5) * step_px_, (row + 0.5) * step_px_}));
      const double share = std::clamp((value.value_or(0.0) - look_.low) / span, 0.0, 1.0);
      line[column] = !value || !std::isfinite(*value) ? outside
                     : look_.labels.empty()           ? table[static_cast<std::size_t>(255.0 * share)]
                                                      : color_of_label(*value);
    }
  }
}

void SliceView::find_tiles() {
  tiles_ = {};
  if (!look_.tiles) return;
  const double px_m = 1.0 / (look_.pose.scale * view_.px_per_m());  // in the frame of the octaves
  const auto along = [&](const Vec3& side, int px) { return 0.5 * px * px_m * look_.pose.direction_to_hand(side); };
  tiles_ = look_.tiles->tiles_of({look_.pose.to_hand(at_m({0.5 * width(), 0.5 * height()})), along(view_.right, width()),
                                  along(view_.up, height()), step_px_ * px_m},
                                 *look_.octave);
}

void SliceView::show_tiles(std::span<const TilePlace> places) {
  if (!look_.tiles || image_.isNull()) return;
  find_tiles();
  for (const TilePlace& place : places) {
    if (place.across != tiles_.across || place.octave < tiles_.wanted) continue;
    QPolygonF on;
    for (const Vec3& corner_m : look_.tiles->corners_m(place)) on << on_screen(view_, look_.pose.to_world(corner_m)) / step_px_;
    sample(on.boundingRect().toAlignedRect() & image_.rect());
  }
  update();
}

void SliceView::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.fillRect(rect(), QColor(46, 46, 52));
  painter.setRenderHint(QPainter::Antialiasing);
  painter.setRenderHint(QPainter::SmoothPixmapTransform);
  if (!image_.isNull()) {
    const int step = std::max(1, static_cast<int>(std::lround(1.0 * width() / image_.width())));
    painter.drawImage(QRect(0, 0, image_.width() * step, image_.height() * step), image_);
  }
  const QPointF cross = on_screen(view_, cross_m_);
  painter.setPen(QPen(QColor(86, 180, 233, 200), 1.0));
  for (const double gap : {-1.0, 1.0}) {
    painter.drawLine(cross + QPointF(gap * 9, 0), QPointF(gap < 0 ? 0 : width(), cross.y()));
    painter.drawLine(cross + QPointF(0, gap * 9), QPointF(cross.x(), gap < 0 ? 0 : height()));
  }
  paint_trail(painter, view_, trail_, most_n_);
  paint_hands(painter, view_, hands_, most_n_);
  Texts texts(painter);
  paint_texts(texts);
  texts_ = texts.shown();
  if (hasFocus()) {
    painter.setPen(QPen(palette().highlight().color(), 2));
    painter.setBrush(Qt::NoBrush);
    painter.drawRect(rect().adjusted(1, 1, -1, -1));
  }
}

/// Octaves of which there are samples in the slice; nothing for volumes in memory.
QString SliceView::octave_words() const {
  if (!look_.octave) return {};
  const int finest = look_.tiles ? tiles_.finest : *look_.octave, coarsest = look_.tiles ? tiles_.coarsest : finest;
  return finest == coarsest ? tr(", octave %1").arg(finest) : tr(", octaves %1 to %2").arg(finest).arg(coarsest);
}

void SliceView::paint_texts(Texts& shown) {
  QPainter& painter = shown.painter();
  const QColor ink(235, 235, 235);
  QFont small = painter.font();
  small.setPointSizeF(0.85 * small.pointSizeF());
  painter.setFont(small);
  const std::array<Vec3, 3> axes{look_.map.direction_to_hand({1, 0, 0}), look_.map.direction_to_hand({0, 1, 0}),
                                 look_.map.direction_to_hand({0, 0, 1})};
  const QFontMetrics metrics = painter.fontMetrics();
  const Vec3 cut_m = look_.map.to_world(cross_m_);
  const double along_m[] = {cut_m.x, cut_m.y, cut_m.z};
  // Rows of texts, side by side where the slice is wide enough.
  QStringList texts{title() + " · " + coordinate_words(axis_, along_m[axis_], look_.medical, look_.map.scale)};
  if (look_.field) {
    texts << look_.words + octave_words();
    if (look_.labels.empty()) texts << QString("%1 … %2").arg(look_.low, 0, 'g', 4).arg(look_.high, 0, 'g', 4);
  }
  const int room_px = width() - 16;
  QRectF row(8, 4, room_px, metrics.height());
  int left_px = 0;  // of the row
  for (const QString& text : texts) {
    const int px = metrics.horizontalAdvance(text);
    const bool beside = left_px > 0 && left_px + 2 * metrics.averageCharWidth() + px <= room_px;
    if (left_px > 0 && !beside) row.translate(0, metrics.height());
    shown.paint_rimmed(row, beside ? Qt::AlignRight : Qt::AlignLeft, metrics.elidedText(text, Qt::ElideMiddle, room_px), ink);
    left_px = beside ? room_px : px;
  }
  if (!look_.labels.empty() && width() > least_legend_px) {
    std::vector<detail::LegendEntry> legend;
    for (const SeenLabel& label : look_.labels) legend.push_back({label.name, {label.color}, {}});
    paint_explanations(shown, QRect(0, static_cast<int>(row.bottom()) + 4, width(), height()), legend, {}, ink,
                       QColor(20, 20, 24, 210));
  }
  paint_directions(shown, view_, axes, look_.medical, ink, row.bottom());
  paint_scale_bar(shown, view_, look_.map.scale, ink);
}

void SliceView::resizeEvent(QResizeEvent*) {
  view_.width_px = width();
  view_.height_px = height();
  stale();
}

void SliceView::mousePressEvent(QMouseEvent* event) {
  last_px_ = event->localPos();
  const bool shifted = (event->modifiers() & Qt::ShiftModifier) != 0;
  if (event->button() == Qt::RightButton) {
    drag_ = Drag::window;
  } else if (event->button() == Qt::MiddleButton || (shifted && event->button() == Qt::LeftButton)) {
    drag_ = Drag::move;
  } else if (event->button() == Qt::LeftButton) {
    drag_ = Drag::touch;
    Q_EMIT hold_began(at_m(last_px_), {});
  }
}

void SliceView::mouseMoveEvent(QMouseEvent* event) {
  const QPointF way = event->localPos() - last_px_;
  last_px_ = event->localPos();
  Q_EMIT pointed(at_m(last_px_));
  switch (drag_) {
    case Drag::none: break;
    case Drag::touch: Q_EMIT hold_moved(at_m(last_px_), {}, 0.0); break;
    case Drag::window: {
      const double per_px = (look_.most - look_.least) / 800.0;
      const double middle = 0.5 * (look_.low + look_.high) + per_px * way.y();
      const double half = std::max(1e-3 * (look_.most - look_.least), 0.5 * (look_.high - look_.low) + per_px * way.x());
      Q_EMIT window_dragged(middle - half, middle + half);
      break;
    }
    case Drag::move:
      view_.centre_m += (-way.x() / view_.px_per_m()) * view_.right + (way.y() / view_.px_per_m()) * view_.up;
      stale();
      break;
  }
}

void SliceView::mouseReleaseEvent(QMouseEvent*) {
  if (drag_ == Drag::touch) Q_EMIT hold_ended({});
  drag_ = Drag::none;
}

void SliceView::mouseDoubleClickEvent(QMouseEvent* event) {
  if (event->button() != Qt::LeftButton) return;
  if (!picks_) return Q_EMIT enlarge_asked();
  const Vec3 here = at_m(event->localPos());
  if (const auto value = value_at(here)) Q_EMIT value_asked(*value, here);
}

void SliceView::leaveEvent(QEvent*) { Q_EMIT pointed_nowhere(); }

void SliceView::wheelEvent(QWheelEvent* event) {
  const double notches = event->angleDelta().y() / 120.0;
  if (event->modifiers() & Qt::ControlModifier) {
    view_.half_height_m = std::clamp(view_.half_height_m / std::pow(1.15, notches), 1e-4, 10.0);
    stale();
  } else if (look_.field) {
    Q_EMIT cross_moved(cross_m_ + notches * look_.field->spacing_m() * view_.towards);
  }
  event->accept();
}

}  // namespace palpa::explorer
