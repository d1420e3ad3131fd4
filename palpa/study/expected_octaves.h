// Octaves to expect of a store that is felt live, by the time that its chunks take: for `palpa info` and `palpa check`.
#pragma once

#include <string>

#include "palpa/file/store_reader.h"
#include "palpa/study/octave_forecast.h"

namespace palpa {

/// Felt octaves to expect at two speeds of a simulated hand in the middle of a store.
struct OctaveExpectation {
  static constexpr double speeds_m_per_s[] = {0.05, 0.2};
  double chunk_s = 0.0;         ///< [s] of a chunk of octave 0
  double voxel_hand_m = 0.0;    ///< [m] of the hand a voxel of octave 0
  OctaveForecast forecasts[2];  ///< by speed
  /// Coarser octaves than the hand's way in a tick are felt in more than a tenth of the time, and in clearly less if chunks
  /// took no time.
  bool is_too_slow = false;
};

/// [s] of a chunk of octave 0, while as many are read at once as the reader has slots: of 64 random ones. The reader has no
/// request pending. Blocks. Throws as StoreReader.
double measured_chunk_s(StoreReader& reader);

/// Moves a simulated hand in virtual time. One to four seconds. Allocates; any thread.
/// \param contents      of the store
/// \param octaves       [1] that are felt, from octave 0: each half as fine as the one before
/// \param voxel_hand_m  [m] of the hand a voxel of octave 0, along the axis where voxels are smallest; > 0
/// \param chunk_s       [s] of a chunk; ≥ 0
/// \param fields        [1] that the loader makes windows of in turn
OctaveExpectation expected_octaves(const StoreContents& contents, int octaves, double voxel_hand_m, double chunk_s,
                                   int fields = 1);

std::string words_of(const OctaveExpectation& expected);
/// As an object in JSON; names carry their unit.
std::string to_json(const OctaveExpectation& expected);

}  // namespace palpa
