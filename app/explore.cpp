#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <vector>

#include "app/commands.h"
#include "palpa/base/load_error.h"

namespace palpa::app {

namespace fs = std::filesystem;

int run_explore(const ExploreArguments& arguments) {
  std::error_code ignored;
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored).parent_path() / "palpa-explorer";
  if (!fs::exists(program, ignored)) {
    throw LoadError(program.string() +
                    ": the window is not installed; it is a package of its own (palpa-explorer), and from a checkout "
                    "./demo --explore builds it");
  }
  std::vector<std::string> words{program.string()};
  for (const std::string& folder : arguments.data_folders) words.insert(words.end(), {"--data", folder});
  if (!arguments.device.empty()) words.insert(words.end(), {"--device", arguments.device});
  if (!arguments.screenshot.empty()) words.insert(words.end(), {"--screenshot", arguments.screenshot});
  if (!arguments.quit_after_s.empty()) words.insert(words.end(), {"--quit-after-s", arguments.quit_after_s});
  words.push_back("--");  // ends the options: file names may begin with a dash
  words.insert(words.end(), arguments.files.begin(), arguments.files.end());
  std::vector<char*> raw;
  for (std::string& word : words) raw.push_back(word.data());
  raw.push_back(nullptr);
  ::execv(program.c_str(), raw.data());
  throw LoadError(program.string() + ": cannot be started (" + std::strerror(errno) + "); build or install it again");
}

}  // namespace palpa::app
