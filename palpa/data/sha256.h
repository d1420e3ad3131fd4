// SHA-256 (FIPS 180-4) of a file.
#pragma once

#include <string>

namespace palpa::detail {

/// Checksum in hexadecimal. Throws LoadError with a sentence if the file cannot be read.
std::string sha256_of_file(const std::string& path);

}  // namespace palpa::detail
