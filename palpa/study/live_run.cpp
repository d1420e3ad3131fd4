#include "palpa/study/live_run.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <exception>
#include <utility>

#include "palpa/base/printed.h"
#include "palpa/device/blocked_signals.h"

namespace palpa {
namespace {

/// Header of a live run's trace, with the scene clamped to the device's limits.
TraceHeader live_header(const RunOptions& options, PreparedRun& prepared, const DeviceLimits& limits) {
  TraceHeader header = detail::header_of(options, prepared, limits);
  detail::hold_to(limits, prepared, header);
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
