// Volumes made smaller, or laid along the world's axes, on their way into a file.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "palpa/base/load_error.h"
#include "palpa/base/new_file.h"
#include "palpa/data/field.h"
#include "palpa/data/volume.h"

namespace palpa {

/// Voxels of a grid from the first to the last, both among them.
struct VoxelRange {
  std::array<std::int64_t, 3> first{0, 0, 0};
  std::array<std::int64_t, 3> last{0, 0, 0};
};

struct WrittenVolume;

/// What becomes of a volume, in this order.
struct ConvertOptions {
  std::string field;  ///< this one alone; empty: all
  std::optional<VoxelRange> crop;
  int downsample = 1;       ///< n: the mean of n × n × n voxels becomes one; >= 1
  double resample_m = 0.0;  ///< [m] cubes along the world's axes, trilinear, NaN outside of the data; 0: the grid stays
  bool int16 = false;       ///< rounded to whole numbers of 16 bits
  detail::Existing existing = detail::Existing::refused;  ///< what becomes of a file that has the name already
  std::function<void(const WrittenVolume&)> written;      ///< called with what the file holds, once it is whole; may be empty
  std::function<void(double)> progress;  ///< called with the share that is done [1]; may be empty, and may throw
};

/// Writes a volume as `write_volume` does. Voxels that are not computed keep their type, where that holds value = raw · scale +
/// offset exactly; others become float32, or float64 where they were that. Nothing is allocated but a few slices
/// and, where a part or a mean is resampled, that as float32. Returns what is lost on the way, half sentences. Throws
/// LoadError.
std::vector<std::string> convert(const Volume& volume, const std::filesystem::path& out, const ConvertOptions& options = {});

}  // namespace palpa
