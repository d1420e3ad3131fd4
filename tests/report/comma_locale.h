// A private locale with a decimal comma and a thousands point.
#pragma once

#include <gtest/gtest.h>
#include <locale.h>
#include <stdlib.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <locale>
#include <string>

namespace palpa {

/// std::locale's format of numbers.
class CommaPunctuation : public std::numpunct<char> {
 protected:
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

/// Writes the locale "comma" for the C library into `folder`, which LOCPATH then names (glibc's locale/localeinfo.h).
inline void make_comma_locale(const std::filesystem::path& folder) {
  constexpr std::uint32_t lc_numeric = 1, entries = 6;
  std::uint32_t offsets[entries], number = 0;
  std::string data;
  const std::uint32_t head = sizeof(std::uint32_t) * (2 + entries);
  const auto next = [&] { offsets[number++] = head + static_cast<std::uint32_t>(data.size()); };
  const auto put = [&](std::uint32_t word) { data.append(reinterpret_cast<const char*>(&word), sizeof word); };
  for (const char* text : {",", ".", "\3"}) next(), data.append(text, 2);
  while ((head + data.size()) % sizeof(std::uint32_t) != 0) data += '\0';
  for (const char wide : {',', '.'}) next(), put(static_cast<unsigned char>(wide));
  next(), data.append("UTF-8", 6);
  std::filesystem::create_directories(folder / "comma");
  std::ofstream file(folder / "comma/LC_NUMERIC", std::ios::binary);
  const std::uint32_t begin[] = {0x20031115U ^ lc_numeric, entries};
  file.write(reinterpret_cast<const char*>(begin), sizeof begin).write(reinterpret_cast<const char*>(offsets), sizeof offsets);
  file << data;
}

enum class LocaleOf { nothing, set_locale, use_locale, streams };

/// While it lives, the program's numbers have commas, by one of the ways to set a locale.
class CommaLocale {
 public:
  /// \param folder  gets the locale
  CommaLocale(LocaleOf what, const std::filesystem::path& folder) {
    make_comma_locale(folder);
    ::setenv("LOCPATH", folder.c_str(), 1);
    if (what == LocaleOf::set_locale) {
      EXPECT_NE(::setlocale(LC_NUMERIC, "comma"), nullptr);
    } else if (what == LocaleOf::use_locale) {
      comma_ = ::newlocale(LC_NUMERIC_MASK, "comma", nullptr);
      EXPECT_NE(comma_, nullptr);
      ::uselocale(comma_);
    } else if (what == LocaleOf::streams) {
      std::locale::global(std::locale(std::locale::classic(), new CommaPunctuation));
    }
    char number[16];
    std::snprintf(number, sizeof number, "%.1f", 1.5);
    if (what == LocaleOf::set_locale || what == LocaleOf::use_locale) {
      EXPECT_STREQ(number, "1,5");
    }
  }
  ~CommaLocale() {
    ::setlocale(LC_NUMERIC, "C");
    std::locale::global(std::locale::classic());
    ::uselocale(LC_GLOBAL_LOCALE);
    if (comma_) ::freelocale(comma_);
    ::unsetenv("LOCPATH");
  }
  CommaLocale(const CommaLocale&) = delete;
  CommaLocale& operator=(const CommaLocale&) = delete;

 private:
  locale_t comma_ = nullptr;
};

}  // namespace palpa
