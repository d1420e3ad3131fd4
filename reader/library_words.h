// What libraries say of a file quotes it, and what it says may be a patient's name.
#pragma once

#include <string>
#include <string_view>

namespace palpa::reader {

/// The sentence with only such words as are on a list of ours, of what libraries say of files; others, and what stands between
/// quotes, become "…". Allocates.
std::string known_words(std::string_view sentence);

}  // namespace palpa::reader
