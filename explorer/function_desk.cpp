#include "explorer/function_desk.h"

#include <QColor>
#include <algorithm>
#include <cmath>

#include "explorer/parameter_rows.h"
#include "palpa/scene/parts.h"
#include "palpa/view/layers.h"

namespace palpa::explorer {
namespace {

std::vector<ParameterRow> rows_of_mode(const SceneMode& mode) {
  return rows_of([&](ParameterVisitor& visitor) { look_through(mode.mode, visitor); });
}

void set_mode_row(Scene& scene, const std::string& mode, std::size_t row, const ParameterRow::Value& value) {
  scene.edit_mode(
      mode, [&](SceneMode& changed) { set_row([&](ParameterVisitor& visitor) { changed.mode.visit(visitor); }, row, value); });
}

/// Field for a strength as a function: the mode's; of a level, on which that is constant, its gradient's magnitude. Empty: the
/// mode reads no field.
std::string input_for(const Scene& scene, const std::vector<ParameterRow>& rows, std::size_t strength) {
  const auto first = std::ranges::find_if(rows, [](const auto& row) { return std::holds_alternative<FieldRef>(row.value); });
  if (first == rows.end() || std::get<FieldRef>(first->value).name.empty()) return {};
  const std::string& field = std::get<FieldRef>(first->value).name;
  if (scene.field({field}).field->components() != 1) return "magnitude(" + field + ")";
  const std::string& group = rows[strength].group;
  const bool is_on_level = !group.empty() && std::ranges::any_of(rows, [&](const ParameterRow& row) {
    return row.info.kind == ParameterKind::level && row.group == group;
  });
  return is_on_level ? "gradient_magnitude(" + field + ")" : field;
}

/// True if the layer's colours depend on this field.
bool colors_say(const ViewLayer& layer, const std::string& field) {
  if (layer.show == ViewLayer::Show::surface || layer.show == ViewLayer::Show::slices) return false;
  return layer.field.name == field || "magnitude(" + layer.field.name + ")" == field;
}

std::vector<ViewLayer::ColorPoint> drawn_colors(const ViewLayer& layer, const Field& field) {
  if (!layer.colors.empty()) return layer.colors;
  const detail::ColorMap map = detail::colors_of(layer, field);
  std::vector<ViewLayer::ColorPoint> points;
  for (const detail::ColorMap::Point& point : map.points()) {
    const QColor color = QColor::fromRgbF(point.color.red, point.color.green, point.color.blue);
    points.push_back({point.value, color.name().toStdString(), point.opacity});
  }
  return points;
}

}  // namespace

FunctionDesk::FunctionDesk(Document& document, Jobs& jobs, bool has_opengl, QWidget* parent)
    : QDockWidget(tr("Function"), parent), document_(document), jobs_(jobs), editor_(new FunctionEditor(has_opengl)) {
  setObjectName("function");
  setWidget(editor_);
  connect(&document_, &Document::opened_another, this, [this] { draft_.reset(); });
  connect(editor_, &FunctionEditor::strength_changed, this, [this](const TransferFunction& curve) {
    if (!felt_) return;
    const FieldRef field{editor_->shown().field};
    draft_.reset();
    document_.edit(felt_->is_mask ? tr("mask") : tr("strength"), felt_->is_mask ? 900'002 : 900'000, [&](Scene& scene) {
      if (felt_->is_mask) {
        scene.edit_mode(felt_->mode, [&](SceneMode& mode) { mode.masks.at(felt_->number) = {field, curve}; });
      } else {
        set_mode_row(scene, felt_->mode, felt_->number, Strength(field, curve));
      }
    });
  });
  connect(editor_, &FunctionEditor::colors_changed, this, [this](const std::vector<ViewLayer::ColorPoint>& colors) {
    if (!seen_) return;
    document_.edit(tr("colours"), 900'001, [&](Scene& scene) {
      scene.layers = detail::layers_of(scene);
      if (*seen_ < scene.layers.size()) scene.layers[*seen_].colors = colors;
    });
  });
  connect(editor_, &FunctionEditor::value_chosen, this, &FunctionDesk::give_value_to_level);
}

void FunctionDesk::edit_strength(std::size_t mode, std::size_t row) {
  const Felt felt{.mode = document_.scene().modes()[mode].name, .is_mask = false, .number = row};
  const std::vector<ParameterRow> rows = rows_of_mode(document_.scene().modes()[mode]);
  const auto* strength = std::get_if<Strength>(&rows[row].value);
  if (!strength) return;
  draft_.reset();
  if (!strength->is_constant()) return open(felt);
  const std::string field = input_for(document_.scene(), rows, row);
  if (field.empty()) return Q_EMIT said(tr("This mode reads no field: its strength is a number."), false);
  // A derived field is computed on first use.
  jobs_.begin<VolumeField>(
      Jobs::Purpose::look, tr("computing %1").arg(QString::fromStdString(field)),
      [scene = document_.scene(), field](std::stop_token) { return scene.field({field}); },
      [this, felt, field](const VolumeField& named) { draft(felt, field, named.field->value_ranges()[0]); },
      [this](const QString& why) { Q_EMIT said(why, true); });
}

void FunctionDesk::draft(const Felt& felt, const std::string& field, const ValueRange& values) {
  try {  // levels may rule out a function: the strength stays a number
    Scene scene = document_.scene();
    const SceneMode* mode = scene.find_mode(felt.mode);
    const std::vector<ParameterRow> rows = mode ? rows_of_mode(*mode) : std::vector<ParameterRow>();
    const auto* strength = felt.number < rows.size() ? std::get_if<Strength>(&rows[felt.number].value) : nullptr;
    if (!strength || !strength->is_constant()) return;  // changed meanwhile
    const double newtons = strength->constant_n;
    draft_ = Strength(FieldRef{field}, TransferFunction({{values.min, newtons}, {values.max, newtons}}, newtons));
    set_mode_row(scene, felt.mode, felt.number, *draft_);
    scene.check();
  } catch (const std::exception& error) {
    draft_.reset();
    return Q_EMIT said(QString::fromUtf8(error.what()), true);
  }
  open(felt);
}

void FunctionDesk::edit_mask(std::size_t mode, std::size_t mask) {
  draft_.reset();
  open({.mode = document_.scene().modes()[mode].name, .is_mask = true, .number = mask});
}

void FunctionDesk::edit_colors(std::size_t layer) {
  draft_.reset();
  seen_ = layer;
  began_with_seen_ = true;
  open();
}

void FunctionDesk::open(const Felt& felt) {
  felt_ = felt;
  began_with_seen_ = false;
  open();
}

void FunctionDesk::open() {
  refresh();
  show();
  raise();
}

void FunctionDesk::choose_seen(const Scene& scene) {
  seen_.reset();
  const SceneMode* mode = felt_ ? scene.find_mode(felt_->mode) : nullptr;
  FunctionEditor::Shown shown;
  if (!mode || !show_felt(scene, shown)) return;
  const std::vector<ViewLayer> layers = detail::layers_of(scene);
  for (std::size_t i = 0; i < layers.size() && !seen_; ++i)
    if (colors_say(layers[i], shown.field)) seen_ = i;
}

void FunctionDesk::choose_felt(const Scene& scene) {
  felt_.reset();
  const std::vector<ViewLayer> layers = detail::layers_of(scene);
  if (*seen_ >= layers.size()) return;
  for (const SceneMode& mode : scene.modes()) {
    const std::vector<ParameterRow> rows = rows_of_mode(mode);
    for (std::size_t row = 0; row < rows.size(); ++row) {
      const auto* strength = std::get_if<Strength>(&rows[row].value);
      if (!strength || strength->is_constant() || !colors_say(layers[*seen_], strength->of.name)) continue;
      felt_ = Felt{.mode = mode.name, .is_mask = false, .number = row};
      return;
    }
  }
}

bool FunctionDesk::show_felt(const Scene& scene, FunctionEditor::Shown& shown) const {
  const SceneMode* mode = scene.find_mode(felt_->mode);
  if (!mode) return false;
  const QString name = QString::fromStdString(mode->name);
  if (felt_->is_mask) {
    if (felt_->number >= mode->masks.size()) return false;
    const Mask& mask = mode->masks[felt_->number];
    shown.title = tr("Mask of %1").arg(name);
    shown.field = mask.of.name;
    shown.strength = mask.curve;
    shown.largest = 1.0;
    return true;
  }
  const std::vector<ParameterRow> rows = rows_of_mode(*mode);
  const Strength* strength = felt_->number < rows.size() ? std::get_if<Strength>(&rows[felt_->number].value) : nullptr;
  if (strength && strength->is_constant() && draft_) strength = &*draft_;
  if (!strength || strength->is_constant()) return false;
  const std::string& group = rows[felt_->number].group;
  shown.title = tr("Strength of %1").arg(group.empty() ? name : name + ", " + QString::fromStdString(group));
  shown.field = strength->of.name;
  shown.strength = strength->curve;
  shown.result_unit = "N";
  shown.largest = 0.1;
  for (const auto& point : strength->curve.points()) shown.largest = std::max(shown.largest, 1.25 * point.result);
  // Keep the scale while a point is dragged.
  if (editor_->shown().title.contains(shown.title)) shown.largest = std::max(editor_->shown().largest, shown.largest);
  return true;
}

std::optional<FunctionEditor::Shown> FunctionDesk::shown() const {
  const Scene& scene = document_.scene();
  FunctionEditor::Shown shown;
  const bool is_felt = felt_ && show_felt(scene, shown);
  const std::vector<ViewLayer> layers = detail::layers_of(scene);
  const bool is_seen = seen_ && *seen_ < layers.size();
  if (!is_felt && !is_seen) return {};
  if (is_seen) {
    const ViewLayer& layer = layers[*seen_];
    if (!is_felt) shown.field = layer.field.name;
    shown.colors = drawn_colors(layer, *scene.field(layer.field).field);
    const QString seen = tr("Transfer function of layer %1").arg(*seen_ + 1);
    shown.title = !is_felt ? seen : began_with_seen_ ? seen + " · " + shown.title : shown.title + " · " + seen;
  }
  const VolumeField named = scene.field({shown.field});
  shown.unit = named.unit;
  const std::vector<ValueRange> value_ranges = named.field->value_ranges();
  shown.low = named.field->components() == 1 ? value_ranges[0].min : 0.0;
  shown.high = value_ranges[0].max;
  for (const ValueRange& extent : value_ranges) shown.high = std::max(shown.high, extent.max);
  return shown;
}

void FunctionDesk::refresh() {
  try {
    const Scene& scene = document_.scene();
    if (began_with_seen_ && seen_) {
      choose_felt(scene);
    } else {
      choose_seen(scene);
    }
    const std::optional<FunctionEditor::Shown> now = shown();
    if (!now) return;
    const bool is_other = editor_->shown().field != now->field;
    editor_->show_functions(*now);
    if (is_other)
      jobs_.begin<Histogram>(
          Jobs::Purpose::look, tr("counting values"),
          [field = scene.field({now->field}).field](std::stop_token) { return statistics(*field).histogram; },
          [this](Histogram histogram) { editor_->show_histogram(histogram); },
          [this](const QString& why) { Q_EMIT said(why, true); });
  } catch (const std::exception& error) {
    Q_EMIT said(QString::fromUtf8(error.what()), true);
  }
}

void FunctionDesk::give_value_to_level(double value) {
  for (const SceneMode& mode : document_.scene().modes()) {
    const std::vector<ParameterRow> rows = rows_of_mode(mode);
    std::optional<std::size_t> nearest;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (rows[i].info.kind != ParameterKind::level) continue;
      const auto away = [&](std::size_t row) { return std::abs(std::get<double>(rows[row].value) - value); };
      if (!nearest || away(i) < away(*nearest)) nearest = i;
    }
    if (!nearest) continue;
    const QString words =
        tr("%1, %2: now at %3").arg(QString::fromStdString(mode.name), QString::fromStdString(rows[*nearest].group)).arg(value);
    const std::string name = mode.name;
    document_.edit(tr("level"), -1, [&](Scene& scene) { set_mode_row(scene, name, *nearest, value); });
    Q_EMIT said(words, false);
    return;
  }
}

}  // namespace palpa::explorer
