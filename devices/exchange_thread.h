// Thread of a device whose exchange of force for state blocks; the haptic thread only passes values.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

#include "palpa/device/device.h"
#include "palpa/device/latest.h"
#include "palpa/device/rest.h"
#include "palpa/loop/loop.h"
#include "palpa/guard/wrench.h"

namespace palpa {

/// Exchanges as fast as the device answers, but at least `shortest_interval` apart. `Link` has
///   bool open();  // true: reopened. Called repeatedly after a loss; may block
///   void close(); // at zero force
///   DeviceState exchange(const Wrench& wrench, bool brakes);
///   bool is_lost() const;  // has to be reopened
/// and is used by this thread only. Forces older than 20 ms are not sent; states older than 50 ms are invalid.
template <class Link>
class ExchangeThread {
 public:
  explicit ExchangeThread(std::unique_ptr<Link> link) : link_(std::move(link)), thread_([this] { run(); }) {}
  ~ExchangeThread() {
    ends_ = true;
    thread_.join();
  }
  ExchangeThread(const ExchangeThread&) = delete;
  ExchangeThread& operator=(const ExchangeThread&) = delete;

  // ---- called by the haptic thread ----

  DeviceState read() noexcept {
    DeviceState state = states_.take();
    if (state.valid && seconds(Clock::now()) - state.time_s > state_lifetime_s) {
      state.valid = false;
      state.buttons = 0;
      state.fault = "the device does not answer";
    }
    return state;
  }
  /// \param most_n   [N] force limit of the device
  /// \param most_nm  [N·m] torque limit of the device; 0: it drives none
  bool write(const Wrench& wrench, double most_n, double most_nm) noexcept {
    const bool is_usable = is_finite(wrench);
    wanted_.wrench = is_usable ? Wrench{shortened(wrench.force_n, most_n), shortened(wrench.torque_nm, most_nm)} : Wrench{};
    wanted_.number = rest_.ask(wanted_.wrench != Wrench{});
    wanted_.time = Clock::now();
    wishes_.give(wanted_);
    return is_linked_.load(std::memory_order_relaxed);
  }
  bool rests() const noexcept { return rest_.is_reached(); }
  void brake(bool on) noexcept {
    wanted_.brakes = on;
    wanted_.time = Clock::now();
    wishes_.give(wanted_);
  }

 private:
  using Clock = std::chrono::steady_clock;
  struct Wish {
    Wrench wrench;
    bool brakes = false;
    std::uint64_t number = 0;
    Clock::time_point time{};
  };
  // Longer: a hung program pushes longer; shorter: a busy machine's pause drops the force.
  static constexpr std::chrono::milliseconds force_lifetime{20};
  // Longer: stale positions count; shorter: a busy machine's pause is a fault.
  static constexpr double state_lifetime_s = 0.05;
  // Between attempts to reopen. Longer: later back; shorter: more futile attempts.
  static constexpr std::chrono::milliseconds retry_interval{300};
  // Between exchanges: at most 4000 per second. Shorter: more work; longer: latency.
  static constexpr std::chrono::microseconds shortest_interval{250};

  static double seconds(Clock::time_point time) { return std::chrono::duration<double>(time.time_since_epoch()).count(); }

  void run() noexcept {
    // As urgent as the loop's thread: forces pass through both.
    const RealTimeThread real_time;
    for (bool is_open = true; !ends_;) {  // constructed with an open `link_`
      if (!is_open) {
        is_open = link_->open();
        if (!is_open) pause(retry_interval);
        continue;
      }
      const Clock::time_point begin = Clock::now();
      const Wish wish = wishes_.take();
      const bool is_fresh = begin - wish.time < force_lifetime;
      const Wrench wrench = is_fresh ? wish.wrench : Wrench{};
      DeviceState state = link_->exchange(wrench, is_fresh && wish.brakes);
      if (wrench == Wrench{} && !link_->is_lost()) rest_.give_none(wish.number);
      state.time_s = seconds(Clock::now());
      states_.give(state);
      is_linked_ = !link_->is_lost();
      if (link_->is_lost()) {
        link_->close();
        is_open = false;
      }
      std::this_thread::sleep_until(begin + shortest_interval);
    }
    link_->close();
  }
  /// Pauses while the device is lost.
  void pause(std::chrono::milliseconds longest) {
    const Clock::time_point end = Clock::now() + longest;
    while (!ends_ && Clock::now() < end) {
      rest_.give_none(wishes_.take().number);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }

  std::unique_ptr<Link> link_;
  Latest<Wish> wishes_;
  Latest<DeviceState> states_;
  Wish wanted_;  // of the haptic thread
  Rest rest_;
  std::atomic<bool> is_linked_{true};
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace palpa
