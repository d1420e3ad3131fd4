// Opening of all input files (docs/design.md §3).
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

/// Reason why a file cannot be read.
enum class NoInput : std::uint8_t { none, missing, folder, special, unreadable };

/// Untrusted file, opened for reading. Opens regular files only and never blocks: opening a FIFO would block, a device may have
/// no end. Reads end at the file's size at opening. Any thread; concurrent reads are allowed.
class InputFile {
 public:
  /// Opens the file; on failure `why_not` holds the reason and there are no bytes.
  /// \param path  links are followed
  explicit InputFile(std::filesystem::path path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  NoInput why_not() const noexcept { return why_not_; }
  bool is_open() const noexcept { return why_not_ == NoInput::none; }
  /// Fault, to follow the file's name: "does not exist". Only if not open.
  std::string problem() const;
  /// Throws LoadError "PATH: problem; right" if not open.
  void expect_open(std::string_view right) const;

  const std::filesystem::path& path() const noexcept { return path_; }
  std::uint64_t bytes() const noexcept { return bytes_; }
  /// Owned by this object; -1 if not open.
  int descriptor() const noexcept { return descriptor_; }

  /// Reads bytes from an offset, up to the size at opening. Returns their number, smaller if the file was truncated meanwhile.
  /// Throws LoadError on a disk error.
  std::size_t read(std::uint64_t from, void* to, std::size_t bytes) const;

 private:
  std::filesystem::path path_;
  int descriptor_ = -1;
  int error_ = 0;
  NoInput why_not_ = NoInput::none;
  std::uint64_t bytes_ = 0;
};

/// Content of a text file. Throws LoadError, also for a file above the limit, before it is read.
/// \param most   [bytes]
/// \param right  remedy if not open: "name a scene file"
std::string read_whole(const InputFile& file, const Limit& most, std::string_view right);

/// An InputFile as a stream; in the failed state if the file is not open.
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
    std::uint64_t end_of_piece_ = 0;  ///< [bytes] offset of the piece's end in the file
  };
  Buffer buffer_;
};

}  // namespace palpa::detail
