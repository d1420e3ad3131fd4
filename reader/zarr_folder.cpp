#include "zarr_folder.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "palpa/base/input_file.h"
#include "palpa/base/sanitized.h"
#include "palpa/base/web_address.h"
#include "palpa/base/wording.h"
#include "zarr_fetch.h"

namespace palpa::reader {
namespace {

namespace fs = std::filesystem;

// Limits of metadata. More of either: hostile metadata take more memory or time; less: sound ones are refused.
constexpr std::uint64_t most_json_bytes = std::uint64_t{4} << 20;
constexpr int most_json_depth = 16;
constexpr std::size_t longest_text_bytes = 200;

/// Depth of nested lists and objects. Adds the text to `plain`, with null for the bare words NaN and Infinity, which Python
/// writes and JSON has not.
int depth_of(std::string_view text, std::string& plain) {
  int depth = 0, deepest = 0;
  bool inside = false;
  plain.reserve(text.size());
  for (std::size_t n = 0; n < text.size(); ++n) {
    const char c = text[n];
    const std::string_view rest = text.substr(n);
    const std::string_view word = inside                         ? ""
                                  : rest.starts_with("NaN")      ? "NaN"
                                  : rest.starts_with("Infinity") ? "Infinity"
                                                                 : "";
    if (!word.empty()) {
      if (plain.ends_with('-')) plain.pop_back();
      plain += "null";
      n += word.size() - 1;
      continue;
    }
    plain += c;
    if (inside && c == '\\' && n + 1 < text.size()) plain += text[++n];
    if (c == '"') inside = !inside;
    if (inside) continue;
    if (c == '[' || c == '{') deepest = std::max(deepest, ++depth);
    if (c == ']' || c == '}') --depth;
  }
  return deepest;
}

/// A file of a folder.
class FolderFile final : public ZarrFile {
 public:
  explicit FolderFile(const std::string& path) : file_(path) {}
  const detail::InputFile& file() const noexcept { return file_; }
  std::uint64_t bytes() const noexcept override { return file_.bytes(); }
  std::size_t read(std::uint64_t from, void* to, std::size_t bytes) const override { return file_.read(from, to, bytes); }
  std::timespec changed() const noexcept override {
    struct stat status{};
    ::fstat(file_.descriptor(), &status);
    return status.st_mtim;
  }

 private:
  detail::InputFile file_;
};

}  // namespace

ZarrFolder::ZarrFolder(const std::string& path, int fetch) : path_(path) {
  if (is_web_address(path)) {
    if (fetch < 0) throw LoadError("cannot be fetched: palpa-read was given no palpa-fetch; update all programs together");
    fetch_ = new ZarrFetch(fetch);
    return;
  }
  std::error_code problem;
  canonical_ = fs::canonical(path, problem).string();
  if (problem) throw LoadError("cannot be opened (" + problem.message() + "); give a folder that can be read");
}

ZarrFolder::~ZarrFolder() = default;

std::unique_ptr<ZarrFile> ZarrFolder::open(const std::string& name, std::uint64_t most_bytes) const {
  if (fetch_) return fetch_->whole(name, most_bytes);
  auto opened = std::make_unique<FolderFile>(path_ + "/" + name);
  const detail::InputFile* const file = &opened->file();
  if (file->why_not() == detail::NoInput::missing) return nullptr;
  if (!file->is_open()) throw LoadError("'" + name + "': " + file->problem());
  // The sandbox also allows the system's folders, which are not the store's.
  char real[4096];
  const ssize_t length = ::readlink(("/proc/self/fd/" + std::to_string(file->descriptor())).c_str(), real, sizeof real);
  const std::string_view there(real, static_cast<std::size_t>(std::max<ssize_t>(length, 0)));
  const bool is_below = there.size() > canonical_.size() && there.starts_with(canonical_) &&
                        (canonical_.ends_with('/') || there[canonical_.size()] == '/');
  if (!is_below) throw LoadError("'" + name + "': is a link that leads out of the store");
  return opened;
}

std::shared_ptr<const ZarrFile> ZarrFolder::open_in_parts(const std::string& name, std::uint64_t index_bytes,
                                                          bool index_at_end) const {
  if (fetch_) return fetch_->in_parts(name, index_bytes, index_at_end);
  return open(name, UINT64_MAX);
}

bool ZarrFolder::has(const std::string& name) const {
  if (fetch_) return true;
  std::error_code problem;
  return fs::is_regular_file(path_ + "/" + name, problem);
}

/// A file of metadata; null if there is none, or a server refuses it, as some do with files that are missing.
std::unique_ptr<ZarrFile> ZarrFolder::open_json(const std::string& name) const {
  try {
    return open(name, most_json_bytes);
  } catch (const LoadError& problem) {
    if (fetch_ && fetch_->was_forbidden(name)) return nullptr;
    if (fetch_) throw LoadError(std::string("cannot be fetched: ") + problem.what() + "; check the address and its server");
    throw LoadError(std::string("has metadata that cannot be used: ") + problem.what() + "; write the store again");
  }
}

bool ZarrFolder::has_json(const std::string& name) const { return open_json(name) != nullptr; }

std::string ZarrFolder::why_absent() const {
  return fetch_ && fetch_->has_forbidden() ? " (the server answers 403, forbidden, to some of its files)" : "";
}

std::optional<ZarrJson> ZarrFolder::json(const std::string& name) const {
  const std::unique_ptr<ZarrFile> file = open_json(name);
  if (!file) return std::nullopt;
  if (file->bytes() > most_json_bytes) throw LoadError("has a '" + name + "' of more than 4 MiB; metadata are short texts");
  std::string text(static_cast<std::size_t>(file->bytes()), '\0');
  text.resize(file->read(0, text.data(), text.size()));
  std::string plain;
  if (depth_of(text, plain) > most_json_depth)
    throw LoadError("has a '" + name + "' of more than 16 levels of lists and objects; write the store again");
  ZarrJson parsed = ZarrJson::parse(plain, nullptr, false);
  if (parsed.is_discarded() || !parsed.is_object())
    throw LoadError("has a '" + name + "' that is no JSON object; get the whole store, or write it again");
  return parsed;
}

std::vector<std::string> ZarrFolder::parts(std::size_t most) const {
  std::vector<std::string> found;
  std::error_code problem;
  if (fetch_) return found;
  for (fs::directory_iterator entry(path_, problem), end; !problem && entry != end && found.size() < most;
       entry.increment(problem)) {
    std::error_code gone;
    for (const char* metadata : {".zarray", ".zgroup", "zarr.json"}) {
      if (fs::is_regular_file(entry->path() / metadata, gone)) {
        found.push_back(detail::one_line(entry->path().filename().string()));
        break;
      }
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

bool is_plain_path(std::string_view path) noexcept {
  constexpr std::string_view marks = "_-+. ";
  while (true) {
    const std::size_t end = std::min(path.find('/'), path.size());
    const std::string_view name = path.substr(0, end);
    const auto is_plain = [&](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || marks.find(c) != marks.npos;
    };
    if (name.empty() || name == "." || name == ".." || name.size() > 255 || !std::ranges::all_of(name, is_plain)) return false;
    if (end == path.size()) return true;
    path.remove_prefix(end + 1);
  }
}

std::string joined_path(const std::string& folder, const std::string& name) {
  return folder.empty() ? name : folder + "/" + name;
}

LoadError ZarrMetadata::error(const std::string& fault) const { return LoadError("has a '" + name + "' " + fault); }

const ZarrJson* ZarrMetadata::member(const ZarrJson& of, const char* key) noexcept {
  if (!of.is_object()) return nullptr;
  const auto found = of.find(key);
  return found == of.end() || found->is_null() ? nullptr : &*found;
}

std::vector<std::int64_t> ZarrMetadata::whole_numbers(const ZarrJson& of, const char* key, std::int64_t least) const {
  // Rank of an array. More: hostile metadata take more time; less: arrays with single extra axes are refused.
  constexpr std::size_t most_numbers = 8;
  constexpr std::int64_t most = std::int64_t{1} << 40;
  const ZarrJson* list = member(of, key);
  std::vector<std::int64_t> numbers;
  if (list != nullptr && list->is_array() && list->size() <= most_numbers) {
    for (const ZarrJson& n : *list) {
      if (!n.is_number_integer() || (n.is_number_unsigned() && n.get<std::uint64_t>() > most)) break;
      const auto number = n.get<std::int64_t>();
      if (number < least || number > most) break;
      numbers.push_back(number);
    }
    if (!numbers.empty() && numbers.size() == list->size()) return numbers;
  }
  throw error("whose '" + std::string(key) + "' is no list of up to 8 whole numbers from " + std::to_string(least) +
              " on; write the store again");
}

std::vector<double> ZarrMetadata::numbers(const ZarrJson& of, const char* key, std::size_t count) const {
  const ZarrJson* list = member(of, key);
  std::vector<double> found;
  if (list != nullptr && list->is_array() && list->size() == count) {
    for (const ZarrJson& n : *list) {
      if (!n.is_number() || !std::isfinite(n.get<double>())) break;
      found.push_back(n.get<double>());
    }
    if (found.size() == count) return found;
  }
  throw error("whose '" + std::string(key) + "' is no list of " + std::to_string(count) +
              " numbers, one for each axis; write the store again");
}

std::string ZarrMetadata::text(const ZarrJson& of, const char* key, const std::string& otherwise) {
  const ZarrJson* value = member(of, key);
  if (value == nullptr || !value->is_string()) return otherwise;
  return detail::shortened(detail::one_line(value->get_ref<const std::string&>()), longest_text_bytes);
}

}  // namespace palpa::reader
