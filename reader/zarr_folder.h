// Folder of a Zarr store: files and JSON below it, and nothing else.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/base/load_error.h"
#include "zarr_file.h"

namespace palpa::reader {

using ZarrJson = nlohmann::json;

class ZarrFetch;

class ZarrFolder {
 public:
  /// Throws LoadError with a sentence.
  /// \param path   of the store: a folder, or a web address
  /// \param fetch  socket of palpa-fetch, of a web address
  ZarrFolder(const std::string& path, int fetch);
  ~ZarrFolder();

  /// Whether its files are fetched, so that each costs a round trip.
  bool is_fetched() const noexcept { return fetch_ != nullptr; }

  /// File by its path in the store; null if there is none. Throws LoadError "'0/1/2': …" for all else than a regular file of
  /// the store: a link that leads out, a folder, a pipe; a file that could not be fetched. Allocates; any thread.
  /// \param most_bytes  longer files are not fetched
  std::unique_ptr<ZarrFile> open(const std::string& name, std::uint64_t most_bytes) const;
  /// `open` of a file with an index, whose other parts are fetched one by one.
  std::shared_ptr<const ZarrFile> open_in_parts(const std::string& name, std::uint64_t index_bytes, bool index_at_end) const;

  /// Whether there is a regular file of this name, wherever a link of that name leads; of a file that would be fetched true.
  /// Allocates; any thread.
  bool has(const std::string& name) const;

  /// Content of a JSON file; none if there is no such file. Throws LoadError with a sentence: damaged, too long, too deep.
  std::optional<ZarrJson> json(const std::string& name) const;

  /// Whether there is a JSON file. Throws as `json`.
  bool has_json(const std::string& name) const;

  /// Why metadata may look absent, to follow a sentence that says so: empty, or the server's refusal.
  std::string why_absent() const;

  /// Names of the folders in the store's folder that have metadata of Zarr, sorted; at most `most`. Of a web address none.
  std::vector<std::string> parts(std::size_t most) const;

 private:
  std::unique_ptr<ZarrFile> open_json(const std::string& name) const;

  std::string path_, canonical_;
  ZarrFetch* fetch_ = nullptr;  ///< lives as long as the process; null: files are opened
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
