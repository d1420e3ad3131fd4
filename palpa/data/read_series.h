// Time series from files: which files, in which order, and their volumes as one.
#pragma once

#include <filesystem>
#include <vector>

#include "palpa/data/timed_field.h"
#include "palpa/data/volume.h"

namespace palpa {

/// The files of a folder whose names match the last part of a path, where `*` stands for any characters and `?` for one.
/// Numbers in names sort by value: phase_2 before phase_10. Empty where there is no such folder. Allocates.
std::vector<std::filesystem::path> files_matching(const std::filesystem::path& pattern);

/// The frames of a series as one volume whose fields are time series: one file for each frame, or all frames of one file
/// (`request.frame` is ignored). All frames must have the same fields on one grid. A series of more than 2 GB gets a warning.
/// \param frame_period_s  [s] from frame to frame
/// Throws what `read_volume` throws, and std::invalid_argument with the file's name and a sentence.
Volume read_series(const VolumeRequest& request, double frame_period_s, BetweenFrames between_frames,
                   const VolumeReader& read_volume);

}  // namespace palpa
