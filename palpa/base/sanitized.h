// Sanitizing of untrusted text for terminals and pages: the only definition of control characters.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace palpa::detail {

/// Bytes of a leading control character: C0, DEL, C1, which a terminal obeys, bidirectional marks, and Unicode's own line ends.
/// 0 if there is none, or the text begins with invalid UTF-8. Allocates nothing; any thread.
std::size_t steering_length(std::string_view text) noexcept;

/// Text for a terminal and within JSON: each control character as \uXXXX, each byte of invalid UTF-8 as U+FFFD. Idempotent.
/// Allocates; any thread.
/// \param lines  keeps line ends and tabs
std::string sanitized(std::string_view text, bool lines = false);

/// Text of at most `most_bytes`: a longer one loses its middle, between whole characters.
std::string shortened(std::string_view text, std::size_t most_bytes);

}  // namespace palpa::detail
