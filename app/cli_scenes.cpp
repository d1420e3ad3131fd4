// Command lines for scenes.
#include <CLI/CLI.hpp>
#include <memory>

#include "app/command_lines.h"
#include "app/commands.h"
#include "app/options.h"
#include "palpa/base/load_error.h"

namespace palpa::app {

void add_check(CLI::App& app, Work& work, const std::atomic<bool>& stop) {
  const auto given = std::make_shared<CheckArguments>();
  const auto force = std::make_shared<bool>(false);
  const auto sets = std::make_shared<std::vector<std::string>>();
  const auto far = std::make_shared<FarArguments>();
  CLI::App* command = app.add_subcommand("check", "Check a scene for a device, and propose changes; or a link");
  command->add_option("SCENE", given->scene, "scene file (TOML)")->type_name("");
  command
      ->add_option("--device", given->device,
                   "touch, omega, falcon, inverse3, desktop or a file FILE.toml, with values changed as in touch,delay_ticks=2")
      ->type_name("DEVICE");
  add_data_at(command, *far, "in place of a scene and a device: measure for 3 s the link to where palpa serve is");
  command->add_option("--fix", given->fix, "write the scene with the proposed changes into this new file")
      ->type_name("OUT.toml");
  command->add_option("--picture", given->picture, "draw the stable stiffness and damping into this new PNG file")
      ->type_name("FILE.png");
  add_force(command, *force);
  add_repeated(command, "--data", given->scene_options.data_folders, "also search this folder for data")->type_name("DIR");
  add_repeated(command, "--set", *sets, "change one value of the scene, as in coupling.stiffness_n_per_m=400")
      ->type_name("PATH=VALUE");
  add_plugins(command, given->plugins);
  command->add_flag("--json", given->json, "print as JSON");
  add_reader(command, given->read);
  command->footer("Example:\n  palpa check scenes/head_phantom.toml --device touch --picture margin.png");
  command->callback([=, &work, &stop] {
    work = [=, &stop] {
      check_data_at(*far, "check");
      if (!far->data_at.empty() && (!given->scene.empty() || !given->device.empty()))
        throw LoadError("check: --data-at measures a link; leave SCENE and --device out");
      if (!far->data_at.empty()) return check_link(*far, given->json, stop);
      if (given->scene.empty()) throw LoadError("check: SCENE is required; see 'palpa check --help'");
      if (given->device.empty()) throw LoadError("check: --device is required; see 'palpa check --help'");
      given->existing = existing(*force);
      given->scene_options.sets = split_sets(*sets);
      return run_check(*given);
    };
  });
}

namespace {

struct MapLine {
  MapArguments map;
  bool force = false;
  std::string part;
  std::vector<std::string> sets;
};

}  // namespace

void add_map(CLI::App& app, Work& work, const std::atomic<bool>& stop) {
  const auto given = std::make_shared<MapLine>();
  MapArguments& map = given->map;
  CLI::App* command = app.add_subcommand("map", "Compute the force field of a scene on a slice or a grid");
  command->add_option("SCENE", map.scene, "scene file (TOML)")->required()->type_name("");
  command->add_option("OUT", map.out, "new file: .vti, for ParaView")->required()->type_name("");
  command->add_option("--slice", map.slice, "across which axis of the hand: x, y or z (x)")
      ->check(CLI::IsMember({"x", "y", "z"}))
      ->type_name("AXIS");
  command->add_flag("--grid", map.grid, "a cube instead of a slice")->excludes("--slice");
  command->add_option("--at-mm", map.at_mm, "where the slice cuts that axis, from the middle of the workspace (0)")
      ->excludes("--grid")
      ->type_name("MM");
  command->add_option("--size-mm", map.size_mm, "length of its sides, about the middle of the workspace (180)")
      ->type_name("MM");
  command->add_option("--points", map.points, "along each of its sides (256, of a grid 64)")
      ->check(CLI::Range(2, 100000))
      ->type_name("N");
  command->add_option("--picture", map.picture, "draw the slice into this new PNG file")
      ->excludes("--grid")
      ->type_name("FILE.png");
  command->add_option("--threads", map.threads, "number of cores to use (all)")->check(CLI::Range(1, 1024))->type_name("N");
  add_part(command, given->part, "compute only this part of the map, into OUT.part-I; without it all parts are joined");
  command->add_flag("--json", map.json, "print the summary as JSON");
  add_force(command, given->force);
  add_repeated(command, "--data", map.scene_options.data_folders, "folder with the files of the scene")->type_name("DIR");
  add_repeated(command, "--set", given->sets, "replace a value of the scene, as in --set coupling.stiffness_n_per_m=500")
      ->type_name("PATH=VALUE");
  add_plugins(command, map.plugins);
  add_reader(command, map.read);
  command->footer("Example:\n  palpa map scenes/head_phantom.toml head.vti --picture head.png");
  command->callback([=, &work, &stop] {
    work = [=, &stop] {
      given->map.existing = existing(given->force);
      given->map.scene_options.sets = split_sets(given->sets);
      if (!given->part.empty()) given->map.part = work_part(given->part), given->map.is_part = true;
      return run_map(given->map, stop);
    };
  });
}

void add_modes(CLI::App& app, Work& work) {
  const auto given = std::make_shared<ModesArguments>();
  CLI::App* command = app.add_subcommand("modes", "List the types of modes, or the parameters of one");
  command->add_option("TYPE", given->type, "a type of mode")->type_name("");
  add_plugins(command, given->plugins);
  command->add_flag("--json", given->json, "print as JSON");
  command->footer("Example:\n  palpa modes surface_and_friction");
  command->callback([=, &work] { work = [=] { return run_modes(*given); }; });
}

}  // namespace palpa::app
