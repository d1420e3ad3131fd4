// How a volume is asked for: the seam between scenes and whatever opens files.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "palpa/field/field.h"
#include "palpa/volume/volume.h"

namespace palpa {

/// What an array of a file does not say about itself.
struct ArrayLayout {
  std::string type;                    ///< "int16": of a file of bare numbers; empty: the file says it
  std::string byte_order;              ///< "big"; "little" or empty: little
  std::int64_t header_bytes = 0;       ///< before the first voxel
  std::string axes;                    ///< "zyx": which of the grid's axes each index is, slowest first; empty: that
  std::string components;              ///< where vector components are: "first" or "last" index; empty: last if it is of 3
  std::array<std::int64_t, 3> dims{};  ///< voxels along x, y, z; 0: not said
  Vec3 spacing_m;                      ///< [m] 0: not said
  std::optional<Vec3> origin_m;        ///< [m]
  friend bool operator==(const ArrayLayout&, const ArrayLayout&) = default;
};

/// What a scene's `[volume.NAME]` says about the file besides its path.
struct VolumeRequest {
  std::vector<std::filesystem::path> files;  ///< resolved: they exist
  std::string length_unit;                   ///< "m", "mm", … or empty: the file's own, else the default
  struct FieldRequest {
    std::string name;                   ///< how the scene names the field
    std::string array;                  ///< the file's name of the array; empty: the same
    std::string unit;                   ///< label; empty: the file's
    std::vector<std::string> arrays{};  ///< instead of `array` three scalar ones: the components of a vector along x, y and z
    friend bool operator==(const FieldRequest&, const FieldRequest&) = default;
  };
  std::vector<FieldRequest> fields;  ///< empty: all, under the file's names
  std::string as;                    ///< "vector" where a file of three frames is one vector; else empty
  int frame = -1;                    ///< of a file with several; -1: not said
  std::string series;                ///< of a DICOM folder with several, its UID; empty: the largest
  std::string components_along;      ///< "index": vectors are along the grid's axes; "file" or empty: as the format says
  std::optional<double> time_s;      ///< [s] of a case with several moments; none: the latest
  std::optional<Box> crop;           ///< [m] the part that a curvilinear or unstructured grid is resampled in
  ArrayLayout layout;                ///< of an array in an HDF5 file, or of a file of bare numbers
};

/// A file, and what is meant inside it: "flow.h5:/velocity" is the array /velocity of flow.h5.
struct PlaceInFile {
  std::filesystem::path file;
  std::string inside;  ///< begins with '/'; empty: all of it
};
/// Splits a path at the last ":/" unless there is a file or folder of that whole name.
PlaceInFile place_in_file(const std::filesystem::path& path);

/// How a scene's files are opened: injected, so that scenes need no reader. Throws LoadError.
using ReadVolume = std::function<Volume(const VolumeRequest&)>;

}  // namespace palpa
