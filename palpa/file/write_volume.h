// Writing of volumes: NRRD, NIfTI and VTI, slice by slice.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "palpa/base/load_error.h"
#include "palpa/base/new_file.h"
#include "palpa/data/grid.h"
#include "palpa/file/sliced_file.h"

namespace palpa {

/// Array to write. Slices are requested in order, so that a volume need never be in memory as a whole.
struct WrittenField {
  std::string name;
  std::string unit;
  VoxelType type = VoxelType::float32;
  int components = 1;  ///< 1, or 3 along the axes of the world
  /// Writes the values of slice k to the pointer, i fastest, the components of a voxel together: whole for an integer type, not
  /// finite without data (for types with fractions).
  using Slice = std::function<void(std::int64_t, double*)>;
  Slice slice;
  /// All values in memory, in `type`, i fastest, the components of a voxel together, if the slices are these; else nullptr.
  const std::byte* voxels = nullptr;
  /// Writes rows of these values in `type`, in the same order, for volumes that are not in memory; else empty.
  std::function<void(const SliceRows&, std::byte*)> rows{};
  std::int64_t rows_at_once = 1;  ///< [voxels] along j that `rows` reads best, with multiples of them
};

/// Content of a file beside its voxels.
struct WrittenVolume {
  GridGeometry grid;
  bool medical_frame = false;        ///< stored in NRRD; VTI has no key for it, NIfTI no other frame
  std::string length_unit = "m";     ///< of NRRD: "m" or "mm"; of OME-Zarr also others; VTI is in metres, NIfTI in millimetres
  std::vector<WrittenField> fields;  ///< at least one; of NRRD and NIfTI exactly one
};

/// Bytes of the voxels. Throws LoadError, without a place, on overflow.
std::uint64_t written_bytes(const WrittenVolume& volume);

/// Whether the name's ending is NIfTI's: .nii, or .nii.gz, which is packed.
bool is_nifti(const std::filesystem::path& file);

/// Writes a file: by its ending .nrrd, .nhdr (with the voxels beside it, ENDING .raw), .nii, .nii.gz or .vti. It gets its name
/// when complete (palpa/base/new_file.h). Refuses first a volume larger, without packing, than the free disk.
/// \param progress  called after each slice with the share done [1]; may be empty, and may throw to end the writing
/// Throws LoadError, with the file's name, also for a sheared grid in VTI.
void write_volume(const WrittenVolume& volume, const std::filesystem::path& file, detail::Existing existing,
                  const std::function<void(double)>& progress = {});

}  // namespace palpa
