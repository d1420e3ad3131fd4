#include "palpa/trace/csv.h"

#include "palpa/base/load_error.h"

namespace palpa::detail {

namespace {
constexpr std::size_t block_bytes = std::size_t{1} << 16;         // of a read. Less: more system calls; more: memory
constexpr std::size_t longest_line_bytes = std::size_t{1} << 20;  // a longer line is refused, or a wrong file fills memory
}  // namespace

void put_text(std::string& line, std::string_view text) {
  const bool quoted = text.find_first_of(",\"") != std::string_view::npos;
  if (quoted) line += '"';
  for (const char c : text) {
    if (c == '"') line += '"';
    line += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  if (quoted) line += '"';
}

void split(std::string_view line, std::vector<std::string_view>& cells) {
  cells.clear();
  bool quoted = false;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') quoted = !quoted;
    if (line[i] == ',' && !quoted) {
      cells.push_back(line.substr(begin, i - begin));
      begin = i + 1;
    }
  }
  cells.push_back(line.substr(begin));
}

LineFile::LineFile(std::filesystem::path path) : file_(std::move(path)) {
  if (exists()) file_.expect_open("a trace holds ordinary files");
}

bool LineFile::next(std::string_view& line) {
  std::size_t searched = begin_;
  while (file_.is_open()) {
    const std::size_t end = buffer_.find('\n', searched);
    if (end != std::string::npos) {
      line = std::string_view(buffer_).substr(begin_, end - begin_);
      if (line.ends_with('\r')) line.remove_suffix(1);
      begin_ = end + 1;
      ++number_;
      return true;
    }
    buffer_.erase(0, begin_);
    begin_ = 0;
    searched = buffer_.size();
    if (buffer_.size() > longest_line_bytes) {
      throw LoadError(file_.path().string() + ":" + std::to_string(number_ + 1) +
                      ": the line is longer than 1 MB; a row of a trace is short");
    }
    buffer_.resize(searched + block_bytes);
    const std::size_t got = file_.read(read_, buffer_.data() + searched, block_bytes);
    buffer_.resize(searched + got);
    read_ += got;
    if (got == 0) return false;
  }
  return false;
}

std::string LineFile::place() const { return file_.path().string() + ":" + std::to_string(number_); }

}  // namespace palpa::detail
