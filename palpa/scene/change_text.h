// Edits of single numbers in the text of a scene file.
#pragma once

#include <string>
#include <string_view>

namespace palpa {

/// Returns the text with one number of a table changed, or added if missing; comments, order and spaces are kept. The table
/// must be written as [TABLE], or is added at the end.
/// \param text   a valid scene file; throws SceneError if it is no TOML
/// \param table  a plain word: "coupling"
/// \param value  finite, in the key's own unit
std::string with_number(const std::string& text, std::string_view table, std::string_view key, double value);

}  // namespace palpa
