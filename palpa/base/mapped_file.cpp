#include "palpa/base/mapped_file.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <mutex>
#include <string_view>

#include "palpa/base/load_error.h"

namespace palpa::detail {
namespace {

/// Mapped file as registered with the signal handler; `begin` is 0 in a free entry.
struct Place {
  std::atomic<std::uintptr_t> begin = 0, end = 0;
  std::atomic<bool> whole = true;
};
static_assert(std::atomic<std::uintptr_t>::is_always_lock_free && std::atomic<bool>::is_always_lock_free, "used in a handler");

constexpr std::size_t most_places =
    256;  // [1] files mapped at once. More: a longer search in the handler; fewer: files refused
std::array<Place, most_places> places;
std::mutex taking;
struct sigaction before {};
std::atomic<std::uintptr_t> page_bytes = 4096;

/// Maps zeros in place of the lost page, so that the read continues.
void on_lost_page(int number, siginfo_t* info, void*) {
  const int error = errno;
  const auto at = reinterpret_cast<std::uintptr_t>(info->si_addr);
  for (Place& place : places) {
    const std::uintptr_t begin = place.begin, end = place.end;
    if (info->si_code <= 0 || begin == 0 || at < begin || at >= end) continue;
    const std::uintptr_t from = at / page_bytes * page_bytes;
    if (::mmap(reinterpret_cast<void*>(from), end - from, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED | MAP_NORESERVE,
               -1, 0) == MAP_FAILED)
      break;
    if (place.whole.exchange(false)) {
      constexpr std::string_view said = "palpa: a mapped file: was cut short while it was used; what is gone reads as zeros\n";
      [[maybe_unused]] const ssize_t ignored = ::write(STDERR_FILENO, said.data(), said.size());
    }
    errno = error;
    return;
  }
  ::sigaction(SIGBUS, &before, nullptr);
  if (info->si_code <= 0) ::raise(number);  // sent by a process; else the access repeats it
  errno = error;
}

void catch_lost_pages() {
  page_bytes = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  struct sigaction action {};
  action.sa_sigaction = on_lost_page;
  action.sa_flags = SA_SIGINFO;
  ::sigaction(SIGBUS, &action, &before);
}

}  // namespace

MappedFile::MappedFile(const InputFile& file) : bytes_(file.bytes()) {
  if (bytes_ == 0) return;
  static const bool caught = (catch_lost_pages(), true);
  static_cast<void>(caught);
  const std::lock_guard lock(taking);
  while (place_ < most_places && places[place_].begin != 0) ++place_;
  if (place_ == most_places) throw LoadError("cannot be read: too many files are mapped; close some");
  void* const memory = ::mmap(nullptr, bytes_, PROT_READ, MAP_SHARED, file.descriptor(), 0);
  if (memory == MAP_FAILED) throw LoadError("cannot be read: there is no address space for it; crop or downsample the volume");
  data_ = static_cast<const std::byte*>(memory);
  descriptor_ = ::fcntl(file.descriptor(), F_DUPFD_CLOEXEC, 0);
  Place& place = places[place_];
  place.whole = true;
  place.end = reinterpret_cast<std::uintptr_t>(memory) + bytes_;
  place.begin = reinterpret_cast<std::uintptr_t>(memory);
}

MappedFile::~MappedFile() {
  if (data_ == nullptr) return;
  const std::lock_guard lock(taking);
  places[place_].begin = 0;
  ::munmap(const_cast<std::byte*>(data_), bytes_);
  if (descriptor_ >= 0) ::close(descriptor_);
}

bool MappedFile::is_whole() const noexcept {
  if (data_ == nullptr) return true;
  // Within the page of the file's new end no signal is raised: the system has zeros there.
  struct stat status {};
  const bool is_shorter = ::fstat(descriptor_, &status) == 0 && static_cast<std::uint64_t>(status.st_size) < bytes_;
  return places[place_].whole && !is_shorter;
}

}  // namespace palpa::detail
