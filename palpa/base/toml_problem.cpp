#include "palpa/base/toml_problem.h"

#include <algorithm>
#include <cstdint>

#include "palpa/base/limits.h"

namespace palpa::detail {

namespace {

/// Splits a text into TOML's tokens, with ends equal to toml++'s up to the first error; stops there.
class Tokenizer {
 public:
  enum class Token : std::uint8_t {
    word,       ///< string, or a character of a key, a number or white space
    separator,  ///< ','
    dot,
    equals,
    open,   ///< '[' or '{'
    close,  ///< ']' or '}'
    line_end,
    end,
  };

  explicit Tokenizer(std::string_view text) : text_(text) {}

  Token next() noexcept {
    begin_ = end_;
    if (end_ == text_.size()) return Token::end;
    switch (const char c = text_[end_]) {
      case '#': end_ = std::min(text_.find('\n', end_), text_.size()); return Token::word;
      case '"':
      case '\'': skip_string(c); return Token::word;
      case '\n': ++end_; return Token::line_end;
      case ',': ++end_; return Token::separator;
      case '.': ++end_; return Token::dot;
      case '=': ++end_; return Token::equals;
      case '[':
      case '{': ++end_; return Token::open;
      case ']':
      case '}': ++end_; return Token::close;
      default: ++end_; return Token::word;
    }
  }

  /// Whether the token is white space.
  bool is_space() const noexcept { return text_[begin_] == ' ' || text_[begin_] == '\t' || text_[begin_] == '\r'; }
  TomlProblem problem(const Limit& limit, std::string_view begin) const {
    const std::string_view before = text_.substr(0, begin_);
    const std::size_t line_start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
    return {static_cast<std::size_t>(std::ranges::count(before, '\n')) + 1, begin_ - line_start + 1,
            std::string(begin) + more_than(limit)};
  }

 private:
  std::size_t quotes_at(std::size_t at, char quote) const noexcept {
    return std::min(text_.find_first_not_of(quote, at), text_.size()) - at;
  }
  /// A single-line string ends with one quote. A multi-line string ends with three, after which its text may end with two more:
  /// four quotes end it, too.
  void skip_string(char quote) noexcept {
    const bool has_lines = quotes_at(end_, quote) >= 3;
    const std::size_t width = has_lines ? 3 : 1, most = has_lines ? 5 : 1;
    for (end_ += width; end_ < text_.size(); ++end_) {
      const char c = text_[end_];
      if (c == '\n' && !has_lines) return;  // not closed: an error
      if (c == '\\' && quote == '"') {
        if (++end_ == text_.size()) return;
      } else if (c == quote) {
        const std::size_t quotes = quotes_at(end_, quote);
        if (quotes >= width) {
          end_ += std::min(quotes, most);
          return;
        }
        end_ += quotes - 1;
      }
    }
  }

  std::string_view text_;
  std::size_t begin_ = 0, end_ = 0;  // of the token
};

}  // namespace

std::optional<TomlProblem> problem_with_toml(std::string_view text) {
  using Token = Tokenizer::Token;
  Tokenizer tokens(text);
  std::size_t dots = 0, headings = 0, nested = 0;
  bool is_line_begin = true, is_heading = false;
  for (Token token = tokens.next(); token != Token::end; token = tokens.next()) {
    if (token == Token::word && tokens.is_space()) continue;
    const bool ends_part = token == Token::dot || token == Token::equals || token == Token::close;
    if (ends_part && limit::key_parts.is_passed_by(static_cast<double>(dots + 1)))
      return tokens.problem(limit::key_parts, "a key of ");
    if (token == Token::equals && dots > 0) ++headings;
    if (token == Token::open) {
      if (is_line_begin && nested == 0) is_heading = true, ++headings;
      if (!is_heading) ++nested;
    }
    if (token == Token::close && !is_heading && nested > 0) --nested;
    if (limit::headings.is_passed_by(static_cast<double>(headings))) return tokens.problem(limit::headings, "");
    if (token == Token::line_end) is_heading = false;
    if (token == Token::dot) {
      ++dots;
    } else if (token != Token::word) {
      dots = 0;
    }
    is_line_begin = token == Token::line_end;
  }
  return std::nullopt;
}

}  // namespace palpa::detail
