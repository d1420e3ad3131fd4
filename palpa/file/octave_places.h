// Places of a store's octaves, by their voxels: files are often silent or wrong about half a voxel.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "palpa/file/store_reader.h"

namespace palpa {

/// Making of an octave from the one before.
enum class OctaveMaking : std::uint8_t {
  none,        ///< there is one octave only
  means,       ///< of 2 × 2 × 2 voxels
  decimation,  ///< every second voxel
  neither,     ///< neither fits to rounding: such octaves are not felt
  undecided,   ///< the voxels fit both, as where they are constant
};

struct OctavePlaces {
  OctaveMaking making = OctaveMaking::none;
  std::array<int, 3> first{};         ///< [voxels] of decimation: the taken voxel of each pair along i, j, k
  std::vector<StoreOctave> octaves;   ///< of the store, with the places [m] of their voxels; undecided: those of the file
  std::vector<std::string> warnings;  ///< half sentences: the file contradicts, or neither fits
};

/// Compares up to 16 boxes of octave 1 with octave 0, in the first frame of the first field, at most 64 MB of chunks. The
/// reader has no request pending. Blocks for milliseconds. Throws as StoreReader. Equal stores give equal results.
OctavePlaces octave_places(StoreReader& reader);

}  // namespace palpa
