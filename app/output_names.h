// Names of files that commands write, checked before their work begins.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "palpa/base/new_file.h"

namespace palpa::app {

/// Throws LoadError on a name with another ending than the format's. \param ending  with its dot
void check_ending(const std::filesystem::path& file, const char* ending);
/// The same, and on a name that cannot be written.
void check_output(const std::filesystem::path& file, const char* ending, detail::Existing existing);

/// "Wrote head.vti: 64 x 64 x 32 voxels, 1.2 MB". \param what  is in the file; \param file  is there
std::string wrote_words(const std::filesystem::path& file, const std::string& what);

}  // namespace palpa::app
