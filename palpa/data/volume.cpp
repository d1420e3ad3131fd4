#include "palpa/data/volume.h"

#include <stdexcept>
#include <utility>

#include "palpa/data/filter.h"
#include "palpa/data/sampled.h"
#include "palpa/data/timed_field.h"

namespace palpa {
namespace {

template <class Change>
FieldPtr changed(const VolumeField& field, Change change) {
  try {
    return change(field.field);
  } catch (const std::invalid_argument& problem) {
    throw std::invalid_argument("field '" + field.name + "': " + problem.what());
  }
}

}  // namespace

Volume posed(const Volume& volume, const Similarity& pose) {
  Volume moved = volume;
  for (VolumeField& f : moved.fields) f.field = posed(std::move(f.field), pose);
  return moved;
}

Volume moving(const Volume& volume, const PoseTrack& track) {
  Volume moved = volume;
  for (VolumeField& f : moved.fields) f.field = moving(std::move(f.field), track);
  return moved;
}

Volume sampled(const Volume& volume, int longest) {
  Volume grids = volume;
  grids.format = "grid";
  for (VolumeField& f : grids.fields) f.field = sampled(*f.field, longest);
  return grids;
}

Volume sampled(const Volume& volume, int longest, int frames, BetweenFrames between_frames) {
  Volume grids = volume;
  grids.format = "grid";
  for (VolumeField& f : grids.fields) f.field = sampled(f.field, longest, frames, between_frames);
  return grids;
}

Volume filtered(Volume volume, std::optional<Filter> filter) {
  for (VolumeField& field : volume.fields) {
    const GridView* grid = filter ? nullptr : grid_below(*field.field);
    if (!filter && !(grid && grid->filter == Filter::trilinear)) continue;
    field.field =
        changed(field, [&](const FieldPtr& f) { return filtered(f, filter ? *filter : default_filter(*grid).filter); });
  }
  return volume;
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
