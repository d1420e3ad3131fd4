// Lock-free single-producer single-consumer triple buffer.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace palpa {

/// Triple buffer: a place for the producer, a place for the consumer, and a place between them, which either exchanges for its
/// own. Neither blocks nor reads a partial value; the latest value wins. One producer thread, one consumer thread. Allocates
/// nothing.
template <class Value>
class Latest {
 public:
  void give(const Value& value) noexcept {
    places_[writing_] = value;
    writing_ = between_.exchange(writing_ | fresh, std::memory_order_acq_rel) & ~fresh;
  }
  /// Latest value; at first Value{}. Stays valid until the next call.
  const Value& take() noexcept {
    if (is_fresh()) reading_ = between_.exchange(reading_, std::memory_order_acq_rel) & ~fresh;
    return places_[reading_];
  }
  /// Whether a newer value is available. For the consumer.
  bool is_fresh() const noexcept { return (between_.load(std::memory_order_relaxed) & fresh) != 0; }

 private:
  static constexpr std::uint32_t fresh = 4;
  std::array<Value, 3> places_{};
  std::uint32_t writing_ = 0;
  std::atomic<std::uint32_t> between_{1};
  std::uint32_t reading_ = 2;
};

}  // namespace palpa
