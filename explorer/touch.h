// Haptic session of the window: loop on its own thread, mouse or device, recording.
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

/// [ticks] Suffices for screens at 60 Hz.
inline constexpr std::int64_t ticks_per_moment = 8;

/// A scene that is being felt. All functions are for the window's thread.
///
/// Watchdog: `frozen_after_s` after the last `beat`, or `drawn_after_s` while a picture is drawn, the force is held at zero
/// until the next `beat`.
class Touch {
 public:
  static constexpr double frozen_after_s =
      1.0;                                      ///< Longer: force despite a dead window; shorter: a busy machine cuts the force
  static constexpr double drawn_after_s = 4.0;  ///< Longer: force despite a hung driver; shorter: slow drawing cuts the force

  Touch();
  ~Touch();
  Touch(const Touch&) = delete;
  Touch& operator=(const Touch&) = delete;

  /// Starts a session; ends the previous one. Throws LoadError if the recording cannot be created; no session runs then.
  /// \param device  null: the mouse
  /// \param out     folder of the trace; empty: no recording
  void begin(const LoadedScene& loaded, std::unique_ptr<Device> device, const std::filesystem::path& out = {});
  /// Ends the session. Returns why the recording is incomplete; empty: complete, or none.
  std::string end();
  bool is_felt() const noexcept { return run_ != nullptr; }
  bool has_ended() const noexcept { return run_ && run_->has_ended(); }
  bool is_recorded() const noexcept { return run_ && !out_.empty(); }
  const std::filesystem::path& trace() const noexcept { return out_; }
  /// True if the mouse is the hand.
  bool is_by_mouse() const noexcept { return pointer_ != nullptr; }

  /// Replaces the loop's scene, prepared on a background thread; of several pending scenes the last.
  void change(const Scene& scene);
  /// Returns and clears the error of the last rejected scene; empty: none.
  std::string take_problem();

  // ---- the mouse's hand ----

  /// Moves the hand without contacts on the way. \param at_m  hand frame
  void put_hand(const Vec3& at_m);
  /// Sets the hand's target, approached at limited speed. \param to_m  hand frame
  void lead_hand(const Vec3& to_m) { wanted_m_ = to_m; }
  /// Turns the hand further, at limited speed, by a rotation vector in the hand frame [rad]. Felt with a tool.
  void turn_hand(const Vec3& rotation_rad);
  /// Sets the hand upright, for the next session.
  void set_upright() { wanted_turn_ = {}; }
  /// Target of the hand, hand frame [m].
  const Vec3& led_to_m() const noexcept { return wanted_m_; }
  /// Sets whether the window has the mouse (`MouseHand::have_mouse`): without it the mouse's hand gets no force.
  void have_mouse(bool is_had);
  /// Advances the hand and resets the watchdog. \param dt_s  [s]
  void beat(double dt_s);
  /// Begin or end of a picture, whose drawing holds up `beat`.
  void draws(bool on);

  // ---- the session ----

  LiveLoop* loop() noexcept { return run_ ? &run_->loop() : nullptr; }
  /// Latest tick with its primitives.
  const Moment& moment() noexcept { return moments_.take(); }
  SampleRing& samples() noexcept { return samples_; }
  void panic();
  void resume();
  bool is_held() const noexcept { return held_; }
  /// Real-time privileges denied to the loop's thread, and scene settings above the device's limits.
  const std::vector<std::string>& notes() const noexcept { return prepared_.notes; }

 private:
  void observe(const TickFrame& frame, const Session& session) noexcept;
  void make_scenes();
  void watch();

  std::filesystem::path out_;
  RunOptions options_;
  PreparedRun prepared_;
  MouseHand* pointer_ = nullptr;  ///< `device_`, if it is the mouse
  std::unique_ptr<Device> device_;
  std::unique_ptr<LiveRun> run_;
  bool held_ = false;
  bool has_mouse_ = true;
  Vec3 wanted_m_, sent_m_;
  Turn wanted_turn_, sent_turn_;

  // From the loop.
  SampleRing samples_;
  Latest<Moment> moments_;
  std::uint64_t observed_ = 0;

  // Pending scene, prepared by `maker_`; `watcher_` is the watchdog.
  std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<Scene> next_;
  std::string problem_;
  bool over_ = false;
  std::atomic<std::int64_t> last_beat_ns_{0};
  std::atomic<bool> frozen_{false}, drawing_{false};
  std::thread maker_, watcher_;
};

}  // namespace palpa::explorer
