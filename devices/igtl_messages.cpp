#include "devices/igtl_messages.h"

#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "palpa/device/turn_of.h"

namespace palpa::igtl {
namespace {

constexpr std::uint64_t polynomial = 0x42f0'e1eb'a9ea'3693;

constexpr std::array<std::uint64_t, 256> crc_table = [] {
  std::array<std::uint64_t, 256> table{};
  for (std::uint64_t byte = 0; byte < table.size(); ++byte) {
    std::uint64_t crc = byte << 56;
    for (int bit = 0; bit < 8; ++bit) crc = (crc << 1) ^ ((crc >> 63) != 0 ? polynomial : 0);
    table[byte] = crc;
  }
  return table;
}();

/// Reads fields one after the other; all are big endian. Zero beyond the end.
class Fields {
 public:
  explicit Fields(std::span<const std::byte> bytes) : rest_(bytes) {}
  template <class Number>
  Number next() noexcept {
    std::array<std::byte, sizeof(Number)> bytes{};
    const std::size_t length = std::min(bytes.size(), rest_.size());
    std::reverse_copy(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(length), bytes.begin());
    rest_ = rest_.subspan(length);
    return std::bit_cast<Number>(bytes);
  }
  template <std::size_t length>
  std::array<char, length> text() noexcept {
    std::array<char, length> text{};
    for (char& letter : text) letter = next<char>();
    return text;
  }

 private:
  std::span<const std::byte> rest_;
};

template <class Number>
void put(Bytes& to, Number number) {
  const auto bytes = std::bit_cast<std::array<std::byte, sizeof(Number)>>(number);
  for (std::size_t n = bytes.size(); n > 0; --n) to.push_back(bytes[n - 1]);
}
void put_text(Bytes& to, std::string_view text) {
  for (const char letter : text) to.push_back(static_cast<std::byte>(letter));
}
/// A field of a fixed length, filled up with zeros.
void put_text(Bytes& to, std::string_view text, std::size_t length) {
  text = text.substr(0, length);
  put_text(to, text);
  to.resize(to.size() + length - text.size());
}
void put_floats(Bytes& to, const Vec3& v) {
  for (const double x : {v.x, v.y, v.z}) put(to, static_cast<float>(x));
}

/// Seconds since 1970 in the upper half, their fraction in the lower.
std::uint64_t stamp_now() noexcept {
  const double now_s = std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  const double whole_s = std::floor(now_s);
  return static_cast<std::uint64_t>(whole_s) << 32 | static_cast<std::uint64_t>((now_s - whole_s) * 4294967296.0);
}

Vec3 column(const Mat3& m, int n) noexcept {
  const auto of = [n](const Vec3& row) { return n == 0 ? row.x : n == 1 ? row.y : row.z; };
  return {of(m.row[0]), of(m.row[1]), of(m.row[2])};
}

}  // namespace

std::uint64_t crc64(std::span<const std::byte> bytes, std::uint64_t crc) noexcept {
  for (const std::byte byte : bytes) crc = crc_table[(crc >> 56) ^ static_cast<std::uint64_t>(byte)] ^ (crc << 8);
  return crc;
}

/// Returns the number of bytes taken.
std::size_t MessageStream::assemble(std::span<const std::byte> bytes) noexcept {
  if (taken_ < head_bytes) {
    const std::size_t length = std::min(bytes.size(), static_cast<std::size_t>(head_bytes - taken_));
    std::copy_n(bytes.begin(), length, head_as_sent_.begin() + static_cast<std::ptrdiff_t>(taken_));
    taken_ += length;
    if (taken_ < head_bytes) return length;
    Fields fields(head_as_sent_);
    head_.version = fields.next<std::uint16_t>();
    head_.type = fields.text<12>();
    head_.name = fields.text<20>();
    fields.next<std::uint64_t>();  // its time is by another clock
    head_.body_bytes = fields.next<std::uint64_t>();
    head_.crc = fields.next<std::uint64_t>();
    constexpr std::uint16_t newest = 3;
    is_usable_ = head_.version >= 1 && head_.version <= newest && head_.body_bytes <= most_passed_bytes;
    is_whole_ = head_.body_bytes == 0;
    return length;
  }
  const std::uint64_t at = taken_ - head_bytes;
  const auto length = static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), head_.body_bytes - at));
  if (is_kept()) std::copy_n(bytes.begin(), length, body_.begin() + static_cast<std::ptrdiff_t>(at));
  taken_ += length;
  is_whole_ = taken_ - head_bytes == head_.body_bytes;
  return length;
}

std::span<const std::byte> content_of(const Head& head, std::span<const std::byte> body) noexcept {
  if (head.version < 2) return body;
  constexpr std::uint64_t least_extended_bytes = 12;
  Fields fields(body);
  const std::uint64_t extended = fields.next<std::uint16_t>();
  const std::uint64_t behind = std::uint64_t{fields.next<std::uint16_t>()} + fields.next<std::uint32_t>();
  if (extended < least_extended_bytes || extended + behind > body.size()) return {};
  return body.subspan(static_cast<std::size_t>(extended), static_cast<std::size_t>(body.size() - extended - behind));
}

std::optional<RasPose> pose_of(std::span<const std::byte> content) noexcept {
  constexpr double rotation_tolerance = 1e-2;  // [1] of senders with few digits. More: sheared poses; less: no pose of theirs
  constexpr double farthest_mm = 1e5;
  if (content.size() != 12 * sizeof(float)) return std::nullopt;
  Fields fields(content);
  const auto vector = [&] {
    const double x = fields.next<float>(), y = fields.next<float>(), z = fields.next<float>();
    return Vec3{x, y, z};
  };
  const Vec3 x = vector(), y = vector(), z = vector();
  RasPose pose{.rotation = {{{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}}}, .place_mm = vector()};
  const auto& [px, py, pz] = pose.place_mm;
  const bool is_near = std::abs(px) <= farthest_mm && std::abs(py) <= farthest_mm && std::abs(pz) <= farthest_mm;
  if (!is_near || !is_rotation(pose.rotation, rotation_tolerance)) return std::nullopt;
  return pose;
}

Bytes head_for(std::string_view type, std::string_view name, std::uint64_t body_bytes, std::uint64_t crc) {
  Bytes head;
  head.reserve(head_bytes + static_cast<std::size_t>(std::min<std::uint64_t>(body_bytes, most_body_bytes)));
  put(head, std::uint16_t{1});
  put_text(head, type, 12);
  put_text(head, name, 20);
  put(head, stamp_now());
  put(head, body_bytes);
  put(head, crc);
  return head;
}

Bytes message_of(std::string_view type, std::string_view name, std::span<const std::byte> body) {
  Bytes message = head_for(type, name, body.size(), crc64(body));
  message.insert(message.end(), body.begin(), body.end());
  return message;
}

Bytes transform_body(const RasPose& pose) {
  Bytes body;
  for (int n = 0; n < 3; ++n) put_floats(body, column(pose.rotation, n));
  put_floats(body, pose.place_mm);
  return body;
}

Bytes status_body(Status status, std::string_view name, std::string_view text) {
  Bytes body;
  put(body, static_cast<std::uint16_t>(status));
  put(body, std::uint64_t{0});
  put_text(body, name.substr(0, 19), 20);  // ends with a zero
  put_text(body, text);
  body.push_back(std::byte{0});
  return body;
}

Bytes string_body(std::string_view text) {
  constexpr std::uint16_t utf8 = 106;  // of IANA's list of encodings
  text = text.substr(0, std::numeric_limits<std::uint16_t>::max());
  Bytes body;
  put(body, utf8);
  put(body, static_cast<std::uint16_t>(text.size()));
  put_text(body, text);
  return body;
}

Bytes capability_body(std::span<const std::string_view> types) {
  Bytes body;
  for (const std::string_view type : types) put_text(body, type, 12);
  return body;
}

Bytes image_head(const ImageGrid& grid) {
  constexpr std::uint8_t int16 = 4, float32 = 10, little_endian = 2, ras = 1;
  Bytes head;
  put(head, std::uint16_t{1});
  for (const std::uint8_t number : {std::uint8_t{1}, grid.is_float ? float32 : int16, little_endian, ras}) put(head, number);
  for (const std::uint16_t n : grid.dims) put(head, n);
  put_floats(head, {grid.step_mm.x, 0, 0});
  put_floats(head, {0, grid.step_mm.y, 0});
  put_floats(head, {0, 0, grid.step_mm.z});
  put_floats(head, grid.centre_mm);
  for (int n = 0; n < 3; ++n) put(head, std::uint16_t{0});  // the whole is sent
  for (const std::uint16_t n : grid.dims) put(head, n);
  return head;
}

}  // namespace palpa::igtl
