#include "app/output_names.h"

#include <system_error>

#include "palpa/base/load_error.h"
#include "palpa/file/protocol.h"

namespace palpa::app {

namespace fs = std::filesystem;

void check_ending(const fs::path& file, const char* ending) {
  if (file.extension() != ending)
    throw LoadError(file.string() + ": has an ending of no format that is written; name it " + ending);
}

void check_output(const fs::path& file, const char* ending, detail::Existing existing) {
  check_ending(file, ending);
  try {
    const detail::NewFile trial(file, existing);
  } catch (const LoadError& error) {
    throw LoadError(file.string() + ": " + error.what());
  }
}

std::string wrote_words(const fs::path& file, const std::string& what) {
  std::error_code none;
  const std::uintmax_t bytes = fs::file_size(file, none);
  return "Wrote " + file.string() + ": " + what + (none ? "" : ", " + protocol::readable_bytes(static_cast<double>(bytes))) +
         "\n";
}

}  // namespace palpa::app
