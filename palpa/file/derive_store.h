// Derived fields of a store larger than memory, written as stores within it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "palpa/data/derived.h"
#include "palpa/file/derived_name.h"
#include "palpa/file/prepare_store.h"

namespace palpa {

/// Parses "q=velocity": curl, divergence, gradient_magnitude, q or lambda2. Throws LoadError "--derive TEXT: problem; remedy".
DerivedArray derived_array(const std::string& text);

/// Folder of a derived field, an OME-Zarr image of its own: STORE/palpa/derived/q_velocity.
std::filesystem::path derived_store(const std::filesystem::path& store, const std::string& name);
/// Names of the derived fields that a store has, sorted; none of a folder that is no store. Allocates; any thread.
std::vector<std::string> derived_names(const std::filesystem::path& store);

/// Derives a field of a store as `derived` does, with the smoothing of two voxels, from blocks of voxels with those around them
/// that their values depend on: octave 0 of `derived_store`, as float32. A part makes its rows of chunks along k; a call for
/// the whole also makes what is missing, and then prepares the store. Rows whose files are there are left as they are. Any
/// number of parts, in any order, gives the same bytes: blocks are the same for all. Some hundred megabytes for each process.
///
/// Values differ from those derived in memory by the rounding of float32 alone. Throws LoadError as `prepare_store`.
/// \return  counts of the preparation; of a part those of units are 0
PreparedStore derive_store(const std::filesystem::path& store, const DerivedArray& array, const PrepareOptions& options = {});

}  // namespace palpa
