// Checks of output file names, before the work begins.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "palpa/base/new_file.h"

namespace palpa::app {

/// Throws LoadError unless the name has the format's ending. \param ending  with its dot
void check_ending(const std::filesystem::path& file, const char* ending);
/// Also throws LoadError on a name that cannot be written.
void check_output(const std::filesystem::path& file, const char* ending, detail::Existing existing);

/// "Wrote head.vti: 64 x 64 x 32 voxels, 1.2 MB". \param what  content of the file; \param file  exists
std::string wrote_words(const std::filesystem::path& file, const std::string& what);

}  // namespace palpa::app
