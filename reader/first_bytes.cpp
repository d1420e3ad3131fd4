#include "first_bytes.h"

#include <fcntl.h>
#include <zlib.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <new>

#include "palpa/core/load_error.h"
#include "palpa/disk/input_file.h"

namespace palpa::reader {

std::string first_bytes(const std::string& path) {
  char buffer[1024] = {};
  const detail::InputFile opened(path);
  if (!opened.is_open()) throw LoadError(opened.problem() + "; give a file that can be read");
  const int descriptor = ::fcntl(opened.descriptor(), F_DUPFD_CLOEXEC, 0);  // gzclose closes the one that it is given
  const gzFile file = gzdopen(descriptor, "rb");                            // reads files that are not compressed as they are
  if (file == nullptr) throw std::bad_alloc();
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

bool Beginning::is_folder() const { return std::filesystem::is_directory(path_); }

bool Beginning::is_named(std::initializer_list<std::string_view> ends) const noexcept {
  return std::ranges::any_of(ends, [&](std::string_view end) { return path_.ends_with(end); });
}

bool Beginning::has(std::size_t at, std::string_view bytes) const {
  return std::string_view(this->bytes()).substr(std::min(at, this->bytes().size())).starts_with(bytes);
}

bool Beginning::contains(std::string_view bytes) const { return this->bytes().find(bytes) != std::string::npos; }

bool Beginning::begins_with_word(std::initializer_list<std::string_view> words) const {
  const std::string first = first_word(bytes());
  return std::ranges::find(words, first) != words.end();
}

const std::string& Beginning::bytes() const {
  if (!bytes_) bytes_ = first_bytes(path_);
  return *bytes_;
}

}  // namespace palpa::reader
