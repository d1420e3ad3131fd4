// How much memory there is for data.
#pragma once

#include <cstdint>

namespace palpa::detail {

/// What this process may still take [bytes]: the machine's free memory, or less where a control group, the limit of the
/// process's addresses (`ulimit -v`) or that of its memory (`ulimit -m`) says so. Reads files of the system; any thread.
std::uint64_t free_memory_bytes();

}  // namespace palpa::detail
