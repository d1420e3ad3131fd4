// Writing of all output files (docs/design.md §3), except traces, which must survive a crash and write their own rows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace palpa::detail {

/// Treatment of an existing file with the name.
enum class Existing : std::uint8_t { refused, replaced };

/// File that gets its name when complete. Until then it is unnamed, or hidden beside the name if the file system requires it: a
/// signal, a crash or a full disk leaves nothing and keeps an existing file. Never writes through a link or into a pipe or a
/// device. One thread.
class NewFile {
 public:
  /// Throws LoadError with a sentence, without the name: the name is taken, or the folder is not writable.
  NewFile(std::filesystem::path name, Existing existing);
  ~NewFile();  ///< without `finish` no file remains
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;

  /// Appends. Throws LoadError with a sentence if the disk is full or fails.
  void write(const void* data, std::size_t bytes);
  void write(std::string_view text) { write(text.data(), text.size()); }

  /// Syncs all files of the file system to disk: of many files at once that takes less time than a sync of each. False: it
  /// failed.
  bool sync_with_others() noexcept;

  /// Syncs the file to disk and gives it its name. Throws LoadError with a sentence, also if the name was taken meanwhile.
  /// Once.
  /// \param is_synced  all was written before a `sync_with_others` of a file of the same file system
  void finish(bool is_synced = false);

 private:
  std::filesystem::path hidden_name() const;

  std::filesystem::path name_, hidden_;  ///< `hidden_` is empty for a file without any name
  Existing existing_;
  int descriptor_ = -1;
};

/// Writes a complete file. Throws LoadError: "NAME: what is wrong; what would be right".
void write_whole(const std::filesystem::path& name, std::string_view bytes, Existing existing);

}  // namespace palpa::detail
