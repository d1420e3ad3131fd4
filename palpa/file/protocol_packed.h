// Which files come with memory for what they hold, because they are packed as a whole.
#pragma once

#include <string>

namespace palpa::protocol {

/// Whether a file is packed, by its first bytes; false where it cannot be opened. Any thread. Throws LoadError where the disk
/// fails.
bool is_packed(const std::string& path);

/// Whether a file is DICOM whose elements are deflated, or a folder, which may hold such files; false where it cannot be opened.
/// Any thread. Throws LoadError where the disk fails.
bool may_be_deflated(const std::string& path);

}  // namespace palpa::protocol
