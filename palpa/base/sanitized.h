// Texts of others on terminals and pages: the one place that says which characters do more there than be read.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace palpa::detail {

/// Bytes of the character that a text begins with, where that one steers instead of being seen: control characters (C0, DEL,
/// C1), which a terminal obeys, the marks that turn the order of letters around, and Unicode's own line ends. 0 where it does
/// not, or is no UTF-8. Allocates nothing; any thread.
std::size_t steering_length(std::string_view text) noexcept;

/// A text as it may stand on a terminal and within JSON: each such character as \uXXXX, each byte that is no UTF-8 as U+FFFD.
/// The same again where it is cleaned twice. Allocates; any thread.
/// \param lines  line ends and tabs stay
std::string shown(std::string_view text, bool lines = false);

/// A text of at most so many bytes, its middle left out where it is longer: what stands before and behind is whole characters.
std::string shortened(std::string_view text, std::size_t most_bytes);

}  // namespace palpa::detail
