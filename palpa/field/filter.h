// Fields on grids with another filter, or without signs: from field to field, sharing the voxels.
#pragma once

#include <optional>

#include "palpa/field/grid.h"

namespace palpa {

/// What lies between voxels where nobody says otherwise: the smoothing spline for whole numbers, whose steps it evens out,
/// else trilinear.
Filter default_filter(VoxelType type) noexcept;

/// The grid behind a field, below its poses, and of a series its first frame: its geometry need not be that of the world.
/// nullptr where there is none.
const GridView* grid_below(const Field& field) noexcept;

/// The same voxels with another filter, under the same pose, in every frame of a series; the field itself where it has that
/// filter already. Throws std::invalid_argument, with a sentence, on a field that has no voxels (a formula, a derived value),
/// and on Filter::cubic for whole numbers and for axes.
FieldPtr filtered(FieldPtr field, Filter filter);

/// Every field of a volume, in the same way; a sentence names the field. Without a filter: each trilinear grid gets
/// the default of its type, and all else stays. That is what `Scene::add` does, so that data from files, embedded
/// data and data of a program are felt alike; `read_volume` and `grid_field` themselves give trilinear fields.
Volume filtered(Volume volume, std::optional<Filter> filter = {});

/// A vector grid as an axis field (axis_grid.h) with the same voxels, filter (the smooth one for a cubic) and pose. Throws
/// std::invalid_argument, with a sentence, on fields without voxels and on scalar ones.
FieldPtr signless(FieldPtr field);
/// The volume with its vector fields without sign. Throws as above, and where there is no vector field.
Volume signless(Volume volume);

}  // namespace palpa
