// Messages of OpenIGTLink: read from bytes of any origin, and written. Shared by the driver of trackers and by the view of a
// run.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "palpa/solver/vec3.h"

namespace palpa::igtl {

using Bytes = std::vector<std::byte>;

inline constexpr std::size_t head_bytes = 58;
/// [bytes] Longest body that is kept. Longer: a stranger takes memory; shorter: transforms with many metadata are passed over.
inline constexpr std::size_t most_body_bytes = 65536;
/// [bytes] Longest body that is passed over, as another device's image. Longer: a wrong length swallows the stream; shorter:
/// beside a large image no transform is read.
inline constexpr std::uint64_t most_passed_bytes = std::uint64_t{1} << 30;

/// Head of a message: of versions 1 to 3 of the protocol.
struct Head {
  std::uint16_t version = 1;
  std::array<char, 12> type{};  ///< ends at the first zero, or after all
  std::array<char, 20> name{};  ///< of the device; likewise
  std::uint64_t body_bytes = 0;
  std::uint64_t crc = 0;  ///< of the body
};
/// The word in a field of a head.
template <std::size_t length>
std::string_view word_of(const std::array<char, length>& field) noexcept {
  return {field.data(), static_cast<std::size_t>(std::ranges::find(field, '\0') - field.begin())};
}

/// Checksum of the protocol: CRC-64 by the polynomial of ECMA-182, from the highest bit on. Allocates nothing; any thread.
/// \param crc  of the bytes before these; 0: none
std::uint64_t crc64(std::span<const std::byte> bytes, std::uint64_t crc = 0) noexcept;

/// Assembles messages from a stream of bytes in pieces of any size. Keeps `most_body_bytes`; allocates at construction alone.
class MessageStream {
 public:
  MessageStream() : body_(most_body_bytes) {}

  /// Takes bytes, and calls `message(head, body)` for each message that they complete and whose checksum is right. False: the
  /// bytes are no OpenIGTLink, and the connection is of no use.
  template <class Message>
  bool take(std::span<const std::byte> bytes, Message&& message) {
    while (!bytes.empty()) {
      bytes = bytes.subspan(assemble(bytes));
      if (!is_usable_) return false;
      if (!is_whole_) continue;
      const std::span<const std::byte> body(body_.data(), static_cast<std::size_t>(is_kept() ? head_.body_bytes : 0));
      if (is_kept() && crc64(body) == head_.crc) message(std::as_const(head_), body);
      begin();
    }
    return true;
  }
  /// Begins anew, with a head.
  void begin() noexcept {
    taken_ = 0;
    is_whole_ = false;
    is_usable_ = true;
  }
  /// Whether a message has begun that is not whole.
  bool is_within() const noexcept { return taken_ > 0; }

 private:
  std::size_t assemble(std::span<const std::byte> bytes) noexcept;
  bool is_kept() const noexcept { return head_.body_bytes <= most_body_bytes; }

  std::array<std::byte, head_bytes> head_as_sent_{};
  Bytes body_;
  Head head_;
  std::uint64_t taken_ = 0;  // of this message
  bool is_whole_ = false;
  bool is_usable_ = true;
};

/// Content of a body without the additions of version 3 of the protocol (extended head, metadata); empty if these do not fit.
std::span<const std::byte> content_of(const Head& head, std::span<const std::byte> body) noexcept;

/// Pose in the protocol's frame: RAS (x to the patient's right, y to the front, z to the head), in millimetres.
struct RasPose {
  Mat3 rotation = Mat3::identity();
  Vec3 place_mm;
};
/// Pose of a TRANSFORM's content; none if it is no rotation to within 1e-2, beyond 100 m, or not finite.
std::optional<RasPose> pose_of(std::span<const std::byte> content) noexcept;

// ---- written ----

/// Message of version 1 with its head, checksum and this computer's time. Allocates.
Bytes message_of(std::string_view type, std::string_view name, std::span<const std::byte> body);
/// Head alone, for a body that follows.
/// \param crc  of the body
Bytes head_for(std::string_view type, std::string_view name, std::uint64_t body_bytes, std::uint64_t crc);

Bytes transform_body(const RasPose& pose);
/// Codes of STATUS.
enum class Status : std::uint16_t { ok = 1, panic = 3, not_found = 4, not_ready = 13, shut_down = 19 };
Bytes status_body(Status status, std::string_view name, std::string_view text);
Bytes string_body(std::string_view text);
Bytes capability_body(std::span<const std::string_view> types);

/// Grid of an IMAGE along the world's axes, all voxels of which follow its head.
struct ImageGrid {
  bool is_float = false;  ///< float32; else int16; both little endian
  std::array<std::uint16_t, 3> dims{};
  Vec3 step_mm;    ///< [mm, RAS] from voxel to voxel along i (x), j (y), k (z); negative against the axis
  Vec3 centre_mm;  ///< [mm, RAS] of the grid, half way between its first and last voxels
};
Bytes image_head(const ImageGrid& grid);

}  // namespace palpa::igtl
