#include "palpa/base/free_memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <utility>

namespace palpa::detail {

namespace {

std::uint64_t left(std::uint64_t limit, std::uint64_t used) { return limit > used ? limit - used : 0; }

}  // namespace

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
    free = std::min(free, left(limit, used));
  }
  std::uint64_t addressed = 0, resident = 0;
  if (std::ifstream("/proc/self/statm") >> addressed >> resident) {
    // Linux enforces the first alone; programs have to respect the second.
    for (const auto& [resource, pages] : {std::pair{RLIMIT_AS, addressed}, std::pair{RLIMIT_RSS, resident}}) {
      rlimit own{};
      if (::getrlimit(resource, &own) == 0 && own.rlim_cur != RLIM_INFINITY)
        free = std::min(free, left(own.rlim_cur, pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE))));
    }
  }
  return free;
}

}  // namespace palpa::detail
