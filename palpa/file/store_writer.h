// Writing of volumes as OME-Zarr: octave 0, whole or in parts.
#pragma once

#include <filesystem>
#include <functional>

#include "palpa/base/new_file.h"
#include "palpa/file/work_part.h"
#include "palpa/file/write_volume.h"

namespace palpa {

/// Whether the name's ending is that of a store: .zarr.
bool is_store(const std::filesystem::path& name);

struct StoreWriting {
  WorkPart part;              ///< rows of chunks (of shards, if there are any) along k
  bool shares_store = false;  ///< other processes write other parts: an unfinished store of the same arrays is written on
  detail::Existing existing = detail::Existing::refused;  ///< of the whole: for an existing store, which must be of palpa
  int zarr = 0;                                           ///< version of Zarr, 2 or 3; 0: 3 from a million chunks on
  bool keeps_rows = false;                                ///< files of a row that are all there are not written again
  std::function<void(double)> progress{};  ///< called with the share done [1]; may be empty, and may throw to end the writing
};

/// Writes octave 0 of an OME-Zarr store with chunks of 32³ voxels, all of them also where they are wholly the fill value, 0,
/// and the metadata. With shards, those have 512³ voxels. Each file gets its name when complete, so that an interrupted writing
/// leaves whole chunks; repeated, it gives the same bytes. Fields of several types get one that holds all. Chunks are packed on
/// all cores. Throws LoadError, with the store's name: also for a grid that is not along the axes of the world.
void write_store(const WrittenVolume& volume, const std::filesystem::path& store, const StoreWriting& how = {});

}  // namespace palpa
