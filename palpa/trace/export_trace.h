// Export of traces: felt quantities at positions in the data.
#pragma once

#include <cstddef>
#include <filesystem>

#include "palpa/base/load_error.h"
#include "palpa/base/new_file.h"
#include "palpa/trace/trace.h"

namespace palpa {

/// Writes the felt path of the trace in `folder`, in the format of `file`'s ending:
///   .vtp       the proxy's path as a line with all columns of `FeltPath` as arrays, for ParaView and VTK, in metres
///   .csv       the columns
///   .h5        each column as a data set
///   .mrk.json  for 3D Slicer: the proxy's path as a curve of at most 2000 points, and the positions where a mode began contact
///              or broke through; RAS, in millimetres
/// The file gets its name when complete. Returns the number of ticks. Throws LoadError, also on a trace without ticks, and on
/// .h5 in a build without HDF5.
std::size_t export_trace(const std::filesystem::path& folder, const std::filesystem::path& file,
                         detail::Existing existing = detail::Existing::refused);

}  // namespace palpa
