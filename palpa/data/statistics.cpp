#include "palpa/data/statistics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <numeric>
#include <type_traits>

#include "palpa/data/grid_base.h"
#include "palpa/data/halton.h"
#include "palpa/data/octave_parts.h"
#include "palpa/data/parallel.h"
#include "palpa/data/row_samples.h"

namespace palpa {
namespace {

// [1] Classes of the histogram. More: memory and time; fewer: coarser percentiles and levels.
constexpr std::size_t classes = 4096;
// [1] Places at which a field without voxels is sampled. More: slower; fewer: less certain, and thin features are missed.
constexpr int places_without_voxels = 1 << 18;
// [1] Parts of the values with sums of their own, equal on every computer, for reproducible sums. More: memory, a histogram for
// each; fewer: idle cores.
constexpr std::int64_t parts = 16;

/// Numbers of samples, in order: of rows of a grid, places, stored numbers.
struct Part {
  std::int64_t first = 0, last = 0;
};

/// Sums over the values of a part. The first pass finds the smallest and largest value; the second counts values in classes
/// between these and sums their distances from the middle.
struct Sums {
  std::int64_t counted = 0, zeros = 0, max_at = 0;
  double min = std::numeric_limits<double>::infinity(), max = -std::numeric_limits<double>::infinity();
  double mean = 0.0, squares = 0.0;  ///< sums of the distances from that middle, and of their squares
  bool whole_numbers = true;
  std::vector<std::int64_t> counts;

  void look(double value, std::int64_t at, std::int64_t times) noexcept {
    counted += times;
    if (value == 0.0) zeros += times;
    if (value > max) max = value, max_at = at;
    min = std::min(min, value);
    whole_numbers = whole_numbers && value == std::nearbyint(value);
  }
  void join(const Sums& other) noexcept {
    if (other.counted == 0) return;
    if (other.max > max || counted == 0) max_at = other.max_at;
    counted += other.counted, zeros += other.zeros;
    min = std::min(min, other.min), max = std::max(max, other.max);
    whole_numbers = whole_numbers && other.whole_numbers;
  }
};

/// Calls `each(value, index of the voxel, 1)` with every finite value of some rows of a grid.
template <class T, class Each>
void for_each_value(const GridView& grid, const T* voxels, const detail::RowSamples& rows, const Part& part, Each&& each) {
  const std::int64_t width = grid.geometry.dims[0];
  for (std::int64_t sample = part.first; sample < part.last; ++sample) {
    const std::int64_t begin = rows[sample] * width;
    for (std::int64_t at = begin; at < begin + width; ++at) {
      double value = 0.0;
      if (grid.voxels.components == 1) {
        value = static_cast<double>(voxels[at]) * grid.scale + grid.offset;
      } else {
        const T* v = voxels + 3 * at;
        value = norm(Vec3{static_cast<double>(v[0]) * grid.scale + grid.offset,
                          static_cast<double>(v[1]) * grid.scale + grid.offset,
                          static_cast<double>(v[2]) * grid.scale + grid.offset});
      }
      if (std::isfinite(value)) each(value, at, std::int64_t{1});
    }
  }
}

/// Frequency of each stored number in rows of a grid, by the number minus the least of its type: short types have few, from
/// which the statistics follow in a fraction of the time of visiting each value.
template <class T>
std::vector<std::int64_t> times_stored(const GridView& grid, const T* voxels, const detail::RowSamples& rows) {
  constexpr std::int64_t least_rows = 256;  // [1] for a thread of its own. More: idle cores; fewer: tables cost more
  constexpr auto numbers = std::size_t{1} << (8 * sizeof(T));
  const std::int64_t width = grid.geometry.dims[0];
  std::vector<std::int64_t> times(numbers, 0);
  std::mutex mutex;
  detail::in_parts(rows.count(), least_rows, [&](std::int64_t first, std::int64_t last) {
    std::vector<std::int64_t> here(numbers, 0);
    for (std::int64_t sample = first; sample < last; ++sample) {
      const T* const begin = voxels + rows[sample] * width;
      for (const T* v = begin; v != begin + width; ++v) ++here[static_cast<std::size_t>(*v - std::numeric_limits<T>::min())];
    }
    const std::lock_guard lock(mutex);
    std::transform(here.begin(), here.end(), times.begin(), times.begin(), std::plus());
  });
  return times;
}

/// Index of the first voxel, in rows of a grid, that stores a number; it exists.
template <class T>
std::int64_t first_with(const GridView& grid, const T* voxels, const detail::RowSamples& rows, T stored) {
  const std::int64_t width = grid.geometry.dims[0];
  for (std::int64_t sample = 0; sample < rows.count(); ++sample) {
    const T* const begin = voxels + rows[sample] * width;
    if (const T* const found = std::find(begin, begin + width, stored); found != begin + width) return found - voxels;
  }
  return 0;
}

/// Calls `act(part, sums)` once for each of the `parts` parts of the samples, on all cores.
template <class Act>
void in_all_parts(std::int64_t samples, std::vector<Sums>& sums, const Act& act) {
  detail::in_parts(parts, 1, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t part = first; part < last; ++part) {
      act(Part{samples * part / parts, samples * (part + 1) / parts}, sums[static_cast<std::size_t>(part)]);
    }
  });
}

/// Both passes over the values; `for_values(part, each)` calls `each` with the values of a part.
template <class ForValues>
Statistics looked_at(std::int64_t samples, const ForValues& for_values) {
  std::vector<Sums> sums(parts);
  in_all_parts(samples, sums, [&](const Part& part, Sums& to) {
    for_values(part, [&](double value, std::int64_t at, std::int64_t times) { to.look(value, at, times); });
  });
  Sums whole = sums.front();
  for (auto part = sums.begin() + 1; part != sums.end(); ++part) whole.join(*part);
  Statistics result;
  if (whole.counted == 0) {
    result.histogram.counts.assign(1, 0);
    return result;
  }
  result.counted = whole.counted, result.zeros = whole.zeros;
  result.min = whole.min, result.max = whole.max, result.whole_numbers = whole.whole_numbers;
  result.max_at.i = static_cast<double>(whole.max_at);  // index of a voxel, which the caller turns into indices
  Histogram& histogram = result.histogram;
  histogram.low = whole.min, histogram.high = whole.max;
  histogram.counts.assign(whole.max > whole.min ? classes : 1, 0);

  // Distances from the middle instead of values: squares of large values would round small differences away.
  const double middle = 0.5 * whole.min + 0.5 * whole.max;
  const double per_unit = whole.max > whole.min ? static_cast<double>(histogram.counts.size()) / (whole.max - whole.min) : 0.0;
  const auto last = static_cast<double>(histogram.counts.size() - 1);
  in_all_parts(samples, sums, [&](const Part& part, Sums& to) {
    to.counts.assign(histogram.counts.size(), 0);
    double sum = 0.0, squares = 0.0;
    for_values(part, [&](double value, std::int64_t, std::int64_t times) {
      const double apart = value - middle, weight = static_cast<double>(times);
      sum += weight * apart, squares += weight * apart * apart;
      const double number = (value - whole.min) * per_unit;
      to.counts[static_cast<std::size_t>(number < last ? number : last)] += times;
    });
    to.mean = sum, to.squares = squares;
  });
  const auto n = static_cast<double>(whole.counted);
  double sum = 0.0, squares = 0.0;
  for (const Sums& part : sums) {
    sum += part.mean, squares += part.squares;
    std::transform(part.counts.begin(), part.counts.end(), histogram.counts.begin(), histogram.counts.begin(), std::plus());
  }
  const double apart = sum / n;
  result.mean = middle + apart;
  result.deviation = std::sqrt(std::max(0.0, squares / n - apart * apart));
  return result;
}

/// `looked_at` from the frequencies of stored numbers.
template <class T>
Statistics of_stored(const GridView& grid, const T* voxels, const detail::RowSamples& rows) {
  const std::vector<std::int64_t> times = times_stored(grid, voxels, rows);
  Statistics found = looked_at(std::ssize(times), [&](const Part& part, const auto& each) {
    for (std::int64_t n = part.first; n < part.last; ++n) {
      const double value = static_cast<double>(n + std::numeric_limits<T>::min()) * grid.scale + grid.offset;
      if (const std::int64_t here = times[static_cast<std::size_t>(n)]; here > 0 && std::isfinite(value)) each(value, n, here);
    }
  });
  const auto largest = static_cast<std::int64_t>(found.max_at.i) + std::numeric_limits<T>::min();
  found.max_at.i = static_cast<double>(first_with(grid, voxels, rows, static_cast<T>(largest)));
  return found;
}

}  // namespace

double Histogram::edge(std::size_t number) const noexcept {
  const double share = static_cast<double>(number) / static_cast<double>(counts.size());
  return (1.0 - share) * low + share * high;
}

std::int64_t Histogram::total() const noexcept { return std::accumulate(counts.begin(), counts.end(), std::int64_t{0}); }

Histogram Histogram::in_classes(std::size_t wanted) const {
  Histogram coarse{low, high, std::vector<std::int64_t>(std::clamp<std::size_t>(wanted, 1, counts.size()), 0)};
  for (std::size_t c = 0; c < counts.size(); ++c) coarse.counts[c * coarse.counts.size() / counts.size()] += counts[c];
  return coarse;
}

double Histogram::percentile(double share) const noexcept {
  const double wanted = share * static_cast<double>(total());
  double below = 0.0;
  for (std::size_t c = 0; c < counts.size(); ++c) {
    const auto here = static_cast<double>(counts[c]);
    if (here > 0.0 && below + here >= wanted) {
      const double part = std::clamp((wanted - below) / here, 0.0, 1.0);
      return (1.0 - part) * edge(c) + part * edge(c + 1);
    }
    below += here;
  }
  return high;
}

double Histogram::share_between(double from, double to) const noexcept {
  double inside = 0.0;
  const double width = edge(1) - low;
  for (std::size_t c = 0; c < counts.size(); ++c) {
    if (counts[c] == 0 || edge(c + 1) < from || edge(c) > to) continue;
    const double covered = std::min(to, edge(c + 1)) - std::max(from, edge(c));
    inside += static_cast<double>(counts[c]) * (width > 0.0 ? std::clamp(covered / width, 0.0, 1.0) : 1.0);
  }
  const std::int64_t all = total();
  return all > 0 ? inside / static_cast<double>(all) : 0.0;
}

double Histogram::mean_between(double from, double to) const noexcept {
  double sum = 0.0, inside = 0.0;
  for (std::size_t c = 0; c < counts.size(); ++c) {
    const double middle = 0.5 * (edge(c) + edge(c + 1));
    if (middle < from || middle > to) continue;
    sum += static_cast<double>(counts[c]) * middle, inside += static_cast<double>(counts[c]);
  }
  return inside > 0.0 ? sum / inside : 0.5 * (from + to);
}

double Statistics::percentile(double share) const noexcept {
  const double value = histogram.percentile(share);
  const double width = (histogram.high - histogram.low) / static_cast<double>(histogram.counts.size());
  if (!(width > 0.0)) return value;
  const auto last = static_cast<double>(histogram.counts.size() - 1);
  // A value on the edge of two classes is the upper end of the lower one.
  const auto c = static_cast<std::size_t>(std::clamp(std::ceil((value - histogram.low) / width) - 1.0, 0.0, last));
  if (whole_numbers && width <= 1.0) return std::ceil(histogram.edge(c) - 1e-6 * width) + 0.0;  // zero without a sign
  const bool around_zero = histogram.edge(c) <= 0.0 && histogram.edge(c + 1) >= 0.0;
  return around_zero && 2 * zeros > histogram.counts[c] ? 0.0 : value;
}

Statistics statistics(const Field& field, std::int64_t most) {
  if (const Octaves* octaves = octaves_below(field)) return sample_statistics(*octaves, octave_sample(*octaves));
  const GridView* grid = grid_behind(field);
  if (!grid) {
    const Box box = field.bounds_m();
    const auto for_places = [&](const Part& part, const auto& each) {
      for (std::int64_t n = part.first; n < part.last; ++n) {
        const Vec3 place = detail::halton(static_cast<int>(n) + 1, box);
        if (field.components() == 1) {
          if (const ScalarSample s = field.scalar(place); s.inside) each(s.value, n, std::int64_t{1});
        } else if (const VectorSample v = field.vector(place); v.inside) {
          each(norm(v.value), n, std::int64_t{1});
        }
      }
    };
    Statistics found = looked_at(places_without_voxels, for_places);
    found.max_at = {};
    return found;
  }
  const auto& dims = grid->geometry.dims;
  const std::int64_t step = std::max<std::int64_t>(1, (grid->geometry.voxels() + most - 1) / std::max<std::int64_t>(most, 1));
  const detail::RowSamples rows{dims[1] * dims[2], step};
  Statistics found = detail::with_values_of(grid->voxels, [&]<class T>(const T* voxels) {
    if constexpr (std::is_integral_v<T> && sizeof(T) <= 2) {
      if (grid->voxels.components == 1) return of_stored(*grid, voxels, rows);
    }
    return looked_at(rows.count(),
                     [&](const Part& part, const auto& each) { for_each_value(*grid, voxels, rows, part, each); });
  });
  found.one_in = step;
  const auto at = static_cast<std::int64_t>(found.max_at.i);
  found.max_at = {static_cast<double>(at % dims[0]), static_cast<double>(at / dims[0] % dims[1]),
                  static_cast<double>(at / dims[0] / dims[1])};
  return found;
}

Statistics statistics(std::span<const FieldPtr> grids) {
  const auto for_grids = [&](const Part& part, const auto& each) {
    for (std::int64_t n = part.first; n < part.last; ++n) {
      const GridView& grid = *grid_behind(*grids[static_cast<std::size_t>(n)]);
      const detail::RowSamples rows{grid.geometry.dims[1] * grid.geometry.dims[2]};
      detail::with_values_of(grid.voxels,
                             [&](const auto* voxels) { for_each_value(grid, voxels, rows, {0, rows.rows}, each); });
    }
  };
  Statistics found = looked_at(std::ssize(grids), for_grids);
  found.max_at = {};
  return found;
}

std::optional<double> dividing_value(const Histogram& histogram, double from, double to) {
  double all = 0.0, sum = 0.0;
  std::size_t filled = 0;
  const auto middle = [&](std::size_t c) { return 0.5 * (histogram.edge(c) + histogram.edge(c + 1)); };
  const auto counts = [&](std::size_t c) {
    return middle(c) >= from && middle(c) <= to ? static_cast<double>(histogram.counts[c]) : 0.0;
  };
  for (std::size_t c = 0; c < histogram.counts.size(); ++c) {
    all += counts(c), sum += counts(c) * middle(c);
    filled += counts(c) > 0.0;
  }
  if (filled < 2) return std::nullopt;
  // If no value lies between two classes, all cuts there are equal, to rounding: the middle one is used.
  double below = 0.0, sum_below = 0.0, best = -1.0;
  std::size_t first_best = 0, last_best = 0;
  for (std::size_t c = 0; c + 1 < histogram.counts.size(); ++c) {
    below += counts(c), sum_below += counts(c) * middle(c);
    if (below == 0.0 || below == all) continue;
    const double apart = sum_below / below - (sum - sum_below) / (all - below);
    const double between = below * (all - below) * apart * apart;
    if (between > best * (1.0 + 1e-12)) best = between, first_best = c;
    if (between >= best) last_best = c;
  }
  return 0.5 * (histogram.edge(first_best + 1) + histogram.edge(last_best + 1));
}

bool looks_like_hounsfield(const Statistics& values, const std::string& unit, const std::string& modality) {
  if (!unit.empty()) return unit == "HU";
  if (!modality.empty() && modality != "CT") return false;
  const Histogram& h = values.histogram;
  return values.min >= -3100.0 && values.min <= -900.0 && values.max > 300.0 && values.max < 70000.0 &&
         h.share_between(-1100.0, -850.0) > 0.05 && h.share_between(-150.0, 250.0) > 0.03;
}

bool looks_like_directions(const Statistics& lengths) {
  const double moving =
      1.0 - static_cast<double>(lengths.zeros) / static_cast<double>(std::max<std::int64_t>(lengths.counted, 1));
  return moving > 0.0 && lengths.max < 1.02 && lengths.histogram.share_between(0.98, 1.02) > 0.95 * moving;
}

}  // namespace palpa
