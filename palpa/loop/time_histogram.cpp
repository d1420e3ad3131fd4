#include "palpa/loop/time_histogram.h"

#include <algorithm>
#include <cmath>

namespace palpa {

namespace {
// Single writer: a relaxed store suffices.
template <class Value>
void store(std::atomic<Value>& kept, Value value) noexcept {
  kept.store(value, std::memory_order_relaxed);
}
}  // namespace

void TimeHistogram::add(double time_us) noexcept {
  const double nanoseconds = std::max(1.0, 1e3 * time_us);
  const auto time_class = static_cast<std::size_t>(std::log(std::min(nanoseconds, 1e12)) / std::log(class_ratio));
  std::atomic<std::uint32_t>& counted = counts_[std::min(time_class, classes - 1)];
  store(counted, counted.load(std::memory_order_relaxed) + 1);
  store(count_, count() + 1);
  store(sum_us_, sum_us_.load(std::memory_order_relaxed) + time_us);
  store(max_us_, std::max(max_us(), time_us));
}

double TimeHistogram::mean_us() const noexcept {
  const std::int64_t all = count();
  return all > 0 ? sum_us_.load(std::memory_order_relaxed) / static_cast<double>(all) : 0.0;
}

double TimeHistogram::percentile_us(double share) const noexcept {
  std::int64_t all = 0;
  for (const auto& counted : counts_) all += counted.load(std::memory_order_relaxed);
  if (all == 0) return 0.0;
  const auto wanted = static_cast<std::int64_t>(std::ceil(share * static_cast<double>(all)));
  std::int64_t below = 0;
  for (std::size_t i = 0; i < classes; ++i) {
    below += counts_[i].load(std::memory_order_relaxed);
    if (below >= std::max<std::int64_t>(1, wanted))
      return std::min(max_us(), 1e-3 * std::pow(class_ratio, static_cast<double>(i) + 0.5));
  }
  return max_us();
}

}  // namespace palpa
