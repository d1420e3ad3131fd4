// The exception that loading throws.
#pragma once

#include <stdexcept>
#include <string>

namespace palpa {

/// Something that was loaded cannot be used. `what()` is one line: `PLACE: what is wrong; what would be
/// right` with PLACE = file:line:column, a file, or what the error is about.
class LoadError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace palpa
