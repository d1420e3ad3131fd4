// Arena of trivially copyable session state.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstring>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <vector>

namespace palpa {

/// State of a session's parts, side by side. Trivially copyable contents without pointers into the arena are copied as bytes: a
/// rehearsal begins, and is discarded, by one copy. Caches are kept elsewhere. One thread.
class StateArena {
 public:
  StateArena() = default;
  StateArena(const StateArena&) = delete;
  StateArena& operator=(const StateArena&) = delete;

  /// Returns `size` [1] new values; their addresses are stable. Allocates.
  template <class T>
  std::span<T> add(std::size_t size) {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= alignment);
    T* first = reinterpret_cast<T*>(room_for(size * sizeof(T)));
    std::uninitialized_value_construct_n(first, size);
    return {first, size};
  }
  template <class T>
  T& add() {
    return add<T>(1).front();
  }

  /// Whether another arena has parts of equal sizes.
  bool has_parts_of(const StateArena& other) const noexcept {
    return std::ranges::equal(chunks_, other.chunks_, {}, &Chunk::used, &Chunk::used);
  }
  /// Copies the contents of another arena. Programming error (assert) if its parts differ.
  void copy(const StateArena& other) noexcept {
    assert(chunks_.size() == other.chunks_.size());
    for (std::size_t i = 0; i < chunks_.size(); ++i) {
      assert(chunks_[i].used == other.chunks_[i].used);
      std::memcpy(chunks_[i].bytes.get(), other.chunks_[i].bytes.get(), chunks_[i].used);
    }
  }

 private:
  static constexpr std::size_t alignment = __STDCPP_DEFAULT_NEW_ALIGNMENT__;
  static constexpr std::size_t chunk_bytes = 1 << 16;  // fits a usual scene; unused pages are never touched
  struct Chunk {
    std::unique_ptr<std::byte[]> bytes;
    std::size_t used = 0, size = 0;
  };

  std::byte* room_for(std::size_t bytes) {
    bytes = (bytes + alignment - 1) / alignment * alignment;
    if (chunks_.empty() || chunks_.back().size - chunks_.back().used < bytes) {
      const std::size_t size = std::max(bytes, chunk_bytes);
      chunks_.push_back({std::unique_ptr<std::byte[]>(new std::byte[size]), 0, size});
    }
    chunks_.back().used += bytes;
    return chunks_.back().bytes.get() + chunks_.back().used - bytes;
  }

  std::vector<Chunk> chunks_;  // rarely more than one
};

}  // namespace palpa
