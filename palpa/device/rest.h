// Detection of forceless motors across the two threads of a driver.
#pragma once

#include <atomic>
#include <cstdint>

namespace palpa {

/// One thread requests and numbers forces, one sends them to the motors, any thread may read. Allocates nothing and is
/// async-signal-safe.
class Rest {
 public:
  /// Call before a force is passed to the other thread. Returns its number [1], from 1.
  std::uint64_t ask(bool is_force) noexcept {
    ++asked_;
    if (is_force) last_force_.store(asked_, std::memory_order_release);
    return asked_;
  }
  /// Records that the motors received zero force while this number [1] was the latest passed, or are disconnected.
  void give_none(std::uint64_t number) noexcept { none_at_.store(number, std::memory_order_release); }
  /// Whether the motors received zero since the last force was requested.
  bool is_reached() const noexcept {
    const std::uint64_t none_at = none_at_.load(std::memory_order_acquire);
    return none_at >= last_force_.load(std::memory_order_acquire);
  }

 private:
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free, "read in a signal handler");
  std::uint64_t asked_ = 0;
  std::atomic<std::uint64_t> last_force_{0}, none_at_{0};
};

}  // namespace palpa
