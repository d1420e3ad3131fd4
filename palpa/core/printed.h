// Numbers in sentences and tables, as printf writes them. Files that a program reads back have rules of their own for numbers
// (shortest digits that give the same value, no locale): trace/csv.h, toml/wording.h.
#pragma once

#include <string>
#include <string_view>

namespace palpa::detail {

/// printf into a string of any length. Allocates; safe from any thread.
/// \return  empty where printf refuses the format
[[gnu::format(printf, 1, 2)]] std::string text(const char* format, ...);

/// The digits of a whole number with its thousands apart: "125 000". Allocates; safe from any thread.
/// \param digits   with a sign where there is one
/// \param between  what stands between the thousands; a page wants a space at which no line breaks
std::string grouped(std::string digits, std::string_view between = " ");

}  // namespace palpa::detail
