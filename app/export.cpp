#include "app/commands.h"
#include "app/terminal.h"
#include "palpa/export/export_trace.h"

namespace palpa::app {

int run_export(const ExportArguments& arguments) {
  const Progress progress("writing " + arguments.out.filename().string());
  export_trace(arguments.trace, arguments.out, arguments.existing);
  return 0;
}

}  // namespace palpa::app
