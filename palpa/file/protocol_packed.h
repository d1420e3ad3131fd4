// Detection of files compressed as a whole by gzip, which need memory for their content.
#pragma once

#include <string>

namespace palpa::protocol {

/// Whether a file is compressed, by its first bytes; false if it cannot be opened. Any thread. Throws LoadError on a disk
/// error.
bool is_packed(const std::string& path);

/// Whether a file is DICOM whose elements are deflated, or a folder, which may hold such files; false where it cannot be
/// opened. Any thread. Throws LoadError where the disk fails.
bool may_be_deflated(const std::string& path);

}  // namespace palpa::protocol
