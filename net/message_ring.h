// Lock-free queue of whole messages.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>

namespace palpa::net {

/// Ring of messages of at most 4096 bytes, each of a numbered connection. One producer thread, one consumer thread; neither
/// blocks. Construction allocates.
/// \tparam places  [1] a power of 2
template <std::size_t places>
class MessageRing {
 public:
  MessageRing() : slots_(std::make_unique<Slots>()) {}

  /// False: full, or too long. Nothing is put in.
  bool put(std::uint32_t connection, std::span<const std::byte> message) noexcept {
    const std::size_t end = end_.load(std::memory_order_relaxed);
    if (end - begin_.load(std::memory_order_acquire) == places || message.size() > longest) return false;
    Slot& slot = (*slots_)[end % places];
    slot.connection = connection;
    slot.bytes = message.size();
    std::memcpy(slot.message.data(), message.data(), message.size());
    end_.store(end + 1, std::memory_order_release);
    return true;
  }
  /// Oldest message of the connection, valid until `drop`; those of earlier ones before it are dropped. Empty: none.
  std::span<const std::byte> front(std::uint32_t connection) noexcept {
    while (begin_.load(std::memory_order_relaxed) != end_.load(std::memory_order_acquire)) {
      const Slot& slot = (*slots_)[begin_.load(std::memory_order_relaxed) % places];
      if (slot.connection == connection) return {slot.message.data(), slot.bytes};
      if (static_cast<std::int32_t>(slot.connection - connection) > 0) break;
      drop();
    }
    return {};
  }
  void drop() noexcept { begin_.store(begin_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

 private:
  static constexpr std::size_t longest = 4096;
  struct Slot {
    std::uint32_t connection = 0;
    std::size_t bytes = 0;
    std::array<std::byte, longest> message{};
  };
  using Slots = std::array<Slot, places>;
  std::unique_ptr<Slots> slots_;
  std::atomic<std::size_t> begin_{0}, end_{0};
};

}  // namespace palpa::net
