// Statistics of a field's values: mean, deviation, histogram, and dividing values.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "palpa/data/grid.h"

namespace palpa {

/// Counts of values in classes of equal width.
struct Histogram {
  double low = 0.0;                    ///< start of the first class, in the field's own unit
  double high = 0.0;                   ///< end of the last class, in the field's own unit
  std::vector<std::int64_t> counts{};  ///< at least one class
  friend bool operator==(const Histogram&, const Histogram&) = default;

  /// Start of class `number`, in the field's own unit; `high` for `counts.size()`.
  double edge(std::size_t number) const noexcept;
  std::int64_t total() const noexcept;
  /// The counts merged to `classes` >= 1 classes; at most as many as now.
  Histogram in_classes(std::size_t classes) const;
  /// Value below which a share of all lies, interpolated within a class; in the field's own unit.
  /// \param share  [1]
  double percentile(double share) const noexcept;
  /// Share [1] of all between two values, interpolated within a class.
  /// \param from  in the field's own unit
  /// \param to    in the field's own unit
  double share_between(double from, double to) const noexcept;
  /// Mean of the values between two limits, in the field's own unit; their middle if there are none.
  /// \param from  in the field's own unit
  /// \param to    in the field's own unit
  double mean_between(double from, double to) const noexcept;
};

/// Statistics of a scalar field; of a vector field, of its lengths.
struct Statistics {
  std::int64_t counted = 0;   ///< finite values examined
  std::int64_t zeros = 0;     ///< of them exactly 0
  std::int64_t one_in = 1;    ///< 1: every voxel was examined; n: one row of voxels in n
  double min = 0.0;           ///< of the examined values, in the field's own unit
  double max = 0.0;           ///< in the field's own unit
  double mean = 0.0;          ///< in the field's own unit
  double deviation = 0.0;     ///< standard deviation, in the field's own unit
  GridPoint max_at;           ///< first voxel with the largest value
  Histogram histogram;        ///< from min to max
  bool whole_numbers = true;  ///< no value has a fraction

  /// The histogram's percentile, in the field's own unit, but exact if its class holds a single whole number, or mostly zeros.
  /// \param share  [1]
  double percentile(double share) const noexcept;
};

/// Statistics of all voxels of the grid behind the field (grid_behind); beyond `most` voxels, of about that many, in rows
/// spread evenly; of a field in octaves, also below poses, of a sample of octave 0 (octave_parts.h), which is read; of another
/// field without voxels at places spread evenly over its box. Uses all cores. Throws std::bad_alloc, and LoadError where a
/// sample cannot be read.
Statistics statistics(const Field& field, std::int64_t most = std::int64_t{1} << 24);
/// Statistics of all voxels of several grids together, each with a grid behind it; `max_at` stays 0. Throws std::bad_alloc
/// only.
Statistics statistics(std::span<const FieldPtr> grids);

/// Value that divides the values between `from` and `to` (the field's own unit) into two classes with the least spread within
/// them (N. Otsu, IEEE Trans. SMC 9, 1979). None if all values lie in one class of the histogram. In the field's own unit.
std::optional<double> dividing_value(const Histogram& histogram, double from, double to);

/// Whether a scalar field is in Hounsfield units: by its unit, or, without a unit and a modality other than CT, by values like
/// those of CT: air near -1000, tissue near 0, bone above.
/// \param modality  as Volume::modality
bool looks_like_hounsfield(const Statistics& values, const std::string& unit, const std::string& modality = {});

/// Whether a field's vectors are directions: nearly all nonzero ones have length 1 to 2 %.
bool looks_like_directions(const Statistics& lengths);

}  // namespace palpa
