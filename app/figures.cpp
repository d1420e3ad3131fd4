#include <cstdio>
#include <utility>

#include "app/commands.h"
#ifdef PALPA_APP_HAS_VIEW
#include "app/scenes_folder.h"
#include "app/terminal.h"
#include "palpa/report/figures.h"
#include "palpa/report/path_figures.h"
#include "palpa/report/theory_figures.h"
#endif

namespace palpa::app {

int run_figures(const FiguresArguments& arguments) {
#ifdef PALPA_APP_HAS_VIEW
  std::vector<Figure> figures = paper_figures();
  try {
    figures.push_back(laws_figure(scenes_folder()));
  } catch (const LoadError& error) {
    print_warnings({std::string("the figure of the laws is left out: ") + error.what()});
  }
  for (Figure& figure : theory_figures()) figures.push_back(std::move(figure));
  for (Figure& figure : path_figures()) figures.push_back(std::move(figure));
  for (const std::filesystem::path& file : write_figures(arguments.out, figures)) std::printf("%s\n", file.c_str());
  return 0;
#else
  throw LoadError(arguments.out.string() + ": this palpa was built without pictures; build it with PALPA_VIEW=ON");
#endif
}

}  // namespace palpa::app
