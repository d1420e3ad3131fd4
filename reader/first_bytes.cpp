#include "first_bytes.h"

#include <fcntl.h>
#include <zlib.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <new>

#include "palpa/base/input_file.h"
#include "palpa/base/load_error.h"
#include "palpa/file/protocol_packed.h"
#include "palpa/file/store_protocol.h"

namespace palpa::reader {

std::string first_bytes(const std::string& path, std::size_t most) {
  const detail::InputFile opened(path);
  if (!opened.is_open()) throw LoadError(opened.problem() + "; give a file that can be read");
  const int descriptor = ::fcntl(opened.descriptor(), F_DUPFD_CLOEXEC, 0);  // gzclose closes its descriptor
  const gzFile file = gzdopen(descriptor, "rb");                            // also reads uncompressed files
  if (file == nullptr) throw std::bad_alloc();
  std::string bytes(most, '\0');
  const int got = gzread(file, bytes.data(), static_cast<unsigned>(most));
  gzclose(file);
  if (got <= 0) throw LoadError("cannot be read: its gzip compression is damaged; get the file again");
  bytes.resize(static_cast<std::size_t>(got));
  return bytes;
}

namespace {

/// Latest start of the XML. More: memory for files that only begin like it; less: files with long comments are refused.
constexpr std::size_t most_prolog_bytes = std::size_t{1} << 26;

/// Tag of the first element in the text, as far as present; nullopt if the text may end before it.
std::optional<std::string> root_in(std::string_view text) {
  constexpr std::string_view blanks = " \t\r\n", byte_order_mark = "\xef\xbb\xbf";
  if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
  while (true) {
    text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
    if (text.empty()) return std::nullopt;
    if (text.front() != '<') return "";
    const std::string_view end = text.starts_with("<!--") ? "-->"
                                 : text.starts_with("<?") ? "?>"
                                 : text.starts_with("<!") ? (text.find('[') < text.find('>') ? "]>" : ">")
                                                          : "";
    if (end.empty()) break;
    const std::size_t at = text.find(end, 2);
    if (at == std::string_view::npos) return std::nullopt;
    text.remove_prefix(at + end.size());
  }
  text.remove_prefix(1);
  if (text.empty() || std::isalpha(static_cast<unsigned char>(text.front())) == 0) return "";
  char quote = '\0';
  for (std::size_t n = 0; n < text.size(); ++n) {
    if (quote == '\0' && text[n] == '>') return std::string(text.substr(0, n));
    if (quote == '\0' && (text[n] == '"' || text[n] == '\'')) {
      quote = text[n];
    } else if (text[n] == quote) {
      quote = '\0';
    }
  }
  return std::nullopt;
}

}  // namespace

std::string xml_root(const std::string& path) {
  const std::string start = first_bytes(path);
  if (const auto root = root_in(start)) return *root;
  if (start.size() < 1024) return {};
  return root_in(first_bytes(path, most_prolog_bytes)).value_or("");
}

std::string attribute_in(std::string_view tag, std::string_view name) {
  constexpr std::string_view blanks = " \t\r\n";
  std::size_t at = tag.find_first_of(blanks);
  while (at < tag.size()) {
    at = tag.find_first_not_of(blanks, at);
    const std::size_t equals = tag.find('=', std::min(at, tag.size()));
    if (equals == std::string_view::npos) return {};
    const std::size_t open = tag.find_first_not_of(blanks, equals + 1);
    if (open == std::string_view::npos || (tag[open] != '"' && tag[open] != '\'')) return {};
    const std::size_t close = tag.find(tag[open], open + 1);
    if (close == std::string_view::npos) return {};
    const std::string_view key = tag.substr(at, tag.find_first_of(" \t\r\n=", at) - at);
    if (key == name) return std::string(tag.substr(open + 1, close - open - 1));
    at = close + 1;
  }
  return {};
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

bool Beginning::is_store() const { return protocol::is_store(path_); }

bool Beginning::is_folder_with(const char* file) const {
  std::error_code none;
  return is_folder() && std::filesystem::is_regular_file(std::filesystem::path(path_) / file, none);
}

bool Beginning::info_says(std::string_view bytes) const {
  return first_bytes(path_ + "/info").find(bytes) != std::string::npos;
}

bool Beginning::is_named(std::initializer_list<std::string_view> ends) const noexcept {
  return std::ranges::any_of(ends, [&](std::string_view end) { return path_.ends_with(end); });
}

bool Beginning::has(std::size_t at, std::string_view bytes) const {
  return std::string_view(this->bytes()).substr(std::min(at, this->bytes().size())).starts_with(bytes);
}

bool Beginning::is_tiff() const {
  return has(0, {"II*\0", 4}) || has(0, {"MM\0*", 4}) || has(0, {"II+\0", 4}) || has(0, {"MM\0+", 4});
}

bool Beginning::has_behind_block(std::string_view mark) const {
  if (has(512, mark)) return true;
  const detail::InputFile file(path_);
  std::string there(mark.size(), '\0');
  for (std::uint64_t at = 512; at < file.bytes(); at *= 2) {
    if (file.read(at, there.data(), there.size()) == there.size() && there == mark) return true;
  }
  return false;
}

bool Beginning::has_xml_root(std::string_view name) const {
  if (!root_) root_ = xml_root(path_);
  return name.empty() ? !root_->empty() : first_word(*root_) == name;
}

bool Beginning::is_packed() const { return protocol::is_packed(path_); }

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
