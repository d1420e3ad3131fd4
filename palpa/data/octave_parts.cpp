#include "palpa/data/octave_parts.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "palpa/data/halton.h"

namespace palpa {
namespace {

using VoxelCounts = std::array<std::int64_t, 3>;

constexpr std::int64_t sample_block_voxels = 32;  // [voxels] a chunk of a store that palpa writes
// [1] Blocks of a sample. More: slower to open; fewer: values of small parts are missed.
constexpr int most_sample_blocks = 128;

GridGeometry grid_of_part(const Octaves& octaves, int octave, const VoxelCounts& first, const VoxelCounts& dims) {
  const GridGeometry& finest = octaves.shape().finest;
  const double width = std::ldexp(1.0, octave);  // [voxels of octave 0]
  const auto at = [&](std::size_t a) { return 0.5 * (width - 1.0) + width * static_cast<double>(first[a]); };
  GridGeometry grid{dims, width * finest.index_to_world_m, finest.to_world({at(0), at(1), at(2)}), {}};
  return grid;
}

/// Box around a box after a similarity.
Box around(const Box& box, const auto& moved) {
  const Vec3 first = moved(box.low_m);
  Box out{first, first};
  for (int corner = 1; corner < 8; ++corner) {
    const Vec3 at = moved({corner & 1 ? box.high_m.x : box.low_m.x, corner & 2 ? box.high_m.y : box.low_m.y,
                           corner & 4 ? box.high_m.z : box.low_m.z});
    out.low_m = {std::min(out.low_m.x, at.x), std::min(out.low_m.y, at.y), std::min(out.low_m.z, at.z)};
    out.high_m = {std::max(out.high_m.x, at.x), std::max(out.high_m.y, at.y), std::max(out.high_m.z, at.z)};
  }
  return out;
}

/// Voxels of an octave whose samples fill a box; `dims` has a 0 if there are none.
struct PartOfOctave {
  VoxelCounts first{}, dims{};
};
PartOfOctave part_within(const Octaves& octaves, int octave, const Box& box_m) {
  const auto border = static_cast<double>(Octaves::border(octave));
  const Box steps = around(box_m, [&](const Vec3& at) { return octaves.steps_of(octave, at) - Vec3{border, border, border}; });
  const double low[] = {steps.low_m.x, steps.low_m.y, steps.low_m.z}, high[] = {steps.high_m.x, steps.high_m.y, steps.high_m.z};
  const VoxelCounts all = octaves.dims(octave);
  PartOfOctave part;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto last = static_cast<double>(all[a] - 1);
    if (!(low[a] <= last + 1.0) || !(high[a] >= -1.0)) return {};
    part.first[a] = static_cast<std::int64_t>(std::clamp(std::floor(low[a]), 0.0, last));
    part.dims[a] = static_cast<std::int64_t>(std::clamp(std::ceil(high[a]), 0.0, last)) - part.first[a] + 1;
  }
  return part;
}

std::optional<DrawnOctave> drawn_of(const Octaves& octaves, const Box& box_m, double step_m) {
  const int last = octaves.count() - 1;
  const double finest = std::floor(std::log2(std::max(step_m, octaves.spacing_m()) / octaves.spacing_m()) + 1e-9);
  for (int octave = static_cast<int>(std::clamp(finest, 0.0, static_cast<double>(last))); octave <= last; ++octave) {
    const PartOfOctave part = part_within(octaves, octave, box_m);
    if (part.dims[0] == 0) return std::nullopt;
    if (octave < last && *std::ranges::max_element(part.dims) > most_drawn_voxels) continue;
    if (const FieldPtr field = octave_part(octaves, octave, part.first, part.dims))
      return DrawnOctave{filtered(field, octaves.shape().filter), octave, std::ldexp(octaves.spacing_m(), octave)};
  }
  return std::nullopt;
}

}  // namespace

const Octaves* octaves_of(const Field& field) noexcept { return dynamic_cast<const Octaves*>(&field); }

const Octaves* octaves_below(const Field& field) noexcept {
  if (const PosedView* view = posed_of(field)) return octaves_below(*view->field);
  if (const MovingView* view = moving_of(field)) return octaves_below(*view->field);
  if (const SeriesView* view = series_of(field)) return octaves_of(*view->frames.front());
  return octaves_of(field);
}

std::optional<PosedOctaves> posed_octaves(const Field& field, DataTime at) noexcept {
  const PosedView* posed_view = posed_of(field);
  const MovingView* moved = posed_view ? nullptr : moving_of(field);
  if (!posed_view && !moved) {
    const SeriesView* series = series_of(field);
    const auto frame = series ? static_cast<std::size_t>(std::round(frame_at(*series, at))) % series->frames.size() : 0;
    const Octaves* octaves = octaves_of(series ? *series->frames[frame] : field);
    return octaves ? std::optional<PosedOctaves>({octaves, {}}) : std::nullopt;
  }
  if (moved && moved->per_length != 0) return std::nullopt;
  const Similarity outer = posed_view ? posed_view->pose : pose_at(moved->track, at);
  std::optional<PosedOctaves> below = posed_octaves(posed_view ? *posed_view->field : *moved->field, at);
  if (below) {
    const Similarity& inner = below->pose;
    below->pose = {outer.rotation * inner.rotation, outer.scale * inner.scale, outer.to_world(inner.translation_m)};
  }
  return below;
}

std::vector<const Octaves*> frames_in_octaves(const Field& field) {
  const Field* below = &field;
  for (const MovingView* view = moving_of(*below); view; view = moving_of(*below)) below = view->field.get();
  std::vector<const Octaves*> all;
  if (!octaves_below(*below)) return all;
  const SeriesView* series = series_of(*below);
  if (!series) return {octaves_below(*below)};
  for (const FieldPtr& frame : series->frames) all.push_back(octaves_of(*frame));
  return all;
}

bool changes_with_time(const Field& field) noexcept {
  const MovingView* moved = moving_of(field);
  return timed(field) && (!octaves_below(field) || (moved && moved->track.size() > 1) || frames_in_octaves(field).size() > 1);
}

FieldPtr octave_part(const Octaves& octaves, int octave, const VoxelCounts& first, const VoxelCounts& dims) {
  const Octaves::Shape& shape = octaves.shape();
  const std::size_t bytes =
      static_cast<std::size_t>(dims[0] * dims[1] * dims[2]) * size_of(shape.type) * static_cast<std::size_t>(shape.components);
  const std::shared_ptr<std::byte[]> voxels(new std::byte[bytes]);
  if (!shape.source->read(octave, first, dims, voxels.get())) return nullptr;
  return grid_field(grid_of_part(octaves, octave, first, dims), {shape.type, shape.components, voxels}, shape.scale,
                    shape.offset);
}

std::vector<FieldPtr> octave_sample(const Octaves& octaves) {
  const VoxelCounts all = octaves.dims(0);
  VoxelCounts blocks{};
  std::int64_t count = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    blocks[a] = (all[a] + sample_block_voxels - 1) / sample_block_voxels;
    count *= std::min<std::int64_t>(blocks[a], most_sample_blocks + 1);
  }
  std::set<VoxelCounts> places;
  for (std::int64_t n = 0; count <= most_sample_blocks && n < count; ++n)
    places.insert({n % blocks[0], n / blocks[0] % blocks[1], n / blocks[0] / blocks[1]});
  for (int n = 1; count > most_sample_blocks && n <= most_sample_blocks; ++n) {
    const double share[] = {detail::radical_inverse<2>(n), detail::radical_inverse<3>(n), detail::radical_inverse<5>(n)};
    VoxelCounts at{};
    for (std::size_t a = 0; a < 3; ++a) at[a] = static_cast<std::int64_t>(share[a] * static_cast<double>(blocks[a]));
    places.insert(at);
  }
  std::vector<FieldPtr> sample;
  for (const VoxelCounts& place : places) {
    VoxelCounts first{}, dims{};
    for (std::size_t a = 0; a < 3; ++a)
      first[a] = place[a] * sample_block_voxels, dims[a] = std::min(sample_block_voxels, all[a] - first[a]);
    if (FieldPtr block = octave_part(octaves, 0, first, dims)) sample.push_back(std::move(block));
  }
  return sample;
}

Statistics sample_statistics(const Octaves& octaves, std::span<const FieldPtr> sample) {
  Statistics found = statistics(sample);
  if (found.counted == 0) return found;
  found.one_in = std::max<std::int64_t>(1, octaves.shape().finest.voxels() / found.counted);
  if (octaves.components() == 1) {
    const ValueRange range = octaves.value_ranges().front();
    found.min = std::min(found.min, range.min), found.max = std::max(found.max, range.max);
  }
  return found;
}

std::optional<DrawnOctave> drawn_octave(const Field& field, DataTime at, const Box& box_m, double step_m) {
  const std::optional<PosedOctaves> of = posed_octaves(field, at);
  if (!of) return std::nullopt;
  const Box within = around(box_m, [&](const Vec3& x) { return of->pose.to_hand(x); });
  std::optional<DrawnOctave> drawn = drawn_of(*of->octaves, within, step_m / of->pose.scale);
  if (drawn) drawn->field = posed(drawn->field, of->pose), drawn->voxel_m *= of->pose.scale;
  return drawn;
}

}  // namespace palpa
