// How much memory there is for data.
#pragma once

#include <cstdint>

namespace palpa::detail {

/// What this process may still take [bytes]: the machine's free memory, or less where a control group or the limit of the
/// process's addresses (`ulimit -v`) says so. Reads files of the system; any thread.
std::uint64_t free_memory_bytes();

}  // namespace palpa::detail
