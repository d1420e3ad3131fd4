#include "palpa/study/check.h"

#include "app/commands.h"
#include "app/output_names.h"
#include "app/pictures.h"
#include "app/terminal.h"
#include "palpa/disk/new_file.h"
#include "palpa/mode/plugin.h"
#include "palpa/scene/change_text.h"
#include "palpa/scene/load_scene.h"

namespace palpa::app {
namespace {

void check_names(const CheckArguments& arguments) {
  if (!arguments.fix.empty() && arguments.fix.extension() != ".toml")
    throw LoadError("--fix " + arguments.fix.string() + ": is no name of a scene; write --fix OUT.toml");
  if (arguments.picture.empty()) return;
  check_output(arguments.picture, ".png", arguments.existing);
  pictures_for("--picture " + arguments.picture.string());
}

/// The file with its changes, and nothing else of it touched.
std::string fixed(const LoadedScene& loaded, const CheckReport& report) {
  std::string text = loaded.text;
  for (const Change& change : report.changes) text = with_number(text, change.table, change.key, change.to);
  return text;
}

}  // namespace

int run_check(const CheckArguments& arguments) {
  check_names(arguments);
  const DevicePlant plant = checked_plant(device_plant(arguments.device));
  LoadedScene loaded;
  CheckReport report;
  {
    Progress progress("checking " + arguments.scene.filename().string());
    SceneOptions options;
    options.data_folders = arguments.data_folders;
    loaded = load_scene(arguments.scene, volume_reader(arguments.read), modes_with(arguments.plugins), options);
    report = check(loaded.scene, plant,
                   {.map = !arguments.picture.empty(), .progress = [&](double share) { progress.show(share); }});
  }
  print_warnings(loaded.warnings);
  print(arguments.json ? to_json(report) : to_table(report));
  if (!arguments.picture.empty())
    pictures_for("--picture " + arguments.picture.string()).check(report, arguments.picture, arguments.existing);
  if (!arguments.fix.empty()) {
    detail::write_whole(arguments.fix, fixed(loaded, report), arguments.existing);
    if (!arguments.json)
      print(report.changes.empty() ? "\nNothing was changed in " + arguments.fix.string() + "\n"
                                   : "\nWritten to " + arguments.fix.string() + "\nNext: palpa check " +
                                         arguments.fix.string() + " --device " + arguments.device + "\n");
  }
  return report.grade == Grade::stop ? 1 : 0;
}

}  // namespace palpa::app
