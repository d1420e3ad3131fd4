// Numbers as bench_felt prints them.
#pragma once

#include <cstdarg>
#include <cstdio>
#include <string>

namespace palpa::bench {

/// As printf.
[[gnu::format(printf, 1, 2)]] inline std::string text(const char* format, ...) {
  char buffer[256];
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  return buffer;
}

}  // namespace palpa::bench
