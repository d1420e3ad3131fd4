// Memory available for data.
#pragma once

#include <cstdint>

namespace palpa::detail {

/// Memory that this process may still allocate [bytes]: the machine's free memory, or less by a control group, the limit of the
/// address space (`ulimit -v`) or of memory (`ulimit -m`). Reads files of the system; any thread.
std::uint64_t free_memory_bytes();

}  // namespace palpa::detail
