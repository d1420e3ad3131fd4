#include "palpa/base/load_error.h"
#include "palpa/base/new_file.h"

namespace palpa::detail {

void write_whole(const std::filesystem::path& name, std::string_view bytes, Existing existing) {
  try {
    NewFile file(name, existing);
    file.write(bytes);
    file.finish();
  } catch (const LoadError& error) {
    throw LoadError(name.string() + ": " + error.what());
  }
}

}  // namespace palpa::detail
