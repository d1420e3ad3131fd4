#include "palpa/file/unit_plan.h"

#include <algorithm>
#include <bit>
#include <numeric>

#include "palpa/base/load_error.h"
#include "palpa/file/store_histogram.h"

namespace palpa::detail {
namespace {

constexpr std::int64_t chunk_side = 32;       // [voxels] of own chunks, unless those of others need another
constexpr int unit_octaves = 5;               // of a unit of 32 chunks a side: octave 5 is one chunk
constexpr std::int64_t coarsest_side = 128;   // [voxels] of a window, so that the coarsest octave is in memory as a whole
constexpr std::int64_t most_facts_side = 64;  // [chunks] that a reader takes
constexpr double chunks_for_shards = 1e6;
constexpr std::int64_t most_own_chunk_bytes = std::int64_t{8} << 20;
constexpr double most_block_bytes = 2e9;  // More: memory; less: planes of large slices are refused

std::int64_t ceil_of(std::int64_t n, std::int64_t each) { return (n + each - 1) / each; }
std::int64_t odd_part(std::int64_t n) { return n >> std::countr_zero(static_cast<std::uint64_t>(n)); }
std::int64_t power_of_two(std::int64_t n) { return static_cast<std::int64_t>(std::bit_ceil(static_cast<std::uint64_t>(n))); }

/// Along one axis: own chunk, and unit, of the reaches of the octaves that are there.
void plan_axis(UnitPlan& plan, std::size_t a) {
  std::int64_t odd = 1;
  for (int n = 0; n <= plan.base; ++n) odd = std::lcm(odd, odd_part(plan.octaves[static_cast<std::size_t>(n)].reach[a]));
  std::int64_t own = 2 * odd;  // even, so that pairs of voxels lie in one chunk
  while (own < chunk_side) own *= 2;
  std::int64_t unit = own << unit_octaves;
  for (int n = 0; n <= std::min(plan.base, unit_octaves); ++n)
    unit = std::lcm(unit, plan.octaves[static_cast<std::size_t>(n)].reach[a] << n);
  plan.unit[a] = unit;
  plan.units[a] = ceil_of(plan.octaves[0].dims[a], unit);
  for (int n = plan.base + 1; n <= plan.last; ++n) {
    PlannedOctave& octave = plan.octaves[static_cast<std::size_t>(n)];
    octave.chunk[a] = octave.reach[a] = own;
  }
  // Blocks: of the base whole chunks of it and of the own; then half of the one before, but no smaller than a chunk.
  for (int n = 0; n <= plan.last; ++n) {
    PlannedOctave& octave = plan.octaves[static_cast<std::size_t>(n)];
    octave.chunks[a] = ceil_of(octave.dims[a], octave.chunk[a]);
    octave.block[a] = n < plan.base    ? std::lcm<std::int64_t>(octave.reach[a], 2)
                      : n == plan.base ? std::lcm(octave.reach[a], own)
                                       : std::max(own, plan.octaves[static_cast<std::size_t>(n - 1)].block[a] / 2);
    std::int64_t facts = n > plan.top ? chunk_side : (unit >> n) / octave.reach[a];
    while (facts > most_facts_side && facts % 2 == 0) facts /= 2;
    octave.facts[a] = facts;
  }
}

void check(const UnitPlan& plan) {
  for (const PlannedOctave& octave : plan.octaves) {
    double bytes = static_cast<double>(plan.kind.bytes());
    for (const std::int64_t n : octave.block) bytes *= static_cast<double>(n);
    if (bytes > most_block_bytes ||
        std::any_of(octave.facts.begin(), octave.facts.end(), [](std::int64_t n) { return n > most_facts_side; })) {
      const VoxelIndex& c = plan.octaves[static_cast<std::size_t>(plan.base)].chunk;
      throw LoadError("has chunks of " + std::to_string(c[0]) + " x " + std::to_string(c[1]) + " x " + std::to_string(c[2]) +
                      " voxels, whose means take more memory than there is room for; write it anew with chunks whose sides "
                      "are powers of two (palpa convert of its source)");
    }
  }
  const VoxelIndex& own = plan.octaves.back().chunk;
  if (plan.last > plan.base && own[0] * own[1] * own[2] * static_cast<std::int64_t>(plan.kind.bytes()) > most_own_chunk_bytes)
    throw LoadError(
        "has chunks whose sides are far from powers of two; write it anew with others (palpa convert of its source)");
}

}  // namespace

std::int64_t UnitPlan::items() const noexcept {
  return frames * static_cast<std::int64_t>(components.size()) * units[0] * units[1] * units[2];
}

UnitPlan::Item UnitPlan::item(std::int64_t number) const noexcept {
  Item result;
  for (std::size_t a = 0; a < 3; ++a) result.at[a] = number % units[a], number /= units[a];
  result.field = static_cast<int>(number % static_cast<std::int64_t>(components.size()));
  result.frame = static_cast<int>(number / static_cast<std::int64_t>(components.size()));
  return result;
}

std::array<VoxelIndex, 2> UnitPlan::blocks_in(const Item& item, int octave) const noexcept {
  const PlannedOctave& o = octaves[static_cast<std::size_t>(octave)];
  std::array<VoxelIndex, 2> range{};
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t side = unit[a] >> octave;
    range[0][a] = item.at[a] * side / o.block[a];
    range[1][a] = ceil_of(std::min((item.at[a] + 1) * side, o.dims[a]), o.block[a]);
  }
  return range;
}

VoxelIndex UnitPlan::valid_in_block(int octave, const VoxelIndex& at) const noexcept {
  const PlannedOctave& o = octaves[static_cast<std::size_t>(octave)];
  VoxelIndex valid{};
  for (std::size_t a = 0; a < 3; ++a) valid[a] = std::clamp<std::int64_t>(o.dims[a] - at[a] * o.block[a], 0, o.block[a]);
  return valid;
}

std::string UnitPlan::path_of(int octave) const {
  bool by_number = true;
  for (int n = 0; n <= base; ++n) by_number = by_number && image.paths[static_cast<std::size_t>(n)] == std::to_string(n);
  return (by_number ? "" : "palpa/octaves/") + std::to_string(octave);
}

ArrayPlan UnitPlan::voxel_array(int octave) const {
  const PlannedOctave& o = octaves[static_cast<std::size_t>(octave)];
  ArrayPlan array{.zarr = image.zarr, .path = path_of(octave), .type = kind.type, .stored = stored, .axes = image.axes()};
  const std::int64_t channels = std::accumulate(components.begin(), components.end(), std::int64_t{0});
  const bool shards = has_shards && octave < unit_octaves && octave <= top;
  const auto axis = [&](std::int64_t count) {
    array.shape.push_back(count), array.chunk.push_back(1);
    if (shards) array.shard.push_back(1);
  };
  if (image.has_time) axis(frames);
  if (image.has_channels) axis(channels);
  for (const std::size_t a : {2, 1, 0}) {
    array.shape.push_back(o.dims[a]), array.chunk.push_back(o.chunk[a]);
    if (shards) array.shard.push_back(unit[a] >> octave);
  }
  return array;
}

ArrayPlan UnitPlan::facts_array(int octave) const {
  const PlannedOctave& o = octaves[static_cast<std::size_t>(octave)];
  return {.zarr = image.zarr,
          .path = "palpa/facts/" + std::to_string(octave),
          .type = VoxelType::float64,
          .shape = {frames, static_cast<std::int64_t>(components.size()), o.chunks[2], o.chunks[1], o.chunks[0], 4},
          .chunk = {1, 1, o.facts[2], o.facts[1], o.facts[0], 4}};
}

ArrayPlan UnitPlan::histogram_array() const {
  constexpr std::int64_t numbers = std::tuple_size_v<DyadicHistogram::Numbers>;
  return {.zarr = image.zarr,
          .path = "palpa/histograms",
          .type = VoxelType::float64,
          .shape = {frames, static_cast<std::int64_t>(components.size()), units[2], units[1], units[0], numbers},
          .chunk = {1, 1, 1, 1, 1, numbers},
          .is_packed = false};
}

UnitPlan unit_plan(const StoreContents& contents, const StoreImage& image) {
  UnitPlan plan{.image = image, .frames = contents.frames};
  for (const StoreField& field : contents.fields) plan.components.push_back(field.components);
  plan.kind = {contents.fields.front().type, 1};
  for (const int components : plan.components) plan.kind.components = std::max(plan.kind.components, components);
  const std::string& file_type = contents.fields.front().file_type;
  if (file_type == "int8") plan.stored = StoredAs::int8;
  if (file_type == "uint32") plan.stored = StoredAs::uint32, plan.kind.is_rounded = true;
  const bool is_kept = plan.stored != StoredAs::as_in_memory || file_type == name_of(plan.kind.type);
  if (!is_kept && file_type != "float16") {
    throw LoadError("has voxels of " + file_type +
                    ", of which no octaves are written; write it anew as int8 to int32, uint8 to uint32, float32 or float64");
  }
  const int there = static_cast<int>(contents.octaves.size());
  plan.base = image.own_from > 0 ? std::min(image.own_from, there) - 1 : there - 1;
  for (int n = 0; n <= plan.base; ++n) {
    const StoreOctave& from = contents.octaves[static_cast<std::size_t>(n)];
    PlannedOctave octave{.dims = from.grid.dims, .chunk = from.chunk, .reach = from.chunk};
    for (std::size_t a = 0; a < 3; ++a) {
      // One chunk along the whole axis may have any length.
      if (octave.chunk[a] >= octave.dims[a] && odd_part(octave.chunk[a]) != 1) octave.reach[a] = power_of_two(octave.dims[a]);
    }
    plan.octaves.push_back(octave);
  }
  const StoreOctave& finest = contents.octaves.front();
  double chunks = 1.0;
  for (std::size_t a = 0; a < 3; ++a) chunks *= static_cast<double>(ceil_of(finest.grid.dims[a], finest.chunk[a]));
  plan.has_shards = image.zarr == 3 && (finest.shard != finest.chunk || chunks >= chunks_for_shards);
  const auto longest = [](const VoxelIndex& dims) { return *std::max_element(dims.begin(), dims.end()); };
  while (longest(plan.octaves.back().dims) > coarsest_side) {
    PlannedOctave next;
    for (std::size_t a = 0; a < 3; ++a) next.dims[a] = ceil_of(plan.octaves.back().dims[a], 2);
    plan.octaves.push_back(next);
  }
  plan.last = static_cast<int>(plan.octaves.size()) - 1;
  plan.top = std::min(unit_octaves, plan.last);
  plan.task = std::min(plan.top, std::max(plan.base, 3));
  for (std::size_t a = 0; a < 3; ++a) plan_axis(plan, a);
  check(plan);
  return plan;
}

}  // namespace palpa::detail
