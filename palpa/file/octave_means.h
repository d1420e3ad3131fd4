// Means of 2 × 2 × 2 voxels, and facts of chunks.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "palpa/file/store_contents.h"

namespace palpa::detail {

/// Voxels along i, j, k.
using VoxelIndex = std::array<std::int64_t, 3>;

/// Block of voxels in memory: i fastest, components of a voxel together.
struct VoxelBlock {
  VoxelIndex size{};   ///< [voxels]
  VoxelIndex valid{};  ///< [voxels] of them that exist, from the first; the others are zero
  std::vector<std::byte> voxels;
};

/// Kind of the voxels of a field.
struct VoxelKind {
  VoxelType type = VoxelType::uint8;
  int components = 1;
  bool is_rounded = false;  ///< whole numbers in float64: means are rounded half up
  std::size_t bytes() const noexcept { return size_of(type) * static_cast<std::size_t>(components); }
};

/// A block of zeros.
VoxelBlock zero_block(const VoxelKind& kind, const VoxelIndex& size, const VoxelIndex& valid);

/// Writes the means of a block into a coarser one: a mean over the voxels that exist, of whole numbers rounded half up, of
/// others in double, not finite where any voxel is. Allocates nothing; any thread. \param at  [voxels] of the coarser block, of
/// the first mean
void halve(const VoxelKind& kind, const VoxelBlock& fine, VoxelBlock& coarse, const VoxelIndex& at) noexcept;

/// Facts of a part of a block. Voxels that are not finite have neither range nor loss; min and max are NaN where no voxel is
/// finite. The checksum is of the voxels that exist, i fastest. Any thread.
/// \param low     [voxels] first of the part; even
/// \param size    [voxels] of it; voxels that do not exist are left out
/// \param coarse  means of the block; nullptr: there is no coarser octave, and nothing is lost
/// \param at      [voxels] of the first mean of the block in it
ChunkFacts facts_of(const VoxelKind& kind, const VoxelBlock& block, const VoxelIndex& low, const VoxelIndex& size,
                    const VoxelBlock* coarse, const VoxelIndex& at);

/// Copies a part of a block to another place. Allocates nothing; any thread. Parts within their blocks.
void copy_voxels(std::size_t voxel_bytes, const std::byte* from, const VoxelIndex& from_size, const VoxelIndex& from_low,
                 std::byte* to, const VoxelIndex& to_size, const VoxelIndex& to_low, const VoxelIndex& count) noexcept;

}  // namespace palpa::detail
