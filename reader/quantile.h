// The value below which a share of numbers lies.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace palpa::reader {

/// 0 of no numbers. \param share  [1] 0…1
inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace palpa::reader
