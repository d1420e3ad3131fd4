// The one way out: every file that leaves is written here (docs/design.md §3); traces, which must outlive a crash, write their
// own rows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace palpa::detail {

/// What becomes of a file that has the name already.
enum class Existing : std::uint8_t { refused, replaced };

/// A file that gets its name when it is whole. Until then it has none, or where the disk cannot do that a hidden one beside it:
/// a signal, a crash or a full disk leaves nothing, and what had the name before stays as it was. Never writes through a link
/// or into a pipe or a device. One thread.
class NewFile {
 public:
  /// Throws LoadError with a sentence, without the name: where the name is taken, or nothing can be written beside it.
  NewFile(std::filesystem::path name, Existing existing);
  ~NewFile();  ///< without `finish` nothing is left
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;

  /// Appends. Throws LoadError with a sentence where the disk is full or fails.
  void write(const void* data, std::size_t bytes);
  void write(std::string_view text) { write(text.data(), text.size()); }

  /// Makes sure that it is on the disk, and gives it its name. Throws LoadError with a sentence, also where somebody has taken
  /// the name meanwhile. Once.
  void finish();

 private:
  std::filesystem::path hidden_name() const;

  std::filesystem::path name_, hidden_;  ///< `hidden_` is empty while it has no name at all
  Existing existing_;
  int descriptor_ = -1;
};

/// A whole file at once. Throws LoadError: "NAME: what is wrong; what would be right".
void write_whole(const std::filesystem::path& name, std::string_view bytes, Existing existing);

}  // namespace palpa::detail
