// Real-time loop of a hand whose data are far.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "net/net.h"
#include "palpa/device/device.h"
#include "palpa/device/latest.h"
#include "palpa/far/hand_side.h"
#include "palpa/loop/clutch_mapping.h"
#include "palpa/loop/time_histogram.h"
#include "palpa/serve/simulated_link.h"

namespace palpa::app {

struct FarLoopOptions {
  double rate_hz = 1000.0;  ///< [100, 20000]
  double duration_s = 0.0;  ///< > 0; infinite: until stopped
  ClutchMapping::Options grip{};
  std::optional<LinkOptions> link;  ///< simulated, in front of the network, each way
};

/// Latest tick, for a terminal.
struct FarView {
  HandTick tick;
  double t_s = 0.0;
  std::int64_t missed = 0;             ///< [1] ticks so far
  const char* device_fault = nullptr;  ///< a literal
};

/// Sums over the ticks of a loop.
struct FarTotals {
  std::int64_t ticks = 0, missed = 0, models = 0, beyond = 0,
               up = 0;       ///< [1] of all; missed; models received; ticks with `beyond`; link up
  std::int64_t outages = 0;  ///< [1] losses of the link after it was up
  double longest_outage_s = 0.0, felt_s = 0.0;
  double largest_command_n = 0.0;
  double work_j = 0.0, stored_j = 0.0, sampling_j = 0.0, model_j = 0.0, link_j = 0.0,
         released_j = 0.0;  ///< sums of the ledger of HandTick; `stored_j` of the last tick
  double least_account_j = 0.0;
  double round_trips_s = 0.0;  ///< sum over ticks with the link up
  TimeHistogram late, age;     ///< of ticks; of models, with the link up
};

/// Device ↔ `HandSide` ↔ `NetClient`, in ticks with absolute deadlines, as `LiveLoop`: late ticks are skipped and counted, and
/// the next has the whole time step. Does not allocate, except for a simulated link, and blocks on the clock only.
class FarLoop {
 public:
  /// \param device, client  must outlive this object
  FarLoop(Device& device, NetClient& client, const HandSideOptions& hand, const FarLoopOptions& options);

  /// Runs on this thread until `stop` or the end of the duration; the motors then have no force.
  void run(const std::atomic<bool>& stop);
  /// After `run`; `late` at any time, by any thread.
  const FarTotals& totals() const noexcept { return totals_; }

  // Any thread, during `run`.

  /// Zero force from the next tick on, until false; then gate and ramp.
  void panic(bool on) noexcept {
    resumes_ = !on;
    panics_ = on;
  }
  /// Zero force while true.
  void hold(bool on) noexcept { is_held_ = on; }

  /// One other thread.
  const FarView& latest() noexcept { return views_.take(); }

 private:
  void tick(double t_s, double time_step_s, std::int64_t missed, bool has_to_rest) noexcept;
  void connect() noexcept;
  void give(double now_s) noexcept;
  void take(double now_s) noexcept;
  void take(std::span<const std::byte> message) noexcept;
  void count(double time_step_s) noexcept;

  Device& device_;
  NetClient& client_;
  HandSide hand_;
  const FarLoopOptions options_;
  ClutchMapping grip_;
  std::optional<SimulatedLink> there_, back_;
  std::array<std::byte, most_message_bytes> message_{};
  const bool has_motors_;
  std::uint32_t connection_ = 0;
  bool is_linked_ = true;  // with the device
  bool brakes_ = false;
  double outage_s_ = -1.0;  // since the link was up; < 0: it was not yet, or is
  FarView view_;
  FarTotals totals_;
  Latest<FarView> views_;
  std::atomic<bool> panics_{false}, resumes_{false}, is_held_{false};
};

}  // namespace palpa::app
