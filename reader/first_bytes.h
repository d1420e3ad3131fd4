// The first bytes of a file, by which formats are told apart.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

namespace palpa::reader {

/// Up to `most` bytes, unpacked where the file is compressed. Throws LoadError.
std::string first_bytes(const std::string& path, std::size_t most = 1024);

/// The tag of the first element of an XML file, without its "<": after the declaration, comments and the like, which may take
/// 64 MiB. Empty if the file is none. Throws LoadError.
std::string xml_root(const std::string& path);
/// The value of an attribute in a tag; empty if it has none of that name.
std::string attribute_in(std::string_view tag, std::string_view name);

/// The letters, digits and underscores at the start of a text, after blanks and quotes.
std::string first_word(std::string_view text);
/// The word that follows `key` at its first place in a text; empty if it is not there.
std::string word_after(std::string_view text, std::string_view key);

/// Questions about a file or folder that tell its format. The file is read when its bytes are first needed; functions that need
/// them throw LoadError.
class Beginning {
 public:
  explicit Beginning(std::string path) : path_(std::move(path)) {}

  const std::string& path() const noexcept { return path_; }
  bool is_folder() const;
  /// Whether its name ends with one of these.
  bool is_named(std::initializer_list<std::string_view> ends) const noexcept;
  /// Whether these bytes stand at a place.
  bool has(std::size_t at, std::string_view bytes) const;
  /// Whether these bytes stand behind a block of 512, 1024, 2048 … bytes that belongs to somebody else.
  bool has_behind_block(std::string_view bytes) const;
  /// Whether it is XML whose first element has this name; any name if that is empty.
  bool has_xml_root(std::string_view name) const;
  /// Whether it is packed by gzip as a whole.
  bool is_packed() const;
  /// Whether these bytes are among its first.
  bool contains(std::string_view bytes) const;
  /// Whether its first word is one of these.
  bool begins_with_word(std::initializer_list<std::string_view> words) const;

 private:
  const std::string& bytes() const;

  std::string path_;
  mutable std::optional<std::string> bytes_, root_;
};

}  // namespace palpa::reader
