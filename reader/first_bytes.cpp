#include "first_bytes.h"

#include <zlib.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>

#include "palpa/core/load_error.h"

namespace palpa::reader {

std::string first_bytes(const std::string& path) {
  char buffer[1024] = {};
  const gzFile file = gzopen(path.c_str(), "rb");  // reads files that are not compressed as they are
  if (file == nullptr) throw LoadError(std::string("cannot be opened: ") + std::strerror(errno) + "; check its permissions");
  const int got = gzread(file, buffer, sizeof buffer);
  gzclose(file);
  if (got <= 0) throw LoadError("cannot be read: its gzip compression is damaged; get the file again");
  return {buffer, static_cast<std::size_t>(got)};
}

std::string first_word(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t\"'"), text.size()));
  std::size_t end = 0;
  while (end < text.size() && (std::isalnum(static_cast<unsigned char>(text[end])) != 0 || text[end] == '_')) ++end;
  return std::string(text.substr(0, end));
}

std::string word_after(std::string_view text, std::string_view key) {
  const std::size_t at = text.find(key);
  return at == std::string_view::npos ? std::string() : first_word(text.substr(at + key.size()));
}

}  // namespace palpa::reader
