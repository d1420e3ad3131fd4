// Command lines for traces.
#include <CLI/CLI.hpp>
#include <memory>

#include "app/command_lines.h"
#include "app/commands.h"
#include "app/options.h"
#include "palpa/base/load_error.h"

namespace palpa::app {

void add_replay(CLI::App& app, Work& work, const std::atomic<bool>& stop) {
  const auto given = std::make_shared<ReplayArguments>();
  CLI::App* command = app.add_subcommand("replay", "Replay a trace and compare every number");
  command->add_option("TRACE", given->trace, "folder of the trace, or a file in it; of several hands all of them")
      ->required()
      ->type_name("");
  add_repeated(command, "--data", given->data_folders, "search this folder first for the scene's data")->type_name("DIR");
  add_plugins(command, given->plugins);
  command->add_flag("--json", given->json, "print the answer as JSON");
  add_reader(command, given->read);
  command->footer("Example:\n  palpa replay first-trace");
  command->callback([=, &work, &stop] {
    work = [=, &stop] {
      given->trace = trace_folder(given->trace);
      return run_replay(*given, stop);
    };
  });
}

void add_report(CLI::App& app, Work& work) {
  const auto given = std::make_shared<ReportArguments>();
  CLI::App* command = app.add_subcommand("report", "Make one HTML page of a trace: pictures, plots, tables");
  command->add_option("TRACE", given->trace, "folder of the trace; of several hands a page for each")
      ->required()
      ->type_name("");
  command
      ->add_option("--beside", given->beside,
                   "compare with this trace of the same hand: the differences, and whether a hand would tell them apart")
      ->type_name("TRACE");
  command->add_option("--out", given->out, "output file (report.html in the trace, with --beside beside.html)")
      ->type_name("FILE");
  command->add_option("--pictures", given->pictures, "write the pictures as PNG and SVG files into this folder, too")
      ->type_name("DIR");
  command->add_flag("--full-paths", given->full_paths, "write whole paths of files into the page (file names only)");
  add_force(command, given->force);
  add_repeated(command, "--data", given->data_folders, "search this folder first for the scene's data")->type_name("DIR");
  add_plugins(command, given->plugins);
  add_reader(command, given->read);
  command->footer("Example:\n  palpa report first-trace");
  command->callback([=, &work] {
    work = [=] {
      given->trace = trace_folder(given->trace);
      if (!given->beside.empty()) given->beside = trace_folder(given->beside);
      return run_report(*given);
    };
  });
}

void add_export(CLI::App& app, Work& work) {
  const auto given = std::make_shared<ExportArguments>();
  const auto force = std::make_shared<bool>(false);
  CLI::App* command =
      app.add_subcommand("export", "Export a trace, in the frame of the data, for ParaView, 3D Slicer and tables");
  command->add_option("TRACE", given->trace, "folder of the trace, or a file in it")->required()->type_name("");
  command
      ->add_option("OUT", given->out,
                   "new file: .vtp (a path with all columns, for ParaView), .csv, .h5, or .mrk.json (for 3D Slicer: RAS, in "
                   "millimetres)")
      ->required()
      ->type_name("");
  add_force(command, *force);
  command->footer("Example:\n  palpa export first-trace felt.vtp");
  command->callback([=, &work] {
    work = [=] {
      given->trace = trace_folder(given->trace);
      given->existing = existing(*force);
      return run_export(*given);
    };
  });
}

}  // namespace palpa::app
