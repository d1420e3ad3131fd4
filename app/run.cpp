#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "app/commands.h"
#include "app/igtl_view.h"
#include "app/live_terminal.h"
#include "app/terminal.h"
#include "palpa/base/printed.h"
#include "palpa/scene/parts.h"
#include "palpa/study/check.h"

namespace palpa::app {
namespace {

using Json = nlohmann::ordered_json;

/// Description of the tool in the hand; null for a point.
/// \param limits  of the device
Json description_of_tool(const Scene& scene, const DeviceLimits& limits) {
  const Tool tool(scene.tool(), scene.coupling());
  if (tool.is_point()) return nullptr;
  Vec3 low_m = tool.lever_m({}, 0), high_m = low_m;
  for (std::size_t foot = 1; foot < tool.feet(); ++foot) {
    const Vec3 at_m = tool.lever_m({}, foot);
    low_m = {std::min(low_m.x, at_m.x), std::min(low_m.y, at_m.y), std::min(low_m.z, at_m.z)};
    high_m = {std::max(high_m.x, at_m.x), std::max(high_m.y, at_m.y), std::max(high_m.z, at_m.z)};
  }
  const Vec3 size_m = high_m - low_m;
  const CouplingOptions& coupling = scene.coupling();
  const double radius_m = tool.turning_radius_m(), square_m2 = radius_m * radius_m;
  return {{"shape", name_of(scene.tool().shape)},
          {"feet", tool.feet()},
          {"size_m", {size_m.x, size_m.y, size_m.z}},
          {"reach_m", tool.reach_m()},
          {"share", tool.share()},
          {"turning_radius_m", radius_m},
          {"turn_stiffness_nm_per_rad", coupling.stiffness_n_per_m * square_m2},
          {"turn_damping_nms_per_rad", coupling.turn_damping_nms_per_rad.value_or(coupling.damping_ns_per_m * square_m2)},
          {"senses_turn", limits.senses_turn},
          {"max_torque_nm", torque_limit_nm(scene, limits.max_torque_nm)}};
}

/// Description of a run, printed by `--dry-run`.
Json description(const PreparedRun& prepared, double rate_hz) {
  const Scene& scene = prepared.loaded.scene;
  Json volumes = Json::array();
  for (const SceneVolume& volume : scene.volumes()) {
    Json fields = Json::array();
    for (const VolumeField& field : volume.volume.fields) {
      Json min = Json::array(), max = Json::array();
      for (const ValueRange& extent : field.field->value_ranges()) {
        min.push_back(extent.min);
        max.push_back(extent.max);
      }
      fields.push_back(
          {{"name", field.name}, {"unit", field.unit}, {"components", field.field->components()}, {"min", min}, {"max", max}});
    }
    const Vec3 size_m = volume.volume.bounds_m().size_m();
    volumes.push_back({{"name", volume.name},
                       {"format", volume.volume.format},
                       {"size_m", {size_m.x, size_m.y, size_m.z}},
                       {"fields", fields}});
  }
  Json modes = Json::array();
  for (const SceneMode& mode : scene.modes()) {
    modes.push_back({{"name", mode.name}, {"type", mode.mode.type()}, {"enabled", mode.enabled}});
  }
  const DeviceLimits limits = prepared.real_device ? prepared.real_device->limits() : prepared.hand->limits();
  Json notes = prepared.notes;
  notes.push_back(forecast(prepared));
  return {{"title", scene.title},
          {"law", scene.law()},
          {"stiffness_n_per_m", scene.coupling().stiffness_n_per_m},
          {"damping_ns_per_m", scene.coupling().damping_ns_per_m},
          {"max_force_n", scene.coupling().max_force_n},
          {"world_m_per_hand_m", scene.hand_to_world().scale},
          {"hand", prepared.hand ? prepared.hand->name() : "yours"},
          {"device", prepared.real_device ? prepared.real_device->name() : prepared.device},
          {"duration_s", std::isfinite(prepared.duration_s) ? Json(prepared.duration_s) : Json(nullptr)},
          {"rate_hz", rate_hz},
          {"volumes", volumes},
          {"modes", modes},
          {"tool", description_of_tool(scene, limits)},
          {"notes", notes}};
}

void print_tool(const Json& tool) {
  if (tool.is_null()) return;
  const auto number = [&](const char* key) { return tool[key].get<double>(); };
  const Json& size_m = tool["size_m"];
  const auto feet = tool["feet"].get<int>();
  print(detail::text("  tool       %s: %d %s, %.4g x %.4g x %.4g m, up to %.4g m from the device's point\n",
                     tool["shape"].get<std::string>().c_str(), feet, feet == 1 ? "foot" : "feet", size_m[0].get<double>(),
                     size_m[1].get<double>(), size_m[2].get<double>(), number("reach_m")));
  print(detail::text("    foot     bears %.4g of each strength\n", number("share")));
  const std::string limit = number("max_torque_nm") > 0.0     ? detail::text("at most %.4g N·m", number("max_torque_nm"))
                            : tool["senses_turn"].get<bool>() ? std::string("no torque: the device senses turns alone")
                                                              : std::string("no torque: the hand does not turn");
  print(detail::text("    turning  radius %.4g m: %.4g N·m/rad, %.4g N·m·s/rad, %s\n", number("turning_radius_m"),
                     number("turn_stiffness_nm_per_rad"), number("turn_damping_nms_per_rad"), limit.c_str()));
}

void print_description(const Json& d) {
  const auto text = [](const Json& value) { return value.get<std::string>(); };
  const auto number = [](const Json& value) { return value.get<double>(); };
  if (!text(d["title"]).empty()) print(detail::text("%s\n", text(d["title"]).c_str()));
  print(detail::text("  coupling   %g N/m, %g N·s/m, at most %g N; law %s\n", number(d["stiffness_n_per_m"]),
                     number(d["damping_ns_per_m"]), number(d["max_force_n"]), text(d["law"]).c_str()));
  print(detail::text("  workspace  1 m of hand motion is %g m in the world\n", number(d["world_m_per_hand_m"])));
  const Json& duration_s = d["duration_s"];
  const std::string duration = duration_s.is_null() ? "until stopped" : detail::text("%g s", number(duration_s));
  print(detail::text("  hand       %s, %s at %g Hz\n", text(d["hand"]).c_str(), duration.c_str(), number(d["rate_hz"])));
  if (const std::string device = text(d["device"]); !device.empty()) print(detail::text("  device     %s\n", device.c_str()));
  for (const Json& volume : d["volumes"]) {
    const Json& size_m = volume["size_m"];
    print(detail::text("  volume     %s: %s, %.4g x %.4g x %.4g m\n", text(volume["name"]).c_str(),
                       text(volume["format"]).c_str(), number(size_m[0]), number(size_m[1]), number(size_m[2])));
    for (const Json& field : volume["fields"]) {
      print(detail::text("    field    %s", text(field["name"]).c_str()));
      for (std::size_t c = 0; c < field["min"].size(); ++c) {
        print(detail::text("%s %g … %g", c > 0 ? "," : ":", number(field["min"][c]), number(field["max"][c])));
      }
      print(detail::text(" %s\n", text(field["unit"]).c_str()));
    }
  }
  for (const Json& mode : d["modes"]) {
    print(detail::text("  mode       %s: %s%s\n", text(mode["name"]).c_str(), text(mode["type"]).c_str(),
                       mode["enabled"].get<bool>() ? "" : " (not enabled)"));
  }
  print_tool(d["tool"]);
  print("Scene is valid; dry run only.\n");
  for (const Json& note : d["notes"]) print(detail::text("%s\n", text(note).c_str()));
}

/// Result of a quick check of the scene with the described device; empty if its mechanics are unknown.
std::string verdict(const PreparedRun& prepared) {
  const std::optional<DevicePlant> plant = plant_like(prepared.device);
  return plant ? "check: " + check_quickly(prepared.loaded.scene, *plant).verdict + "; details: palpa check" : "";
}

/// Prepares the run, and prints the check's result before it starts.
PreparedRun prepared_and_checked(const RunOptions& options) {
  PreparedRun prepared = prepare(options);
  if (const std::string said = verdict(prepared); !said.empty()) tell(said + "\n");
  return prepared;
}

/// Results by the names of the hands; a single hand has none.
using Felt = std::vector<std::pair<std::string, RunResult>>;

Felt run_given(const RunArguments& given, const RunOptions& options, const std::atomic<bool>& stop) {
  Felt felt;
  if (given.hands.empty() && given.devices.empty()) {
    felt.emplace_back("", run(prepared_and_checked(options), options, &stop));
    return felt;
  }
  PreparedHands prepared = prepare_hands(options, given.hands, given.devices);
  for (std::size_t h = 0; h < prepared.runs.size(); ++h)
    if (const std::string said = verdict(prepared.runs[h]); !said.empty()) tell(prepared.names[h] + ": " + said + "\n");
  const std::vector<std::string> names = prepared.names;
  std::vector<RunResult> results = run_hands(std::move(prepared), &stop);
  for (std::size_t h = 0; h < results.size(); ++h) felt.emplace_back(names[h], std::move(results[h]));
  return felt;
}

Felt felt(const RunArguments& given, const std::atomic<bool>& stop) {
  RunOptions options = given.options;
  Progress progress(options.scene.filename().string());
  options.progress = [&](double share) { progress.show(share); };
  return run_given(given, options, stop);
}

Felt felt_live(const RunArguments& given, const std::atomic<bool>& stop) {
  RunOptions options = given.options;
  std::optional<Progress> loading(std::in_place, "loading " + options.scene.filename().string());
  std::optional<LiveTerminal> terminal;
  std::optional<IgtlView> igtl;
  if (given.igtl_port) {
    igtl.emplace(*given.igtl_port);
    tell("OpenIGTLink at 127.0.0.1:" + std::to_string(igtl->port()) + ", for clients on this machine alone\n");
    options.live->observer = [&](std::size_t hand, const TickFrame& frame, const Session& tick) {
      igtl->tick(hand, frame, tick);
    };
  }
  options.live->watch = [&](LiveLoop& loop, std::span<LiveScene* const> scenes) {
    loading.reset();
    if (!terminal) terminal.emplace();
    if (igtl) igtl->watch([&] { return scenes.front()->scene(); });
    return terminal->watch(loop, scenes);
  };
  return run_given(given, options, stop);
}

/// Prints what a run would be, of each hand.
int print_dry_run(const RunArguments& given) {
  PreparedHands prepared;
  {
    const Progress progress("loading " + given.options.scene.filename().string());
    if (given.hands.empty() && given.devices.empty()) {
      prepared.runs.push_back(prepare(given.options));
    } else {
      prepared = prepare_hands(given.options, given.hands, given.devices);
    }
  }
  Json by_hand;
  for (std::size_t h = 0; h < prepared.runs.size(); ++h) {
    print_warnings(prepared.runs[h].loaded.warnings);
    const Json what = description(prepared.runs[h], given.options.rate_hz);
    const std::string name = prepared.names.empty() ? "" : prepared.names[h];
    if (!given.json && !name.empty()) print((h > 0 ? "\n" : "") + name + "\n");
    if (!given.json) print_description(what);
    (name.empty() ? by_hand : by_hand[name]) = what;
  }
  if (given.json) print(detail::text("%s\n", by_hand.dump(2, ' ', false, Json::error_handler_t::replace).c_str()));
  return 0;
}

void print_summaries(const Felt& felt, bool as_json) {
  if (felt.size() == 1 && felt.front().first.empty()) {
    const Summary& summary = felt.front().second.summary;
    return print(as_json ? to_json(summary) : to_table(summary));
  }
  Json by_hand;
  for (std::size_t h = 0; h < felt.size(); ++h) {
    const auto& [name, result] = felt[h];
    if (as_json) {
      by_hand[name] = Json::parse(to_json(result.summary));
    } else {
      print((h > 0 ? "\n" : "") + name + "\n" + to_table(result.summary));
    }
  }
  if (as_json) print(by_hand.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace

int run_scene(RunArguments arguments, const std::atomic<bool>& stop) {
  if (!arguments.far.data_at.empty()) return run_far(arguments, stop);
  if (arguments.dry_run) return print_dry_run(arguments);
  const Felt all = arguments.options.live ? felt_live(arguments, stop) : felt(arguments, stop);
  bool is_recording_lost = false;
  for (const auto& [name, result] : all) {
    print_warnings(result.warnings);
    is_recording_lost = is_recording_lost || result.is_recording_lost;
  }
  print_summaries(all, arguments.json);
  if (const std::string out = arguments.options.out.string(); !arguments.json && !out.empty())
    print(detail::text("\nRecorded in %s\nNext: palpa report %s\n", out.c_str(), out.c_str()));
  return is_recording_lost ? 1 : 0;
}

}  // namespace palpa::app
