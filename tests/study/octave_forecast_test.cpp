// The loader's policy in virtual time: the need is bounded by the tick, not by the hand.
#include "palpa/study/octave_forecast.h"

#include <gtest/gtest.h>

#include <vector>

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

}  // namespace
}  // namespace palpa
