#include "palpa/field/grid.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>

namespace palpa {
namespace {

/// Positions this far [voxels] beyond the first or last voxel centre count as on it: rounding of world
/// coordinates must not put a corner of the grid outside.
constexpr double face_tolerance_voxels = 1e-6;

Vec3 column(const Mat3& m, int axis) noexcept { return transposed(m).row[axis]; }

/// Inverse by way of a matrix near 1, so that steps of any length neither overflow nor lose bits: scaling
/// by a power of two scales the inverse by its reciprocal, exactly.
Mat3 scaled_inverse(const Mat3& m) noexcept {
  const double largest = std::max({largest_component(m.row[0]), largest_component(m.row[1]), largest_component(m.row[2])});
  const double factor = std::scalbn(1.0, -std::ilogb(largest));
  return factor * inverse(factor * m);
}

template <class T>
struct Range {
  T least = std::numeric_limits<T>::max();
  T greatest = std::numeric_limits<T>::lowest();
  bool any() const noexcept { return least <= greatest; }
};

/// The range of each component over its finite values; returns how many voxels are finite altogether.
template <int Components, class T>
std::int64_t find_range(const T* voxels, std::int64_t count, Range<T>* ranges) noexcept {
  std::int64_t valid = 0;
  for (std::int64_t v = 0; v < count; ++v, voxels += Components) {
    bool finite = true;
    for (int c = 0; c < Components; ++c) {
      if constexpr (std::is_floating_point_v<T>) {
        if (!std::isfinite(voxels[c])) {
          finite = false;
          continue;
        }
      }
      ranges[c].least = std::min(ranges[c].least, voxels[c]);
      ranges[c].greatest = std::max(ranges[c].greatest, voxels[c]);
    }
    valid += finite;
  }
  return valid;
}

/// All of a grid but the sampling of its type of voxel.
class Grid : public Field {
 public:
  Grid(const GridGeometry& geometry, Voxels voxels, double scale, double offset)
      : view_{geometry, std::move(voxels), scale, offset, 1.0},
        world_to_index_(scaled_inverse(geometry.index_to_world_m)),
        origin_m_(geometry.origin_m) {
    std::int64_t stride = view_.voxels.components;
    for (int a = 0; a < 3; ++a) {
      const std::int64_t n = geometry.dims[a];
      last_[a] = static_cast<double>(n - 1);
      half_[a] = n > 1 ? 0.0 : 0.5;
      beyond_[a] = half_[a] + face_tolerance_voxels;
      cells_[a] = std::max<std::int64_t>(n - 1, 1);
      stride_[a] = stride;
      neighbour_[a] = n > 1 ? stride : 0;
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
  }

  const GridView& view() const noexcept { return view_; }

  int components() const noexcept override { return view_.voxels.components; }
  double spacing_m() const noexcept override { return *std::min_element(plane_distance_m_, plane_distance_m_ + 3); }
  Box bounds_m() const noexcept override { return bounds_m_; }

  double depth_m(const Vec3& world_m) const noexcept override {
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

  std::vector<Extent> extents() const override { return extents_; }

 protected:
  /// The cell of a position: its first voxel and the fractions across it.
  struct Cell {
    std::int64_t first = 0;
    double f[3] = {0.0, 0.0, 0.0};
  };

  Vec3 index_of(const Vec3& world_m) const noexcept { return world_to_index_ * (world_m - origin_m_); }

  /// False outside; also for positions that are not finite, because every comparison with NaN fails.
  bool locate(const Vec3& world_m, Cell& cell) const noexcept {
    const Vec3 index = index_of(world_m);
    return enter<0>(index.x, cell) && enter<1>(index.y, cell) && enter<2>(index.z, cell);
  }

  template <int Axis>
  bool enter(double index, Cell& cell) const noexcept {
    if (!(index >= -beyond_[Axis] && index <= last_[Axis] + beyond_[Axis])) return false;
    const double clamped = std::min(std::max(index, 0.0), last_[Axis]);
    const std::int64_t i = std::min(static_cast<std::int64_t>(clamped), cells_[Axis] - 1);
    cell.f[Axis] = clamped - static_cast<double>(i);
    cell.first += i * stride_[Axis];
    return true;
  }

  /// Value and index derivatives of the trilinear interpolant. A corner that is not finite makes the
  /// value NaN or infinite, whatever its weight (0·∞ is NaN), so that one look at the result is enough.
  template <class T>
  double interpolate(const T* first, const double (&f)[3], Vec3& derivative) const noexcept {
    const std::int64_t di = neighbour_[0], dj = neighbour_[1], dk = neighbour_[2];
    const double c000 = static_cast<double>(first[0]);
    const double c010 = static_cast<double>(first[dj]);
    const double c001 = static_cast<double>(first[dk]);
    const double c011 = static_cast<double>(first[dj + dk]);
    const double i00 = static_cast<double>(first[di]) - c000;
    const double i10 = static_cast<double>(first[di + dj]) - c010;
    const double i01 = static_cast<double>(first[di + dk]) - c001;
    const double i11 = static_cast<double>(first[di + dj + dk]) - c011;
    const double c00 = c000 + f[0] * i00;
    const double c10 = c010 + f[0] * i10;
    const double c01 = c001 + f[0] * i01;
    const double c11 = c011 + f[0] * i11;
    const double i0 = i00 + f[1] * (i10 - i00);
    const double i1 = i01 + f[1] * (i11 - i01);
    const double j0 = c10 - c00;
    const double j1 = c11 - c01;
    const double c0 = c00 + f[1] * j0;
    const double c1 = c01 + f[1] * j1;
    derivative = {i0 + f[2] * (i1 - i0), j0 + f[2] * (j1 - j0), c1 - c0};
    return c0 + f[2] * (c1 - c0);
  }

  Vec3 gradient_of(const Vec3& index_derivative) const noexcept {
    return transposed_times(world_to_index_, view_.scale * index_derivative);
  }

  GridView view_;
  std::vector<Extent> extents_;

 private:
  Mat3 world_to_index_;
  Vec3 origin_m_;
  double last_[3];              ///< index of the last voxel
  double half_[3];              ///< [voxels] data beyond the first and last centre
  double beyond_[3];            ///< [voxels] the same, with the tolerance
  std::int64_t cells_[3];       ///< cells along each axis, at least one
  std::int64_t stride_[3];      ///< values from voxel to voxel
  std::int64_t neighbour_[3];   ///< the same within a cell; 0 along an axis of one voxel
  double plane_distance_m_[3];  ///< between neighbouring planes of voxels
  Box bounds_m_;
};

template <class T>
class TypedGrid final : public Grid {
 public:
  TypedGrid(const GridGeometry& geometry, Voxels voxels, double scale, double offset)
      : Grid(geometry, std::move(voxels), scale, offset), data_(static_cast<const T*>(view_.voxels.data.get())) {
    Range<T> ranges[3];
    const std::int64_t count = geometry.voxels();
    const std::int64_t valid = components() == 1 ? find_range<1>(data_, count, ranges) : find_range<3>(data_, count, ranges);
    view_.valid_share = static_cast<double>(valid) / static_cast<double>(count);
    for (int c = 0; c < components(); ++c) {
      extents_.push_back({});
      if (!ranges[c].any()) continue;
      const auto [min, max] = std::minmax(
          {static_cast<double>(ranges[c].least) * scale + offset, static_cast<double>(ranges[c].greatest) * scale + offset});
      if (!std::isfinite(min) || !std::isfinite(max)) {
        throw std::invalid_argument("scale and offset take the grid's values beyond the largest number; use smaller ones");
      }
      extents_.back() = {min, max};
    }
  }

  ScalarSample scalar(const Vec3& world_m) const noexcept override {
    Cell cell;
    if (view_.voxels.components != 1 || !locate(world_m, cell)) return {};
    Vec3 derivative;
    const double raw = interpolate(data_ + cell.first, cell.f, derivative);
    const ScalarSample sample{raw * view_.scale + view_.offset, gradient_of(derivative), true};
    return std::isfinite(sample.value) && is_finite(sample.gradient) ? sample : ScalarSample{};
  }

  VectorSample vector(const Vec3& world_m) const noexcept override {
    Cell cell;
    if (view_.voxels.components != 3 || !locate(world_m, cell)) return {};
    VectorSample sample;
    double value[3];
    for (int c = 0; c < 3; ++c) {
      Vec3 derivative;
      value[c] = interpolate(data_ + cell.first + c, cell.f, derivative) * view_.scale + view_.offset;
      sample.jacobian.row[c] = gradient_of(derivative);
    }
    sample.value = {value[0], value[1], value[2]};
    sample.inside = true;
    return is_finite(sample.value) && is_finite(sample.jacobian) ? sample : VectorSample{};
  }

 private:
  const T* data_;
};

template <class T>
FieldPtr typed_grid(const GridGeometry& geometry, Voxels voxels, double scale, double offset) {
  if (reinterpret_cast<std::uintptr_t>(voxels.data.get()) % alignof(T) != 0) {
    throw std::invalid_argument("the grid's voxels are not aligned in memory; place them at a multiple of their size");
  }
  return std::make_shared<const TypedGrid<T>>(geometry, std::move(voxels), scale, offset);
}

}  // namespace

const char* name_of(VoxelType type) noexcept {
  switch (type) {
    case VoxelType::uint8: return "uint8";
    case VoxelType::int16: return "int16";
    case VoxelType::uint16: return "uint16";
    case VoxelType::int32: return "int32";
    case VoxelType::float32: return "float32";
    case VoxelType::float64: return "float64";
  }
  return "unknown";
}

std::size_t size_of(VoxelType type) noexcept {
  switch (type) {
    case VoxelType::uint8: return 1;
    case VoxelType::int16:
    case VoxelType::uint16: return 2;
    case VoxelType::int32:
    case VoxelType::float32: return 4;
    case VoxelType::float64: return 8;
  }
  return 0;
}

const char* problem_with(const GridGeometry& geometry) noexcept {
  std::int64_t bytes = 3 * sizeof(double);
  for (const std::int64_t n : geometry.dims) {
    if (n < 1) return "an axis of the grid has no voxels; every axis needs at least one";
    if (__builtin_mul_overflow(bytes, n, &bytes)) return "the grid has more voxels than a computer can address";
  }
  // Far wider than any data, far from where squares and products of lengths would overflow.
  constexpr double shortest_m = 1e-75, longest_m = 1e75;
  if (!is_finite(geometry.origin_m) || !(largest_component(geometry.origin_m) <= longest_m)) {
    return "the grid's origin is not a finite position of the world";
  }
  Mat3 directions;
  for (int a = 0; a < 3; ++a) {
    const Vec3 step = column(geometry.index_to_world_m, a);
    const double length_m = norm(step);
    if (!is_finite(step) || !(length_m >= shortest_m && length_m <= longest_m)) {
      return "the step from voxel to voxel along an axis is zero or not finite; it must be a length in metres";
    }
    directions.row[a] = step / length_m;
  }
  if (!(std::abs(determinant(directions)) > 1e-6)) return "the grid's axes lie in one plane; they must span the space";
  return nullptr;
}

FieldPtr grid_field(const GridGeometry& geometry, Voxels voxels, double scale, double offset) {
  if (const char* problem = problem_with(geometry)) throw std::invalid_argument(problem);
  if (!voxels.data) throw std::invalid_argument("the grid has no voxels in memory");
  if (voxels.components != 1 && voxels.components != 3) {
    throw std::invalid_argument("the grid has " + std::to_string(voxels.components) + " components; a field has 1 or 3");
  }
  if (!std::isfinite(scale) || !std::isfinite(offset))
    throw std::invalid_argument("the grid's scale and offset must be finite");
  switch (voxels.type) {
    case VoxelType::uint8: return typed_grid<std::uint8_t>(geometry, std::move(voxels), scale, offset);
    case VoxelType::int16: return typed_grid<std::int16_t>(geometry, std::move(voxels), scale, offset);
    case VoxelType::uint16: return typed_grid<std::uint16_t>(geometry, std::move(voxels), scale, offset);
    case VoxelType::int32: return typed_grid<std::int32_t>(geometry, std::move(voxels), scale, offset);
    case VoxelType::float32: return typed_grid<float>(geometry, std::move(voxels), scale, offset);
    case VoxelType::float64: return typed_grid<double>(geometry, std::move(voxels), scale, offset);
  }
  throw std::invalid_argument("the grid's type of voxel is unknown");
}

const GridView* grid_of(const Field& field) noexcept {
  const auto* grid = dynamic_cast<const Grid*>(&field);
  return grid ? &grid->view() : nullptr;
}

namespace {

/// NaN for what a float cannot hold: its cells are outside rather than wrong.
float as_sample(double value, bool inside) noexcept {
  const bool fits = inside && std::abs(value) <= std::numeric_limits<float>::max();
  return fits ? static_cast<float>(value) : std::numeric_limits<float>::quiet_NaN();
}

}  // namespace

FieldPtr sampled(const Field& field, int longest) {
  if (longest < 2 || longest > 1024) {
    throw std::invalid_argument("a field cannot be sampled " + std::to_string(longest) +
                                " times along its longest side; 2 to 1024 can be");
  }
  const Box box = field.bounds_m();
  const double low[3] = {box.low_m.x, box.low_m.y, box.low_m.z};
  const double high[3] = {box.high_m.x, box.high_m.y, box.high_m.z};
  const double wanted_m = largest_component(box.size_m()) / (longest - 1);
  if (!std::isfinite(wanted_m) || !(wanted_m > 0.0)) throw std::invalid_argument("the field's box has no size to sample");

  // Both ends of every side are samples, so steps differ a little from axis to axis.
  GridGeometry geometry;
  double step_m[3];
  for (int a = 0; a < 3; ++a) {
    const double side_m = high[a] - low[a];
    geometry.dims[a] = std::max<std::int64_t>(std::llround(side_m / wanted_m), side_m > 0.0 ? 1 : 0) + 1;
    step_m[a] = geometry.dims[a] > 1 ? side_m / static_cast<double>(geometry.dims[a] - 1) : wanted_m;
  }
  geometry.index_to_world_m = {{{step_m[0], 0, 0}, {0, step_m[1], 0}, {0, 0, step_m[2]}}};
  geometry.origin_m = box.low_m;

  const int components = field.components();
  const std::shared_ptr<float[]> data(new float[static_cast<std::size_t>(geometry.voxels()) * components]);
  const auto fill = [&](std::int64_t first, std::int64_t last) {
    const auto place = [&](int a, std::int64_t i) { return std::min(low[a] + step_m[a] * static_cast<double>(i), high[a]); };
    float* out = data.get() + first * geometry.dims[1] * geometry.dims[0] * components;
    for (std::int64_t k = first; k < last; ++k) {
      for (std::int64_t j = 0; j < geometry.dims[1]; ++j) {
        for (std::int64_t i = 0; i < geometry.dims[0]; ++i) {
          const Vec3 at{place(0, i), place(1, j), place(2, k)};
          if (components == 1) {
            const ScalarSample s = field.scalar(at);
            *out++ = as_sample(s.value, s.inside);
          } else {
            const VectorSample s = field.vector(at);
            *out++ = as_sample(s.value.x, s.inside);
            *out++ = as_sample(s.value.y, s.inside);
            *out++ = as_sample(s.value.z, s.inside);
          }
        }
      }
    }
  };
  const std::int64_t middle = geometry.dims[2] / 2;
  {
    const std::jthread other(fill, 0, middle);
    fill(middle, geometry.dims[2]);
  }
  return grid_field(geometry, {VoxelType::float32, components, data});
}

Volume sampled(const Volume& volume, int longest) {
  Volume grids = volume;
  grids.format = "grid";
  for (VolumeField& f : grids.fields) f.field = sampled(*f.field, longest);
  return grids;
}

}  // namespace palpa
