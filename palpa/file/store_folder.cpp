#include "palpa/file/store_folder.h"

#include <system_error>

namespace palpa::protocol {

bool is_store(const std::filesystem::path& path) {
  std::error_code none;
  if (!std::filesystem::is_directory(path, none)) return false;
  for (const char* metadata : {".zarray", ".zgroup", ".zattrs", "zarr.json"}) {
    if (std::filesystem::is_regular_file(path / metadata, none)) return true;
  }
  return false;
}

}  // namespace palpa::protocol
