// Lazily read grids: arrays of a program, handed over at once.
#pragma once

#include "palpa/data/grid.h"

namespace palpa {

/// `grid_field` in constant time for any number of voxels: results of reading all of them (range, bounds, holes) are computed
/// at the first request, which a scene makes when the field is added, so that no tick does. Samples need none of them. Throws
/// std::invalid_argument as `grid_field` does. Any number of threads may request at once. The voxels must not change from now
/// on.
/// \param scale   the field's own unit, per raw step
/// \param offset  the field's own unit
FieldPtr unread_grid_field(const GridGeometry& geometry, Voxels voxels, double scale = 1.0, double offset = 0.0);

namespace detail {

/// Reads an unread grid now and returns the loaded grid; any other field itself. Throws on insufficient memory.
FieldPtr read_now(const FieldPtr& field);
/// View of the loaded grid; nullptr if the field is no unread grid. Valid as long as the field.
const GridView* view_read_now(const Field& field) noexcept;
/// Field for samples: of an unread grid, the grid without results of reading; any other field itself.
const Field& sampler_of(const Field& field) noexcept;

}  // namespace detail
}  // namespace palpa
