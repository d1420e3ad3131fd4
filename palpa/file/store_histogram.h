// Histograms of the fields of a store.
#pragma once

#include <functional>

#include "palpa/data/statistics.h"
#include "palpa/file/store_reader.h"

namespace palpa::detail {

/// Chunks of octave 0 that the histograms of a store are of: all, or this many, evenly spread over all frames.
inline constexpr std::int64_t most_histogram_chunks = 4096;

/// Histogram of a field in up to 256 classes: of whole numbers of fewer values a class for each, of vectors of their length,
/// else of equal width from the least to the largest value. Values that are not finite are left out. Equal stores give equal
/// counts. The reader has no request pending. Blocks. Throws LoadError, also of `go_on`.
/// \param low    [raw] least value of the field's components
/// \param high   [raw] largest one
/// \param go_on  called before each request; false ends the counting
Histogram store_histogram(StoreReader& reader, int field, double low, double high, const std::function<bool()>& go_on);

}  // namespace palpa::detail
