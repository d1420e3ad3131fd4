// Command lines that run a hand in a scene.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include "app/command_lines.h"
#include "app/commands.h"
#include "app/hand_words.h"
#include "app/options.h"
#include "app/terminal.h"
#include "palpa/base/load_error.h"
#include "palpa/base/wording.h"

namespace palpa::app {

void add_demo(CLI::App& app, Work& work, const std::atomic<bool>& stop) {
  const auto given = std::make_shared<DemoArguments>();
  CLI::App* command = app.add_subcommand("demo", "Feel a head, a flow or a wing's wake, and make its report");
  command->add_option("NAME", given->name, "which demo: head, flow or wing (head)")
      ->check(CLI::IsMember({"head", "flow", "wing"}))
      ->type_name("");
  command
      ->add_option("--data", given->data,
                   "folder of real data, felt by a recorded hand (embedded data, or the head of tools/get-ct-head)")
      ->type_name("DIR");
  command->add_option("--out", given->out, "folder for recording, report and pictures (palpa-demo)")->type_name("DIR");
  add_device(command, given->device);
  command->add_flag("--json", given->json, "print the summary as JSON; records only with --out");
  add_reader(command, given->read);
  command->footer("Example:\n  palpa demo head");
  command->callback([=, &work, &stop] { work = [=, &stop] { return run_demo(*given, stop); }; });
}

namespace {

struct RunLine {
  RunArguments run;
  LiveRunOptions live;
  bool realtime = false;
  bool no_rehearsal = false;
  int clutch_button = 0, dead_man_button = 0;  // 0: none
  std::vector<std::string> hands, devices, sets;
  std::string hold, place, center, fit;
  int igtl_port = -1;  // none
};

/// NAME of `NAME=HAND` or `NAME=DEVICE`; empty without.
std::string name_in(const std::string& given) {
  const std::size_t at = given.find('=');
  std::error_code unknown;
  if (at == std::string::npos || std::filesystem::exists(given, unknown)) return {};
  const std::string name = given.substr(0, at);
  return detail::is_plain_word(name) ? name : std::string();
}

/// Whether a device is surely a person's: there are more than hands, or it has a name that no hand has, and all have one. Which
/// hands the others fill is up to the scene.
bool has_own_hand(const RunLine& given) {
  if (given.devices.size() > given.hands.size()) return true;
  std::vector<std::string> names;
  for (const std::string& hand : given.hands) names.push_back(name_in(hand));
  if (std::ranges::find(names, std::string()) != names.end()) return false;
  return std::ranges::any_of(
      given.devices, [&](const std::string& device) { return std::ranges::find(names, name_in(device)) == names.end(); });
}

/// One hand without a name goes without `prepare_hands`.
void add_hands(RunLine& given) {
  const auto is_named = [](const std::string& one) { return !name_in(one).empty(); };
  if (given.hands.size() > 1 || given.devices.size() > 1 || std::ranges::any_of(given.hands, is_named) ||
      std::ranges::any_of(given.devices, is_named)) {
    given.run.hands = given.hands;
    given.run.devices = given.devices;
    return;
  }
  if (!given.hands.empty()) given.run.options.hand = given.hands.front();
  if (!given.devices.empty()) given.run.options.device = given.devices.front();
}

/// A device without a hand implies real time.
void add_live(const RunLine& given, RunOptions& options) {
  if (!given.realtime && !has_own_hand(given)) {
    if (given.no_rehearsal || given.clutch_button > 0 || given.dead_man_button > 0 || given.live.goes_on_at_border ||
        given.igtl_port >= 0)
      throw LoadError(
          "run: --no-rehearsal, --clutch-button, --dead-man-button, --go-on-at-border and --igtl are for a run in real time; "
          "add --realtime");
    return;
  }
  const auto bit = [](int button) { return button > 0 ? 1u << (button - 1) : 0u; };
  options.live = given.live;
  options.live->rehearse = !given.no_rehearsal;
  options.live->clutch_buttons = bit(given.clutch_button);
  options.live->dead_man_buttons = bit(given.dead_man_button);
}

/// Placement of a recording; values of earlier versions are accepted with a warning that names the new one.
std::optional<Place> place_of(const RunLine& given) {
  const auto place_named = [](const std::string& word) {
    return word == "fitted" ? Place::fitted : word == "centred" ? Place::centred : Place::as_recorded;
  };
  // CLI11's errors have no name for a hidden option.
  for (const auto& [option, value] : {std::pair("--hand-center", given.center), std::pair("--hand-fit", given.fit)}) {
    if (!value.empty() && value != "on" && value != "off") {
      throw LoadError(std::string("run: ") + option + " cannot be " + detail::in_quotes(value) + "; there are: on, off");
    }
  }
  const bool has_old = !given.fit.empty() || !given.center.empty();
  if (!given.place.empty()) {
    if (has_old) throw LoadError("run: --hand-place says where the recording lies; leave out --hand-fit and --hand-center");
    return place_named(given.place);
  }
  const std::string& hand = given.run.options.hand;
  if (!has_old || hand.empty() || hand.starts_with("sim:")) return {};
  const Place place = given.center.empty() || given.fit == "on" ? place_by_fit(given.run.options, given.fit == "on")
                                                                : place_named(given.center == "on" ? "centred" : "as_recorded");
  print_warnings({std::string(given.fit.empty() ? "--hand-center" : "--hand-fit") + ": is called --hand-place " +
                  name_of(place) + " now"});
  return place;
}

RunArguments arguments_of(RunLine given, int argc, char** argv) {
  RunOptions& options = given.run.options;
  check_data_at(given.run.far, "run");
  if (given.run.far.data_at.empty() && options.scene.empty()) throw LoadError("run: SCENE is required; see 'palpa run --help'");
  add_hands(given);
  given.realtime = given.realtime || !given.run.far.data_at.empty();
  add_live(given, options);
  options.arguments.assign(argv + 1, argv + argc);
  if (given.igtl_port >= 0) given.run.igtl_port = static_cast<std::uint16_t>(given.igtl_port);
  options.scene_options.sets = split_sets(given.sets);
  if (!given.hold.empty()) {
    options.hold = given.hold == "rigid" ? Hold::rigid : given.hold == "relaxed" ? Hold::relaxed : Hold::firm;
  }
  options.place = place_of(given);
  return std::move(given.run);
}

void add_realtime(CLI::App* command, RunLine& given) {
  command->add_flag("--realtime", given.realtime, "run in real time, also with a simulated or recorded hand");
  command->add_flag("--no-rehearsal", given.no_rehearsal,
                    "in real time: skip the rehearsal of ticks, which saves processor time but leaves caches cold");
  command->add_option("--clutch-button", given.clutch_button, "in real time: while this button is held the handle moves alone")
      ->check(CLI::Range(1, 32))
      ->type_name("N");
  command->add_option("--dead-man-button", given.dead_man_button, "in real time: no force unless this button is held")
      ->check(CLI::Range(1, 32))
      ->type_name("N");
  command->add_flag("--go-on-at-border", given.live.goes_on_at_border,
                    "in real time: a handle at the border of its workspace moves the probe on");
  command
      ->add_option(
          "--igtl", given.igtl_port,
          "in real time: show probe, proxy and events to 3D Slicer and other clients of OpenIGTLink on this machine, at "
          "this port; 18944 is usual, 0 is any that is free")
      ->check(CLI::Range(0, 65535))
      ->type_name("PORT");
}

}  // namespace

void add_run(CLI::App& app, Work& work, int argc, char** argv, const std::atomic<bool>& stop) {
  const auto given = std::make_shared<RunLine>();
  CLI::App* command = app.add_subcommand("run", "Feel a scene with your own, a recorded or a simulated hand");
  command->add_option("SCENE", given->run.options.scene, "scene file (TOML); with --data-at it only places a hand")
      ->type_name("");
  add_repeated(
      command, "--hand", given->hands,
      "a recording (CSV) or a simulated hand, sim:NAME[,KEY=VALUE,…]: see below; left out: your own, on --device. Of a "
      "scene of several hands one for each, in its order or as NAME=HAND")
      ->type_name("HAND");
  command
      ->add_option(
          "--hand-hold", given->hold,
          "how a hand is held: rigid (it follows the recording at any force, default of recordings), relaxed (default of "
          "simulated hands) or firm")
      ->check(CLI::IsMember({"rigid", "relaxed", "firm"}))
      ->type_name("HOLD");
  add_repeated(command, "--device", given->devices,
               "without --hand: your device, as 'palpa devices' lists it, with settings as in inverse3,port=10001; with "
               "--hand: the device that this hand holds: touch, omega, falcon, inverse3 or desktop, with values changed as in "
               "touch,delay_ticks=2 (an ideal one: no mass, friction, encoder or delay). Of several hands as --hand")
      ->type_name("DEVICE");
  add_realtime(command, *given);
  add_data_at(command, given->run.far, "feel the data that palpa serve has there, in real time");
  command
      ->add_option("--link", given->run.far.link,
                   "with --data-at: a simulated link in between, as in delay_ms=20,jitter_ms=3,loss=0.01")
      ->type_name("LINK");
  command->add_flag("--datagrams", given->run.far.datagrams,
                    "with --data-at: probes and models by UDP, unencrypted, if palpa serve --datagrams is there");
  command->add_flag("--far-anyway", given->run.far.far_anyway, "with --data-at: also beyond 20 ms one way");
  command->add_option("--hand-rate-hz", given->run.options.recording.hand_rate_hz, "rate of a recording without time")
      ->type_name("HZ");
  command
      ->add_option("--hand-place", given->place,
                   "position of a recording: fitted (the longest contact with the data, default of all but the columns of a "
                   "ticks.csv), centred (the middle of its box in the middle of the workspace) or as_recorded")
      ->check(CLI::IsMember({"as_recorded", "centred", "fitted"}))
      ->type_name("PLACE");
  // Names of earlier versions.
  command->add_option("--hand-center", given->center)->group("");
  command->add_option("--hand-fit", given->fit)->group("");
  command
      ->add_option("--duration-s", given->run.options.duration_s,
                   "duration (the recording's, or 10; of your own hand: until q or an interrupt)")
      ->type_name("S");
  command->add_option("--rate-hz", given->run.options.rate_hz, "update rate: ticks per second (1000)")->type_name("HZ");
  command->add_option("--out", given->run.options.out, "record a trace into this new folder")->type_name("DIR");
  command->add_flag("--primitives", given->run.options.primitives, "record balances and primitives as well");
  add_repeated(command, "--data", given->run.options.scene_options.data_folders, "also search this folder for data")
      ->type_name("DIR");
  add_repeated(command, "--set", given->sets, "change one value of the scene, as in mode.skin.friction_n=0.2")
      ->type_name("PATH=VALUE");
  add_plugins(command, given->run.options.plugins);
  command->add_flag("--dry-run", given->run.dry_run, "load and check everything, print a summary, run no tick");
  command->add_flag("--json", given->run.json, "print the summary as JSON");
  add_reader(command, given->run.options.read);
  command->footer(hand_words() + "Example:\n  palpa run scenes/head_phantom.toml --hand sim:press --out first-trace");
  command->callback([=, &work, &stop] { work = [=, &stop] { return run_scene(arguments_of(*given, argc, argv), stop); }; });
}

void add_devices(CLI::App& app, Work& work, const std::atomic<bool>& stop) {
  const auto given = std::make_shared<DevicesArguments>();
  CLI::App* command = app.add_subcommand("devices", "List connected devices, and missing requirements of others");
  command->add_option("NAME", given->name, "one kind of device, with settings as in inverse3,port=10001 (all)")->type_name("");
  command->add_flag("--setup", given->setup, "measure that device with your help and save the result");
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
  command->add_option("--screenshot", given->screenshot, "save the window as a picture once it is drawn")->type_name("PNG");
  command->add_option("--quit-after-s", given->quit_after_s, "close the window after this time")->type_name("S");
  command->footer("Example:\n  palpa explore scenes/head_phantom.toml");
  command->callback([=, &work] { work = [=] { return run_explore(*given); }; });
}

}  // namespace palpa::app
