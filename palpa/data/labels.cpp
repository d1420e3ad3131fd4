#include "palpa/data/labels.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "palpa/data/grid_base.h"
#include "palpa/data/timed_field.h"

namespace palpa {
namespace {

// [1] Share of neighbours along i with equal values: about a tenth in measured data, nearly all in a label map. Less: smooth
// images of few values pass for label maps; more: maps of thin parts do not.
constexpr double same_share = 0.7;

/// Voxels of a value: total, at the border, and equal to the next one along i.
struct Count {
  std::int64_t voxels = 0, border = 0, pairs = 0, same = 0;
};

/// Count of each stored value: a table for few possible values, since a search for each voxel would dominate the analysis of a
/// file.
template <class T>
class Counts {
 public:
  Count& of(T stored) {
    if constexpr (is_table) {
      return counts_[static_cast<std::make_unsigned_t<T>>(stored)];
    } else {
      return counts_[stored];
    }
  }
  template <class Take>
  void each(const Take& take) const {
    if constexpr (is_table) {
      for (std::size_t n = 0; n < counts_.size(); ++n) {
        if (counts_[n].voxels > 0) take(static_cast<T>(n), counts_[n]);
      }
    } else {
      for (const auto& [stored, count] : counts_) take(stored, count);
    }
  }

 private:
  static constexpr bool is_table = std::is_integral_v<T> && sizeof(T) <= 2;
  static auto none() {
    if constexpr (is_table) {
      return std::vector<Count>(std::size_t{1} << (8 * sizeof(T)));
    } else {
      return std::map<T, Count>();
    }
  }
  decltype(none()) counts_ = none();
};

/// By value; empty for more than `LabelMap::most_values` values, or with fractions.
template <class T>
std::map<double, Count> counts_of(const GridView& grid, const T* voxels) {
  const auto& n = grid.geometry.dims;
  const auto value_of = [&](T stored) { return static_cast<double>(stored) * grid.scale + grid.offset; };
  Counts<T> counts;
  std::size_t values = 0;
  Count* last = nullptr;
  for (std::int64_t row = 0, at = 0; row < n[1] * n[2]; ++row) {
    const bool at_border = row % n[1] == 0 || row % n[1] == n[1] - 1 || row < n[1] || row >= n[1] * (n[2] - 1);
    for (std::int64_t i = 0; i < n[0]; ++i, ++at) {
      const bool same = last && voxels[at] == voxels[at - 1];
      if (!same) {
        if (const double value = value_of(voxels[at]); value != std::nearbyint(value)) return {};  // also NaN, unlike itself
        last = &counts.of(voxels[at]);
        if (last->voxels == 0 && ++values > LabelMap::most_values) return {};
      }
      ++last->voxels;
      last->border += at_border || i == 0 || i == n[0] - 1;
      if (i > 0) ++last->pairs, last->same += same;
    }
  }
  std::map<double, Count> by_value;
  counts.each([&](T stored, const Count& count) { by_value[value_of(stored)] = count; });
  return by_value;
}

}  // namespace

LabelMap label_map(const Field& field) {
  const GridView* grid = grid_behind(field);
  if (!grid || grid->voxels.components != 1) return {};
  const std::map<double, Count> counts =
      detail::with_values_of(grid->voxels, [&](const auto* voxels) { return counts_of(*grid, voxels); });
  if (counts.size() < 2) return {};
  const auto background = std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second.border; });
  LabelMap map{background->first, {}};
  std::int64_t pairs = 0, same = 0;
  for (const auto& [value, count] : counts) {
    if (value == map.background) continue;
    map.labels.push_back({value, count.voxels});
    pairs += count.pairs, same += count.same;
  }
  if (static_cast<double>(same) < same_share * static_cast<double>(pairs)) return {};
  std::ranges::stable_sort(map.labels, std::greater(), &Label::voxels);
  return map;
}

LabelMap label_map_unless_said(const Field& field, const Statistics& values, const std::string& unit,
                               const std::string& modality) {
  const bool open = unit.empty() && (modality.empty() || modality == "SEG");
  return open && values.whole_numbers && !looks_like_hounsfield(values, unit, modality) ? label_map(field) : LabelMap{};
}

FieldPtr label_field(const Field& field, double label) {
  if (const SeriesView* series = series_of(field)) {
    std::vector<FieldPtr> frames;
    for (const FieldPtr& frame : series->frames) frames.push_back(label_field(*frame, label));
    return time_series(std::move(frames), series->period_s, series->between_frames);
  }
  const GridView* grid = grid_behind(field);
  if (!grid || grid->voxels.components != 1) {
    throw std::invalid_argument("labels are of a grid of whole numbers; this field has none");
  }
  const std::int64_t n = grid->geometry.voxels();
  const std::shared_ptr<std::uint8_t[]> is_label(new std::uint8_t[static_cast<std::size_t>(n)]);
  detail::with_values_of(grid->voxels, [&](const auto* voxels) {
    for (std::int64_t v = 0; v < n; ++v) is_label[v] = static_cast<double>(voxels[v]) * grid->scale + grid->offset == label;
  });
  return grid_field(grid->geometry, {VoxelType::uint8, 1, is_label});
}

}  // namespace palpa
