// Messages of a far hand: what is written is read, and bytes of any origin give values within the ranges or none.
#include "palpa/far/message.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <type_traits>
#include <vector>

namespace palpa {
namespace message_test {

using Bytes = std::vector<std::byte>;

/// Random messages with any values that may be sent.
class AnyMessages {
 public:
  explicit AnyMessages(unsigned seed) : random_(seed) {}
  double real(double low, double high) { return std::uniform_real_distribution(low, high)(random_); }
  float single(double low, double high) { return static_cast<float>(real(low, high)); }
  template <class Number>
  Number whole(Number low, Number high) {
    return static_cast<Number>(std::uniform_int_distribution<std::int64_t>(low, high)(random_));
  }
  Vec3 vector(double most) { return {real(-most, most), real(-most, most), real(-most, most)}; }
  Vec3 short_vector(double most) { return {single(-most, most), single(-most, most), single(-most, most)}; }
  Vec3 direction() { return normalized(vector(1.0) + Vec3{1e-9, 0.0, 0.0}); }
  template <std::size_t N>
  void letters(std::array<char, N>& text) {
    for (char& letter : text) letter = whole<char>('a', 'z');
  }
  std::mt19937& generator() { return random_; }

  void fill(HandHello& m) {
    for (auto& byte : m.token) byte = whole<std::uint8_t>(0, 255);
    m.role = whole(0, 1) == 0 ? HandHello::Role::touch : HandHello::Role::watch;
    m.max_force_n = real(0, 20), m.max_stiffness_n_per_m = real(0, 1e4);
    m.max_damping_ns_per_m = std::numeric_limits<double>::infinity(), m.encoder_step_m = real(0, 1e-4);
    letters(m.name);
  }
  void fill(DataWelcome& m) {
    m.scene = whole<std::uint32_t>(0, 1000);
    m.stiffness_n_per_m = real(1, 3000), m.damping_ns_per_m = real(0, 5), m.max_force_n = real(0, 10);
    m.impact_ns_per_m = real(0, 10);
    m.modes = whole<std::uint16_t>(0, DataWelcome::most_modes);
    for (std::size_t n = 0; n < m.modes; ++n) letters(m.names[n]);
  }
  void fill(ProbeReport& m) {
    m.newest = whole<std::uint64_t>(0, 1'000'000);
    m.count = whole<std::uint8_t>(1, ProbeReport::most_samples);
    for (std::size_t n = 0; n < m.count; ++n)
      m.samples[n] = {vector(0.2), single(1e-4, 1.0), whole<std::uint32_t>(0, 15), whole(0, 1) == 1};
    m.proxy_m = vector(0.2), m.command_n = short_vector(5), m.command_nm = short_vector(0.1);
    m.guard = static_cast<GuardState>(whole(0, 7)), m.cause = static_cast<GuardCause>(whole(0, 12));
    m.model_age_s = single(0, 1), m.model = whole<std::uint64_t>(0, 1000), m.echo_us = whole<std::uint64_t>(0, 1u << 30);
    m.held_s = single(0, 1), m.account_j = single(-0.1, 0.1), m.link_total_j = single(-10, 10);
  }
  void fill(ModelUpdate& m) {
    m.answers = whole<std::uint64_t>(0, 1'000'000), m.scene = whole<std::uint32_t>(0, 9);
    m.echo_us = whole<std::uint64_t>(0, 1u << 30);
    m.held_s = single(0, 0.1), m.ahead_s = single(0, 0.04), m.valid_m = single(0, 0.01), m.proxy_m = vector(0.2);
    m.count = whole<std::uint16_t>(0, ModelUpdate::most_rows);
    for (std::int32_t n = 0; n < m.count; ++n) {
      ModelRow& row = m.rows[static_cast<std::size_t>(n)];
      row.kind = static_cast<PrimitiveKind>(whole(0, 4));
      row.rides = whole(0, 1), row.ahead = whole(0, 1), row.is_facet = whole(0, 1);
      row.mode = whole<std::uint16_t>(0, 65535), row.slot = whole<std::uint16_t>(0, 65535);
      row.plane = whole<std::int32_t>(-1, n - 1);
      row.strength_n = single(0, 9), row.drag_ns_per_m = single(0, 9), row.coefficient = single(0, 2);
      row.stiffness_n_per_m = whole(0, 1) ? single(1, 2000) : std::numeric_limits<float>::infinity();
      row.offset_m = short_vector(0.01), row.velocity_m_per_s = short_vector(1.0);
      row.direction = row.kind == PrimitiveKind::point ? Vec3{} : direction();
    }
  }
  void fill(ModelEvent& m) {
    m.kind = static_cast<ModelEvent::Kind>(whole(0, 3)), m.mode = whole<std::int32_t>(-1, 60);
    m.sample = whole<std::uint64_t>(0, 1'000'000), m.value = real(-1e6, 1e6), m.depth_m = single(0, 0.1);
    letters(m.text);
  }

 private:
  std::mt19937 random_;
};

template <class Message>
Bytes bytes_of(const Message& message, std::uint64_t time_us = 7) {
  Bytes bytes(most_message_bytes);
  bytes.resize(write_message(message, time_us, bytes));
  return bytes;
}

bool is_within(double value, double low, double high) { return value >= low && value <= high; }
bool is_usable(const Vec3& v) {
  return is_within(v.x, -largest_position_m, largest_position_m) && is_within(v.y, -largest_position_m, largest_position_m) &&
         is_within(v.z, -largest_position_m, largest_position_m);
}
bool is_within_ranges(const HandHello& m) {
  return m.max_force_n >= 0 && m.max_stiffness_n_per_m >= 0 && m.max_damping_ns_per_m >= 0 && m.encoder_step_m >= 0;
}
bool is_within_ranges(const DataWelcome& m) {
  return m.stiffness_n_per_m > 0 && std::isfinite(m.stiffness_n_per_m) && is_within(m.damping_ns_per_m, 0, 1e9) &&
         is_within(m.max_force_n, 0, 1e9) && is_within(m.impact_ns_per_m, 0, 1e9) && m.modes <= DataWelcome::most_modes;
}
bool is_within_ranges(const ProbeReport& m) {
  bool is_sound = m.count >= 1 && m.count <= ProbeReport::most_samples && is_usable(m.proxy_m) && is_usable(m.command_n) &&
                  is_usable(m.command_nm) && m.guard <= GuardState::off && m.cause <= GuardCause::link_closed &&
                  is_within(m.model_age_s, 0, 1e6) && is_within(m.held_s, 0, 1e6);
  for (std::size_t n = 0; n < m.count && is_sound; ++n) {
    is_sound = is_usable(m.samples[n].position_m) && m.samples[n].time_step_s > 0 && m.samples[n].time_step_s <= 1;
  }
  return is_sound;
}
bool is_within_ranges(const ModelUpdate& m) {
  bool is_sound = m.count <= ModelUpdate::most_rows && is_usable(m.proxy_m) && is_within(m.held_s, 0, 1e6) &&
                  is_within(m.ahead_s, 0, 1) && is_within(m.valid_m, 0, 1e6);
  for (std::size_t n = 0; n < m.count && is_sound; ++n) {
    const ModelRow& row = m.rows[n];
    const double length = norm(row.direction);
    is_sound = row.kind <= PrimitiveKind::corner && row.plane >= -1 && row.plane < static_cast<std::int32_t>(n) &&
               is_within(row.strength_n, 0, 1e9) && is_within(row.drag_ns_per_m, 0, 1e9) && row.stiffness_n_per_m > 0 &&
               is_within(row.coefficient, 0, 1e9) && is_usable(row.offset_m) && is_usable(row.velocity_m_per_s) &&
               (length == 0.0 || std::abs(length - 1.0) < 1e-12);
  }
  return is_sound;
}
bool is_within_ranges(const ModelEvent& m) {
  return m.kind <= ModelEvent::Kind::warning && m.mode >= -1 && std::isfinite(m.value) && is_within(m.depth_m, 0, 1e6);
}

/// Directions are made unit again, which changes their rounding.
template <class Message>
void take_directions_of(const Message& sent, Message& read) {
  if constexpr (std::is_same_v<Message, ModelUpdate>) {
    for (std::size_t n = 0; n < sent.count; ++n) {
      EXPECT_LT(distance(sent.rows[n].direction, read.rows[n].direction), 1e-7);
      read.rows[n].direction = sent.rows[n].direction;
    }
  }
}

template <class Message>
class FarMessages : public testing::Test {};
using Kinds = testing::Types<HandHello, DataWelcome, ProbeReport, ModelUpdate, ModelEvent>;
TYPED_TEST_SUITE(FarMessages, Kinds);

// Reading and writing once more gives the bytes; and the head is of this kind, this length and this time.
TYPED_TEST(FarMessages, AreReadAsTheyWereWritten) {
  AnyMessages any(1);
  for (int n = 0; n < 500; ++n) {
    TypeParam sent{}, read{};
    any.fill(sent);
    const Bytes bytes = bytes_of(sent, static_cast<std::uint64_t>(n));
    ASSERT_GT(bytes.size(), 0u);
    ASSERT_TRUE(head_of(bytes));
    EXPECT_EQ(head_of(bytes)->bytes, bytes.size());
    EXPECT_EQ(head_of(bytes)->time_us, static_cast<std::uint64_t>(n));
    ASSERT_TRUE(read_message(bytes, read)) << n;
    take_directions_of(sent, read);
    EXPECT_EQ(bytes_of(read, static_cast<std::uint64_t>(n)), bytes) << n;
  }
}

TYPED_TEST(FarMessages, CutOrWithMoreBytesAreRefused) {
  AnyMessages any(2);
  TypeParam sent{}, read{};
  any.fill(sent);
  Bytes bytes = bytes_of(sent);
  for (std::size_t length = 0; length < bytes.size(); ++length)
    EXPECT_FALSE(read_message(std::span(bytes).first(length), read)) << length;
  bytes.push_back(std::byte{0});
  EXPECT_FALSE(read_message(bytes, read));
  // Likewise with a head that agrees.
  for (const std::size_t length : {std::size_t{16}, bytes.size() - 2, bytes.size()}) {
    bytes.resize(length);
    bytes[4] = static_cast<std::byte>(length), bytes[5] = static_cast<std::byte>(length >> 8);
    EXPECT_FALSE(read_message(bytes, read)) << length;
  }
  Bytes small(bytes.size() - 2);
  EXPECT_EQ(write_message(sent, 7, small), 0u);
}

// A hostile peer: flipped bits, random bytes behind a head that agrees.
TYPED_TEST(FarMessages, OfAnyBytesAreWithinTheRanges) {
  AnyMessages any(3);
  int accepted = 0;
  for (int n = 0; n < 20'000; ++n) {
    TypeParam sent{}, read{};
    any.fill(sent);
    Bytes bytes = bytes_of(sent);
    if (n % 4 == 0) {
      for (std::size_t at = 16; at < bytes.size(); ++at) bytes[at] = static_cast<std::byte>(any.whole(0, 255));
    } else {
      for (int flips = any.whole(1, 4); flips > 0; --flips)
        bytes[any.whole<std::size_t>(0, bytes.size() - 1)] ^= static_cast<std::byte>(1 << any.whole(0, 7));
    }
    if (!read_message(bytes, read)) continue;
    ++accepted;
    EXPECT_TRUE(is_within_ranges(read)) << n;
  }
  EXPECT_GT(accepted, 1000);
}

TEST(FarMessagesOfModels, HaveTheLayoutThatIsDocumented) {
  ModelUpdate model;
  const std::size_t empty = bytes_of(model).size();
  model.count = 1;
  model.rows[0] = {.strength_n = 2.0f, .direction = {0, 0, 1}};
  const Bytes bytes = bytes_of(model);
  EXPECT_EQ(bytes.size() - empty, 60u);
  EXPECT_EQ(bytes[0], std::byte{1});
  EXPECT_EQ(bytes[2], std::byte{4});
  EXPECT_EQ(bytes[empty], std::byte{2});  // a plane
  float strength_n = 0.0f;
  std::memcpy(&strength_n, &bytes[empty + 8], sizeof strength_n);
  EXPECT_EQ(strength_n, 2.0f);
}

}  // namespace message_test
}  // namespace palpa
