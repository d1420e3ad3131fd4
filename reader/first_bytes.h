// The first bytes of a file, by which formats are told apart.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

namespace palpa::reader {

/// Up to 1024 bytes, unpacked where the file is compressed. Throws LoadError.
std::string first_bytes(const std::string& path);

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
  /// Whether these bytes are among its first.
  bool contains(std::string_view bytes) const;
  /// Whether its first word is one of these.
  bool begins_with_word(std::initializer_list<std::string_view> words) const;

 private:
  const std::string& bytes() const;

  std::string path_;
  mutable std::optional<std::string> bytes_;
};

}  // namespace palpa::reader
