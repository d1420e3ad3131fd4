// The one way in: every file that is read here was opened here (docs/design.md §3).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <istream>
#include <memory>
#include <streambuf>
#include <string>
#include <string_view>

#include "palpa/base/limits.h"

namespace palpa::detail {

/// Why a file cannot be read.
enum class NoInput : std::uint8_t { none, missing, folder, special, unreadable };

/// A file that somebody else may have made, opened for reading. Only regular files are opened, and opening never waits: the
/// open of a FIFO would wait for its writer, a device may have no end. What is read ends where the file ended when it was
/// opened. Any thread; two may read at once.
class InputFile {
 public:
  /// Opens it. Where that cannot be, `why_not` says it and there are no bytes. \param path  followed where it is a link
  explicit InputFile(std::filesystem::path path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  NoInput why_not() const noexcept { return why_not_; }
  bool is_open() const noexcept { return why_not_ == NoInput::none; }
  /// What is wrong, to stand behind the file's name: "does not exist". Only where it is not open.
  std::string problem() const;
  /// Throws LoadError "PATH: problem; right" where it is not open.
  void expect_open(std::string_view right) const;

  const std::filesystem::path& path() const noexcept { return path_; }
  /// Its size when it was opened.
  std::uint64_t bytes() const noexcept { return bytes_; }
  /// For calls that need one; stays this object's. -1 where it is not open.
  int descriptor() const noexcept { return descriptor_; }

  /// Reads bytes from a place on: as many as there are up to the size that the file had. Returns how many; fewer than that
  /// where the file was cut short meanwhile. Throws LoadError where the disk fails.
  std::size_t read(std::uint64_t from, void* to, std::size_t bytes) const;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  int error_ = 0;
  NoInput why_not_ = NoInput::none;
  std::uint64_t bytes_ = 0;
};

/// All of a file, for texts. Throws LoadError, also where it is longer than the limit, before it is read.
/// \param most   [bytes]
/// \param right  what would be right where it is not open: "name a scene file"
std::string read_whole(const InputFile& file, const Limit& most, std::string_view right);

/// The same file as a stream, for code that reads one; it fails from the start where the file is not open.
class InputStream : public std::istream {
 public:
  explicit InputStream(const std::filesystem::path& path);
  const InputFile& file() const noexcept { return buffer_.file; }

 private:
  class Buffer : public std::streambuf {
   public:
    explicit Buffer(const std::filesystem::path& path);
    InputFile file;

   private:
    int_type underflow() override;
    pos_type seekoff(off_type by, std::ios_base::seekdir from, std::ios_base::openmode which) override;
    pos_type seekpos(pos_type to, std::ios_base::openmode which) override;

    std::unique_ptr<char[]> piece_;
    std::uint64_t end_of_piece_ = 0;  ///< [bytes] where in the file the piece ends
  };
  Buffer buffer_;
};

}  // namespace palpa::detail
