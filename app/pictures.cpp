#include "app/pictures.h"

#include <dlfcn.h>

#include <cstring>

#include "palpa/core/load_error.h"
#include "palpa/version.h"

namespace palpa::app {
namespace {

namespace fs = std::filesystem;

const Pictures* load() {
  const fs::path program = fs::read_symlink("/proc/self/exe");
  const fs::path file = (program.parent_path() / "../libexec/palpa/palpa-pictures.so").lexically_normal();
  if (!fs::exists(file)) return nullptr;
  void* const library = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library) throw LoadError(file.string() + ": cannot be loaded (" + ::dlerror() + "); install palpa again");
  const auto* const found = static_cast<const Pictures*>(::dlsym(library, "palpa_pictures"));
  if (!found || std::strcmp(found->version, version) != 0)
    throw LoadError(file.string() + ": is not of this palpa, " + version + "; install palpa again");
  return found;
}

}  // namespace

const Pictures* pictures() {
  static const Pictures* const loaded = load();
  return loaded;
}

const Pictures& pictures_for(const std::string& place) {
  if (const Pictures* const loaded = pictures()) return *loaded;
  throw LoadError(place + ": this palpa was built without pictures; build it with PALPA_VIEW=ON");
}

}  // namespace palpa::app
