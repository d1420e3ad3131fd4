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
#include "palpa/file/store_protocol.h"

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

StoreContents sample_contents() {
  StoreContents contents;
  contents.format = "OME-Zarr 0.4, Zarr v2", contents.length_unit = "um", contents.length_unit_assumed = true;
  contents.fields = {{"p", "Pa", "int8", VoxelType::int16, 1, -3.0}, {"u", "", "float32", VoxelType::float32, 3, 0.0}};
  for (const std::int64_t side : {200, 100}) {
    StoreOctave octave{.chunk = {32, 16, 8}, .shard = {64, 64, 64}, .codec = "blosc (lz4, bitshuffle)", .facts = {4, 4, 4}};
    octave.grid.dims = {side, side, side};
    octave.grid.index_to_world_m = {{{1e-6, 0, 0}, {0, 2e-6, 0}, {0, 0, 3e-6}}};
    octave.grid.origin_m = {1, 2, 3};
    contents.octaves.push_back(octave);
  }
  contents.frames = 5, contents.period_s = 0.25, contents.prepared = true, contents.warnings = {"one", "two"};
  return contents;
}

TEST(Protocol, MessagesOfStoresComeBackAsTheyWere) {
  const StoreContents contents = sample_contents();
  const auto packet = packed(contents);
  const auto back = unpacked(packet.data(), packet.size());
  ASSERT_TRUE(back && std::holds_alternative<StoreContents>(*back));
  EXPECT_EQ(std::get<StoreContents>(*back), contents);
  const StoreChunk chunk{1, 4, 1, true, {-1, 1LL << 40, 3}};
  for (const Message& message : {Message(StoreRoom{16, 65536}), Message(ChunkRequest{chunk, 7}),
                                 Message(ChunkAnswer{chunk, 7, ChunkState::damaged, 99, "'0/1': is cut"}),
                                 Message(FetchRequest{3, "0/1/2/3", 64, 1 << 20, true, 1 << 26}),
                                 Message(FetchAnswer{3, FetchState::failed, 64, 1 << 27, true, "its server answers 403"})}) {
    const auto bytes = packed(message);
    const auto again = unpacked(bytes.data(), bytes.size());
    ASSERT_TRUE(again);
    EXPECT_EQ(again->index(), message.index());
    EXPECT_EQ(packed(*again), bytes);
  }
  auto bytes = packed(ChunkAnswer{chunk, 7, static_cast<ChunkState>(3), 99, ""});
  EXPECT_FALSE(unpacked(bytes.data(), bytes.size()));
  bytes = packed(FetchAnswer{3, static_cast<FetchState>(3), 0, 0, false, ""});
  EXPECT_FALSE(unpacked(bytes.data(), bytes.size()));
}

TEST(Protocol, ContentsOfStoresAreChecked) {
  EXPECT_EQ(problem_with(sample_contents()), nullptr);
  const auto is_refused = [](const auto& change) {
    StoreContents contents = sample_contents();
    change(contents);
    return problem_with(contents) != nullptr;
  };
  EXPECT_TRUE(is_refused([](StoreContents& c) { c.fields.clear(); }));
  EXPECT_TRUE(is_refused([](StoreContents& c) { c.fields[1].components = 2; }));
  EXPECT_TRUE(is_refused([](StoreContents& c) { c.octaves.clear(); }));
  EXPECT_TRUE(is_refused([](StoreContents& c) { c.octaves.resize(25, c.octaves[0]); }));
  EXPECT_TRUE(is_refused([](StoreContents& c) { c.octaves[0].grid.dims[1] = 0; }));
  EXPECT_TRUE(is_refused([](StoreContents& c) { c.octaves[0].grid.dims[1] = (1 << 18) + 1; }));
  EXPECT_TRUE(is_refused([](StoreContents& c) { c.octaves[1].chunk[2] = -1; }));
  EXPECT_TRUE(is_refused(
      [](StoreContents& c) { c.octaves[1].chunk = {1 << 18, 1 << 18, 1 << 18}, c.octaves[1].shard = c.octaves[1].chunk; }));
  EXPECT_TRUE(is_refused([](StoreContents& c) { c.octaves[1].shard[2] = 12; }));
  EXPECT_TRUE(is_refused([](StoreContents& c) { c.octaves[1].facts = {65, 65, 65}; }));
  EXPECT_TRUE(is_refused([](StoreContents& c) { c.octaves[1].facts = {0, 4, 4}; }));
  EXPECT_TRUE(is_refused([](StoreContents& c) { c.octaves[0].grid.origin_m.x = std::numeric_limits<double>::quiet_NaN(); }));
  EXPECT_TRUE(is_refused([](StoreContents& c) { c.octaves[0].grid.index_to_world_m.row[1] = {}; }));
  EXPECT_TRUE(is_refused([](StoreContents& c) { c.frames = 0; }));
  EXPECT_TRUE(is_refused([](StoreContents& c) { c.period_s = -1.0; }));
}

TEST(Protocol, SlotsHoldEveryChunkThatHasAPlace) {
  const StoreContents contents = sample_contents();
  EXPECT_EQ(content_bytes(contents, {}), 32u * 16 * 8 * 2);
  EXPECT_EQ(content_bytes(contents, {.field = 1}), 32u * 16 * 8 * 12);
  EXPECT_EQ(content_bytes(contents, {.facts = true}), 64u * 32);
  EXPECT_EQ(content_bytes(contents, {.presence = true}), 64u);
  EXPECT_EQ(slot_bytes(contents), 65536u);
  EXPECT_TRUE(has_place(contents, {.octave = 1, .frame = 4, .field = 1, .at = {3, 6, 12}}));
  EXPECT_FALSE(has_place(contents, {.octave = 1, .at = {4, 0, 0}}));
  EXPECT_TRUE(has_place(contents, {.facts = true, .at = {1, 3, 6}}));
  EXPECT_FALSE(has_place(contents, {.facts = true, .at = {2, 3, 6}}));
  EXPECT_TRUE(has_place(contents, {.at = {1, 3, 6}, .presence = true}));
  EXPECT_FALSE(has_place(contents, {.at = {2, 3, 6}, .presence = true}));
  EXPECT_FALSE(has_place(contents, {.facts = true, .presence = true}));
  for (const StoreChunk& chunk :
       {StoreChunk{.octave = 2}, {.octave = -1}, {.frame = 5}, {.frame = -1}, {.field = 2}, {.at = {0, 0, -1}}})
    EXPECT_FALSE(has_place(contents, chunk));
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
