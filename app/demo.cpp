#include <cerrno>
#include <cstdio>
#include <cstdlib>

#include "app/commands.h"
#include "app/terminal.h"

namespace palpa::app {
namespace {

namespace fs = std::filesystem;

constexpr const char* recording = "trajectories/inverse3_woodcarving_20231121_102837.csv";

/// Where our scenes are: $PALPA_SCENES, or beside the program, installed or in a build folder.
fs::path scenes_folder() {
  if (const char* folder = std::getenv("PALPA_SCENES"); folder && *folder) return folder;
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path();
  for (const char* way : {"../share/palpa/scenes", "../../../scenes"}) {
    const fs::path folder = (program / way).lexically_normal();
    if (fs::is_directory(folder)) return folder;
  }
  throw LoadError("scenes: not found beside " + program.string() + "; set PALPA_SCENES to the folder with head_phantom.toml");
}

}  // namespace

int run_demo(const DemoArguments& arguments, const std::atomic<bool>& stop) {
  const fs::path scenes = scenes_folder();
  RunOptions options;
  options.read = arguments.read;
  if (arguments.data.empty()) {
    options.scene = scenes / "head_phantom.toml";
    options.hand = "sim:stroke";
    options.duration_s = 10.0;
  } else {
    if (!fs::is_directory(arguments.data)) {
      throw LoadError(arguments.data.string() + ": no such folder; --data names the one with ct_head_cranium and trajectories");
    }
    options.scene = scenes / "head.toml";
    options.hand = (arguments.data / recording).string();
    options.hold = Hold::firm;
    options.scene_options.data_folders = {arguments.data};
  }

  RunResult result;
  {
    Progress progress("feeling " + options.scene.filename().string());
    options.progress = [&](double share) { progress.show(share); };
    result = run(options, &stop);
  }
  print_warnings(result.warnings);
  if (arguments.json) {
    std::fputs(to_json(result.summary).c_str(), stdout);
    return 0;
  }
  const std::string palpa = program_invocation_name;  // as the user would have to type it
  std::string next = palpa + " run " + options.scene.string() + " --hand " + options.hand;
  if (options.hold) next += " --hand-hold firm --data " + arguments.data.string();
  std::printf(
      "%s, felt by %s\n\n%s\nTry next:\n  %s --out first-trace --primitives\n  %s replay first-trace\n  %s modes "
      "surface_and_friction\n",
      options.scene.filename().c_str(), options.hand.c_str(), to_table(result.summary).c_str(), next.c_str(), palpa.c_str(),
      palpa.c_str());
  return 0;
}

}  // namespace palpa::app
