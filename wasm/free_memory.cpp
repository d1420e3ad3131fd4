// Memory that the module can still get.
#include "palpa/base/free_memory.h"

#include <cstddef>

namespace palpa::detail {

std::uint64_t free_memory_bytes() {
  constexpr std::uint64_t addressable = std::uint64_t{1} << 32, page = std::uint64_t{1} << 16;
  return addressable - page * __builtin_wasm_memory_size(0);
}

}  // namespace palpa::detail
