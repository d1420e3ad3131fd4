// Parsing of descriptions NAME[,KEY=VALUE…].
#pragma once

#include <algorithm>
#include <charconv>
#include <string_view>
#include <system_error>
#include <utility>

namespace palpa::detail {

/// Removes and returns the text before the first comma of `rest`; removes the comma.
inline std::string_view next_word(std::string_view& rest) noexcept {
  const std::size_t end = std::min(rest.find(','), rest.size());
  const std::string_view word = rest.substr(0, end);
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return word;
}

/// Both sides of the first '='; the value is empty without one.
inline std::pair<std::string_view, std::string_view> key_and_value(std::string_view word) noexcept {
  const std::size_t equals = std::min(word.find('='), word.size());
  return {word.substr(0, equals), word.substr(std::min(equals + 1, word.size()))};
}

/// Parses the whole text as a number.
template <class Number>
bool read_number(std::string_view text, Number& value) noexcept {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

}  // namespace palpa::detail
