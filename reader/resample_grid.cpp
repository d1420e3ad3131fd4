// Choice of the affine grid for resampling.
#include <vtkDataSetAttributes.h>
#include <vtkPoints.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "palpa/base/limits.h"
#include "palpa/base/load_error.h"
#include "palpa/data/quantile.h"
#include "resample.h"

namespace palpa::reader {
namespace {

constexpr double voxels_per_point = 4.0;  // for meshes with more points than the limit on voxels
// [1] Longest step over shortest. More: voxels are longer in one direction; less: more voxels.
constexpr double uneven_steps = 4.0;

}  // namespace

Resampler::Resampler(std::vector<vtkSmartPointer<vtkPointSet>> blocks, const std::optional<Box>& crop)
    : blocks_(std::move(blocks)), crop_(crop) {
  normalise();
  find_cells(crop);
  if (cells_.empty()) {
    throw LoadError(crop ? "has no cell within crop_m; give a box that meets the data"
                         : "has no cell with a volume; surfaces and lines cannot be felt as data");
  }
  choose_grid(crop);
}

/// Scales the points to units of a typical cell, about their centre: VTK's hexahedron fails if its volume is below 1e-20.
void Resampler::normalise() {
  double low[3] = {1, 1, 1}, high[3] = {-1, -1, -1};
  double cells = 0.0;
  for (const auto& block : blocks_) {
    double bounds[6];
    block->GetBounds(bounds);
    cells += static_cast<double>(block->GetNumberOfCells());
    for (int a = 0; a < 3; ++a) {
      if (!(bounds[2 * a] <= bounds[2 * a + 1])) continue;
      low[a] = low[a] <= high[a] ? std::min(low[a], bounds[2 * a]) : bounds[2 * a];
      high[a] = std::max(high[a], bounds[2 * a + 1]);
    }
  }
  double diagonal = 0.0;
  for (int a = 0; a < 3; ++a) {
    if (!std::isfinite(low[a]) || !std::isfinite(high[a])) throw LoadError("has points that are not finite; export it again");
    diagonal = std::max(diagonal, high[a] - low[a]);
  }
  if (!(diagonal > 0.0)) throw LoadError("has no cell with a volume; surfaces and lines cannot be felt as data");
  centre_ = 0.5 * (vec(low) + vec(high));
  unit_ = diagonal / std::cbrt(std::max(cells, 1.0));
  for (auto& block : blocks_) {
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    points->SetNumberOfPoints(block->GetNumberOfPoints());
    for (vtkIdType p = 0; p < block->GetNumberOfPoints(); ++p) {
      double at[3];
      block->GetPoint(p, at);
      const Vec3 x = (vec(at) - centre_) / unit_;
      points->SetPoint(p, x.x, x.y, x.z);
    }
    block->SetPoints(points);
  }
}

void Resampler::find_cells(const std::optional<Box>& crop) {
  shortest_edge_ = std::numeric_limits<double>::infinity();
  double low[3]{}, high[3]{};
  if (crop) {
    const Vec3 l = (crop->low_m - centre_) / unit_, h = (crop->high_m - centre_) / unit_;
    low[0] = l.x, low[1] = l.y, low[2] = l.z;
    high[0] = h.x, high[1] = h.y, high[2] = h.z;
  }
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double least[3] = {infinity, infinity, infinity}, greatest[3] = {-infinity, -infinity, -infinity};
  vtkNew<vtkGenericCell> cell;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    vtkPointSet& block = *blocks_[b];
    vtkUnsignedCharArray* hidden = block.GetPointGhostArray();
    for (vtkIdType id = 0; id < block.GetNumberOfCells(); ++id) {
      if (!is_visible(block, id)) continue;
      block.GetCell(id, cell);
      const int n = static_cast<int>(cell->GetNumberOfPoints());
      if (n < 4 || cell->GetCellDimension() != 3) continue;
      bool whole = true;
      for (int p = 0; p < n; ++p) {
        whole =
            whole && (hidden == nullptr || (hidden->GetValue(cell->GetPointId(p)) & vtkDataSetAttributes::HIDDENPOINT) == 0);
      }
      double bounds[6];
      cell->GetBounds(bounds);
      for (int a = 0; a < 3; ++a) {
        whole = whole && std::isfinite(bounds[2 * a]) && std::isfinite(bounds[2 * a + 1]);
        if (crop) whole = whole && bounds[2 * a] <= high[a] && bounds[2 * a + 1] >= low[a];
      }
      if (!whole) continue;
      for (int a = 0; a < 3; ++a) {
        least[a] = std::min(least[a], bounds[2 * a]);
        greatest[a] = std::max(greatest[a], bounds[2 * a + 1]);
      }
      Cell found{static_cast<std::int64_t>(b), id, {}, {}};
      for (int a = 0; a < 3; ++a) {  // widened by more than rounding
        found.low[a] = static_cast<float>(bounds[2 * a] - 1e-5 * (1.0 + std::abs(bounds[2 * a])));
        found.high[a] = static_cast<float>(bounds[2 * a + 1] + 1e-5 * (1.0 + std::abs(bounds[2 * a + 1])));
      }
      cells_.push_back(found);
      for (int p = 0; p < n; ++p) {
        for (int q = p + 1; q < std::min(n, 8); ++q) {
          double one[3], other[3];
          cell->GetPoints()->GetPoint(p, one);
          cell->GetPoints()->GetPoint(q, other);
          const double edge = unit_ * norm(vec(one) - vec(other));
          if (edge > 0.0) shortest_edge_ = std::min(shortest_edge_, edge);
        }
      }
    }
  }
  box_ = {centre_ + unit_ * vec(least), centre_ + unit_ * vec(greatest)};
}

void Resampler::choose_grid(const std::optional<Box>& crop) {
  double step[3], points = 0.0;
  for (const auto& block : blocks_) points += static_cast<double>(block->GetNumberOfPoints());
  const std::size_t stride = std::max<std::size_t>(cells_.size() / 200'000, 1);
  for (int a = 0; a < 3; ++a) {
    std::vector<double> value_ranges;
    for (std::size_t c = 0; c < cells_.size(); c += stride) {
      value_ranges.push_back(static_cast<double>(cells_[c].high[a]) - static_cast<double>(cells_[c].low[a]));
    }
    step[a] = 0.5 * detail::quantile(value_ranges, 0.25);
  }
  double box_low[3] = {box_.low_m.x, box_.low_m.y, box_.low_m.z};
  double box_high[3] = {box_.high_m.x, box_.high_m.y, box_.high_m.z};
  if (crop) {
    const Vec3 low = crop->low_m, high = crop->high_m;
    const double lows[3] = {low.x, low.y, low.z}, highs[3] = {high.x, high.y, high.z};
    for (int a = 0; a < 3; ++a) box_low[a] = std::max(box_low[a], lows[a]), box_high[a] = std::min(box_high[a], highs[a]);
  }
  const double shortest = *std::min_element(step, step + 3);
  for (int a = 0; a < 3; ++a) {
    if (!(box_low[a] < box_high[a])) throw LoadError("has no cell within crop_m; give a box that meets the data");
    step[a] = unit_ * std::min(step[a], uneven_steps * shortest);
  }
  // Both ends of every side are voxels.
  const double most = std::max(limit::resampled_voxels.most, voxels_per_point * points);
  const auto count = [&](int a) { return std::max(std::ceil((box_high[a] - box_low[a]) / step[a]), 1.0) + 1.0; };
  for (double voxels = count(0) * count(1) * count(2); voxels > most; voxels = count(0) * count(1) * count(2)) {
    bounded_ = true;
    const double longer = 1.001 * std::cbrt(voxels / most);
    for (double& s : step) s *= longer;
  }
  const double longest = std::max({box_high[0] - box_low[0], box_high[1] - box_low[1], box_high[2] - box_low[2]});
  for (int a = 0; a < 3; ++a) {
    grid_.dims[static_cast<std::size_t>(a)] = static_cast<std::int64_t>(count(a));
    step[a] = (box_high[a] - box_low[a]) / (count(a) - 1.0);
    if (!(step[a] > 1e-9 * longest)) throw LoadError("is flat: it has no volume to be felt; give a grid of three dimensions");
  }
  grid_.index_to_world_m = {{{step[0], 0, 0}, {0, step[1], 0}, {0, 0, step[2]}}};
  grid_.origin_m = vec(box_low);
}

std::string Resampler::description() const {
  if (crop_ && !bounded_) return {};  // a request that was met is no warning
  char text[300];
  const Mat3& step = grid_.index_to_world_m;
  const double shortest = std::min({step.row[0].x, step.row[1].y, step.row[2].z});
  int length = std::snprintf(text, sizeof text,
                             "has no affine grid: resampled to %lld × %lld × %lld voxels of %.3g × %.3g × %.3g of its units",
                             static_cast<long long>(grid_.dims[0]), static_cast<long long>(grid_.dims[1]),
                             static_cast<long long>(grid_.dims[2]), step.row[0].x, step.row[1].y, step.row[2].z);
  if (bounded_ && shortest_edge_ < shortest && length > 0 && length < static_cast<int>(sizeof text)) {
    double finest = 1.0;
    for (std::size_t a = 0; a < 3; ++a) {
      const double s = a == 0 ? step.row[0].x : a == 1 ? step.row[1].y : step.row[2].z;
      finest *= static_cast<double>(grid_.dims[a] - 1) * s / shortest_edge_;
    }
    std::snprintf(text + length, sizeof text - static_cast<std::size_t>(length),
                  ", no more because memory is finite (its shortest edge would need %.1g voxels); crop_m makes a part finer",
                  finest);
  }
  return text;
}

std::uint64_t Resampler::working_bytes(int components) const noexcept {
  std::uint64_t points = 0;
  for (const auto& block : blocks_) points += static_cast<std::uint64_t>(block->GetNumberOfPoints());
  return points * 4 * static_cast<std::uint64_t>(components) + static_cast<std::uint64_t>(grid_.voxels()) +
         cells_.size() * sizeof(Cell);
}

}  // namespace palpa::reader
