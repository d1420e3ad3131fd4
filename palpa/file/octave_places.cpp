#include "palpa/file/octave_places.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "palpa/data/grid_base.h"
#include "palpa/file/store_chunks.h"

namespace palpa {
namespace {

// More of any: slower; less: more stores stay undecided.
constexpr int boxes_wanted = 16, most_candidates = 1024;
constexpr std::int64_t box_side = 16;  ///< [voxels] of octave 1
constexpr std::uint64_t most_bytes = 64'000'000;
/// Voxels that distinguish means from decimation. More: sparse stores stay undecided; fewer: chance decides.
constexpr std::int64_t least_voxels = 64;
constexpr double most_misfits = 1e-3;  ///< [1] of these voxels. More: wrong places; less: a damaged chunk decides

using Counts = std::array<std::int64_t, 3>;

/// Voxels of octave 1 that a hypothesis does not fit: eight decimations, then means rounded to the nearest, and down.
struct Misfits {
  std::array<std::int64_t, 8> decimation{};
  std::int64_t nearest = 0, down = 0, compared = 0;
};

/// Box around a random chunk, in octave 1.
VoxelBox box_near(const StoreContents& contents, const Counts& at) {
  const StoreOctave &fine = contents.octaves[0], &coarse = contents.octaves[1];
  VoxelBox box;
  for (std::size_t a = 0; a < 3; ++a) {
    // Only whole pairs of voxels, but of an axis of one voxel.
    const std::int64_t pairs = std::min(coarse.grid.dims[a], std::max<std::int64_t>(fine.grid.dims[a] / 2, 1));
    const std::int64_t whole = std::clamp<std::int64_t>(fine.chunk[a] / 2, 1, box_side);
    box.first[a] = std::min((at[a] * fine.chunk[a] + 1) / 2, pairs - 1);
    box.count[a] = std::min(whole, pairs - box.first[a]);
  }
  return box;
}

/// Tolerance [raw] of a mean of these voxels that is rounded to the file's type.
double tolerance(const StoreField& field, double largest) {
  if (field.file_type == "float64") return 1e-12 * largest;
  if (field.file_type == "float32") return 2e-6 * largest;
  if (field.file_type == "float16") return 2e-3 * largest;
  return 0.5;
}

void compare(const StoreField& field, const std::vector<double>& coarse, const VoxelBox& box, const std::vector<double>& fine,
             const VoxelBox& around, Misfits& misfits) {
  const bool is_whole = !field.file_type.starts_with("float");
  for (std::int64_t k = 0; k < box.count[2]; ++k) {
    for (std::int64_t j = 0; j < box.count[1]; ++j) {
      for (std::int64_t i = 0; i < box.count[0]; ++i) {
        const double there = coarse[static_cast<std::size_t>((k * box.count[1] + j) * box.count[0] + i)];
        std::array<double, 8> parts{};
        double sum = 0.0, largest = 0.0;
        for (std::size_t n = 0; n < 8; ++n) {
          Counts at{2 * i, 2 * j, 2 * k};
          for (std::size_t a = 0; a < 3; ++a)
            at[a] = std::min(at[a] + static_cast<std::int64_t>((n >> a) & 1), around.count[a] - 1);
          parts[n] = fine[static_cast<std::size_t>((at[2] * around.count[1] + at[1]) * around.count[0] + at[0])];
          sum += parts[n], largest = std::max(largest, std::abs(parts[n]));
        }
        const double mean = sum / 8.0;
        if (std::ranges::all_of(parts, [&](double part) { return part == parts[0]; }) || !std::isfinite(mean)) continue;
        ++misfits.compared;
        for (std::size_t n = 0; n < 8; ++n) misfits.decimation[n] += parts[n] != there;
        misfits.nearest += !(std::abs(there - mean) <= tolerance(field, largest));
        misfits.down += is_whole ? there != std::trunc(mean) : 1;
      }
    }
  }
}

/// Compares boxes until enough are informative.
Misfits measured(StoreReader& reader) {
  const StoreContents& contents = reader.contents();
  const Counts chunks = chunks_along(contents.octaves[0]);
  std::mt19937_64 random(1);  // equal stores, equal results
  Misfits misfits;
  const std::uint64_t voxel_bytes =
      size_of(contents.fields[0].type) * static_cast<std::uint64_t>(contents.fields[0].components);
  std::uint64_t bytes = 0;
  int informative = 0;
  for (int n = 0; n < most_candidates && informative < boxes_wanted && bytes < most_bytes; ++n) {
    Counts at{};
    for (std::size_t a = 0; a < 3; ++a)
      at[a] = n == 0 ? chunks[a] / 2 : static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(chunks[a]));
    const VoxelBox box = box_near(contents, at);
    VoxelBox around;
    for (std::size_t a = 0; a < 3; ++a) {
      around.first[a] = 2 * box.first[a];
      around.count[a] = std::min(2 * box.count[a], contents.octaves[0].grid.dims[a] - around.first[a]);
    }
    const auto fine = voxels_in(reader, {.octave = 0}, around);
    // Most chunks of sparse stores are absent, and cost little.
    if (!fine || std::ranges::all_of(*fine, [&](double voxel) { return voxel == fine->front(); })) continue;
    const auto coarse = voxels_in(reader, {.octave = 1}, box);
    if (!coarse) continue;
    for (const StoreOctave* octave : {&contents.octaves[0], &contents.octaves[1]})
      bytes += static_cast<std::uint64_t>(octave->chunk[0] * octave->chunk[1] * octave->chunk[2]) * voxel_bytes;
    const std::int64_t before = misfits.compared;
    compare(contents.fields[0], *coarse, box, *fine, around, misfits);
    informative += misfits.compared > before;
  }
  return misfits;
}

void decide(const Misfits& misfits, const Counts& dims, OctavePlaces& places) {
  if (misfits.compared < least_voxels) {
    places.making = OctaveMaking::undecided;
    return;
  }
  const auto most = static_cast<std::int64_t>(most_misfits * static_cast<double>(misfits.compared));
  const bool are_means = misfits.nearest <= most || misfits.down <= most;
  const auto taken = std::ranges::min_element(misfits.decimation);
  const bool are_taken = *taken <= most;
  places.making = are_means && are_taken ? OctaveMaking::undecided
                  : are_means            ? OctaveMaking::means
                  : are_taken            ? OctaveMaking::decimation
                                         : OctaveMaking::neither;
  const auto n = static_cast<std::size_t>(taken - misfits.decimation.begin());
  if (places.making != OctaveMaking::decimation) return;
  for (std::size_t a = 0; a < 3; ++a) places.first[a] = dims[a] == 1 ? 0 : static_cast<int>((n >> a) & 1);
}

/// Moves the octaves to the measured places. Returns the largest way [voxels of octave 0].
double move(OctavePlaces& places) {
  const GridGeometry& finest = places.octaves.front().grid;
  double largest = 0.0;
  for (std::size_t n = 1; n < places.octaves.size(); ++n) {
    GridGeometry& grid = places.octaves[n].grid;
    GridPoint at;
    double* const parts[] = {&at.i, &at.j, &at.k};
    for (std::size_t a = 0; a < 3; ++a) {
      const double share = finest.dims[a] == 1 ? 0.0 : places.making == OctaveMaking::means ? 0.5 : places.first[a];
      *parts[a] = share * (std::ldexp(1.0, static_cast<int>(n)) - 1.0);
    }
    const Vec3 origin_m = finest.to_world(at), way = origin_m - grid.origin_m;
    largest = std::max(largest, largest_component(detail::scaled_inverse(finest.index_to_world_m) * way));
    grid.origin_m = origin_m;
  }
  return largest;
}

}  // namespace

OctavePlaces octave_places(StoreReader& reader) {
  const StoreContents& contents = reader.contents();
  OctavePlaces places;
  places.octaves = contents.octaves;
  if (contents.octaves.size() < 2) return places;
  decide(measured(reader), contents.octaves[0].grid.dims, places);
  if (places.making == OctaveMaking::neither) {
    places.warnings.emplace_back(
        "has octaves that are neither means of 2 × 2 × 2 voxels nor every second voxel of the one before: they are not felt");
  }
  if (places.making != OctaveMaking::means && places.making != OctaveMaking::decimation) return places;
  constexpr double much_voxels = 1e-3;
  if (move(places) > much_voxels) {
    places.warnings.emplace_back(
        places.making == OctaveMaking::means
            ? "places its octaves elsewhere than their voxels are, which are means of 2 × 2 × 2 voxels: "
              "they are moved there"
            : "places its octaves elsewhere than their voxels are, which are every second voxel: they "
              "are moved there");
  }
  return places;
}

}  // namespace palpa
