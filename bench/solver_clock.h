// A cheap clock for tens of nanoseconds.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

#if defined(__x86_64__)
#include <x86intrin.h>
#endif

namespace palpa::bench {

/// Counts and their length. On x86-64 the time-stamp counter (constant rate, calibrated against steady_clock), after the
/// instructions before it; elsewhere steady_clock.
class Clock {
 public:
  Clock() : ns_per_count_(calibrated()) {
    for (int i = 0; i < 10'000; ++i) {
      const std::uint64_t begin = now(), end = now(), later = now();
      own_ns_ = std::min(own_ns_, ns_between(begin, end));
      const std::uint64_t first = end - begin, second = later - end;
      if (first != second) step_ns_ = std::min(step_ns_, ns_between(0, first > second ? first - second : second - first));
    }
  }

  static std::uint64_t now() noexcept {
#if defined(__x86_64__)
    _mm_lfence();
    const std::uint64_t count = __rdtsc();
    _mm_lfence();
    return count;
#else
    return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
#endif
  }
  double ns_between(std::uint64_t begin, std::uint64_t end) const noexcept {
    return ns_per_count_ * static_cast<double>(end - begin);
  }

  /// The clock's own time [ns]: the least between two readings.
  double own_ns() const noexcept { return own_ns_; }
  /// The least difference of two measured times [ns].
  double step_ns() const noexcept { return step_ns_; }
  static const char* name() noexcept {
#if defined(__x86_64__)
    return "time-stamp counter, calibrated against steady_clock";
#else
    return "steady_clock";
#endif
  }

 private:
  static double calibrated() {
    using Steady = std::chrono::steady_clock;
    using Period = std::chrono::duration<double, std::nano>;
#if defined(__x86_64__)
    const Steady::time_point begin = Steady::now();
    const std::uint64_t count = now();
    while (Steady::now() - begin < std::chrono::milliseconds(200)) {
    }
    const std::uint64_t counts = now() - count;
    return Period(Steady::now() - begin).count() / static_cast<double>(counts);
#else
    return Period(Steady::duration(1)).count();
#endif
  }

  double ns_per_count_;
  double own_ns_ = 1e9;
  double step_ns_ = 1e9;
};

}  // namespace palpa::bench
