// Volume file whose rows of voxels are read on request, by the sandboxed palpa-read: so that it may be larger than memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "palpa/data/volume.h"
#include "palpa/file/store_contents.h"

namespace palpa {

class StoreReader;
struct ReadOptions;

/// Rows of slices: a box of voxels that is whole along i.
struct SliceRows {
  std::int64_t first_slice = 0;  ///< [voxels] along k
  std::int64_t slices = 1;       ///< [1]
  std::int64_t first_row = 0;    ///< [voxels] along j
  std::int64_t rows = 1;         ///< [1]
};

/// Open file of a format whose rows can be read alone. One thread.
class SlicedFile {
 public:
  struct Field {
    std::string name, unit;
    GridGeometry grid;  ///< [m]
    VoxelType type = VoxelType::uint8;
    int components = 1;
    double scale = 1.0, offset = 0.0;  ///< [own unit] value = raw · scale + offset
  };

  /// Facts of the file as of a volume that is read as a whole, without fields.
  Volume volume;
  std::vector<Field> fields;  ///< on one grid

  /// \param arrays  index of each field's array in `contents`
  SlicedFile(std::unique_ptr<StoreReader> reader, std::vector<std::uint32_t> arrays);
  ~SlicedFile();

  /// [voxels] of a slice that are read at once, along j.
  std::int64_t rows_at_once() const noexcept;
  /// Writes rows of slices in the field's type: i fastest, then j, then k, components of a voxel together. Reads ahead within
  /// the request. Throws LoadError with the file's name.
  void read(std::size_t field, const SliceRows& range, std::byte* to);

 private:
  std::unique_ptr<StoreReader> reader_;
  std::vector<std::uint32_t> arrays_;
};

/// Opens the file of a request; nullptr if its format, or this file, is read as a whole alone. Throws LoadError as
/// `read_volume`.
std::unique_ptr<SlicedFile> open_sliced_file(const VolumeRequest& request, const ReadOptions& options);

}  // namespace palpa
