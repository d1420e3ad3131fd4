// A value handed from one thread to another: the latest wins, nobody waits.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace palpa {

/// Three places for a value: one that the giver writes, one that the taker reads, and one between them, which either exchanges
/// for its own. So the giver never waits for the taker, nor the taker for the giver, and neither ever sees half a value. One
/// thread gives, one takes. Allocates nothing.
template <class Value>
class Latest {
 public:
  void give(const Value& value) noexcept {
    places_[writing_] = value;
    writing_ = between_.exchange(writing_ | fresh, std::memory_order_acq_rel) & ~fresh;
  }
  /// The value last given; the first is Value{}. Stays as it is until the next call.
  const Value& take() noexcept {
    if (is_fresh()) reading_ = between_.exchange(reading_, std::memory_order_acq_rel) & ~fresh;
    return places_[reading_];
  }
  /// Whether one was given that has not been taken. For the taker.
  bool is_fresh() const noexcept { return (between_.load(std::memory_order_relaxed) & fresh) != 0; }

 private:
  static constexpr std::uint32_t fresh = 4;
  std::array<Value, 3> places_{};
  std::uint32_t writing_ = 0;
  std::atomic<std::uint32_t> between_{1};
  std::uint32_t reading_ = 2;
};

}  // namespace palpa
