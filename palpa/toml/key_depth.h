// What keeps TOML's parser from a text that would take it down.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>

namespace palpa::detail {

constexpr int deepest_key = 16;  ///< [1] parts of a.b.c…; scenes need three. More: nonsense takes more of the stack

/// Where a key has more than `deepest_key` parts: line and column, from 1; none where all are fine. toml++ builds a table for
/// every dot of a key and takes them down recursively, so a key of 100 000 dots would overflow the stack: asked before parsing.
/// The text need not be right. Any thread; allocates nothing.
std::optional<std::pair<std::size_t, std::size_t>> too_deep_key(std::string_view text);

}  // namespace palpa::detail
