// Octaves that a live hand will feel of a volume larger than memory, in virtual time.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "palpa/data/octaves.h"
#include "palpa/device/hand.h"
#include "palpa/solver/similarity.h"
#include "palpa/study/felt_octaves.h"

namespace palpa {

/// Speed at which chunks come.
struct ChunkSupply {
  double chunk_s = 0.15e-3;   ///< [s] of a chunk, reading and decoding; ≥ 0
  int at_once = 4;            ///< [1] chunks on the way at the same time; ≥ 1
  double window_s = 2e-3;     ///< [s] of a window of 128³ voxels from its chunks; ≥ 0
  std::int64_t cache = 8192;  ///< [1] chunks in memory
};

/// Store of which the geometry alone matters.
struct ForecastStore {
  GridGeometry finest;                                  ///< of octave 0
  std::span<const std::array<std::int64_t, 3>> chunks;  ///< [voxels] of a chunk along i, j, k, by octave: as many as octaves
};

/// Felt octaves, and the need for chunks.
struct OctaveForecast {
  FeltOctaves felt;
  double chunks_per_s = 0.0;  ///< that were not in memory
  double most_per_s = 0.0;    ///< in the second with the most
};

/// Moves a hand through the store at 1 kHz, with the loader's policy and the session's rule of the felt octave on a simulated
/// clock: the proxy is at the hand. Takes about a second for 8 s. Allocates. Throws std::invalid_argument on a store that
/// `Octaves` refuses.
/// \param hand_to_world  of the scene
/// \param speed          [1] > 0: the hand's time runs so much faster
/// \param duration_s     [s] > 0
OctaveForecast forecast_octaves(const ForecastStore& store, const Target& hand, const Similarity& hand_to_world, double speed,
                                double duration_s, const ChunkSupply& supply);

}  // namespace palpa
