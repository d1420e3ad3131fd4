// The cage: what a program that parses files of others may still do. Whoever takes it over through a damaged file can compute,
// and read the folder that its user has named; nothing else.
#pragma once

#include <string>

#include "palpa/file/protocol.h"

namespace palpa::reader {

/// Closes the cage around palpa-read, for good, just before it looks into a file. Only the way to the programs beside it, which
/// it becomes and which stay in the cage, is left open.
/// \param request  names the files, whose folders can be read, and the bytes that voxels may have
/// Returns which parts the running kernel lacks, in words, without which the cage is closed; empty: none.
std::string enter_cage(const protocol::Request& request);

/// Closes that way, too, just before parsing.
void close_cage();

/// Refuses a file that a header or a link leads to and only the cage keeps closed: libraries would pass over it, or tell a
/// reason that does not help. Throws LoadError.
void check_within_cage(const std::string& file);

}  // namespace palpa::reader
