// Structs of the header for C that begin with their size, which an older caller's program gives smaller.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace palpa::c {

/// Size of the struct in the first header that had it [bytes].
template <class Struct>
inline constexpr std::size_t first_bytes = sizeof(Struct);

/// Whether a caller's struct of this size can be used. Allocates nothing; any thread.
template <class Struct>
constexpr bool is_known_size(std::uint32_t size_bytes) noexcept {
  return size_bytes >= first_bytes<Struct> && size_bytes <= sizeof(Struct);
}

/// The whole struct of a caller's, whose size is usable: fields beyond it have their values in `defaults`. Allocates nothing;
/// any thread.
template <class Struct>
Struct whole(const Struct* given, Struct defaults = {}) noexcept {
  std::memcpy(&defaults, given, given->size);
  defaults.size = sizeof(Struct);
  return defaults;
}

/// Writes the part of `full` that a caller's struct of this known size has, and the size. Allocates nothing; any thread.
template <class Struct>
void put(Struct full, std::uint32_t size_bytes, void* to) noexcept {
  full.size = size_bytes;
  std::memcpy(to, &full, size_bytes);
}

}  // namespace palpa::c
