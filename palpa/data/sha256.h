// SHA-256 (FIPS 180-4) of a file.
#pragma once

#include <stop_token>
#include <string>

namespace palpa::detail {

/// Checksum in hexadecimal; empty after a stop. Throws LoadError with a sentence if the file cannot be read.
std::string sha256_of_file(const std::string& path, std::stop_token stop = {});

}  // namespace palpa::detail
