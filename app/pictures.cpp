#include "app/pictures.h"

#include <dlfcn.h>
#include <signal.h>
#include <unistd.h>

#include <cstring>
#include <string_view>

#include "palpa/base/load_error.h"
#include "palpa/version.h"

namespace palpa::app {
namespace {

namespace fs = std::filesystem;

/// If memory runs out, VTK, Mesa and LLVM abort or write to invalid addresses. Unfinished files have no name yet and vanish.
void end_in_words(int signal) {
  constexpr std::string_view aborted = "palpa: pictures: the renderer failed (aborted)";
  constexpr std::string_view outside = "palpa: pictures: the renderer failed (segmentation fault)";
  constexpr std::string_view remedy = "; give it more memory, or if there is enough, report this as a bug of Palpa\n";
  for (const std::string_view part : {std::string_view("\n"), signal == SIGABRT ? aborted : outside, remedy})
    if (::write(STDERR_FILENO, part.data(), part.size()) < 0) break;
  ::_exit(2);
}

const Pictures* load() {
  const fs::path program = fs::read_symlink("/proc/self/exe");
  const fs::path file = (program.parent_path() / "../libexec/palpa/palpa-pictures.so").lexically_normal();
  if (!fs::exists(file)) return nullptr;
  struct sigaction action = {};
  action.sa_handler = end_in_words;
  for (const int number : {SIGABRT, SIGSEGV}) ::sigaction(number, &action, nullptr);
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
