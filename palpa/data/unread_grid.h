// Grids of voxels that nobody has read yet: arrays of a program, handed over at once.
#pragma once

#include "palpa/data/grid.h"

namespace palpa {

/// The same field as `grid_field`, made in no time, however many voxels there are: what only reading all of them tells (their
/// range, bounds, holes) is found out when somebody first asks for it, and a scene does that when the field is added, so that
/// no tick ever does. Samples need none of it. Throws std::invalid_argument as `grid_field` does. Any number of threads may
/// ask at once. The voxels must not change from now on.
/// \param scale   the field's own unit, per raw step
/// \param offset  the field's own unit
FieldPtr unread_grid_field(const GridGeometry& geometry, Voxels voxels, double scale = 1.0, double offset = 0.0);

namespace detail {

/// Of an unread grid, the grid that has been read, now; any other field itself. Throws where there is no memory for what it
/// tells.
FieldPtr read_now(const FieldPtr& field);
/// The same of its view; nullptr where the field is no unread grid. Stays as long as the field.
const GridView* view_read_now(const Field& field) noexcept;
/// What samples a field: of an unread grid, the grid without what reading tells; any other field itself.
const Field& sampler_of(const Field& field) noexcept;

}  // namespace detail
}  // namespace palpa
