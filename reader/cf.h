// Packing and axes of HDF5 and netCDF-4 arrays, from their attributes by the CF conventions and older netCDF ones.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "hdf5_objects.h"

namespace palpa::reader {

/// Storage of an array's values: value = stored · scale + offset; some stored numbers are no data.
struct Packing {
  double scale = 1.0;                                       ///< [unit of the values per stored step]
  double offset = 0.0;                                      ///< [unit of the values]
  std::vector<double> missing;                              ///< stored numbers without a value
  double least = -std::numeric_limits<double>::infinity();  ///< stored numbers below are no data
  double most = std::numeric_limits<double>::infinity();    ///< stored numbers above are no data
  double unsigned_by = 0.0;  ///< added to negative stored numbers, which represent positive ones; 0: none
  double signed_by = 0.0;    ///< subtracted from stored numbers of at least half of it, which represent negative ones; 0: none

  /// True if some stored numbers are no data, so that values are kept as floating point.
  bool marks_any() const noexcept;
  /// Value of a stored number after the correction of its sign.
  template <class T>
  T with_sign(T number) const noexcept {
    if (number < T{0}) return number + static_cast<T>(unsigned_by);
    return signed_by != 0.0 && number >= static_cast<T>(0.5 * signed_by) ? number - static_cast<T>(signed_by) : number;
  }
  /// Replaces numbers that are no data by NaN. T: float or double.
  template <class T>
  void mark(T* numbers, std::size_t count) const;
};

/// Packing of an array, from its attributes scale_factor, add_offset, _FillValue, missing_value, valid_min, valid_max,
/// valid_range and _Unsigned; in a netCDF file also from netCDF's default fill value. Adds attributes that are not applied to
/// `warnings`. Throws LoadError if the values are ambiguous.
Packing packing_of(hid_t dataset, RawType type, bool is_netcdf, std::vector<std::string>& warnings);

/// True if the netCDF library wrote the file or the array.
bool is_netcdf(hid_t file, hid_t dataset);

/// One index of an array.
struct Dimension {
  std::int64_t length = 1;
  char along = ' ';                 ///< x, y, z, t (time), c (vector components); blank: unknown
  std::string name;                 ///< of its scale or label; empty: none
  std::string unit;                 ///< of its coordinates, as in the file
  std::vector<double> coordinates;  ///< as many as its length, finite; empty: none in the file
};

/// Indices of an array, slowest first, from its dimension scales (`axis`, `standard_name`, `units`, `positive`, names) and
/// labels. Adds unused attributes to `warnings`.
std::vector<Dimension> dimensions_of(hid_t dataset, const Shape& shape, std::vector<std::string>& warnings);

/// True if the file has coordinates of at least one of these axes.
bool has_places(const std::array<Dimension, 3>& of);

/// Coordinates of x, y and z, converted to one unit of length.
struct Coordinates {
  std::array<std::vector<double>, 3> of;
  std::string unit;  ///< of length; empty: none in the file
};
/// \param of  x, y and z; axes without coordinates get even steps, and a warning
Coordinates in_one_unit(const std::array<Dimension, 3>& of, std::vector<std::string>& warnings);

}  // namespace palpa::reader
