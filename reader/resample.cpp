#include "resample.h"

#include <vtkStructuredGrid.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpa/base/limits.h"
#include "palpa/base/load_error.h"
#include "palpa/data/parallel.h"
#include "palpa/data/volume.h"

namespace palpa::reader {
namespace {

// Most voxels of a layer that are searched without narrowing. More: damaged cells cost more; fewer: narrowing costs more.
constexpr std::int64_t most_whole_layer = 64;

}  // namespace

void Resampler::load(const Cell& cell, CellAt& to) const {
  blocks_[static_cast<std::size_t>(cell.block)]->GetCell(cell.id, to.cell);
}

Resampler::Steps Resampler::steps() const {
  const Mat3& m = grid_.index_to_world_m;
  const Vec3 first = (grid_.origin_m - centre_) / unit_;
  return {{first.x, first.y, first.z}, {m.row[0].x / unit_, m.row[1].y / unit_, m.row[2].z / unit_}};
}

/// Voxels of an axis between two positions: the first, and the one past the last.
Resampler::Voxels Resampler::voxels_between(const Steps& steps, std::size_t axis, double low, double high) const {
  const auto n = static_cast<double>(grid_.dims[axis]);
  const auto voxel = [&](double place) { return (place - steps.origin[axis]) / steps.step[axis]; };
  return {static_cast<std::int64_t>(std::clamp(std::ceil(voxel(low)), 0.0, n)),
          static_cast<std::int64_t>(std::clamp(std::floor(voxel(high)) + 1.0, 0.0, n))};
}

void Resampler::fill(const std::vector<PointValues>& values, const std::vector<float*>& to, std::vector<std::uint8_t>& done,
                     std::int64_t first_k, std::int64_t last_k, std::atomic<std::int64_t>& tests_left) const {
  CellAt here(blocks_);
  const auto& dims = grid_.dims;
  const Steps steps = this->steps();
  for (const Cell& cell : cells_) {
    const auto low = [&](int a) { return static_cast<double>(cell.low[a]); };
    const auto high = [&](int a) { return static_cast<double>(cell.high[a]); };
    const Voxels i_box = voxels_between(steps, 0, low(0), high(0)), j_box = voxels_between(steps, 1, low(1), high(1));
    Voxels k_box = voxels_between(steps, 2, low(2), high(2));
    k_box = {std::max(k_box.first, first_k), std::min(k_box.end, last_k)};
    if (i_box.count() <= 0 || j_box.count() <= 0 || k_box.count() <= 0) continue;
    load(cell, here);
    const PointValues& block = values[static_cast<std::size_t>(cell.block)];
    const bool is_large = i_box.count() * j_box.count() > most_whole_layer;
    std::int64_t tests = 0;
    for (std::int64_t k = k_box.first; k < k_box.end; ++k) {
      Voxels i_range = i_box, j_range = j_box;
      if (is_large && !narrow(here, steps, k, i_range, j_range)) continue;
      for (std::int64_t j = j_range.first; j < j_range.end; ++j) {
        for (std::int64_t i = i_range.first; i < i_range.end; ++i) {
          const std::int64_t voxel = i + dims[0] * (j + dims[1] * k);
          if (done[static_cast<std::size_t>(voxel)] != 0) continue;
          const double at[3] = {steps.at(0, i), steps.at(1, j), steps.at(2, k)};
          ++tests;
          if (!here.holds(at)) continue;
          done[static_cast<std::size_t>(voxel)] = 1;
          const float* value = here.values(block);
          for (std::size_t f = 0; f < to.size(); ++f) {
            const int components = block.components[f];
            std::copy_n(value, components, to[f] + voxel * components);
            value += components;
          }
        }
      }
    }
    if ((tests_left -= tests) < 0)
      throw LoadError("has voxels that would be looked for in " + more_than(limit::tests_per_voxel));
  }
}

/// Narrows the range of a layer's voxels, plus half a voxel, that a cell can contain; false if none.
bool Resampler::narrow(const CellAt& cell, const Steps& steps, std::int64_t k, Voxels& i_range, Voxels& j_range) const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double low[2] = {-infinity, -infinity}, high[2] = {infinity, infinity};
  const double z = steps.at(2, k), half = 0.5 * steps.step[2];
  if (!cell.narrow(z - half, z + half, low, high)) return false;
  const auto narrowed = [&](std::size_t axis, const Voxels& box) {
    const double margin = 0.5 * steps.step[axis];
    const Voxels range = voxels_between(steps, axis, low[axis] - margin, high[axis] + margin);
    return Voxels{std::max(box.first, range.first), std::min(box.end, range.end)};
  };
  i_range = narrowed(0, i_range), j_range = narrowed(1, j_range);
  return true;
}

std::vector<Resampled> Resampler::sample(const std::vector<ArrayName>& arrays, const std::vector<float*>& to) const {
  std::vector<PointValues> values;
  for (const auto& block : blocks_) values.emplace_back(*block, arrays);

  std::vector<Resampled> out(arrays.size());
  std::int64_t points = 0;
  for (const auto& block : blocks_) points += block->GetNumberOfPoints();
  int at = 0;
  for (std::size_t f = 0; f < arrays.size(); ++f) {
    Resampling& report = out[f].report;
    report.dims = {points, 1, 1};
    if (auto* grid = blocks_.size() == 1 ? vtkStructuredGrid::SafeDownCast(blocks_.front()) : nullptr) {
      int dims[3];
      grid->GetDimensions(dims);
      report.dims = {dims[0], dims[1], dims[2]};
    }
    for (int c = 0; c < arrays[f].components; ++c, ++at) {
      float min = std::numeric_limits<float>::infinity(), max = -min;
      for (const PointValues& block : values) {
        for (std::size_t n = static_cast<std::size_t>(at); n < block.numbers.size();
             n += static_cast<std::size_t>(block.per_point)) {
          if (!std::isfinite(block.numbers[n])) continue;
          min = std::min(min, block.numbers[n]), max = std::max(max, block.numbers[n]);
        }
      }
      report.value_ranges.push_back(min <= max ? ValueRange{static_cast<double>(min), static_cast<double>(max)} : ValueRange{});
    }
    std::fill_n(to[f], grid_.voxels() * arrays[f].components, nan);
  }

  std::vector<std::uint8_t> done(static_cast<std::size_t>(grid_.voxels()));
  std::atomic<std::int64_t> tests_left =
      static_cast<std::int64_t>(limit::tests_per_voxel.most * static_cast<double>(grid_.voxels()));
  palpa::detail::in_parts(grid_.dims[2], 1,
                          [&](std::int64_t first, std::int64_t last) { fill(values, to, done, first, last, tests_left); });
  std::vector<Loss> losses[2];  // by cell, by volume
  palpa::detail::in_parts(2, 1, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t n = first; n < last; ++n) losses[n] = look(values, to, out, n == 1);
  });
  for (std::size_t f = 0; f < out.size(); ++f) {
    const Loss &by_cell = losses[0][f], &by_volume = losses[1][f];
    out[f].report.by_cell = by_cell.error;
    out[f].report.by_volume = by_volume.error;
    out[f].worst = by_volume.worst ? by_volume.worst : by_cell.worst;
  }
  return out;
}

}  // namespace palpa::reader
