#include "palpa/base/escaped.h"

#include <algorithm>
#include <cstddef>

#include "palpa/base/sanitized.h"
#include "palpa/base/utf8.h"

namespace palpa::detail {

std::string escaped(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const char c = text.front();
    if (length == 0) {
      out += '?';
    } else if (c != '\n' && c != '\t' && steering_length(text) > 0) {
      out += ' ';
    } else if (length > 1) {
      out += text.substr(0, length);
    } else {
      switch (c) {
        case '<': out += "&lt;"; break;
        case '>': out += "&gt;"; break;
        case '&': out += "&amp;"; break;
        case '"': out += "&quot;"; break;
        default: out += c;
      }
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out;
}

}  // namespace palpa::detail
