// Time series from files: their selection, order, and joint volume.
#pragma once

#include <filesystem>
#include <vector>

#include "palpa/data/timed_field.h"
#include "palpa/data/volume.h"

namespace palpa {

/// Files of a folder that match the last part of a path, with `*` for any characters and `?` for a single character. Numbers in
/// names sort by value: phase_2 before phase_10. Empty for a missing folder. Allocates.
std::vector<std::filesystem::path> files_matching(const std::filesystem::path& pattern);

/// Frames of a series as a volume whose fields are time series: a file for each frame, or all frames of a file (`request.frame`
/// is ignored). All frames must have equal fields on one grid. A series of more than 2 GB gets a warning.
/// \param frame_period_s  [s] from frame to frame
/// Throws what `read_volume` throws, and std::invalid_argument with the file's name and a sentence.
Volume read_series(const VolumeRequest& request, double frame_period_s, BetweenFrames between_frames,
                   const VolumeReader& read_volume);

}  // namespace palpa
