// Sandbox of the readers. Code injected by a damaged file can compute and read the folder of the user's file, nothing
// else. palpa-fetch has a network, and no file of the user.
#pragma once

#include <string>

#include "palpa/file/protocol.h"

namespace palpa::reader {

/// Confines palpa-read permanently before it reads a file. Left open: exec of the programs beside it, which stay confined.
/// \param request  names the files, whose folders stay readable, and the bytes for voxels
/// Returns the parts that the running kernel lacks, in words; empty: none.
std::string enter_cage(const protocol::Request& request);

/// Closes exec, too, before parsing.
void close_cage();

/// Confines palpa-fetch permanently before it opens a connection: it reads what the system's libraries need of /etc, /usr and
/// certificates, writes nothing but memory, and can start no program. Returns what is lacking, as `enter_cage`.
std::string enter_cage_with_network();

/// Refuses a file in a header or link that only the sandbox makes unreadable: libraries would skip it or report another reason.
/// Throws LoadError.
void check_within_cage(const std::string& file);

}  // namespace palpa::reader
