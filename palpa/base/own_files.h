// Search path of files that are loaded or run by name.
#pragma once

#include <filesystem>
#include <vector>

namespace palpa {

/// Folders, nearest first: beside this program, libexec/palpa beside its folder, and libexec/palpa beside the library's folder,
/// for other programs. Allocates; any thread.
std::vector<std::filesystem::path> own_files_folders();

}  // namespace palpa
