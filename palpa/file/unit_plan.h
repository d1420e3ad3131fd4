// Plan of a store's preparation: octaves, units of work, blocks, arrays to write.
#pragma once

#include <vector>

#include "palpa/file/octave_means.h"
#include "palpa/file/store_array.h"
#include "palpa/file/store_contents.h"
#include "palpa/file/store_image.h"

namespace palpa::detail {

/// Octave of a plan. Lengths along i, j, k.
struct PlannedOctave {
  VoxelIndex dims{};    ///< [voxels]
  VoxelIndex chunk{};   ///< [voxels]
  VoxelIndex reach{};   ///< [voxels] of a chunk in a unit: larger than `chunk` where one covers the octave
  VoxelIndex chunks{};  ///< [chunks]
  VoxelIndex block{};   ///< [voxels] that are in memory at once, a multiple of `reach`
  VoxelIndex facts{};   ///< [chunks] of a chunk of facts
};

/// Units and octaves of a preparation. A unit's octaves need no voxels of another unit.
struct UnitPlan {
  StoreImage image;
  VoxelKind kind;  ///< of all fields
  int frames = 1;
  std::vector<int> components;               ///< of each field
  int base = 0;                              ///< [octaves] the coarsest that others wrote
  int top = 0;                               ///< [octaves] the coarsest that units make, at most 5
  int last = 0;                              ///< [octaves] the coarsest: no side longer than 128 voxels
  int task = 0;                              ///< [octaves] whose blocks are made by one thread
  VoxelIndex unit{};                         ///< [voxels] of octave 0
  VoxelIndex units{};                        ///< [1]
  StoredAs stored = StoredAs::as_in_memory;  ///< of octaves
  bool has_shards = false;                   ///< as octave 0 has
  std::vector<PlannedOctave> octaves;

  /// Frame, field and place of a unit.
  struct Item {
    int frame = 0;
    int field = 0;
    VoxelIndex at{};  ///< [units]
  };
  std::int64_t items() const noexcept;
  Item item(std::int64_t number) const noexcept;
  /// Blocks of an octave in a unit, the first and the one behind the last, within the octave.
  std::array<VoxelIndex, 2> blocks_in(const Item& item, int octave) const noexcept;
  /// Voxels of a block that exist. \param at  [blocks]
  VoxelIndex valid_in_block(int octave, const VoxelIndex& at) const noexcept;

  /// Array of an octave's voxels, of those that palpa makes.
  ArrayPlan voxel_array(int octave) const;
  ArrayPlan facts_array(int octave) const;
  /// Array of the units' histograms (`DyadicHistogram::Numbers`).
  ArrayPlan histogram_array() const;
  std::string path_of(int octave) const;
};

/// Throws LoadError without a place: chunks of which no units can be made.
UnitPlan unit_plan(const StoreContents& contents, const StoreImage& image);

/// Calls `act` with each index from the first to before the end, i fastest.
template <class Act>
void for_each_index(const VoxelIndex& first, const VoxelIndex& end, const Act& act) {
  for (std::int64_t k = first[2]; k < end[2]; ++k)
    for (std::int64_t j = first[1]; j < end[1]; ++j)
      for (std::int64_t i = first[0]; i < end[0]; ++i) act(VoxelIndex{i, j, k});
}

}  // namespace palpa::detail
