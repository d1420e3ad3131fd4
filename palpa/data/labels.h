// Label maps: whole numbers that name the parts of a body, and mean nothing between them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "palpa/data/field.h"
#include "palpa/data/statistics.h"

namespace palpa {

/// A part of a label map.
struct Label {
  double value = 0.0;  ///< in the field's own unit
  std::int64_t voxels = 0;
};

/// The parts that a grid of whole numbers names.
struct LabelMap {
  /// [1] Different values, background and all. More: scans of few values may pass for label maps, and other data are searched
  /// longer; fewer: large atlases are taken for scans.
  static constexpr std::size_t most_values = 256;

  double background = 0.0;    ///< in the field's own unit: the value that most of the border of the grid has
  std::vector<Label> labels;  ///< all others, the largest part first; empty: the field is no label map
};

/// The field as a label map, if it looks like one: a scalar grid of whole numbers, no more than `LabelMap::most_values`
/// different ones, in which most neighbours of a voxel that is not background have its value (measured data have noise, so that
/// few do). For other fields `labels` is empty. Reads all voxels at most once.
LabelMap label_map(const Field& field);

/// `label_map` where the file leaves it open: of a field with a unit, and of a scan whose modality is another than that of
/// segmentations, the values are no labels, whatever they look like; nor are those that look like Hounsfield units.
/// \param modality  as Volume::modality
LabelMap label_map_unless_said(const Field& field, const Statistics& values, const std::string& unit,
                               const std::string& modality);

/// 1 where the voxels of a scalar grid are `label`, and 0 elsewhere, as a grid of whole numbers; between voxels it goes from
/// one to the other, so its level 0.5 is the surface of that part. Of a series, frame by frame. Throws std::invalid_argument,
/// with a sentence, on a field without voxels, of vectors or below a pose. \param label  in the field's own unit
FieldPtr label_field(const Field& field, double label);

}  // namespace palpa
