// HTML helpers of reports. Every text passes through `escaped`.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "palpa/base/escaped.h"
#include "palpa/base/printed.h"

namespace palpa::detail {

/// Table of texts, escaped here; the first `left` columns are names, the others numbers.
std::string table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows, std::size_t left);

/// Base64 encoding.
std::string base64(std::string_view bytes);

/// Data URL of a PNG image.
std::string png_address(std::string_view png);

/// Integer with thousands separated by narrow no-break spaces: "125 000".
inline std::string grouped(long long number) { return grouped(std::to_string(number), "\u202f"); }

}  // namespace palpa::detail
