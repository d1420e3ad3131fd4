#include "palpa/file/protocol.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>
#include <limits>
#include <random>

#include "palpa/base/load_error.h"
#include "palpa/file/protocol_memory.h"

namespace palpa::protocol {
namespace protocol_test {

Header sample_header() {
  Header header;
  header.format = "nrrd", header.length_unit = "mm", header.default_unit = "mm";
  header.medical_frame = true, header.frames = 4, header.working_bytes = 12345678901234;
  for (const char* name : {"a", "b"}) {
    FieldHeader field;
    field.name = name, field.unit = "cm/s", field.type = VoxelType::int16, field.components = 3;
    field.grid.dims = {3, 5, 7};
    field.grid.index_to_world_m = {{{1, 2, 3}, {4, 5, 6}, {7, 8, 10}}};
    field.grid.origin_m = {-1, 0.5, 1e300};
    field.scale = 0.1, field.offset = -1024;
    header.fields.push_back(field);
  }
  header.warnings = {"one", "two"};
  header.series = {{"1.2.3", "CT 2 head", 28}}, header.labels = {{"liver", "", 3}}, header.alternatives = {{"/u", "2 × 3", 6}};
  header.scan = {{ScanFactKind::body_part, "head"}, {ScanFactKind::tube_voltage_kv, {}, 120.0}};
  return header;
}

TEST(Protocol, EveryMessageComesBackAsItWas) {
  const Header header = sample_header();
  const auto packet = packed(header);
  const auto back = unpacked(packet.data(), packet.size());
  ASSERT_TRUE(back && std::holds_alternative<Header>(*back));
  EXPECT_EQ(packed(*back), packet);
  EXPECT_EQ(std::get<Header>(*back).fields[1].grid, header.fields[1].grid);
  for (const Message& message : {Message(Request{"/a b/c", "vector", 3, 99}), Message(ReadRequest{{0, 1, 7}}),
                                 Message(Done{{{"x.raw", 12, "abcd"}}, {"w"}}), Message(Failure{"is wrong; do right"})}) {
    const auto bytes = packed(message);
    const auto again = unpacked(bytes.data(), bytes.size());
    ASSERT_TRUE(again);
    EXPECT_EQ(again->index(), message.index());
    EXPECT_EQ(packed(*again), bytes);
  }
}

TEST(Protocol, ListsOfPartsAreCutWhereAPacketHoldsNoMore) {
  Header header = sample_header();
  header.series.assign(5000, {"1.2.3", std::string(100, 'x'), 1});
  header.labels.assign(900, {std::string(9000, 'y'), "", 1});
  const auto packet = packed(header);
  EXPECT_LT(packet.size(), max_packet_bytes / 2);
  const auto back = unpacked(packet.data(), packet.size());
  ASSERT_TRUE(back);
  EXPECT_GT(std::get<Header>(*back).series.size(), 100u);
  EXPECT_GT(std::get<Header>(*back).labels.size(), 1u);
  EXPECT_EQ(std::get<Header>(*back).fields.size(), header.fields.size());
}

TEST(Protocol, PathsComeBackByteByByteAndWordsWithoutControlCharacters) {
  const std::string any = "a\tb\nc\033d\x7f\xff\u0085";
  Request request{any, "", 0, 1};
  request.partners = {any}, request.inside = any;
  const auto asked = packed(request);
  const Message back = unpacked(asked.data(), asked.size()).value();
  EXPECT_EQ(std::get<Request>(back).path, any);
  EXPECT_EQ(std::get<Request>(back).partners, request.partners);
  EXPECT_EQ(std::get<Request>(back).inside, any);
  const auto done = packed(Done{{{any, 12, "abcd"}}, {any}});
  const Message told = unpacked(done.data(), done.size()).value();
  EXPECT_EQ(std::get<Done>(told).files[0].path, any);
  EXPECT_EQ(std::get<Done>(told).warnings[0].substr(0, 7), "a b c d");
}

TEST(Protocol, WhatIsCutOrTooLongIsNoMessage) {
  for (const Message& message :
       {Message(sample_header()), Message(Request{"p", "", 0, 1}), Message(ReadRequest{{1}}), Message(Failure{"x"})}) {
    auto packet = packed(message);
    for (std::size_t size = 0; size < packet.size(); ++size) EXPECT_FALSE(unpacked(packet.data(), size)) << size;
    packet.push_back(std::byte{0});
    EXPECT_FALSE(unpacked(packet.data(), packet.size()));
  }
}

TEST(Protocol, AnyBytesAreAMessageOrNone) {
  std::mt19937 random(1);
  const auto packet = packed(sample_header());
  for (int n = 0; n < 20'000; ++n) {
    auto bytes = packet;
    for (int m = 0; m < 3; ++m) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
    if (const auto message = unpacked(bytes.data(), bytes.size()); message && std::holds_alternative<Header>(*message)) {
      const auto& header = std::get<Header>(*message);
      for (const FieldHeader& field : header.fields) {
        EXPECT_LE(static_cast<int>(field.type), static_cast<int>(VoxelType::float64));
        voxel_bytes(field);
      }
    }
  }
}

TEST(Protocol, FactsOfAScanAreShortPlainWordsAndFiniteNumbers) {
  const auto passes = [](const ScanFact& fact) {
    Header header = sample_header();
    header.scan = {fact};
    const auto packet = packed(header);
    const auto back = unpacked(packet.data(), packet.size());
    return back && std::get<Header>(*back).scan == header.scan;
  };
  EXPECT_TRUE(passes({ScanFactKind::protocol, "head routine"}));
  EXPECT_TRUE(passes({ScanFactKind::echo_time_ms, {}, 2.98}));
  EXPECT_FALSE(passes({ScanFactKind::protocol, std::string(97, 'a')}));
  EXPECT_FALSE(passes({ScanFactKind::protocol,
                       "Sch\xc3\xa4"
                       "del"}));
  EXPECT_FALSE(passes({ScanFactKind::protocol, "a\x1b[1m"}));
  EXPECT_FALSE(passes({ScanFactKind::echo_time_ms, {}, std::numeric_limits<double>::infinity()}));
  EXPECT_FALSE(passes({static_cast<ScanFactKind>(scan_fact_kinds), "x"}));
}

TEST(Protocol, AnotherVersionIsNoMessage) {
  auto packet = packed(Failure{"x"});
  packet[4] = static_cast<std::byte>(version + 1);
  EXPECT_FALSE(unpacked(packet.data(), packet.size()));
}

TEST(Protocol, TextOfAFileCannotBreakALine) {
  const auto packet = packed(Failure{"a\nb\x1b[31mc\x7f"});
  EXPECT_EQ(std::get<Failure>(*unpacked(packet.data(), packet.size())).sentence, "a b [31mc ");
}

TEST(Protocol, SizesThatOverflowAreNone) {
  FieldHeader field;
  field.type = VoxelType::float64;
  field.grid.dims = {1'000'000'000'000, 1'000'000'000, 1};
  EXPECT_FALSE(voxel_bytes(field));
  field.grid.dims = {10, 0, 10};
  EXPECT_FALSE(voxel_bytes(field));
  field.grid.dims = {10, -10, -10};
  EXPECT_FALSE(voxel_bytes(field));
  field.grid.dims = {10, 10, 10};
  EXPECT_EQ(voxel_bytes(field), 8000U);
  field.components = 2;
  EXPECT_FALSE(voxel_bytes(field));
  field.components = 3;
  field.grid.dims = {1 << 20, 1 << 20, 1 << 19};
  Header header;
  header.fields = {field, field, field};
  EXPECT_FALSE(place(header, {{0, 1, 2}}));
}

TEST(Protocol, SizesBeyondAnyMemoryAreNone) {
  FieldHeader field;
  field.type = VoxelType::uint16;
  field.grid.dims = {1 << 20, 1 << 20, 1 << 21};
  EXPECT_EQ(voxel_bytes(field), std::uint64_t{1} << 62);
  field.components = 3;
  field.grid.dims = {1 << 20, 1 << 20, 1 << 20};
  EXPECT_FALSE(voxel_bytes(field));
}

TEST(Protocol, FieldsDoNotOverlap) {
  const Header header = sample_header();
  const auto offsets = place(header, {{0, 1}});
  ASSERT_TRUE(offsets);
  ASSERT_EQ(offsets->size(), 3U);
  EXPECT_EQ((*offsets)[0], 0U);
  for (std::size_t f = 0; f < 2; ++f) {
    EXPECT_GE((*offsets)[f + 1], (*offsets)[f] + *voxel_bytes(header.fields[f]));
    EXPECT_EQ((*offsets)[f + 1] % 64, 0U);
  }
  EXPECT_FALSE(place(header, {{0, 2}}));
  EXPECT_FALSE(place(header, {{1, 0}}));
  EXPECT_FALSE(place(header, {{1, 1}}));
}

/// Files for a memory.
struct Files : MemoryFiles {
  explicit Files(std::uint64_t bytes) {
    const std::uint64_t in_first = bytes_in_first(bytes);
    const auto made = [](std::uint64_t of) {
      const int file = ::memfd_create("test", MFD_CLOEXEC);
      EXPECT_EQ(::ftruncate(file, static_cast<off_t>(of)), 0);
      return file;
    };
    first = made(in_first);
    if (bytes > in_first) second = made(bytes - in_first);
  }
  ~Files() {
    ::close(first);
    if (second >= 0) ::close(second);
  }
  Files(const Files&) = delete;
  Files& operator=(const Files&) = delete;
};

TEST(Protocol, AMemoryInTwoFilesIsOne) {
  for (const std::uint64_t bytes : {std::uint64_t{64}, std::uint64_t{1} << 24, (std::uint64_t{1} << 24) + 12352}) {
    const Files files(bytes);
    EXPECT_EQ(files.second >= 0, bytes > 1'000'000);
    const Memory to = mapped(files, bytes, true);
    std::vector<std::byte> expected(bytes);
    std::mt19937 random(7);
    const auto write = [&](std::uint64_t at, std::uint64_t count) {
      std::vector<std::byte> piece(count);
      for (std::byte& b : piece) b = static_cast<std::byte>(random());
      to.write(to.all.get() + at, piece.data(), count);
      std::copy(piece.begin(), piece.end(), expected.begin() + static_cast<std::ptrdiff_t>(at));
    };
    const std::uint64_t middle = bytes_in_first(bytes);
    write(0, bytes);
    for (int n = 0; n < 20; ++n) {
      const std::uint64_t at = random() % bytes;
      write(at, random() % (bytes - at));
    }
    if (middle < bytes) write(middle - 3, 7), write(middle, 5), write(middle - 5, 5);
    EXPECT_EQ(std::memcmp(to.all.get(), expected.data(), bytes), 0);
    EXPECT_EQ(std::memcmp(mapped(files, bytes, false).all.get(), expected.data(), bytes), 0);
  }
}

TEST(Protocol, AMemoryThatIsTooSmallIsRefused) {
  const std::uint64_t bytes = 1 << 25;
  const Files files(bytes);
  EXPECT_THROW(mapped({files.first, -1}, bytes, true), LoadError);
  EXPECT_THROW(mapped({-1, files.second}, bytes, true), LoadError);
  ASSERT_EQ(::ftruncate(files.second, 100), 0);
  EXPECT_THROW(mapped(files, bytes, true), LoadError);
}

TEST(Protocol, DescriptorsTravelWithMessages) {
  int pair[2], pipe_ends[2];
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, pair), 0);
  ASSERT_EQ(::pipe(pipe_ends), 0);
  EXPECT_TRUE(send(pair[0], ReadRequest{{0}}, pipe_ends[1]));
  bool garbled = true;
  const auto received = receive(pair[1], garbled);
  ASSERT_TRUE(received);
  EXPECT_FALSE(garbled);
  ASSERT_GE(received->descriptor, 0);
  EXPECT_EQ(::write(received->descriptor, "x", 1), 1);
  char c = 0;
  EXPECT_EQ(::read(pipe_ends[0], &c, 1), 1);

  // Two at once, and a peeked message comes again.
  EXPECT_TRUE(send(pair[0], ReadRequest{{1}}, pipe_ends[1], pipe_ends[0]));
  for (const bool take : {false, true}) {
    const auto both = receive(pair[1], garbled, take);
    ASSERT_TRUE(both);
    EXPECT_EQ(std::get<ReadRequest>(both->message).fields, std::vector<std::uint32_t>{1});
    EXPECT_EQ(::write(both->descriptor, "y", 1), 1);
    EXPECT_EQ(::read(both->second_descriptor, &c, 1), 1);
    EXPECT_EQ(c, 'y');
    ::close(both->descriptor), ::close(both->second_descriptor);
  }
  EXPECT_EQ(::send(pair[0], "nonsense", 8, 0), 8);
  EXPECT_FALSE(receive(pair[1], garbled));
  EXPECT_TRUE(garbled);
  ::close(pair[0]);
  EXPECT_FALSE(receive(pair[1], garbled));
  EXPECT_FALSE(garbled);
  EXPECT_FALSE(send(pair[1], ReadRequest{{0}}));  // and no SIGPIPE
  for (const int descriptor : {pair[1], pipe_ends[0], pipe_ends[1], received->descriptor}) ::close(descriptor);
}

TEST(Protocol, BytesReadLikeWords) {
  EXPECT_EQ(readable_bytes(999), "999 bytes");
  EXPECT_EQ(readable_bytes(14'200'000), "14.2 MB");
  EXPECT_EQ(readable_bytes(2e12), "2 TB");
  EXPECT_EQ(readable_bytes(512e9), "512 GB");
}

}  // namespace protocol_test
}  // namespace palpa::protocol
