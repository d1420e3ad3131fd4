// Numbers of a scene file changed, and nothing else of its text.
#pragma once

#include <string>
#include <string_view>

namespace palpa {

/// The text with one number of a table changed, or added to it where it is not there: comments, order and spaces stay. The
/// table is [TABLE], written so, or is added at the end.
/// \param text   a scene file that loads; throws SceneError where it is no TOML
/// \param table  a plain word: "coupling"
/// \param value  finite, in the key's own unit
std::string with_number(const std::string& text, std::string_view table, std::string_view key, double value);

}  // namespace palpa
