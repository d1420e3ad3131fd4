// What the names of a file and of its fields say of its size.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "palpa/data/volume.h"

namespace palpa {

/// A word in the name of a file or of a field that belongs to a part of a body.
struct BodyHint {
  std::string part;  ///< "blood vessel"
  std::string name;  ///< the file or field that is called so
};

/// [m] No part of a body is longer. More: data in wrong units pass; less: a person who lies at full length is asked about.
inline constexpr double longest_body_m = 2.5;

/// The part of a body that data of more than `longest_body_m` cannot be, though a name says it, where the unit of length is
/// assumed: the unit is then probably another one. None for data that are shorter, whose unit is known, or without such a name.
/// Allocates; any thread. \param files  as they were asked for
std::optional<BodyHint> too_long_for(const Volume& volume, const std::vector<std::filesystem::path>& files);

}  // namespace palpa
