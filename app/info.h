// `palpa info`: contents of data files.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "app/info_place.h"
#include "palpa/base/new_file.h"
#include "palpa/file/read_volume.h"
#include "palpa/solver/vec3.h"

namespace palpa::app {

struct InfoArguments {
  std::vector<std::filesystem::path> files;  ///< each a separate volume, or a name pattern of a time series; at least one
  bool series = false;                       ///< the files are the frames of one time series
  bool json = false;                         ///< one object for one file, a list of objects for several
  std::vector<Vec3> at_m;                    ///< [m] world positions to sample
  std::optional<double> level;  ///< of scalar fields, in the field's own unit: reports the smooth filter's loss there
  ReadOptions read;
  VolumeRequest request;                                  ///< options of reading; its files are the partners of each file
  bool scene = false;                                     ///< print a first scene instead; of one file
  std::filesystem::path scene_file;                       ///< write it to this file instead of printing it
  std::filesystem::path picture;                          ///< also draw a picture into this file; of one file
  detail::Existing existing = detail::Existing::refused;  ///< treatment of existing files with these names
  std::vector<AskedPlace> places{};                       ///< further positions to sample
};

/// Prints the contents as a table or as JSON, whose keys are promises. Returns 0; throws LoadError at the first unreadable
/// file.
int run_info(const InfoArguments& arguments);

}  // namespace palpa::app
