// Check of a text before TOML's parser, against stack overflow and run times of minutes.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace palpa::detail {

/// Reason to refuse a text.
struct TomlProblem {
  std::size_t line = 1, column = 1;  ///< [1] position, from 1
  std::string sentence;              ///< "a key of more than 16 parts; …"
};

/// Finds constructs that would break the parser; none for a safe text. Required for every text before parsing (a test enforces
/// it): toml++ destroys the tables of a key's parts recursively, so a key of 100 000 dots overflows the stack; it compares each
/// heading with all others, so 100 000 of them take minutes (limits.h: key_parts, headings). The text need not be valid TOML.
/// Any thread; allocates only the sentence.
std::optional<TomlProblem> problem_with_toml(std::string_view text);

}  // namespace palpa::detail
