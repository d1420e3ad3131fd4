#include "palpa/scene/first_levels.h"

#include <algorithm>
#include <cmath>

#include "palpa/base/printed.h"
#include "palpa/data/halton.h"
#include "palpa/data/labels.h"
#include "palpa/data/quantile.h"

namespace palpa::detail {
namespace {

// [1] Random sample positions in a field. More: slower; fewer: less certain.
constexpr int places = 20000;
// Levels of CT. The first lies between air (-1000) and fat (-100); lower: noise of the air is felt. The second lies above soft
// tissue (40) and most contrast agent; higher: thin bone has holes.
constexpr double skin_hu = -300.0;
constexpr double bone_hu = 300.0;
// [1] Strength of soft tissue, as a share of a level's: a hand stays in it and pushes on, while it meets a level now and then.
// More: a recorded hand tires; less: friction and drag hide it.
constexpr double of_tissue = 0.5;

/// Whether the values at the border of the data are below a value: most of them, or a third if the scan ends within the body.
bool border_is_below(const Field& field, double value) {
  const Box box = field.bounds_m();
  std::vector<std::pair<double, double>> found;  // depth, value
  for (int n = 1; n <= places; ++n) {
    const Vec3 place_m = halton(n, box);
    if (const ScalarSample s = field.scalar(place_m); s.inside) found.emplace_back(field.depth_m(place_m), s.value);
  }
  const auto border =
      static_cast<std::ptrdiff_t>(std::max<std::size_t>(found.size() / 10, std::min<std::size_t>(found.size(), 1)));
  std::nth_element(found.begin(), found.begin() + std::max<std::ptrdiff_t>(border - 1, 0), found.end());
  const auto below = std::count_if(found.begin(), found.begin() + border, [&](const auto& f) { return f.second < value; });
  return 3 * below >= border;
}

/// Share of the contrast of two classes within two sample spacings across a level, as a median over it: 1 for an edge as sharp
/// as the grid allows, near 0 for a slope.
double sharpness(std::span<const FieldPtr> sample, double level, double contrast) {
  std::vector<double> shares;
  for (const FieldPtr& field : sample) {
    const Box box = field->bounds_m();
    const double spacing_m = field->spacing_m();
    for (int n = 1; n <= places / static_cast<int>(sample.size()); ++n) {
      const ScalarSample s = field->scalar(halton(n, box));
      const double steep = norm(s.gradient);
      if (!s.inside || !(steep > 0.0) || std::abs(level - s.value) > steep * spacing_m) continue;
      shares.push_back(2.0 * spacing_m * steep / contrast);
    }
  }
  if (shares.empty() || !(contrast > 0.0)) return 0.0;
  return std::clamp(median(shares), 0.0, 1.0);
}

/// Level between two classes of values of the histogram, from `low` over the level to `high`.
FirstLevel level_between(std::span<const FieldPtr> sample, const Histogram& histogram, std::string name, double value,
                         double low, double high, double weakest_n, double firmest_n) {
  const double below = histogram.mean_between(low, value), above = histogram.mean_between(value, high);
  const double sharp = sharpness(sample, value, std::abs(above - below));
  FirstLevel level;
  level.name = std::move(name);
  level.value = value;
  level.strength_n = rounded(weakest_n + (firmest_n - weakest_n) * sharp, firmest_n);
  level.why_value = text("parts the values best (Otsu): %.3g on average below, %.3g above", below, above);
  level.why_strength =
      text("%.2g N for a soft edge, %.2g N for a sharp one; sharpness of this one: %.0f %% of the step within two voxels",
           weakest_n, firmest_n, 100.0 * sharp);
  return level;
}

}  // namespace

double rounded(double value, double span) noexcept {
  if (!std::isfinite(value) || !(span > 0.0) || !std::isfinite(span)) return value;
  const double power = std::floor(std::log10(span)) - 2.0;
  // Division by a power of ten, not multiplication by its inverse: 0.3, not 0.30000000000000004.
  const double step = std::pow(10.0, std::abs(power));
  const double result = power < 0.0 ? std::round(value * step) / step : std::round(value / step) * step;
  return std::isfinite(result) ? result + 0.0 : value;
}

FirstLevels first_levels(const Field& field, std::span<const FieldPtr> sample, const Statistics& values,
                         const std::string& unit, const std::string& modality, bool is_scan) {
  FirstLevels first;
  const Histogram& h = values.histogram;
  if (!(values.max > values.min)) return first;

  if (looks_like_hounsfield(values, unit, modality)) {
    first.hounsfield = true;
    first.why_solid = "Hounsfield units: air is low, everything else is higher";
    const auto add = [&](const char* name, double value, double strength_n, const char* why, const char* why_strength) {
      if (values.min < value && h.share_between(value, values.max) > 1e-3) {
        first.levels.push_back({name, value, strength_n, why, why_strength});
      }
    };
    add("skin", skin_hu, 0.8, "between air (-1000 HU) and fat (-100 HU)",
        "gives way to a light press, so that the bone can be reached");
    add("bone", bone_hu, holding_n, "above soft tissue (40 HU) and most contrast agent",
        "above max_force_n: it cannot be pressed through; weaker levels can");
    for (FirstLevel& level : first.levels) {
      level.soft = level.value == skin_hu;
      level.holds = level.value == bone_hu;
    }
    if (!first.levels.empty()) return first;
  }

  // Without the highest and lowest thousandth: a few outlying voxels would become a class of their own.
  const double top = std::max(h.percentile(0.999), h.edge(1)), bottom = std::min(h.percentile(0.001), top);
  auto outer = dividing_value(h, bottom, top);
  if (!outer) outer = dividing_value(h, values.min, values.max);
  if (!outer) return first;
  first.tissue = is_scan;
  const double share = is_scan ? of_tissue : 1.0;
  const double span = values.max - values.min;
  const double outer_value = rounded(*outer, span);
  first.solid_is_high = border_is_below(field, outer_value);
  first.why_solid = first.solid_is_high ? "most of the border of the data is below the level: what is above it is the object"
                                        : "most of the border of the data is above the level: what is below it is the object";
  first.levels.push_back(level_between(sample, h, "surface", outer_value, bottom, top, share * 0.4, share * 1.0));

  const double from = first.solid_is_high ? outer_value : bottom, to = first.solid_is_high ? top : outer_value;
  if (const auto inner = dividing_value(h, from, to)) {
    const double inner_value = rounded(*inner, span);
    const double solid = h.share_between(from, to);
    const double beyond = first.solid_is_high ? h.share_between(inner_value, to) : h.share_between(from, inner_value);
    // A level with less than a twentieth of the solid on one side is no surface of its own: it bounds a few voxels, or repeats
    // the first level.
    if (inner_value > from && inner_value < to && beyond > 0.05 * solid && solid - beyond > 0.05 * solid) {
      first.levels.back().soft = true;
      first.levels.push_back(level_between(sample, h, "core", inner_value, from, to, share * 0.7, share * 1.5));
    }
  }
  return first;
}

std::optional<FirstLevels> level_around_labels(std::span<const FieldPtr> sample, const Statistics& values,
                                               const std::string& unit, const std::string& modality) {
  double background = values.max, least = values.max;
  int varied = 0, labelled = 0;  // blocks; one that a thin part of a label enters does not look like labels
  for (const FieldPtr& block : sample) {
    const ValueRange range = block->value_ranges().front();
    background = std::min(background, range.min);
    if (!(range.max > range.min)) continue;
    LabelMap map = label_map_unless_said(*block, values, unit, modality);
    ++varied, labelled += !map.labels.empty();
    map.labels.push_back({map.background, 0});  // of the block: a label where it lies within one
    for (const Label& label : map.labels) {
      if (label.value > values.min) least = std::min(least, label.value);
    }
  }
  if (2 * labelled <= varied || background > values.min) return std::nullopt;
  FirstLevels first;
  first.why_solid = "the background has the lowest value";
  FirstLevel level{.name = "labelled", .value = 0.5 * (background + least), .strength_n = 0.8};
  level.why_value = "half way from the background to the lowest label; labels of their own need all voxels in memory";
  level.why_strength = "gives way, so that one gets to what lies behind";
  first.levels.push_back(std::move(level));
  return first;
}

double faint_value(std::vector<double> around, const FirstLevels& first, double wanted) {
  const double level = first.levels.front().value, sign = first.solid_is_high ? 1.0 : -1.0;
  if (around.empty()) return level;
  std::ranges::sort(around, [&](double a, double b) { return sign * a < sign * b; });
  const double at = around[static_cast<std::size_t>((1.0 - wanted) * static_cast<double>(around.size() - 1))];
  // Drag begins no earlier than at the mean outside of the solid: hardly any in empty space and its noise.
  double sum = 0.0, empty = 0.0;
  for (const double value : around) {
    if (sign * value < sign * level) sum += value, ++empty;
  }
  const double mean = empty > 0.0 ? sum / empty : level;
  const double faint = rounded(sign * std::max(sign * at, sign * mean), std::abs(level - mean));
  return sign * faint < sign * level ? faint : level;
}

FirstFlow first_flow(const Statistics& speeds) {
  const Histogram& h = speeds.histogram;
  FirstFlow flow;
  flow.directions = looks_like_directions(speeds);
  // If so little moves that percentiles of all values are those of rest, only moving values are used.
  const double resting = h.percentile(0.995) < 0.01 * speeds.max ? h.share_between(h.low, 0.01 * speeds.max) : 0.0;
  const double fast = std::max(h.percentile(resting + 0.995 * (1.0 - resting)), h.edge(1));
  flow.fast = rounded(fast, fast);
  flow.empty = rounded(0.05 * fast, 0.05 * fast);
  const double still = h.share_between(h.low, flow.empty);
  flow.moderate = rounded(std::max(h.percentile(still + 0.5 * (1.0 - still)), 2.0 * flow.empty), fast);
  return flow;
}

}  // namespace palpa::detail
