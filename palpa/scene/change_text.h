// Edits of single numbers in a scene file's text.
#pragma once

#include <string>
#include <string_view>

namespace palpa {

/// Changes a number of a table, or adds it if missing; keeps comments, order and spaces. The table must be written as [TABLE],
/// or is added at the end.
/// \param text   a valid scene file; throws SceneError if it is no TOML
/// \param table  a plain word: "coupling"
/// \param value  finite, in the key's own unit
std::string with_number(const std::string& text, std::string_view table, std::string_view key, double value);

}  // namespace palpa
