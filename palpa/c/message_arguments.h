// Arguments of the functions for C that take and give messages.
#pragma once

#include <cstddef>
#include <span>

#include "palpa/c.h"

namespace palpa::c {

/// Message of a caller. Allocates nothing; any thread.
inline std::span<const std::byte> message_given(const void* message, std::size_t bytes) noexcept {
  return {static_cast<const std::byte*>(message), bytes};
}
/// Room of a caller. Allocates nothing; any thread.
inline std::span<std::byte> room_given(void* message, std::size_t room) noexcept {
  return {static_cast<std::byte*>(message), room};
}

/// Fault of these arguments, half a sentence; nullptr: none. Allocates nothing; any thread.
/// \param without_handle  sentence for a NULL handle
inline const char* problem_with_room(const void* handle, const char* without_handle, const void* message,
                                     std::size_t room) noexcept {
  if (!handle) return without_handle;
  if (!message) return "message is NULL; give a place for it";
  if (room < PALPA_MESSAGE_BYTES) return "room is too small for a message; give PALPA_MESSAGE_BYTES";
  return nullptr;
}

}  // namespace palpa::c
