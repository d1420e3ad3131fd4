// New files in the module's file system, which is in memory: no crash leaves half a file, no link leads elsewhere.
#include "palpa/base/new_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "palpa/base/load_error.h"

namespace palpa::detail {
namespace {

[[noreturn]] void fail(int error) {
  if (error == EEXIST) throw LoadError("exists already; name a new file");
  throw LoadError("cannot be written (" + std::generic_category().message(error) + "); name a file in a folder");
}

}  // namespace

NewFile::NewFile(std::filesystem::path name, Existing existing) : name_(std::move(name)), existing_(existing) {
  const int taken = existing_ == Existing::refused ? O_EXCL : O_TRUNC;
  descriptor_ = ::open(name_.c_str(), O_WRONLY | O_CREAT | taken, 0666);
  if (descriptor_ < 0) fail(errno);
  hidden_ = name_;
}

NewFile::~NewFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!hidden_.empty()) ::unlink(hidden_.c_str());
}

void NewFile::write(const void* data, std::size_t bytes) {
  for (const char* next = static_cast<const char*>(data); bytes > 0;) {
    const ssize_t written = ::write(descriptor_, next, bytes);
    if (written <= 0) fail(written < 0 ? errno : ENOSPC);
    next += written, bytes -= static_cast<std::size_t>(written);
  }
}

void NewFile::finish(bool) { hidden_.clear(); }

}  // namespace palpa::detail
