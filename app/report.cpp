#include <cstdio>

#include "app/commands.h"
#ifdef PALPA_APP_HAS_VIEW
#include "palpa/report/report.h"
#endif

namespace palpa::app {

int run_report(const ReportArguments& arguments) {
#ifdef PALPA_APP_HAS_VIEW
  const std::filesystem::path file = write_report(arguments.trace, arguments.out,
                                                  {.data_folders = arguments.data_folders,
                                                   .plugins = arguments.plugins,
                                                   .read = arguments.read,
                                                   .pictures = arguments.pictures});
  std::printf("%s\n", file.c_str());
  return 0;
#else
  throw LoadError(arguments.trace.string() + ": this palpa was built without pictures; build it with PALPA_VIEW=ON");
#endif
}

}  // namespace palpa::app
