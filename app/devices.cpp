#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/terminal.h"
#include "palpa/base/load_error.h"
#include "palpa/base/printed.h"
#include "palpa/device/open_device.h"
#include "palpa/study/bring_up.h"

namespace palpa::app {
namespace {

using Json = nlohmann::ordered_json;

/// Results of one kind of device.
struct Kind {
  const DeviceBackend* backend = nullptr;
  DeviceSearch search;
};

std::vector<Kind> kinds_of(const DevicesArguments& arguments) {
  std::vector<Kind> kinds;
  if (!arguments.name.empty()) {
    const DeviceDescription description = device_description(arguments.name);
    const DeviceBackend& backend = device_backend(description.name);
    kinds.push_back({&backend, backend.search(description.settings)});
    return kinds;
  }
  for (const DeviceBackend* backend : device_backends()) kinds.push_back({backend, backend->search({})});
  if (kinds.empty())
    throw LoadError("devices: this installation has no device drivers; build it with PALPA_DEVICES=ON, or install palpa again");
  return kinds;
}

void print_kind(const Kind& kind, bool with_settings) {
  print(detail::text("%s: %s\n", kind.backend->name, kind.backend->title));
  for (const FoundDevice& found : kind.search.found)
    print(detail::text("  found    %s\n           palpa run SCENE --device %s\n", found.words.c_str(),
                       found.description.c_str()));
  for (const std::string& missing : kind.search.missing) print(detail::text("  missing  %s\n", missing.c_str()));
  print(detail::text("  axes     %s\n", kind.backend->axes));
  if (!with_settings) return;
  for (const DeviceSetting& setting : kind.backend->settings())
    print(detail::text("  setting  %s: %s\n", setting.key, setting.meaning));
}

/// Limits of a present device with the user's file applied.
void print_limits(const DeviceLimits& limits) {
  const auto say = [](const char* what, double value, const char* unit) {
    if (std::isfinite(value)) print(detail::text("  limit    %s: %g %s\n", what, value, unit));
  };
  if (!limits.has_motors) {
    print("  limit    no motors: position input only, no force\n");
  } else {
    say("force", limits.max_force_n, "N");
    say("continuous force", limits.continuous_force_n, "N");
    say("stiffness", limits.max_stiffness_n_per_m, "N/m");
    say("damping", limits.max_damping_ns_per_m, "N·s/m");
  }
  print(limits.senses_turn ? "  senses   position and orientation\n" : "  senses   position\n");
  if (limits.max_torque_nm > 0.0) {
    say("torque", limits.max_torque_nm, "N·m");
    say("stiffness of turning", limits.max_turn_stiffness_nm_per_rad, "N·m/rad");
    say("damping of turning", limits.max_turn_damping_nms_per_rad, "N·m·s/rad");
  } else if (limits.senses_turn) {
    print("  limit    no motors for a torque: a tool turns freely in the hand\n");
  }
  say("workspace, about its middle", 1e3 * limits.workspace_radius_m, "mm");
  if (limits.encoder_step_m > 0.0) say("encoder step", 1e6 * limits.encoder_step_m, "µm");
  if (limits.damping_ns_per_m > 0.0) say("device damping", limits.damping_ns_per_m, "N·s/m");
}

Json json_of(const Kind& kind) {
  Json found = Json::array();
  for (const FoundDevice& device : kind.search.found)
    found.push_back({{"device", device.description}, {"words", device.words}});
  Json settings = Json::array();
  for (const DeviceSetting& setting : kind.backend->settings())
    settings.push_back({{"key", setting.key}, {"meaning", setting.meaning}});
  return {{"name", kind.backend->name},     {"title", kind.backend->title}, {"found", found},
          {"missing", kind.search.missing}, {"axes", kind.backend->axes},   {"settings", settings}};
}

/// Prompts on the terminal. False if the user skips it, or stdin is closed.
bool ask(const std::string& sentence) {
  print(detail::text("\n%s\n[Enter] when ready, s and [Enter] to leave it out: ", sentence.c_str()));
  std::fflush(stdout);
  std::string line;
  return std::getline(std::cin, line) && line.empty();
}

int set_up(const DevicesArguments& arguments, const std::atomic<bool>& stop) {
  if (arguments.name.empty())
    throw LoadError("devices: --setup needs the name of a device, as in 'palpa devices inverse3 --setup'");
  if (::isatty(STDIN_FILENO) != 1) throw LoadError("devices: --setup is interactive; run it in a terminal");
  const DeviceDescription description = device_description(arguments.name);
  const std::unique_ptr<Device> device = open_device(description);
  print(detail::text("%s\n", device->name().c_str()));
  print_limits(device->limits());
  const std::unique_ptr<LoopClock> clock = wall_clock();
  const DeviceCalibration found = bring_up(*device, *clock, ask, stop);
  print("\n");
  for (const std::string& finding : found.findings) print(finding + "\n");
  if (found.encoder_step_m || found.damping_ns_per_m) {
    DeviceNotes notes = device_notes(device_notes_file(), description.name);
    if (found.encoder_step_m) notes.encoder_step_m = found.encoder_step_m;
    if (found.damping_ns_per_m) notes.damping_ns_per_m = found.damping_ns_per_m;
    keep_device_notes(device_notes_file(), description.name, notes);
    print(detail::text("Saved in %s; every run with this device uses it.\n", device_notes_file().c_str()));
  }
  return found.has_valid_position && (found.pushes_rightly || !device->limits().has_motors) ? 0 : 1;
}

}  // namespace

int run_devices(const DevicesArguments& arguments, const std::atomic<bool>& stop) {
  if (arguments.setup) return set_up(arguments, stop);
  std::vector<Kind> kinds;
  {
    const Progress progress("searching for devices");
    kinds = kinds_of(arguments);
  }
  if (arguments.json) {
    Json all = Json::array();
    for (const Kind& kind : kinds) all.push_back(json_of(kind));
    print(detail::text("%s\n", Json{{"devices", all}, {"devices_toml", device_notes_file().string()}}
                                   .dump(2, ' ', false, Json::error_handler_t::replace)
                                   .c_str()));
    return 0;
  }
  for (std::size_t n = 0; n < kinds.size(); ++n) {
    if (n > 0) print("\n");
    print_kind(kinds[n], !arguments.name.empty());
    if (arguments.name.empty() || kinds[n].search.found.empty()) continue;
    print_limits(open_device(device_description(arguments.name))->limits());
  }
  return 0;
}

}  // namespace palpa::app
