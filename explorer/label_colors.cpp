#include "explorer/label_colors.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpa/base/toml_problem.h"
#include "palpa/data/grid.h"
#include "palpa/data/grid_base.h"
#include "palpa/view/layers.h"

namespace palpa::explorer {
namespace {

/// Field that takes the value of the nearest voxel of a grid.
class NearestVoxels : public Field {
 public:
  NearestVoxels(FieldPtr field, const GridView& grid)
      : field_(std::move(field)), grid_(grid), to_index_(detail::scaled_inverse(grid.geometry.index_to_world_m)) {}
  int components() const noexcept override { return 1; }
  ScalarSample scalar(const Vec3& x_m) const noexcept override {
    ScalarSample sample = field_->scalar(x_m);
    const Vec3 index = to_index_ * (x_m - grid_.geometry.origin_m);
    const auto& dims = grid_.geometry.dims;
    const auto nearest = [](double along, std::int64_t size) {
      return static_cast<std::int64_t>(std::lround(std::clamp(along, 0.0, static_cast<double>(size - 1))));
    };
    if (!sample.inside) return sample;
    const std::int64_t at =
        (nearest(index.z, dims[2]) * dims[1] + nearest(index.y, dims[1])) * dims[0] + nearest(index.x, dims[0]);
    const double raw =
        detail::with_values_of(grid_.voxels, [at](const auto* voxels) { return static_cast<double>(voxels[at]); });
    sample.value = raw * grid_.scale + grid_.offset;
    return sample;
  }
  double spacing_m() const noexcept override { return field_->spacing_m(); }
  Box bounds_m() const noexcept override { return field_->bounds_m(); }
  double depth_m(const Vec3& x_m) const noexcept override { return field_->depth_m(x_m); }
  std::vector<ValueRange> value_ranges() const override { return field_->value_ranges(); }

 private:
  FieldPtr field_;
  GridView grid_;
  Mat3 to_index_;
};

/// Names and values of `labels = {…}` of the volume's table; they are fields of the volume.
std::vector<SeenLabel> said_labels(const SceneVolume& volume) {
  std::vector<SeenLabel> labels;
  if (volume.volume.fields.size() < 2 || volume.source.find("labels") == volume.source.npos) return labels;
  if (detail::problem_with_toml(volume.source)) return labels;
  try {
    const toml::table source = toml::parse(volume.source);
    const toml::table* said = source["labels"].as_table();
    if (!said) return labels;
    for (const auto& [name, value] : *said)
      labels.push_back({value.value_or(0.0), std::string(name.str()), detail::surface_color(labels.size())});
  } catch (const toml::parse_error&) {  // a body of several tables, without labels
  }
  return labels;
}

std::string name_of_map(const SceneVolume& volume) { return volume.name + "." + volume.volume.fields.front().name; }

}  // namespace

std::vector<SeenLabel> labels_of(const Scene& scene, const std::string& name) {
  for (const SceneVolume& volume : scene.volumes()) {
    if (name_of_map(volume) != name) continue;
    std::vector<SeenLabel> labels = said_labels(volume);
    const std::vector<ViewLayer> layers = detail::layers_of(scene);
    for (SeenLabel& label : labels)
      for (std::size_t i = 0; i < layers.size(); ++i)
        if (layers[i].show == ViewLayer::Show::surface && layers[i].field.name == volume.name + "." + label.name)
          label.color = detail::surface_style(scene, layers, i, true).color;
    return labels;
  }
  return {};
}

std::string name_of_label_map(const Scene& scene) {
  for (const SceneVolume& volume : scene.volumes())
    if (!said_labels(volume).empty()) return name_of_map(volume);
  return {};
}

const SeenLabel* label_at(const std::vector<SeenLabel>& labels, double value) {
  const auto found = std::ranges::find(labels, value, &SeenLabel::value);
  return found == labels.end() ? nullptr : &*found;
}

FieldPtr nearest_voxels(const FieldPtr& field) {
  const GridView* grid = grid_behind(*field);
  if (!grid || grid->voxels.components != 1 || grid->geometry.is_rectilinear()) return field;
  return std::make_shared<NearestVoxels>(field, *grid);
}

}  // namespace palpa::explorer
