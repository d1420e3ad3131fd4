// HDF5 is linked into a shared object of its own, palpa-hdf5.so, which is loaded by name: nothing else needs the library.
#pragma once

#include <string>

#include "palpa/trace/trace.h"

namespace palpa::detail {

/// What palpa-hdf5.so exports as `palpa_hdf5`.
struct Hdf5 {
  const char* palpa_version;
  /// The file that holds each column as a data set, as bytes; empty: the library refuses.
  std::string (*file_of)(const FeltPath& path);
};

}  // namespace palpa::detail
