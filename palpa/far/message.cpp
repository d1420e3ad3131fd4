#include "palpa/far/message.h"

#include <bit>
#include <cmath>
#include <concepts>
#include <cstring>
#include <type_traits>

namespace palpa {

namespace {

constexpr std::size_t head_bytes = 16;
/// [1] Furthest from unit length that a direction may be. More: a wrong peer is not noticed; less: rounding to f32 is refused.
constexpr double most_off_unit = 1e-3;
constexpr double most_time_s = 1.0;  // of a tick
constexpr double longest_s = 1e6;    // that anything is held
constexpr double most_energy_j = 1e9;
constexpr double infinity = std::numeric_limits<double>::infinity();

template <class Number>
using Bits = std::conditional_t<sizeof(Number) == 1, std::uint8_t,
                                std::conditional_t<sizeof(Number) == 2, std::uint16_t,
                                                   std::conditional_t<sizeof(Number) == 4, std::uint32_t, std::uint64_t>>>;

/// Appends numbers. Without room it writes no further.
class MessageWriter {
 public:
  explicit MessageWriter(std::span<std::byte> to) noexcept : to_(to) {}
  template <class Number>
    requires std::is_arithmetic_v<Number> || std::is_enum_v<Number>
  void number(Number value) noexcept {
    const auto bits = std::bit_cast<Bits<Number>>(value);
    for (std::size_t n = 0; n < sizeof value; ++n, ++at_)
      if (at_ < to_.size()) to_[at_] = static_cast<std::byte>(bits >> (8 * n));
  }
  void range(double, double, double) noexcept {}
  void vector(const Vec3& v) noexcept { number(v.x), number(v.y), number(v.z); }
  void short_vector(const Vec3& v) noexcept {
    number(static_cast<float>(v.x)), number(static_cast<float>(v.y)), number(static_cast<float>(v.z));
  }
  void unit_or_zero(const Vec3& v) noexcept { short_vector(v); }
  void refuse_if(bool is_wrong) noexcept { is_sound_ = is_sound_ && !is_wrong; }
  /// [bytes] written; 0: some had no room, or a number is out of range.
  std::size_t bytes() const noexcept { return is_sound_ && at_ <= to_.size() ? at_ : 0; }

 private:
  std::span<std::byte> to_;
  std::size_t at_ = 0;
  bool is_sound_ = true;
};

/// Takes numbers from the beginning on. Beyond the end, or where one is not finite, it takes zeros and is no longer sound.
class MessageReader {
 public:
  explicit MessageReader(std::span<const std::byte> from) noexcept : from_(from) {}
  template <class Number>
    requires std::is_arithmetic_v<Number> || std::is_enum_v<Number>
  void number(Number& value) noexcept {
    value = Number{};
    refuse_if(from_.size() - at_ < sizeof value);
    if (!is_sound_) return;
    Bits<Number> bits = 0;
    for (std::size_t n = 0; n < sizeof value; ++n)
      bits = static_cast<Bits<Number>>(bits | static_cast<Bits<Number>>(from_[at_ + n]) << (8 * n));
    at_ += sizeof value;
    if constexpr (std::is_same_v<Number, bool>) {
      refuse_if(bits > 1);
      value = bits == 1;
    } else {
      value = std::bit_cast<Number>(bits);
    }
    if constexpr (std::is_floating_point_v<Number>) {
      refuse_if(std::isnan(value));
      if (std::isnan(value)) value = Number{};
    }
  }
  /// The value must be within low…high.
  void range(double value, double low, double high) noexcept { refuse_if(!(value >= low && value <= high)); }
  void vector(Vec3& v) noexcept {
    number(v.x), number(v.y), number(v.z);
    within_reach(v);
  }
  void short_vector(Vec3& v) noexcept {
    float x = 0.0f, y = 0.0f, z = 0.0f;
    number(x), number(y), number(z);
    v = {x, y, z};
    within_reach(v);
  }
  void unit_or_zero(Vec3& v) noexcept {
    short_vector(v);
    const double length = norm(v);
    refuse_if(length != 0.0 && !(std::abs(length - 1.0) <= most_off_unit));
    v = is_sound_ && length > 0.0 ? v / length : Vec3{};
  }
  void refuse_if(bool is_wrong) noexcept { is_sound_ = is_sound_ && !is_wrong; }
  bool is_sound() const noexcept { return is_sound_; }
  bool is_whole() const noexcept { return is_sound_ && at_ == from_.size(); }

 private:
  void within_reach(Vec3& v) noexcept {
    for (const double c : {v.x, v.y, v.z}) range(c, -largest_position_m, largest_position_m);
    if (!is_sound_) v = {};
  }

  std::span<const std::byte> from_;
  std::size_t at_ = 0;
  bool is_sound_ = true;
};

/// Takes or gives a number that must be within low…high.
template <class Archive, class Number>
void bounded(Archive& a, Number& value, double low, double high) noexcept {
  a.number(value);
  a.range(static_cast<double>(value), low, high);
  if constexpr (!std::is_const_v<Number> && std::same_as<Archive, MessageReader>) {
    if (!a.is_sound()) value = Number{};
  }
}

/// Takes or gives an enumerator from `first` to `last`.
template <class Archive, class Enum>
void named(Archive& a, Enum& value, std::type_identity_t<std::remove_const_t<Enum>> first,
           std::type_identity_t<std::remove_const_t<Enum>> last) noexcept {
  a.number(value);
  a.refuse_if(value < first || value > last);
  if constexpr (!std::is_const_v<Enum>) {
    if (value < first || value > last) value = first;
  }
}

// ---- the layout of each kind, for both directions ----

template <class Archive, class Message>
  requires std::same_as<std::remove_const_t<Message>, HandHello>
void fields(Archive& a, Message& m) noexcept {
  for (auto& byte : m.token) a.number(byte);
  named(a, m.role, HandHello::Role::touch, HandHello::Role::watch);
  for (auto* limit : {&m.max_force_n, &m.max_stiffness_n_per_m, &m.max_damping_ns_per_m, &m.encoder_step_m})
    bounded(a, *limit, 0.0, infinity);
  for (auto& letter : m.name) a.number(letter);
}

template <class Archive, class Message>
  requires std::same_as<std::remove_const_t<Message>, DataWelcome>
void fields(Archive& a, Message& m) noexcept {
  a.number(m.scene);
  bounded(a, m.stiffness_n_per_m, std::numeric_limits<double>::min(), largest_drag_ns_per_m);
  for (auto* gain : {&m.damping_ns_per_m, &m.max_force_n, &m.impact_ns_per_m}) bounded(a, *gain, 0.0, largest_strength_n);
  bounded(a, m.modes, 0, DataWelcome::most_modes);
  for (std::size_t n = 0; n < m.modes && n < m.names.size(); ++n)
    for (auto& letter : m.names[n]) a.number(letter);
}

template <class Archive, class Message>
  requires std::same_as<std::remove_const_t<Message>, ProbeReport>
void fields(Archive& a, Message& m) noexcept {
  a.number(m.newest);
  bounded(a, m.count, 1, ProbeReport::most_samples);
  for (std::size_t n = 0; n < m.count && n < m.samples.size(); ++n) {
    auto& sample = m.samples[n];
    a.vector(sample.position_m);
    bounded(a, sample.time_step_s, std::numeric_limits<float>::min(), most_time_s);
    a.number(sample.buttons), a.number(sample.valid);
  }
  a.vector(m.proxy_m);
  a.short_vector(m.command_n), a.short_vector(m.command_nm);
  named(a, m.guard, GuardState::pass, GuardState::off);
  named(a, m.cause, GuardCause::none, GuardCause::link_closed);
  bounded(a, m.model_age_s, 0.0, longest_s);
  a.number(m.model), a.number(m.echo_us);
  bounded(a, m.held_s, 0.0, longest_s);
  bounded(a, m.account_j, -most_energy_j, most_energy_j);
  bounded(a, m.link_total_j, -most_energy_j, most_energy_j);
}

template <class Archive, class Row>
  requires std::same_as<std::remove_const_t<Row>, ModelRow>
void row_fields(Archive& a, Row& row, std::int32_t number) noexcept {
  named(a, row.kind, PrimitiveKind::point, PrimitiveKind::corner);
  auto flags = static_cast<std::uint8_t>(row.rides | row.ahead << 1 | row.is_facet << 2);
  auto plane = static_cast<std::uint8_t>(row.plane + 1);
  a.number(flags);
  a.number(row.mode), a.number(row.slot);
  a.number(plane);
  std::uint8_t reserved = 0;
  a.number(reserved);
  a.refuse_if(flags > 7 || reserved != 0 || plane > number);
  if constexpr (std::is_const_v<Row>) {
    a.refuse_if(row.plane < -1 || row.plane >= number);
  } else {
    row.rides = flags & 1, row.ahead = flags & 2, row.is_facet = flags & 4;
    row.plane = plane > number ? -1 : std::int32_t{plane} - 1;
  }
  bounded(a, row.strength_n, 0.0, largest_strength_n);
  bounded(a, row.drag_ns_per_m, 0.0, largest_drag_ns_per_m);
  a.number(row.stiffness_n_per_m);
  a.range(row.stiffness_n_per_m, softest_level_n_per_m, infinity);
  bounded(a, row.coefficient, 0.0, largest_strength_n);
  a.short_vector(row.offset_m);
  a.unit_or_zero(row.direction);
  a.short_vector(row.velocity_m_per_s);
  for (const double part : {row.velocity_m_per_s.x, row.velocity_m_per_s.y, row.velocity_m_per_s.z})
    a.refuse_if(std::abs(part) > ModelRow::fastest_m_per_s);
}

template <class Archive, class Message>
  requires std::same_as<std::remove_const_t<Message>, ModelUpdate>
void fields(Archive& a, Message& m) noexcept {
  a.number(m.answers), a.number(m.scene), a.number(m.echo_us);
  bounded(a, m.held_s, 0.0, longest_s);
  bounded(a, m.ahead_s, 0.0, most_time_s);
  bounded(a, m.valid_m, 0.0, largest_position_m);
  a.vector(m.proxy_m);
  bounded(a, m.count, 0, ModelUpdate::most_rows);
  for (std::size_t n = 0; n < m.count && n < m.rows.size(); ++n) row_fields(a, m.rows[n], static_cast<std::int32_t>(n));
}

template <class Archive, class Message>
  requires std::same_as<std::remove_const_t<Message>, ModelEvent>
void fields(Archive& a, Message& m) noexcept {
  named(a, m.kind, ModelEvent::Kind::onset, ModelEvent::Kind::warning);
  bounded(a, m.mode, -1, 65535);
  a.number(m.sample);
  bounded(a, m.value, -std::numeric_limits<double>::max(), std::numeric_limits<double>::max());
  bounded(a, m.depth_m, 0.0, largest_position_m);
  for (auto& letter : m.text) a.number(letter);
}

template <class Message>
constexpr MessageHead::Kind kind_of() {
  using Kind = MessageHead::Kind;
  if constexpr (std::same_as<Message, HandHello>) return Kind::hello;
  if constexpr (std::same_as<Message, DataWelcome>) return Kind::welcome;
  if constexpr (std::same_as<Message, ProbeReport>) return Kind::probes;
  if constexpr (std::same_as<Message, ModelUpdate>) return Kind::model;
  return Kind::event;
}

void write_head(MessageWriter& writer, MessageHead::Kind kind, std::size_t bytes, std::uint64_t time_us) noexcept {
  writer.number(message_version);
  writer.number(kind);
  writer.number(std::uint8_t{0});
  writer.number(static_cast<std::uint32_t>(bytes));
  writer.number(time_us);
}

template <class Message>
std::size_t written(const Message& message, std::uint64_t time_us, std::span<std::byte> to) noexcept {
  to = to.first(std::min(to.size(), most_message_bytes));
  if (to.size() < head_bytes) return 0;
  MessageWriter body(to.subspan(head_bytes));
  fields(body, message);
  if (body.bytes() == 0) return 0;
  const std::size_t bytes = head_bytes + body.bytes();
  MessageWriter head(to.first(head_bytes));
  write_head(head, kind_of<Message>(), bytes, time_us);
  return bytes;
}

template <class Message>
bool was_read(std::span<const std::byte> from, Message& message) noexcept {
  const std::optional<MessageHead> head = head_of(from);
  if (!head || head->kind != kind_of<Message>()) return false;
  MessageReader body(from.subspan(head_bytes));
  fields(body, message);
  return body.is_whole();
}

}  // namespace

std::optional<MessageHead> head_of(std::span<const std::byte> message) noexcept {
  MessageReader reader(message);
  MessageHead head;
  std::uint16_t version = 0;
  std::uint8_t zero = 0;
  reader.number(version);
  named(reader, head.kind, MessageHead::Kind::hello, MessageHead::Kind::event);
  reader.number(zero), reader.number(head.bytes), reader.number(head.time_us);
  const bool is_whole = reader.is_sound() && version == message_version && zero == 0 && head.bytes == message.size() &&
                        message.size() <= most_message_bytes;
  return is_whole ? std::optional(head) : std::nullopt;
}

std::size_t write_message(const HandHello& hello, std::uint64_t time_us, std::span<std::byte> to) noexcept {
  return written(hello, time_us, to);
}
std::size_t write_message(const DataWelcome& welcome, std::uint64_t time_us, std::span<std::byte> to) noexcept {
  return written(welcome, time_us, to);
}
std::size_t write_message(const ProbeReport& report, std::uint64_t time_us, std::span<std::byte> to) noexcept {
  return written(report, time_us, to);
}
std::size_t write_message(const ModelUpdate& model, std::uint64_t time_us, std::span<std::byte> to) noexcept {
  return written(model, time_us, to);
}
std::size_t write_message(const ModelEvent& event, std::uint64_t time_us, std::span<std::byte> to) noexcept {
  return written(event, time_us, to);
}

bool read_message(std::span<const std::byte> message, HandHello& hello) noexcept { return was_read(message, hello); }
bool read_message(std::span<const std::byte> message, DataWelcome& welcome) noexcept { return was_read(message, welcome); }
bool read_message(std::span<const std::byte> message, ProbeReport& report) noexcept { return was_read(message, report); }
bool read_message(std::span<const std::byte> message, ModelUpdate& model) noexcept { return was_read(message, model); }
bool read_message(std::span<const std::byte> message, ModelEvent& event) noexcept { return was_read(message, event); }

}  // namespace palpa
