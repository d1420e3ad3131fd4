// What is worth feeling first: the levels of a scalar field, the speeds of a vector field.
#pragma once

#include <string>
#include <vector>

#include "palpa/data/statistics.h"

namespace palpa::detail {

/// A surface between two classes of values.
struct FirstLevel {
  std::string name;
  double value = 0.0;  ///< the field's own unit
  double strength_n = 0.0;
  std::string why_value;  ///< half a sentence, for a comment in the scene
  std::string why_strength;
  bool soft = false;   ///< elastic: gives way, so that a level below is felt through it
  bool holds = false;  ///< stronger than any force that reaches the hand: it cannot be pressed through
};

/// A scalar field as surfaces: what is solid lies on one side of all levels, the outermost first.
struct FirstLevels {
  bool solid_is_high = true;
  std::string why_solid;
  bool hounsfield = false;
  bool tissue = false;             ///< soft tissue: felt as a material, which yields everywhere and breaks nowhere
  std::vector<FirstLevel> levels;  ///< empty where the field does not vary
};

/// [N] `coupling.max_force_n` of a first scene: the most that small devices give.
inline constexpr double first_max_force_n = 3.3;
/// [N] Of a level that holds: more than first_max_force_n, and than a device of 5 N that is given all of its force.
inline constexpr double holding_n = 6.0;

/// Levels from the histogram: skin and bone of CT, of which bone holds; else the value that divides it best, and a second one
/// that divides what is solid. Strengths come from the gradients: the sharper an edge, the firmer. A level over another one is
/// soft.
/// \param modality  as Volume::modality
/// \param is_scan  of a part of a body: what is solid is then soft tissue, unless the values are Hounsfield units
FirstLevels first_levels(const Field& field, const Statistics& values, const std::string& unit, const std::string& modality,
                         bool is_scan);

/// The value at which the drag of a sparse object begins, in the field's own unit: a share `wanted` [1] of `around` lies beyond
/// it, and it lies between the mean of what is not solid there and the first level. \param around  values of the object's box
double faint_value(std::vector<double> around, const FirstLevels& first, double wanted);

/// A vector field as a flow.
struct FirstFlow {
  bool directions = false;  ///< every vector that is not zero has length 1
  double empty = 0.0;       ///< slower counts as still, in the field's own unit
  double moderate = 0.0;    ///< median of what is faster than `empty`, in the field's own unit
  double fast = 0.0;        ///< 99.5 % of all, or of what moves if that is little, is slower; in the field's own unit
};
FirstFlow first_flow(const Statistics& speeds);

/// The value rounded to a thousandth to a hundredth of `span`, both in the same unit, so that scenes show few digits.
double rounded(double value, double span) noexcept;

}  // namespace palpa::detail
