#include "palpa/base/scenes_folder.h"

#include <cstdlib>

#include "palpa/base/load_error.h"

namespace palpa {

namespace fs = std::filesystem;

fs::path scenes_folder() {
  if (const char* folder = std::getenv("PALPA_SCENES"); folder && *folder) return folder;
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path();
  for (const char* way : {"../share/palpa/scenes", "../../../scenes"}) {
    const fs::path folder = (program / way).lexically_normal();
    if (fs::is_directory(folder)) return folder;
  }
  throw LoadError("scenes: not found beside " + program.string() + "; set PALPA_SCENES to the folder with head_phantom.toml");
}

}  // namespace palpa
