// Numbers that leave a header carry their unit.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpa::architecture {

/// A number of a header whose unit nobody can tell.
struct UnitlessNumber {
  int line = 0;
  std::string name;
};

/// The public numbers of a header that do not say their unit. A number is a data member, a parameter or
/// a function's result of type double, float or Vec3 (also within std::optional and the like) at namespace
/// scope or in a public part of a class; namespaces called detail are private. It says its unit when
///   its name ends with one: `depth_m`, `stiffness_n_per_m`, `tick_us_p99`, or
///   its comment does, in brackets or as "own unit": `double scale;  ///< [1] …`. The comment is the one
///   behind it or above it; a parameter's is the words from `\param name` or `` `name` `` to the end of that line.
std::vector<UnitlessNumber> unitless_numbers(std::string_view header);

/// Whether a name ends with a unit.
bool ends_with_unit(const std::string& name);

}  // namespace palpa::architecture
