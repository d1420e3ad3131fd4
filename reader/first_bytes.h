// First bytes of a file, which identify its format.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

namespace palpa::reader {

/// Up to `most` bytes, decompressed if the file is compressed. Throws LoadError.
std::string first_bytes(const std::string& path, std::size_t most = 1024);

/// Tag of an XML file's first element, without "<", after the declaration and comments, of up to 64 MiB. Empty if the file is
/// no XML. Throws LoadError.
std::string xml_root(const std::string& path);
/// Value of an attribute in a tag; empty if absent.
std::string attribute_in(std::string_view tag, std::string_view name);

/// Letters, digits and underscores at the start of a text, after blanks and quotes.
std::string first_word(std::string_view text);
/// Word that follows the first `key` in a text; empty if absent.
std::string word_after(std::string_view text, std::string_view key);

/// Tests of a file or folder that identify its format. The first test of its bytes reads the file and may throw LoadError.
class Beginning {
 public:
  explicit Beginning(std::string path) : path_(std::move(path)) {}

  const std::string& path() const noexcept { return path_; }
  bool is_folder() const;
  /// Folder with metadata of Zarr.
  bool is_store() const;
  bool is_folder_with(const char* file) const;
  /// Folder whose file "info" contains these bytes near its begin.
  bool info_says(std::string_view bytes) const;
  bool is_named(std::initializer_list<std::string_view> ends) const noexcept;
  bool has(std::size_t at, std::string_view bytes) const;
  /// These bytes follow a user block of 512, 1024, 2048 … bytes.
  bool has_behind_block(std::string_view bytes) const;
  /// XML with this first element; with any if empty.
  bool has_xml_root(std::string_view name) const;
  /// TIFF or BigTIFF, in either byte order.
  bool is_tiff() const;
  /// Compressed by gzip as a whole.
  bool is_packed() const;
  bool contains(std::string_view bytes) const;
  bool begins_with_word(std::initializer_list<std::string_view> words) const;

 private:
  const std::string& bytes() const;

  std::string path_;
  mutable std::optional<std::string> bytes_, root_;
};

}  // namespace palpa::reader
