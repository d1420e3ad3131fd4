// What keeps TOML's parser from a text that would take it down, or keep it busy for minutes.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace palpa::detail {

/// Why a text is not given to the parser.
struct TomlProblem {
  std::size_t line = 1, column = 1;  ///< [1] where, from 1
  std::string sentence;              ///< "a key of more than 16 parts; …"
};

/// What the parser cannot bear in a text; none where there is nothing. To be asked of every text before it is parsed, which a
/// test watches: toml++ builds a table for every part of a key and takes them down recursively, so that a key of 100 000 dots
/// overflows the stack; and it looks for each heading among all others, so that 100 000 of them take minutes (limits.h:
/// key_parts, headings). The text need not be right. Any thread; allocates nothing but the sentence.
std::optional<TomlProblem> problem_with_toml(std::string_view text);

}  // namespace palpa::detail
