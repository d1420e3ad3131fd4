// HDF5: one array by its path, and images in the form of VTKHDF. The library must not follow links to other files or load
// filters from plug-ins.
#include <hdf5.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include "library_words.h"
#include "source.h"
#include "vtk_data.h"

namespace palpa::reader {
namespace {

constexpr std::size_t max_listed = 200;  // arrays in a message. More: long lines; fewer: the wanted path may be missing

/// An identifier of the library, closed with its owner.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Handle& operator=(Handle&&) = delete;
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const noexcept { return id_; }
  bool is_open() const noexcept { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// The type of numbers in memory for an HDF5 type; false where it cannot be read.
bool find_raw_type(hid_t type, RawType& raw) {
  const std::size_t bytes = H5Tget_size(type);
  if (H5Tget_class(type) == H5T_FLOAT) {
    raw = bytes <= 4 ? RawType::float32 : RawType::float64;
    return bytes == 2 || bytes == 4 || bytes == 8;
  }
  if (H5Tget_class(type) != H5T_INTEGER) return false;
  const bool with_sign = H5Tget_sign(type) == H5T_SGN_2;
  switch (bytes) {
    case 1: return raw = with_sign ? RawType::int8 : RawType::uint8, true;
    case 2: return raw = with_sign ? RawType::int16 : RawType::uint16, true;
    case 4: return raw = with_sign ? RawType::int32 : RawType::uint32, true;
    case 8: return raw = with_sign ? RawType::int64 : RawType::uint64, true;
    default: return false;
  }
}

hid_t memory_type(RawType type) {
  switch (type) {
    case RawType::int8: return H5T_NATIVE_INT8;
    case RawType::uint8: return H5T_NATIVE_UINT8;
    case RawType::int16: return H5T_NATIVE_INT16;
    case RawType::uint16: return H5T_NATIVE_UINT16;
    case RawType::int32: return H5T_NATIVE_INT32;
    case RawType::uint32: return H5T_NATIVE_UINT32;
    case RawType::int64: return H5T_NATIVE_INT64;
    case RawType::uint64: return H5T_NATIVE_UINT64;
    case RawType::float32: return H5T_NATIVE_FLOAT;
    case RawType::float64: return H5T_NATIVE_DOUBLE;
  }
  return H5I_INVALID_HID;
}

/// The lengths of an array's indices, slowest first.
struct Shape {
  std::vector<std::int64_t> lengths;
  RawType type = RawType::float32;
};

/// Why this data set is not an array of numbers that can be read from this file alone; empty if it is, and `shape` is filled.
std::string shape_of(hid_t dataset, Shape& shape) {
  const Handle space(H5Dget_space(dataset), H5Sclose), type(H5Dget_type(dataset), H5Tclose);
  if (!space.is_open() || !type.is_open() || !find_raw_type(type, shape.type)) return "it holds no numbers of 8 to 64 bits";
  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank < 1 || rank > 8) return "it is no array";
  std::vector<hsize_t> lengths(static_cast<std::size_t>(rank));
  H5Sget_simple_extent_dims(space, lengths.data(), nullptr);
  for (const hsize_t n : lengths) {
    if (n < 1 || n > static_cast<hsize_t>(INT64_MAX)) return "it is empty";
    shape.lengths.push_back(static_cast<std::int64_t>(n));
  }
  const Handle creation(H5Dget_create_plist(dataset), H5Pclose);
  if (H5Pget_layout(creation) == H5D_VIRTUAL || H5Pget_external_count(creation) > 0)
    return "its numbers lie in other files, which are not followed";
  for (int f = 0; f < H5Pget_nfilters(creation); ++f) {
    unsigned int flags = 0, settings = 0;
    std::size_t values = 0;
    const H5Z_filter_t filter =
        H5Pget_filter2(creation, static_cast<unsigned int>(f), &flags, &values, nullptr, 0, nullptr, &settings);
    if (filter < 0 || H5Zfilter_avail(filter) <= 0)
      return "it is packed with filter " + std::to_string(filter) +
             ", which needs a plug-in; repack it with gzip (h5repack -f GZIP=5)";
  }
  return {};
}

/// Whether less is stored than the numbers take, and no filter that could have made it smaller: HDF5 would read on behind it,
/// in memory that holds anything.
bool is_stored_short(hid_t dataset) {
  const Handle creation(H5Dget_create_plist(dataset), H5Pclose), type(H5Dget_type(dataset), H5Tclose),
      space(H5Dget_space(dataset), H5Sclose);
  const auto bytes_of = [&, size = static_cast<double>(H5Tget_size(type))](const std::vector<hsize_t>& lengths) {
    return std::accumulate(lengths.begin(), lengths.end(), size,
                           [](double a, hsize_t n) { return a * static_cast<double>(n); });
  };
  const auto rank = static_cast<std::size_t>(H5Sget_simple_extent_ndims(space));
  std::vector<hsize_t> lengths(rank), chunk(rank), first(rank, 0);
  H5Sget_simple_extent_dims(space, lengths.data(), nullptr);
  const H5D_layout_t layout = H5Pget_layout(creation);
  if (layout != H5D_CHUNKED) {
    const hsize_t stored = H5Dget_storage_size(dataset);  // 0: nothing has been written
    return (layout == H5D_COMPACT || stored != 0) && static_cast<double>(stored) < bytes_of(lengths);
  }
  const int filters = H5Pget_nfilters(creation);
  if (filters <= 0) return false;
  unsigned int packing = 0;  // a bit for each filter that may make a chunk smaller; a chunk has one set where it is left out
  for (int f = 0; f < filters; ++f) {
    unsigned int flags = 0, settings = 0;
    std::size_t values = 0;
    const H5Z_filter_t filter =
        H5Pget_filter2(creation, static_cast<unsigned int>(f), &flags, &values, nullptr, 0, nullptr, &settings);
    if (filter != H5Z_FILTER_SHUFFLE && filter != H5Z_FILTER_FLETCHER32) packing |= 1U << f;
  }
  if (H5Pget_chunk(creation, static_cast<int>(rank), chunk.data()) != static_cast<int>(rank)) return true;
  const double needed = bytes_of(chunk);
  for (std::size_t a = 0; a < rank;) {
    unsigned int left_out = 0;
    haddr_t address = HADDR_UNDEF;
    hsize_t bytes = 0;
    if (H5Dget_chunk_info_by_coord(dataset, first.data(), &left_out, &address, &bytes) < 0) return true;
    if (address != HADDR_UNDEF && (packing & ~left_out) == 0 && static_cast<double>(bytes) < needed) return true;
    for (a = 0; a < rank && (first[a] += chunk[a]) >= lengths[a]; ++a) first[a] = 0;
  }
  return false;
}

/// Paths and shapes of the arrays of three or four indices.
std::vector<std::string> arrays_in(hid_t file) {
  std::vector<std::string> found;
  const auto visit = [](hid_t at, const char* name, const H5O_info_t* info, void* to) -> herr_t {
    auto& list = *static_cast<std::vector<std::string>*>(to);
    if (info->type != H5O_TYPE_DATASET) return 0;
    const Handle dataset(H5Dopen2(at, name, H5P_DEFAULT), H5Dclose);
    Shape shape;
    if (dataset.is_open() && shape_of(dataset, shape).empty() && shape.lengths.size() >= 3 && shape.lengths.size() <= 4)
      list.push_back(std::string("/") + name);
    return list.size() >= max_listed ? 1 : 0;
  };
  H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_INC, visit, &found, H5O_INFO_BASIC);
  return found;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t n = 0; n < std::min<std::size_t>(names.size(), 10); ++n) text += (n == 0 ? "" : ", ") + names[n];
  return names.size() > 10 ? text + " and " + std::to_string(names.size() - 10) + " more" : text;
}

/// The text of a string attribute of an object; empty if it has none.
std::string text_attribute(hid_t object, const char* name) {
  if (H5Aexists(object, name) <= 0) return {};
  const Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose), type(H5Aget_type(attribute), H5Tclose);
  if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0) return {};
  const std::size_t bytes = H5Tget_size(type);
  const Handle space(H5Aget_space(attribute), H5Sclose);
  if (bytes > 1000 || H5Sget_simple_extent_npoints(space) != 1) return {};
  std::string text(bytes, '\0');
  if (H5Aread(attribute, type, text.data()) < 0) return {};
  return text.substr(0, text.find('\0'));
}

/// Reads `count` numbers of an attribute; false if it does not have that many.
bool numbers_attribute(hid_t object, const char* name, double* to, hssize_t count) {
  if (H5Aexists(object, name) <= 0) return false;
  const Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose), space(H5Aget_space(attribute), H5Sclose);
  return H5Sget_simple_extent_npoints(space) == count && H5Aread(attribute, H5T_NATIVE_DOUBLE, to) >= 0;
}

class Hdf5Source final : public Source {
 public:
  explicit Hdf5Source(const protocol::Request& request) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    H5PLset_loading_state(0);
    H5Lunregister(H5L_TYPE_EXTERNAL);
    file_ = H5Fopen(request.path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file_ < 0) throw LoadError("cannot be read as HDF5; check that the file is whole");
    header.default_unit = "m";
    header.named = true;
    takes.inside = true, takes.layout = true, takes.index_axes = true;
    along_index_ = request.components_along == "index";
    files.push_back(request.path);
    choose_frames(request, 1);
    if (request.inside.empty() && H5Lexists(file_, "VTKHDF", H5P_DEFAULT) > 0) {
      open_image();
    } else {
      open_array(request);
    }
    for (const auto& field : header.fields) header.working_bytes += 2 * protocol::voxel_bytes(field).value_or(0);
  }
  ~Hdf5Source() override { H5Fclose(file_); }

  void read(const std::vector<std::uint32_t>& wanted, const std::vector<std::byte*>& to) override {
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const Array& array = arrays_[wanted[i]];
      const protocol::FieldHeader& field = header.fields[wanted[i]];
      const Handle dataset(H5Dopen2(file_, array.path.c_str(), H5P_DEFAULT), H5Dclose);
      const bool direct = kept_as_they_are(array.raw, array.turn, field);
      std::size_t count = static_cast<std::size_t>(array.raw.components);
      for (const std::int64_t n : array.raw.dims) count *= static_cast<std::size_t>(n);
      std::vector<std::byte> room(direct ? 0 : count * size_of(array.raw.type));
      if (is_stored_short(dataset) ||
          H5Dread(dataset, memory_type(array.raw.type), H5S_ALL, H5S_ALL, H5P_DEFAULT, direct ? to[i] : room.data()) < 0)
        throw LoadError("array '" + array.path + "' cannot be read; it is damaged, or the file is not whole");
      if (!direct) copy_voxels(room.data(), array.raw, array.turn, field, to[i]);
    }
  }

 private:
  struct Array {
    std::string path;
    RawVoxels raw;
    Turn turn;
  };

  /// Adds a field for an array.
  void add(const std::string& path, const std::string& name, const RawVoxels& raw, const GridGeometry& grid) {
    protocol::FieldHeader field;
    field.name = name;
    field.grid = grid;
    Turn turn;
    if (along_index_) turn.axes = protocol::unit_axes(grid);
    keep(raw, turn, field, header.warnings);
    const Handle dataset(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose);
    for (const char* key : {"units", "unit"}) {
      if (field.unit.empty()) field.unit = text_attribute(dataset, key);
    }
    header.fields.push_back(field);
    arrays_.push_back({path, raw, turn});
  }

  void open_array(const protocol::Request& request) {
    header.format = "hdf5";
    std::string path = request.inside;
    if (path.empty()) {
      const std::vector<std::string> found = arrays_in(file_);
      if (found.empty()) throw LoadError("has no array of three or four indices; give a file with a volume");
      if (found.size() > 1) {
        throw LoadError("holds several arrays (" + joined(found) +
                        "); name one: " + request.path.substr(request.path.rfind('/') + 1) + ":" + found.front());
      }
      path = found.front();
    }
    const Handle dataset(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose);
    if (!dataset.is_open()) throw LoadError("has no array '" + path + "' of its own; it has " + joined(arrays_in(file_)));
    Shape shape;
    if (const std::string why = shape_of(dataset, shape); !why.empty())
      throw LoadError("array '" + path + "' cannot be felt: " + why + "; give one that holds a volume");

    try {
      add(path, path.substr(path.rfind('/') + 1), arranged(shape.type, shape.lengths, request.layout),
          placed_by(request.layout, header));
    } catch (const LoadError& error) {
      throw LoadError("array '" + path + "' " + error.what());
    }
  }

  void open_image() {
    header.format = "vtkhdf";
    const Handle root(H5Gopen2(file_, "VTKHDF", H5P_DEFAULT), H5Gclose);
    if (!root.is_open()) throw LoadError("is VTKHDF without its group; check that the file is whole");
    const std::string kind = text_attribute(root, "Type");
    if (kind != "ImageData") {
      throw LoadError("is VTKHDF of " + (kind.empty() ? std::string("no type") : known_words(kind)) +
                      "; ImageData can be read, other grids as .vtu or .vts");
    }
    double whole[6], origin[3] = {0, 0, 0}, spacing[3] = {1, 1, 1}, direction[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    if (!numbers_attribute(root, "WholeExtent", whole, 6)) throw LoadError("has no WholeExtent; export it again");
    numbers_attribute(root, "Origin", origin, 3);
    numbers_attribute(root, "Spacing", spacing, 3);
    numbers_attribute(root, "Direction", direction, 9);
    int extent[6];
    for (int n = 0; n < 6; ++n) {
      if (!(std::abs(whole[n]) < 2e9)) throw LoadError("has an extent that cannot be; export it again");
      extent[n] = static_cast<int>(whole[n]);
    }
    const PointsAndCells grids = grids_of(extent, origin, spacing, direction);
    std::set<std::string> names;
    for (const bool of_cells : {false, true}) {
      const std::string group = of_cells ? "/VTKHDF/CellData" : "/VTKHDF/PointData";
      for (const std::string& path : arrays_in(file_)) {
        if (path.compare(0, group.size() + 1, group + "/") != 0) continue;
        std::string name = path.substr(group.size() + 1);
        const Handle dataset(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose);
        Shape shape;
        if (!shape_of(dataset, shape).empty()) continue;
        const GridGeometry& grid = of_cells ? grids.cells : grids.points;
        const bool vector = shape.lengths.size() == 4;
        const bool fits = shape.lengths[0] == grid.dims[2] && shape.lengths[1] == grid.dims[1] &&
                          shape.lengths[2] == grid.dims[0] && (!vector || shape.lengths[3] == 3);
        if (!fits) {
          header.warnings.push_back("array '" + name +
                                    "' is left out: its shape is not that of the grid, with 1 or 3 components");
          continue;
        }
        if (!names.insert(name).second) name += "_cells";
        ArrayLayout layout;
        if (vector) layout.components = "last";
        add(path, name, arranged(shape.type, shape.lengths, layout), grid);
      }
    }
    if (header.fields.empty())
      throw LoadError("has no array that can be felt; one number per point, or a vector of three, is needed");
  }

  hid_t file_ = H5I_INVALID_HID;
  bool along_index_ = false;   ///< vectors are along the axes of the grid
  std::vector<Array> arrays_;  ///< one for each field
};

}  // namespace

std::unique_ptr<Source> open_hdf5(const protocol::Request& request) { return std::make_unique<Hdf5Source>(request); }

}  // namespace palpa::reader
