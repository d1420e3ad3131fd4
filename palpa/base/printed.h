// Numbers in sentences and tables, as printf writes them in the C locale: no number that leaves the process depends on the
// locale of the program that uses the library. Files that a program reads back have rules of their own for numbers (shortest
// digits that give the same value): trace/csv.h, toml/wording.h. A test keeps printf and streams out of all other files.
#pragma once

#include <string>
#include <string_view>

namespace palpa::detail {

/// While it lives, this thread's C library reads and writes numbers as in the C locale, whatever the program has set with
/// setlocale or uselocale. What C++ streams do is not changed. Allocates nothing; one thread.
class CLocale {
 public:
  CLocale() noexcept;
  ~CLocale();
  CLocale(const CLocale&) = delete;
  CLocale& operator=(const CLocale&) = delete;

 private:
  void* before_;
};

/// printf into a string of any length, in the C locale. Allocates; safe from any thread.
/// \return  empty where printf refuses the format
[[gnu::format(printf, 1, 2)]] std::string text(const char* format, ...);

/// The digits of a whole number with its thousands apart: "125 000". Allocates; safe from any thread.
/// \param digits   with a sign where there is one
/// \param between  what stands between the thousands; a page wants a space at which no line breaks
std::string grouped(std::string digits, std::string_view between = " ");

}  // namespace palpa::detail
