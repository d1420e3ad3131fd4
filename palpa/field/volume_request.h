// How a volume is asked for: the seam between scenes and whatever opens files.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "palpa/field/field.h"

namespace palpa {

/// What a scene's `[volume.NAME]` says about the file besides its path.
struct VolumeRequest {
  std::vector<std::filesystem::path> files;  ///< resolved: they exist
  std::string length_unit;                   ///< "m", "mm", … or empty: the file's own, else the default
  struct FieldRequest {
    std::string name;   ///< how the scene names the field
    std::string array;  ///< the file's name of the array; empty: the same
    std::string unit;   ///< label; empty: the file's
  };
  std::vector<FieldRequest> fields;  ///< empty: all, under the file's names
  std::string as;                    ///< "vector" where a file of three frames is one vector; else empty
  int frame = -1;                    ///< of a file with several; -1: not said
  std::string series;                ///< of a DICOM folder with several, its UID; empty: the largest
  std::string components_along;      ///< "index": vectors are along the grid's axes; "file" or empty: as the format says
};

/// How a scene's files are opened: injected, so that scenes need no reader. Throws LoadError.
using ReadVolume = std::function<Volume(const VolumeRequest&)>;

}  // namespace palpa
