// Statistics of the values of a field: mean, spread, histogram, and the values that divide it into classes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "palpa/data/grid.h"

namespace palpa {

/// Counts of values in classes of equal width.
struct Histogram {
  double low = 0.0;                    ///< where the first class begins, in the field's own unit
  double high = 0.0;                   ///< where the last class ends, in the field's own unit
  std::vector<std::int64_t> counts{};  ///< at least one class

  /// Where class `number` begins, in the field's own unit; `high` for `counts.size()`.
  double edge(std::size_t number) const noexcept;
  std::int64_t total() const noexcept;
  /// The same counts in `classes` >= 1 classes, or as many as now if that is fewer.
  Histogram in_classes(std::size_t classes) const;
  /// The value below which a share of all lies, within a class in proportion; in the field's own unit.
  /// \param share  [1]
  double percentile(double share) const noexcept;
  /// The share [1] of all that lies between two values, within a class in proportion.
  /// \param from  in the field's own unit
  /// \param to    in the field's own unit
  double share_between(double from, double to) const noexcept;
  /// The mean of what lies between two values, in the field's own unit; the middle where nothing does.
  /// \param from  in the field's own unit
  /// \param to    in the field's own unit
  double mean_between(double from, double to) const noexcept;
};

/// The values of a scalar field; of a vector field, the lengths of its vectors.
struct Statistics {
  std::int64_t counted = 0;   ///< finite values that were looked at
  std::int64_t zeros = 0;     ///< of them exactly 0
  std::int64_t one_in = 1;    ///< 1: every voxel was looked at; n: one row of voxels in n
  double min = 0.0;           ///< of those looked at, in the field's own unit
  double max = 0.0;           ///< in the field's own unit
  double mean = 0.0;          ///< in the field's own unit
  double deviation = 0.0;     ///< standard deviation, in the field's own unit
  GridPoint max_at;           ///< the first voxel with the largest value
  Histogram histogram;        ///< from min to max
  bool whole_numbers = true;  ///< none has a fraction

  /// The histogram's percentile, in the field's own unit, but exact where its class holds a single whole number, or mostly
  /// zeros.
  /// \param share  [1]
  double percentile(double share) const noexcept;
};

/// Statistics of all voxels of the grid behind the field (grid_behind); where it has more than `most` voxels, of about that
/// many, in rows spread evenly; of a field without voxels at places spread evenly over its box. Uses as many threads as there
/// are cores. Throws nothing but bad_alloc.
Statistics statistics(const Field& field, std::int64_t most = std::int64_t{1} << 24);

/// The value that divides the values between `from` and `to` (the field's own unit) into two classes as far apart as possible,
/// with the least spread within them (N. Otsu, IEEE Trans. SMC 9, 1979). None where all values lie in one class of the
/// histogram. In the field's own unit.
std::optional<double> dividing_value(const Histogram& histogram, double from, double to);

/// Whether the values of a scalar field are Hounsfield units: its unit says so, or, where the file names neither a unit nor
/// another modality than CT, the values are like those of CT: air near -1000, tissue near 0, bone above.
/// \param modality  as Volume::modality
bool looks_like_hounsfield(const Statistics& values, const std::string& unit, const std::string& modality = {});

/// Whether the vectors of a field are directions: those that are not zero have length 1 to 2 %, nearly all of them.
bool looks_like_directions(const Statistics& lengths);

}  // namespace palpa
