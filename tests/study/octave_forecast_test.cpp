// The loader's policy in virtual time: the need is bounded by the tick, not by the hand.
#include "palpa/study/octave_forecast.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "palpa/study/expected_octaves.h"

namespace palpa {
namespace {

OctaveForecast forecast(double speed_m_per_s, double voxel_hand_m, const ChunkSupply& supply = {}, double duration_s = 4.0) {
  const std::vector<std::array<std::int64_t, 3>> chunks(6, {32, 32, 32});
  ForecastStore store;
  store.finest.dims = {4096, 4096, 4096};
  store.finest.index_to_world_m = Mat3{{{1e-6, 0, 0}, {0, 1e-6, 0}, {0, 0, 1e-6}}};
  store.chunks = chunks;
  const auto hand = simulated_target("sim:random,speed_m_per_s=0.1");
  const Vec3 start_m = hand->at(0.0).position_m;
  const double scale = 1e-6 / voxel_hand_m;
  const Vec3 middle_m{2.048e-3, 2.048e-3, 2.048e-3};
  return forecast_octaves(store, *hand, {.scale = scale, .translation_m = middle_m - scale * start_m}, speed_m_per_s / 0.1,
                          duration_s, supply);
}

// Law 6 of docs/large.md.
TEST(OctaveForecasts, NeedFewChunksAtAnySpeedAndZoom) {
  for (const double voxel_m : {36.6e-6, 293e-6, 2342e-6}) {
    for (const double speed_m_per_s : {0.01, 0.1, 0.5, 3.0}) {
      const OctaveForecast felt = forecast(speed_m_per_s, voxel_m, {.chunk_s = 0.0, .window_s = 0.0}, 2.0);
      EXPECT_LE(felt.chunks_per_s, 1750.0) << speed_m_per_s << " m/s, " << voxel_m << " m";
    }
  }
}

TEST(OctaveForecasts, FeelFinerAtASlowerHandAndAFasterSource) {
  const double slow = forecast(0.02, 36.6e-6).felt.mean, fast = forecast(0.4, 36.6e-6).felt.mean;
  EXPECT_LT(slow, fast);
  EXPECT_GT(forecast(0.02, 36.6e-6).felt.finest_share, 0.9);
  const double starved = forecast(0.02, 36.6e-6, {.chunk_s = 20e-3, .at_once = 1}).felt.mean;
  EXPECT_GT(starved, slow + 0.5);
  const OctaveForecast nothing = forecast(0.02, 36.6e-6, {.chunk_s = 1e3});
  EXPECT_EQ(nothing.felt.mean, 5.0) << "without windows the coarsest octave is felt";
}

StoreContents contents_of(std::int64_t side, int octaves) {
  StoreContents contents;
  contents.fields.push_back({.name = "v", .unit = "", .file_type = "uint8"});
  for (int n = 0; n < octaves; ++n) {
    StoreOctave octave;
    octave.grid.dims = {side >> n, side >> n, side >> n};
    const double spacing_m = 1e-6 * (1 << n);
    octave.grid.index_to_world_m = Mat3{{{spacing_m, 0, 0}, {0, spacing_m, 0}, {0, 0, spacing_m}}};
    octave.chunk = octave.shard = {32, 32, 32};
    contents.octaves.push_back(octave);
  }
  return contents;
}

TEST(ExpectedOctaves, AreCoarserOfASlowerStoreAndSaySo) {
  const StoreContents contents = contents_of(4096, 6);
  const OctaveExpectation disk = expected_octaves(contents, 6, 36.6e-6, 0.15e-3);
  EXPECT_FALSE(disk.is_too_slow);
  EXPECT_THAT(words_of(disk), testing::Not(testing::HasSubstr("TOO SLOWLY")));
  EXPECT_GT(disk.forecasts[0].felt.as_fine_as_way_share, 0.95);
  const OctaveExpectation slow = expected_octaves(contents, 6, 36.6e-6, 20e-3);
  EXPECT_TRUE(slow.is_too_slow);
  EXPECT_THAT(words_of(slow), testing::HasSubstr("TOO SLOWLY"));
  for (int speed = 0; speed < 2; ++speed)
    EXPECT_LT(slow.forecasts[speed].felt.finest_share, disk.forecasts[speed].felt.finest_share - 0.05);
}

TEST(ExpectedOctaves, OfTwoFieldsAreThoseOfAStoreThatIsHalfAsFast) {
  const StoreContents contents = contents_of(4096, 6);
  const OctaveExpectation two = expected_octaves(contents, 6, 36.6e-6, 2e-3, 2),
                          one = expected_octaves(contents, 6, 36.6e-6, 2e-3);
  EXPECT_LT(two.forecasts[0].felt.finest_share, one.forecasts[0].felt.finest_share);
  EXPECT_GT(two.forecasts[0].chunks_per_s, one.forecasts[0].chunks_per_s);
}

TEST(ExpectedOctaves, DependOnTheZoomAlone) {
  StoreContents contents = contents_of(2048, 5), larger = contents;
  for (StoreOctave& octave : larger.octaves)
    for (Vec3& row : octave.grid.index_to_world_m.row) row = 1024.0 * row;
  const auto share = [](const StoreContents& of) {
    return expected_octaves(of, 5, 100e-6, 1e-3).forecasts[1].felt.finest_share;
  };
  EXPECT_EQ(share(contents), share(larger));
}

}  // namespace
}  // namespace palpa
