// Number formatting for sentences and tables, by printf in the C locale, independent of the program's locale. Files that a
// program reads back use shortest digits of equal value instead: trace/csv.h, base/wording.h. A test keeps printf and streams
// out of all other files.
#pragma once

#include <string>
#include <string_view>

namespace palpa::detail {

/// Sets the C locale for this thread's C library during its lifetime, overriding setlocale and uselocale, but not C++ streams.
/// Allocates nothing; one thread.
class CLocale {
 public:
  CLocale() noexcept;
  ~CLocale();
  CLocale(const CLocale&) = delete;
  CLocale& operator=(const CLocale&) = delete;

 private:
  void* before_;
};

/// printf into a string of any length, in the C locale. Allocates; any thread.
/// \return  empty if printf refuses the format
[[gnu::format(printf, 1, 2)]] std::string text(const char* format, ...);

/// Groups the digits of a whole number by thousands: "125 000". Allocates; any thread.
/// \param digits   with an optional sign
/// \param between  separator; for a page a no-break space
std::string grouped(std::string digits, std::string_view between = " ");

}  // namespace palpa::detail
