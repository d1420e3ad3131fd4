#include "palpa/core/printed.h"

#include <cstdarg>
#include <cstddef>
#include <cstdio>

namespace palpa::detail {

std::string text(const char* format, ...) {
  std::va_list arguments, again;
  va_start(arguments, format);
  va_copy(again, arguments);
  const int length = std::vsnprintf(nullptr, 0, format, arguments);
  std::string words(length > 0 ? static_cast<std::size_t>(length) : 0, '\0');
  if (length > 0) std::vsnprintf(words.data(), words.size() + 1, format, again);
  va_end(again);
  va_end(arguments);
  return words;
}

std::string grouped(std::string digits, std::string_view between) {
  for (auto i = static_cast<std::ptrdiff_t>(digits.size()) - 3; i > 0 && digits[static_cast<std::size_t>(i) - 1] != '-';
       i -= 3) {
    digits.insert(static_cast<std::size_t>(i), between);
  }
  return digits;
}

}  // namespace palpa::detail
