// Folder of a Zarr store: files and JSON below it, and nothing else.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/base/input_file.h"
#include "palpa/base/load_error.h"

namespace palpa::reader {

using ZarrJson = nlohmann::json;

class ZarrFolder {
 public:
  /// \param path  of the store. Throws LoadError with a sentence.
  explicit ZarrFolder(const std::string& path);

  /// File by its path in the store; null if there is none. Throws LoadError "'0/1/2': …" for all else than a regular file of
  /// the store: a link that leads out, a folder, a pipe. Allocates; any thread.
  std::unique_ptr<detail::InputFile> open(const std::string& name) const;

  /// Whether there is a regular file of this name, wherever a link of that name leads. Allocates; any thread.
  bool has(const std::string& name) const;

  /// Content of a JSON file; none if there is no such file. Throws LoadError with a sentence: damaged, too long, too deep.
  std::optional<ZarrJson> json(const std::string& name) const;

  /// Names of the folders in the store's folder that have metadata of Zarr, sorted; at most `most`.
  std::vector<std::string> parts(std::size_t most) const;

 private:
  std::string path_, canonical_;
};

/// Whether a path in metadata is plain: names of letters, digits and "_-+. " with '/' between, none of them "." or "..".
bool is_plain_path(std::string_view path) noexcept;
/// "a/b", also if `folder` is empty.
std::string joined_path(const std::string& folder, const std::string& name);

/// Metadata file, for the sentences of its faults.
struct ZarrMetadata {
  std::string name;  ///< "0/.zarray"
  const ZarrJson& root;

  /// "has a '0/.zarray' " + `fault`. \param fault  "whose 'shape' is …; …"
  LoadError error(const std::string& fault) const;
  /// Member of an object; nullptr if absent or null.
  static const ZarrJson* member(const ZarrJson& of, const char* key) noexcept;
  /// List of whole numbers from `least` on. Throws LoadError.
  std::vector<std::int64_t> whole_numbers(const ZarrJson& of, const char* key, std::int64_t least) const;
  /// List of `count` finite numbers. Throws LoadError.
  std::vector<double> numbers(const ZarrJson& of, const char* key, std::size_t count) const;
  /// Text of a member; `otherwise` if it is absent or no text. Cut to 200 bytes.
  static std::string text(const ZarrJson& of, const char* key, const std::string& otherwise = {});
};

}  // namespace palpa::reader
