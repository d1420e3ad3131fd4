#include "arrays.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>

#include "palpa/base/wording.h"
#include "palpa/data/parallel.h"
#include "palpa/data/samples.h"
#include "palpa/data/unread_grid.h"
#include "parameters.h"

namespace palpa::python {
namespace {

/// Voxel type equal to an array's, without a copy.
std::optional<VoxelType> voxel_type_of(const py::dtype& type) {
  if (!type.attr("isnative").cast<bool>()) return {};
  switch (type.kind()) {
    case 'u':
      if (type.itemsize() == 1) return VoxelType::uint8;
      if (type.itemsize() == 2) return VoxelType::uint16;
      return {};
    case 'i':
      if (type.itemsize() == 2) return VoxelType::int16;
      if (type.itemsize() == 4) return VoxelType::int32;
      return {};
    case 'f':
      if (type.itemsize() == 4) return VoxelType::float32;
      if (type.itemsize() == 8) return VoxelType::float64;
      return {};
    default: return {};
  }
}

/// Smallest voxel type that holds all values of an array type; none if there is none.
const char* type_that_holds(const py::dtype& type) {
  const auto bytes = type.itemsize();
  switch (type.kind()) {
    case 'b': return "uint8";
    case 'u': return bytes == 1 ? "uint8" : bytes == 2 ? "uint16" : "float64";
    case 'i': return bytes <= 2 ? "int16" : bytes == 4 ? "int32" : "float64";
    case 'f': return bytes <= 4 ? "float32" : "float64";
    default: return nullptr;
  }
}

std::string name_of(const py::dtype& type) { return type.attr("__str__")().cast<std::string>(); }

/// Memory layout of the axes x, y, z of an array.
struct Layout {
  std::array<int, 3> axis{};       ///< x, y or z of the grid's i, j, k
  std::array<bool, 3> reversed{};  ///< of i, j, k: the array's index increases against memory
};

/// None if voxels are not contiguous.
std::optional<Layout> layout_of(const py::array& array) {
  const bool is_vector = array.ndim() == 4;
  py::ssize_t next = array.itemsize();
  if (is_vector) {
    if (array.strides(3) != next) return {};
    next *= 3;
  }
  // Axis a of x, y, z is index 2 − a of the array. An axis of one voxel may have any stride: it goes last.
  const auto length = [&](int a) { return array.shape(2 - a); };
  const auto stride = [&](int a) { return array.strides(2 - a); };
  Layout layout{.axis = {0, 1, 2}};
  std::stable_sort(layout.axis.begin(), layout.axis.end(), [&](int a, int b) {
    const auto key = [&](int c) { return length(c) == 1 ? std::numeric_limits<py::ssize_t>::max() : std::abs(stride(c)); };
    return key(a) < key(b);
  });
  for (int n = 0; n < 3; ++n) {
    const int a = layout.axis[static_cast<std::size_t>(n)];
    if (length(a) == 1) continue;
    if (std::abs(stride(a)) != next) return {};
    layout.reversed[static_cast<std::size_t>(n)] = stride(a) < 0;
    next *= length(a);
  }
  return layout;
}

/// Makes this array and its bases read-only, because a grid reads its range only once.
void make_read_only(py::object array) {
  while (py::isinstance<py::array>(array)) {
    array.attr("flags").attr("writeable") = false;
    array = array.attr("base");
  }
}

void check_shape(const py::array& array) {
  const auto refuse = [&](const char* why) {
    throw py::value_error("an array of shape " + py::str(array.attr("shape")).cast<std::string>() + " " + why);
  };
  if (array.ndim() != 3 && array.ndim() != 4)
    refuse("is no volume; it has three axes, [z, y, x], and a fourth of 3 for vectors");
  if (array.ndim() == 4 && array.shape(3) != 3) refuse("has vectors that are not of 3 components; the last axis is theirs");
  if (array.size() == 0) refuse("has no voxels; a volume has at least one along each axis");
}

/// Contiguous copy of the values in a voxel type.
py::array copied(const py::array& array) {
  const char* const type = type_that_holds(array.dtype());
  if (!type) throw py::type_error("an array of " + name_of(array.dtype()) + " holds no voxels; use whole numbers or floats");
  const py::array copy = array.attr("astype")(type, py::arg("order") = "C", py::arg("copy") = true);
  const bool rounds = array.dtype().kind() != 'f' && copy.dtype().kind() == 'f';
  if (rounds && !copy.attr("astype")(array.dtype()).attr("__eq__")(array).attr("all")().cast<bool>())
    throw py::value_error("whole numbers beyond 2^53 are no voxels; scale the array to smaller ones");
  return copy;
}

/// The array itself, or, if allowed and needed, a copy.
py::array readable(const py::array& array, bool copy) {
  const auto type = voxel_type_of(array.dtype());
  if (type && layout_of(array)) return copy ? copied(array) : array;
  if (copy) return copied(array);
  if (!type && type_that_holds(array.dtype()) == nullptr) return copied(array);  // raises
  throw py::value_error(
      type ? std::string("the voxels of the array are not close to one another, so that they cannot be read where they are; ") +
                 "copy=True reads a copy"
           : "an array of " + name_of(array.dtype()) + " cannot be read where it is; copy=True reads a copy as " +
                 type_that_holds(array.dtype()));
}

GridGeometry geometry_of(const py::array& array, const Layout& layout, const PlacedArray& placed) {
  std::array<std::int64_t, 3> dims{};  // along x, y, z of the array
  for (int a = 0; a < 3; ++a) dims[static_cast<std::size_t>(a)] = array.shape(2 - a);
  if (placed.planes_m) {
    if ((array.flags() & py::array::c_style) == 0)
      throw py::value_error("an array on planes at uneven distances is in C's order; numpy.ascontiguousarray makes one");
    GridGeometry geometry = rectilinear_geometry(*placed.planes_m);
    if (geometry.dims != dims) throw py::value_error("the planes of the array are not one for each of its voxels");
    return geometry;
  }
  const Mat3 steps = transposed(placed.steps_m);  // one row per axis of the array
  Vec3 first_m;
  if (placed.origin_m) {
    first_m = *placed.origin_m;
  } else {
    for (std::size_t a = 0; a < 3; ++a) first_m -= 0.5 * static_cast<double>(dims[a] - 1) * steps.row[a];
  }
  GridGeometry geometry;
  Mat3 columns{};
  for (std::size_t n = 0; n < 3; ++n) {
    const auto a = static_cast<std::size_t>(layout.axis[n]);
    geometry.dims[n] = dims[a];
    columns.row[n] = layout.reversed[n] ? -steps.row[a] : steps.row[a];
    if (layout.reversed[n]) first_m += static_cast<double>(dims[a] - 1) * steps.row[a];
  }
  geometry.index_to_world_m = transposed(columns);
  geometry.origin_m = first_m;
  return geometry;
}

const char* first_voxel_of(const py::array& array, const Layout& layout) {
  const auto* data = static_cast<const char*>(array.data());
  for (std::size_t n = 0; n < 3; ++n) {
    const int index = 2 - layout.axis[n];
    if (layout.reversed[n]) data += (array.shape(index) - 1) * array.strides(index);
  }
  return data;
}

}  // namespace

std::shared_ptr<const void> kept(py::object object, const void* data) {
  PyObject* const owner = object.release().ptr();
  return {data, [owner](const void*) {
            if (!Py_IsInitialized()) return;  // the interpreter's end has freed it
            const py::gil_scoped_acquire acquire;
            Py_DECREF(owner);
          }};
}

Volume array_volume(const py::object& object, const PlacedArray& placed, const std::string& unit, bool copy) {
  if (!py::isinstance<py::array>(object)) {
    throw py::type_error("voxels are an array of numpy, not " + object.get_type().attr("__name__").cast<std::string>() +
                         "; numpy.asarray makes one");
  }
  const py::array given = object.cast<py::array>();
  check_shape(given);
  const py::array array = readable(given, copy);
  const Layout layout = *layout_of(array);
  const GridGeometry geometry = geometry_of(array, layout, placed);
  make_read_only(array);
  Voxels voxels{.type = *voxel_type_of(array.dtype()),
                .components = array.ndim() == 4 ? 3 : 1,
                .data = kept(array, first_voxel_of(array, layout))};
  Volume volume;
  volume.format = "grid";
  volume.fields.push_back({.name = "data", .unit = unit, .field = unread_grid_field(geometry, std::move(voxels))});
  return volume;
}

py::array raw_voxels_of(const FieldPtr& field) {
  const GridView* const grid = grid_behind(*field);
  static constexpr const char* types[] = {"uint8", "int16", "uint16", "int32", "float32", "float64"};
  const auto& dims = grid->geometry.dims;
  std::vector<py::ssize_t> shape{dims[2], dims[1], dims[0]};
  if (grid->voxels.components == 3) shape.push_back(3);
  const py::capsule owner(new FieldPtr(field), [](void* held) { delete static_cast<FieldPtr*>(held); });
  py::array array(py::dtype(types[static_cast<std::size_t>(grid->voxels.type)]), shape, grid->voxels.data.get(), owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}

py::object voxels_of(const FieldPtr& field) {
  const GridView* const grid = grid_behind(*field);
  if (!grid) return py::none();
  const py::array array = raw_voxels_of(field);
  if (grid->scale == 1.0 && grid->offset == 0.0) return array;
  return array.attr("__mul__")(py::float_(grid->scale)).attr("__add__")(py::float_(grid->offset));
}

py::array_t<double> matrix_of(const Mat3& linear, const Vec3& origin_m) {
  py::array_t<double> matrix({4, 4});
  auto at = matrix.mutable_unchecked<2>();
  for (int r = 0; r < 3; ++r) {
    const Vec3& row = linear.row[r];
    at(r, 0) = row.x, at(r, 1) = row.y, at(r, 2) = row.z;
  }
  at(0, 3) = origin_m.x, at(1, 3) = origin_m.y, at(2, 3) = origin_m.z;
  at(3, 0) = at(3, 1) = at(3, 2) = 0.0, at(3, 3) = 1.0;
  return matrix;
}
py::array_t<double> matrix_of(const Similarity& map) { return matrix_of(map.scale * map.rotation, map.translation_m); }

py::object affine_of(const Field& field) {
  const GridView* const grid = grid_behind(field);
  if (!grid || grid->geometry.is_rectilinear()) return py::none();
  return matrix_of(grid->geometry.index_to_world_m, grid->geometry.origin_m);
}

namespace {

/// Positions in memory as doubles, and the shape without its last axis.
struct Places {
  Numbers points_m;
  std::vector<py::ssize_t> shape;
  std::int64_t count = 1;
};

Places places_of(const py::object& points_m) {
  const auto points = numbers_of(points_m);
  if (!points) throw py::type_error("'points_m' takes an array of numbers of shape (…, 3)");
  if (points->ndim() == 0 || points->shape(points->ndim() - 1) != 3) {
    throw py::value_error("'points_m' has the shape " + py::str(points->attr("shape")).cast<std::string>() +
                          "; its last axis is of 3: x, y, z");
  }
  Places places{*points, {}, 1};
  for (py::ssize_t a = 0; a + 1 < places.points_m.ndim(); ++a) {
    places.shape.push_back(places.points_m.shape(a));
    places.count *= places.points_m.shape(a);
  }
  return places;
}

py::array_t<double> results(const Places& places, std::initializer_list<py::ssize_t> of_each) {
  std::vector<py::ssize_t> shape = places.shape;
  shape.insert(shape.end(), of_each);
  return py::array_t<double>(shape);
}

constexpr double none = std::numeric_limits<double>::quiet_NaN();  // outside of the field's data

/// Calls `act(first, last)` for parts of all positions on all cores, without the interpreter's lock; checks signals regularly.
template <class Act>
void for_all(const Places& places, const Act& act) {
  constexpr std::int64_t block = 1 << 20,
                         least = 4096;  // [1] positions. More: Ctrl-C takes effect later; fewer: more threads are started
  const py::gil_scoped_release release;
  for (std::int64_t begin = 0; begin < places.count; begin += block) {
    detail::in_parts(std::min(block, places.count - begin), least,
                     [&](std::int64_t first, std::int64_t last) { act(begin + first, begin + last); });
    const py::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  }
}

}  // namespace

py::tuple sample(const Field& field, const py::object& points_m) {
  const Places places = places_of(points_m);
  const double* const points = places.points_m.data();
  if (field.components() == 1) {
    py::array_t<double> values = results(places, {}), gradients = results(places, {3});
    double* const value = values.mutable_data();
    double* const gradient = gradients.mutable_data();
    for_all(places, [&](std::int64_t first, std::int64_t last) {
      detail::sample_scalars(field, points + 3 * first, last - first, value + first, gradient + 3 * first);
    });
    return py::make_tuple(std::move(values), std::move(gradients));
  }
  py::array_t<double> values = results(places, {3}), jacobians = results(places, {3, 3});
  double* const value = values.mutable_data();
  double* const jacobian = jacobians.mutable_data();
  for_all(places, [&](std::int64_t first, std::int64_t last) {
    const Vec3 nowhere{none, none, none};
    for (std::int64_t n = first; n < last; ++n) {
      const VectorSample s = field.vector({points[3 * n], points[3 * n + 1], points[3 * n + 2]});
      put(value + 3 * n, s.inside ? s.value : nowhere);
      double* to = jacobian + 9 * n;
      for (const Vec3& row : s.jacobian.row) to = put(to, s.inside ? row : nowhere);
    }
  });
  return py::make_tuple(std::move(values), std::move(jacobians));
}

}  // namespace palpa::python
