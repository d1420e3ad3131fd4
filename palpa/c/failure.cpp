#include "palpa/c/failure.h"

#include <algorithm>
#include <array>
#include <initializer_list>

#include "palpa/base/utf8.h"

namespace palpa::c {

namespace {

// Longer: more memory of each thread; shorter: long lists of suggestions are cut. Without a constructor: no thread pays for it
// before its first failure.
constexpr std::size_t most_bytes = 2048;
thread_local std::array<char, most_bytes> sentence;

void write(std::initializer_list<std::string_view> parts) noexcept {
  std::size_t at = 0;
  for (std::string_view part : parts) {
    while (!part.empty()) {
      const std::size_t length = std::max<std::size_t>(1, detail::utf8_length(part));
      if (at + length >= most_bytes) break;
      // One line, for any text.
      const bool is_line_end = part.front() == '\n' || part.front() == '\r';
      if (is_line_end) {
        sentence[at++] = ' ';
      } else {
        for (std::size_t i = 0; i < length; ++i) sentence[at++] = part[i];
      }
      part.remove_prefix(length);
    }
  }
  sentence[at] = '\0';
}

}  // namespace

palpa_result fail(palpa_result kind, std::string_view place, std::string_view text) noexcept {
  write({place, ": ", text});
  return kind;
}

palpa_result fail(palpa_result kind, std::string_view text) noexcept {
  write({text});
  return kind;
}

void copy_utf8(std::string_view text, std::span<char> to) noexcept {
  std::size_t at = 0;
  for (std::size_t length; (length = detail::utf8_length(text)) > 0 && at + length < to.size();) {
    std::copy_n(text.data(), length, to.data() + at);
    at += length;
    text.remove_prefix(length);
  }
  to[at] = '\0';
}

const char* last_sentence() noexcept { return sentence.data(); }

}  // namespace palpa::c
