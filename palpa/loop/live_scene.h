// A live scene as its loop sees it.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>

#include "palpa/loop/loop.h"

namespace palpa {

/// A session that is ready to be felt, and a second one of the same scene to rehearse with, whose modes say how long they take.
struct PreparedSession {
  PreparedSession(const Scene& scene, double encoder_step_m);

  std::vector<std::int64_t> spent_ns;  // by mode, in rehearsals
  Session felt;
  Session rehearsal;
  PreparedSession* next = nullptr;  // of those to be freed
};

/// A session on its way from the thread that made it to the loop, and back to be freed: two atomic pointers.
class LiveScene::State {
 public:
  State(const Scene& scene, const DeviceLimits& limits);
  ~State();

  // ---- any thread ----
  Scene scene() const;
  void change(const std::function<void(Scene&)>& edit);

  // ---- the loop ----
  /// The session that was set last, if none has taken it yet; else nullptr. The loop's until it gives it back.
  PreparedSession* take() noexcept { return waiting_.exchange(nullptr, std::memory_order_acq_rel); }
  /// The loop has ended: the next one begins with this session, unless another one was set.
  void put_back(PreparedSession* session) noexcept;
  /// To be freed by another thread.
  void give_back(PreparedSession* session) noexcept;

 private:
  void free_given_back() noexcept;

  mutable std::mutex mutex_;  // of those who change; the loop never takes it
  Scene scene_;
  DeviceLimits limits_;
  std::atomic<PreparedSession*> waiting_;
  std::atomic<PreparedSession*> given_back_{nullptr};
};

}  // namespace palpa
