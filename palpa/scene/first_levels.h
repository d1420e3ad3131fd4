// First levels of a scalar field, first speeds of a vector field.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "palpa/data/statistics.h"

namespace palpa::detail {

/// Surface between two classes of values.
struct FirstLevel {
  std::string name;
  double value = 0.0;  ///< the field's own unit
  double strength_n = 0.0;
  std::string why_value;  ///< half a sentence, for a comment in the scene
  std::string why_strength;
  bool soft = false;   ///< elastic: yields, so that a level below is felt through it
  bool holds = false;  ///< stronger than the force limit: cannot be pressed through
};

/// Surfaces of a scalar field: the solid lies on one side of all levels, the outermost first.
struct FirstLevels {
  bool solid_is_high = true;
  std::string why_solid;
  bool hounsfield = false;
  bool tissue = false;             ///< soft tissue: felt as a material, which yields everywhere and breaks nowhere
  std::vector<FirstLevel> levels;  ///< empty if the field does not vary
};

/// [N] `coupling.max_force_n` of a first scene: the largest force of small devices.
inline constexpr double first_max_force_n = 3.3;
/// [N] Of a level that holds: more than first_max_force_n, and than a device of 5 N at its limit.
inline constexpr double holding_n = 6.0;

/// Levels from the histogram: skin and bone of CT, of which bone holds; else the value that divides it best, and a second that
/// divides the solid. The sharper an edge, the firmer. A level over another is soft.
/// \param sample  the field, or of a field in octaves blocks of octave 0 (octave_parts.h): its edges are as sharp as they are
/// \param modality  as Volume::modality
/// \param is_scan  of a part of a body: the solid is then soft tissue, unless the values are Hounsfield units
FirstLevels first_levels(const Field& field, std::span<const FieldPtr> sample, const Statistics& values,
                         const std::string& unit, const std::string& modality, bool is_scan);

/// One level around all labels of a label map in octaves, whose labels have no fields of their own; none if it is no label map,
/// or some labels are below its background.
/// \param sample    blocks of octave 0
/// \param modality  as Volume::modality
std::optional<FirstLevels> level_around_labels(std::span<const FieldPtr> sample, const Statistics& values,
                                               const std::string& unit, const std::string& modality);

/// Value at which the drag of a sparse object begins, in the field's own unit: a share `wanted` [1] of `around` lies beyond it,
/// clamped between the mean outside of the solid and the first level.
/// \param around  values of the object's box
double faint_value(std::vector<double> around, const FirstLevels& first, double wanted);

/// Speeds of a vector field.
struct FirstFlow {
  bool directions = false;  ///< every nonzero vector has length 1
  double empty = 0.0;       ///< slower counts as still, in the field's own unit
  double moderate = 0.0;    ///< median above `empty`, in the field's own unit
  double fast = 0.0;        ///< 99.5 % of all, or of the moving part if that is little, is slower; in the field's own unit
};
FirstFlow first_flow(const Statistics& speeds);

/// Rounds the value to a thousandth to a hundredth of `span`, both in a common unit, for few digits in scenes.
double rounded(double value, double span) noexcept;

}  // namespace palpa::detail
