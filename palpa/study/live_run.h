// Real-time run of a scene on a thread of its own.
#pragma once

#include <atomic>
#include <memory>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "palpa/study/recording.h"
#include "palpa/study/run.h"

namespace palpa {

/// One hand of a live run; all must outlive it.
struct LiveRunHand {
  const RunOptions* options;  ///< with `live`; `options.duration_s` is in `prepared`
  PreparedRun* prepared;      ///< with the scene of this hand
  Device* device;
};

/// Haptic loop of a scene and a device on a thread of its own, from construction to `end`, recorded if `options.out` names a
/// folder. Clamps the scene to the device's limits; the trace and `prepared.notes` record it. Several hands share the loop;
/// each has a scene, a device and a trace. Owned by one other thread, that of a terminal or a window; the loop's functions
/// document their threads.
class LiveRun {
 public:
  /// \param options   with `live`; `options.duration_s` is in `prepared`
  /// \param prepared  with the scene; must outlive this object
  /// \param device    must outlive this object
  /// \param observer  may be empty; restricted like a tick
  /// Throws LoadError if the trace cannot be created, SceneError on a scene that cannot be felt.
  LiveRun(const RunOptions& options, PreparedRun& prepared, Device& device, TickObserver observer);
  /// Likewise with several hands.
  /// \param hands  at least one; the duration is the longest of theirs
  LiveRun(std::span<const LiveRunHand> hands, HandObserver observer);
  ~LiveRun();
  LiveRun(const LiveRun&) = delete;
  LiveRun& operator=(const LiveRun&) = delete;

  LiveLoop& loop() noexcept { return *loop_; }
  LiveScene& scene(std::size_t hand = 0) noexcept { return *scenes_[hand]; }
  /// Replaces a hand's scene (`LiveScene::set`). Throws SceneError, also for a tool in a recording of a point, whose files lack
  /// the columns of a tool. Any thread.
  void set_scene(const Scene& scene, std::size_t hand = 0);
  const detail::Recording& recording(std::size_t hand = 0) const noexcept { return recordings_[hand]; }
  /// Whether the loop has ended: by duration, or by request. Any thread.
  bool has_ended() const noexcept { return ended_.load(std::memory_order_acquire); }
  /// Requests the loop's end after the current tick; the motors then have no force. Safe in a signal handler.
  void tell_to_end() noexcept { ends_.store(true, std::memory_order_release); }
  /// Ends the loop, blocks until then, and passes all ticks to the recording. Later calls do nothing.
  void end();
  /// Ends the loop and completes the recording. Returns the fault of an incomplete recording (a full disk); empty: complete.
  std::string finish();
  /// Privileges that the system refused to the loop's thread, a sentence each; after `end`.
  const std::vector<std::string>& refused() const noexcept { return refused_; }
  /// [s] real duration of the loop; after `end`.
  double wall_s() const noexcept { return wall_s_; }

 private:
  static_assert(std::atomic<bool>::is_always_lock_free, "set in a signal handler");
  void lose(detail::Recording& recording, const std::exception& error);

  std::atomic<bool> ends_{false}, ended_{false};
  std::vector<std::string> refused_;
  std::string lost_;
  double wall_s_ = 0.0;
  HandObserver observer_;
  std::vector<detail::Recording> recordings_;
  std::vector<std::unique_ptr<LiveScene>> scenes_;
  std::unique_ptr<LiveLoop> loop_;
  std::thread thread_;
};

}  // namespace palpa
