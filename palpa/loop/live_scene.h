// Live scene, as used by its loop.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>

#include "palpa/loop/loop.h"
#include "palpa/loop/window_loader.h"

namespace palpa {

/// A session, and a second one that rehearses ticks and measures the time of each mode.
struct PreparedSession {
  PreparedSession(const Scene& scene, double encoder_step_m);

  std::vector<std::int64_t> spent_ns;  // by mode, in rehearsals
  Tool tool;
  Session felt;
  Session rehearsal;
  std::uint32_t loaded_scene = 0;   // number of the window loader; 0: no volume is larger than memory
  PreparedSession* next = nullptr;  // in the list to be freed
};

/// Passes sessions by two atomic pointers: from the thread that makes them to the loop, and back to be freed.
class LiveScene::State {
 public:
  State(const Scene& scene, const DeviceLimits& limits);
  ~State();

  // ---- any thread ----
  Scene scene() const;
  void change(const std::function<void(Scene&)>& edit);

  // ---- the loop ----
  /// Takes the session set last; nullptr: no new one. The loop owns it until `give_back`.
  PreparedSession* take() noexcept { return waiting_.exchange(nullptr, std::memory_order_acq_rel); }
  /// Stores the session at the end of a loop: the next loop starts with it, unless another was set.
  void put_back(PreparedSession* session) noexcept;
  /// Queues the session to be freed by another thread.
  void give_back(PreparedSession* session) noexcept;
  /// Loader of windows; nullptr as long as no scene has needed one.
  WindowLoader* loader() const noexcept { return loader_.load(std::memory_order_acquire); }

 private:
  std::unique_ptr<PreparedSession> prepared(const Scene& scene);
  void free_given_back() noexcept;

  mutable std::mutex mutex_;  // of the changing threads; the loop never takes it
  Scene scene_;
  DeviceLimits limits_;
  std::atomic<WindowLoader*> loader_{nullptr};
  std::atomic<PreparedSession*> waiting_;
  std::atomic<PreparedSession*> given_back_{nullptr};
};

}  // namespace palpa
