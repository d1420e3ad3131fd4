// SHA-256 of a file, known at once or later.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

namespace palpa {

/// Checksums that a reading computes.
enum class Checksums : std::uint8_t {
  none,
  now,    ///< before the reading ends
  later,  ///< in another thread, while the data are already in use
};

/// Checksums of a volume's files, computed by another thread, which ends with this object. Any thread.
class LateChecksums {
 public:
  virtual ~LateChecksums() = default;
  /// `text` does not block.
  virtual bool are_known() const = 0;
  /// In hexadecimal; empty if a file could not be read. Blocks until all are computed. \param file  number in the volume
  virtual std::string text(std::size_t file) const = 0;
};

/// SHA-256 of a file, a value. Any thread.
class Checksum {
 public:
  /// Unknown: `text` is empty.
  Checksum() = default;
  template <std::convertible_to<std::string> Text>
  Checksum(Text&& hexadecimal) : text_(std::forward<Text>(hexadecimal)) {}  // NOLINT: a text is its own checksum
  Checksum(std::shared_ptr<const LateChecksums> later, std::size_t file) : later_(std::move(later)), file_(file) {}

  /// `text` does not block.
  bool is_known() const { return !later_ || later_->are_known(); }
  /// In hexadecimal; empty: unknown. Blocks until it is computed.
  std::string text() const { return later_ ? later_->text(file_) : text_; }
  /// Equal texts. Blocks, except for copies.
  friend bool operator==(const Checksum& a, const Checksum& b) {
    const bool are_copies = a.later_ && a.later_ == b.later_ && a.file_ == b.file_;
    return are_copies || a.text() == b.text();
  }

 private:
  std::string text_;
  std::shared_ptr<const LateChecksums> later_;
  std::size_t file_ = 0;
};

}  // namespace palpa
