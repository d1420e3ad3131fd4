// `palpa info`: what is in data files.
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
  std::vector<std::filesystem::path> files;  ///< each a volume of its own, or a pattern of names: a time series; at least one
  bool series = false;                       ///< the files are the frames of one time series
  bool json = false;                         ///< one object for one file, a list of them for several
  std::vector<Vec3> at_m;                    ///< [m] world positions to sample
  std::optional<double> level;               ///< of scalar fields, in each one's own unit: what the smooth filter loses at it
  ReadOptions read;
  VolumeRequest request;                                  ///< how the files are read; its files are the partners of each
  bool scene = false;                                     ///< print a first scene instead; of one file
  std::filesystem::path scene_file;                       ///< write it there instead of printing it
  std::filesystem::path picture;                          ///< draw into this file, too; of one file
  detail::Existing existing = detail::Existing::refused;  ///< what becomes of files that have these names already
  std::vector<AskedPlace> places{};                       ///< further places to sample
};

/// Prints what is in the files, as a table or as JSON (docs: the keys are promises). Returns 0; throws
/// LoadError at the first file that cannot be read.
int run_info(const InfoArguments& arguments);

}  // namespace palpa::app
