#include <cstdio>

#include "app/commands.h"
#include "app/pictures.h"
#include "app/terminal.h"

namespace palpa::app {

int run_figures(const FiguresArguments& arguments) {
  std::vector<std::string> warnings;
  std::vector<std::filesystem::path> files;
  {
    const Progress progress("drawing into " + arguments.out.string());
    files = pictures_for(arguments.out.string()).figures(arguments.out, warnings);
  }
  print_warnings(warnings);
  for (const std::filesystem::path& file : files) std::printf("%s\n", file.c_str());
  return 0;
}

}  // namespace palpa::app
