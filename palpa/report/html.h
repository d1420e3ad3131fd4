// The little of HTML that a report needs. Every text goes through `escaped`.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpa::detail {

/// A text as it may stand in HTML, between tags and in attributes; what is no UTF-8 becomes '?', control
/// characters but line ends and tabs become spaces.
std::string escaped(std::string_view text);

/// A table. The cells are texts, escaped here; the first `left` columns are names, the others numbers.
std::string table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows, std::size_t left);

/// Bytes in the letters of base64.
std::string base64(std::string_view bytes);

/// Bytes as a data address of an image.
std::string png_address(std::string_view png);

/// printf into a string.
[[gnu::format(printf, 1, 2)]] std::string text(const char* format, ...);

/// A whole number with its thousands apart: "125 000".
std::string grouped(long long number);

}  // namespace palpa::detail
