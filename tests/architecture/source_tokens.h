// C++ as tokens, for the checks that read sources.
#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace palpa::architecture {

struct Token {
  std::string text;
  int line = 0;
};

/// A source as tokens, and its comments by line. Preprocessor lines, texts and characters are left out.
struct Lexed {
  std::vector<Token> tokens;
  std::map<int, std::string> comments;  ///< by line
  std::set<int> lines_with_code;
};
Lexed lex(std::string_view source);

/// A name or a word of the language.
bool is_word(const std::string& token);

}  // namespace palpa::architecture
