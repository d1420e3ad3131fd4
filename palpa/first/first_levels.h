// What of a field is worth feeling first: the levels of a scalar one, the speeds of a vector one.
#pragma once

#include <string>
#include <vector>

#include "palpa/survey/statistics.h"

namespace palpa::detail {

/// A surface between two classes of values.
struct FirstLevel {
  std::string name;
  double value = 0.0;  ///< the field's own unit
  double strength_n = 0.0;
  std::string why_value;  ///< half sentences, for comments
  std::string why_strength;
  bool soft = false;  ///< gives way, so that what is below is felt through it
};

/// A scalar field as surfaces: what is solid lies on one side of all levels, the outermost first.
struct FirstLevels {
  bool solid_is_high = true;
  std::string why_solid;
  bool hounsfield = false;
  std::vector<FirstLevel> levels;  ///< empty where the field does not vary
};

/// Levels from the histogram: skin and bone of CT, else where it parts best, once, and again within what is solid. Their
/// strengths from the gradients: the sharper an edge, the firmer. What lies over another is soft.
FirstLevels first_levels(const Field& field, const Statistics& values, const std::string& unit);

/// Where the drag of something sparse begins: the value beyond which lies a share `wanted` [1] of what is around it, between
/// the mean of what is not solid there and the first level; in the field's own unit. \param around  values of the object's box
double faint_value(std::vector<double> around, const FirstLevels& first, double wanted);

/// A vector field as a flow.
struct FirstFlow {
  bool directions = false;  ///< every vector that is not zero has length 1
  double empty = 0.0;       ///< slower is as good as still, in the field's own unit
  double moderate = 0.0;    ///< median of what is faster, in the field's own unit
  double fast = 0.0;        ///< all but half a percent is slower, of all or of the little that moves, in the field's own unit
};
FirstFlow first_flow(const Statistics& speeds);

/// The value with as many digits as tell it apart within a span of values, both in the same unit.
double rounded(double value, double span) noexcept;

}  // namespace palpa::detail
