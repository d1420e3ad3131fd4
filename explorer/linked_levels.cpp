#include "explorer/linked_levels.h"

#include <algorithm>
#include <cmath>

#include "explorer/parameter_rows.h"
#include "palpa/scene/parts.h"
#include "palpa/view/layers.h"

namespace palpa::explorer {
namespace {

bool is_linked(const ViewLayer& layer, const FeltLevel& felt) {
  return layer.show == ViewLayer::Show::surface && layer.level == felt.value && layer.field.name == felt.field;
}

void set_level(Scene& scene, const FeltLevel& felt, double value) {
  scene.edit_mode(felt.mode,
                  [&](SceneMode& mode) { set_row([&](ParameterVisitor& v) { mode.mode.visit(v); }, felt.row, value); });
}

}  // namespace

std::vector<FeltLevel> felt_levels(const Scene& scene) {
  std::vector<FeltLevel> levels;
  for (const SceneMode& mode : scene.modes()) {
    FeltLevel felt{.mode = mode.name, .field = {}, .name = {}, .enabled = mode.enabled};
    std::string group;
    const std::vector<ParameterRow> rows = rows_of([&](ParameterVisitor& v) { look_through(mode.mode, v); });
    for (std::size_t row = 0; row < rows.size(); ++row) {
      if (rows[row].group != group) felt.name.clear();
      group = rows[row].group;
      if (const auto* field = std::get_if<FieldRef>(&rows[row].value); field && felt.field.empty()) felt.field = field->name;
      if (const auto* name = std::get_if<std::string>(&rows[row].value); name && rows[row].info.name == "name")
        felt.name = *name;
      if (rows[row].info.kind != ParameterKind::level) continue;
      felt.row = row;
      felt.value = std::get<double>(rows[row].value);
      levels.push_back(felt);
    }
  }
  return levels;
}

std::optional<FeltLevel> level_of(const Scene& scene, const ViewLayer& layer) {
  if (layer.show != ViewLayer::Show::surface || !layer.level) return {};
  std::optional<FeltLevel> nearest;
  for (const FeltLevel& felt : felt_levels(scene)) {
    if (felt.field != layer.field.name) continue;
    if (!nearest || std::abs(felt.value - *layer.level) < std::abs(nearest->value - *layer.level)) nearest = felt;
  }
  return nearest;
}

void link_levels(const Scene& before, Scene& after, const std::set<std::size_t>& loose) {
  const std::vector<FeltLevel> felt_before = felt_levels(before), felt_after = felt_levels(after);
  if (felt_before.size() != felt_after.size()) return;
  const std::vector<ViewLayer> seen_before = detail::layers_of(before);
  const auto follows = [&](std::size_t layer) { return !loose.contains(layer); };
  bool is_felt_changed = false;
  for (std::size_t i = 0; i < felt_before.size(); ++i) {
    if (felt_after[i].value == felt_before[i].value) continue;
    is_felt_changed = true;
    for (std::size_t layer = 0; layer < after.layers.size(); ++layer)
      if (follows(layer) && is_linked(after.layers[layer], felt_before[i])) after.layers[layer].level = felt_after[i].value;
  }
  if (is_felt_changed || after.layers.size() != seen_before.size()) return;
  for (std::size_t layer = 0; layer < seen_before.size(); ++layer) {
    const ViewLayer &was = seen_before[layer], &is = after.layers[layer];
    if (!follows(layer) || is.show != was.show || is.field.name != was.field.name || is.level == was.level || !is.level)
      continue;
    for (const FeltLevel& felt : felt_before)
      if (is_linked(was, felt)) set_level(after, felt, *is.level);
  }
}

}  // namespace palpa::explorer
