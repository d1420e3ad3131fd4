#include "palpa/data/grid.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "palpa/data/grid_base.h"
#include "palpa/data/parallel.h"
#include "palpa/data/samples.h"
#include "palpa/data/unread_grid.h"

namespace palpa {
namespace {

/// [1] Least distance of planes of a rectilinear axis, as a share of its length. Less: rounding of positions swaps planes;
/// more: fine layers are refused.
constexpr double least_gap = 1e-12;

/// Common base for `grid_of`: one class for all types of voxel.
class Grid : public detail::GridBase {
 public:
  Grid(const GridGeometry& geometry, Voxels voxels, double scale, double offset, std::int64_t one_row_in,
       const GridWindow* window)
      : GridBase(geometry, std::move(voxels), scale, offset, Filter::trilinear, false, {}, one_row_in, window) {
    for (int a = 0; a < 3; ++a) neighbour_[a] = geometry.dims[a] > 1 ? stride_[a] : 0;
  }

  virtual void sample(const double* places_m, std::int64_t count, double* values, double* gradients) const noexcept = 0;

 protected:
  /// Value and index derivatives of the trilinear interpolant. A non-finite corner makes the value NaN or infinite at any
  /// weight (0·∞ is NaN), so that one check of the result is enough.
  template <class T>
  double interpolate(const T* voxels, const Cell (&cells)[3], Vec3& derivative) const noexcept {
    const T* first = voxels + offset_of(cells[0].first, cells[1].first, cells[2].first);
    const double f[3] = {cells[0].f, cells[1].f, cells[2].f};
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

  /// Prefetches the voxels about a cell for a following sample.
  template <class T>
  void fetch(const T* voxels, const Cell (&cells)[3]) const noexcept {
    const T* first = voxels + offset_of(cells[0].first, cells[1].first, cells[2].first);
    for (const T* row : {first, first + neighbour_[1], first + neighbour_[2], first + neighbour_[1] + neighbour_[2]})
      __builtin_prefetch(row);
  }

  /// The trilinear value along a straight piece is a cubic: its Bernstein coefficients are the means of the values at the
  /// corners of the box about the piece that are as many steps away from its start.
  template <class T>
  void cubic(const T* voxels, const Passage& cell, double (&control)[10]) const noexcept {
    const T* first = voxels + offset_of(cell.first[0], cell.first[1], cell.first[2]);
    double along_i[2][2][2];  // [end of the piece along i][side along j][side along k]
    for (int k = 0; k < 2; ++k) {
      for (int j = 0; j < 2; ++j) {
        const T* row = first + j * neighbour_[1] + k * neighbour_[2];
        const double c = static_cast<double>(row[0]), d = static_cast<double>(row[neighbour_[0]]) - c;
        along_i[0][j][k] = c + cell.begin[0] * d;
        along_i[1][j][k] = c + cell.end[0] * d;
      }
    }
    double sum[4]{};
    for (int i = 0; i < 2; ++i) {
      for (int j = 0; j < 2; ++j) {
        const double f = j == 0 ? cell.begin[1] : cell.end[1];
        const double c0 = along_i[i][0][0] + f * (along_i[i][1][0] - along_i[i][0][0]);
        const double c1 = along_i[i][0][1] + f * (along_i[i][1][1] - along_i[i][0][1]);
        sum[i + j] += c0 + cell.begin[2] * (c1 - c0);
        sum[i + j + 1] += c0 + cell.end[2] * (c1 - c0);
      }
    }
    control[0] = sum[0];
    control[1] = sum[1] / 3.0;
    control[2] = sum[2] / 3.0;
    control[3] = sum[3];
  }

 private:
  std::int64_t neighbour_[3];  ///< offset of the value on the other side of a cell; 0 along an axis of one voxel
};

template <class T>
class TypedGrid final : public Grid {
 public:
  TypedGrid(const GridGeometry& geometry, Voxels voxels, double scale, double offset, std::int64_t one_row_in,
            const GridWindow* window)
      : Grid(geometry, std::move(voxels), scale, offset, one_row_in, window),
        data_(static_cast<const T*>(view_.voxels.data.get())) {}

  ScalarSample scalar_in(Place& place) const noexcept override {
    if (view_.voxels.components != 1 || !place.inside) return {};
    const Cell(&cells)[3] = place.cells;
    Vec3 derivative;
    const double raw = interpolate(data_, cells, derivative);
    const ScalarSample sample{raw * view_.scale + view_.offset, gradient_of(derivative, cells), true};
    return std::isfinite(sample.value) && is_finite(sample.gradient) ? sample : ScalarSample{};
  }

  VectorSample vector_in(Place& place) const noexcept override {
    if (view_.voxels.components != 3 || !place.inside) return {};
    const Cell(&cells)[3] = place.cells;
    VectorSample sample;
    double value[3];
    for (int c = 0; c < 3; ++c) {
      Vec3 derivative;
      value[c] = interpolate(data_ + c, cells, derivative) * view_.scale + view_.offset;
      sample.jacobian.row[c] = gradient_of(derivative, cells);
    }
    sample.value = {value[0], value[1], value[2]};
    sample.inside = true;
    return is_finite(sample.value) && is_finite(sample.jacobian) ? sample : VectorSample{};
  }

  void sample(const double* places_m, std::int64_t count, double* values, double* gradients) const noexcept override {
    // [1] Places prefetched at once. More: the first are evicted from the cache; fewer: the processor stalls.
    constexpr std::int64_t group = 32;
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    Place places[group];
    for (std::int64_t begin = 0; begin < count; begin += group) {
      const std::int64_t here = std::min(group, count - begin);
      for (std::int64_t n = 0; n < here; ++n) {
        const double* const p = places_m + 3 * (begin + n);
        locate({p[0], p[1], p[2]}, places[n]);
        if (places[n].inside) fetch(data_, places[n].cells);
      }
      for (std::int64_t n = 0; n < here; ++n) {
        const ScalarSample s = TypedGrid::scalar_in(places[n]);
        values[begin + n] = s.inside ? s.value : none;
        double* const g = gradients + 3 * (begin + n);
        g[0] = s.inside ? s.gradient.x : none, g[1] = s.inside ? s.gradient.y : none, g[2] = s.inside ? s.gradient.z : none;
      }
    }
  }

 protected:
  void polynomial(int component, const Passage& cell, const ValueRange&, PolynomialPiece& piece) const noexcept override {
    cubic(data_ + component, cell, piece.control);
    piece.degree = 3;
  }

 private:
  const T* data_;
};

FieldPtr made(const GridGeometry& geometry, Voxels voxels, double scale, double offset, std::int64_t one_row_in,
              const GridWindow* window = nullptr) {
  detail::check_grid(geometry, voxels, scale, offset);
  return detail::with_values_of(voxels, [&]<class T>(const T*) -> FieldPtr {
    return std::make_shared<const TypedGrid<T>>(geometry, std::move(voxels), scale, offset, one_row_in, window);
  });
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

const char* name_of(Filter filter) noexcept {
  switch (filter) {
    case Filter::trilinear: return "trilinear";
    case Filter::smooth: return "smooth";
    case Filter::cubic: return "cubic";
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

Vec3 GridGeometry::among_planes(const GridPoint& p) const noexcept {
  const auto along = [this](std::size_t axis, double index) {
    const std::vector<double>& at = planes[axis];
    if (at.empty()) return index;
    const auto cell = static_cast<std::size_t>(std::clamp(index, 0.0, static_cast<double>(at.size() - 2)));
    return at[cell] + (index - static_cast<double>(cell)) * (at[cell + 1] - at[cell]);
  };
  return {along(0, p.i), along(1, p.j), along(2, p.k)};
}

const char* problem_with(const GridGeometry& geometry) noexcept {
  std::int64_t bytes = 3 * sizeof(double);
  for (const std::int64_t n : geometry.dims) {
    if (n < 1) return "an axis of the grid has no voxels; every axis needs at least one";
    if (__builtin_mul_overflow(bytes, n, &bytes)) return "the grid has more voxels than a computer can address";
  }
  // Far beyond any data. Wider limits: squares and products of lengths could overflow.
  constexpr double shortest_m = 1e-75, longest_m = 1e75;
  if (!is_finite(geometry.origin_m) || !(largest_component(geometry.origin_m) <= longest_m)) {
    return "the grid's origin is not a finite position of the world";
  }
  Mat3 directions;
  for (int a = 0; a < 3; ++a) {
    const Vec3 step = transposed(geometry.index_to_world_m).row[a];
    const double length_m = norm(step);
    if (!is_finite(step) || !(length_m >= shortest_m && length_m <= longest_m)) {
      return "the step from voxel to voxel along an axis is zero or not finite; it must be a length in metres";
    }
    directions.row[a] = step / length_m;
  }
  if (!(std::abs(determinant(directions)) > 1e-6)) return "the grid's axes lie in one plane; they must span the space";
  for (std::size_t a = 0; a < 3; ++a) {
    const std::vector<double>& at = geometry.planes[a];
    if (at.empty()) continue;
    const auto last = static_cast<double>(geometry.dims[a] - 1);
    if (at.size() < 2 || static_cast<std::int64_t>(at.size()) != geometry.dims[a] || at.front() != 0.0 || at.back() != last) {
      return "the planes of a rectilinear axis are not one for each voxel, from 0 to the last index";
    }
    for (std::size_t i = 1; i < at.size(); ++i) {
      if (!(at[i] - at[i - 1] > least_gap * last)) return "the planes along an axis of the grid do not rise, or are too close";
    }
  }
  return nullptr;
}

GridGeometry rectilinear_geometry(const std::array<std::vector<double>, 3>& coordinates_m) {
  GridGeometry grid;
  double steps_m[3], least_m = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < 3; ++a) {
    const std::vector<double>& at = coordinates_m[a];
    if (at.empty()) throw std::invalid_argument("the grid has no coordinates along an axis");
    grid.dims[a] = static_cast<std::int64_t>(at.size());
    const auto last = static_cast<double>(at.size() - 1);
    steps_m[a] = at.size() > 1 ? (at.back() - at.front()) / last : 0.0;
    if (!std::isfinite(steps_m[a]) || !std::isfinite(at.front()) || (at.size() > 1 && steps_m[a] == 0.0)) {
      throw std::invalid_argument("the grid's coordinates along an axis begin and end at one place, or are not finite");
    }
    if (at.size() > 1) least_m = std::min(least_m, std::abs(steps_m[a]));
    const double rounding_m = std::numeric_limits<float>::epsilon() * std::max(std::abs(at.front()), std::abs(at.back()));
    bool even = true;
    for (std::size_t i = 0; i < at.size(); ++i) {
      even = even && std::abs(at[i] - (at.front() + static_cast<double>(i) * steps_m[a])) <= rounding_m;
    }
    if (even) continue;
    for (const double x_m : at) grid.planes[a].push_back((x_m - at.front()) / steps_m[a]);
    grid.planes[a].back() = last;
  }
  for (double& step_m : steps_m) {
    if (step_m == 0.0) step_m = std::isfinite(least_m) ? least_m : 1.0;
  }
  grid.index_to_world_m = {{{steps_m[0], 0, 0}, {0, steps_m[1], 0}, {0, 0, steps_m[2]}}};
  grid.origin_m = {coordinates_m[0].front(), coordinates_m[1].front(), coordinates_m[2].front()};
  if (const char* problem = problem_with(grid)) throw std::invalid_argument(problem);
  return grid;
}

FieldPtr grid_field(const GridGeometry& geometry, Voxels voxels, double scale, double offset) {
  return made(geometry, std::move(voxels), scale, offset, 0);
}

FieldPtr preview_grid_field(const GridGeometry& geometry, Voxels voxels, double scale, double offset, std::int64_t one_row_in) {
  return made(geometry, std::move(voxels), scale, offset, one_row_in);
}

FieldPtr detail::trilinear_window(const GridGeometry& whole, const GridWindow& window, Voxels voxels, double scale,
                                  double offset) {
  return made(whole, std::move(voxels), scale, offset, 0, &window);
}

const GridView* grid_of(const Field& field) noexcept {
  const auto* grid = dynamic_cast<const Grid*>(&field);
  return grid ? &grid->view() : detail::view_read_now(field);
}

namespace detail {

void sample_scalars(const Field& given, const double* places_m, std::int64_t count, double* values,
                    double* gradients) noexcept {
  const Field& field = sampler_of(given);
  if (const auto* grid = dynamic_cast<const Grid*>(&field)) return grid->sample(places_m, count, values, gradients);
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  for (std::int64_t n = 0; n < count; ++n, places_m += 3, gradients += 3) {
    const ScalarSample s = field.scalar({places_m[0], places_m[1], places_m[2]});
    values[n] = s.inside ? s.value : none;
    const Vec3 gradient = s.inside ? s.gradient : Vec3{none, none, none};
    gradients[0] = gradient.x, gradients[1] = gradient.y, gradients[2] = gradient.z;
  }
}

}  // namespace detail
}  // namespace palpa
