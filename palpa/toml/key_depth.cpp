#include "palpa/toml/key_depth.h"

#include <algorithm>
#include <string>

namespace palpa::detail {

namespace {

/// Looks through a text for keys, past its comments and strings.
class KeyDepth {
 public:
  explicit KeyDepth(std::string_view text) : text_(text) {}

  /// Where a key is too deep: line and column; nothing when all are fine.
  std::optional<std::pair<std::size_t, std::size_t>> too_deep() {
    int dots = 0;
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '#') {
        skip_to('\n');
      } else if (c == '"' || c == '\'') {
        skip_string(c);
      } else {
        if (c == '.' && ++dots > deepest_key) return position();
        if (c == '=' || c == ',' || c == '\n' || c == '[' || c == '{') dots = 0;
        ++at_;
      }
    }
    return std::nullopt;
  }

 private:
  void skip_to(char end) { at_ = std::min(text_.find(end, at_), text_.size()); }
  /// Three quotes end a string of several lines; up to two more right behind its text belong to it.
  void skip_string(char quote) {
    const bool long_string = text_.substr(at_, 3) == std::string(3, quote);
    const std::size_t width = long_string ? 3 : 1, most = long_string ? 5 : 1;
    for (at_ += width; at_ < text_.size(); ++at_) {
      if (quote == '"' && text_[at_] == '\\') {
        ++at_;
      } else if (text_[at_] == '\n' && !long_string) {
        return;  // not closed: the parser will say so
      } else if (text_[at_] == quote) {
        const std::size_t quotes = std::min(text_.find_first_not_of(quote, at_), text_.size()) - at_;
        if (quotes >= width) {
          at_ += std::min(quotes, most);
          return;
        }
        at_ += quotes - 1;
      }
    }
  }
  std::pair<std::size_t, std::size_t> position() const {
    const std::string_view before = text_.substr(0, at_);
    const std::size_t line_start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
    return {static_cast<std::size_t>(std::ranges::count(before, '\n')) + 1, at_ - line_start + 1};
  }
  std::string_view text_;
  std::size_t at_ = 0;
};

}  // namespace

std::optional<std::pair<std::size_t, std::size_t>> too_deep_key(std::string_view text) { return KeyDepth(text).too_deep(); }

}  // namespace palpa::detail
