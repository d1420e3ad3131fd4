// StoreReader, places of octaves, samples of chunks.
#include <gmock/gmock.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>
#include <zlib.h>

#include <cmath>
#include <fstream>

#include "palpa/file/octave_places.h"
#include "palpa/file/store_survey.h"
#include "store_test.h"

namespace palpa::test {
namespace store_reader_test {

using testing::HasSubstr;

class StoreReaderTest : public StoreTest {
 protected:
  /// The only child of this process.
  static pid_t child() {
    std::ifstream children("/proc/self/task/" + std::to_string(::getpid()) + "/children");
    pid_t pid = 0;
    children >> pid;
    return pid;
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

TEST_F(StoreReaderTest, AProgramThatIsKilledIsSaidInOneLineForEver) {
  write_zarr_image(at("a"), 32, 2, "raw", ramp);
  StoreReader reader = open(at("a"));
  ASSERT_NE(child(), 0);
  ::kill(child(), SIGKILL);
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
  ::kill(child(), SIGSTOP);
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
  ::kill(child(), SIGSTOP);
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
    return survey(reader, 60.0);
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
}

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
