// Detection of Zarr stores.
#pragma once

#include <filesystem>

namespace palpa::protocol {

/// Whether a path is a folder with metadata of Zarr: .zarray, .zgroup, .zattrs or zarr.json. Parses nothing; any thread.
bool is_store(const std::filesystem::path& path);

}  // namespace palpa::protocol
