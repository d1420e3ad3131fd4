#include "palpa/field/grid_base.h"

#include <array>
#include <string>
#include <utility>

namespace palpa::detail {
namespace {

struct Found {
  std::array<Extent, 3> ranges;  ///< raw; min > max where nothing is finite
  std::int64_t valid = 0;        ///< voxels that are finite altogether
};

template <int Components, class T>
Found find_range(const T* voxels, std::int64_t count) noexcept {
  T least[Components], greatest[Components];
  for (int c = 0; c < Components; ++c) {
    least[c] = std::numeric_limits<T>::max();
    greatest[c] = std::numeric_limits<T>::lowest();
  }
  Found found;
  for (std::int64_t v = 0; v < count; ++v, voxels += Components) {
    bool finite = true;
    for (int c = 0; c < Components; ++c) {
      if constexpr (std::is_floating_point_v<T>) {
        if (!std::isfinite(voxels[c])) {
          finite = false;
          continue;
        }
      }
      least[c] = std::min(least[c], voxels[c]);
      greatest[c] = std::max(greatest[c], voxels[c]);
    }
    found.valid += finite;
  }
  for (int c = 0; c < Components; ++c) found.ranges[c] = {static_cast<double>(least[c]), static_cast<double>(greatest[c])};
  return found;
}

}  // namespace

Mat3 scaled_inverse(const Mat3& steps_m) noexcept {
  const double largest =
      std::max({largest_component(steps_m.row[0]), largest_component(steps_m.row[1]), largest_component(steps_m.row[2])});
  const double factor = std::scalbn(1.0, -std::ilogb(largest));
  return factor * inverse(factor * steps_m);
}

void check_grid(const GridGeometry& geometry, const Voxels& voxels, double scale, double offset) {
  if (const char* problem = problem_with(geometry)) throw std::invalid_argument(problem);
  if (!voxels.data) throw std::invalid_argument("the grid has no voxels in memory");
  if (voxels.components != 1 && voxels.components != 3) {
    throw std::invalid_argument("the grid has " + std::to_string(voxels.components) + " components; a field has 1 or 3");
  }
  if (!std::isfinite(scale) || !std::isfinite(offset))
    throw std::invalid_argument("the grid's scale and offset must be finite");
  with_values_of(voxels, [&](const auto* values) {
    if (reinterpret_cast<std::uintptr_t>(values) % alignof(decltype(*values)) != 0) {
      throw std::invalid_argument("the grid's voxels are not aligned in memory; place them at a multiple of their size");
    }
  });
}

GridGeometry geometry_over(const Box& box, int samples) {
  const Vec3 size_m = box.size_m();
  const double sides_m[3] = {size_m.x, size_m.y, size_m.z};
  const double wanted_m = largest_component(size_m) / (samples - 1);
  if (!std::isfinite(wanted_m) || !(wanted_m > 0.0)) throw std::invalid_argument("the field's box has no size to sample");

  // Both ends of every side are samples, so steps differ a little from axis to axis.
  GridGeometry geometry;
  double step_m[3];
  for (int a = 0; a < 3; ++a) {
    geometry.dims[a] = std::max<std::int64_t>(std::llround(sides_m[a] / wanted_m), sides_m[a] > 0.0 ? 1 : 0) + 1;
    step_m[a] = geometry.dims[a] > 1 ? sides_m[a] / static_cast<double>(geometry.dims[a] - 1) : wanted_m;
  }
  geometry.index_to_world_m = {{{step_m[0], 0, 0}, {0, step_m[1], 0}, {0, 0, step_m[2]}}};
  geometry.origin_m = box.low_m;
  return geometry;
}

GridBase::GridBase(const GridGeometry& geometry, Voxels voxels, double scale, double offset)
    : view_{geometry, std::move(voxels), scale, offset, 1.0}, world_to_index_(scaled_inverse(geometry.index_to_world_m)) {
  std::int64_t stride = view_.voxels.components;
  for (int a = 0; a < 3; ++a) {
    const std::int64_t n = geometry.dims[a];
    last_[a] = static_cast<double>(n - 1);
    half_[a] = n > 1 ? 0.0 : 0.5;
    beyond_[a] = half_[a] + face_tolerance_voxels;
    cells_[a] = std::max<std::int64_t>(n - 1, 1);
    stride_[a] = stride;
    stride *= n;
    plane_distance_m_[a] = 1.0 / norm(world_to_index_.row[a]);
  }
  for (int corner = 0; corner < 8; ++corner) {
    const auto at = [&](int a) { return corner >> a & 1 ? last_[a] + half_[a] : -half_[a]; };
    const Vec3 world = geometry.to_world({at(0), at(1), at(2)});
    if (corner == 0) bounds_m_ = {world, world};
    bounds_m_.low_m = {std::min(bounds_m_.low_m.x, world.x), std::min(bounds_m_.low_m.y, world.y),
                       std::min(bounds_m_.low_m.z, world.z)};
    bounds_m_.high_m = {std::max(bounds_m_.high_m.x, world.x), std::max(bounds_m_.high_m.y, world.y),
                        std::max(bounds_m_.high_m.z, world.z)};
  }

  const std::int64_t count = geometry.voxels();
  const Found found = with_values_of(view_.voxels, [&](const auto* values) {
    return view_.voxels.components == 1 ? find_range<1>(values, count) : find_range<3>(values, count);
  });
  view_.valid_share = static_cast<double>(found.valid) / static_cast<double>(count);
  for (int c = 0; c < components(); ++c) {
    extents_.push_back({});
    const Extent& raw = found.ranges[c];
    if (!(raw.min <= raw.max)) continue;
    const auto [min, max] = std::minmax({raw.min * scale + offset, raw.max * scale + offset});
    if (!std::isfinite(min) || !std::isfinite(max)) {
      throw std::invalid_argument("scale and offset take the grid's values beyond the largest number; use smaller ones");
    }
    extents_.back() = {min, max};
  }
}

double GridBase::depth_m(const Vec3& world_m) const noexcept {
  const Vec3 p = index_of(world_m);
  const double index[3] = {p.x, p.y, p.z};
  double depth = std::numeric_limits<double>::max();
  for (int a = 0; a < 3; ++a) {
    const double low = index[a] + half_[a];
    const double high = last_[a] + half_[a] - index[a];
    if (!std::isfinite(low) || !std::isfinite(high)) return 0.0;
    depth = std::min(depth, std::min(low, high) * plane_distance_m_[a]);
  }
  return std::isfinite(depth) ? depth : 0.0;
}

}  // namespace palpa::detail
