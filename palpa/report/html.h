// The little of HTML that a report needs. Every text goes through `escaped`.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "palpa/base/escaped.h"
#include "palpa/base/printed.h"

namespace palpa::detail {

/// A table. The cells are texts, escaped here; the first `left` columns are names, the others numbers.
std::string table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows, std::size_t left);

/// Bytes in the letters of base64.
std::string base64(std::string_view bytes);

/// Bytes as a data address of an image.
std::string png_address(std::string_view png);

/// A whole number with its thousands apart by a narrow space at which no line breaks: "125 000".
inline std::string grouped(long long number) { return grouped(std::to_string(number), "\u202f"); }

}  // namespace palpa::detail
