#include "palpa/base/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "palpa/base/load_error.h"

namespace palpa::detail {
namespace {

constexpr std::size_t piece_bytes = std::size_t{1} << 16;  // of a stream. More: more memory; less: more system calls

}  // namespace

InputFile::InputFile(std::filesystem::path path) : path_(std::move(path)) {
  descriptor_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  struct stat status {};
  if (descriptor_ < 0 || ::fstat(descriptor_, &status) != 0) {
    error_ = errno;
    // Sockets cannot be opened (ENXIO).
    why_not_ = error_ == ENOENT || error_ == ENOTDIR ? NoInput::missing
               : error_ == ENXIO                     ? NoInput::special
                                                     : NoInput::unreadable;
  } else if (S_ISDIR(status.st_mode)) {
    why_not_ = NoInput::folder;
  } else if (!S_ISREG(status.st_mode)) {
    why_not_ = NoInput::special;
  } else {
    bytes_ = static_cast<std::uint64_t>(std::max<off_t>(status.st_size, 0));
  }
  if (!is_open() && descriptor_ >= 0) ::close(descriptor_), descriptor_ = -1;
}

InputFile::~InputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::string InputFile::problem() const {
  switch (why_not_) {
    case NoInput::missing: return "does not exist";
    case NoInput::folder: return "is a folder";
    case NoInput::special: return "is no ordinary file, but a pipe, a socket or a device";
    default: return "cannot be read (" + std::generic_category().message(error_) + ")";
  }
}

void InputFile::expect_open(std::string_view right) const {
  if (!is_open()) throw LoadError(path_.string() + ": " + problem() + "; " + std::string(right));
}

std::size_t InputFile::read(std::uint64_t from, void* to, std::size_t bytes) const {
  const std::size_t wanted = from >= bytes_ ? 0 : static_cast<std::size_t>(std::min<std::uint64_t>(bytes, bytes_ - from));
  std::size_t done = 0;
  while (done < wanted) {
    const ssize_t got = ::pread(descriptor_, static_cast<char*>(to) + done, wanted - done, static_cast<off_t>(from + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) {
      throw LoadError(path_.string() + ": cannot be read (" + std::generic_category().message(errno) +
                      "); copy it to a disk that is sound");
    }
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

std::string read_whole(const InputFile& file, const Limit& most, std::string_view right) {
  file.expect_open(right);
  if (most.is_passed_by(static_cast<double>(file.bytes()))) {
    throw LoadError(file.path().string() + ": longer than " + quantity(most) + "; " + std::string(most.remedy));
  }
  std::string text(static_cast<std::size_t>(file.bytes()), '\0');
  text.resize(file.read(0, text.data(), text.size()));
  return text;
}

InputStream::Buffer::Buffer(const std::filesystem::path& path) : file(path), piece_(new char[piece_bytes]) {}

InputStream::Buffer::int_type InputStream::Buffer::underflow() {
  const std::size_t got = file.is_open() ? file.read(end_of_piece_, piece_.get(), piece_bytes) : 0;
  if (got == 0) return traits_type::eof();
  end_of_piece_ += got;
  setg(piece_.get(), piece_.get(), piece_.get() + got);
  return traits_type::to_int_type(*gptr());
}

InputStream::Buffer::pos_type InputStream::Buffer::seekoff(off_type by, std::ios_base::seekdir from,
                                                           std::ios_base::openmode which) {
  const auto here = static_cast<off_type>(end_of_piece_) - (egptr() - gptr());
  return seekpos(by + (from == std::ios_base::cur   ? here
                       : from == std::ios_base::end ? static_cast<off_type>(file.bytes())
                                                    : 0),
                 which);
}

InputStream::Buffer::pos_type InputStream::Buffer::seekpos(pos_type to, std::ios_base::openmode) {
  const off_type place = to;
  if (place < 0 || static_cast<std::uint64_t>(place) > file.bytes()) return pos_type(off_type(-1));
  end_of_piece_ = static_cast<std::uint64_t>(place);
  setg(nullptr, nullptr, nullptr);
  return to;
}

InputStream::InputStream(const std::filesystem::path& path) : std::istream(nullptr), buffer_(path) {
  rdbuf(&buffer_);
  if (!buffer_.file.is_open()) setstate(failbit);
}

}  // namespace palpa::detail
