// Parts of volumes larger than memory, as ordinary grids: a sample of octave 0, and octaves for pictures.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "palpa/data/octaves.h"
#include "palpa/data/statistics.h"

namespace palpa {

/// The field itself as octaves; nullptr for others, also below a pose. Any thread.
const Octaves* octaves_of(const Field& field) noexcept;

/// The octaves of a field, also below poses, of a series those of its first frame; nullptr for others. Any thread.
const Octaves* octaves_below(const Field& field) noexcept;
/// Octaves, and the pose of their frame in that of a field.
struct PosedOctaves {
  const Octaves* octaves = nullptr;
  Similarity pose;
};
/// The octaves of a field, also below poses, at a moment, of a series those of the nearest frame; none for other fields. Any
/// thread.
std::optional<PosedOctaves> posed_octaves(const Field& field, DataTime at) noexcept;
/// Likewise all frames of a series in octaves; of other fields in octaves these alone. Allocates; any thread.
std::vector<const Octaves*> frames_in_octaves(const Field& field);
/// Whether a field changes with the time of the data: a timed one, unless it is octaves of one frame that do not move. Any
/// thread.
bool changes_with_time(const Field& field) noexcept;

/// Box of voxels of an octave, trilinear; null where some of them are lost or damaged. Reads them: blocks. Allocates; any
/// thread, one at a time. Throws LoadError if the source has ended.
/// \param octave  [1] below `octaves.count()`
/// \param first   [voxels] along i, j, k
/// \param dims    [voxels] along i, j, k, within the octave
FieldPtr octave_part(const Octaves& octaves, int octave, const std::array<std::int64_t, 3>& first,
                     const std::array<std::int64_t, 3>& dims);

/// Blocks of 32 × 32 × 32 voxels of octave 0, at 128 places spread evenly over it, or all of fewer: values of coarser octaves
/// are means, which lie closer together. Lost and damaged ones are left out. Blocks, allocates and throws as `octave_part`.
std::vector<FieldPtr> octave_sample(const Octaves& octaves);

/// Statistics of a scalar field in octaves, of a vector field of its lengths, from a sample of octave 0; the least and largest
/// value of a scalar field are those of `Octaves::Shape::ranges`, unless the sample exceeds them. Throws std::bad_alloc only.
/// \param sample  as from `octave_sample`
Statistics sample_statistics(const Octaves& octaves, std::span<const FieldPtr> sample);

/// Octave that a picture is drawn from.
struct DrawnOctave {
  FieldPtr field;        ///< part of one octave as a grid, under the pose and with the filter of the whole
  int octave = 0;        ///< [1] 0: the voxels of the file
  double voxel_m = 0.0;  ///< [m] width of its voxels
};

/// [voxels] Along each axis of a part that is drawn. More: memory and time, cubed; fewer: details are lost.
inline constexpr std::int64_t most_drawn_voxels = 256;

/// Of a field in octaves, also under a pose, the part within a box at one moment, from the coarsest octave whose voxels are no
/// wider than `step_m`, if at most `most_drawn_voxels` of them lie in the box along each axis and none is lost, else from a
/// coarser one; the coarsest always is drawn. None for other fields, and for a box beside the data. Blocks, allocates and
/// throws as `octave_part`.
/// \param box_m   [m] in the frame of the field
/// \param step_m  [m] wanted distance of samples, above 0
std::optional<DrawnOctave> drawn_octave(const Field& field, DataTime at, const Box& box_m, double step_m);

}  // namespace palpa
