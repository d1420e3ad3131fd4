#include "tests/path/shapes.h"

#include <cmath>
#include <stdexcept>

#include "palpa/data/filter.h"
#include "palpa/data/grid_base.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/volume.h"

namespace palpa::test {

namespace {

// Data over a cube, from formulas; one of the two is empty.
class Formula final : public Field {
 public:
  Formula(std::function<ScalarSample(const Vec3&)> scalar, std::function<VectorSample(const Vec3&)> vector, double size_m,
          double spacing_m)
      : scalar_(std::move(scalar)), vector_(std::move(vector)), half_m_(0.5 * size_m), spacing_m_(spacing_m) {}

  int components() const noexcept override { return scalar_ ? 1 : 3; }
  ScalarSample scalar(const Vec3& x) const noexcept override { return scalar_ && holds(x) ? scalar_(x) : ScalarSample{}; }
  VectorSample vector(const Vec3& x) const noexcept override { return vector_ && holds(x) ? vector_(x) : VectorSample{}; }
  double spacing_m() const noexcept override { return spacing_m_; }
  Box bounds_m() const noexcept override { return {{-half_m_, -half_m_, -half_m_}, {half_m_, half_m_, half_m_}}; }
  double depth_m(const Vec3& x) const noexcept override { return is_finite(x) ? half_m_ - largest_component(x) : -half_m_; }
  std::vector<ValueRange> value_ranges() const override {
    return std::vector<ValueRange>(static_cast<std::size_t>(components()), {-1e6, 1e6});
  }

 private:
  bool holds(const Vec3& x) const noexcept { return is_finite(x) && largest_component(x) <= half_m_; }
  std::function<ScalarSample(const Vec3&)> scalar_;
  std::function<VectorSample(const Vec3&)> vector_;
  double half_m_;
  double spacing_m_;
};

FieldPtr with_filter(const GridGeometry& geometry, const Voxels& voxels, double scale, double offset, Filter filter) {
  switch (filter) {
    case Filter::trilinear: return grid_field(geometry, voxels, scale, offset);
    case Filter::smooth: return smooth_grid_field(geometry, voxels, scale, offset);
    case Filter::cubic: return cubic_grid_field(geometry, voxels, scale, offset);
  }
  return nullptr;
}

}  // namespace

FieldPtr sampled_depth(const Depth& depth, const GridGeometry& geometry, const Sampling& sampling, Filter filter) {
  const double voxel_m = norm(geometry.index_to_world_m * Vec3{1, 0, 0});
  const double top = sampling.ramp_voxels > 0.0 ? std::exp2(sampling.bits) - 1.0 : 1.0;
  const double ramp_m = (sampling.ramp_voxels > 0.0 ? sampling.ramp_voxels : 0.5) * voxel_m;
  auto raw = std::make_shared<std::vector<float>>();
  raw->reserve(static_cast<std::size_t>(geometry.voxels()));
  for (std::int64_t k = 0; k < geometry.dims[2]; ++k) {
    for (std::int64_t j = 0; j < geometry.dims[1]; ++j) {
      for (std::int64_t i = 0; i < geometry.dims[0]; ++i) {
        const double d = depth(geometry.to_world({double(i), double(j), double(k)}));
        const double share = sampling.ramp_voxels > 0.0 ? 0.5 + 0.5 * std::clamp(d / ramp_m, -1.0, 1.0) : (d > 0.0 ? 1.0 : 0.0);
        raw->push_back(static_cast<float>(std::round(top * share)));
      }
    }
  }
  const Voxels voxels{VoxelType::float32, 1, std::shared_ptr<const void>(raw, raw->data())};
  return with_filter(geometry, voxels, 2.0 * ramp_m / top, -ramp_m, filter);
}

FieldPtr in_floats(const Field& grid, Filter filter) {
  const GridView* view = grid_below(grid);
  if (!view) throw std::invalid_argument("the field is no grid");
  auto raw = std::make_shared<std::vector<float>>();
  detail::with_values_of(view->voxels, [&](const auto* values) {
    raw->assign(values, values + view->geometry.voxels() * view->voxels.components);
  });
  const Voxels voxels{VoxelType::float32, view->voxels.components, std::shared_ptr<const void>(raw, raw->data())};
  return with_filter(view->geometry, voxels, view->scale, view->offset, filter);
}

GridGeometry cube_of(int voxels, double voxel_m, const Mat3& turn) {
  const double half = 0.5 * (voxels - 1);
  const Mat3 steps = voxel_m * turn;
  return {{voxels, voxels, voxels}, steps, -(steps * Vec3{half, half, half})};
}

FieldPtr formula(std::function<ScalarSample(const Vec3&)> at, double size_m, double spacing_m) {
  return std::make_shared<Formula>(std::move(at), nullptr, size_m, spacing_m);
}

FieldPtr vector_formula(std::function<VectorSample(const Vec3&)> at, double size_m, double spacing_m) {
  return std::make_shared<Formula>(nullptr, std::move(at), size_m, spacing_m);
}

Volume volume_of(FieldPtr field, const char* unit) {
  Volume volume;
  volume.fields = {{"f", unit, std::move(field)}};
  volume.format = "formula";
  return volume;
}

std::optional<Filter> filter_of(const Field& field) {
  const GridView* grid = grid_behind(field);
  return grid ? std::optional(grid->filter) : std::nullopt;
}

Workspace plain_workspace() {
  Workspace workspace;
  workspace.scale = 1.0;
  workspace.center_m = Vec3{};
  workspace.towards_user = "+z";
  workspace.up = "+y";
  return workspace;
}

Scene plain_scene(const CouplingOptions& coupling) {
  Scene scene(coupling);
  scene.set(plain_workspace());
  return scene;
}

Depth groove(double opening_rad) {
  const double c = std::cos(0.5 * opening_rad);
  const double s = std::sin(0.5 * opening_rad);
  return [c, s](const Vec3& x) { return std::max(-(c * x.x + s * x.y), -(-c * x.x + s * x.y)); };
}

}  // namespace palpa::test
