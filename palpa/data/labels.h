// Label maps: whole numbers for the parts of a body, without meaning in between.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "palpa/data/field.h"
#include "palpa/data/statistics.h"

namespace palpa {

/// Part of a label map.
struct Label {
  double value = 0.0;  ///< in the field's own unit
  std::int64_t voxels = 0;
};

/// Parts of a grid of whole numbers.
struct LabelMap {
  /// [1] Different values, with the background. More: scans of few values may pass for label maps, and other data are searched
  /// longer; fewer: large atlases count as scans.
  static constexpr std::size_t most_values = 256;

  double background = 0.0;    ///< in the field's own unit: most frequent value at the grid's border
  std::vector<Label> labels;  ///< all others, the largest part first; empty: no label map
};

/// Label map of a field: a scalar grid of whole numbers with at most `LabelMap::most_values` different ones, in which most
/// neighbours of a voxel that is not background have its value (few do in measured data, by noise). Other fields: `labels` is
/// empty. Reads all voxels at most once.
LabelMap label_map(const Field& field);

/// `label_map` unless the file excludes it: a field with a unit, a scan of a modality other than segmentation, or values like
/// Hounsfield units have no labels.
/// \param modality  as Volume::modality
LabelMap label_map_unless_said(const Field& field, const Statistics& values, const std::string& unit,
                               const std::string& modality);

/// Indicator of a label: 1 where the voxels of a scalar grid are `label`, else 0, as a grid of whole numbers; interpolated
/// between voxels, so its level 0.5 is the surface of that part. Of a series, frame by frame. Throws std::invalid_argument,
/// with a sentence, on a field without voxels, of vectors or below a pose.
/// \param label  in the field's own unit
FieldPtr label_field(const Field& field, double label);

}  // namespace palpa
