#include "dicom_slices.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <tuple>
#include <utility>

#include "dicom_frames.h"
#include "palpa/base/load_error.h"

namespace palpa::reader {
namespace {

/// [pixels] Largest distance of slices from their common line. Less: sound stacks are refused; more: bent stacks are read
/// straight.
constexpr double straight = 0.1;
/// [slices] Largest deviation from even distances. Less: rounded positions are resampled; more: uneven ones are read as even.
constexpr double even = 0.02;
/// [1] Most resampled layers per slice. More: memory; less: closely spaced slices lose detail.
constexpr double finest = 4.0;
constexpr double farthest_mm = 1e12;  ///< from the origin; a position beyond is damaged
/// [1] Largest difference of unit directions of parallel slices. Less: rounded headers split a series; more: tilts are lost.
constexpr double parallel = 1e-3;

Vec3 normal_of(const Slice& slice) { return normalized(cross(slice.right, slice.down)); }

bool belong_together(const Slice& a, const Slice& b) {
  const auto alike = [](double x, double y) { return std::abs(x - y) <= 1e-4 * std::abs(x); };
  return a.series == b.series && a.size == b.size && a.type == b.type && a.placed == b.placed &&
         alike(a.spacing_mm[0], b.spacing_mm[0]) && alike(a.spacing_mm[1], b.spacing_mm[1]) &&
         norm(a.right - b.right) < parallel && norm(a.down - b.down) < parallel;
}

void drop_copies(std::vector<Slice>& stack, std::vector<std::string>& warnings) {
  const auto key = [](const Slice& s) { return std::tuple(s.instance, s.frame); };
  std::ranges::stable_sort(stack, {}, key);
  const std::size_t before = stack.size();
  const auto same = [&](const Slice& a, const Slice& b) { return !a.instance.empty() && key(a) == key(b); };
  stack.erase(std::unique(stack.begin(), stack.end(), same), stack.end());
  if (stack.size() < before) {
    warnings.push_back(std::to_string(before - stack.size()) + (before - stack.size() == 1 ? " image is" : " images are") +
                       " there twice: read once");
  }
}

/// Chooses evenly spaced layers for uneven slices. \param at_mm  [mm] positions of the slices along their normal
void resample(const std::vector<double>& at_mm, Arranged& volume, std::vector<std::string>& warnings) {
  std::vector<double> gaps_mm;
  for (std::size_t i = 1; i < at_mm.size(); ++i) gaps_mm.push_back(at_mm[i] - at_mm[i - 1]);
  std::vector<double> sorted_mm = gaps_mm;
  std::ranges::sort(sorted_mm);
  const double length_mm = at_mm.back() - at_mm.front(), usual_mm = sorted_mm[sorted_mm.size() / 2];

  // If all gaps are multiples of the usual gap, slices are missing in the larger ones.
  const bool lacking = std::ranges::all_of(gaps_mm, [&](double gap_mm) {
    const double slices = gap_mm / usual_mm;
    return slices > 0.5 && std::abs(slices - std::round(slices)) < 0.1;
  });
  std::string missing;
  int count = 0;
  for (std::size_t i = 0; lacking && i < gaps_mm.size(); ++i) {
    const int lost = static_cast<int>(std::min(1e6, std::round(gaps_mm[i] / usual_mm))) - 1;
    if (lost > 0) missing += (count > 0 ? ", " : "") + text_of(at_mm[i]) + " and " + text_of(at_mm[i + 1]) + " mm";
    count += lost;
  }
  const double wanted_mm =
      std::max(count == 0 ? sorted_mm.front() : usual_mm, length_mm / (finest * static_cast<double>(at_mm.size())));
  const auto layers = static_cast<std::size_t>(std::round(length_mm / wanted_mm)) + 1;
  const double step_mm = length_mm / static_cast<double>(layers - 1);
  if (count > 0) {
    warnings.push_back(std::to_string(count) + (count == 1 ? " slice is" : " slices are") + " missing, between " + missing +
                       " along the normal: filled from its neighbours; get the whole series");
  } else {
    warnings.push_back("has slices " + text_of(sorted_mm.front()) + " to " + text_of(sorted_mm.back()) +
                       " mm apart: resampled along their normal to " + text_of(step_mm) + " mm");
  }
  volume.resampled = true;
  volume.grid.dims[2] = static_cast<std::int64_t>(layers);
  for (std::size_t k = 0, i = 0; k < layers; ++k) {
    const double here_mm = at_mm.front() + step_mm * static_cast<double>(k);
    while (i + 2 < at_mm.size() && at_mm[i + 1] < here_mm) ++i;
    volume.layer_at.push_back(static_cast<double>(i) + std::clamp((here_mm - at_mm[i]) / gaps_mm[i], 0.0, 1.0));
  }
}

}  // namespace

std::vector<std::vector<Slice>> stacks_of(std::vector<Slice> slices) {
  std::vector<std::vector<Slice>> stacks;
  for (Slice& slice : slices) {
    auto stack = std::ranges::find_if(stacks, [&](const auto& s) { return belong_together(s.front(), slice); });
    if (stack == stacks.end()) stack = stacks.emplace(stacks.end());
    stack->push_back(std::move(slice));
  }
  return stacks;
}

Arranged arranged(std::vector<Slice> stack, std::vector<std::string>& warnings) {
  drop_copies(stack, warnings);
  if (!std::ranges::all_of(
          stack, [](const Slice& s) { return is_finite(s.position_mm) && largest_component(s.position_mm) < farthest_mm; })) {
    throw LoadError("has positions that are not finite; correct its headers");
  }
  Arranged volume;
  Frames frames = frames_of(std::move(stack), warnings);
  volume.frames = std::move(frames.frames), volume.differ = std::move(frames.differ);
  const std::vector<Slice>& slices = volume.frames.front();
  const Slice &first = slices.front(), &last = slices.back();
  const Vec3 normal = normal_of(first);
  const auto count = static_cast<std::int64_t>(slices.size());
  volume.grid.dims = {first.size[0], first.size[1], count};
  volume.grid.origin_m = first.position_mm;

  const double thickness_mm = first.thickness_mm > 0 ? first.thickness_mm : first.spacing_mm[0];
  const Vec3 way_mm = count > 1 ? last.position_mm - first.position_mm : thickness_mm * normal;
  std::vector<double> at_mm;
  double worst = 0.0;  // [slices]
  for (std::int64_t i = 0; i < count; ++i) {
    const Vec3 from_first_mm = slices[static_cast<std::size_t>(i)].position_mm - first.position_mm;
    at_mm.push_back(dot(normal, slices[static_cast<std::size_t>(i)].position_mm));
    const double share = dot(normal, from_first_mm) / dot(normal, way_mm);
    worst = std::max(worst, std::abs(share * static_cast<double>(count - 1) - static_cast<double>(i)));
    for (const auto& frame : volume.frames) {
      const Vec3 beside_mm = frame[static_cast<std::size_t>(i)].position_mm - first.position_mm - share * way_mm;
      if (norm(beside_mm) > straight * std::min(first.spacing_mm[0], first.spacing_mm[1])) {
        throw LoadError("has slices that lie " + text_of(norm(beside_mm)) +
                        " mm beside the line of the others; export them as one straight stack");
      }
    }
  }
  if (worst > even) resample(at_mm, volume, warnings);
  const Vec3 step_mm = count > 1 ? way_mm / static_cast<double>(volume.grid.dims[2] - 1) : way_mm;
  volume.grid.index_to_world_m =
      transposed(Mat3{{first.spacing_mm[0] * first.right, first.spacing_mm[1] * first.down, step_mm}});

  const bool one_space = std::ranges::all_of(slices, [&](const Slice& s) { return s.space == first.space; });
  if (!one_space) warnings.push_back("has slices of different frames of reference: they may not lie as they say");
  return volume;
}

Numbers common_numbers(const std::vector<Slice>& stack) {
  const Slice& first = stack.front();
  const bool padded = std::ranges::any_of(stack, [](const Slice& s) { return s.padding.has_value(); });
  const VoxelType exact = exact_type(first.type);
  const VoxelType floating = size_of(first.type) <= 2 ? VoxelType::float32 : VoxelType::float64;
  const bool one_scale =
      std::ranges::all_of(stack, [&](const Slice& s) { return s.slope == first.slope && s.intercept == first.intercept; });
  if (one_scale) return {padded ? floating : exact, first.slope, first.intercept};

  // Greatest common divisor of all slopes and differences of intercepts; it exists, as they are decimal numbers.
  double step = 0.0;
  for (const Slice& slice : stack) {
    for (double rest : {std::abs(slice.slope), std::abs(slice.intercept - first.intercept)}) {
      double divisor = step;
      const double negligible = 1e-9 * std::max(divisor, rest);
      while (rest > negligible) divisor = std::exchange(rest, std::fmod(divisor, rest));
      step = divisor;
    }
  }
  const Numbers whole{VoxelType::int32, step, first.intercept};
  bool exactly = !padded && step > 0;
  double least = 0.0, greatest = 0.0;
  for (const Slice& slice : stack) {
    const ToKept kept = to_kept(slice, whole);
    exactly = exactly && std::abs(kept.factor * step - slice.slope) <= 1e-9 * std::abs(slice.slope);
    for (const double raw : {slice.least(), slice.greatest()}) {
      least = std::min(least, raw * kept.factor + kept.shift), greatest = std::max(greatest, raw * kept.factor + kept.shift);
    }
  }
  const auto fits = [&]<class T>(T) {
    return least >= std::numeric_limits<T>::lowest() && greatest <= std::numeric_limits<T>::max();
  };
  if (exactly && fits(std::int16_t{})) return {VoxelType::int16, step, first.intercept};
  if (exactly && fits(std::int32_t{})) return whole;
  return {floating, 1.0, 0.0};
}

ToKept to_kept(const Slice& slice, const Numbers& numbers) noexcept {
  ToKept kept{slice.slope / numbers.scale, (slice.intercept - numbers.offset) / numbers.scale};
  const bool whole = numbers.type != VoxelType::float32 && numbers.type != VoxelType::float64;
  if (whole) kept = {std::round(kept.factor), std::round(kept.shift)};
  return kept;
}

}  // namespace palpa::reader
