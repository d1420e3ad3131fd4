#include "app/info_octaves.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <random>

#include "app/info_numbers.h"
#include "palpa/file/store_chunks.h"

namespace palpa::app {
namespace {

constexpr int measured_chunks = 64;     // [1] More: slower; fewer: one slow chunk decides
constexpr double hand_m = 0.15;         // of the longest side
constexpr double duration_s = 4.0;      // of the hand. More: slower; less: where it begins decides
constexpr double chunks_bytes = 256e6;  // in memory, as of the cache

/// [s] of a chunk, while as many are read at once as the reader has slots.
double measured_chunk_s(StoreReader& reader) {
  const StoreOctave& octave = reader.contents().octaves.front();
  const std::array<std::int64_t, 3> count = chunks_along(octave);
  std::mt19937 random(1);  // equal places on every machine
  std::vector<StoreChunk> chunks(measured_chunks);
  for (StoreChunk& chunk : chunks)
    for (std::size_t a = 0; a < 3; ++a)
      chunk.at[a] = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(count[a]));
  const auto begin = std::chrono::steady_clock::now();
  read_chunks(reader, chunks, [](const StoreRead&, std::span<const std::byte>) {});
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() / measured_chunks;
}

}  // namespace

OctaveExpectation expected_octaves(StoreReader& reader, int octaves) {
  const StoreContents& contents = reader.contents();
  ForecastStore store{.finest = contents.octaves.front().grid};
  std::vector<std::array<std::int64_t, 3>> chunks;
  for (int octave = 0; octave < octaves; ++octave) chunks.push_back(contents.octaves[static_cast<std::size_t>(octave)].chunk);
  store.chunks = chunks;

  OctaveExpectation expected;
  expected.chunk_s = measured_chunk_s(reader);
  const auto& n = store.finest.dims;
  const Vec3 diagonal_m =
      store.finest.to_world({static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])}) -
      store.finest.to_world({});
  const auto longest = static_cast<double>(*std::ranges::max_element(n));
  expected.voxel_hand_m = hand_m / longest;
  const double spacing_m = norm(transposed(store.finest.index_to_world_m).row[0]);
  const StoreField& field = contents.fields.front();
  const auto chunk_bytes = static_cast<double>(chunks.front()[0] * chunks.front()[1] * chunks.front()[2]) *
                           static_cast<double>(size_of(field.type)) * field.components;
  const ChunkSupply supply{.chunk_s = expected.chunk_s,
                           .at_once = 1,
                           .cache = std::max<std::int64_t>(static_cast<std::int64_t>(chunks_bytes / chunk_bytes), 1)};
  const auto hand = simulated_target("sim:random,speed_m_per_s=0.1");
  const double scale = spacing_m / expected.voxel_hand_m;
  const Vec3 middle_m = store.finest.to_world({}) + 0.5 * diagonal_m - scale * hand->at(0.0).position_m;
  for (std::size_t s = 0; s < std::size(OctaveExpectation::speeds_m_per_s); ++s)
    expected.forecasts[s] = forecast_octaves(store, *hand, {.scale = scale, .translation_m = middle_m},
                                             OctaveExpectation::speeds_m_per_s[s] / 0.1, duration_s, supply);
  return expected;
}

std::string words_of(const OctaveExpectation& expected) {
  const auto percent = [&](std::size_t n) { return 100.0 * expected.forecasts[n].felt.finest_share; };
  return fmt::format(
      "at octave 0 about {:.0f} % of the time at {:g} m/s, {:.0f} % at {:g} m/s, where a voxel is {} of the hand; a chunk "
      "takes {:.2g} ms, and {:.0f} a second are needed",
      percent(0), OctaveExpectation::speeds_m_per_s[0], percent(1), OctaveExpectation::speeds_m_per_s[1],
      length_words(expected.voxel_hand_m), 1e3 * expected.chunk_s,
      std::max(expected.forecasts[0].chunks_per_s, expected.forecasts[1].chunks_per_s));
}

nlohmann::ordered_json json_of(const OctaveExpectation& expected) {
  auto speeds = nlohmann::ordered_json::array();
  for (std::size_t n = 0; n < std::size(OctaveExpectation::speeds_m_per_s); ++n)
    speeds.push_back({{"speed_m_per_s", OctaveExpectation::speeds_m_per_s[n]},
                      {"finest_share", expected.forecasts[n].felt.finest_share},
                      {"as_fine_as_way_share", expected.forecasts[n].felt.as_fine_as_way_share},
                      {"chunks_per_s", expected.forecasts[n].chunks_per_s}});
  return {{"chunk_s", expected.chunk_s}, {"voxel_hand_m", expected.voxel_hand_m}, {"speeds", speeds}};
}

}  // namespace palpa::app
