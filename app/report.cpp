#include "app/commands.h"
#include "app/output_names.h"
#include "app/pictures.h"
#include "app/terminal.h"

namespace palpa::app {

int run_report(const ReportArguments& arguments) {
  if (!arguments.out.empty()) check_ending(arguments.out, ".html");
  const Pictures& pictures = pictures_for(arguments.trace.string());
  std::filesystem::path file;
  {
    Progress progress("report");
    file = pictures.report(arguments.trace, arguments.out,
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
  return 0;
}

}  // namespace palpa::app
