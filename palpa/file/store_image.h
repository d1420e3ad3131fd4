// Image of an OME-Zarr store: its axes, and the metadata that programs read first.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "palpa/data/grid.h"
#include "palpa/data/statistics.h"

namespace palpa::detail {

/// Image of a store, as its attributes describe it.
struct StoreImage {
  int zarr = 2;                    ///< 2: OME-Zarr 0.4; 3: 0.5
  bool has_time = false;           ///< axis t
  bool has_channels = false;       ///< axis c
  std::vector<std::string> paths;  ///< of the octaves' arrays, from the finest
  int own_from = 0;                ///< [octaves] first that palpa made; 0: unknown
  std::vector<std::string> axes() const;
};

/// Content of a new store.
struct NewImage {
  int zarr = 2;
  std::string name;
  std::string length_unit;             ///< "micrometer"
  std::array<double, 3> spacing{};     ///< [length_unit] along i, j, k; above 0
  std::array<double, 3> origin{};      ///< [length_unit] of the first voxel's centre
  std::vector<std::string> channels;   ///< labels; one: no axis c
  std::array<double, 2> window{0, 1};  ///< range of values, the field's own unit
  std::vector<std::string> units;      ///< of each channel; empty texts: unknown
};

/// Text of .zattrs or zarr.json of a new store of octave 0 alone, at path "0". Allocates; any thread.
std::string image_metadata(const NewImage& image);

/// Reads the attributes of a store. The text is limited in size and depth. Throws LoadError "STORE: problem; remedy".
StoreImage read_image(const std::filesystem::path& store);

/// Attributes with further octaves: of means, so that the first voxel of each lies half a voxel of the one before further in.
struct AddedOctaves {
  int first = 1;                              ///< [octaves] number of the first one
  std::vector<std::string> paths;             ///< of all from `first` on
  int own_from = 1;                           ///< [octaves] first that palpa made
  std::array<std::int64_t, 3> unit{};         ///< [voxels] of octave 0 in a unit of work
  std::vector<std::array<double, 2>> ranges;  ///< least and largest value of each field, raw; empty: not known yet
  std::vector<double> lost;                   ///< root mean square of what octave 1 loses, raw, of each field
  std::vector<Histogram> histograms;          ///< raw, of each field
  std::string beside;                         ///< name of the store that they belong to; empty: the same
};
/// Text of the attributes of `store` with these octaves; of those of `beside` the others are left out. Allocates. Throws
/// LoadError as `read_image`.
std::string image_metadata_with(const std::filesystem::path& store, const AddedOctaves& added);
/// Name of the file of the attributes: .zattrs or zarr.json.
const char* attributes_file(int zarr) noexcept;

}  // namespace palpa::detail
