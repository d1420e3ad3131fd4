// Data sets to damage: the shared data, and small sets of missing formats.
#pragma once

#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "files.h"

namespace palpa::test {

struct SetToDamage {
  std::string name;
  /// Path of a file or a folder; a made set is written into the folder first.
  std::function<fs::path(const TemporaryFolder&)> original;
  std::vector<std::string> with{};  ///< files that are read with it, in the same folder
  VolumeRequest request{};
  std::string frames{};  ///< of a folder: the pattern of a time series' files
  bool chunks = false;   ///< all chunks of a store are read by StoreReader, not its octave 0 as a volume
};
inline void PrintTo(const SetToDamage& set, std::ostream* to) { *to << set.name; }

/// \param data_folder  the shared data; for a missing set `original` names a missing file
std::vector<SetToDamage> sets_to_damage(const fs::path& data_folder);
/// The made sets of VTK's own formats.
std::vector<SetToDamage> vtk_sets_to_damage();

}  // namespace palpa::test
