#include "palpa/base/sanitized.h"

#include "palpa/base/utf8.h"

namespace palpa::detail {
namespace {

/// Code point of a valid UTF-8 sequence.
char32_t code_point(std::string_view sequence) noexcept {
  const auto first = static_cast<unsigned char>(sequence[0]);
  if (sequence.size() == 1) return first;
  char32_t point = first & (0x7fU >> sequence.size());
  for (const char c : sequence.substr(1)) point = point << 6 | (static_cast<unsigned char>(c) & 0x3fU);
  return point;
}

bool steers(char32_t c) noexcept {
  const auto within = [c](char32_t first, char32_t last) { return first <= c && c <= last; };
  const bool control = c < 0x20 || within(0x7f, 0x9f);
  const bool order = c == 0x061c || within(0x200e, 0x200f) || within(0x202a, 0x202e) || within(0x2066, 0x2069);
  return control || order || within(0x2028, 0x2029);
}

}  // namespace

std::size_t steering_length(std::string_view text) noexcept {
  const std::size_t length = utf8_length(text);
  return length > 0 && length < 4 && steers(code_point(text.substr(0, length))) ? length : 0;
}

std::string sanitized(std::string_view text, bool lines) {
  constexpr std::string_view digits = "0123456789ABCDEF";
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    if (length == 0) {
      out += "\uFFFD";
      text.remove_prefix(1);
      continue;
    }
    const std::string_view character = text.substr(0, length);
    if (steering_length(character) > 0 && !(lines && (character == "\n" || character == "\t"))) {
      const char32_t c = code_point(character);
      out += "\\u";
      for (int shift = 12; shift >= 0; shift -= 4) out += digits[c >> shift & 15];
    } else {
      out += character;
    }
    text.remove_prefix(length);
  }
  return out;
}

std::string shortened(std::string_view text, std::size_t most_bytes) {
  constexpr std::string_view gap = "\u2026";
  if (text.size() <= most_bytes) return std::string(text);
  const auto continues = [&](std::size_t at) { return (static_cast<unsigned char>(text[at]) & 0xc0) == 0x80; };
  const std::size_t each = (most_bytes - gap.size()) / 2;
  std::size_t end = each, begin = text.size() - each;
  while (end > 0 && continues(end)) --end;
  while (begin < text.size() && continues(begin)) ++begin;
  return std::string(text.substr(0, end)) + std::string(gap) + std::string(text.substr(begin));
}

}  // namespace palpa::detail
