// What is damaged: the sets of the shared data, and small ones of the formats that they lack.
#pragma once

#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "files.h"

namespace palpa::test {

struct SetToDamage {
  std::string name;
  /// Where it lies, a file or a folder; one that is made is written into the folder first.
  std::function<fs::path(const TemporaryFolder&)> original;
  std::vector<std::string> with{};  ///< files that are read with it, in the same folder
  VolumeRequest request{};          ///< without files
  std::string frames{};             ///< of a folder: the pattern of the files that are a time series
};
inline void PrintTo(const SetToDamage& set, std::ostream* to) { *to << set.name; }

/// \param data_folder  the shared data; where a set is not there, `original` names a file that is not
std::vector<SetToDamage> sets_to_damage(const fs::path& data_folder);
/// Of these the ones of VTK's own formats that are made.
std::vector<SetToDamage> vtk_sets_to_damage();

}  // namespace palpa::test
