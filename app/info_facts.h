// What is known of a file once it is open. `palpa info` prints it as words or JSON.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "palpa/data/frame_shift.h"
#include "palpa/data/grid.h"
#include "palpa/data/labels.h"
#include "palpa/data/placement.h"
#include "palpa/data/statistics.h"
#include "palpa/data/volume.h"
#include "palpa/file/read_volume.h"

namespace palpa::app {

/// A volume as the user asked for it.
struct Asked {
  std::string name;  ///< as it was written
  VolumeRequest request;
  bool is_series = false;  ///< the files are frames; else the first is the volume, and the others its partners
};

/// One file, or the files of one time series.
struct Facts {
  std::string name;              ///< as it was asked for
  VolumeFile file;               ///< the volume; of a series its first frame
  std::optional<Volume> series;  ///< all frames, where there are several
  Placement placed;
  std::vector<Statistics> values;       ///< of each field
  std::vector<LabelMap> labels;         ///< of each field
  std::string what;                     ///< what it is (`kind_of`)
  bool directions = false;              ///< its frames are the components of vectors of length 1
  std::vector<std::string> suspicious;  ///< what a person should look at, half sentences
  std::uint64_t memory_bytes = 0;       ///< of the voxels

  double valid_share() const;  ///< [1] least share of voxels with a finite value
};

/// Opens one file, or several files as one series. Throws LoadError.
/// \param all_frames  reads all its frames, too, where it has several
Facts facts_of(const Asked& asked, const ReadOptions& read, bool all_frames);

/// The request for the same file by which it should be felt or drawn, if that differs from `asked`: frames that are the
/// components of directions, or arrays that are the components of vectors.
std::optional<VolumeRequest> request_to_feel(const Asked& asked, const Facts& facts, const ReadOptions& read);

/// How far the levels of a field move from frame to frame; none if it is no series.
std::optional<FrameShift> shift_of(const Facts& facts, std::size_t field, const std::optional<double>& level);

}  // namespace palpa::app
