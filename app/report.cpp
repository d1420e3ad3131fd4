#include <vector>

#include "app/commands.h"
#include "app/output_names.h"
#include "app/pictures.h"
#include "app/terminal.h"
#include "palpa/base/load_error.h"
#include "palpa/trace/trace.h"

namespace palpa::app {

int run_report(const ReportArguments& arguments) {
  if (!arguments.out.empty()) check_ending(arguments.out, ".html");
  const std::vector<std::filesystem::path> traces = traces_in(arguments.trace);
  if (traces.front() != arguments.trace && !(arguments.out.empty() && arguments.beside.empty() && arguments.pictures.empty()))
    throw LoadError(arguments.trace.string() +
                    ": holds a trace of each hand, and --out, --beside and --pictures are for one; name it, as in " +
                    traces.front().string());
  for (const std::filesystem::path& trace : traces) {
    const Pictures& pictures = pictures_for(trace.string());
    std::filesystem::path file;
    {
      Progress progress("report");
      file = pictures.report(trace, arguments.out,
                             {.data_folders = arguments.data_folders,
                              .plugins = arguments.plugins,
                              .read = arguments.read,
                              .beside = arguments.beside,
                              .pictures = arguments.pictures,
                              .full_paths = arguments.full_paths,
                              .replace = arguments.force,
                              .progress = [&](double share) { progress.show(share); }});
    }
    print(file.string() + "\n");
  }
  return 0;
}

}  // namespace palpa::app
