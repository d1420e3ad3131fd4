#include "palpa/field/filter.h"

#include <stdexcept>
#include <string>
#include <utility>

#include "palpa/field/axis_grid.h"
#include "palpa/field/smooth_grid.h"

namespace palpa {
namespace {

FieldPtr made_of(const GridView& grid, Filter filter, bool without_sign) {
  const auto make = [&](auto* maker, auto... more) {
    return maker(grid.geometry, grid.voxels, grid.scale, grid.offset, more...);
  };
  if (without_sign) return make(axis_grid_field, filter);
  switch (filter) {
    case Filter::smooth: return make(smooth_grid_field);
    case Filter::cubic: return make(cubic_grid_field);
    default: return make(grid_field);
  }
}

const GridView& grid_or_throw(const Field& field) {
  if (const GridView* grid = grid_behind(field)) return *grid;
  throw std::invalid_argument("it is a formula and has no voxels; sample it first");
}

template <class Change>
FieldPtr changed(const VolumeField& field, Change change) {
  try {
    return change(field.field);
  } catch (const std::invalid_argument& problem) {
    throw std::invalid_argument("field '" + field.name + "': " + problem.what());
  }
}

}  // namespace

Filter default_filter(VoxelType type) noexcept {
  const bool fractions = type == VoxelType::float32 || type == VoxelType::float64;
  return fractions ? Filter::trilinear : Filter::smooth;
}

FieldPtr filtered(FieldPtr field, Filter filter) {
  if (!field) throw std::invalid_argument("there is no field to filter");
  if (const PosedView* moved = posed_of(*field)) return posed(filtered(moved->field, filter), moved->pose);
  const GridView& grid = grid_or_throw(*field);
  if (grid.filter == filter) return field;
  return made_of(grid, filter, grid.signless);
}

Volume filtered(Volume volume, std::optional<Filter> filter) {
  for (VolumeField& field : volume.fields) {
    const GridView* grid = filter ? nullptr : grid_below(*field.field);
    if (!filter && !(grid && grid->filter == Filter::trilinear)) continue;
    field.field =
        changed(field, [&](const FieldPtr& f) { return filtered(f, filter ? *filter : default_filter(grid->voxels.type)); });
  }
  return volume;
}

FieldPtr signless(FieldPtr field) {
  if (!field) throw std::invalid_argument("there is no field without a sign");
  if (const PosedView* moved = posed_of(*field)) return posed(signless(moved->field), moved->pose);
  const GridView& grid = grid_or_throw(*field);
  if (grid.signless) return field;
  return made_of(grid, grid.filter == Filter::trilinear ? Filter::trilinear : Filter::smooth, true);
}

Volume signless(Volume volume) {
  bool found = false;
  for (VolumeField& field : volume.fields) {
    if (field.field->components() != 3) continue;
    field.field = changed(field, [](const FieldPtr& f) { return signless(f); });
    found = true;
  }
  if (!found) throw std::invalid_argument("it has no vector field whose sign could mean nothing");
  return volume;
}

}  // namespace palpa
