#include <cstdio>

#include "app/commands.h"
#ifdef PALPA_APP_HAS_VIEW
#include "palpa/report/figures.h"
#endif

namespace palpa::app {

int run_figures(const FiguresArguments& arguments) {
#ifdef PALPA_APP_HAS_VIEW
  for (const std::filesystem::path& file : write_figures(arguments.out)) std::printf("%s\n", file.c_str());
  return 0;
#else
  throw LoadError(arguments.out.string() + ": this palpa was built without pictures; build it with PALPA_VIEW=ON");
#endif
}

}  // namespace palpa::app
