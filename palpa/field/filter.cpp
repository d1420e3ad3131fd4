#include "palpa/field/filter.h"

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "palpa/field/axis_grid.h"
#include "palpa/field/smooth_grid.h"
#include "palpa/field/timed_field.h"

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

/// The field with every grid below its poses and frames made into another.
template <class Make>
FieldPtr remade(const FieldPtr& field, const Make& make) {
  if (const PosedView* view = posed_of(*field)) return posed(remade(view->field, make), view->pose);
  if (const MovingView* view = moving_of(*field)) return moving(remade(view->field, make), view->track, view->per_length);
  if (const SeriesView* view = series_of(*field)) {
    std::vector<FieldPtr> frames;
    for (const FieldPtr& frame : view->frames) frames.push_back(remade(frame, make));
    return time_series(std::move(frames), view->period_s, view->between_frames);
  }
  const GridView* grid = grid_behind(*field);
  if (!grid) throw std::invalid_argument("it is a formula and has no voxels; sample it first");
  return make(*grid);
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

const GridView* grid_below(const Field& field) noexcept {
  if (const PosedView* view = posed_of(field)) return grid_below(*view->field);
  if (const MovingView* view = moving_of(field)) return grid_below(*view->field);
  if (const SeriesView* view = series_of(field)) return grid_below(*view->frames.front());
  return grid_behind(field);
}

FieldPtr filtered(FieldPtr field, Filter filter) {
  if (!field) throw std::invalid_argument("there is no field to filter");
  const GridView* grid = grid_below(*field);
  if (grid && grid->filter == filter) return field;
  return remade(field, [&](const GridView& of) { return made_of(of, filter, of.signless); });
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
  if (is_axis_field(*field)) return field;
  return remade(field, [](const GridView& of) {
    return made_of(of, of.filter == Filter::trilinear ? Filter::trilinear : Filter::smooth, true);
  });
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
