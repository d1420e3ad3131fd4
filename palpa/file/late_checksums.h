// Checksums that are computed while the data are in use.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "palpa/data/volume.h"

namespace palpa::detail {

/// Checksums of all files of a volume, by a thread that starts at once. A LoadError of `compute` leaves them empty.
/// \param compute  in the files' order
/// \param stop     ends `compute` soon; requested when nothing has the checksums any more
std::shared_ptr<const LateChecksums> checksums_by(std::function<std::vector<std::string>()> compute, std::stop_source stop);

/// Likewise of one file.
Checksum checksum_by_thread(const std::string& path, std::stop_source stop);

}  // namespace palpa::detail
