#include "app/commands.h"
#include "app/output_names.h"
#include "app/terminal.h"
#include "palpa/base/printed.h"
#include "palpa/trace/export_trace.h"

namespace palpa::app {

int run_export(const ExportArguments& arguments) {
  std::size_t ticks = 0;
  {
    const Progress progress("writing " + arguments.out.filename().string());
    ticks = export_trace(arguments.trace, arguments.out, arguments.existing);
  }
  tell(wrote_words(arguments.out, detail::grouped(std::to_string(ticks)) + (ticks == 1 ? " tick" : " ticks")));
  return 0;
}

}  // namespace palpa::app
