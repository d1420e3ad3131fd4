// Loader of windows of volumes larger than memory, on a thread of its own.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "palpa/device/latest.h"
#include "palpa/loop/loop.h"
#include "palpa/loop/window_policy.h"
#include "palpa/scene/scene.h"

namespace palpa {

/// Makes windows about a live hand and passes them to its loop, one a tick, by one pointer. Neither blocks on the
/// other: without a window the coarser octaves are felt. Runs at a lower priority than the program, and
/// frees each window after the last session has dropped it.
class WindowLoader {
 public:
  WindowLoader();
  /// Blocks until the window in the making is done, or its source has given up.
  ~WindowLoader();
  WindowLoader(const WindowLoader&) = delete;
  WindowLoader& operator=(const WindowLoader&) = delete;

  /// Motion of the feet in a scene of `add`.
  struct Motion {
    FeetMotion feet;
    std::uint32_t loop = 0;   ///< from `begin_loop`
    std::uint32_t scene = 0;  ///< from `add`
  };
  /// Window for the loop.
  struct Loaded {
    WindowPlace place;
    OctaveWindow window;
    std::atomic<bool> is_given_back{false};
  };
  // ---- any thread ----

  /// Adds a scene with its session; returns its number. Allocates.
  std::uint32_t add(const Scene& scene, const Stock& stock);
  LoopStatistics::Windows counts() const;

  // ---- the loop's thread; no lock, no allocation ----

  /// Number of a loop whose sessions have no windows yet.
  std::uint32_t begin_loop() noexcept { return ++loops_; }
  void publish(const Motion& motion) noexcept { motion_.give(motion); }
  /// Next window, to be laid before a tick, then given back; nullptr: none.
  Loaded* take() noexcept { return inbox_.exchange(nullptr, std::memory_order_acq_rel); }
  static void give_back(Loaded* loaded) noexcept { loaded->is_given_back.store(true, std::memory_order_release); }

 private:
  /// A scene whose fields are loaded.
  struct Loading {
    std::uint32_t number;
    Scene scene;  ///< owns the fields of the policy
    WindowPolicy policy;
  };
  void run();
  bool step();
  Loading* loading_of(const Motion& motion);
  void make(Loading& loading, const WindowPlace& place);
  void note_delay(const WindowPlace* place, double now_s);
  void add_note(const std::string& sentence);
  void free_unused();

  std::uint32_t loops_ = 0;
  Latest<Motion> motion_;
  std::atomic<Loaded*> inbox_{nullptr};
  std::atomic<bool> ends_{false};

  mutable std::mutex mutex_;  // of added_ and counts_; the loop never takes it
  std::vector<std::unique_ptr<Loading>> added_;
  std::uint32_t scenes_ = 0;
  LoopStatistics::Windows counts_;

  // The loader's thread alone.
  std::unique_ptr<Loading> current_;
  std::uint32_t current_loop_ = 0;
  std::vector<std::unique_ptr<Loaded>> made_;
  std::vector<const Octaves*> failed_;
  std::vector<std::string> slow_;  ///< files that were reported
  std::map<const Octaves*, std::size_t> problems_noted_;
  double behind_since_s_ = -1.0;
  std::int64_t windows_then_ = 0;

  std::thread thread_;  // last: it uses all of the above
};

}  // namespace palpa
