#include "cf.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <string_view>

#include "palpa/base/load_error.h"
#include "palpa/data/length_unit.h"

namespace palpa::reader {
namespace {

constexpr std::int64_t most_planes =
    1'000'000;  // along an axis. More: memory for damaged files; fewer: long axes have no coordinates
constexpr double earth_radius_m = 6'371'000;  // mean

/// [m] per unit of length; 0 if unknown.
double metres_per(const std::string& unit) {
  const auto known = palpa::detail::length_unit(unit);
  return known ? known->metres : 0.0;
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool is_one_of(const std::string& word, std::initializer_list<std::string_view> words) {
  return std::ranges::find(words, word) != words.end();
}

bool is_whole(RawType type) { return type != RawType::float32 && type != RawType::float64; }

/// Single number of an attribute, `without` it. Throws LoadError if it is no finite number.
double one_number(hid_t dataset, const char* name, double without) {
  const auto numbers = numbers_attribute(dataset, name);
  if (!numbers) return without;
  if (numbers->size() != 1 || !std::isfinite(numbers->front()))
    throw LoadError("has a " + std::string(name) + " that is not one finite number, so its values cannot be known; correct it");
  return numbers->front();
}

/// netCDF's default fill value by type; none for bytes.
std::vector<double> netcdf_fill(RawType type) {
  switch (type) {
    case RawType::int16: return {-32767};
    case RawType::uint16: return {65535};
    case RawType::int32: return {-2147483647};
    case RawType::uint32: return {4294967295};
    case RawType::int64: return {-9223372036854775806.0};
    case RawType::uint64: return {18446744073709551614.0};
    case RawType::float32:
    case RawType::float64: return {9.9692099683868690e+36};
    default: return {};
  }
}

/// True if voxels that were never written have a defined fill value, as netCDF's have.
bool has_fill_value(hid_t dataset) {
  const Handle creation(H5Dget_create_plist(dataset), H5Pclose);
  H5D_fill_value_t chosen = H5D_FILL_VALUE_UNDEFINED;
  return H5Pfill_value_defined(creation, &chosen) >= 0 && chosen == H5D_FILL_VALUE_USER_DEFINED;
}

bool has_floating_attribute(hid_t dataset, const char* name) {
  const Handle attribute(H5Aopen(dataset, name, H5P_DEFAULT), H5Aclose), type(H5Aget_type(attribute), H5Tclose);
  return type.is_open() && H5Tget_class(type) == H5T_FLOAT;
}

void find_missing(hid_t dataset, RawType type, bool netcdf, Packing& packing, std::vector<std::string>& warnings) {
  bool any = false;
  for (const char* name : {"_FillValue", "missing_value"}) {
    const auto numbers = numbers_attribute(dataset, name);
    if (!numbers) continue;
    if (numbers->empty()) {
      warnings.push_back(std::string("has a ") + name + " that holds no number: it is not applied");
      continue;
    }
    any = true;
    packing.missing.insert(packing.missing.end(), numbers->begin(), numbers->end());
  }
  if (!any && netcdf && has_fill_value(dataset)) packing.missing = netcdf_fill(type);
}

/// Range of data. By netCDF's rule, whole numbers with a range of the unpacked values' type have it in the unpacked unit.
void find_range(hid_t dataset, RawType type, Packing& packing, std::vector<std::string>& warnings) {
  double least = packing.least, most = packing.most;
  bool is_unpacked = false, any = false;
  const auto take = [&](const char* name, std::size_t count, auto use) {
    const auto numbers = numbers_attribute(dataset, name);
    if (!numbers) return;
    if (numbers->size() != count || std::ranges::any_of(*numbers, [](double n) { return std::isnan(n); })) {
      warnings.push_back(std::string("has a ") + name + " that does not hold " + (count == 1 ? "one number" : "two numbers") +
                         ": it is not applied");
      return;
    }
    any = true;
    is_unpacked = is_unpacked || (is_whole(type) && has_floating_attribute(dataset, name));
    use(*numbers);
  };
  take("valid_min", 1, [&](const std::vector<double>& n) { least = n[0]; });
  take("valid_max", 1, [&](const std::vector<double>& n) { most = n[0]; });
  take("valid_range", 2, [&](const std::vector<double>& n) { least = n[0], most = n[1]; });
  if (!any) return;
  if (!is_unpacked) {
    if (std::isfinite(least)) least = packing.with_sign(least);
    if (std::isfinite(most)) most = packing.with_sign(most);
  }
  if (least > most) {
    warnings.push_back("has a valid range whose ends are exchanged: it is not applied");
    return;
  }
  if (is_unpacked && (packing.scale != 1.0 || packing.offset != 0.0)) {
    warnings.push_back("has a valid range of the type of its unpacked values: it is taken in their unit");
    least = (least - packing.offset) / packing.scale, most = (most - packing.offset) / packing.scale;
    if (packing.scale < 0.0) std::swap(least, most);
  }
  packing.least = least, packing.most = most;
}

/// Names of unread attributes that may describe storage or positions.
std::string unread_attributes(hid_t dataset) {
  constexpr int most = 200;  // attributes searched
  std::string names;
  for (int n = 0; n < std::min(most, H5Aget_num_attrs(dataset)); ++n) {
    const Handle attribute(
        H5Aopen_by_idx(dataset, ".", H5_INDEX_NAME, H5_ITER_INC, static_cast<hsize_t>(n), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    char text[64] = {};
    if (!attribute.is_open() || H5Aget_name(attribute, sizeof text, text) >= static_cast<ssize_t>(sizeof text)) continue;
    const std::string word = lower(text);
    static const std::initializer_list<std::string_view> known_parts{"scale",      "offset",  "slope",  "intercept", "gain",
                                                                     "fill",       "missing", "nodata", "no_data",   "spacing",
                                                                     "resolution", "voxel",   "pixel"};
    const bool is_read = is_one_of(text, {"scale_factor", "add_offset", "_FillValue", "missing_value"});
    if (is_read ||
        std::ranges::none_of(known_parts, [&](std::string_view part) { return word.find(part) != std::string::npos; }))
      continue;
    names += (names.empty() ? "'" : ", '") + std::string(text) + "'";
  }
  return names;
}

}  // namespace

bool Packing::marks_any() const noexcept {
  return !missing.empty() || std::isfinite(least) || std::isfinite(most) || unsigned_by != 0.0 || signed_by != 0.0;
}

template <class T>
void Packing::mark(T* numbers, std::size_t count) const {
  std::vector<T> none;  // rounded like the numbers
  for (const double number : missing) none.push_back(static_cast<T>(number));
  const T low = static_cast<T>(least), high = static_cast<T>(most);
  for (T *number = numbers, *const end = numbers + count; number != end; ++number) {
    *number = with_sign(*number);
    if (!(*number >= low && *number <= high) || std::ranges::find(none, *number) != none.end())
      *number = std::numeric_limits<T>::quiet_NaN();
  }
}
template void Packing::mark(float*, std::size_t) const;
template void Packing::mark(double*, std::size_t) const;

Packing packing_of(hid_t dataset, RawType type, bool netcdf, std::vector<std::string>& warnings) {
  Packing packing;
  packing.scale = one_number(dataset, "scale_factor", 1.0);
  packing.offset = one_number(dataset, "add_offset", 0.0);
  if (packing.scale == 0.0) throw LoadError("has a scale_factor of 0, so its values cannot be known; correct it");
  const std::string is_unsigned = lower(text_attribute(dataset, "_Unsigned"));
  const double numbers = std::ldexp(1.0, static_cast<int>(8 * protocol::size_of(type)));
  if (is_unsigned == "true" && (type == RawType::int8 || type == RawType::int16 || type == RawType::int32))
    packing.unsigned_by = numbers;
  if (is_unsigned == "false" && (type == RawType::uint8 || type == RawType::uint16 || type == RawType::uint32))
    packing.signed_by = numbers;
  find_missing(dataset, type, netcdf, packing, warnings);
  for (double& number : packing.missing) number = packing.with_sign(number);
  find_range(dataset, type, packing, warnings);
  if (const std::string others = unread_attributes(dataset); !others.empty())
    warnings.push_back("has attributes that are not applied: " + others + "; scale_factor, add_offset and _FillValue would be");
  return packing;
}

bool is_netcdf(hid_t file, hid_t dataset) {
  const Handle root(H5Gopen2(file, "/", H5P_DEFAULT), H5Gclose);
  return (root.is_open() && H5Aexists(root, "_NCProperties") > 0) || H5Aexists(dataset, "_Netcdf4Dimid") > 0 ||
         H5Aexists(dataset, "_Netcdf4Coordinates") > 0;
}

namespace {

enum class Angle : std::uint8_t { none, east, north, any };

/// Direction of an angle in degrees, for which CF has six spellings each.
Angle angle_of(const std::string& unit) {
  const std::string word = lower(unit);
  if (is_one_of(word, {"degrees_east", "degree_east", "degree_e", "degrees_e", "degreee", "degreese"})) return Angle::east;
  if (is_one_of(word, {"degrees_north", "degree_north", "degree_n", "degrees_n", "degreen", "degreesn"})) return Angle::north;
  return is_one_of(word, {"degrees", "degree", "deg", "°"}) ? Angle::any : Angle::none;
}

/// Axis of a scale's index, by CF's order of precedence.
char along_of(hid_t scale, const std::string& unit) {
  const std::string axis = lower(text_attribute(scale, "axis"));
  if (is_one_of(axis, {"x", "y", "z", "t"})) return axis[0];
  const std::string standard = lower(text_attribute(scale, "standard_name"));
  if (standard == "time" || lower(unit).find(" since ") != std::string::npos) return 't';
  if (standard.find("longitude") != std::string::npos || standard.find("_x_coordinate") != std::string::npos) return 'x';
  if (standard.find("latitude") != std::string::npos || standard.find("_y_coordinate") != std::string::npos) return 'y';
  const Angle angle = angle_of(unit);
  if (angle == Angle::east) return 'x';
  if (angle == Angle::north) return 'y';
  for (const char* word : {"height", "altitude", "depth", "air_pressure", "sigma", "_z_coordinate", "model_level", "hybrid"}) {
    if (standard.find(word) != std::string::npos) return 'z';
  }
  if (!text_attribute(scale, "positive").empty()) return 'z';
  return ' ';
}

/// Axis by the name of a scale or label alone.
char along_by_name(const std::string& name) {
  const std::string word = lower(name);
  if (is_one_of(word, {"x", "lon", "long", "longitude", "rlon", "west_east", "easting", "xc"})) return 'x';
  if (is_one_of(word, {"y", "lat", "latitude", "rlat", "south_north", "northing", "yc"})) return 'y';
  if (is_one_of(word, {"z", "lev", "level", "height", "altitude", "alt", "depth", "plev", "bottom_top", "zc"})) return 'z';
  if (is_one_of(word, {"t", "time", "times"})) return 't';
  return is_one_of(word, {"c", "component", "components", "vector"}) ? 'c' : ' ';
}

/// Coordinates of a scale; none, and a warning, if unusable.
std::vector<double> coordinates_in(hid_t scale, const Dimension& of, std::vector<std::string>& warnings) {
  const auto leave = [&](const std::string& why) {
    warnings.push_back("its coordinates '" + of.name + "' are not taken: " + why);
    return std::vector<double>();
  };
  Shape shape;
  if (const std::string why = shape_of(scale, shape); !why.empty()) return leave(why);
  if (shape.lengths.size() != 1 || shape.lengths[0] != of.length) return leave("they are not as many as the index has");
  if (of.length > most_planes) return leave("they are more than a million");
  std::vector<double> numbers(static_cast<std::size_t>(of.length));
  if (is_stored_short(scale) || H5Dread(scale, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()) < 0)
    return leave("they are damaged");
  const Packing packing = packing_of(scale, shape.type, false, warnings);
  packing.mark(numbers.data(), numbers.size());
  for (double& number : numbers) number = number * packing.scale + packing.offset;
  if (std::ranges::any_of(numbers, [](double n) { return !std::isfinite(n); })) return leave("some are not finite");
  return numbers;
}

std::string name_of(hid_t scale) {
  std::string path(1000, '\0');
  const ssize_t bytes = H5Iget_name(scale, path.data(), path.size());
  path.resize(bytes > 0 && static_cast<std::size_t>(bytes) < path.size() ? static_cast<std::size_t>(bytes) : 0);
  return path.substr(path.rfind('/') + 1);
}

/// True if a scale only has the length of an index.
bool is_bare(hid_t scale) { return text_attribute(scale, "NAME").starts_with("This is a netCDF dimension but not"); }

}  // namespace

std::vector<Dimension> dimensions_of(hid_t dataset, const Shape& shape, std::vector<std::string>& warnings) {
  const std::size_t rank = shape.lengths.size();
  const std::vector<Handle> scales = dimension_scales(dataset, rank);
  const std::vector<std::string> labels = texts_attribute(dataset, "DIMENSION_LABELS", rank);
  std::vector<Dimension> dimensions(rank);
  for (std::size_t n = 0; n < rank; ++n) {
    Dimension& dimension = dimensions[n];
    dimension.length = shape.lengths[n];
    if (!labels.empty()) dimension.name = labels[n];
    if (!scales[n].is_open()) {
      dimension.along = along_by_name(dimension.name);
      continue;
    }
    if (dimension.name.empty()) dimension.name = name_of(scales[n]);
    if (!is_bare(scales[n])) {
      dimension.unit = text_attribute(scales[n], "units");
      dimension.along = along_of(scales[n], dimension.unit);
    }
    if (dimension.along == ' ') dimension.along = along_by_name(dimension.name);
    if (dimension.along != 't' && dimension.along != 'c' && !is_bare(scales[n]))
      dimension.coordinates = coordinates_in(scales[n], dimension, warnings);
    if (lower(text_attribute(scales[n], "positive")) == "down" && !dimension.coordinates.empty())
      warnings.push_back("its coordinates '" + dimension.name +
                         "' count downwards, and are kept so: what is above is felt below");
  }
  if (!text_attribute(dataset, "coordinates").empty() &&
      std::ranges::all_of(dimensions, [](const Dimension& d) { return d.coordinates.empty(); }))
    warnings.emplace_back("names coordinates of several indices (its attribute 'coordinates'), which are not read");
  // If two indices claim one axis, both claims are dropped.
  for (const char along : {'x', 'y', 'z', 't', 'c'}) {
    const auto claims = [&](const Dimension& d) { return d.along == along; };
    if (std::ranges::count_if(dimensions, claims) < 2) continue;
    warnings.push_back(std::string("two of its indices claim to be along ") + along + ": their order is taken instead");
    for (Dimension& dimension : dimensions) {
      if (claims(dimension)) dimension.along = ' ';
    }
  }
  return dimensions;
}

namespace {

double step_of(const std::vector<double>& coordinates) {
  if (coordinates.size() < 2) return 0.0;
  return std::abs(coordinates.back() - coordinates.front()) / static_cast<double>(coordinates.size() - 1);
}

/// Metres per degree along x and y, at the middle latitude.
std::array<double, 2> metres_per_degree(const Dimension& y) {
  const double per_degree = earth_radius_m * std::numbers::pi / 180.0;
  if (y.coordinates.empty() || angle_of(y.unit) == Angle::none) return {per_degree, per_degree};
  const double middle = 0.5 * (y.coordinates.front() + y.coordinates.back());
  return {per_degree * std::max(0.01, std::cos(middle * std::numbers::pi / 180.0)), per_degree};
}

/// Unit of x or y if neither has a known unit; empty otherwise, or if both have none. Throws LoadError if only one has a unit.
std::string unknown_unit(const std::array<Dimension, 3>& of) {
  std::string unknown;
  bool any_known = false;
  for (std::size_t a = 0; a < 3; ++a) {
    if (of[a].coordinates.empty() || palpa::detail::leaves_length_unit_open(of[a].unit)) continue;
    const bool known = metres_per(of[a].unit) > 0.0 || (a < 2 && angle_of(of[a].unit) != Angle::none);
    any_known = any_known || known;
    if (!known && a < 2 && unknown.empty()) unknown = of[a].unit;
  }
  if (any_known && !unknown.empty())
    throw LoadError("has coordinates in '" + unknown +
                    "', which is no known unit of length, beside others; correct it, or give "
                    "spacing_m = [x, y, z]");
  return unknown;
}

}  // namespace

bool has_places(const std::array<Dimension, 3>& of) {
  return std::ranges::any_of(of, [](const Dimension& d) { return !d.coordinates.empty(); }) &&
         std::ranges::all_of(of, [](const Dimension& d) { return d.length <= most_planes; });
}

Coordinates in_one_unit(const std::array<Dimension, 3>& of, std::vector<std::string>& warnings) {
  Coordinates made;
  std::array<double, 3> metres{};  // per unit of the file; 0: none given; below: not a length
  bool mixed = false, angles = false;
  const auto per_degree = metres_per_degree(of[1]);
  const std::string unknown = unknown_unit(of);
  for (std::size_t a = 0; a < 3; ++a) {
    if (of[a].coordinates.empty()) continue;
    if (palpa::detail::leaves_length_unit_open(of[a].unit) || (!unknown.empty() && of[a].unit == unknown)) continue;
    metres[a] = metres_per(of[a].unit);
    if (a < 2 && metres[a] == 0.0 && angle_of(of[a].unit) != Angle::none) metres[a] = per_degree[a], angles = mixed = true;
    if (metres[a] == 0.0) metres[a] = -1.0;
    if (metres[a] > 0.0 && made.unit.empty()) made.unit = of[a].unit;
    mixed = mixed || (metres[a] > 0.0 && metres_per(made.unit) != metres[a]);
  }
  if (angles)
    warnings.push_back(
        "its longitudes and latitudes are taken as metres on the Earth at the middle latitude (spacing_m takes others)");
  double common = made.unit.empty() ? 0.0 : metres_per(made.unit);
  if (mixed) made.unit = "m", common = 1.0;
  double least = 0.0;
  for (std::size_t a = 0; a < 3; ++a) {
    if (of[a].coordinates.empty() || metres[a] < 0.0) continue;
    made.of[a] = of[a].coordinates;
    if (metres[a] == 0.0 && common != 0.0)
      warnings.push_back("its coordinates '" + of[a].name + "' have no unit: that of the others is taken");
    const double factor = metres[a] == 0.0 || common == 0.0 ? 1.0 : metres[a] / common;
    if (factor != 1.0) {
      for (double& number : made.of[a]) number *= factor;
    }
    if (const double step = step_of(made.of[a]); step > 0.0) least = least == 0.0 ? step : std::min(least, step);
  }
  if (!unknown.empty()) made.unit = unknown;
  if (least == 0.0) least = 1.0;
  for (std::size_t a = 0; a < 3; ++a) {
    if (!made.of[a].empty()) continue;
    for (std::int64_t n = 0; n < of[a].length; ++n) made.of[a].push_back(least * static_cast<double>(n));
    if (of[a].length == 1) continue;
    const std::string axis(1, static_cast<char>('x' + a));
    warnings.push_back((of[a].coordinates.empty()
                            ? "has no coordinates along " + axis
                            : "its coordinates '" + of[a].name + "' are in '" + of[a].unit + "', which is no length") +
                       ": steps as of the finest other axis are taken (spacing_m = [x, y, z] takes others)");
  }
  return made;
}

}  // namespace palpa::reader
