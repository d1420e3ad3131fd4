// Volumes to files: NRRD and VTI, slice by slice.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "palpa/base/load_error.h"
#include "palpa/base/new_file.h"
#include "palpa/data/grid.h"

namespace palpa {

/// One array to write. Slices are asked for in order, so that a volume need never be in memory as a whole.
struct WrittenField {
  std::string name;
  std::string unit;
  VoxelType type = VoxelType::float32;
  int components = 1;  ///< 1, or 3 along the axes of the world
  /// Puts the values of slice k where they are wanted, i fastest, the components of one voxel together: whole where the
  /// type is, not finite where there are no data (of a type with fractions).
  using Slice = std::function<void(std::int64_t, double*)>;
  Slice slice;
};

/// What a file says beside its voxels.
struct WrittenVolume {
  GridGeometry grid;
  bool medical_frame = false;        ///< NRRD says so; VTI cannot
  std::string length_unit = "m";     ///< of NRRD: "m" or "mm"; VTI is in metres
  std::vector<WrittenField> fields;  ///< at least one; of NRRD exactly one
};

/// Bytes of the voxels. Throws LoadError, without a place, where they cannot be counted.
std::uint64_t written_bytes(const WrittenVolume& volume);

/// Writes a file: by its ending .nrrd, .nhdr (with the voxels beside it, ENDING .raw) or .vti. It gets its name when it is
/// whole (palpa/base/new_file.h), so that nobody ever finds half of it. Refuses first what the disk has no room for. \param
/// progress  called after each slice with the share that is done [1]; may be empty, and may throw to end the writing Throws
/// LoadError, with the file's name, also where VTI cannot say where a sheared grid lies.
void write_volume(const WrittenVolume& volume, const std::filesystem::path& file, detail::Existing existing,
                  const std::function<void(double)>& progress = {});

}  // namespace palpa
