#include <unistd.h>

#include <cerrno>
#include <cstdlib>

#include "app/commands.h"
#include "app/pictures.h"
#include "app/terminal.h"
#include "palpa/base/printed.h"
#include "palpa/base/scenes_folder.h"

namespace palpa::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* recording = "trajectories/inverse3_woodcarving_20231121_102837.csv";
constexpr const char* simulated = "sim:stroke";

/// Folder with the real data of a demo: the named one or, for the head, the target of tools/get-ct-head; empty if absent.
fs::path data_folder(const DemoArguments& arguments) {
  if (!arguments.data.empty()) {
    if (fs::is_directory(arguments.data)) return arguments.data;
    throw LoadError(arguments.data.string() +
                    ": no such folder; --data names the one with ct_head_cranium, mri_flow_carotid, cfd_wing and trajectories");
  }
  if (arguments.name != "head") return {};
  const auto variable = [](const char* name) -> fs::path {
    const char* value = std::getenv(name);
    return value ? value : "";
  };
  fs::path folder = variable("PALPA_DATA");
  if (folder.empty()) {
    const fs::path shared = variable("XDG_DATA_HOME"), home = variable("HOME");
    folder = (shared.empty() ? home / ".local/share" : shared) / "palpa";
  }
  return fs::exists(folder / "ct_head_cranium/cranium.mhd") ? folder : fs::path();
}

/// Unused name of a folder: `wanted`, or `wanted` with a number.
fs::path new_folder(const fs::path& wanted) {
  fs::path folder = wanted;
  for (int number = 2; fs::exists(folder); ++number) folder = wanted.string() + "-" + std::to_string(number);
  return folder;
}

/// Folder for the demo's recording. Empty, with a message, if nothing can be written; empty for JSON without --out.
fs::path trace_folder(const DemoArguments& arguments) {
  fs::path folder = arguments.out;
  if (folder.empty()) {
    if (arguments.json) return {};
    if (::access(".", W_OK) != 0) {
      print("This folder cannot be written, so nothing is recorded; name a writable one with --out DIR.\n\n");
      return {};
    }
    folder = "palpa-demo";
  }
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw LoadError(folder.string() + ": cannot be made (" + error.message() + "); name another folder with --out");
  return new_folder(folder / arguments.name);
}

/// Prints the paths of the recording, its report and its pictures.
void print_what_there_is(const fs::path& trace, const DemoArguments& arguments, const fs::path& data) {
  if (trace.empty()) return;
  print(detail::text("Recorded in %s\n", trace.c_str()));
  if (!pictures()) return print("No report and no pictures: this palpa was built without them.\n");
  ReportOptions options{.data_folders = {}, .plugins = {}, .read = arguments.read, .pictures = trace / "pictures"};
  if (!data.empty()) options.data_folders = {data};
  fs::path report;
  {
    Progress progress("drawing the report");
    report = pictures()->report(trace, {}, options);
  }
  print(detail::text("Report      %s\n", report.c_str()));
  for (const char* name : {"scene.png", "moment.png"}) {
    if (const fs::path picture = options.pictures / name; fs::exists(picture))
      print(detail::text("Picture     %s\n", picture.c_str()));
  }
}

}  // namespace

int run_demo(const DemoArguments& arguments, const std::atomic<bool>& stop) {
  const fs::path scenes = scenes_folder();
  RunOptions options;
  options.read = arguments.read;
  options.device = arguments.device;
  if (!options.device.empty()) device_plant(options.device);  // refuses wrong ones before a folder is made
  const fs::path data = data_folder(arguments);
  const bool recorded = !arguments.data.empty() || fs::exists(data / recording);
  if (data.empty()) {
    options.scene = scenes / (arguments.name + "_phantom.toml");
    options.hand = simulated;
    options.duration_s = 10.0;
  } else {
    options.scene = scenes / (arguments.name + ".toml");
    options.hand = recorded ? (data / recording).string() : simulated;
    if (recorded) options.hold = Hold::relaxed;
    options.scene_options.data_folders = {data};
  }
  options.out = trace_folder(arguments);
  const std::string palpa = program_invocation_name;  // as the user would type it
  options.arguments = {"demo", arguments.name};
  if (!options.device.empty()) options.arguments.insert(options.arguments.end(), {"--device", options.device});

  RunResult result;
  {
    Progress progress("feeling " + options.scene.filename().string());
    options.progress = [&](double share) { progress.show(share); };
    result = run(options, &stop);
  }
  print_warnings(result.warnings);
  if (arguments.json) {
    print(to_json(result.summary));
    return 0;
  }
  print(detail::text("%s, felt by %s\n\n%s\n", options.scene.filename().c_str(), options.hand.c_str(),
                     to_table(result.summary).c_str()));
  print_what_there_is(options.out, arguments, data);

  std::string next = palpa + " run " + options.scene.string() + " --hand " + options.hand;
  if (options.hold) next += " --hand-hold relaxed";
  if (!options.device.empty()) next += " --device " + options.device;
  if (!data.empty()) next += " --data " + data.string();
  const std::string trace = options.out.empty() ? "first-trace" : options.out.string();
  print(detail::text("Try next:\n  %s --out first-trace --primitives\n  %s replay %s\n  %s modes %s\n", next.c_str(),
                     palpa.c_str(), trace.c_str(), palpa.c_str(), result.summary.modes.front().type.c_str()));
  const fs::path get_head = (scenes / "../tools/get-ct-head").lexically_normal();
  if (arguments.name == "head" && data.empty() && fs::exists(get_head)) {
    print(detail::text("For a real CT head in place of the embedded one (a package of Debian, 19 MB, no root):\n  %s\n",
                       get_head.c_str()));
  }
  return 0;
}

}  // namespace palpa::app
