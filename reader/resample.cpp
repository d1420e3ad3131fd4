#include "resample.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkGenericCell.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkStructuredGrid.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <thread>

#include "palpa/core/load_error.h"

namespace palpa::reader {
namespace {

constexpr double most_voxels = 1 << 22;   // of a mesh with fewer points than a quarter of it
constexpr double voxels_per_point = 4.0;  // of a larger one
constexpr double uneven_steps = 4.0;      // the longest step is no more than so many times the shortest
constexpr std::int64_t places = 10'000;   // looked at by cell, and again by volume
constexpr int tries = 1000;               // for a place within one cell
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

Vec3 vec(const double* p) { return {p[0], p[1], p[2]}; }

double share_of(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace

/// The numbers of the wanted arrays at the points of one block, all of a point together.
struct Resampler::Values {
  int per_point = 0;
  std::vector<int> components;
  std::vector<float> numbers;

  Values(vtkPointSet& block, const std::vector<ArrayName>& arrays) {
    for (const ArrayName& array : arrays) components.push_back(array.components), per_point += array.components;
    const vtkIdType points = block.GetNumberOfPoints();
    numbers.assign(static_cast<std::size_t>(points * per_point), nan);
    int at = 0;
    for (const ArrayName& array : arrays) {
      vtkFieldData& data = array.of_cells ? static_cast<vtkFieldData&>(*block.GetCellData()) : *block.GetPointData();
      vtkDataArray* from = data.GetArray(array.name.c_str());
      const vtkIdType count = array.of_cells ? block.GetNumberOfCells() : points;
      if (from == nullptr || from->GetNumberOfComponents() != array.components || from->GetNumberOfTuples() != count) {
        throw LoadError("has not all values of array '" + array.name + "'; check that the file is whole");
      }
      if (array.of_cells) {
        average(block, *from, at);
      } else {
        for (vtkIdType p = 0; p < points; ++p) {
          for (int c = 0; c < array.components; ++c) number(p, at + c) = static_cast<float>(from->GetComponent(p, c));
        }
      }
      at += array.components;
    }
  }

  float& number(vtkIdType point, int at) { return numbers[static_cast<std::size_t>(point * per_point + at)]; }
  const float* of(vtkIdType point) const { return numbers.data() + point * per_point; }

  /// The mean of the cells around each point.
  void average(vtkPointSet& block, vtkDataArray& from, int at) {
    std::vector<float> weights(static_cast<std::size_t>(block.GetNumberOfPoints()));
    const int count = from.GetNumberOfComponents();
    vtkNew<vtkIdList> points;
    for (vtkIdType cell = 0; cell < block.GetNumberOfCells(); ++cell) {
      if (!is_visible(block, cell)) continue;
      block.GetCellPoints(cell, points);
      for (vtkIdType n = 0; n < points->GetNumberOfIds(); ++n) {
        const vtkIdType p = points->GetId(n);
        float& weight = weights[static_cast<std::size_t>(p)];
        for (int c = 0; c < count; ++c) {
          float& mean = number(p, at + c);
          const auto value = static_cast<float>(from.GetComponent(cell, c));
          mean = weight == 0.0F ? value : mean + (value - mean) / (weight + 1.0F);
        }
        weight += 1.0F;
      }
    }
  }

  static bool is_visible(vtkPointSet& block, vtkIdType cell) {
    const vtkUnsignedCharArray* ghosts = block.GetCellGhostArray();
    return ghosts == nullptr ||
           (const_cast<vtkUnsignedCharArray*>(ghosts)->GetValue(cell) & vtkDataSetAttributes::HIDDENCELL) == 0;
  }
};

/// Whether a place lies in a cell, and the values there; each thread has its own.
struct Resampler::Locator {
  vtkNew<vtkGenericCell> cell;
  std::vector<double> weights;
  std::vector<float> found;

  explicit Locator(const Resampler& of) {
    int most = 8;
    for (const auto& block : of.blocks_) most = std::max(most, static_cast<int>(block->GetMaxCellSize()));
    weights.resize(static_cast<std::size_t>(most));
  }
  void load(const Resampler& of, const Cell& c) { of.blocks_[static_cast<std::size_t>(c.block)]->GetCell(c.id, cell); }
  bool holds(const double (&at)[3]) {
    double closest[3], parametric[3], distance2 = 0.0;
    int sub = 0;
    return cell->EvaluatePosition(at, closest, sub, parametric, distance2, weights.data()) == 1;
  }
  const float* values(const Values& of) {
    found.assign(static_cast<std::size_t>(of.per_point), 0.0F);
    for (vtkIdType n = 0; n < cell->GetNumberOfPoints(); ++n) {
      const float* point = of.of(cell->GetPointId(static_cast<int>(n)));
      const auto weight = static_cast<float>(weights[static_cast<std::size_t>(n)]);
      for (int c = 0; c < of.per_point; ++c) found[static_cast<std::size_t>(c)] += weight * point[c];
    }
    return found.data();
  }
};

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

/// Puts the points into units of a typical cell about the centre: VTK's hexahedron gives up where the volume is below 1e-20.
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
      if (!Values::is_visible(block, id)) continue;
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
      for (int a = 0; a < 3; ++a) {  // outwards by more than their rounding
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
    std::vector<double> extents;
    for (std::size_t c = 0; c < cells_.size(); c += stride) {
      extents.push_back(static_cast<double>(cells_[c].high[a]) - static_cast<double>(cells_[c].low[a]));
    }
    step[a] = 0.5 * quantile(std::move(extents), 0.25);
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
  const double most = std::max(most_voxels, voxels_per_point * points);
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
  char text[300];
  const Mat3& step = grid_.index_to_world_m;
  const double shortest = std::min({step.row[0].x, step.row[1].y, step.row[2].z});
  int length =
      std::snprintf(text, sizeof text, "has no affine grid: resampled to %lld × %lld × %lld voxels of %.3g × %.3g × %.3g",
                    static_cast<long long>(grid_.dims[0]), static_cast<long long>(grid_.dims[1]),
                    static_cast<long long>(grid_.dims[2]), step.row[0].x, step.row[1].y, step.row[2].z);
  if (bounded_ && shortest_edge_ < shortest && length > 0 && length < static_cast<int>(sizeof text)) {
    double finest = 1.0;
    for (std::size_t a = 0; a < 3; ++a) {
      const double s = a == 0 ? step.row[0].x : a == 1 ? step.row[1].y : step.row[2].z;
      finest *= static_cast<double>(grid_.dims[a] - 1) * s / shortest_edge_;
    }
    std::snprintf(text + length, sizeof text - static_cast<std::size_t>(length),
                  ", no more because memory is finite (its shortest edge would need %.1g); crop_m makes a part finer", finest);
  }
  return text;
}

std::uint64_t Resampler::working_bytes(int components) const noexcept {
  std::uint64_t points = 0;
  for (const auto& block : blocks_) points += static_cast<std::uint64_t>(block->GetNumberOfPoints());
  return points * 4 * static_cast<std::uint64_t>(components) + static_cast<std::uint64_t>(grid_.voxels()) +
         cells_.size() * sizeof(Cell);
}

void Resampler::fill(const std::vector<Values>& values, const std::vector<float*>& to, std::vector<std::uint8_t>& done,
                     std::int64_t first_k, std::int64_t last_k) const {
  Locator here(*this);
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
    here.load(*this, cell);
    const Values& block = values[static_cast<std::size_t>(cell.block)];
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

namespace {

/// The trilinear value of a grid of floats at a place [voxels], as the felt field will have it; NaN outside.
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

double range_of(const std::vector<Extent>& extents) {
  double range = 0.0;
  for (const Extent& e : extents) range = std::max(range, e.max - e.min);
  return range;
}

}  // namespace

void Resampler::look(const std::vector<Values>& values, const std::vector<float*>& to, const std::optional<Box>& crop,
                     bool by_volume, std::vector<Resampled>& out) const {
  std::vector<double> volumes;  // of the boxes, summed up
  for (const Cell& c : cells_) {
    const double box = (static_cast<double>(c.high[0]) - static_cast<double>(c.low[0])) *
                       (static_cast<double>(c.high[1]) - static_cast<double>(c.low[1])) *
                       (static_cast<double>(c.high[2]) - static_cast<double>(c.low[2]));
    volumes.push_back((volumes.empty() ? 0.0 : volumes.back()) + box);
  }
  Locator here(*this);
  std::mt19937_64 random(by_volume ? 1 : 2);
  std::vector<std::vector<double>> errors(to.size());
  std::vector<std::vector<Vec3>> bad(to.size());
  std::int64_t looked = 0;
  for (std::int64_t n = 0; n < places; ++n) {
    const auto any = static_cast<std::size_t>(share_of(random) * static_cast<double>(cells_.size()));
    const Cell* cell = &cells_[std::min(any, cells_.size() - 1)];
    if (!by_volume) here.load(*this, *cell);
    double at[3];
    Vec3 world;
    bool found = false;
    for (int t = 0; t < tries && !found; ++t) {
      if (by_volume) {
        const double share = share_of(random) * volumes.back();
        const auto hit = std::lower_bound(volumes.begin(), volumes.end(), share) - volumes.begin();
        cell = &cells_[std::min(static_cast<std::size_t>(hit), cells_.size() - 1)];
        here.load(*this, *cell);
      }
      for (int a = 0; a < 3; ++a) {
        const auto low = static_cast<double>(cell->low[a]);
        at[a] = low + share_of(random) * (static_cast<double>(cell->high[a]) - low);
      }
      world = centre_ + unit_ * vec(at);
      const bool wanted = !crop || (world.x >= crop->low_m.x && world.y >= crop->low_m.y && world.z >= crop->low_m.z &&
                                    world.x <= crop->high_m.x && world.y <= crop->high_m.y && world.z <= crop->high_m.z);
      found = wanted && here.holds(at);
    }
    if (!found) continue;  // a cell too thin to be hit
    ++looked;
    const Vec3 from = world - grid_.origin_m;
    const Mat3& step = grid_.index_to_world_m;
    const double index[3] = {from.x / step.row[0].x, from.y / step.row[1].y, from.z / step.row[2].z};
    const Values& block = values[static_cast<std::size_t>(cell->block)];
    const float* value = here.values(block);
    for (std::size_t f = 0; f < to.size(); ++f) {
      const int components = block.components[f];
      const double range = range_of(out[f].report.extents);
      double squares = 0.0;
      for (int c = 0; c < components; ++c) {
        const double d = static_cast<double>(trilinear(grid_, to[f], components, c, index) - value[c]);
        squares += d * d;
      }
      value += components;
      const double error = range > 0.0 ? std::sqrt(squares) / range : 0.0;
      if (!std::isfinite(squares)) continue;
      errors[f].push_back(error);
      if (error > much_error) bad[f].push_back(world);
    }
  }
  for (std::size_t f = 0; f < to.size(); ++f) {
    ResamplingError& report = by_volume ? out[f].report.by_volume : out[f].report.by_cell;
    report = {quantile(errors[f], 0.5), quantile(errors[f], 0.99), quantile(errors[f], 1.0),
              looked > 0 ? static_cast<double>(errors[f].size()) / static_cast<double>(looked) : 0.0};
    if (!(report.p99 > much_error)) continue;
    const auto side = [&](double Vec3::*axis, double share) {
      std::vector<double> along;
      for (const Vec3& x : bad[f]) along.push_back(x.*axis);
      return quantile(std::move(along), share);
    };
    out[f].worst = Box{{side(&Vec3::x, 0.1), side(&Vec3::y, 0.1), side(&Vec3::z, 0.1)},
                       {side(&Vec3::x, 0.9), side(&Vec3::y, 0.9), side(&Vec3::z, 0.9)}};
  }
}

std::vector<Resampled> Resampler::sample(const std::vector<ArrayName>& arrays, const std::vector<float*>& to) const {
  std::vector<Values> values;
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
      for (const Values& block : values) {
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
  const std::int64_t middle = grid_.dims[2] / 2;
  {
    const std::jthread other([&] { fill(values, to, done, 0, middle); });
    fill(values, to, done, middle, grid_.dims[2]);
  }
  look(values, to, crop_, false, out);
  look(values, to, crop_, true, out);
  return out;
}

}  // namespace palpa::reader
