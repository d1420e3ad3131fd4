// Cropping, downsampling and resampling of volumes into files.
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
#include "palpa/file/work_part.h"

namespace palpa {

/// Voxels of a grid from the first to the last, both included.
struct VoxelRange {
  std::array<std::int64_t, 3> first{0, 0, 0};
  std::array<std::int64_t, 3> last{0, 0, 0};
};

struct WrittenVolume;
class SlicedFile;

/// Steps of a conversion, in this order.
struct ConvertOptions {
  std::string field;  ///< only this field; empty: all
  std::optional<VoxelRange> crop;
  int downsample = 1;       ///< n: mean of n × n × n voxels; >= 1
  double resample_m = 0.0;  ///< [m] cubes along the world's axes, trilinear, NaN outside of the data; 0: the grid stays
  bool int16 = false;       ///< round to whole numbers of 16 bits
  detail::Existing existing = detail::Existing::refused;  ///< for an existing file of this name
  WorkPart part;                                          ///< of a store (.zarr): only these rows of chunks
  bool shares_store = false;                              ///< of a store: other processes write other parts
  int zarr = 0;                                           ///< of a store: version of Zarr, 2 or 3; 0: by the number of chunks
  std::function<void(const WrittenVolume&)> written;      ///< called with the file's content once complete; may be empty
  std::function<void(double)> progress;                   ///< called with the share done [1]; may be empty, and may throw
};

/// Writes a volume as `write_volume` does, or octave 0 of a store as `write_store` does, by the name's ending. Voxels that are
/// not computed keep their type, if that holds value = raw · scale + offset exactly; others become float32, or float64 if they
/// were that. Allocates a few slices only and, if a part or a mean is resampled, that as float32. Returns the losses, as half
/// sentences. Throws LoadError.
std::vector<std::string> convert(const Volume& volume, const std::filesystem::path& out, const ConvertOptions& options = {});

/// `convert` of a file that is read by rows; without resampling and `int16`. Allocates some hundred megabytes, whatever the
/// file's size.
std::vector<std::string> convert(SlicedFile& file, const std::filesystem::path& out, const ConvertOptions& options = {});

}  // namespace palpa
