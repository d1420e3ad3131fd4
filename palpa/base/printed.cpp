#include "palpa/base/printed.h"

#include <clocale>
#include <cstdarg>
#include <cstddef>
#include <cstdio>

namespace palpa::detail {

CLocale::CLocale() noexcept {
  static const locale_t c = ::newlocale(LC_ALL_MASK, "C", nullptr);  // a static object of the C library: cannot fail
  before_ = ::uselocale(c);
}

CLocale::~CLocale() { ::uselocale(static_cast<locale_t>(before_)); }

std::string text(const char* format, ...) {
  const CLocale c_locale;
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
