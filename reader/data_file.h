// Files that a header names: its voxels or pieces.
#pragma once

#include <string>

namespace palpa::reader {

/// Checks a file that `header` names, before a library opens it: a regular file below the header's folder or a folder in
/// PALPA_READER_FOLDERS. A stranger's header must not load other files of the user as voxels, nor open a pipe or a device.
/// Throws LoadError with a sentence.
void check_data_file(const std::string& header, const std::string& file);

/// Refuses a header that was decompressed into memory, so has no folder, but names other files. Throws LoadError.
void check_not_unpacked(const std::string& header);

}  // namespace palpa::reader
