#include <system_error>

#include "palpa/base/web_address.h"
#include "palpa/data/volume.h"

namespace palpa {

PlaceInFile place_in_file(const std::filesystem::path& path) {
  if (is_web_address(path)) return {path, {}};
  const std::string text = path.string();
  const std::size_t at = text.rfind(":/");
  std::error_code ignored;
  if (at == std::string::npos || std::filesystem::exists(path, ignored)) return {path, {}};
  return {text.substr(0, at), text.substr(at + 1)};
}

}  // namespace palpa
