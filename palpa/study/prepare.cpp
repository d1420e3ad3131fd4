#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <system_error>

#include "palpa/base/limits.h"
#include "palpa/base/printed.h"
#include "palpa/device/open_device.h"
#include "palpa/loop/loop.h"
#include "palpa/mode/modes.h"
#include "palpa/mode/plugin.h"
#include "palpa/study/run.h"
#include "palpa/study/unyielding.h"

namespace palpa {
namespace {

namespace fs = std::filesystem;

constexpr double default_duration_s = 10.0;  // of a run with an endless hand. Longer: slower; shorter: less is felt

void check_numbers(const RunOptions& options) {
  if (!(options.rate_hz >= 1.0 && options.rate_hz <= 1e5)) {
    throw LoadError("rate: " + detail::text("%g", options.rate_hz) + " Hz cannot be used; a rate lies between 1 and 100000 Hz");
  }
  if (options.live && !(options.rate_hz >= 100.0 && options.rate_hz <= 20000.0)) {
    throw LoadError("rate: " + detail::text("%g", options.rate_hz) +
                    " Hz cannot be kept in real time; a rate in real time lies between 100 and 20000 Hz");
  }
  if (options.duration_s && !(*options.duration_s > 0.0 && std::isfinite(*options.duration_s))) {
    throw LoadError("duration: " + detail::text("%g", *options.duration_s) +
                    " s cannot be used; a duration is finite and above 0");
  }
}

/// Throws LoadError if the trace's folder cannot be created, before a long load. `TraceWriter` checks again at creation.
void check_out(const fs::path& out) {
  std::error_code error;
  if (fs::exists(fs::symlink_status(out, error))) {
    throw LoadError(out.string() + ": exists already; a trace goes into a new folder");
  }
  const fs::path parent = fs::absolute(out).lexically_normal().parent_path();
  if (!fs::is_directory(parent, error)) {
    throw LoadError(out.string() + ": the folder " + parent.string() + " does not exist; make it first");
  }
  if (::access(parent.c_str(), W_OK | X_OK) != 0) {
    throw LoadError(out.string() + ": the folder " + parent.string() + " cannot be written; choose another");
  }
}

/// Refuses, before it begins, a run as long as an endless recording, or one whose trace exceeds the disk. A duration set by the
/// user is not limited.
void check_duration(const PreparedRun& prepared, const RunOptions& options) {
  const double duration_s = prepared.duration_s;
  if (limit::run_s.is_passed_by(duration_s)) {
    throw LoadError(detail::text("duration: %g s are ", duration_s) + more_than(limit::run_s));
  }
  if (options.out.empty()) return;
  // Of a tick in the files of a trace. More: runs that fit are refused; less: a full disk.
  constexpr double least_bytes_per_tick = 150.0;
  std::error_code unknown;
  const fs::space_info disk = fs::space(fs::absolute(options.out).lexically_normal().parent_path(), unknown);
  const double bytes = least_bytes_per_tick * duration_s * options.rate_hz;
  if (unknown || bytes <= static_cast<double>(disk.available)) return;
  throw LoadError(options.out.string() +
                  detail::text(": a trace of %g s takes %.3g GB or more, and %.3g GB are free on its disk; make room, or end "
                               "the run earlier with --duration-s",
                               duration_s, 1e-9 * bytes, 1e-9 * static_cast<double>(disk.available)));
}

/// Formats the placement of a recording.
std::string format_placement(const RecordingPlacement& laid) {
  std::string words = "The recording was ";
  if (laid.scale != 1.0) {
    words += detail::text("made %.3g times smaller to fit a device's reach or the force limit, and ", 1.0 / laid.scale);
  }
  return words + detail::text(
                     "moved by %+.0f, %+.0f, %+.0f mm (right, up, towards the user) to the position with the longest contact; "
                     "--hand-place as_recorded keeps the recorded position.",
                     1e3 * laid.offset_m.x, 1e3 * laid.offset_m.y, 1e3 * laid.offset_m.z);
}

/// The scene with its force limited to the device's.
Scene within(Scene scene, const DevicePlant& plant) {
  if (plant.name.empty()) return scene;
  scene.edit<CouplingOptions>(
      [&](auto& coupling) { coupling.max_force_n = std::min(coupling.max_force_n, plant.limits.max_force_n); });
  return scene;
}

std::string format_stiffness(const Scene& scene, const DevicePlant& plant) {
  return detail::text(
      "device: %s is rated for up to %g N/m, the scene's coupling has %g N/m; --set coupling.stiffness_n_per_m=%g",
      plant.name.substr(0, 60).c_str(), plant.limits.max_stiffness_n_per_m, scene.coupling().stiffness_n_per_m,
      plant.limits.max_stiffness_n_per_m);
}

/// A sentence for each level stronger than the largest force at the hand, which never breaks.
std::vector<std::string> format_unyielding(const Scene& scene, double device_max_force_n) {
  const double most_n = force_limit_n(scene, device_max_force_n);
  const char* whose = device_max_force_n < scene.coupling().max_force_n ? "the device's limit" : "coupling.max_force_n";
  std::vector<std::string> sentences;
  for (const UnyieldingLevel& level : unyielding_levels(scene, most_n)) {
    sentences.push_back(
        detail::text("The level %.60s of '%.60s' holds up to %g N, but at most %g N reach the hand (%s): it cannot be pressed "
                     "through, except within four voxels of the end of its data.",
                     level.name.c_str(), scene.modes()[level.mode].name.c_str(), level.strength_n, most_n, whose));
  }
  return sentences;
}

}  // namespace

namespace {

std::unique_ptr<Device> opened_device(const RunOptions& options) {
  const fs::path& notes = options.live->devices_toml;
  return open_device(device_description(options.device), notes.empty() ? device_notes_file() : notes);
}

/// Prepares a run with a person's hand.
PreparedRun held(std::unique_ptr<Device> device, LoadedScene loaded, const RunOptions& options) {
  PreparedRun prepared;
  prepared.loaded = std::move(loaded);
  prepared.notes = prepared.loaded.notes;
  prepared.real_device = std::move(device);
  prepared.device = options.device;
  const DeviceLimits limits = prepared.real_device->limits();
  for (std::string& sentence : format_unyielding(prepared.loaded.scene, limits.max_force_n))
    prepared.notes.push_back(std::move(sentence));
  prepared.duration_s = options.duration_s.value_or(std::numeric_limits<double>::infinity());
  return prepared;
}

/// Hand without a person, before its placement.
struct SoughtHand {
  DevicePlant plant;
  std::optional<SimulatedMotion> motion;  ///< else `target`
  std::shared_ptr<const Target> target;
};

/// Place of the options; by default the recording's own.
Place place_of(const RunOptions& options, const Target& target) {
  if (options.place) return *options.place;
  if (options.recording.center) return *options.recording.center ? Place::centred : Place::as_recorded;
  return target.has_own_placement() ? Place::as_recorded : Place::fitted;
}

SoughtHand sought_hand(const RunOptions& options) {
  SoughtHand hand;
  if (!options.device.empty()) hand.plant = device_plant(options.device);
  if (options.target) {
    hand.target = options.target;
  } else if (options.hand.starts_with("sim:")) {
    hand.motion = simulated_motion(options.hand);
  } else {
    RecordingOptions recording = options.recording;
    if (options.place) recording.center = *options.place != Place::as_recorded;
    hand.target = recorded_target(options.hand, recording);
  }
  return hand;
}

/// Places the hand in the scene, in contact.
PreparedRun placed(const SoughtHand& hand, LoadedScene loaded, const RunOptions& options) {
  PreparedRun prepared;
  prepared.loaded = std::move(loaded);
  prepared.notes = prepared.loaded.notes;
  prepared.device = hand.plant.name;
  prepared.target = hand.target;
  if (prepared.target) {
    for (const std::string& warning : prepared.target->warnings())
      prepared.loaded.warnings.push_back((options.target ? "hand" : options.hand) + ": " + warning);
  }

  const Scene& scene = prepared.loaded.scene;
  const Hold hold = options.hold.value_or(hand.motion ? Hold::relaxed : Hold::rigid);
  const bool fits = !hand.motion && !options.target && place_of(options, *prepared.target) == Place::fitted;
  if (hand.motion || fits) {
    prepared.reach.emplace(within(scene, hand.plant), [&](double share) {
      if (options.progress) options.progress(reach_progress * share);
    });
  }
  if (hand.motion) {
    prepared.target = prepared.reach->is_empty()
                          ? simulated_target(*hand.motion)
                          : simulated_target(*hand.motion, prepared.reach->encounter(*hand.motion, hold));
  } else if (prepared.reach && !prepared.reach->is_empty()) {
    const RecordingPlacement laid = prepared.reach->place_recording(prepared.target, hold);
    prepared.target = displaced(prepared.target, laid.offset_m, laid.scale);
    prepared.laid = laid;
    prepared.notes.push_back(format_placement(laid));
  }
  if (!hand.motion && !options.target && !prepared.laid && !prepared.target->has_own_placement())
    prepared.remedy = "--hand-place fitted";
  prepared.is_rigid_hand = !hand.motion && hold == Hold::rigid;
  prepared.hand = hand_device(prepared.target, hold, hand.plant);
  if (!hand.plant.name.empty()) {
    prepared.notes.push_back("The hand holds a device, " + hand.plant.name + ": " + format_plant(hand.plant) + ".");
    if (scene.coupling().stiffness_n_per_m > hand.plant.limits.max_stiffness_n_per_m)
      prepared.loaded.warnings.push_back(format_stiffness(scene, hand.plant));
  }
  for (std::string& sentence : format_unyielding(scene, prepared.hand->limits().max_force_n))
    prepared.notes.push_back(std::move(sentence));
  const double hand_s = prepared.target->duration_s();
  prepared.duration_s = options.duration_s.value_or(std::isfinite(hand_s) ? hand_s : default_duration_s);
  prepared.ends_with_row = !hand.motion && !options.duration_s && std::isfinite(hand_s);
  if (!options.duration_s) check_duration(prepared, options);
  return prepared;
}

}  // namespace

namespace {

/// Throws LoadError on all faults detectable before the scene is loaded.
void check(const RunOptions& options) {
  check_numbers(options);
  if (options.hand.empty() && !options.target && (!options.live || options.device.empty())) {
    throw LoadError(
        "hand: none was named; give --hand a recording or sim:press|stroke|circle|helix|random, or use your own with --device "
        "NAME");
  }
  if (!options.out.empty()) check_out(options.out);
}

/// \param scene  called after device or hand are opened
PreparedRun prepared_with(const std::function<LoadedScene()>& scene, const RunOptions& options) {
  check(options);
  if (options.hand.empty() && !options.target) {
    std::unique_ptr<Device> device = opened_device(options);
    return held(std::move(device), scene(), options);
  }
  const SoughtHand hand = sought_hand(options);
  return placed(hand, scene(), options);
}

LoadedScene loaded_scene(const RunOptions& options) {
  ReadOptions read = options.read;
  read.checksums = options.out.empty() ? Checksums::none : Checksums::later;
  SceneOptions scene_options = options.scene_options;
  scene_options.thin_parts = true;  // warns of a wall with holes before the run
  return load_scene(options.scene, volume_reader(read), modes_with(options.plugins), scene_options);
}

/// "2 hands (left, right)".
std::string format_hands(const Scene& scene) {
  std::string names;
  for (const SceneHand& hand : scene.hands()) names += (names.empty() ? "" : ", ") + hand.name;
  if (scene.hands().size() < 2) return "one hand" + (names.empty() ? names : " (" + names + ")");
  return std::to_string(scene.hands().size()) + " hands (" + names + ")";
}

std::string too_few_hands(const fs::path& scene_file, const Scene& scene, std::size_t given) {
  return scene_file.string() + ": the scene has " + format_hands(scene) + ", and " + std::to_string(given) +
         (given == 1 ? " is" : " are") +
         " given; give each a --hand or --device, in this order or as NAME=…, or feel one: --set only_hand=" +
         scene.hands().front().name;
}

/// Values of an option by hand of the scene; empty: none.
std::vector<std::string> by_hand(const std::vector<std::string>& given, const char* option, const fs::path& scene_file,
                                 const Scene& scene) {
  const std::vector<SceneHand>& hands = scene.hands();
  if (given.size() > hands.size()) {
    throw LoadError(scene_file.string() + ": the scene has " + format_hands(scene) + ", and " + std::to_string(given.size()) +
                    " " + option + (given.size() == 1 ? " by name is given;" : " are given;") +
                    " add a [[hand]] for each, or give fewer");
  }
  std::vector<std::string> by(hands.size()), unnamed;
  for (const std::string& one : given) {
    const auto named = std::ranges::find_if(hands, [&](const SceneHand& hand) { return one.starts_with(hand.name + "="); });
    if (named == hands.end()) {
      unnamed.push_back(one);
      continue;
    }
    std::string& its = by[static_cast<std::size_t>(named - hands.begin())];
    if (!its.empty())
      throw LoadError(std::string("run: ") + option + " is given twice for hand " + named->name + "; give it once");
    its = one.substr(named->name.size() + 1);
  }
  auto next = by.begin();
  for (std::string& one : unnamed) {
    while (!next->empty()) ++next;
    *next = std::move(one);
  }
  return by;
}

}  // namespace

const char* name_of(Place place) noexcept {
  switch (place) {
    case Place::as_recorded: return "as_recorded";
    case Place::centred: return "centred";
    case Place::fitted: break;
  }
  return "fitted";
}

Place place_by_fit(const RunOptions& options, bool is_fitted) {
  if (recorded_target(options.hand, options.recording)->has_own_placement()) return Place::as_recorded;
  return is_fitted ? Place::fitted : Place::centred;
}

PreparedRun prepare(const RunOptions& options) {
  return prepared_with(
      [&] {
        LoadedScene loaded = loaded_scene(options);
        if (loaded.scene.hands().size() > 1) throw LoadError(too_few_hands(options.scene, loaded.scene, 1));
        return loaded;
      },
      options);
}

PreparedHands prepare_hands(const RunOptions& options, const std::vector<std::string>& hands,
                            const std::vector<std::string>& devices) {
  check_numbers(options);
  if (!options.out.empty()) check_out(options.out);
  const LoadedScene loaded = loaded_scene(options);
  const std::vector<SceneHand>& all = loaded.scene.hands();
  const std::vector<std::string> given = by_hand(hands, "--hand", options.scene, loaded.scene);
  const std::vector<std::string> held = by_hand(devices, "--device", options.scene, loaded.scene);
  if (all.empty()) throw LoadError(options.scene.string() + ": the scene has no [[hand]]; run it with one hand, or add them");
  const auto is_given = [&](std::size_t h) { return !given[h].empty() || !held[h].empty(); };
  PreparedHands prepared;
  for (std::size_t h = 0; h < all.size(); ++h) {
    if (!is_given(h)) {
      std::size_t count = 0;
      for (std::size_t other = 0; other < all.size(); ++other) count += is_given(other) ? 1 : 0;
      throw LoadError(too_few_hands(options.scene, loaded.scene, count));
    }
    if (given[h].empty() && !options.live)
      throw LoadError("run: hand " + all[h].name + " is a person's, on --device, which is felt in real time; add --realtime");
    RunOptions one = options;
    one.hand = given[h];
    one.device = held[h];
    one.target = nullptr;
    one.out.clear();  // its folder is made by the run
    one.scene_options.sets.emplace_back("only_hand", all[h].name);
    one.progress = {};
    if (options.progress) {
      const auto before = static_cast<double>(h), count = static_cast<double>(all.size());
      one.progress = [=, &options](double share) { options.progress((reach_progress * before + share) / count); };
    }
    LoadedScene of_hand{loaded.scene.of_hand(h), loaded.text, h == 0 ? loaded.warnings : std::vector<std::string>{},
                        loaded.notes};
    prepared.runs.push_back(prepare(std::move(of_hand), one));
    if (!options.out.empty()) one.out = options.out / all[h].name;
    one.progress = h == 0 ? options.progress : std::function<void(double)>{};
    prepared.names.push_back(all[h].name);
    prepared.options.push_back(std::move(one));
  }
  return prepared;
}

PreparedRun prepare(LoadedScene loaded, const RunOptions& options) {
  return prepared_with([&] { return std::move(loaded); }, options);
}

std::string forecast(const PreparedRun& prepared) {
  if (!prepared.target) return "No forecast: the hand is yours.";
  constexpr int most = 2048;  // [1] positions of the path. More: slower; fewer: a coarser share
  std::vector<Vec3> places_m;
  for (int n = 0; n < most; ++n) {
    const Target::Point point = prepared.target->at(n * prepared.duration_s / most);
    if (point.valid) places_m.push_back(point.position_m);
  }
  const Reach reach = prepared.reach ? *prepared.reach : Reach(prepared.loaded.scene);
  const double share = reach.felt_share(places_m);
  const std::string words = detail::text("About %.0f %% of the hand's path is in contact.", 100.0 * share);
  if (share >= little_contact) return words;
  return (share > 0.0 ? words : "Nothing will be felt.") + " " + explain_little_contact(reach, places_m, prepared.remedy);
}

}  // namespace palpa
