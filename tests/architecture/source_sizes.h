// How much of a source there is: its functions' lengths, and the numbers that it names.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpa::architecture {

struct FunctionLength {
  std::string name;
  int line = 0;   ///< where it begins
  int lines = 0;  ///< from there to its closing brace
};
/// The functions that a source defines, at namespace scope or in a class.
std::vector<FunctionLength> functions_of(std::string_view source);

/// The names of what a source declares constexpr, in any scope, with a number in its value. Other names for
/// the same, like `std::numeric_limits` and constants of another class, are none.
std::vector<std::string> named_constants(std::string_view source);

}  // namespace palpa::architecture
