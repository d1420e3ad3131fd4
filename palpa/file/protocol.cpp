#include "palpa/file/protocol.h"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "palpa/base/limits.h"
#include "palpa/base/printed.h"
#include "palpa/data/volume.h"
#include "palpa/file/packer.h"
#include "palpa/file/store_protocol.h"

namespace palpa::protocol {
namespace {

constexpr std::uint32_t magic = 0x50'4C'50'52;  // "PLPR"
constexpr std::uint64_t alignment_bytes = 64;   // of each field's voxels: a cache line
/// Of a fact's words. More: a damaged file can say more about a person; less: facts are refused.
constexpr std::size_t max_fact_bytes = 96;

void pack(Packer& to, const ArrayLayout& m) {
  to.text(m.type), to.text(m.byte_order), to.text(m.axes), to.text(m.components);
  to.number(m.header_bytes);
  for (const std::int64_t n : m.dims) to.number(n);
  to.vector(m.spacing_m);
  to.optional(m.origin_m, [&](const Vec3& v) { to.vector(v); });
}
void unpack(Unpacker& from, ArrayLayout& m) {
  m.type = from.text(), m.byte_order = from.text(), m.axes = from.text(), m.components = from.text();
  m.header_bytes = from.number<std::int64_t>();
  for (std::int64_t& n : m.dims) n = from.number<std::int64_t>();
  m.spacing_m = from.vector();
  m.origin_m = from.optional<Vec3>([&] { return from.vector(); });
}

void pack(Packer& to, const Request& m) {
  to.text(m.path), to.text(m.as), to.text(m.series), to.text(m.components_along);
  to.number(m.frame), to.number(m.max_bytes);
  to.list(m.partners, [&](const std::string& p) { to.text(p); });
  to.text(m.inside);
  pack(to, m.layout);
  to.optional(m.time_s, [&](double t) { to.number(t); });
  to.optional(m.crop, [&](const Box& b) { to.vector(b.low_m), to.vector(b.high_m); });
  to.number(static_cast<std::uint8_t>(m.checksums)), to.number(static_cast<std::uint8_t>(m.listing));
  to.number(static_cast<std::uint8_t>(m.store)), to.number(static_cast<std::uint8_t>(m.rows));
}
void unpack(Unpacker& from, Request& m) {
  m.path = from.path(), m.as = from.text(), m.series = from.text(), m.components_along = from.text();
  m.frame = from.number<std::int32_t>();
  m.max_bytes = from.number<std::uint64_t>();
  m.partners = from.list<std::string>([&] { return from.path(); });
  m.inside = from.path();
  unpack(from, m.layout);
  m.time_s = from.optional<double>([&] { return from.number<double>(); });
  m.crop = from.optional<Box>([&] {
    Box box;
    box.low_m = from.vector(), box.high_m = from.vector();
    return box;
  });
  m.checksums = static_cast<Checksums>(std::min<std::uint8_t>(from.number<std::uint8_t>(), 2));
  m.listing = from.truth(), m.store = from.truth(), m.rows = from.truth();
}

void pack(Packer& to, const FieldHeader& f) {
  to.text(f.name), to.text(f.unit);
  to.number(static_cast<std::uint8_t>(f.type)), to.number(f.components);
  for (const std::int64_t n : f.grid.dims) to.number(n);
  for (const Vec3& row : f.grid.index_to_world_m.row) to.vector(row);
  to.vector(f.grid.origin_m);
  for (const auto& planes : f.grid.planes) to.number(static_cast<std::uint8_t>(!planes.empty()));
  to.number(f.scale), to.number(f.offset);
}
FieldHeader unpack_field(Unpacker& from) {
  FieldHeader f;
  f.name = from.text(), f.unit = from.text();
  const auto type = from.number<std::uint8_t>();
  if (type > static_cast<std::uint8_t>(VoxelType::float64)) from.refuse();
  f.type = static_cast<VoxelType>(type);
  f.components = from.number<std::int32_t>();
  for (std::int64_t& n : f.grid.dims) n = from.number<std::int64_t>();
  for (Vec3& row : f.grid.index_to_world_m.row) row = from.vector();
  f.grid.origin_m = from.vector();
  for (auto& planes : f.grid.planes) planes.resize(from.truth() ? 1 : 0);
  f.scale = from.number<double>(), f.offset = from.number<double>();
  return f;
}

void pack(Packer& to, const ScanFact& fact) {
  to.number(static_cast<std::uint8_t>(fact.kind));
  to.text(fact.words), to.number(fact.number);
}
/// A few plain letters or one finite number: all else that a file contains about a scan is dropped.
ScanFact unpack_fact(Unpacker& from) {
  const auto kind = from.number<std::uint8_t>();
  if (kind >= scan_fact_kinds) from.refuse();
  ScanFact fact{static_cast<ScanFactKind>(kind), from.text(), from.number<double>()};
  const bool plain = std::ranges::all_of(fact.words, [](char c) { return c >= ' ' && c <= '~'; });
  if (!plain || fact.words.size() > max_fact_bytes || !std::isfinite(fact.number)) from.refuse();
  return fact;
}

/// As many parts as a packet holds beside the rest of a header.
void pack(Packer& to, std::vector<FilePart> parts) {
  std::size_t fitting = 0;
  for (std::size_t bytes = 0; fitting < std::min(parts.size(), max_entries); ++fitting) {
    bytes += std::min(parts[fitting].name.size(), max_text_bytes) + std::min(parts[fitting].words.size(), max_text_bytes) + 16;
    if (bytes > max_packet_bytes / 8) break;
  }
  parts.resize(fitting);
  to.list(parts, [&](const FilePart& part) { to.text(part.name), to.text(part.words), to.number(part.number); });
}
std::vector<FilePart> unpack_parts(Unpacker& from) {
  return from.list<FilePart>([&] {
    FilePart part;
    part.name = from.text(), part.words = from.text(), part.number = from.number<std::int64_t>();
    return part;
  });
}

void pack(Packer& to, const Header& m) {
  to.text(m.format), to.text(m.modality), to.text(m.frame_of_reference), to.text(m.length_unit), to.text(m.default_unit);
  to.number(static_cast<std::uint8_t>(m.medical_frame)), to.number(static_cast<std::uint8_t>(m.named));
  to.number(m.frames), to.number(m.working_bytes), to.number(static_cast<std::uint8_t>(m.reads_rows));
  to.list(m.fields, [&](const FieldHeader& f) { pack(to, f); });
  to.list(m.scan, [&](const ScanFact& f) { pack(to, f); });
  to.list(m.warnings, [&](const std::string& w) { to.text(w); });
  pack(to, m.series), pack(to, m.labels), pack(to, m.alternatives);
}
void unpack(Unpacker& from, Header& m) {
  m.format = from.text(), m.modality = from.text(), m.frame_of_reference = from.text(), m.length_unit = from.text(),
  m.default_unit = from.text();
  m.medical_frame = from.truth(), m.named = from.truth();
  m.frames = from.number<std::int32_t>();
  m.working_bytes = from.number<std::uint64_t>();
  m.reads_rows = from.truth();
  m.fields = from.list<FieldHeader>([&] { return unpack_field(from); });
  m.scan = from.list<ScanFact>([&] { return unpack_fact(from); });
  m.warnings = from.list<std::string>([&] { return from.text(); });
  m.series = unpack_parts(from), m.labels = unpack_parts(from), m.alternatives = unpack_parts(from);
}

void pack(Packer& to, const ReadRequest& m) {
  to.list(m.fields, [&](std::uint32_t f) { to.number(f); });
  to.number(m.frames);
}
void unpack(Unpacker& from, ReadRequest& m) {
  m.fields = from.list<std::uint32_t>([&] { return from.number<std::uint32_t>(); });
  m.frames = from.number<std::int32_t>();
}

void pack(Packer& to, const Resampling& m) {
  for (const std::int64_t n : m.dims) to.number(n);
  to.list(m.value_ranges, [&](const ValueRange& e) { to.number(e.min), to.number(e.max); });
  for (const ResamplingError& e : {m.by_cell, m.by_volume}) {
    to.number(e.p50), to.number(e.p99), to.number(e.max), to.number(e.covered);
  }
}
Resampling unpack_resampling(Unpacker& from) {
  Resampling m;
  for (std::int64_t& n : m.dims) n = from.number<std::int64_t>();
  m.value_ranges = from.list<ValueRange>([&] {
    const auto min = from.number<double>(), max = from.number<double>();
    return ValueRange{min, max};
  });
  for (ResamplingError* e : {&m.by_cell, &m.by_volume}) {
    e->p50 = from.number<double>(), e->p99 = from.number<double>();
    e->max = from.number<double>(), e->covered = from.number<double>();
  }
  return m;
}

void pack(Packer& to, const Done& m) {
  to.list(m.files, [&](const SourceFile& f) { to.text(f.path), to.number(f.bytes), to.text(f.sha256.text()); });
  to.list(m.warnings, [&](const std::string& w) { to.text(w); });
  to.list(m.resampled, [&](const Resampling& r) { pack(to, r); });
  to.number(static_cast<std::uint8_t>(m.more));
}
void unpack(Unpacker& from, Done& m) {
  m.files = from.list<SourceFile>([&] {
    SourceFile f;
    f.path = from.path(), f.bytes = from.number<std::uint64_t>(), f.sha256 = from.text();
    return f;
  });
  m.warnings = from.list<std::string>([&] { return from.text(); });
  m.resampled = from.list<Resampling>([&] { return unpack_resampling(from); });
  m.more = from.truth();
}

void pack(Packer& to, const Failure& m) { to.text(m.sentence); }
void unpack(Unpacker& from, Failure& m) { m.sentence = from.text(); }

template <std::size_t I = 0>
Message unpack_kind(std::size_t kind, Unpacker& from) {
  if constexpr (I < std::variant_size_v<Message>) {
    if (kind != I) return unpack_kind<I + 1>(kind, from);
    std::variant_alternative_t<I, Message> message;
    unpack(from, message);
    return message;
  } else {
    from.refuse();
    return {};
  }
}

}  // namespace

std::optional<std::uint64_t> voxel_bytes(const FieldHeader& field) noexcept {
  if (field.components != 1 && field.components != 3) return std::nullopt;
  std::uint64_t bytes = size_of(field.type) * static_cast<std::uint64_t>(field.components);
  for (const std::int64_t n : field.grid.dims) {
    if (n < 1 || __builtin_mul_overflow(bytes, static_cast<std::uint64_t>(n), &bytes)) return std::nullopt;
  }
  // Beyond any machine; sums with planes and gaps do not overflow.
  constexpr std::uint64_t most_bytes = std::uint64_t{1} << 62;
  if (bytes > most_bytes) return std::nullopt;
  return bytes;
}

std::uint64_t plane_numbers(const FieldHeader& field) noexcept {
  std::uint64_t count = 0;
  for (std::size_t a = 0; a < 3; ++a)
    count += field.grid.planes[a].empty() ? 0 : static_cast<std::uint64_t>(field.grid.dims[a]);
  return count;
}

std::optional<std::vector<std::uint64_t>> place(const Header& header, const ReadRequest& room) {
  if (room.frames < 1 || limit::frames.is_passed_by(room.frames) || (room.frames > 1 && room.frames != header.frames)) {
    return std::nullopt;
  }
  std::vector<std::uint64_t> offsets{0};
  for (std::size_t n = 0; n < room.fields.size() * static_cast<std::size_t>(room.frames); ++n) {
    const std::size_t i = n % room.fields.size();
    const std::uint32_t field = room.fields[i];
    if (field >= header.fields.size() || (i > 0 && field <= room.fields[i - 1])) return std::nullopt;
    const auto voxels = voxel_bytes(header.fields[field]);
    if (!voxels) return std::nullopt;
    std::uint64_t bytes = (*voxels + 7) / 8 * 8, end = 0;
    // No more planes than voxels along each axis, so this is at most 24 times as much.
    if (__builtin_add_overflow(bytes, 8 * std::min(plane_numbers(header.fields[field]), UINT64_MAX / 8), &bytes) ||
        __builtin_add_overflow(offsets.back(), bytes, &end) || end > INT64_MAX - alignment_bytes) {
      return std::nullopt;
    }
    offsets.push_back((end + alignment_bytes - 1) / alignment_bytes * alignment_bytes);
  }
  return offsets;
}

std::vector<std::byte> packed(const Message& message) {
  Packer to;
  to.number(magic), to.number(version), to.number(static_cast<std::uint16_t>(message.index()));
  std::visit([&](const auto& m) { pack(to, m); }, message);
  return to.take();
}

std::optional<Message> unpacked(const std::byte* bytes, std::size_t size) {
  Unpacker from(bytes, size);
  if (from.number<std::uint32_t>() != magic || from.number<std::uint16_t>() != version) return std::nullopt;
  const auto kind = from.number<std::uint16_t>();
  Message message = unpack_kind(kind, from);
  if (!from.at_end()) return std::nullopt;
  return message;
}

bool send(int socket, const Message& message, int descriptor, int second_descriptor) {
  std::vector<std::byte> bytes = packed(message);
  if (bytes.size() > max_packet_bytes) throw std::length_error("a message to or from palpa-read is too long");
  iovec part{bytes.data(), bytes.size()};
  const int descriptors[] = {descriptor, second_descriptor};
  const std::size_t descriptor_bytes = descriptor < 0 ? 0 : second_descriptor < 0 ? sizeof(int) : 2 * sizeof(int);
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof descriptors)] = {};
  msghdr packet{};
  packet.msg_iov = &part, packet.msg_iovlen = 1;
  if (descriptor_bytes > 0) {
    packet.msg_control = control, packet.msg_controllen = CMSG_SPACE(descriptor_bytes);
    cmsghdr* with = CMSG_FIRSTHDR(&packet);
    with->cmsg_level = SOL_SOCKET, with->cmsg_type = SCM_RIGHTS, with->cmsg_len = CMSG_LEN(descriptor_bytes);
    std::memcpy(CMSG_DATA(with), descriptors, descriptor_bytes);
  }
  ssize_t sent = 0;
  do sent = ::sendmsg(socket, &packet, MSG_NOSIGNAL);
  while (sent < 0 && errno == EINTR);
  return sent == static_cast<ssize_t>(bytes.size());
}

std::optional<Received> receive(int socket, bool& garbled, bool take) {
  garbled = false;
  const auto bytes = std::make_unique_for_overwrite<std::byte[]>(max_packet_bytes);
  iovec part{bytes.get(), max_packet_bytes};
  alignas(cmsghdr) char control[CMSG_SPACE(8 * sizeof(int))] = {};
  msghdr packet{};
  packet.msg_iov = &part, packet.msg_iovlen = 1;
  packet.msg_control = control, packet.msg_controllen = sizeof control;
  ssize_t size = 0;
  do size = ::recvmsg(socket, &packet, MSG_CMSG_CLOEXEC | (take ? 0 : MSG_PEEK));
  while (size < 0 && errno == EINTR);
  if (size <= 0) return std::nullopt;

  int descriptors[] = {-1, -1};
  std::size_t count = 0;
  for (cmsghdr* with = CMSG_FIRSTHDR(&packet); with != nullptr; with = CMSG_NXTHDR(&packet, with)) {
    if (with->cmsg_level != SOL_SOCKET || with->cmsg_type != SCM_RIGHTS) continue;
    for (std::size_t at = 0; CMSG_LEN(at + sizeof(int)) <= with->cmsg_len; at += sizeof(int)) {
      int got = -1;
      std::memcpy(&got, CMSG_DATA(with) + at, sizeof got);
      if (count < std::size(descriptors)) {
        descriptors[count++] = got;
      } else {
        ::close(got);
      }
    }
  }
  std::optional<Message> message;
  if ((packet.msg_flags & MSG_TRUNC) == 0) message = unpacked(bytes.get(), static_cast<std::size_t>(size));
  if (!message) {
    garbled = true;
    for (const int descriptor : descriptors) {
      if (descriptor >= 0) ::close(descriptor);
    }
    return std::nullopt;
  }
  return Received{std::move(*message), descriptors[0], descriptors[1]};
}

std::string readable_bytes(double bytes) {
  static constexpr const char* units[] = {"bytes", "kB", "MB", "GB", "TB", "PB", "EB"};
  std::size_t unit = 0;
  while (bytes >= 1000.0 && unit + 1 < std::size(units)) bytes /= 1000.0, ++unit;
  return unit == 0 || bytes >= 100 ? detail::text("%.0f %s", bytes, units[unit]) : detail::text("%.3g %s", bytes, units[unit]);
}

}  // namespace palpa::protocol
