// Loss of resampling cells onto an affine grid.
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "palpa/data/quantile.h"
#include "resample.h"

namespace palpa::reader {
namespace {

// Random positions at which the loss is measured, by cell and again by volume. More: slower; fewer: a less certain percentile.
constexpr std::int64_t places = 10'000;
// Tries for a position within one cell, and for all positions: damaged cells contain none. More: slower; fewer: thin cells are
// left out.
constexpr int tries = 1000;
constexpr std::int64_t all_tries = 50 * places;

double share_of(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

/// Trilinear value of a grid of floats at a position [voxels], as the resulting field has it; NaN outside.
float trilinear(const GridGeometry& grid, const float* voxels, int components, int component, const double (&at)[3]) {
  std::int64_t first[3];
  double f[3];
  for (std::size_t a = 0; a < 3; ++a) {
    const auto last = static_cast<double>(grid.dims[a] - 1);
    if (!(at[a] >= 0.0 && at[a] <= last)) return nan;
    first[a] = std::min(static_cast<std::int64_t>(at[a]), grid.dims[a] - 2);
    f[a] = at[a] - static_cast<double>(first[a]);
  }
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
    const std::int64_t voxel = first[0] + i + grid.dims[0] * (first[1] + j + grid.dims[1] * (first[2] + k));
    sum += (i ? f[0] : 1 - f[0]) * (j ? f[1] : 1 - f[1]) * (k ? f[2] : 1 - f[2]) *
           static_cast<double>(voxels[voxel * components + component]);
  }
  return static_cast<float>(sum);
}

/// Between interpolated voxels and a value, over all components.
double squared_difference(const GridGeometry& grid, const float* voxels, int components, const double* at, const float* value) {
  double squares = 0.0;
  for (int c = 0; c < components; ++c) {
    const double d = static_cast<double>(trilinear(grid, voxels, components, c, at) - value[c]);
    squares += d * d;
  }
  return squares;
}

double range_of(const std::vector<ValueRange>& value_ranges) {
  double range = 0.0;
  for (const ValueRange& e : value_ranges) range = std::max(range, e.max - e.min);
  return range;
}

/// Volumes of the cells' boxes, cumulative.
template <class Cells>
std::vector<double> volumes_of(const Cells& cells) {
  std::vector<double> volumes;
  for (const auto& c : cells) {
    const double box = (static_cast<double>(c.high[0]) - static_cast<double>(c.low[0])) *
                       (static_cast<double>(c.high[1]) - static_cast<double>(c.low[1])) *
                       (static_cast<double>(c.high[2]) - static_cast<double>(c.low[2]));
    volumes.push_back((volumes.empty() ? 0.0 : volumes.back()) + box);
  }
  return volumes;
}

/// Box of four fifths of the points along each axis.
Box inner_box(const std::vector<Vec3>& points) {
  const auto side = [&](double Vec3::*axis, double share) {
    std::vector<double> along;
    for (const Vec3& x : points) along.push_back(x.*axis);
    return detail::quantile(along, share);
  };
  return {{side(&Vec3::x, 0.1), side(&Vec3::y, 0.1), side(&Vec3::z, 0.1)},
          {side(&Vec3::x, 0.9), side(&Vec3::y, 0.9), side(&Vec3::z, 0.9)}};
}

}  // namespace

std::vector<Resampler::Loss> Resampler::look(const std::vector<PointValues>& values, const std::vector<float*>& to,
                                             const std::vector<Resampled>& sampled, bool by_volume) const {
  const std::vector<double> volumes = by_volume ? volumes_of(cells_) : std::vector<double>();
  CellAt here(blocks_);
  std::mt19937_64 random(by_volume ? 1 : 2);
  std::vector<std::vector<double>> errors(to.size());
  std::vector<std::vector<Vec3>> bad(to.size());
  std::int64_t looked = 0, tried = 0;
  for (std::int64_t n = 0; n < places; ++n) {
    const auto any = static_cast<std::size_t>(share_of(random) * static_cast<double>(cells_.size()));
    const Cell* cell = &cells_[std::min(any, cells_.size() - 1)];
    if (!by_volume) load(*cell, here);
    double at[3];
    Vec3 world;
    bool found = false;
    for (int t = 0; t < tries && tried < all_tries && !found; ++t, ++tried) {
      if (by_volume) {
        const double share = share_of(random) * volumes.back();
        const auto hit = std::lower_bound(volumes.begin(), volumes.end(), share) - volumes.begin();
        cell = &cells_[std::min(static_cast<std::size_t>(hit), cells_.size() - 1)];
        load(*cell, here);
      }
      for (int a = 0; a < 3; ++a) {
        const auto low = static_cast<double>(cell->low[a]);
        at[a] = low + share_of(random) * (static_cast<double>(cell->high[a]) - low);
      }
      world = centre_ + unit_ * vec(at);
      const bool wanted = !crop_ || (world.x >= crop_->low_m.x && world.y >= crop_->low_m.y && world.z >= crop_->low_m.z &&
                                     world.x <= crop_->high_m.x && world.y <= crop_->high_m.y && world.z <= crop_->high_m.z);
      found = wanted && here.holds(at);
    }
    if (!found) continue;  // a cell too thin to be hit
    ++looked;
    const Vec3 from = world - grid_.origin_m;
    const Mat3& step = grid_.index_to_world_m;
    const double index[3] = {from.x / step.row[0].x, from.y / step.row[1].y, from.z / step.row[2].z};
    const PointValues& block = values[static_cast<std::size_t>(cell->block)];
    const float* value = here.values(block);
    for (std::size_t f = 0; f < to.size(); ++f) {
      const int components = block.components[f];
      const double range = range_of(sampled[f].report.value_ranges);
      const double squares = squared_difference(grid_, to[f], components, index, value);
      value += components;
      const double error = range > 0.0 ? std::sqrt(squares) / range : 0.0;
      if (!std::isfinite(squares)) continue;
      errors[f].push_back(error);
      if (error > much_error) bad[f].push_back(world);
    }
  }
  std::vector<Loss> losses(to.size());
  for (std::size_t f = 0; f < to.size(); ++f) {
    ResamplingError& error = losses[f].error;
    error = {detail::quantile(errors[f], 0.5), detail::quantile(errors[f], 0.99), detail::quantile(errors[f], 1.0),
             looked > 0 ? static_cast<double>(errors[f].size()) / static_cast<double>(looked) : 0.0};
    if (!(error.p99 > much_error)) continue;
    losses[f].worst = inner_box(bad[f]);
  }
  return losses;
}

}  // namespace palpa::reader
