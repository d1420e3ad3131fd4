#include "palpa/file/store_histogram.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <vector>

#include "palpa/file/protocol_voxels.h"

namespace palpa::detail {
namespace {

// Of a class's width, where all numbers are equal or zero. More: such numbers have wide classes; less: numbers of classes do
// not fit into a double.
constexpr int digits = 40;             // [bits] of the largest number
constexpr int least_exponent = -1000;  // of zeros
constexpr int largest_exponent = 1023;

/// Number of the class of width 2^exponent · 2^steps in which a class of width 2^exponent lies.
std::int64_t coarser(std::int64_t number, int steps) noexcept { return number >> std::min(steps, 63); }

/// Number of a value's class, downwards rounded. \param width_inverse  a power of two
std::int64_t class_of(double value, double width_inverse) noexcept {
  const double at = value * width_inverse;
  const auto number = static_cast<std::int64_t>(at);
  const bool is_below = static_cast<double>(number) > at || (number == 0 && value < 0.0);  // also where `at` underflows
  return number - (is_below ? 1 : 0);
}

template <class T>
constexpr bool is_whole = !std::is_floating_point_v<T>;

}  // namespace

bool is_of_whole_numbers(VoxelType type, int components) noexcept {
  return components == 1 && type != VoxelType::float32 && type != VoxelType::float64;
}

void DyadicHistogram::hold(std::int64_t first, std::int64_t last, int exponent) noexcept {
  const bool is_empty = last_ < first_;
  int wider = is_empty ? exponent : std::max(exponent, exponent_);
  const auto low = [&] {
    return std::min(coarser(first, wider - exponent), is_empty ? INT64_MAX : coarser(first_, wider - exponent_));
  };
  const auto high = [&] {
    return std::max(coarser(last, wider - exponent), is_empty ? INT64_MIN : coarser(last_, wider - exponent_));
  };
  while (high() - low() >= most_classes) ++wider;
  const std::int64_t from = low(), to = high();
  if (is_empty || wider != exponent_ || from != first_) {
    const std::array<std::int64_t, most_classes> before = counts_;
    counts_.fill(0);
    for (std::int64_t n = first_; n <= last_; ++n)
      counts_[static_cast<std::size_t>(coarser(n, wider - exponent_) - from)] += before[static_cast<std::size_t>(n - first_)];
  }
  exponent_ = wider, first_ = from, last_ = to;
}

template <class T>
void DyadicHistogram::add_numbers(int components, const T* row, std::int64_t voxels) noexcept {
  if constexpr (is_whole<T>) {
    if (components == 1) {
      T low = row[0], high = row[0];
      for (std::int64_t n = 1; n < voxels; ++n) low = std::min(low, row[n]), high = std::max(high, row[n]);
      hold(low, high, 0);
      for (std::int64_t n = 0; n < voxels; ++n)
        ++counts_[static_cast<std::size_t>((static_cast<std::int64_t>(row[n]) >> exponent_) - first_)];
      return;
    }
  }
  const auto value = [&](std::int64_t n) {
    const T* const at = row + n * components;
    if (components == 1) return static_cast<double>(*at);
    const double x = static_cast<double>(at[0]), y = static_cast<double>(at[1]), z = static_cast<double>(at[2]);
    return std::sqrt(x * x + y * y + z * z);
  };
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (std::int64_t n = 0; n < voxels; ++n) {
    const double v = value(n);
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  }
  if (low > high) return;
  const double largest = std::max(std::abs(low), std::abs(high));
  const int exponent = largest > 0.0 ? std::max(std::ilogb(largest) - digits, least_exponent) : least_exponent;
  hold(class_of(low, std::ldexp(1.0, -exponent)), class_of(high, std::ldexp(1.0, -exponent)), exponent);
  const double width_inverse = std::ldexp(1.0, -exponent_);
  for (std::int64_t n = 0; n < voxels; ++n) {
    const double v = value(n);
    if (std::isfinite(v)) ++counts_[static_cast<std::size_t>(class_of(v, width_inverse) - first_)];
  }
}

void DyadicHistogram::add(const VoxelKind& kind, const VoxelBlock& block, const VoxelIndex& low, const VoxelIndex& size) {
  VoxelIndex count{};
  for (std::size_t a = 0; a < 3; ++a) count[a] = std::clamp<std::int64_t>(block.valid[a] - low[a], 0, size[a]);
  if (count[0] == 0) return;
  protocol::with_type(kind.type, [&](auto number) {
    using T = decltype(number);
    const T* const voxels = reinterpret_cast<const T*>(block.voxels.data());
    for (std::int64_t k = 0; k < count[2]; ++k)
      for (std::int64_t j = 0; j < count[1]; ++j) {
        const std::int64_t first = ((low[2] + k) * block.size[1] + low[1] + j) * block.size[0] + low[0];
        add_numbers(kind.components, voxels + first * kind.components, count[0]);
      }
  });
}

void DyadicHistogram::merge(const DyadicHistogram& other) noexcept {
  if (other.last_ < other.first_) return;
  hold(other.first_, other.last_, other.exponent_);
  for (std::int64_t n = other.first_; n <= other.last_; ++n)
    counts_[static_cast<std::size_t>(coarser(n, exponent_ - other.exponent_) - first_)] +=
        other.counts_[static_cast<std::size_t>(n - other.first_)];
}

DyadicHistogram::Numbers DyadicHistogram::numbers() const noexcept {
  Numbers numbers{static_cast<double>(exponent_), static_cast<double>(first_)};
  for (std::size_t n = 0; n < counts_.size(); ++n) numbers[2 + n] = static_cast<double>(counts_[n]);
  return numbers;
}

bool DyadicHistogram::take(const Numbers& numbers) noexcept {
  constexpr double most_number = 0x1p52;
  DyadicHistogram taken;
  const auto is_good = [](double number, double low, double high) {
    return number >= low && number <= high && number == std::floor(number);
  };
  if (!is_good(numbers[0], least_exponent, largest_exponent) || !is_good(numbers[1], -most_number, most_number)) return false;
  taken.exponent_ = static_cast<int>(numbers[0]), taken.first_ = static_cast<std::int64_t>(numbers[1]);
  taken.last_ = taken.first_ - 1;
  for (std::size_t n = 0; n < taken.counts_.size(); ++n) {
    if (!is_good(numbers[2 + n], 0.0, most_number)) return false;
    taken.counts_[n] = static_cast<std::int64_t>(numbers[2 + n]);
    if (taken.counts_[n] > 0) taken.last_ = taken.first_ + static_cast<std::int64_t>(n);
  }
  *this = taken;
  return true;
}

Histogram DyadicHistogram::classes(bool is_whole_numbers) const {
  Histogram classes;
  if (last_ < first_) {
    classes.counts.assign(1, 0);
    return classes;
  }
  const double before = is_whole_numbers ? 0.5 : 0.0;
  const auto edge = [&](std::int64_t number) {
    constexpr double most = std::numeric_limits<double>::max();
    return std::clamp(std::ldexp(static_cast<double>(number), exponent_) - before, -most, most);
  };
  classes.low = edge(first_), classes.high = edge(last_ + 1);
  classes.counts.assign(counts_.begin(), counts_.begin() + (last_ - first_ + 1));
  return classes;
}

}  // namespace palpa::detail
