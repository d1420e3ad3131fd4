#include "palpa/file/shared_memory.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <new>
#include <string>

#include "palpa/base/load_error.h"
#include "palpa/file/protocol.h"

namespace palpa::detail {
namespace {

/// Seals a file. A dead process's mapping may last a moment longer (a reader of /proc holds it).
void seal(int file) {
  int sealed = -1;
  for (int wait_ms = 0; wait_ms < 2000 && (sealed = ::fcntl(file, F_ADD_SEALS, F_SEAL_WRITE | F_SEAL_SEAL)) != 0; ++wait_ms) {
    if (errno != EBUSY) break;
    ::usleep(1000);
  }
  if (sealed != 0) {
    throw LoadError(std::string("cannot be read: its voxels cannot be sealed (") + std::strerror(errno) + "); try again");
  }
}

std::string no_memory(const char* of, std::uint64_t bytes, const std::string& why) {
  return std::string("cannot be read: no ") + of + " of " + protocol::readable_bytes(static_cast<double>(bytes)) + why +
         "; crop or downsample the volume (palpa convert --crop, --downsample)";
}

}  // namespace

UnpackedMemory::UnpackedMemory() : file_(::memfd_create("palpa-unpacked", MFD_CLOEXEC)) {
  if (file_ < 0)
    throw LoadError(std::string("cannot be unpacked: no memory for it (") + std::strerror(errno) + "); unpack it (gunzip)");
}

UnpackedMemory::~UnpackedMemory() { ::close(file_); }

SharedMemory::SharedMemory(std::uint64_t bytes) : bytes_(bytes) {
  const std::uint64_t in_first = protocol::bytes_in_first(bytes);
  make(files_.first, in_first);
  if (bytes > in_first) make(files_.second, bytes - in_first);
}

SharedMemory::~SharedMemory() { close(); }

std::shared_ptr<const std::byte> SharedMemory::sealed_and_mapped() {
  seal(files_.first);
  if (files_.second >= 0) seal(files_.second);
  try {
    return protocol::mapped(files_, bytes_, false).all;
  } catch (const std::bad_alloc&) {
    throw LoadError(no_memory("address space", bytes_, ""));
  }
}

void SharedMemory::make(int& file, std::uint64_t bytes) {
  file = ::memfd_create("palpa-voxels", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (file >= 0 && ::ftruncate(file, static_cast<off_t>(bytes)) == 0 &&
      ::fcntl(file, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW) == 0) {
    return;
  }
  const int problem = errno;
  close();
  throw LoadError(no_memory("shared memory", bytes_, std::string(" (") + std::strerror(problem) + ")"));
}

void SharedMemory::close() noexcept {
  for (const int file : {files_.first, files_.second}) {
    if (file >= 0) ::close(file);
  }
}

}  // namespace palpa::detail
