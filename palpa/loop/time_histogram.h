// Histogram of times.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace palpa {

/// Counts times in classes of equal ratio from 1 ns to 10 s, so that percentiles are good to 1 %. A single thread adds, without
/// allocating or blocking; any thread may read.
class TimeHistogram {
 public:
  void add(double time_us) noexcept;
  std::int64_t count() const noexcept { return count_.load(std::memory_order_relaxed); }
  double max_us() const noexcept { return max_us_.load(std::memory_order_relaxed); }
  double mean_us() const noexcept;
  /// Time [us] that a `share` [1] of all times does not exceed; 0 without any.
  double percentile_us(double share) const noexcept;

 private:
  // A smaller ratio needs more classes and memory for an equal range.
  static constexpr double class_ratio = 1.01;
  static constexpr std::size_t classes = 2320;

  std::array<std::atomic<std::uint32_t>, classes> counts_{};
  std::atomic<std::int64_t> count_{0};
  std::atomic<double> sum_us_{0.0};
  std::atomic<double> max_us_{0.0};
};

}  // namespace palpa
