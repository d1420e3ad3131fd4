// Octaves of voxels in memory, for the tests of volumes larger than memory.
#pragma once

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "palpa/data/octaves.h"

namespace palpa::test {

/// Octaves of a grid in memory: each voxel the mean of the finer ones that exist, rounded half up for whole numbers.
class Pyramid final : public VoxelSource {
 public:
  Pyramid(const GridGeometry& finest, Voxels voxels, int count) : type_(voxels.type), components_(voxels.components) {
    dims_.push_back(finest.dims);
    levels_.push_back(std::move(voxels));
    while (static_cast<int>(levels_.size()) < count) detail::with_values_of(levels_.back(), [&](const auto* v) { halve(v); });
  }
  bool read(int octave, const std::array<std::int64_t, 3>& first, const std::array<std::int64_t, 3>& dims,
            std::byte* to) override {
    const auto& all = dims_[static_cast<std::size_t>(octave)];
    const auto* from = static_cast<const std::byte*>(levels_[static_cast<std::size_t>(octave)].data.get());
    const auto voxel = static_cast<std::int64_t>(size_of(type_)) * components_;
    for (std::int64_t k = 0; k < dims[2]; ++k) {
      for (std::int64_t j = 0; j < dims[1]; ++j, to += dims[0] * voxel) {
        const std::int64_t at = first[0] + all[0] * (first[1] + j + all[1] * (first[2] + k));
        std::memcpy(to, from + at * voxel, static_cast<std::size_t>(dims[0] * voxel));
      }
    }
    return true;
  }
  std::shared_ptr<VoxelSource> beside() const override { return std::make_shared<Pyramid>(*this); }
  int count() const { return static_cast<int>(levels_.size()); }

 private:
  template <class T>
  void halve(const T* fine) {
    const std::array<std::int64_t, 3> n = dims_.back();
    const std::array<std::int64_t, 3> m{(n[0] + 1) / 2, (n[1] + 1) / 2, (n[2] + 1) / 2};
    const std::shared_ptr<T[]> out(new T[static_cast<std::size_t>(m[0] * m[1] * m[2] * components_)]);
    T* to = out.get();
    for (std::int64_t k = 0; k < m[2]; ++k) {
      for (std::int64_t j = 0; j < m[1]; ++j) {
        for (std::int64_t i = 0; i < m[0]; ++i) {
          for (int c = 0; c < components_; ++c) {
            double sum = 0.0, count = 0.0;
            for (std::int64_t z = 2 * k; z < std::min(2 * k + 2, n[2]); ++z) {
              for (std::int64_t y = 2 * j; y < std::min(2 * j + 2, n[1]); ++y) {
                for (std::int64_t x = 2 * i; x < std::min(2 * i + 2, n[0]); ++x)
                  sum += static_cast<double>(fine[(x + n[0] * (y + n[1] * z)) * components_ + c]), count += 1.0;
              }
            }
            const double mean = sum / count;
            *to++ = static_cast<T>(std::is_integral_v<T> ? std::floor(mean + 0.5) : mean);
          }
        }
      }
    }
    dims_.push_back(m);
    levels_.push_back({type_, components_, out});
  }

  VoxelType type_;
  int components_;
  std::vector<std::array<std::int64_t, 3>> dims_;
  std::vector<Voxels> levels_;
};

/// The field of a grid as octaves, with its filter, scale and offset, of voxels up to `coarsest_m` [m].
inline std::shared_ptr<const Octaves> in_octaves(const Field& field, int count,
                                                 double coarsest_m = std::numeric_limits<double>::infinity()) {
  const GridView& view = *grid_behind(field);
  Octaves::Shape shape{view.geometry,
                       count,
                       view.voxels.type,
                       view.voxels.components,
                       view.filter,
                       view.scale,
                       view.offset,
                       field.value_ranges(),
                       std::make_shared<Pyramid>(view.geometry, view.voxels, count),
                       coarsest_m};
  return std::make_shared<const Octaves>(std::move(shape));
}

/// Window of at most `size` [voxels] along each axis, with its middle as near to a position [m] as bricks of 8 allow.
inline OctaveWindow window_about(const Octaves& octaves, int octave, const Vec3& world_m, std::int64_t size) {
  const GridGeometry& grid = octaves.sampled_grid(octave);
  const Vec3 steps = detail::scaled_inverse(grid.index_to_world_m) * (world_m - grid.origin_m);
  const double at[3] = {steps.x, steps.y, steps.z};
  std::array<std::int64_t, 3> first{}, dims{};
  for (std::size_t a = 0; a < 3; ++a) {
    const auto low = static_cast<std::int64_t>(std::floor(at[a])) - size / 2;
    first[a] = std::clamp<std::int64_t>(low, 0, std::max<std::int64_t>(grid.dims[a] - size, 0)) / 8 * 8;
    dims[a] = std::min(size, grid.dims[a] - first[a]);
    if (grid.dims[a] - first[a] < size + 8) dims[a] = grid.dims[a] - first[a];  // to the border, which a brick may overhang
  }
  return octaves.window(octave, first, dims);
}

}  // namespace palpa::test
