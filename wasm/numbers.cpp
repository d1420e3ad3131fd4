// Reading of floating-point numbers, which libc++ 19 leaves out: by the C library, whose result is the nearest number, in the
// locale "C", the only one of WASI.
#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <string>
#include <string_view>

namespace std {
namespace {

/// Length of the decimal number that `text` begins with, in the grammar of from_chars; 0: none.
size_t length_of_number(string_view text, chars_format format) {
  const auto is_digit = [&](size_t at) { return at < text.size() && text[at] >= '0' && text[at] <= '9'; };
  size_t at = 0;
  if (at < text.size() && text[at] == '-') ++at;
  for (const string_view word : {"infinity", "inf", "nan"}) {
    const string_view here = text.substr(at, word.size());
    if (ranges::equal(here, word, {}, [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; }))
      return at + word.size();
  }
  size_t digits = 0;
  while (is_digit(at)) ++at, ++digits;
  if (at < text.size() && text[at] == '.') {
    ++at;
    while (is_digit(at)) ++at, ++digits;
  }
  if (digits == 0) return 0;
  if (format != chars_format::fixed && at < text.size() && (text[at] == 'e' || text[at] == 'E')) {
    const size_t sign = at + 1 < text.size() && (text[at + 1] == '-' || text[at + 1] == '+') ? 1 : 0;
    if (is_digit(at + 1 + sign)) {
      at += 1 + sign;
      while (is_digit(at)) ++at;
    }
  }
  return at;
}

}  // namespace

from_chars_result from_chars(const char* first, const char* last, double& value, chars_format format) {
  const size_t length = length_of_number({first, static_cast<size_t>(last - first)}, format);
  if (length == 0) return {first, errc::invalid_argument};
  const string text(first, length);
  errno = 0;
  const double read = std::strtod(text.c_str(), nullptr);
  // Numbers below the normal ones are numbers; those that are too small for any, or too large, are none.
  const bool is_out = errno == ERANGE && (read == 0.0 || read == HUGE_VAL || read == -HUGE_VAL);
  if (is_out) return {first + length, errc::result_out_of_range};
  value = read;
  return {first + length, errc{}};
}

}  // namespace std
