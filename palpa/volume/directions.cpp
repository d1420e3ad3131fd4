#include "palpa/volume/directions.h"

#include "palpa/field/statistics.h"

namespace palpa {

bool frames_are_directions(const VolumeRequest& request, const VolumeFile& file, const ReadOptions& options) {
  if (file.frames != 3 || !request.as.empty() || file.volume.fields.size() != 1) return false;
  const GridView* grid = grid_of(*file.volume.fields.front().field);
  if (!grid || (grid->voxels.type != VoxelType::float32 && grid->voxels.type != VoxelType::float64)) return false;
  VolumeRequest as_vector = request;
  as_vector.as = "vector";
  try {
    return looks_like_directions(statistics(*read_volume(as_vector, options).fields.front().field));
  } catch (const LoadError&) {
    return false;  // a format that takes no frames as vectors
  }
}

}  // namespace palpa
