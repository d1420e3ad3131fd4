#include "palpa/study/expected_octaves.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <random>

#include "palpa/base/printed.h"
#include "palpa/file/store_chunks.h"

namespace palpa {
namespace {

constexpr int measured_chunks = 64;     // [1] More: slower; fewer: one slow chunk decides
constexpr double duration_s = 4.0;      // of the hand. More: slower; less: where it begins decides
constexpr double chunks_bytes = 256e6;  // in memory, as of the cache
constexpr double hand_m_per_s = 0.1;    // of the simulated hand, whose time runs slower or faster
constexpr double fine_enough = 0.9;     // [1] More: disks are called slow; less: a network is not
constexpr double clearly = 0.05;        // [1] More: slow chunks are not blamed; less: chance blames them

/// [m] Least distance of voxels along an axis.
double least_spacing_m(const GridGeometry& grid) noexcept {
  const Mat3 columns = transposed(grid.index_to_world_m);
  return std::min({norm(columns.row[0]), norm(columns.row[1]), norm(columns.row[2])});
}

std::string length(double metres) {
  return metres < 1e-3 ? detail::text("%.3g µm", 1e6 * metres) : detail::text("%.3g mm", 1e3 * metres);
}

}  // namespace

double measured_chunk_s(StoreReader& reader) {
  const std::array<std::int64_t, 3> count = chunks_along(reader.contents().octaves.front());
  std::mt19937 random(1);  // equal places on every machine
  std::vector<StoreChunk> chunks(measured_chunks);
  for (StoreChunk& chunk : chunks)
    for (std::size_t a = 0; a < 3; ++a)
      chunk.at[a] = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(count[a]));
  const auto begin = std::chrono::steady_clock::now();
  read_chunks(reader, chunks, [](const StoreRead&, std::span<const std::byte>) {});
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() / measured_chunks;
}

OctaveExpectation expected_octaves(const StoreContents& contents, int octaves, double voxel_hand_m, double chunk_s,
                                   int fields) {
  ForecastStore store{.finest = contents.octaves.front().grid, .chunks = {}};
  std::vector<std::array<std::int64_t, 3>> chunks;
  for (int octave = 0; octave < octaves; ++octave) chunks.push_back(contents.octaves[static_cast<std::size_t>(octave)].chunk);
  store.chunks = chunks;

  const auto& n = store.finest.dims;
  const Vec3 diagonal_m =
      store.finest.to_world({static_cast<double>(n[0]), static_cast<double>(n[1]), static_cast<double>(n[2])}) -
      store.finest.to_world({});
  const StoreField& field = contents.fields.front();
  const auto chunk_bytes = static_cast<double>(chunks.front()[0] * chunks.front()[1] * chunks.front()[2]) *
                           static_cast<double>(size_of(field.type)) * field.components * fields;
  ChunkSupply supply{.chunk_s = fields * chunk_s,
                     .at_once = 1,
                     .window_s = fields * ChunkSupply{}.window_s,
                     .cache = std::max<std::int64_t>(static_cast<std::int64_t>(chunks_bytes / chunk_bytes), 1)};
  const auto hand = simulated_target(detail::text("sim:random,speed_m_per_s=%g", hand_m_per_s));
  const double scale = least_spacing_m(store.finest) / voxel_hand_m;
  const Similarity middle{.scale = scale,
                          .translation_m = store.finest.to_world({}) + 0.5 * diagonal_m - scale * hand->at(0.0).position_m};
  const auto forecast = [&](double speed_m_per_s) {
    OctaveForecast felt = forecast_octaves(store, *hand, middle, speed_m_per_s / hand_m_per_s, duration_s, supply);
    felt.chunks_per_s *= fields, felt.most_per_s *= fields;
    return felt;
  };

  OctaveExpectation expected{.chunk_s = chunk_s, .voxel_hand_m = voxel_hand_m, .forecasts = {}};
  for (std::size_t s = 0; s < std::size(expected.forecasts); ++s)
    expected.forecasts[s] = forecast(OctaveExpectation::speeds_m_per_s[s]);
  supply.chunk_s = 0.0;
  for (std::size_t s = 0; s < std::size(expected.forecasts) && !expected.is_too_slow; ++s) {
    const double fine = expected.forecasts[s].felt.as_fine_as_way_share;
    expected.is_too_slow =
        fine < fine_enough && forecast(OctaveExpectation::speeds_m_per_s[s]).felt.as_fine_as_way_share > fine + clearly;
  }
  return expected;
}

std::string words_of(const OctaveExpectation& expected) {
  const auto& [slow, fast] = expected.forecasts;
  return detail::text(
             "at octave 0 about %.0f %% of the time at %g m/s, %.0f %% at %g m/s; as fine as the way of a tick %.0f "
             "and %.0f %%; a voxel is ",
             100.0 * slow.felt.finest_share, OctaveExpectation::speeds_m_per_s[0], 100.0 * fast.felt.finest_share,
             OctaveExpectation::speeds_m_per_s[1], 100.0 * slow.felt.as_fine_as_way_share,
             100.0 * fast.felt.as_fine_as_way_share) +
         length(expected.voxel_hand_m) +
         detail::text(" of the hand, a chunk takes %.2g ms, and %.0f a second are needed", 1e3 * expected.chunk_s,
                      std::max(slow.chunks_per_s, fast.chunks_per_s)) +
         (expected.is_too_slow ? ": chunks come TOO SLOWLY, which a faster disk or smaller chunks mend" : "");
}

std::string to_json(const OctaveExpectation& expected) {
  auto speeds = nlohmann::ordered_json::array();
  for (std::size_t n = 0; n < std::size(OctaveExpectation::speeds_m_per_s); ++n)
    speeds.push_back({{"speed_m_per_s", OctaveExpectation::speeds_m_per_s[n]},
                      {"finest_share", expected.forecasts[n].felt.finest_share},
                      {"as_fine_as_way_share", expected.forecasts[n].felt.as_fine_as_way_share},
                      {"chunks_per_s", expected.forecasts[n].chunks_per_s}});
  const nlohmann::ordered_json json{{"chunk_s", expected.chunk_s},
                                    {"voxel_hand_m", expected.voxel_hand_m},
                                    {"too_slow", expected.is_too_slow},
                                    {"speeds", speeds}};
  return json.dump();
}

}  // namespace palpa
