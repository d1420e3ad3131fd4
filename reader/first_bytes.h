// What a file begins with, by which formats are told apart.
#pragma once

#include <string>
#include <string_view>

namespace palpa::reader {

/// Up to 1024 bytes, unpacked where the file is compressed. Throws LoadError.
std::string first_bytes(const std::string& path);

/// The letters, digits and underscores at the start of a text, after blanks and quotes.
std::string first_word(std::string_view text);
/// The word that follows `key` at its first place in a text; empty if it is not there.
std::string word_after(std::string_view text, std::string_view key);

}  // namespace palpa::reader
