// Choices of a case: drawn from a seed, or replayed from a list for minimisation.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace palpa::fuzz {

/// Source of a case's choices: whole numbers with 0 the plainest; an exhausted list continues with zeros. A shorter list, or
/// one with smaller numbers, is a plainer case, so that one minimiser serves all campaigns.
class Choices {
 public:
  /// All choices of one seed, unlike its neighbours', identical on every machine. Recorded in `record` up to its size.
  explicit Choices(std::uint64_t seed, std::span<std::uint64_t> record = {})
      : state_(mixed(mixed(seed + 1) + 0x632BE59BD9B4E019u)), record_(record) {}
  explicit Choices(std::vector<std::uint64_t> list) : list_(std::move(list)), replays_(true) {}

  /// 0…n − 1, n > 0.
  std::uint64_t below(std::uint64_t n) {
    std::uint64_t chosen = 0;
    if (!replays_) {
      chosen = static_cast<std::uint64_t>((static_cast<unsigned __int128>(bits()) * n) >> 64);
    } else if (taken_ < list_.size()) {
      chosen = list_[taken_] < n ? list_[taken_] : n - 1;
    }
    if (taken_ < record_.size()) record_[taken_] = chosen;
    ++taken_;
    return chosen;
  }
  /// True once in n times; the plainest is false.
  bool one_in(std::uint64_t n) { return below(n) == n - 1 && n > 1; }
  /// [low, high); the plainest is `low`. Unit [1].
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(below(std::uint64_t{1} << 53)) * 0x1p-53;
  }
  /// [low, high), log-uniform; the plainest is `low`. Unit [1].
  double log_between(double low, double high) {  // whose quotient may overflow
    return std::clamp(std::exp(std::log(low) + between(0.0, std::log(high) - std::log(low))), low, high);
  }
  /// An element of a list; the plainest is the first.
  template <class List>
  const auto& one_of(const List& list) {
    return list[static_cast<std::size_t>(below(std::size(list)))];
  }
  std::string bytes(std::size_t count) {
    std::string made(count, '\0');
    for (char& c : made) c = static_cast<char>(below(256));
    return made;
  }
  std::size_t taken() const { return taken_; }

 private:
  static std::uint64_t mixed(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  std::uint64_t bits() { return mixed(state_ += 0x9E3779B97F4A7C15u); }  // splitmix64 (Steele, Lea, Flood 2014)

  std::uint64_t state_ = 0;
  std::span<std::uint64_t> record_;
  std::vector<std::uint64_t> list_;
  bool replays_ = false;
  std::size_t taken_ = 0;
};

}  // namespace palpa::fuzz
