// Exception of all loading functions.
#pragma once

#include <stdexcept>
#include <string>

namespace palpa {

/// Input that cannot be used. `what()` is one line: `PLACE: what is wrong; what would be right` with PLACE = file:line:column,
/// a file, or the subject of the error.
class LoadError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace palpa
