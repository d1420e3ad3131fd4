// Haptic sessions of the window: loop on its own thread, mouse or device, recording.
#pragma once

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

/// A scene that is being felt, by all its hands in one loop. All functions are for the window's thread. All lengths are in the
/// window's hand frame, the first hand's.
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

  /// Ends the session, and takes the hands of a new scene: upright, each before its own middle. The mouse leads the first.
  /// \param front_m  place along z [m], window's hand frame
  void start(const Scene& scene, double front_m);
  /// Starts a session of the scene of `start`; ends the previous one. Throws LoadError if the recording cannot be created; no
  /// session runs then.
  /// \param device  of the first hand; null: the mouse, which leads all others
  /// \param out     folder of the trace, or of several hands' traces; empty: no recording
  void begin(const LoadedScene& loaded, std::unique_ptr<Device> device, const std::filesystem::path& out = {});
  /// Ends the session. Returns why the recording is incomplete; empty: complete, or none.
  std::string end();
  bool is_felt() const noexcept { return run_ != nullptr; }
  bool has_ended() const noexcept { return run_ && run_->has_ended(); }
  bool is_recorded() const noexcept { return run_ && !out_.empty(); }
  const std::filesystem::path& trace() const noexcept { return out_; }

  // ---- the led hand, one of several ----

  std::size_t hands() const noexcept { return hands_.size(); }
  std::size_t led() const noexcept { return led_; }
  /// Lets the mouse lead this hand from now on; the others stay where they are, and go on to be felt.
  /// \param hand  below `hands`
  void lead(std::size_t hand);
  /// True if the mouse is the led hand.
  bool is_by_mouse() const noexcept { return hands_[led_]->pointer != nullptr; }

  /// Replaces the loop's scene, prepared on a background thread; of several pending scenes the last.
  void change(const Scene& scene);
  /// Returns and clears the error of the last rejected scene; empty: none.
  std::string take_problem();

  /// Moves the hand without contacts on the way.
  void put_hand(const Vec3& at_m);
  /// Sets the hand's target, approached at limited speed.
  void lead_hand(const Vec3& to_m) { hands_[led_]->wanted_m = to_m; }
  /// Turns the hand further, at limited speed, by a rotation vector [rad]. Felt with a tool.
  void turn_hand(const Vec3& rotation_rad);
  /// Target of the hand.
  const Vec3& led_to_m() const noexcept { return hands_[led_]->wanted_m; }

  // ---- the session ----

  /// Sets whether the window has the mouse (`MouseHand::have_mouse`): without it the mouse's hands get no force.
  void have_mouse(bool is_had);
  /// Advances the hands and resets the watchdog. \param dt_s  [s]
  void beat(double dt_s);
  /// Begin or end of a picture, whose drawing holds up `beat`.
  void draws(bool on);
  /// Sets the rotation from a device's axes to the hand frame (`LiveLoop::set_view_rotation`); the mouse has the screen's.
  void turn_view(const Mat3& rotation);
  LiveLoop* loop() noexcept { return run_ ? &run_->loop() : nullptr; }
  /// Latest tick of the led hand with its primitives.
  const Moment& moment() noexcept { return moment(led_); }
  /// Likewise of any hand. \param hand  below `hands`
  const Moment& moment(std::size_t hand) noexcept { return hands_[hand]->moments.take(); }
  /// Ticks of the led hand.
  SampleRing& samples() noexcept { return samples_; }
  void panic();
  void resume();
  bool is_held() const noexcept { return held_; }

 private:
  struct Hand {
    RunOptions options;
    PreparedRun prepared;
    std::unique_ptr<Device> device;
    MouseHand* pointer = nullptr;  ///< `device`, if it is the mouse
    Vec3 origin_m;                 ///< of its own frame, as the next
    Vec3 wanted_m, sent_m;
    Turn wanted_turn, sent_turn;
    Latest<Moment> moments;  ///< from the loop
    std::uint64_t observed = 0;
  };
  std::unique_ptr<Device> new_pointer(Hand& hand, const CouplingOptions& coupling) const;
  void observe(std::size_t number, const TickFrame& frame, const Session& session) noexcept;
  void make_scenes();
  void watch();

  std::filesystem::path out_;
  std::vector<std::unique_ptr<Hand>> hands_;  ///< at least one
  std::atomic<std::size_t> led_{0};
  std::unique_ptr<LiveRun> run_;
  bool held_ = false;
  bool has_mouse_ = true;
  SampleRing samples_;  ///< from the loop

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
