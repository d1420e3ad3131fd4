#include "palpa/base/own_files.h"

#include <dlfcn.h>

#include <system_error>

namespace palpa {

namespace fs = std::filesystem;

std::vector<fs::path> own_files_folders() {
  std::error_code none;
  const fs::path program = fs::read_symlink("/proc/self/exe", none).parent_path();
  Dl_info info{};
  const bool known = ::dladdr(reinterpret_cast<const void*>(&own_files_folders), &info) != 0 && info.dli_fname;
  // lib or lib/x86_64-linux-gnu.
  const fs::path library = known ? fs::weakly_canonical(info.dli_fname, none).parent_path() : fs::path();
  std::vector<fs::path> folders{program};
  for (const fs::path& prefix : {program.parent_path(), library.parent_path(), library.parent_path().parent_path()})
    folders.push_back(prefix / "libexec" / "palpa");
  return folders;
}

}  // namespace palpa
