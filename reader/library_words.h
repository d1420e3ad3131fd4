// Filter of library messages, which quote files and so may contain a patient's name.
#pragma once

#include <string>
#include <string_view>

namespace palpa::reader {

/// Sentence with only the known words of library messages; other words, and text in quotes, become "…". Allocates.
std::string known_words(std::string_view sentence);

}  // namespace palpa::reader
