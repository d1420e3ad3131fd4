// A scene that is felt in real time, on a thread of its own.
#pragma once

#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "palpa/study/recording.h"
#include "palpa/study/run.h"

namespace palpa {

/// The haptic loop of a scene and a device on a thread of its own, from construction to `end`, recorded where `options.out`
/// names a folder. It holds the scene to what the device bears, which the trace and `prepared.notes` then tell. One other
/// thread, that of a terminal or a window, owns it; the loop's functions say which threads may call them.
class LiveRun {
 public:
  /// \param options   with `live`; `options.duration_s` is in `prepared`
  /// \param prepared  whose scene is felt; stays
  /// \param device    stays
  /// \param observer  may be empty; it must not do what a tick may not do
  /// Throws LoadError where the trace cannot be begun, SceneError on a scene that cannot be felt.
  LiveRun(const RunOptions& options, PreparedRun& prepared, Device& device, TickObserver observer);
  /// Ends it.
  ~LiveRun();
  LiveRun(const LiveRun&) = delete;
  LiveRun& operator=(const LiveRun&) = delete;

  LiveLoop& loop() noexcept { return *loop_; }
  LiveScene& scene() noexcept { return *scene_; }
  const detail::Recording& recording() const noexcept { return recording_; }
  /// Whether the loop is over: its duration was, or it was told to end. Any thread.
  bool has_ended() const noexcept { return ended_.load(std::memory_order_acquire); }
  /// Tells the loop to end after the tick under way; the motors then have no force. Of use in a signal handler.
  void tell_to_end() noexcept { ends_.store(true, std::memory_order_release); }
  /// Ends the loop, waits for it, and hands all ticks to the recording. Of later calls, none does anything.
  void end();
  /// Ends the loop and completes the recording. Returns why the recording is not complete (a full disk); empty: it is.
  std::string finish();
  /// What the system did not give to the loop's thread, a sentence each; after `end`.
  const std::vector<std::string>& refused() const noexcept { return refused_; }
  /// [s] that the loop has gone on, by the clock on the wall; after `end`.
  double wall_s() const noexcept { return wall_s_; }

 private:
  static_assert(std::atomic<bool>::is_always_lock_free, "set in a signal handler");
  void lose(const std::exception& error);

  std::atomic<bool> ends_{false}, ended_{false};
  std::vector<std::string> refused_;
  std::string lost_;
  double wall_s_ = 0.0;
  TickObserver observer_;
  detail::Recording recording_;
  std::unique_ptr<LiveScene> scene_;
  std::unique_ptr<LiveLoop> loop_;
  std::thread thread_;
};

}  // namespace palpa
