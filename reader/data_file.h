// Files that another file names: its voxels, or pieces of it.
#pragma once

#include <string>

namespace palpa::reader {

/// Checks a file that `header` names, before a library opens it: an ordinary file that lies below the header's folder, or below
/// one of PALPA_READER_FOLDERS. A header from a stranger must not make voxels of somebody's other files, nor have a pipe or a
/// device read. Throws LoadError with a sentence.
void check_data_file(const std::string& header, const std::string& file);

/// Refuses a header that was unpacked into memory, which has no folder, where it names other files. Throws LoadError.
void check_not_unpacked(const std::string& header);

}  // namespace palpa::reader
