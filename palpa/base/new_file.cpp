#include "palpa/base/new_file.h"

#include <fcntl.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <random>
#include <system_error>
#include <utility>

#include "palpa/base/load_error.h"

namespace palpa::detail {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(int error) {
  const bool full = error == ENOSPC || error == EDQUOT || error == EFBIG;
  throw LoadError("cannot be written (" + std::generic_category().message(error) + "); " +
                  (full ? "make room, or name another disk" : "name a file in a folder that may be written to"));
}

[[noreturn]] void refuse_as_taken() { throw LoadError("exists already; name a new file, or have it replaced (--force)"); }

/// Only a regular file is replaced: a link's target belongs to others; a device or a pipe is no file.
void check_name(const fs::path& name, Existing existing) {
  struct stat status{};
  if (::lstat(name.c_str(), &status) != 0) return;  // open reports other faults
  if (S_ISDIR(status.st_mode)) fail(EISDIR);
  if (existing == Existing::refused) refuse_as_taken();
  if (!S_ISREG(status.st_mode))
    throw LoadError("cannot be written: it is a link, a pipe or a device; name an ordinary file, or remove it first");
}

}  // namespace

NewFile::NewFile(fs::path name, Existing existing) : name_(std::move(name)), existing_(existing) {
  check_name(name_, existing_);
  if (!name_.has_filename()) fail(EISDIR);
  const fs::path folder = name_.has_parent_path() ? name_.parent_path() : fs::path(".");
  // A file without a name vanishes with the process, however it ends; /proc gives it its name.
  if (::access("/proc/self/fd", X_OK) == 0) descriptor_ = ::open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
  if (descriptor_ >= 0) return;
  fs::path hidden = hidden_name();
  descriptor_ = ::open(hidden.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (descriptor_ < 0) fail(errno);
  hidden_ = std::move(hidden);
}

NewFile::~NewFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!hidden_.empty()) ::unlink(hidden_.c_str());
}

fs::path NewFile::hidden_name() const {
  std::random_device random;
  return name_.parent_path() / (".palpa-" + std::to_string(random()) + "-" + std::to_string(random()));
}

void NewFile::write(const void* data, std::size_t bytes) {
  for (const char* next = static_cast<const char*>(data); bytes > 0;) {
    const ssize_t written = ::write(descriptor_, next, bytes);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail(written < 0 ? errno : ENOSPC);
    next += written, bytes -= static_cast<std::size_t>(written);
  }
}

bool NewFile::sync_with_others() noexcept { return ::syncfs(descriptor_) == 0; }

void NewFile::finish(bool is_synced) {
  if (!is_synced && ::fsync(descriptor_) != 0) fail(errno);
  const auto link_as = [&](const fs::path& name) {
    const std::string nameless = "/proc/self/fd/" + std::to_string(descriptor_);
    return ::linkat(AT_FDCWD, nameless.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW);
  };
  if (existing_ == Existing::refused) {
    // A link fails if the name is taken, unlike a rename; some file systems have no links.
    int failed = hidden_.empty() ? link_as(name_) : ::link(hidden_.c_str(), name_.c_str());
    if (failed != 0 && errno != EEXIST && !hidden_.empty())
      failed = ::renameat2(AT_FDCWD, hidden_.c_str(), AT_FDCWD, name_.c_str(), RENAME_NOREPLACE);
    if (failed == 0) return;
    if (errno == EEXIST) refuse_as_taken();
    fail(errno);
  }
  // Most names are free: then one link gives the name.
  if (hidden_.empty() && link_as(name_) == 0) return;
  if (hidden_.empty()) {
    fs::path hidden = hidden_name();
    if (link_as(hidden) != 0) fail(errno);
    hidden_ = std::move(hidden);
  }
  check_name(name_, existing_);
  if (::rename(hidden_.c_str(), name_.c_str()) != 0) fail(errno);
  hidden_.clear();
}

}  // namespace palpa::detail
