// Quantiles as elements of the sample, without interpolation. Histograms interpolate within a class (statistics.h).
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

namespace palpa::detail {

/// Rank of a quantile among `count` > 0 numbers in rising order: the lower neighbour between two.
/// \param share  [1] 0…1
inline std::size_t rank_of(double share, std::size_t count) noexcept {
  return static_cast<std::size_t>(share * static_cast<double>(count - 1));
}

/// Quantile; 0 of no numbers. Reorders them.
/// \param share  [1] 0…1
inline double quantile(std::span<double> numbers, double share) {
  if (numbers.empty()) return 0.0;
  const auto at = numbers.begin() + static_cast<std::ptrdiff_t>(rank_of(share, numbers.size()));
  std::nth_element(numbers.begin(), at, numbers.end());
  return *at;
}

/// Median; of an even count the upper of the two middle numbers, unlike quantile(0.5). 0 of no numbers. Reorders them.
inline double median(std::span<double> numbers) {
  if (numbers.empty()) return 0.0;
  const auto middle = numbers.begin() + static_cast<std::ptrdiff_t>(numbers.size() / 2);
  std::nth_element(numbers.begin(), middle, numbers.end());
  return *middle;
}

}  // namespace palpa::detail
