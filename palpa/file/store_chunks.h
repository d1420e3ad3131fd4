// Reading of many chunks of a store at once, and of boxes of voxels.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "palpa/file/store_reader.h"

namespace palpa {

/// Reads chunks in all slots of the reader, which has no request pending, and passes each on as it comes: the content of a
/// chunk that is present, else an empty span. Blocks. Throws as StoreReader; also what `use` throws, with requests pending.
/// \param go_on  called before each request: false ends the reading; those requested are still passed on. Empty: true
void read_chunks(StoreReader& reader, std::span<const StoreChunk> chunks,
                 const std::function<void(const StoreRead&, std::span<const std::byte>)>& use,
                 const std::function<bool()>& go_on = {});

/// Number of chunks of an octave along i, j, k. Allocates nothing; any thread.
std::array<std::int64_t, 3> chunks_along(const StoreOctave& octave) noexcept;

/// [raw] All numbers in the content of a chunk of the field, components of a voxel together. Copies; any thread.
std::vector<double> numbers_in(const StoreField& field, std::span<const std::byte> content);

/// Box of voxels within an octave.
struct VoxelBox {
  std::array<std::int64_t, 3> first{};  ///< [voxels]
  std::array<std::int64_t, 3> count{};  ///< [voxels]
  std::int64_t voxels() const noexcept { return count[0] * count[1] * count[2]; }
};

/// [raw] First components of the voxels in a box, i fastest; absent chunks have the fill value. None where a chunk is damaged.
/// Blocks. Throws as StoreReader.
/// \param place  octave, frame and field
/// \param box    within the octave
std::optional<std::vector<double>> voxels_in(StoreReader& reader, const StoreChunk& place, const VoxelBox& box);

}  // namespace palpa
