#include "devices/vendor_library.h"

#include <dlfcn.h>

namespace palpa {

VendorLibrary::VendorLibrary(const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    handle_ = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle_ != nullptr) {
      file_ = file;
      return;
    }
    const char* const said = ::dlerror();
    const std::string words = said != nullptr ? said : "";
    // A file that exists but fails to load matters more than missing files.
    if (complaint_.empty() || words.find("No such file") == std::string::npos) complaint_ = words;
  }
}

void* VendorLibrary::symbol(const char* name) const noexcept { return handle_ != nullptr ? ::dlsym(handle_, name) : nullptr; }

}  // namespace palpa
