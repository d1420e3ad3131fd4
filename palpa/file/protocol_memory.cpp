#include "palpa/file/protocol_memory.h"

#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <new>

#include "palpa/base/load_error.h"

namespace palpa::protocol {
namespace {

/// Memory from this size on is shared in two halves, for two writing threads. More: large files are written by one thread;
/// less: small ones pay for two files.
constexpr std::uint64_t large_bytes = 1 << 24;
constexpr std::uint64_t whole_pages_bytes = 1 << 16;  ///< a multiple of the page size of any machine

bool holds(int file, std::uint64_t bytes) {
  struct stat status {};
  return file >= 0 && ::fstat(file, &status) == 0 && static_cast<std::uint64_t>(status.st_size) >= bytes;
}

/// Writes to a file, and the unwritten remainder to its mapping.
void write_part(int file, std::uint64_t at, std::byte* place, const std::byte* from, std::uint64_t bytes) {
  const ssize_t written = ::pwrite(file, from, bytes, static_cast<off_t>(at));
  const std::uint64_t done = written > 0 ? static_cast<std::uint64_t>(written) : 0;
  std::memcpy(place + done, from + done, bytes - done);
}

}  // namespace

std::uint64_t bytes_in_first(std::uint64_t bytes) noexcept {
  return bytes < large_bytes ? bytes : bytes / 2 / whole_pages_bytes * whole_pages_bytes;
}

void Memory::write(std::byte* place, const std::byte* from, std::uint64_t count) const {
  const std::uint64_t in_first = bytes_in_first(bytes);
  const auto at = static_cast<std::uint64_t>(place - all.get());
  const std::uint64_t to_first = at < in_first ? std::min(count, in_first - at) : 0;
  if (to_first > 0) write_part(files.first, at, place, from, to_first);
  if (count > to_first) write_part(files.second, at + to_first - in_first, place + to_first, from + to_first, count - to_first);
}

Memory mapped(const MemoryFiles& files, std::uint64_t bytes, bool writable) {
  const std::uint64_t in_first = bytes_in_first(bytes), in_second = bytes - in_first;
  if (!holds(files.first, in_first) || (in_second > 0 && !holds(files.second, in_second)))
    throw LoadError("got too little memory from the program that asked for it; update palpa and palpa-read together");
  const int access = writable ? PROT_READ | PROT_WRITE : PROT_READ;
  void* memory = ::mmap(nullptr, bytes, access, MAP_SHARED, files.first, 0);  // reserves the addresses of the second, too
  if (memory == MAP_FAILED) throw std::bad_alloc();
  Memory made{files, bytes, {static_cast<std::byte*>(memory), [bytes](std::byte* m) { ::munmap(m, bytes); }}};
  if (in_second > 0 &&
      ::mmap(made.all.get() + in_first, in_second, access, MAP_SHARED | MAP_FIXED, files.second, 0) == MAP_FAILED) {
    throw std::bad_alloc();
  }
  return made;
}

}  // namespace palpa::protocol
