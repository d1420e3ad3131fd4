// Hints of the data's size from the names of a file and of its fields.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "palpa/data/volume.h"

namespace palpa {

/// Word for a part of a body in the name of a file or of a field.
struct BodyHint {
  std::string part;  ///< "blood vessel"
  std::string name;
};

/// [m] Upper bound of a part of a body. More: data in wrong units pass; less: a question about a person at full length.
inline constexpr double longest_body_m = 2.5;

/// Part of a body, by name, that cannot be longer than `longest_body_m` as these data are, if the unit of length is assumed: it
/// is then probably wrong. None for shorter data, a known unit, or other names. Allocates; any thread.
/// \param files  as requested
std::optional<BodyHint> too_long_for(const Volume& volume, const std::vector<std::filesystem::path>& files);

}  // namespace palpa
