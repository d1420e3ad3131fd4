// Where the files are that are loaded or run by name.
#pragma once

#include <filesystem>
#include <vector>

namespace palpa {

/// The folders in which they may be, the nearest first: beside this program, libexec/palpa beside its folder, and libexec/palpa
/// beside the library's, for a program of somebody else's. Allocates; any thread.
std::vector<std::filesystem::path> own_files_folders();

}  // namespace palpa
