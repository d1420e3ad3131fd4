#include "source_sizes.h"

#include <algorithm>

#include "source_tokens.h"

namespace palpa::architecture {
namespace {

/// The brace that closes the one at `open`, or the last token.
std::size_t closing(const std::vector<Token>& tokens, std::size_t open) {
  int depth = 0;
  for (std::size_t i = open; i < tokens.size(); ++i) {
    depth += (tokens[i].text == "{") - (tokens[i].text == "}");
    if (depth == 0) return i;
  }
  return tokens.size() - 1;
}

bool is_any_of(const std::string& token, std::initializer_list<const char*> words) {
  return std::ranges::find(words, token) != words.end();
}

}  // namespace

std::vector<FunctionLength> functions_of(std::string_view source) {
  const std::vector<Token> tokens = lex(source).tokens;
  std::vector<FunctionLength> functions;
  std::size_t first = 0;  // of the statement
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    const std::string& t = tokens[i].text;
    if (is_any_of(t, {";", "}"}) ||
        (t == ":" && i > first && is_any_of(tokens[i - 1].text, {"public", "private", "protected"})))
      first = i + 1;
    if (t != "{") continue;
    const auto begin = tokens.begin() + static_cast<std::ptrdiff_t>(first),
               end = tokens.begin() + static_cast<std::ptrdiff_t>(i);
    const auto bracket = std::find_if(begin, end, [](const Token& token) { return token.text == "("; });
    const bool holds_more = std::any_of(begin, bracket, [](const Token& k) {
      return is_any_of(k.text, {"namespace", "class", "struct", "union"});
    });
    const bool is_value = std::any_of(begin, bracket, [](const Token& k) { return is_any_of(k.text, {"=", "enum"}); });
    if (holds_more && bracket == end) {
      first = i + 1;
      continue;
    }
    const std::size_t close = closing(tokens, i);
    if (bracket != end && bracket != begin && !is_value) {
      functions.push_back({std::prev(bracket)->text, tokens[first].line, tokens[close].line - tokens[first].line + 1});
    }
    i = close;
    first = close + 1;
  }
  return functions;
}

}  // namespace palpa::architecture
