// `palpa info` of stores.
#include "app/info_store.h"

#include <gmock/gmock.h>

#include <chrono>

#include "app/info.h"
#include "palpa/file/protocol.h"
#include "zarr_file.h"

namespace palpa::app {
namespace info_store_test {

namespace fs = std::filesystem;
using test::ZarrToWrite;
using testing::HasSubstr;

class InfoStore : public test::ReaderTest {
 protected:
  fs::path at(const std::string& name) const { return folder_.path() / name; }
  std::optional<StoreFacts> facts(const std::string& name) const {
    Asked asked{at(name).string(), {}};
    asked.request.files = {at(name)};
    return store_facts_of(asked, options_);
  }
  /// Printed words, and JSON.
  InfoTable table(const std::string& name) const {
    const auto found = facts(name);
    EXPECT_TRUE(found);
    return found ? store_table(*found) : InfoTable{};
  }
  static double value(std::int64_t i, std::int64_t j, std::int64_t k) { return static_cast<double>((i * j + 31 * k) % 97); }
};

TEST_F(InfoStore, SaysOctavesChunksLossAndRange) {
  test::write_zarr_image(at("a"), 64, 3, "zstd", value);
  const InfoTable told = table("a");
  for (const char* part :
       {"grid      64 × 64 × 64 voxels of 1 µm × 1 µm × 1 µm\n", "size      64 µm × 64 µm × 64 µm, 524 kB as a whole\n",
        "store     OME-Zarr 0.5, Zarr v3, about ", "octaves   3, down to 16 × 16 × 16 voxels: means of 2 × 2 × 2 voxels\n",
        "chunks    16 × 16 × 16 voxels, zstd, in shards of 32 × 32 × 32\n", "lost      none of all 64 chunks\n",
        "prepared  no; palpa prepare ", "about 0 ", "about 96\n", "of a sample of chunks: the range may be larger\n"})
    EXPECT_THAT(told.words, HasSubstr(part));
  const auto& json = told.json.at("store");
  EXPECT_EQ(json.at("octaves_made_by"), "means");
  EXPECT_EQ(json.at("octaves").size(), 3u);
  EXPECT_EQ(json.at("octaves")[1].at("chunk"), (std::array<std::int64_t, 3>{16, 16, 16}));
  EXPECT_EQ(json.at("fields")[0].at("max"), 96.0);
  EXPECT_EQ(json.at("chunks_lost"), 0);
}

TEST_F(InfoStore, SaysWhatPlanesCost) {
  test::write_zarr_group(at("planes"), test::multiscales(1, false));
  ZarrToWrite array{.shape = {4, 600, 600}, .chunk = {1, 600, 600}};
  array.value = [](const auto&) { return 1.0; };
  test::write_zarr_array(at("planes") / "0", array);
  EXPECT_THAT(table("planes").words, HasSubstr("a window of 128 × 128 × 128 voxels reads 22 times too much; palpa convert "));
  EXPECT_THAT(table("planes").words, HasSubstr("octaves   1; palpa prepare makes coarser ones"));
}

TEST_F(InfoStore, SaysLostAndDamagedChunksWithTheirFile) {
  test::write_zarr_image(at("a"), 64, 2, "blosc", value);
  fs::remove(at("a") / "0/1/2/3");
  test::write_text_file(at("a") / "0/3/3/3", "no blosc");
  const InfoTable told = table("a");
  EXPECT_THAT(told.words,
              HasSubstr("lost      1 of all 64 chunks: absent, where the next octave has values; get them again\n"));
  EXPECT_THAT(told.words,
              HasSubstr("damaged   1 of 64 chunks that were looked at: '0/3/3/3': has an invalid header of blosc\n"));
}

TEST_F(InfoStore, OfSixteenTerabytesTakesNoTimeAndReadsNothingElse) {
  test::write_zarr_group(at("huge"), test::multiscales(2, false));
  for (int n = 0; n < 2; ++n) {
    const std::string side = std::to_string(20'000 >> n);
    test::write_text_file(
        at("huge") / std::to_string(n) / ".zarray",
        R"({"zarr_format":2,"shape":[)" + side + "," + side + "," + side +
            R"(],"chunks":[32,32,32],"dtype":"<i2","compressor":null,"fill_value":-5,"order":"C","filters":null})");
  }
  const auto found = facts("huge");
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->is_large());
  const InfoTable told = store_table(*found);
  EXPECT_THAT(told.words, HasSubstr("16 TB as a whole"));
  EXPECT_THAT(told.words, HasSubstr(" are absent, and have the fill value\n"));
  EXPECT_EQ(told.json.at("store").at("fields")[0].at("max"), -5.0);
  InfoArguments arguments;
  arguments.files = {at("huge")}, arguments.read = options_, arguments.scene = true;
  EXPECT_THAT(test::error_of([&] { run_info(arguments); }), HasSubstr("`palpa prepare` makes the rest"));
}

TEST_F(InfoStore, ReadsChunksThatAreTooLargeToBeFeltAsAWholeUpToALimit) {
  const auto write = [&](const std::string& shape) {
    test::write_zarr_group(at("one"), test::multiscales(1, false));
    test::write_text_file(
        at("one/0/.zarray"),
        R"({"zarr_format":2,"shape":[)" + shape +
            R"(],"chunks":[400,300,300],"dtype":"|u1","compressor":null,"fill_value":7,"order":"C","filters":null})");
  };
  InfoArguments arguments;
  arguments.files = {at("one")}, arguments.read = options_;
  write("4000,300,3000");
  EXPECT_FALSE(facts("one"));
  EXPECT_THAT(test::error_of([&] { run_info(arguments); }), HasSubstr("3.6 GB where 512 MB are allowed"));
  write("400,300,300");
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_info(arguments), 0);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("300 × 300 × 400 voxels"));
}

TEST_F(InfoStore, IsOfStoresAlone) {
  folder_.write("a.nrrd", "NRRD0004\n");
  EXPECT_FALSE(facts("a.nrrd"));
  fs::create_directory(at("none"));
  EXPECT_FALSE(facts("none"));
}

}  // namespace info_store_test
}  // namespace palpa::app
