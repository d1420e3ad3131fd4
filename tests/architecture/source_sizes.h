// The lengths of a source's functions.
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

}  // namespace palpa::architecture
