#include "palpa/report/path_names.h"

#include <algorithm>
#include <cctype>

namespace palpa::detail {
namespace {

namespace fs = std::filesystem;

bool within_name(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || std::string_view("_-./~").find(c) != std::string_view::npos ||
         static_cast<unsigned char>(c) >= 0x80;
}
bool ends_path(char c) { return std::string_view(" \t\n\r\"'`,;()[]{}<>|=").find(c) != std::string_view::npos; }

/// End of a path's folders: behind the last slash before an array's name.
std::size_t name_at(std::string_view path) {
  const std::size_t array = path.find(":/");
  std::string_view file = path.substr(0, array);
  while (file.size() > 1 && file.ends_with('/')) file.remove_suffix(1);
  const std::size_t slash = file.rfind('/');
  return slash == std::string_view::npos || slash + 1 == file.size() ? 0 : slash + 1;
}

/// True if the text begins with a path: absolute with at least two components, or with ~/, ./ or ../.
bool begins_path(std::string_view piece) {
  if (piece.starts_with("~/") || piece.starts_with("./") || piece.starts_with("../")) return true;
  return piece.size() > 1 && piece[0] == '/' && piece[1] != '/' && piece.find('/', 1) != std::string_view::npos;
}

/// Replaces `folder/` by nothing and `folder` alone by its base name, unless it is part of a longer name.
std::string without(std::string text, const std::string& folder) {
  for (std::size_t at = text.find(folder); at != std::string::npos; at = text.find(folder, at)) {
    const std::size_t end = at + folder.size();
    const bool whole = (at == 0 || !within_name(text[at - 1])) &&
                       (end == text.size() || text[end] == '/' || !within_name(text[end]) || text[end] == '.');
    if (!whole) {
      ++at;
    } else if (end + 1 < text.size() && text[end] == '/' && !ends_path(text[end + 1])) {
      text.erase(at, folder.size() + 1);
    } else {
      text.erase(at, folder.size() - folder.substr(name_at(folder)).size());
      ++at;
    }
  }
  return text;
}

}  // namespace

PathNames::PathNames(const Recorded& recorded, const fs::path& trace, bool full) : full_(full) {
  if (full) return;
  const auto know = [&](const fs::path& path) {
    std::error_code none;
    for (const fs::path& one : {path, fs::absolute(path, none), fs::absolute(path, none).lexically_normal()}) {
      const std::string folder = one.parent_path().string();
      if (folder.size() > 1 && folder != ".." && folder.find('/') != std::string::npos) folders_.push_back(folder);
    }
    if (path.has_filename()) files_.push_back(path.filename().string());
  };
  for (const SourceFile& file : recorded.header.data_files) {
    know(file.path);
    know(fs::path(file.path).parent_path());  // the folder of a series of slices counts as a file
  }
  for (const std::string& plugin : recorded.header.plugins) know(plugin);
  for (const std::string& argument : recorded.header.arguments) {
    if (argument.find('/') != std::string::npos && argument.find('=') == std::string::npos) know(argument);
  }
  know(trace);
  know(trace / "trace.toml");
  std::sort(folders_.begin(), folders_.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
}

bool PathNames::is_known_file(std::string_view name) const {
  return std::find(files_.begin(), files_.end(), name) != files_.end();
}

std::string PathNames::of_path(std::string_view path) const { return std::string(full_ ? path : path.substr(name_at(path))); }

std::string PathNames::of_argument(std::string_view argument) const {
  if (full_ || argument.find('/') == std::string_view::npos) return std::string(argument);
  if (argument.find_first_of("\"'{[") != std::string_view::npos) return in_text(argument);
  std::string out;
  while (true) {
    const std::size_t value = argument.find('=') + 1;  // npos + 1: no value
    if (value == 0) return out + of_path(argument);
    // A path may contain commas: a value ends where another key begins.
    std::size_t end = argument.find('=', value);
    if (end != std::string_view::npos) end = argument.rfind(',', end);
    if (end == std::string_view::npos || end < value) end = argument.size();
    out += of_path(argument.substr(0, value));
    out += of_path(argument.substr(value, end - value));
    if (end == argument.size()) return out;
    out += ',';
    argument.remove_prefix(end + 1);
  }
}

std::string PathNames::of_value(std::string_view value) const {
  // Quoted, as in a scene, so that blanks and commas belong to the path.
  const std::string quoted = in_text('"' + std::string(value) + '"');
  return quoted.substr(1, quoted.size() - 2);
}

std::string PathNames::in_text(std::string_view given) const {
  if (full_) return std::string(given);
  std::string text(given);
  for (const std::string& folder : folders_) text = without(std::move(text), folder);
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    // String that ends with a known file's name, or is the value of a key for files.
    if (c == '"' || c == '\'') {
      const std::size_t end = text.find_first_of(std::string{c, '\n'}, at + 1);
      if (end != std::string::npos && text[end] == c) {
        const std::string_view inside = std::string_view(text).substr(at + 1, end - at - 1);
        const std::size_t line = text.rfind('\n', at) + 1;  // npos + 1: start of the text
        const std::string_view before = std::string_view(text).substr(line, at - line);
        const bool names_files = before.find("file") != std::string_view::npos && before.find('=') != std::string_view::npos;
        const std::string_view name = inside.substr(name_at(inside));
        if (inside.find('/') != std::string_view::npos &&
            (names_files || is_known_file(name.substr(0, name.find(":/"))) || begins_path(inside))) {
          out += c + std::string(name) + c;
          at = end + 1;
          continue;
        }
      }
    }
    if ((at == 0 || !within_name(text[at - 1])) && (c == '/' || c == '~' || c == '.')) {
      std::size_t end = at;
      while (end < text.size() && !ends_path(text[end]) &&
             !(text[end] == ':' && text[std::min(end + 1, text.size() - 1)] != '/'))
        ++end;
      const std::string_view piece = std::string_view(text).substr(at, end - at);
      if (begins_path(piece)) {
        out += piece.substr(name_at(piece));
        at = end;
        continue;
      }
    }
    out += c;
    ++at;
  }
  return out;
}

}  // namespace palpa::detail
