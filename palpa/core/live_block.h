// What a session remembers from tick to tick, in one block of bytes.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstring>
#include <new>
#include <span>
#include <type_traits>
#include <vector>

namespace palpa {

/// Memory in which the parts of a session keep, side by side, what the next tick depends on. What a part keeps is trivially
/// copyable and has no pointer into the block, so the whole is copied as bytes: a rehearsal begins, and is thrown away, by one
/// copy. What may be forgotten, such as where a search begins, is kept elsewhere. A block stays where it is; one thread.
class LiveBlock {
 public:
  LiveBlock() = default;
  LiveBlock(const LiveBlock&) = delete;
  LiveBlock& operator=(const LiveBlock&) = delete;

  /// An array in a block, which must outlive it.
  template <class T>
  class Part {
   public:
    std::size_t size() const noexcept { return size_; }
    T* begin() const noexcept { return reinterpret_cast<T*>(block_->bytes_.data() + offset_); }
    T* end() const noexcept { return begin() + size_; }
    T& operator[](std::size_t i) const noexcept { return begin()[i]; }
    T& operator*() const noexcept { return *begin(); }
    T* operator->() const noexcept { return begin(); }
    std::span<T> all() const noexcept { return {begin(), size_}; }

   private:
    friend class LiveBlock;
    LiveBlock* block_ = nullptr;
    std::size_t offset_ = 0, size_ = 0;
  };

  /// Gives room for so many values, which are fresh ones. Before the first tick: it allocates, and references into other parts
  /// are no longer valid.
  template <class T>
  Part<T> add(std::size_t size = 1) {
    static_assert(std::is_trivially_copyable_v<T> && alignof(T) <= __STDCPP_DEFAULT_NEW_ALIGNMENT__);
    Part<T> part;
    part.block_ = this;
    part.offset_ = (bytes_.size() + alignof(T) - 1) / alignof(T) * alignof(T);
    part.size_ = size;
    bytes_.resize(part.offset_ + size * sizeof(T));
    for (T& value : part) ::new (&value) T{};
    return part;
  }

  /// [1] of bytes that a copy moves.
  std::size_t size() const noexcept { return bytes_.size(); }
  /// Takes over what another block holds. Programming error (assert) if its parts are others.
  void copy(const LiveBlock& other) noexcept {
    assert(bytes_.size() == other.bytes_.size());
    if (!bytes_.empty()) std::memcpy(bytes_.data(), other.bytes_.data(), bytes_.size());
  }

 private:
  std::vector<std::byte> bytes_;
};

}  // namespace palpa
