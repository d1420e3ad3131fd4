#include "palpa/limits/free_memory.h"

#include <algorithm>
#include <fstream>
#include <string>

namespace palpa::detail {

std::uint64_t free_memory_bytes() {
  std::uint64_t free = 0;
  std::ifstream info("/proc/meminfo");
  for (std::string key; info >> key;) {
    if (key == "MemAvailable:" && info >> free) break;
    info.ignore(1 << 12, '\n');
  }
  free *= 1024;
  std::uint64_t limit = 0, used = 0;
  if (std::ifstream("/sys/fs/cgroup/memory.max") >> limit && std::ifstream("/sys/fs/cgroup/memory.current") >> used) {
    free = std::min(free, limit > used ? limit - used : 0);
  }
  return free;
}

}  // namespace palpa::detail
