#include <system_error>

#include "palpa/data/volume.h"

namespace palpa {

PlaceInFile place_in_file(const std::filesystem::path& path) {
  const std::string text = path.string();
  const std::size_t at = text.rfind(":/");
  std::error_code ignored;
  if (at == std::string::npos || std::filesystem::exists(path, ignored)) return {path, {}};
  return {text.substr(0, at), text.substr(at + 1)};
}

}  // namespace palpa
