#include "app/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "app/commands.h"
#include "app/hand_words.h"
#include "app/info.h"
#include "app/reference.h"
#include "app/terminal.h"
#include "palpa/scene/wording.h"
#include "palpa/version.h"

namespace palpa::app {
namespace {

/// `PATH=VALUE` as its two halves. \param example  for who wrote it otherwise
std::pair<std::string, std::string> split_set(const std::string& text, const std::string& example) {
  const std::size_t at = text.find('=');
  if (at == 0 || at == std::string::npos) {
    throw LoadError("--set " + text + ": is no setting; write " + example);
  }
  return {text.substr(0, at), text.substr(at + 1)};
}

/// An option that may be given several times, with one value each.
template <class T>
CLI::Option* add_repeated(CLI::App* command, const std::string& name, std::vector<T>& values, const std::string& sentence) {
  return command->add_option(name, values, sentence)->allow_extra_args(false);
}

void add_plugins(CLI::App* command, std::vector<std::filesystem::path>& plugins) {
  add_repeated(command, "--plugin", plugins, "take modes from this shared library, which you trust")->type_name("FILE");
}

void add_reader(CLI::App* command, ReadOptions& read) {
  command->add_option("--reader", read.reader, "the program palpa-read, if it is not found by itself")->type_name("FILE");
}

void add_device(CLI::App* command, std::string& device) {
  command
      ->add_option("--device", device,
                   "the device that the hand holds: touch, omega, falcon, inverse3 or desktop, with values changed as in "
                   "touch,delay_ticks=2 (an ideal one: no mass, friction, encoder or delay)")
      ->type_name("DEVICE");
}

/// A trace by its folder, or by a file in it, as a shell completes one.
std::filesystem::path trace_folder(const std::filesystem::path& named) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(named, unknown)) return named;
  const std::filesystem::path folder = std::filesystem::absolute(named).parent_path();
  return std::filesystem::exists(folder / "trace.toml", unknown) ? folder : named;
}

/// What a scene's [volume] would say about a file.
struct HowToRead {
  std::vector<std::string> sets;
  std::vector<std::filesystem::path> partners;
};
void add_how_to_read(CLI::App* command, HowToRead& how) {
  add_repeated(command, "--with", how.partners,
               "read this file with it, as a PLOT3D solution whose name is not that of its grid")
      ->type_name("FILE");
  add_repeated(command, "--set", how.sets,
               "read it as a scene would with this key of [volume], as in --set as=vector, --set length_unit=cm or, of bare "
               "numbers, --set type=int16 --set dims=[256,256,99]")
      ->type_name("KEY=VALUE");
}
/// `files` are its partners alone.
VolumeRequest request_of(const HowToRead& how) {
  std::vector<std::pair<std::string, std::string>> keys;
  for (const std::string& set : how.sets) keys.push_back(split_set(set, "KEY=VALUE, as in length_unit=cm"));
  VolumeRequest request = how_to_read(keys);
  request.files = how.partners;
  return request;
}

/// The words between commas.
std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> words(1);
  for (const char c : list) {
    if (c == ',') {
      words.emplace_back();
    } else {
      words.back() += c;
    }
  }
  return words;
}

/// CLI11's complaint in our form: what is wrong; what would be right.
std::string complaint(const CLI::ParseError& error, const CLI::App& app) {
  const CLI::App* command = &app;
  for (const CLI::App* used : app.get_subcommands()) command = used;
  const std::string name = command == &app ? "command line" : command->get_name();
  const std::string help = command == &app ? "see 'palpa --help'" : "see 'palpa " + name + " --help'";

  const std::vector<std::string> rest = command->remaining();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) && !rest.empty()) {
    const auto option = std::find_if(rest.begin(), rest.end(), [](const std::string& word) { return word.rfind('-', 0) == 0; });
    if (option == rest.end()) return name + ": " + detail::in_quotes(rest.front()) + " is one argument too many; " + help;
    std::vector<std::string> known;
    for (const CLI::Option* there : command->get_options()) {
      for (const std::string& long_name : there->get_lnames()) known.push_back("--" + long_name);
    }
    const std::string given = option->substr(0, option->find('='));
    return name + ": unknown option " + detail::in_quotes(given) + "; " + detail::suggestion(given, known);
  }
  // "--hand-hold: loose not in {rigid,relaxed,firm}", and "Could not convert: --rate-hz = fast"
  const std::string text = error.what();
  const std::size_t colon = text.find(": "), not_in = text.find(" not in {");
  if (dynamic_cast<const CLI::ValidationError*>(&error) && colon < not_in && not_in != std::string::npos &&
      text.back() == '}') {
    const std::size_t open = not_in + 9;
    const std::string given = text.substr(colon + 2, not_in - colon - 2);
    return name + ": " + text.substr(0, colon) + " cannot be " + detail::in_quotes(given) + "; " +
           detail::suggestion(given, split(text.substr(open, text.size() - 1 - open)));
  }
  if (dynamic_cast<const CLI::ConversionError*>(&error) && colon != std::string::npos) {
    const std::size_t equals = std::min(text.find(" = "), text.size() - 3);
    return name + ": " + text.substr(colon + 2, equals - colon - 2) + " cannot be " +
           detail::in_quotes(text.substr(equals + 3)) + "; it must be a number";
  }
  return name + ": " + text + "; " + help;
}

}  // namespace

int run_command_line(int argc, char** argv, const std::atomic<bool>& stop) {
  CLI::App app("Touch volumetric data: feel scans and flows as forces.", "palpa");
  app.set_version_flag("--version", std::string("palpa ") + version);
  app.require_subcommand(1);
  app.footer(
      "First steps:\n"
      "  palpa demo                                             a head from a formula, felt by a simulated hand\n"
      "  palpa info scan.nrrd --scene first.toml                data of your own, and a first scene for them\n"
      "  palpa run first.toml --hand sim:stroke --out first     feel it, record it\n"
      "  palpa report first                                     see what was felt\n"
      "Each command has help of its own with an example: palpa run --help\n"
      "Exit codes: 0 ok, 1 it ran and the answer is no, 2 wrong usage or input, 130 interrupted.");

  DemoArguments demo;
  CLI::App* demo_command = app.add_subcommand("demo", "Feel a head, a flow or a wing's wake, and see what came of it");
  demo_command->add_option("NAME", demo.name, "which demo: head, flow or wing (head)")
      ->check(CLI::IsMember({"head", "flow", "wing"}))
      ->type_name("");
  demo_command
      ->add_option(
          "--data", demo.data,
          "folder of real data, felt by a recorded hand; left out: embedded data, or the head that tools/get-ct-head brought")
      ->type_name("DIR");
  demo_command->add_option("--out", demo.out, "folder for recording, report and pictures (palpa-demo)")->type_name("DIR");
  add_device(demo_command, demo.device);
  demo_command->add_flag("--json", demo.json, "print the summary as JSON; records only with --out");
  add_reader(demo_command, demo.read);
  demo_command->footer("Example:\n  palpa demo head");

  RunArguments run;
  std::vector<std::string> sets;
  std::string hold, center, fit;
  CLI::App* run_command = app.add_subcommand("run", "Feel a scene with a recorded or simulated hand");
  run_command->add_option("SCENE", run.options.scene, "scene file (TOML)")->required()->type_name("");
  run_command
      ->add_option("--hand", run.options.hand, "a recording (CSV) or a simulated hand, sim:NAME[,KEY=VALUE,…]: see below")
      ->required()
      ->type_name("HAND");
  run_command
      ->add_option(
          "--hand-hold", hold,
          "how a hand is held: rigid (it follows the recording whatever the force, default of recordings), relaxed (default of "
          "simulated hands) or firm")
      ->check(CLI::IsMember({"rigid", "relaxed", "firm"}))
      ->type_name("HOLD");
  add_device(run_command, run.options.device);
  run_command->add_option("--hand-rate-hz", run.options.recording.hand_rate_hz, "rate of a recording without time")
      ->type_name("HZ");
  run_command
      ->add_option("--hand-center", center, "put the middle of the recording into the middle of the workspace: on or off")
      ->check(CLI::IsMember({"on", "off"}))
      ->type_name("ON");
  run_command
      ->add_option("--hand-fit", fit,
                   "lay a recording where it feels most of the data: on or off (on, but with --hand-center; traces of ours are "
                   "never moved)")
      ->check(CLI::IsMember({"on", "off"}))
      ->type_name("ON");
  run_command->add_option("--duration-s", run.options.duration_s, "duration (the recording's, or 10)")->type_name("S");
  run_command->add_option("--rate-hz", run.options.rate_hz, "update rate: ticks per second (1000)")->type_name("HZ");
  run_command->add_option("--out", run.options.out, "record a trace into this new folder")->type_name("DIR");
  run_command->add_flag("--primitives", run.options.primitives, "record balances and primitives as well");
  add_repeated(run_command, "--data", run.options.scene_options.data_folders, "look for data here as well")->type_name("DIR");
  add_repeated(run_command, "--set", sets, "change one value of the scene, as in mode.skin.friction_n=0.2")
      ->type_name("PATH=VALUE");
  add_plugins(run_command, run.options.plugins);
  run_command->add_flag("--dry-run", run.dry_run, "load and check everything, say what it is, feel nothing");
  run_command->add_flag("--json", run.json, "print the summary as JSON");
  add_reader(run_command, run.options.read);
  run_command->footer(hand_words() + "Example:\n  palpa run scenes/head_phantom.toml --hand sim:press --out first-trace");

  InfoArguments info;
  CLI::App* info_command = app.add_subcommand("info", "Say what is in data files, draw it, suggest a first scene");
  std::vector<std::string> at_m, at;
  info_command
      ->add_option("FILE", info.files,
                   "files or folders, each a volume of its own; a pattern in quotes, as 'phase_*.vti', is one time series")
      ->required()
      ->type_name("");
  add_repeated(info_command, "--at", at,
               "say the values there: at a voxel, as 120,200,90, at a position, as -5mm,16mm,7mm, or in the patient, as "
               "R5,A16,S7 (millimetres to the right or left, front or back, head or feet)")
      ->type_name("PLACE");
  add_repeated(info_command, "--at-m", at_m, "say the values at this position of the world, in metres")->type_name("X,Y,Z");
  info_command->add_flag("--series", info.series, "the files are the frames of one time series");
  info_command
      ->add_option(
          "--level", info.level,
          "say how much of what is thin above this value the smooth filter loses, and how far the level moves from frame "
          "to frame")
      ->type_name("VALUE");
  info_command->add_flag("--json", info.json, "print as JSON");
  std::string scene_file;
  CLI::Option* scene_option =
      info_command->add_option("--scene", scene_file, "suggest a first scene, printed or written into this new file")
          ->expected(0, 1)
          ->type_name("[OUT.toml]");
  info_command->add_option("--picture", info.picture, "draw slices, streamlines and histogram into this PNG file")
      ->type_name("FILE.png");
  HowToRead info_how;
  add_how_to_read(info_command, info_how);
  add_reader(info_command, info.read);
  info_command->footer("Example:\n  palpa info head.nrrd --at 120,200,90 --picture head.png");

  ConvertArguments converted;
  CLI::App* convert_command =
      app.add_subcommand("convert", "Write data as NRRD or VTI: whole, a part, coarser, or on another grid");
  std::string convert_in;
  convert_command->add_option("IN", convert_in, "a file or folder of data")->required()->type_name("");
  convert_command->add_option("OUT", converted.out, "new file: .nrrd, .nhdr or .vti")->required()->type_name("");
  convert_command->add_option("--crop", converted.crop, "only these voxels, first and last of each axis")
      ->type_name("I0:I1,J0:J1,K0:K1");
  convert_command->add_option("--downsample", converted.options.downsample, "the mean of N x N x N voxels becomes one")
      ->check(CLI::Range(1, 1000))
      ->type_name("N");
  convert_command
      ->add_option("--resample-m", converted.options.resample_m,
                   "onto cubes of this size along the world's axes; NaN outside the data")
      ->check(CLI::PositiveNumber)
      ->type_name("M");
  convert_command->add_flag("--int16", converted.options.int16, "round to whole numbers of 16 bits");
  convert_command->add_option("--field", converted.options.field, "only this field")->type_name("NAME");
  HowToRead convert_how;
  add_how_to_read(convert_command, convert_how);
  add_reader(convert_command, converted.read);
  convert_command->footer("Example:\n  palpa convert head.nrrd small.nrrd --downsample 2");

  ReplayArguments replayed;
  CLI::App* replay_command = app.add_subcommand("replay", "Replay a trace and compare every number");
  replay_command->add_option("TRACE", replayed.trace, "folder of the trace, or a file in it")->required()->type_name("");
  add_repeated(replay_command, "--data", replayed.data_folders, "look for the scene's data here first")->type_name("DIR");
  add_plugins(replay_command, replayed.plugins);
  replay_command->add_flag("--json", replayed.json, "print the answer as JSON");
  add_reader(replay_command, replayed.read);
  replay_command->footer("Example:\n  palpa replay first-trace");

  ReportArguments reported;
  CLI::App* report_command = app.add_subcommand("report", "Make one HTML page of a trace: pictures, plots, tables");
  report_command->add_option("TRACE", reported.trace, "folder of the trace")->required()->type_name("");
  report_command->add_option("--out", reported.out, "where to write; left out: report.html in the trace")->type_name("FILE");
  report_command->add_option("--pictures", reported.pictures, "write the pictures as PNG and SVG files into this folder, too")
      ->type_name("DIR");
  add_repeated(report_command, "--data", reported.data_folders, "look for the scene's data here first")->type_name("DIR");
  add_plugins(report_command, reported.plugins);
  add_reader(report_command, reported.read);
  report_command->footer("Example:\n  palpa report first-trace");

  FiguresArguments figures;
  CLI::App* figures_command =
      app.add_subcommand("figures", "Draw the figures of the documentation from this program's own answers");
  figures_command->add_option("--out", figures.out, "folder to write into (figures)")->type_name("DIR");
  figures_command->footer("Example:\n  palpa figures --out figures");

  ModesArguments modes;
  CLI::App* modes_command = app.add_subcommand("modes", "List the types of modes, or the parameters of one");
  modes_command->add_option("TYPE", modes.type, "a type of mode")->type_name("");
  add_plugins(modes_command, modes.plugins);
  modes_command->add_flag("--json", modes.json, "print as JSON");
  modes_command->footer("Example:\n  palpa modes surface_and_friction");

  app.add_option_function<std::string>(
         "--print",
         [&app](const std::string& what) {
           std::fputs((what == "man" ? man_page(app) : bash_completion(app)).c_str(), stdout);
           throw CLI::Success();
         },
         "print the man page, or bash's completion, as in: source <(palpa --print bash)")
      ->check(CLI::IsMember({"man", "bash"}))
      ->type_name("WHAT");
  // What the completion asks.
  app.add_option_function<std::string>("--print-sets",
                                       [](const std::string& scene) {
                                         std::fputs(settings_of(scene).c_str(), stdout);
                                         throw CLI::Success();
                                       })
      ->group("");

  // CLI11 would call an unknown command a missing one.
  std::vector<std::string> commands;
  for (const CLI::App* command : app.get_subcommands({})) commands.push_back(command->get_name());
  if (argc < 2) {
    std::fputs(app.help().c_str(), stdout);
    return 0;
  }
  if (argv[1][0] != '-' && std::find(commands.begin(), commands.end(), argv[1]) == commands.end()) {
    print_error("command line: unknown command " + detail::in_quotes(argv[1]) + "; " + detail::suggestion(argv[1], commands));
    return 2;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // help and version
    print_error(complaint(error, app));
    return 2;
  }

  if (*run_command) {
    RunOptions& options = run.options;
    options.arguments.assign(argv + 1, argv + argc);
    for (const std::string& set : sets)
      options.scene_options.sets.push_back(split_set(set, "PATH=VALUE, as in coupling.stiffness_n_per_m=500"));
    if (!hold.empty()) options.hold = hold == "rigid" ? Hold::rigid : hold == "relaxed" ? Hold::relaxed : Hold::firm;
    if (!fit.empty()) options.fit = fit == "on";
    if (!center.empty()) options.recording.center = center == "on";
    return run_scene(std::move(run), stop);
  }
  if (*info_command) {
    info.read.look = true;
    info.read.checksums = info.json;
    info.request = request_of(info_how);
    for (const std::string& position : at_m) info.places.push_back(asked_place_m(position));
    for (const std::string& place : at) info.places.push_back(asked_place(place));
    info.scene = scene_option->count() > 0;
    info.scene_file = scene_file;
    if (!scene_file.empty() && info.scene_file.extension() != ".toml") {
      throw LoadError("--scene " + scene_file +
                      ": is no name of a scene; write --scene OUT.toml, or put --scene behind the file");
    }
    return run_info(info);
  }
  if (*convert_command) {
    converted.request = request_of(convert_how);
    converted.request.files.insert(converted.request.files.begin(), convert_in);
    return run_convert(std::move(converted), stop);
  }
  replayed.trace = trace_folder(replayed.trace);
  reported.trace = trace_folder(reported.trace);
  if (*replay_command) return run_replay(replayed, stop);
  if (*report_command) return run_report(reported);
  if (*figures_command) return run_figures(figures);
  if (*modes_command) return run_modes(modes);
  return run_demo(demo, stop);
}

}  // namespace palpa::app
