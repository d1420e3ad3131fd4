// Octaves to expect of a store that is felt live, as `palpa info` prints them.
#pragma once

#include <string>

#include "app/info_table.h"
#include "palpa/file/store_reader.h"
#include "palpa/study/octave_forecast.h"

namespace palpa::app {

/// Felt octaves to expect at two speeds of the hand, where the longest side of the store is 0.15 m of the hand.
struct OctaveExpectation {
  static constexpr double speeds_m_per_s[] = {0.05, 0.2};
  double chunk_s = 0.0;         ///< [s] of a chunk of octave 0, measured
  double voxel_hand_m = 0.0;    ///< [m] of the hand a voxel of octave 0
  OctaveForecast forecasts[2];  ///< by speed
};

/// Reads 64 random chunks of octave 0 for their time, then moves a simulated hand in virtual time. About two seconds. Throws as
/// StoreReader.
/// \param octaves  that are felt: each half as fine as the one before
OctaveExpectation expected_octaves(StoreReader& reader, int octaves);

std::string words_of(const OctaveExpectation& expected);
nlohmann::ordered_json json_of(const OctaveExpectation& expected);

}  // namespace palpa::app
