// Numbers, texts and lists of messages as bytes, for both ends of a protocol.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "palpa/solver/vec3.h"

namespace palpa::protocol {

// Limits of a message, checked at both ends. Larger: a damaged file can cost more memory; smaller: long texts are cut, and long
// lists are refused.
inline constexpr std::size_t max_text_bytes = 4096;
inline constexpr std::size_t max_entries = 1024;

/// Writes a message. Allocates; one thread.
class Packer {
 public:
  template <class T>
  void number(T value) {
    static_assert(std::is_trivially_copyable_v<T>);
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof value);
    std::memcpy(bytes_.data() + at, &value, sizeof value);
  }
  void text(const std::string& value) {
    const std::size_t length = std::min(value.size(), max_text_bytes);
    number(static_cast<std::uint32_t>(length));
    const auto* first = reinterpret_cast<const std::byte*>(value.data());
    bytes_.insert(bytes_.end(), first, first + length);
  }
  /// \param v  [1] in any unit
  void vector(const Vec3& v) { number(v.x), number(v.y), number(v.z); }
  template <class T, class Put>
  void list(const std::vector<T>& values, Put put) {
    number(static_cast<std::uint32_t>(values.size()));
    for (const T& value : values) put(value);
  }
  template <class T, class Put>
  void optional(const std::optional<T>& value, Put put) {
    number(static_cast<std::uint8_t>(value.has_value()));
    if (value) put(*value);
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

/// Parses Packer's output, from untrusted bytes. Allocates no more than the bytes hold; one thread. After the first fault all
/// is zero and `ok` is false.
class Unpacker {
 public:
  Unpacker(const std::byte* bytes, std::size_t size) : bytes_(bytes), left_(size) {}

  template <class T>
  T number() {
    T value{};
    if (!ok_ || left_ < sizeof value) return ok_ = false, T{};
    std::memcpy(&value, bytes_, sizeof value);
    bytes_ += sizeof value, left_ -= sizeof value;
    return value;
  }
  /// Byte by byte: a path with one byte changed is that of another file.
  std::string path() {
    const auto length = number<std::uint32_t>();
    if (!ok_ || length > max_text_bytes || length > left_) return ok_ = false, std::string();
    std::string value(reinterpret_cast<const char*>(bytes_), length);
    bytes_ += length, left_ -= length;
    return value;
  }
  /// Control characters become spaces: text of a file must not break a line or colour a terminal.
  std::string text() {
    std::string value = path();
    for (char& c : value) {
      if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
    }
    return value;
  }
  /// [1] In any unit.
  Vec3 vector() {
    const auto x = number<double>(), y = number<double>(), z = number<double>();
    return {x, y, z};
  }
  template <class T, class Get>
  std::vector<T> list(Get get) {
    std::vector<T> values;
    const auto count = number<std::uint32_t>();
    if (count > max_entries) ok_ = false;
    for (std::uint32_t i = 0; ok_ && i < count; ++i) values.push_back(get());
    return values;
  }
  template <class T, class Get>
  std::optional<T> optional(Get get) {
    return truth() ? std::optional<T>(get()) : std::nullopt;
  }
  bool truth() { return number<std::uint8_t>() != 0; }
  bool at_end() const noexcept { return ok_ && left_ == 0; }
  void refuse() noexcept { ok_ = false; }

 private:
  const std::byte* bytes_;
  std::size_t left_;
  bool ok_ = true;
};

}  // namespace palpa::protocol
