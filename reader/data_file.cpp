#include "data_file.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "palpa/base/input_file.h"
#include "palpa/base/load_error.h"
#include "source.h"

namespace palpa::reader {
namespace {

namespace fs = std::filesystem;

/// Resolves links on both sides: the location of the bytes counts.
bool lies_below(const fs::path& place, const fs::path& folder) {
  std::error_code is_gone;
  const fs::path real = fs::canonical(folder, is_gone);
  return !is_gone && std::mismatch(real.begin(), real.end(), place.begin(), place.end()).first == real.end();
}

/// Folders permitted by the user, for files far from their header.
bool lies_below_named_folder(const fs::path& place) {
  const char* folders = std::getenv("PALPA_READER_FOLDERS");
  std::istringstream list(folders != nullptr ? folders : "");
  for (std::string folder; std::getline(list, folder, ':');) {
    if (!folder.empty() && lies_below(place, folder)) return true;
  }
  return false;
}

}  // namespace

void check_not_unpacked(const std::string& header) {
  if (header.starts_with(unpacked_folder))
    throw LoadError("is packed by gzip, and its voxels lie in other files; unpack it (gunzip)");
}

void check_data_file(const std::string& header, const std::string& file) {
  check_not_unpacked(header);
  const std::string who = "needs its data file '" + file + "', which ";
  std::error_code is_gone;
  const fs::path place = fs::canonical(file, is_gone);
  if (!is_gone && !fs::is_regular_file(place, is_gone)) throw LoadError(who + "is no ordinary file; name one");
  if (!is_gone && !lies_below(place, fs::absolute(header).parent_path()) &&
      !lies_below(place, fs::canonical(header).parent_path()) && !lies_below_named_folder(place))
    throw LoadError(who +
                    "lies outside its header's folder; put both together, or name its folder in the variable "
                    "PALPA_READER_FOLDERS");
  const detail::InputFile opened(file);
  if (!opened.is_open()) throw LoadError(who + opened.problem() + "; put it back");
}

}  // namespace palpa::reader
