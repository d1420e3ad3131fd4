// The value below which a share of numbers lies: one of the numbers, never one between two. A histogram, which has no numbers
// any more, answers for itself (survey/statistics.h), within a class in proportion.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

namespace palpa::detail {

/// Which of `count` > 0 numbers in rising order it is: the lower neighbour where the share falls between two.
/// \param share  [1] 0…1
inline std::size_t rank_of(double share, std::size_t count) noexcept {
  return static_cast<std::size_t>(share * static_cast<double>(count - 1));
}

/// 0 of no numbers. Changes their order.
/// \param share  [1] 0…1
inline double quantile(std::span<double> numbers, double share) {
  if (numbers.empty()) return 0.0;
  const auto at = numbers.begin() + static_cast<std::ptrdiff_t>(rank_of(share, numbers.size()));
  std::nth_element(numbers.begin(), at, numbers.end());
  return *at;
}

/// The number in the middle, of an even count the upper of the two, where quantile(0.5) is the lower. 0 of no numbers. Changes
/// their order.
inline double median(std::span<double> numbers) {
  if (numbers.empty()) return 0.0;
  const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  return *middle;
}

}  // namespace palpa::detail
