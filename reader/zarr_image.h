// Metadata of an OME-Zarr image: axes, octaves, channels.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "palpa/data/statistics.h"
#include "zarr_array.h"

namespace palpa::reader {

/// Indices of an array that are axes of space, time and channels; SIZE_MAX: none.
struct ZarrAxes {
  std::array<std::size_t, 3> space{SIZE_MAX, SIZE_MAX, SIZE_MAX};  ///< along x, y, z
  std::size_t time = SIZE_MAX, channel = SIZE_MAX;
  std::array<std::string, 3> length_unit;  ///< empty: none
  std::string time_unit;
  std::size_t rank = 0;
};

/// Octave of an image.
struct ZarrLevel {
  ZarrArray array;
  /// Positions in the axes' units are matrix · indices + translation; both empty: none in the file. The matrix row by row, a
  /// row for each axis, in the order of the array's indices; between space, time and channels it is 0.
  std::vector<double> matrix{}, translation{};
};

struct ZarrImage {
  std::string format{};  ///< "OME-Zarr 0.4, Zarr v2"
  std::string folder{};  ///< of its metadata, in the store
  ZarrAxes axes{};
  std::vector<ZarrLevel> levels{};      ///< from the finest
  std::vector<std::string> channels{};  ///< labels of omero
  std::vector<std::string> units{};     ///< of the channels, by palpa; empty: none
  std::vector<Histogram> histograms{};  ///< of the fields, by palpa prepare; empty: none
  std::vector<std::string> warnings{};  ///< half sentences
};

/// Reads the metadata of a store: an image of OME-Zarr 0.1 to 0.6, or a plain array. Throws LoadError with a sentence.
/// \param most_chunk_bytes  larger chunks are refused
ZarrImage read_zarr_image(const ZarrFolder& folder, std::uint64_t most_chunk_bytes);

}  // namespace palpa::reader
