#include "palpa/data/holes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "palpa/data/grid_base.h"
#include "palpa/data/parallel.h"

namespace palpa::detail {
namespace {

using Depth = std::uint16_t;
constexpr Depth furthest = std::numeric_limits<Depth>::max();
constexpr std::int64_t worth_a_thread = 1 << 16;  // [voxels] fewer: thread overhead; more: idle cores

// [1] lines along the first axis processed together. More: beyond the first cache; fewer: part of a register.
constexpr std::int64_t lines_at_once = 64;

/// Neighbouring lines of voxels along an axis, processed value by value, which the compiler vectorises.
class Lines {
 public:
  /// \param costs   [unit] from each plane to the next
  /// \param stride  [voxels] from a voxel of a line to the next
  /// \param apart   [voxels] from a line to the next
  /// \param most    [1] lines at once
  Lines(const std::vector<Depth>& costs, std::int64_t stride, std::int64_t apart, std::int64_t most, int reach)
      : costs_(costs),
        count_(static_cast<std::int64_t>(costs.size()) + 1),
        stride_(stride),
        apart_(apart),
        most_(most),
        reach_(reach),
        given_(static_cast<std::size_t>(count_ * most)),
        near_(given_.size()) {}

  /// Minimum over all voxels of a line of their depth plus the path from the limit of their influence.
  /// \param width  [1] lines from the first on, at most `most`
  void spread(Depth* first, std::int64_t width) noexcept {
    for (std::int64_t n = 0; n < count_; ++n) {
      for (std::int64_t i = 0; i < width; ++i) row(given_, n)[i] = first[n * stride_ + i * apart_];
    }
    for (std::int64_t n = 0; n < count_; ++n) {
      std::copy_n(row(given_, n), width, row(near_, n));
      for (std::int64_t m = std::max<std::int64_t>(n - reach_, 0); m <= std::min(n + reach_, count_ - 1); ++m)
        lower(row(near_, n), row(given_, m), 0, width);
    }
    for (std::int64_t n = 1; n < count_; ++n) lower(row(near_, n), row(near_, n - 1), cost(n - 1), width);
    for (std::int64_t n = count_ - 2; n >= 0; --n) lower(row(near_, n), row(near_, n + 1), cost(n), width);
    for (std::int64_t n = 0; n < count_; ++n) {
      for (std::int64_t i = 0; i < width; ++i) first[n * stride_ + i * apart_] = row(near_, n)[i];
    }
  }

 private:
  Depth cost(std::int64_t n) const noexcept { return costs_[static_cast<std::size_t>(n)]; }
  Depth* row(std::vector<Depth>& rows, std::int64_t n) const noexcept { return rows.data() + n * most_; }
  static void lower(Depth* to, const Depth* from, Depth cost, std::int64_t width) noexcept {
    for (std::int64_t i = 0; i < width; ++i) {
      const auto by_way = static_cast<Depth>(std::min(from[i], static_cast<Depth>(furthest - cost)) + cost);
      to[i] = std::min(to[i], by_way);
    }
  }

  const std::vector<Depth>& costs_;
  std::int64_t count_, stride_, apart_, most_;
  int reach_;
  std::vector<Depth> given_, near_;
};

/// Weight [m] of a step of the affine along each axis: with slopes of up to 1 along all axes the total is no steeper than 1.
std::array<double, 3> steps_count_m(const GridGeometry& geometry, const Mat3& world_to_steps) noexcept {
  Vec3 slopes[3];
  std::array<double, 3> lengths_m{};
  for (std::size_t a = 0; a < 3; ++a) {
    if (geometry.dims[a] == 1) continue;
    lengths_m[a] = 1.0 / norm(world_to_steps.row[a]);
    slopes[a] = lengths_m[a] * world_to_steps.row[a];
  }
  double squared = 0.0;
  for (const double j : {1.0, -1.0}) {
    for (const double k : {1.0, -1.0}) squared = std::max(squared, norm_squared(slopes[0] + j * slopes[1] + k * slopes[2]));
  }
  for (double& length_m : lengths_m) length_m /= std::sqrt(squared);
  return lengths_m;
}

/// Sets depth zero where a component is not finite, the maximum elsewhere.
template <int components, class T>
void mark(const T* values, std::int64_t count, Depth* depths) noexcept {
  for (std::int64_t at = 0; at < count; ++at) {
    bool is_hole = false;
    for (int c = 0; c < components; ++c) is_hole |= !std::isfinite(values[at * components + c]);
    depths[at] = is_hole ? Depth{0} : furthest;
  }
}

}  // namespace

Holes::Holes(const GridGeometry& geometry, const Voxels& values, const Mat3& world_to_steps, int reach) {
  const std::int64_t nx = geometry.dims[0], ny = geometry.dims[1], nz = geometry.dims[2];
  stride_[0] = 1, stride_[1] = nx, stride_[2] = nx * ny;
  const std::array<double, 3> step_m = steps_count_m(geometry, world_to_steps);

  // Depths are multiples of a sixteenth of the shortest step, of larger units on large or very uneven grids. More parts: the
  // longest path overflows 16 bits, and the unit grows again; fewer: steps of different lengths lose precision.
  constexpr double parts = 16.0, most = furthest;
  double least_m = std::numeric_limits<double>::max(), longest_m = 0.0;
  const auto way_m = [&](std::size_t a, std::int64_t n) {
    const std::vector<double>& planes = geometry.planes[a];
    const auto at = static_cast<std::size_t>(n);
    return step_m[a] * (planes.empty() ? 1.0 : planes[at + 1] - planes[at]);
  };
  for (std::size_t a = 0; a < 3; ++a) {
    step_[a] = geometry.dims[a] > 1 ? stride_[a] : 0;
    for (std::int64_t n = 0; n + 1 < geometry.dims[a]; ++n) {
      least_m = std::min(least_m, way_m(a, n));
      longest_m += way_m(a, n);
    }
  }
  constexpr double rounding = 1e-9;  // [1] reduces the unit a little: rounding could count a whole step as 15 units
  if (longest_m > 0.0) unit_m_ = std::max(least_m / parts, longest_m / (most - 1.0)) * (1.0 - rounding);
  std::vector<Depth> costs[3];
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::int64_t n = 0; n + 1 < geometry.dims[a]; ++n)
      costs[a].push_back(static_cast<Depth>(std::min(way_m(a, n) / unit_m_, most)));
  }

  depths_.resize(static_cast<std::size_t>(nx * ny * nz), furthest);
  with_values_of(values, [&]<class T>(const T* data) {
    if constexpr (std::is_floating_point_v<T>) {
      in_parts(nz, worth_a_thread / (nx * ny) + 1, [&](std::int64_t first, std::int64_t last) {
        Lines along_i(costs[0], 1, nx, lines_at_once, reach), along_j(costs[1], nx, 1, nx, reach);
        for (std::int64_t k = first; k < last; ++k) {
          Depth* const slice = depths_.data() + k * nx * ny;
          const T* const given = data + k * nx * ny * values.components;
          values.components == 1 ? mark<1>(given, nx * ny, slice) : mark<3>(given, nx * ny, slice);
          for (std::int64_t j = 0; j < ny; j += lines_at_once) along_i.spread(slice + j * nx, std::min(lines_at_once, ny - j));
          along_j.spread(slice, nx);
        }
      });
    }
  });
  in_parts(ny, worth_a_thread / (nx * nz) + 1, [&](std::int64_t first, std::int64_t last) {
    Lines along_k(costs[2], nx * ny, 1, nx, reach);
    for (std::int64_t j = first; j < last; ++j) along_k.spread(depths_.data() + j * nx, nx);
  });
}

double Holes::depth_m(const std::int64_t (&first)[3], const double (&f)[3]) const noexcept {
  const Depth* at = depths_.data() + first[0] * stride_[0] + first[1] * stride_[1] + first[2] * stride_[2];
  const auto along_i = [&](const Depth* row) {
    const double near = row[0], far = row[step_[0]];
    return near + f[0] * (far - near);
  };
  const auto along_j = [&](const Depth* plane) {
    const double near = along_i(plane), far = along_i(plane + step_[1]);
    return near + f[1] * (far - near);
  };
  const double near = along_j(at), far = along_j(at + step_[2]);
  return unit_m_ * (near + f[2] * (far - near));
}

}  // namespace palpa::detail
