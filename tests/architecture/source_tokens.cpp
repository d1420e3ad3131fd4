#include "source_tokens.h"

#include <algorithm>
#include <cctype>

namespace palpa::architecture {

bool is_word(const std::string& text) { return std::isalpha(static_cast<unsigned char>(text[0])) || text[0] == '_'; }

Lexed lex(std::string_view s) {
  Lexed out;
  int line = 1;
  const auto code = [&](std::string text) {
    out.lines_with_code.insert(line);
    out.tokens.push_back({std::move(text), line});
  };
  for (std::size_t i = 0; i < s.size();) {
    const char c = s[i];
    if (c == '\n') {
      ++line, ++i;
    } else if (s.substr(i, 2) == "//") {
      const auto end = std::min(s.find('\n', i), s.size());
      out.comments[line] += std::string(s.substr(i, end - i));
      i = end;
    } else if (s.substr(i, 2) == "/*") {
      for (const auto end = std::min(s.find("*/", i), s.size() - 2) + 2; i < end; ++i) {
        if (s[i] == '\n')
          ++line;
        else
          out.comments[line] += s[i];
      }
    } else if (c == '#') {
      while (i < s.size() && s[i] != '\n') {
        if (s[i] == '\\' && i + 1 < s.size() && s[i + 1] == '\n') ++line, ++i;
        ++i;
      }
    } else if (c == '"' || c == '\'') {
      for (++i; i < s.size() && s[i] != c; ++i) i += s[i] == '\\';
      ++i;
      code("\"\"");
    } else if (std::isalnum(static_cast<unsigned char>(c)) || c == '_') {
      const bool number = std::isdigit(static_cast<unsigned char>(c));
      std::size_t end = i;
      while (end < s.size() && (std::isalnum(static_cast<unsigned char>(s[end])) || s[end] == '_' ||
                                (number && (s[end] == '.' || s[end] == '\''))))
        ++end;
      code(std::string(s.substr(i, end - i)));
      i = end;
    } else if (s.substr(i, 2) == "::") {
      code("::"), i += 2;
    } else {
      if (!std::isspace(static_cast<unsigned char>(c)) && static_cast<unsigned char>(c) < 128) code(std::string(1, c));
      ++i;
    }
  }
  return out;
}

}  // namespace palpa::architecture
