#include "palpa/study/live_run.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <exception>
#include <utility>

#include "palpa/base/printed.h"
#include "palpa/base/wording.h"
#include "palpa/device/blocked_signals.h"

namespace palpa {
namespace {

/// Clamps the scene to the device's limits; reports the changes, and sets them in the trace's scene as well.
void hold_to(const DeviceLimits& limits, PreparedRun& prepared, TraceHeader& header) {
  const Scene scene = std::exchange(prepared.loaded.scene, clamped_to(prepared.loaded.scene, limits));
  const CouplingOptions& asked = scene.coupling();
  const auto tell = [&](double wanted, double taken, const std::string& key, const char* unit) {
    if (wanted == taken) return;
    const std::string text = detail::text("%s: the scene has %g %s, the device allows %g %s, which is used.", key.c_str(),
                                          wanted, unit, taken, unit);
    header.sets.emplace_back(key, detail::toml_number(taken));
    prepared.notes.push_back(text);
    header.notes.push_back(text);
  };
  const CouplingOptions& held = prepared.loaded.scene.coupling();
  const std::string of_tool = scene.hands().empty() ? "tool." : "hand." + scene.hands().front().name + ".tool.";
  tell(asked.stiffness_n_per_m, held.stiffness_n_per_m, "coupling.stiffness_n_per_m", "N/m");
  tell(asked.damping_ns_per_m, held.damping_ns_per_m, "coupling.damping_ns_per_m", "N·s/m");
  if (scene.tool() != prepared.loaded.scene.tool())
    tell(Tool(scene.tool(), asked).turning_radius_m(), *prepared.loaded.scene.tool().turning_radius_m,
         of_tool + "turning_radius_m", "m");
  if (asked.turn_damping_nms_per_rad != held.turn_damping_nms_per_rad) {
    const double radius_m = Tool(scene.tool(), asked).turning_radius_m();
    tell(asked.turn_damping_nms_per_rad.value_or(asked.damping_ns_per_m * radius_m * radius_m), *held.turn_damping_nms_per_rad,
         "coupling.turn_damping_nms_per_rad", "N·m·s/rad");
  }
}

/// Header of a live run's trace, with the scene clamped to the device's limits.
TraceHeader live_header(const RunOptions& options, PreparedRun& prepared, const DeviceLimits& limits) {
  TraceHeader header = detail::header_of(options, prepared, limits);
  hold_to(limits, prepared, header);
  header.motors = true;
  header.device_continuous_force_n = limits.continuous_force_n;
  header.device_max_damping_ns_per_m = limits.max_damping_ns_per_m;
  header.device_damping_ns_per_m = limits.damping_ns_per_m;
  header.dead_man_buttons = options.live->dead_man_buttons;
  return header;
}

LiveOptions loop_options(const RunOptions& options, const PreparedRun& prepared, const DeviceLimits& limits,
                         double duration_s) {
  LiveOptions loop{.rate_hz = options.rate_hz,
                   .duration_s = duration_s,
                   .rehearse = options.live->rehearse,
                   .guard = guard_options_for(limits, prepared.loaded.scene.coupling().max_force_n),
                   .clutch_buttons = options.live->clutch_buttons,
                   .goes_on_at_border = options.live->goes_on_at_border};
  loop.guard.dead_man_buttons = options.live->dead_man_buttons;
  return loop;
}

}  // namespace

LiveRun::LiveRun(const RunOptions& options, PreparedRun& prepared, Device& device, TickObserver observer)
    : LiveRun(std::array{LiveRunHand{&options, &prepared, &device}},
              observer ? HandObserver([of_hand = std::move(observer)](std::size_t, const TickFrame& frame,
                                                                      const Session& felt) { of_hand(frame, felt); })
                       : HandObserver{}) {}

LiveRun::LiveRun(std::span<const LiveRunHand> hands, HandObserver observer) : observer_(std::move(observer)) {
  double duration_s = 0.0;
  for (const LiveRunHand& hand : hands) duration_s = std::max(duration_s, hand.prepared->duration_s);
  std::vector<LiveHand> in_loop;
  for (const auto& [options, prepared, device] : hands) {
    const DeviceLimits limits = device->limits();
    const TraceHeader header = live_header(*options, *prepared, limits);
    const detail::Recording& recording = recordings_.emplace_back(*options, header, prepared->loaded);
    LiveScene* const scene = scenes_.emplace_back(std::make_unique<LiveScene>(prepared->loaded.scene, limits)).get();
    in_loop.push_back({scene, device, loop_options(*options, *prepared, limits, duration_s), recording.recorder()});
  }
  loop_ = std::make_unique<LiveLoop>(in_loop);
  // The watching thread handles interrupts.
  const detail::BlockedSignals in_the_loop;
  thread_ = std::thread([this] {
    const auto begin = std::chrono::steady_clock::now();
    {
      const RealTimeThread real_time;
      refused_ = real_time.refused();
      loop_->run_hands(ends_, observer_);
    }
    wall_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    ended_.store(true, std::memory_order_release);
  });
}

LiveRun::~LiveRun() { end(); }

void LiveRun::set_scene(const Scene& scene, std::size_t hand) {
  if (recordings_[hand].is_of_point() && !Tool(scene.tool(), scene.coupling()).is_point())
    throw SceneError("scene: a recording of a point has no columns for a tool; end it, and record the tool from the beginning");
  scenes_[hand]->set(scene);
}

void LiveRun::end() {
  tell_to_end();
  if (!thread_.joinable()) return;
  thread_.join();
  for (detail::Recording& recording : recordings_) {
    try {
      recording.finish_ticks();
    } catch (const std::exception& error) {
      lose(recording, error);
    }
  }
}

std::string LiveRun::finish() {
  end();
  for (detail::Recording& recording : recordings_) {
    try {
      recording.finish();
    } catch (const std::exception& error) {
      lose(recording, error);
    }
  }
  return lost_;
}

void LiveRun::lose(detail::Recording& recording, const std::exception& error) {
  lost_ = std::string(error.what()) + "; the run continued without recording; the part written before is kept";
  recording.give_up();
}

}  // namespace palpa
