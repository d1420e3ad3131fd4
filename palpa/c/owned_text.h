// Texts that a function for C returns with ownership.
#pragma once

#include <cstdlib>
#include <cstring>
#include <new>
#include <string>

namespace palpa::c {

/// Copy that palpa_free frees. Throws std::bad_alloc.
inline char* owned_text(const std::string& text) {
  char* const copy = static_cast<char*>(std::malloc(text.size() + 1));
  if (!copy) throw std::bad_alloc();
  std::memcpy(copy, text.c_str(), text.size() + 1);
  return copy;
}

}  // namespace palpa::c
