#include "app/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <memory>

#include "app/commands.h"
#include "app/hand_words.h"
#include "app/info.h"
#include "app/reference.h"
#include "app/terminal.h"
#include "palpa/file/reader_process.h"
#include "palpa/toml/wording.h"
#include "palpa/version.h"

namespace palpa::app {
namespace {

/// Splits `PATH=VALUE`. Throws LoadError. \param example  of the right form, for the message
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

void add_force(CLI::App* command, bool& force) {
  command->add_flag("--force", force, "replace files that have these names already");
}
detail::Existing existing(bool force) { return force ? detail::Existing::replaced : detail::Existing::refused; }

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

/// The folder of a trace, which may also be named by a file in it, because that is what a shell completes.
std::filesystem::path trace_folder(const std::filesystem::path& named) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(named, unknown)) return named;
  const std::filesystem::path folder = std::filesystem::absolute(named).parent_path();
  return std::filesystem::exists(folder / "trace.toml", unknown) ? folder : named;
}

/// How a file is read: what a scene's [volume] would say.
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
/// The request without the file itself: `files` holds only its partners.
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

/// What a command does after the command line has been read.
using Work = std::function<int()>;

void add_demo(CLI::App& app, Work& work, const std::atomic<bool>& stop) {
  const auto given = std::make_shared<DemoArguments>();
  CLI::App* command = app.add_subcommand("demo", "Feel a head, a flow or a wing's wake, and see what came of it");
  command->add_option("NAME", given->name, "which demo: head, flow or wing (head)")
      ->check(CLI::IsMember({"head", "flow", "wing"}))
      ->type_name("");
  command
      ->add_option(
          "--data", given->data,
          "folder of real data, felt by a recorded hand; left out: embedded data, or the head that tools/get-ct-head brought")
      ->type_name("DIR");
  command->add_option("--out", given->out, "folder for recording, report and pictures (palpa-demo)")->type_name("DIR");
  add_device(command, given->device);
  command->add_flag("--json", given->json, "print the summary as JSON; records only with --out");
  add_reader(command, given->read);
  command->footer("Example:\n  palpa demo head");
  command->callback([=, &work, &stop] { work = [=, &stop] { return run_demo(*given, stop); }; });
}

struct RunLine {
  RunArguments run;
  LiveRunOptions live;
  bool realtime = false;
  bool no_rehearsal = false;
  int clutch_button = 0, dead_man_button = 0;  // 0: none
  std::vector<std::string> sets;
  std::string hold, center, fit;
};

/// A hand of one's own is felt in real time without being told so.
void add_live(const RunLine& given, RunOptions& options) {
  const bool is_own_hand = options.hand.empty() && !options.device.empty();
  if (!given.realtime && !is_own_hand) {
    if (given.no_rehearsal || given.clutch_button > 0 || given.dead_man_button > 0 || given.live.goes_on_at_border)
      throw LoadError(
          "run: --no-rehearsal, --clutch-button, --dead-man-button and --go-on-at-border are for a run in real time; "
          "add --realtime");
    return;
  }
  const auto bit = [](int button) { return button > 0 ? 1u << (button - 1) : 0u; };
  options.live = given.live;
  options.live->rehearse = !given.no_rehearsal;
  options.live->clutch_buttons = bit(given.clutch_button);
  options.live->dead_man_buttons = bit(given.dead_man_button);
}

RunArguments arguments_of(RunLine given, int argc, char** argv) {
  RunOptions& options = given.run.options;
  add_live(given, options);
  options.arguments.assign(argv + 1, argv + argc);
  for (const std::string& set : given.sets)
    options.scene_options.sets.push_back(split_set(set, "PATH=VALUE, as in coupling.stiffness_n_per_m=500"));
  if (!given.hold.empty()) {
    options.hold = given.hold == "rigid" ? Hold::rigid : given.hold == "relaxed" ? Hold::relaxed : Hold::firm;
  }
  if (!given.fit.empty()) options.fit = given.fit == "on";
  if (!given.center.empty()) options.recording.center = given.center == "on";
  return std::move(given.run);
}

void add_run(CLI::App& app, Work& work, int argc, char** argv, const std::atomic<bool>& stop) {
  const auto given = std::make_shared<RunLine>();
  CLI::App* command = app.add_subcommand("run", "Feel a scene with your own, a recorded or a simulated hand");
  command->add_option("SCENE", given->run.options.scene, "scene file (TOML)")->required()->type_name("");
  command
      ->add_option("--hand", given->run.options.hand,
                   "a recording (CSV) or a simulated hand, sim:NAME[,KEY=VALUE,…]: see below; left out: your own, on --device")
      ->type_name("HAND");
  command
      ->add_option(
          "--hand-hold", given->hold,
          "how a hand is held: rigid (it follows the recording whatever the force, default of recordings), relaxed (default of "
          "simulated hands) or firm")
      ->check(CLI::IsMember({"rigid", "relaxed", "firm"}))
      ->type_name("HOLD");
  command
      ->add_option(
          "--device", given->run.options.device,
          "without --hand: your device, as 'palpa devices' lists it, with settings as in inverse3,port=10001; with "
          "--hand: the device that this hand holds: touch, omega, falcon, inverse3 or desktop, with values changed as in "
          "touch,delay_ticks=2 (an ideal one: no mass, friction, encoder or delay)")
      ->type_name("DEVICE");
  command->add_flag("--realtime", given->realtime, "by the clock on the wall, also with a simulated or recorded hand");
  command->add_flag("--no-rehearsal", given->no_rehearsal,
                    "in real time: do not rehearse ticks beforehand, which leaves the processor free and the ticks cold");
  command->add_option("--clutch-button", given->clutch_button, "in real time: while this button is held the handle moves alone")
      ->check(CLI::Range(1, 32))
      ->type_name("N");
  command->add_option("--dead-man-button", given->dead_man_button, "in real time: no force unless this button is held")
      ->check(CLI::Range(1, 32))
      ->type_name("N");
  command->add_flag("--go-on-at-border", given->live.goes_on_at_border,
                    "in real time: a handle at the border of its workspace takes the probe further");
  command->add_option("--hand-rate-hz", given->run.options.recording.hand_rate_hz, "rate of a recording without time")
      ->type_name("HZ");
  command
      ->add_option("--hand-center", given->center,
                   "put the middle of the recording into the middle of the workspace: on or off")
      ->check(CLI::IsMember({"on", "off"}))
      ->type_name("ON");
  command
      ->add_option("--hand-fit", given->fit,
                   "lay a recording where it feels most of the data: on or off (on, but with --hand-center; traces of ours are "
                   "never moved)")
      ->check(CLI::IsMember({"on", "off"}))
      ->type_name("ON");
  command
      ->add_option("--duration-s", given->run.options.duration_s,
                   "duration (the recording's, or 10; of your own hand: until q or an interrupt)")
      ->type_name("S");
  command->add_option("--rate-hz", given->run.options.rate_hz, "update rate: ticks per second (1000)")->type_name("HZ");
  command->add_option("--out", given->run.options.out, "record a trace into this new folder")->type_name("DIR");
  command->add_flag("--primitives", given->run.options.primitives, "record balances and primitives as well");
  add_repeated(command, "--data", given->run.options.scene_options.data_folders, "look for data here as well")
      ->type_name("DIR");
  add_repeated(command, "--set", given->sets, "change one value of the scene, as in mode.skin.friction_n=0.2")
      ->type_name("PATH=VALUE");
  add_plugins(command, given->run.options.plugins);
  command->add_flag("--dry-run", given->run.dry_run, "load and check everything, say what it is, feel nothing");
  command->add_flag("--json", given->run.json, "print the summary as JSON");
  add_reader(command, given->run.options.read);
  command->footer(hand_words() + "Example:\n  palpa run scenes/head_phantom.toml --hand sim:press --out first-trace");
  command->callback([=, &work, &stop] { work = [=, &stop] { return run_scene(arguments_of(*given, argc, argv), stop); }; });
}

void add_check(CLI::App& app, Work& work) {
  const auto given = std::make_shared<CheckArguments>();
  const auto force = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand("check", "Say whether a scene should be felt on a device, and what to change");
  command->add_option("SCENE", given->scene, "scene file (TOML)")->required()->type_name("");
  command
      ->add_option("--device", given->device,
                   "touch, omega, falcon, inverse3, desktop or a file FILE.toml, with values changed as in touch,delay_ticks=2")
      ->required()
      ->type_name("DEVICE");
  command->add_option("--fix", given->fix, "write the scene with what should change changed into this new file")
      ->type_name("OUT.toml");
  command->add_option("--picture", given->picture, "draw what stiffness and damping are stable into this new PNG file")
      ->type_name("FILE.png");
  add_force(command, *force);
  add_repeated(command, "--data", given->data_folders, "look for data here as well")->type_name("DIR");
  add_plugins(command, given->plugins);
  command->add_flag("--json", given->json, "print as JSON");
  add_reader(command, given->read);
  command->footer("Example:\n  palpa check scenes/head_phantom.toml --device touch --picture margin.png");
  command->callback([=, &work] {
    work = [=] {
      given->existing = existing(*force);
      return run_check(*given);
    };
  });
}

void add_devices(CLI::App& app, Work& work, const std::atomic<bool>& stop) {
  const auto given = std::make_shared<DevicesArguments>();
  CLI::App* command = app.add_subcommand("devices", "List the devices that are there, and what is missing for others");
  command->add_option("NAME", given->name, "one kind of device, with settings as in inverse3,port=10001 (all)")->type_name("");
  command->add_flag("--setup", given->setup, "try that device with your help, measure it, and keep what came of it");
  command->add_flag("--json", given->json, "print as JSON");
  command->footer("Example:\n  palpa devices inverse3");
  command->callback([=, &work, &stop] { work = [=, &stop] { return run_devices(*given, stop); }; });
}

void add_explore(CLI::App& app, Work& work) {
  const auto given = std::make_shared<ExploreArguments>();
  CLI::App* command = app.add_subcommand("explore", "See and feel a scene, a file or a trace in a window");
  command->add_option("FILE", given->files, "scene, data file, or trace (the start page)")->type_name("");
  add_repeated(command, "--data", given->data_folders, "folder with the files of a scene")->type_name("DIR");
  command->add_option("--device", given->device, "your haptic device, as of run (the mouse)")->type_name("NAME");
  command->footer("Example:\n  palpa explore scenes/head_phantom.toml");
  command->callback([=, &work] { work = [=] { return run_explore(*given); }; });
}

struct InfoLine {
  InfoArguments info;
  bool force = false;
  std::vector<std::string> at, at_m;
  std::string scene_file;
  HowToRead how;
};

InfoArguments arguments_of(InfoLine given, bool scene) {
  InfoArguments& info = given.info;
  info.read.preview = true;
  info.read.checksums = info.json;
  info.request = request_of(given.how);
  for (const std::string& position : given.at_m) info.places.push_back(asked_place_m(position));
  for (const std::string& place : given.at) info.places.push_back(asked_place(place));
  info.scene = scene;
  info.scene_file = given.scene_file;
  info.existing = existing(given.force);
  if (!given.scene_file.empty() && info.scene_file.extension() != ".toml") {
    throw LoadError("--scene " + given.scene_file +
                    ": is no name of a scene; write --scene OUT.toml, or put --scene behind the file");
  }
  return std::move(info);
}

void add_info(CLI::App& app, Work& work) {
  const auto given = std::make_shared<InfoLine>();
  CLI::App* command = app.add_subcommand("info", "Say what is in data files, draw it, suggest a first scene");
  command
      ->add_option("FILE", given->info.files,
                   "files or folders, each a volume of its own; a pattern in quotes, as 'phase_*.vti', is one time series")
      ->required()
      ->type_name("");
  add_repeated(command, "--at", given->at,
               "say the values there: at a voxel, as 120,200,90, at a position, as -5mm,16mm,7mm, or in the patient, as "
               "R5,A16,S7 (millimetres to the right or left, front or back, head or feet)")
      ->type_name("PLACE");
  add_repeated(command, "--at-m", given->at_m, "say the values at this position of the world, in metres")->type_name("X,Y,Z");
  command->add_flag("--series", given->info.series, "the files are the frames of one time series");
  command
      ->add_option(
          "--level", given->info.level,
          "say how much of what is thin above this value the smooth filter loses, and how far the level moves from frame "
          "to frame")
      ->type_name("VALUE");
  command->add_flag("--json", given->info.json, "print as JSON");
  CLI::Option* scene_option =
      command->add_option("--scene", given->scene_file, "suggest a first scene, printed or written into this new file")
          ->expected(0, 1)
          ->type_name("[OUT.toml]");
  command->add_option("--picture", given->info.picture, "draw slices, streamlines and histogram into this new PNG file")
      ->type_name("FILE.png");
  add_force(command, given->force);
  add_how_to_read(command, given->how);
  add_reader(command, given->info.read);
  command->footer("Example:\n  palpa info head.nrrd --at 120,200,90 --picture head.png");
  command->callback([=, &work] { work = [=] { return run_info(arguments_of(*given, scene_option->count() > 0)); }; });
}

struct ConvertLine {
  ConvertArguments convert;
  bool force = false;
  std::string in;
  HowToRead how;
};

void add_convert(CLI::App& app, Work& work, const std::atomic<bool>& stop) {
  const auto given = std::make_shared<ConvertLine>();
  CLI::App* command = app.add_subcommand("convert", "Write data as NRRD or VTI: whole, a part, coarser, or on another grid");
  command->add_option("IN", given->in, "a file or folder of data")->required()->type_name("");
  command->add_option("OUT", given->convert.out, "new file: .nrrd, .nhdr or .vti")->required()->type_name("");
  command->add_option("--crop", given->convert.crop, "only these voxels, first and last of each axis")
      ->type_name("I0:I1,J0:J1,K0:K1");
  command->add_option("--downsample", given->convert.options.downsample, "the mean of N x N x N voxels becomes one")
      ->check(CLI::Range(1, 1000))
      ->type_name("N");
  command
      ->add_option("--resample-m", given->convert.options.resample_m,
                   "onto cubes of this size along the world's axes; NaN outside the data")
      ->check(CLI::PositiveNumber)
      ->type_name("M");
  command->add_flag("--int16", given->convert.options.int16, "round to whole numbers of 16 bits");
  command->add_option("--field", given->convert.options.field, "only this field")->type_name("NAME");
  add_force(command, given->force);
  add_how_to_read(command, given->how);
  add_reader(command, given->convert.read);
  command->footer("Example:\n  palpa convert head.nrrd small.nrrd --downsample 2");
  command->callback([=, &work, &stop] {
    work = [=, &stop] {
      ConvertArguments& convert = given->convert;
      convert.options.existing = existing(given->force);
      convert.request = request_of(given->how);
      convert.request.files.insert(convert.request.files.begin(), given->in);
      return run_convert(std::move(convert), stop);
    };
  });
}

void add_replay(CLI::App& app, Work& work, const std::atomic<bool>& stop) {
  const auto given = std::make_shared<ReplayArguments>();
  CLI::App* command = app.add_subcommand("replay", "Replay a trace and compare every number");
  command->add_option("TRACE", given->trace, "folder of the trace, or a file in it")->required()->type_name("");
  add_repeated(command, "--data", given->data_folders, "look for the scene's data here first")->type_name("DIR");
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
  command->add_option("TRACE", given->trace, "folder of the trace")->required()->type_name("");
  command
      ->add_option("--beside", given->beside,
                   "compare with this trace, which has the same hand: what differs, and would it be felt")
      ->type_name("TRACE");
  command->add_option("--out", given->out, "where to write; left out: report.html in the trace, with --beside beside.html")
      ->type_name("FILE");
  command->add_option("--pictures", given->pictures, "write the pictures as PNG and SVG files into this folder, too")
      ->type_name("DIR");
  add_force(command, given->force);
  add_repeated(command, "--data", given->data_folders, "look for the scene's data here first")->type_name("DIR");
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
  CLI::App* command = app.add_subcommand(
      "export", "Write what was felt in a trace, in the frame of the data, for ParaView, 3D Slicer and tables");
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

struct MapLine {
  MapArguments map;
  bool force = false;
  std::vector<std::string> sets;
};

void add_map(CLI::App& app, Work& work, const std::atomic<bool>& stop) {
  const auto given = std::make_shared<MapLine>();
  MapArguments& map = given->map;
  CLI::App* command = app.add_subcommand("map", "Feel a scene at every place of a slice or a grid: its force field");
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
  command->add_option("--threads", map.threads, "how many cores feel (all)")->check(CLI::Range(1, 1024))->type_name("N");
  command->add_flag("--json", map.json, "print what it took as JSON");
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
      for (const std::string& set : given->sets)
        given->map.scene_options.sets.push_back(split_set(set, "PATH=VALUE, as in coupling.stiffness_n_per_m=500"));
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

void add_prints(CLI::App& app) {
  app.add_option_function<std::string>(
         "--print",
         [&app](const std::string& what) {
           print(what == "man" ? man_page(app) : bash_completion(app));
           throw CLI::Success();
         },
         "print the man page, or bash's completion, as in: source <(palpa --print bash)")
      ->check(CLI::IsMember({"man", "bash"}))
      ->type_name("WHAT");
  // Hidden: bash's completion calls it.
  app.add_option_function<std::string>("--print-sets",
                                       [](const std::string& scene) {
                                         print(settings_of(scene));
                                         throw CLI::Success();
                                       })
      ->group("");
}

/// Whoever asks for the version wants to know what is installed: the cage of files, too, where it is not whole.
void say_what_the_cage_lacks() {
  if (const std::string lacking = detail::lacking_of_cage(); !lacking.empty())
    print_warnings({"files are read in a cage that lacks a part on this system: " + lacking});
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

  Work work;
  add_demo(app, work, stop);
  add_run(app, work, argc, argv, stop);
  add_check(app, work);
  add_devices(app, work, stop);
  add_explore(app, work);
  add_info(app, work);
  add_convert(app, work, stop);
  add_replay(app, work, stop);
  add_report(app, work);
  add_export(app, work);
  add_map(app, work, stop);
  add_modes(app, work);
  add_prints(app);

  // Unknown commands are refused here, because CLI11 would say that the command is missing.
  std::vector<std::string> commands;
  for (const CLI::App* command : app.get_subcommands({})) commands.push_back(command->get_name());
  if (argc < 2) {
    print(app.help());
    return 0;
  }
  if (argv[1][0] != '-' && std::find(commands.begin(), commands.end(), argv[1]) == commands.end()) {
    print_error("command line: unknown command " + detail::in_quotes(argv[1]) + "; " + detail::suggestion(argv[1], commands));
    return 2;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // help and version
      const int code = app.exit(error);
      if (dynamic_cast<const CLI::CallForVersion*>(&error) != nullptr) say_what_the_cage_lacks();
      return code;
    }
    print_error(complaint(error, app));
    return 2;
  }
  return work();
}

}  // namespace palpa::app
