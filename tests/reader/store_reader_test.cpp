// StoreReader, places of octaves, samples of chunks.
#include <gmock/gmock.h>
#include <poll.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <thread>

#include "palpa/file/octave_places.h"
#include "palpa/file/store_survey.h"
#include "store_test.h"

namespace palpa::test {
namespace store_reader_test {

using testing::HasSubstr;

class StoreReaderTest : public StoreTest {
 protected:
  /// The only child of this process.
  static pid_t child() { return child_process(); }
  static void signal_child(int number) {
    const pid_t pid = child();
    ASSERT_GT(pid, 0);
    ::kill(pid, number);
  }
};

TEST_F(StoreReaderTest, ReadsChunksOfAllOctavesInAnyOrder) {
  write_zarr_image(at("a"), 64, 2, "blosc", ramp);
  StoreReader reader = open(at("a"), 7);
  EXPECT_EQ(reader.slots(), 7);
  EXPECT_EQ(reader.contents().octaves.size(), 3u);
  std::vector<StoreChunk> all;
  for (std::int32_t octave = 0; octave < 3; ++octave)
    for (std::int64_t n = 0; n < (64 >> octave) / 16; ++n) all.push_back({.octave = octave, .at = {n, 0, n}});
  std::size_t count = 0;
  read_chunks(reader, all, [&](const StoreRead& read, std::span<const std::byte> content) {
    EXPECT_EQ(read.state, ChunkState::present);
    EXPECT_EQ(content.size(), 16u * 16 * 16 * 2);
    ++count;
  });
  EXPECT_EQ(count, all.size());
  expect_voxels(reader, {}, ramp);
}

TEST_F(StoreReaderTest, WaitsNoLongerThanAskedAndBecomesReadable) {
  write_zarr_image(at("a"), 32, 2, "raw", ramp);
  StoreReader reader = open(at("a"));
  EXPECT_FALSE(reader.next(0.0));
  EXPECT_FALSE(reader.next(0.05));
  reader.request({}, 2);
  pollfd ready{reader.descriptor(), POLLIN, 0};
  EXPECT_EQ(::poll(&ready, 1, 10'000), 1);
  const auto read = reader.next(0.0);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->slot, 2);
  EXPECT_EQ(read->bytes, 8192u);
}

TEST_F(StoreReaderTest, RefusesWrongSlotsAndChunks) {
  write_zarr_image(at("a"), 32, 2, "raw", ramp);
  StoreReader reader = open(at("a"), 2);
  EXPECT_THROW(reader.request({}, 2), std::invalid_argument);
  EXPECT_THROW(reader.request({}, -1), std::invalid_argument);
  for (const StoreChunk& chunk : {StoreChunk{.octave = 3},
                                  {.octave = -1},
                                  {.frame = 1},
                                  {.field = 1},
                                  {.facts = true},
                                  {.at = {2, 0, 0}},
                                  {.at = {0, -1, 0}}})
    EXPECT_THROW(reader.request(chunk, 0), std::invalid_argument);
  reader.request({}, 0);
  EXPECT_THROW(reader.request({}, 0), std::invalid_argument);
  EXPECT_THROW(StoreReader(at("a"), options_, 0), std::invalid_argument);
}

TEST_F(StoreReaderTest, LeavesNoChildAndNoDescriptor) {
  write_zarr_image(at("a"), 32, 2, "raw", ramp);
  const auto descriptors = [] { return std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator()); };
  const auto before = descriptors();
  {
    StoreReader reader = open(at("a"));
    reader.request({}, 0);
    EXPECT_NE(child(), 0);
  }
  EXPECT_EQ(descriptors(), before);
  EXPECT_EQ(child(), 0);
}

TEST_F(StoreReaderTest, OutlivesTheThreadThatOpenedIt) {
  write_zarr_image(at("a"), 32, 2, "raw", ramp);
  std::unique_ptr<StoreReader> reader;
  std::thread([&] { reader = std::make_unique<StoreReader>(at("a"), options_, 4); }).join();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));  // until the program would be ended
  expect_voxels(*reader, {}, ramp);
}

TEST_F(StoreReaderTest, HasThePriorityOfTheThreadThatOpensIt) {
  write_zarr_image(at("a"), 32, 2, "raw", ramp);
  const int before = ::getpriority(PRIO_PROCESS, 0), lower = std::min(before + 3, 19);
  std::unique_ptr<StoreReader> reader;
  std::thread([&] {
    ::setpriority(PRIO_PROCESS, 0, lower);  // of this thread alone
    reader = std::make_unique<StoreReader>(at("a"), options_, 4);
  }).join();
  EXPECT_EQ(::getpriority(PRIO_PROCESS, static_cast<id_t>(child())), lower);
  expect_voxels(*reader, {}, ramp);
  reader = std::make_unique<StoreReader>(at("a"), options_, 4);
  EXPECT_EQ(::getpriority(PRIO_PROCESS, static_cast<id_t>(child())), before);
}

TEST_F(StoreReaderTest, AProgramThatIsKilledIsSaidInOneLineForEver) {
  write_zarr_image(at("a"), 32, 2, "raw", ramp);
  StoreReader reader = open(at("a"));
  ASSERT_NE(child(), 0);
  signal_child(SIGKILL);
  const std::string first = error_of([&] {
    for (int n = 0; n < 100; ++n) reader.next(0.1);
  });
  EXPECT_THAT(first, HasSubstr("was ended by signal 9"));
  EXPECT_THAT(first, testing::StartsWith(at("a").string() + ": "));
  EXPECT_EQ(error_of([&] { reader.request({}, 0); }), first);
  EXPECT_EQ(error_of([&] { reader.next(0.0); }), first);
}

TEST_F(StoreReaderTest, AHungProgramIsEndedWhileARequestIsPendingOnly) {
  write_zarr_image(at("a"), 32, 2, "raw", ramp);
  options_.idle_limit_s = 0.5;
  StoreReader reader = open(at("a"));
  signal_child(SIGSTOP);
  EXPECT_FALSE(reader.next(1.0));
  reader.request({}, 0);
  const std::string error = error_of([&] {
    for (int n = 0; n < 100; ++n) reader.next(0.1);
  });
  EXPECT_THAT(error, HasSubstr("made no progress for 0.5 s and was ended; check that the disk answers"));
  EXPECT_EQ(child(), 0);
}

TEST_F(StoreReaderTest, AProgramThatTakesNoMessageIsEnded) {
  write_zarr_image(at("a"), 32, 2, "raw", ramp);
  options_.idle_limit_s = 0.5;
  StoreReader reader = open(at("a"), 4000);
  signal_child(SIGSTOP);
  EXPECT_THAT(error_of([&] {
                for (int n = 0; n < 4000; ++n) reader.request({}, n);
              }),
              HasSubstr("took no message for 0.5 s and was ended"));
}

TEST_F(StoreReaderTest, FactsAreReadInTheirOwnChunks) {
  write_zarr_image(at("a"), 64, 2, "raw", ramp);
  ZarrToWrite facts{.shape = {1, 1, 4, 4, 4, 4}, .chunk = {1, 1, 2, 2, 2, 4}, .type = "float64", .codec = "blosc"};
  facts.value = [](const std::vector<std::int64_t>& v) {
    return static_cast<double>(1000 * v[2] + 100 * v[3] + 10 * v[4] + v[5]);
  };
  write_zarr_array(at("a") / "palpa/facts/0", facts);
  StoreReader reader = open(at("a"));
  EXPECT_TRUE(reader.contents().prepared);
  EXPECT_EQ(reader.contents().octaves[0].facts, (std::array<std::int64_t, 3>{2, 2, 2}));
  EXPECT_EQ(reader.contents().octaves[1].facts[0], 0);
  reader.request({.facts = true, .at = {1, 0, 0}}, 0);
  const auto read = reader.next(10.0);
  ASSERT_TRUE(read);
  const std::span<const std::byte> content = reader.content(0);
  ASSERT_EQ(content.size(), 8 * sizeof(ChunkFacts));
  ChunkFacts second;
  std::memcpy(&second, &content[1 * sizeof second], sizeof second);
  EXPECT_EQ(second.min, 30.0);
  EXPECT_EQ(second.crc32, 33.0);
  EXPECT_THROW(reader.request({.octave = 1, .facts = true}, 0), std::invalid_argument);
  facts.shape[2] = 5;
  write_zarr_array(at("a") / "palpa/facts/0", facts);
  const StoreReader other = open(at("a"));
  EXPECT_FALSE(other.contents().prepared);
  EXPECT_THAT(other.contents().warnings, testing::Contains(HasSubstr("facts in 'palpa/facts/0' that are not used")));
}

class Octaves : public PythonStores {
 protected:
  OctavePlaces places(const std::string& name) const {
    StoreReader reader = open(stores() / name);
    return octave_places(reader);
  }
  /// Expects octaves that begin at `share` of their first voxels' way, in voxels of octave 0.
  static void expect_places(const OctavePlaces& places, double share) {
    for (std::size_t n = 0; n < places.octaves.size(); ++n) {
      const double expected_m = 1e-6 * share * (std::ldexp(1.0, static_cast<int>(n)) - 1.0);
      EXPECT_NEAR(norm(places.octaves[n].grid.origin_m - Vec3{expected_m, expected_m, expected_m}), 0.0, 1e-15) << n;
    }
  }
};

TEST_F(Octaves, OfScaleAloneArePlacedByTheirVoxels) {
  for (const std::string type : {"u1 ", "f4 "}) {
    for (const auto& [rule, making, share, warns] : {std::tuple{"means", OctaveMaking::means, 0.5, true},
                                                     {"every second", OctaveMaking::decimation, 0.0, false},
                                                     {"the second of each pair", OctaveMaking::decimation, 1.0, true}}) {
      SCOPED_TRACE(type + rule);
      const OctavePlaces found = places("octaves " + type + rule);
      EXPECT_EQ(found.making, making);
      expect_places(found, share);
      EXPECT_EQ(found.warnings.size(), warns ? 1u : 0u);
    }
  }
  EXPECT_EQ(places("octaves u1 means, cut").making, OctaveMaking::means);
}

TEST_F(Octaves, ThatSayTheirPlacesAreCheckedAgainstTheirVoxels) {
  for (const char* rule : {"means", "every second"})
    EXPECT_THAT(places(std::string("octaves right ") + rule).warnings, testing::IsEmpty()) << rule;
  const OctavePlaces wrong = places("octaves wrong every second");
  expect_places(wrong, 0.0);
  EXPECT_THAT(wrong.warnings, testing::ElementsAre(HasSubstr("elsewhere than their voxels are, which are every second voxel")));
}

TEST_F(Octaves, OfNeitherKindOrConstantStayWhereTheFileSays) {
  for (const char* type : {"u1", "f4"}) {
    const OctavePlaces other = places(std::string("octaves ") + type + " other");
    EXPECT_EQ(other.making, OctaveMaking::neither);
    EXPECT_THAT(other.warnings, testing::ElementsAre(HasSubstr("they are not felt")));
  }
  EXPECT_EQ(places("octaves constant").making, OctaveMaking::undecided);
  EXPECT_THAT(places("octaves constant").warnings, testing::IsEmpty());
  const StoreReader flat = open(stores() / "octaves flat");
  EXPECT_EQ(flat.contents().octaves.size(), 1u);
  EXPECT_EQ(places("octaves flat").making, OctaveMaking::none);
}

class Survey : public StoreReaderTest {
 protected:
  StoreSurvey surveyed(const std::string& name) const {
    StoreReader reader = open(at(name), 8);
    return survey(reader, 60.0, 60.0);
  }
};

TEST_F(Survey, CountsLostChunksButNotThoseOfTheFillValue) {
  write_zarr_image(at("a"), 64, 2, "raw", [](auto i, auto j, auto k) { return i < 16 ? 0.0 : 1.0 + ramp(i, j, k); });
  EXPECT_EQ(surveyed("a").absent, 0);
  for (int n = 0; n < 4; ++n) fs::remove(at("a") / "0/1/1" / std::to_string(n));  // the first has the fill value
  const StoreSurvey found = surveyed("a");
  EXPECT_EQ(found.chunks, 64.0);
  EXPECT_EQ(found.looked_at, 64);
  EXPECT_EQ(found.absent, 4);
  EXPECT_EQ(found.lost, 3);
  EXPECT_EQ(found.damaged, 0);
  EXPECT_TRUE(found.can_tell_lost);
}

TEST_F(Survey, FindsTheRangeOfFiniteValuesWithinTheOctave) {
  write("a", {.shape = {20, 20, 20}, .chunk = {16, 16, 16}, .type = "float32", .fill = "\"NaN\"", .value = [](const auto& v) {
                return v[0] == 19 && v[1] == 19 && v[2] == 19 ? -7.5 : v[0] == 0 ? std::nan("") : 100.0;
              }});
  const StoreSurvey found = surveyed("a");
  EXPECT_EQ(found.values[0].min, -7.5);
  EXPECT_EQ(found.values[0].max, 100.0);
  EXPECT_TRUE(found.values[0].about);
  EXPECT_DOUBLE_EQ(found.stored_share, 1.0);
  EXPECT_FALSE(found.can_tell_lost);
}

TEST_F(Survey, OfAPreparedStoreIsOfItsFacts) {
  write_zarr_image(at("a"), 64, 2, "raw", ramp);
  ZarrToWrite facts{.shape = {1, 1, 4, 4, 4, 4}, .chunk = {1, 1, 4, 4, 4, 4}, .type = "float64"};
  facts.value = [&](const std::vector<std::int64_t>& v) {
    std::string bytes;
    for (std::int64_t n = 0; n < 4096; ++n)
      bytes += bytes_of(static_cast<std::int16_t>(ramp(16 * v[4] + n % 16, 16 * v[3] + n / 16 % 16, 16 * v[2] + n / 256)));
    const auto sum = ::crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
    return v[5] == 0 ? -3.0 : v[5] == 1 ? 250.0 : v[5] == 2 ? 1.0 : static_cast<double>(sum);
  };
  write_zarr_array(at("a") / "palpa/facts/0", facts);
  StoreSurvey found = surveyed("a");
  EXPECT_EQ(found.values[0].min, -3.0);
  EXPECT_EQ(found.values[0].max, 250.0);
  EXPECT_FALSE(found.values[0].about);
  EXPECT_EQ(found.damaged, 0) << found.damage;
  EXPECT_EQ(found.lost, 0);
  fs::remove(at("a") / "0/2/1/0");
  write_text_file(at("a") / "0/2/2/2", std::string(8192, 'x'));
  found = surveyed("a");
  EXPECT_EQ(found.lost, 1);
  EXPECT_EQ(found.damaged, 1);
  EXPECT_THAT(found.damage, HasSubstr("has changed since palpa prepare"));
  StoreReader reader = open(at("a"));
  found = survey(reader, 60.0, 60.0, true);  // facts alone
  EXPECT_EQ(found.values[0].max, 250.0);
  EXPECT_EQ(found.lost, 1);
  EXPECT_EQ(found.looked_at, 0);
}

class Presence : public Survey, public testing::WithParamInterface<int> {
 protected:
  bool has_shards() const { return GetParam() == 3; }
  /// [chunks] More than are decoded where they are no files of their own.
  std::int64_t side() const { return has_shards() ? 18 : 8; }
  std::int64_t all() const { return side() * side() * side(); }
  /// Chunks of 2³ voxels, in shards of 9³ chunks where the format has them, without those that `has_chunk` leaves out; facts
  /// in blocks of 4³ chunks.
  void write_store(const std::function<bool(const std::vector<std::int64_t>&)>& has_chunk) {
    write_zarr_group(at("a"), multiscales(1, false, has_shards() ? "0.5" : "0.4"), GetParam());
    const std::int64_t n = side();
    ZarrToWrite array{.format = GetParam(), .shape = {2 * n, 2 * n, 2 * n}, .chunk = {2, 2, 2}};
    if (has_shards()) array.shard = {18, 18, 18};
    array.value = [](const auto& v) { return v[0] < 2 ? 0.0 : 7.0; };
    array.has_chunk = has_chunk;
    write_zarr_array(at("a") / "0", array);
    ZarrToWrite facts{.shape = {1, 1, n, n, n, 4}, .chunk = {1, 1, 4, 4, 4, 4}, .type = "float64"};
    const std::string bytes(8, 7);
    const auto sum = static_cast<double>(::crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
    facts.value = [sum](const std::vector<std::int64_t>& v) {
      if (v[2] == 0) return 0.0;  // the fill value
      return v[5] == 3 ? sum : v[5] == 2 ? 0.0 : 7.0;
    };
    write_zarr_array(at("a") / "palpa/facts/0", facts);
  }
};

TEST_P(Presence, OfEveryChunkIsThatOfTheStore) {
  const auto has_chunk = [](const std::vector<std::int64_t>& c) { return (c[0] + 3 * c[1] + 5 * c[2]) % 7 != 0; };
  write_store(has_chunk);
  StoreReader reader = open(at("a"), 4);
  std::vector<StoreChunk> blocks;
  const std::int64_t along = (side() + 3) / 4;
  for (std::int64_t n = 0; n < along * along * along; ++n)
    blocks.push_back({.at = {n % along, n / along % along, n / along / along}, .presence = true});
  std::int64_t count = 0;
  read_chunks(reader, blocks, [&](const StoreRead& read, std::span<const std::byte> content) {
    ASSERT_EQ(read.state, ChunkState::present);
    ASSERT_EQ(content.size(), 64u);
    for (std::int64_t n = 0; n < 64; ++n) {
      const auto& b = read.chunk.at;
      const std::vector<std::int64_t> c{4 * b[2] + n / 16, 4 * b[1] + n / 4 % 4, 4 * b[0] + n % 4};
      const bool is_there = std::ranges::all_of(c, [&](std::int64_t index) { return index < side(); });
      EXPECT_EQ(content[static_cast<std::size_t>(n)] == std::byte{1}, is_there && has_chunk(c));
      count += is_there;
    }
  });
  EXPECT_EQ(count, all());
}

TEST_P(Presence, NoLostChunkOfAPreparedStoreIsMissed) {
  const auto is_lost = [&](const std::vector<std::int64_t>& c) {
    const std::int64_t last = side() - 1;
    return c == std::vector<std::int64_t>{7, 3, 5} || c == std::vector<std::int64_t>{last, last, last} || c[0] == 0;
  };
  write_store([&](const auto& c) { return !is_lost(c); });
  const StoreSurvey found = surveyed("a");
  EXPECT_EQ(found.looked_for, all());
  EXPECT_EQ(found.lost, 2);
  EXPECT_EQ(found.absent, 2 + side() * side());
  EXPECT_EQ(found.looked_at, std::min<std::int64_t>(4096, all() - found.absent));
  EXPECT_EQ(found.damaged, 0) << found.damage;
  EXPECT_EQ(std::pair(found.values[0].min, found.values[0].max), std::pair(0.0, 7.0));
  EXPECT_FALSE(found.values[0].about);

  StoreReader reader = open(at("a"), 8);
  const StoreSurvey late = survey(reader, 60.0, 0.0);  // no time for facts
  EXPECT_LE(late.looked_for, 4096);
  EXPECT_TRUE(late.values[0].about);
}

TEST_P(Presence, OfADamagedShardOrFactsIsSaid) {
  write_store([](const auto&) { return true; });
  write_text_file(at("a") / "palpa/facts/0/0/0/1/1/1/0", "short");
  if (has_shards()) write_text_file(at("a") / "0/c/1/1/1", "short");
  const StoreSurvey found = surveyed("a");
  EXPECT_GE(found.damaged, 1);
  EXPECT_TRUE(found.values[0].about);
  EXPECT_LT(found.looked_for, all());
}

INSTANTIATE_TEST_SUITE_P(Versions, Presence, testing::Values(2, 3));

TEST(WasteOfChunks, IsOneOfSmallChunksAndLargeOfPlanes) {
  StoreOctave octave;
  octave.grid.dims = {1024, 1024, 1024};
  octave.chunk = {32, 32, 32};
  EXPECT_DOUBLE_EQ(waste_of_chunks(octave), 1.0);
  octave.chunk = {1024, 1024, 1};
  EXPECT_DOUBLE_EQ(waste_of_chunks(octave), 64.0);
}

}  // namespace store_reader_test
}  // namespace palpa::test
