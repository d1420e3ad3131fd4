#include "resample.h"

#include <vtkStructuredGrid.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpa/field/parallel.h"
#include "palpa/volume/volume.h"

namespace palpa::reader {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

}  // namespace

void Resampler::load(const Cell& cell, CellAt& to) const {
  blocks_[static_cast<std::size_t>(cell.block)]->GetCell(cell.id, to.cell);
}

void Resampler::fill(const std::vector<PointValues>& values, const std::vector<float*>& to, std::vector<std::uint8_t>& done,
                     std::int64_t first_k, std::int64_t last_k) const {
  CellAt here(blocks_);
  const auto& dims = grid_.dims;
  const Mat3& steps = grid_.index_to_world_m;
  const double step[3] = {steps.row[0].x / unit_, steps.row[1].y / unit_, steps.row[2].z / unit_};
  const Vec3 first = (grid_.origin_m - centre_) / unit_;
  const double origin[3] = {first.x, first.y, first.z};
  for (const Cell& cell : cells_) {
    std::int64_t from[3], end[3];
    for (int a = 0; a < 3; ++a) {
      const auto n = static_cast<double>(dims[static_cast<std::size_t>(a)]);
      from[a] =
          static_cast<std::int64_t>(std::clamp(std::ceil((static_cast<double>(cell.low[a]) - origin[a]) / step[a]), 0.0, n));
      end[a] = static_cast<std::int64_t>(
          std::clamp(std::floor((static_cast<double>(cell.high[a]) - origin[a]) / step[a]) + 1.0, 0.0, n));
    }
    from[2] = std::max(from[2], first_k), end[2] = std::min(end[2], last_k);
    if (from[0] >= end[0] || from[1] >= end[1] || from[2] >= end[2]) continue;
    load(cell, here);
    const PointValues& block = values[static_cast<std::size_t>(cell.block)];
    for (std::int64_t k = from[2]; k < end[2]; ++k) {
      for (std::int64_t j = from[1]; j < end[1]; ++j) {
        for (std::int64_t i = from[0]; i < end[0]; ++i) {
          const std::int64_t voxel = i + dims[0] * (j + dims[1] * k);
          const double at[3] = {origin[0] + static_cast<double>(i) * step[0], origin[1] + static_cast<double>(j) * step[1],
                                origin[2] + static_cast<double>(k) * step[2]};
          if (done[static_cast<std::size_t>(voxel)] != 0 || !here.holds(at)) continue;
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
  }
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
      report.extents.push_back(min <= max ? Extent{static_cast<double>(min), static_cast<double>(max)} : Extent{});
    }
    std::fill_n(to[f], grid_.voxels() * arrays[f].components, nan);
  }

  std::vector<std::uint8_t> done(static_cast<std::size_t>(grid_.voxels()));
  palpa::detail::in_parts(grid_.dims[2], 1,
                          [&](std::int64_t first, std::int64_t last) { fill(values, to, done, first, last); });
  look(values, to, crop_, false, out);
  look(values, to, crop_, true, out);
  return out;
}

}  // namespace palpa::reader
