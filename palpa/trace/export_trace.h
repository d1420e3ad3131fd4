// Traces for other programs: what was felt, where it was felt in the data.
#pragma once

#include <cstddef>
#include <filesystem>

#include "palpa/base/load_error.h"
#include "palpa/base/new_file.h"
#include "palpa/trace/trace.h"

namespace palpa {

/// Writes what was felt in the trace in `folder`, by the ending of `file`:
///   .vtp       the proxy's path as a line with all columns of `FeltPath` as arrays, for ParaView and VTK, in metres
///   .csv       the columns
///   .h5        each column as a data set
///   .mrk.json  for 3D Slicer: the proxy's path as a curve of at most 2000 points, and the places where a mode began to hold
///              or gave way; RAS, in millimetres
/// It gets its name when it is whole. Returns how many ticks were written. Throws LoadError, also where the trace has no tick,
/// and of .h5 where this palpa was built without HDF5.
std::size_t export_trace(const std::filesystem::path& folder, const std::filesystem::path& file,
                         detail::Existing existing = detail::Existing::refused);

}  // namespace palpa
