// What attributes say of the arrays of HDF5 and netCDF-4 files, by the CF conventions and those of netCDF before them: which
// numbers stand for values, and where the voxels lie.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "hdf5_objects.h"

namespace palpa::reader {

/// How the values of an array are stored: value = stored · scale + offset, and which stored numbers are no data.
struct Packing {
  double scale = 1.0;                                       ///< [unit of the values per stored step]
  double offset = 0.0;                                      ///< [unit of the values]
  std::vector<double> missing;                              ///< stored numbers that stand for none
  double least = -std::numeric_limits<double>::infinity();  ///< stored numbers below are no data
  double most = std::numeric_limits<double>::infinity();    ///< stored numbers above are no data
  double unsigned_by = 0.0;  ///< is added to negative stored numbers, which stand for positive ones; 0: they stay
  double signed_by = 0.0;  ///< is taken from stored numbers of half of it and more, which stand for negative ones; 0: they stay

  /// Whether some stored numbers do not stand for themselves, so that they are kept as floating point.
  bool marks_any() const noexcept;
  /// Value of a stored number after the correction of its sign.
  template <class T>
  T with_sign(T number) const noexcept {
    if (number < T{0}) return number + static_cast<T>(unsigned_by);
    return signed_by != 0.0 && number >= static_cast<T>(0.5 * signed_by) ? number - static_cast<T>(signed_by) : number;
  }
  /// Makes what is no data not finite. T: float or double, which holds the stored numbers.
  template <class T>
  void mark(T* numbers, std::size_t count) const;
};

/// The packing of an array by its attributes scale_factor, add_offset, _FillValue, missing_value, valid_min, valid_max,
/// valid_range and _Unsigned; in a netCDF file also by the fill value that netCDF writes by itself. Adds to `warnings` what of
/// these is not applied. Throws LoadError where the values cannot be known.
Packing packing_of(hid_t dataset, RawType type, bool is_netcdf, std::vector<std::string>& warnings);

/// Whether the netCDF library wrote the file or the array.
bool is_netcdf(hid_t file, hid_t dataset);

/// One index of an array.
struct Dimension {
  std::int64_t length = 1;
  char along = ' ';                 ///< x, y, z, t (time), c (vector components); blank: nothing says it
  std::string name;                 ///< of its scale or label; empty: it has none
  std::string unit;                 ///< of its coordinates, as the file says it
  std::vector<double> coordinates;  ///< as many as its length, finite; none: the file has none
};

/// The indices of an array, slowest first, by its dimension scales (`axis`, `standard_name`, `units`, `positive`, their names)
/// and labels. Adds to `warnings` what of these is not taken.
std::vector<Dimension> dimensions_of(hid_t dataset, const Shape& shape, std::vector<std::string>& warnings);

/// Whether the file says where voxels lie along one of these axes at least.
bool has_places(const std::array<Dimension, 3>& of);

/// The coordinates of x, y and z in one unit of length, whatever units they have in the file.
struct Coordinates {
  std::array<std::vector<double>, 3> of;
  std::string unit;  ///< of length; empty: the file says none
};
/// \param of  those of x, y and z; those without coordinates get even steps, which a warning says
Coordinates in_one_unit(const std::array<Dimension, 3>& of, std::vector<std::string>& warnings);

}  // namespace palpa::reader
