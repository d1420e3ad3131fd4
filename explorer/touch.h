// What the window feels a scene with: the haptic loop on its own thread, the mouse or a device, the recording.
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "explorer/sample_ring.h"
#include "palpa/device/latest.h"
#include "palpa/device/mouse_hand.h"
#include "palpa/study/live_run.h"

namespace palpa::explorer {

/// A scene that is being felt. All functions are for the window's thread.
///
/// The window's silence is watched: if `beat` does not come for `frozen_after_s`, the loop lets no force out until it comes.
class Touch {
 public:
  static constexpr double frozen_after_s = 1.0;  ///< Longer: a dead window feels alive; shorter: slow drawing takes the force

  Touch();
  ~Touch();
  Touch(const Touch&) = delete;
  Touch& operator=(const Touch&) = delete;

  /// Begins to feel; what was felt before ends. Throws LoadError where the recording cannot be had: nothing is felt then.
  /// \param device  the hand's; null: the mouse is the hand
  /// \param out     folder of the trace; empty: nothing is recorded
  void begin(const LoadedScene& loaded, std::unique_ptr<Device> device, const std::filesystem::path& out = {});
  /// Ends it. Returns why the recording is not complete; empty: it is, or there was none.
  std::string end();
  bool is_felt() const noexcept { return run_ != nullptr; }
  bool has_ended() const noexcept { return run_ && run_->has_ended(); }
  bool is_recorded() const noexcept { return run_ && !out_.empty(); }
  const std::filesystem::path& trace() const noexcept { return out_; }
  /// Whether the mouse is the hand.
  bool is_by_mouse() const noexcept { return pointer_ != nullptr; }

  /// Has the loop go on with this scene, made on a thread of its own; of several the last.
  void change(const Scene& scene);
  /// What was wrong with the last scene that could not be felt; empty: nothing. Once.
  std::string take_problem();

  // ---- the mouse's hand ----

  /// Puts the hand somewhere, with nothing felt on the way. \param at_m  hand frame
  void put_hand(const Vec3& at_m);
  /// Where the hand is to go, not faster than a hand goes. \param to_m  hand frame
  void lead_hand(const Vec3& to_m) { wanted_m_ = to_m; }
  /// Where it was told to go, hand frame [m].
  const Vec3& led_to_m() const noexcept { return wanted_m_; }
  /// Sets whether the window has the mouse (`MouseHand::have_mouse`): without it the mouse's hand feels nothing.
  void have_mouse(bool is_had);
  /// Time has passed for the window: the hand goes on, the watch is told that the window lives. \param dt_s  [s]
  void beat(double dt_s);

  // ---- what is felt ----

  LiveLoop* loop() noexcept { return run_ ? &run_->loop() : nullptr; }
  /// The latest tick with its primitives.
  const Moment& moment() noexcept { return moments_.take(); }
  SampleRing& samples() noexcept { return samples_; }
  void panic();
  void resume();
  bool is_held() const noexcept { return held_; }
  /// What the system refused to the loop's thread, and what the device bears less than the scene wants.
  const std::vector<std::string>& notes() const noexcept { return prepared_.notes; }

 private:
  void observe(const TickFrame& frame, const Session& session) noexcept;
  void make_scenes();
  void watch();

  std::filesystem::path out_;
  RunOptions options_;
  PreparedRun prepared_;
  MouseHand* pointer_ = nullptr;  ///< `device_`, where it is the mouse's
  std::unique_ptr<Device> device_;
  std::unique_ptr<LiveRun> run_;
  bool held_ = false;
  bool has_mouse_ = true;
  Vec3 wanted_m_, sent_m_;

  // From the loop.
  SampleRing samples_;
  Latest<Moment> moments_;
  std::uint64_t observed_ = 0;

  // Scenes to be felt next, made on a thread of their own; and the watch over the window.
  std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<Scene> next_;
  std::string problem_;
  bool over_ = false;
  std::atomic<std::int64_t> last_beat_ns_{0};
  std::atomic<bool> frozen_{false};
  std::thread maker_, watcher_;
};

}  // namespace palpa::explorer
