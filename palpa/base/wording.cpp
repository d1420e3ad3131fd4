#include "palpa/base/wording.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>

#include "palpa/base/sanitized.h"
#include "palpa/base/utf8.h"

namespace palpa::detail {

namespace {

constexpr std::size_t longest_quote = 80;  // [bytes] of a user's text in a message. More: long lines; less: cut keys and paths

/// Levenshtein distance: insertions, deletions and replacements of a character.
std::size_t edits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

bool is_control(char c) noexcept { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }

std::string escaped(char c) {
  constexpr std::string_view digits = "0123456789ABCDEF";
  const auto byte = static_cast<unsigned char>(c);
  return std::string("\\u00") + digits[byte >> 4] + digits[byte & 15];
}

}  // namespace

std::string toml_number(double value) {
  std::array<char, 40> buffer;
  char* const end = buffer.data() + buffer.size();
  const bool short_whole = value == std::trunc(value) && std::abs(value) < 1e15;  // 100000, not 1e+05
  const auto result = short_whole ? std::to_chars(buffer.data(), end, value, std::chars_format::fixed)
                                  : std::to_chars(buffer.data(), end, value);
  std::string text(buffer.data(), result.ptr);
  // TOML would parse a long run of digits as an integer, which has 64 bits and no negative zero.
  const bool whole = text.find_first_of(".en") == std::string::npos;
  if (whole && (text.size() > 15 || text == "-0")) text += ".0";
  return text;
}

std::string toml_numbers(const std::vector<double>& values) {
  std::string out;
  for (const double value : values) out += (out.empty() ? "" : ", ") + toml_number(value);
  return "[" + out + "]";
}

std::string toml_string(std::string_view text, std::string_view for_no_utf8) {
  std::string out = "\"";
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = utf8_length(text.substr(i));
    if (length == 0) {
      out += for_no_utf8;
      ++i;
    } else if (is_control(text[i])) {
      out += escaped(text[i++]);
    } else {
      if (text[i] == '"' || text[i] == '\\') out += '\\';
      out += text.substr(i, length);
      i += length;
    }
  }
  return out + '"';
}

std::string in_quotes(std::string_view text) {
  const std::string clean = sanitized(text);
  if (clean.size() <= longest_quote) return "'" + clean + "'";
  std::size_t end = longest_quote;
  while (end > 0 && (static_cast<unsigned char>(clean[end]) & 0xc0) == 0x80) --end;
  return "'" + clean.substr(0, end) + "…'";
}

std::string one_line(std::string_view message) { return sanitized(message); }

std::string joined(std::span<const std::string> words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : ", ") + word;
  return out;
}

bool is_plain_word(std::string_view word) noexcept {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto inner = [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-'; };
  return !word.empty() && letter(word.front()) && std::ranges::all_of(word, inner);
}

std::string problem_with_name(std::string_view kind, std::string_view name) {
  if (is_plain_word(name)) return {};
  return std::string(kind) + " name " + in_quotes(name) + " is no plain word; use a letter, then letters, digits, '_' or '-'";
}

std::string name_is_taken(std::string_view kind, std::string_view name) {
  const std::string word(kind);
  return word + " name " + in_quotes(name) + " is taken; give every " + word + " a name of its own";
}

std::string suggestion(std::string_view name, std::span<const std::string> there) {
  if (there.empty()) return "there are none";
  const std::string* nearest = nullptr;
  std::size_t fewest = 2 + name.size() / 4;  // more edits make another word
  for (const std::string& word : there) {
    if (name.size() > word.size() + fewest) continue;
    // A prefix counts, too: units are easily omitted.
    const std::string_view beginning = std::string_view(word).substr(0, name.size());
    const std::size_t distance = name.size() < 4 ? edits(name, word) : std::min(edits(name, word), 1 + edits(name, beginning));
    if (distance < fewest && distance < word.size()) {
      fewest = distance;
      nearest = &word;
    }
  }
  if (nearest) return "did you mean " + in_quotes(*nearest) + "?";
  return "there are: " + joined(there);
}

}  // namespace palpa::detail
