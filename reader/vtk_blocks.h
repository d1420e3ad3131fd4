// Files of VTK's XML that name other files: .vtm, .pvd, .vtpc.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace palpa::reader {

/// Files named by an index of blocks, or of moments and parts.
struct VtkIndex {
  std::vector<std::string> files;  ///< of one moment, in the order of the index
  std::vector<double> times_s;     ///< [s] of the index, rising; empty: it has none
  double time_s = 0.0;             ///< [s] of `files`
};

/// True for a type of VTK's XML that is an index: "vtkMultiBlockDataSet".
bool is_vtk_index(const std::string& type);

/// Parses an index. Files must lie in its folder or below. Throws LoadError with a sentence.
/// \param time_s  [s] wanted; none: the latest
VtkIndex read_vtk_index(const std::string& path, const std::optional<double>& time_s);

}  // namespace palpa::reader
