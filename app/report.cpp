#include <cstdio>

#include "app/commands.h"
#include "app/pictures.h"

namespace palpa::app {

int run_report(const ReportArguments& arguments) {
  const std::filesystem::path file = pictures_for(arguments.trace.string())
                                         .report(arguments.trace, arguments.out,
                                                 {.data_folders = arguments.data_folders,
                                                  .plugins = arguments.plugins,
                                                  .read = arguments.read,
                                                  .pictures = arguments.pictures});
  std::printf("%s\n", file.c_str());
  return 0;
}

}  // namespace palpa::app
