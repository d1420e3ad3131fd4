// Interface to HDF5, in a shared object of its own, palpa-hdf5.so, loaded by name: nothing else needs the library.
#pragma once

#include <string>

#include "palpa/trace/trace.h"

namespace palpa::detail {

/// Export `palpa_hdf5` of palpa-hdf5.so.
struct Hdf5 {
  const char* palpa_version;
  /// Content of a file with each column as a data set; empty if the library fails.
  std::string (*file_of)(const FeltPath& path);
};

}  // namespace palpa::detail
