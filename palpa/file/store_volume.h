// Stores larger than memory as volumes in octaves.
#pragma once

#include <cstdint>
#include <optional>

#include "palpa/data/volume.h"
#include "palpa/file/octave_places.h"
#include "palpa/file/read_volume.h"

namespace palpa::detail {

/// [bytes] Voxels that a store's octave 0 may take in memory as a whole; more: it is felt through windows. `memory_mb` of a
/// request replaces it.
inline constexpr double whole_bytes = 512e6;
/// [bytes] As above, of the store of this request: of one at a web address 0, as it would have to be fetched first.
double most_whole_bytes(const VolumeRequest& request);

/// [1] Octaves of a store that can be felt through windows; 0: it cannot be.
int felt_octaves(const StoreContents& contents, const OctavePlaces& places);

/// The volume of a request for a store whose octave 0 takes more memory than it may: fields in octaves (octaves.h), whose
/// chunks a program that stays open reads when windows need them; nullopt for smaller stores, for other files, and for stores
/// without usable octaves whose octave 0 takes at most `limit_bytes`, unless the request has `memory_mb`. A chunk that
/// is lost, damaged, or not as it was when the store was prepared leaves no window there. Reads the coarsest octave and
/// the facts of chunks. Throws LoadError with a sentence, without the store's name: also where octaves are missing, or are no
/// means.
std::optional<Volume> volume_in_octaves(const VolumeRequest& request, const ReadOptions& options, std::uint64_t limit_bytes);

}  // namespace palpa::detail
