// HDF5 and netCDF-4 arrays, and VTKHDF images. The library must not follow links to other files or load plug-in filters.
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <stdexcept>

#include "cf.h"
#include "hdf5_objects.h"
#include "library_words.h"
#include "palpa/base/input_file.h"
#include "source.h"
#include "vtk_data.h"

namespace palpa::reader {
namespace {

std::string joined(const std::vector<FoundArray>& arrays) {
  std::string text;
  for (std::size_t n = 0; n < std::min<std::size_t>(arrays.size(), 10); ++n) text += (n == 0 ? "" : ", ") + arrays[n].path;
  return arrays.size() > 10 ? text + " and " + std::to_string(arrays.size() - 10) + " more" : text;
}

/// Indices of an array, assigned to axes.
struct Arranged {
  std::vector<std::int64_t> lengths;  ///< of the kept indices, slowest first
  ArrayLayout layout;                 ///< as `protocol::arranged` expects them
  std::array<Dimension, 3> space;     ///< dimensions along x, y and z
  std::size_t time = SIZE_MAX;        ///< index that counts frames; SIZE_MAX: none
};

/// Applies the requested axes to the indices, if time is among them.
void take_axes(const std::string& axes, std::vector<Dimension>& dimensions) {
  if (axes.find('t') == std::string::npos) return;
  if (axes.size() + 1 < dimensions.size() || axes.size() > dimensions.size())
    throw LoadError("has " + std::to_string(dimensions.size()) + " indices, where axes = \"" + axes + "\" names " +
                    std::to_string(axes.size()) + "; name each but that of vector components");
  const bool components_first =
      axes.size() < dimensions.size() && dimensions.front().length == 3 && dimensions.back().length != 3;
  if (axes.size() < dimensions.size()) (components_first ? dimensions.front() : dimensions.back()).along = 'c';
  for (std::size_t n = 0; n < axes.size(); ++n) dimensions[n + (components_first ? 1 : 0)].along = axes[n];
}

/// Requested spatial axes, without time; empty: none. Throws LoadError.
std::string axes_of_space(const ArrayLayout& layout) {
  ArrayLayout space;
  space.axes = layout.axes;
  if (const std::size_t t = space.axes.find('t'); t != std::string::npos) space.axes.erase(t, 1);
  return layout.axes.empty() ? std::string() : protocol::axes_of(space);
}

/// Index of the vector components: by the file or the request, or the only index of length 3 at either end; SIZE_MAX: none.
/// \param kept  indices other than time
/// \param is_component  the array is one of three that form a vector
std::size_t components_among(const std::vector<Dimension>& kept, const ArrayLayout& layout, bool is_component) {
  for (std::size_t n = 0; n < kept.size(); ++n) {
    if (kept[n].along == 'c' && kept[n].length == 3) return n;
  }
  if (kept.size() < 4) return SIZE_MAX;
  if (layout.components == "first") return 0;
  if (layout.components == "last") return kept.size() - 1;
  const auto may_be = [&](const Dimension& d) { return d.along == ' ' && d.length == 3 && !is_component; };
  const bool first = may_be(kept.front()), last = may_be(kept.back());
  return first == last ? SIZE_MAX : first ? 0 : kept.size() - 1;
}

/// Assigns x, y and z to the spatial indices: as in `said`, then z, y, x in order to the others.
void name_axes(std::vector<Dimension>& space, const std::string& said) {
  std::string left = "zyx";
  if (said.size() == space.size()) {
    for (std::size_t n = 0; n < space.size(); ++n) space[n].along = said[n];
  }
  for (const Dimension& dimension : space) std::erase(left, dimension.along);
  if (space.size() == 2 && left.size() == 3) left = "yx";
  for (Dimension& dimension : space) {
    if (dimension.along == ' ') dimension.along = left.front(), left.erase(0, 1);
  }
}

/// Removes indices of length 1 without a spatial axis, until at most `most` are left. Returns the new index of the components.
std::size_t leave_out_single(std::vector<Dimension>& kept, std::size_t most, std::size_t components) {
  for (std::size_t n = 0; n < kept.size() && kept.size() > most;) {
    if (n == components || kept[n].length != 1 || kept[n].along != ' ') {
      ++n;
      continue;
    }
    kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(n));
    if (components != SIZE_MAX && components > n) --components;
  }
  return components;
}

/// Assigns an array's indices to axes. Throws LoadError if they form no volume.
Arranged arrangement_of(std::vector<Dimension> dimensions, const ArrayLayout& layout, bool is_component) {
  const std::string said = axes_of_space(layout);
  take_axes(layout.axes, dimensions);
  Arranged made;
  made.layout = layout;
  made.layout.components.clear(), made.layout.axes.clear();
  std::vector<Dimension> kept;
  for (std::size_t n = 0; n < dimensions.size(); ++n) {
    const Dimension& dimension = dimensions[n];
    if (dimension.along == 't' && dimension.length > 1) made.time = n;
    if (dimension.along != 't' && !(dimension.along == 'c' && dimension.length == 1)) kept.push_back(dimension);
    if (dimension.along == 'c' && dimension.length != 1 && dimension.length != 3)
      throw LoadError("has " + std::to_string(dimension.length) + " components; a vector has 3");
  }
  leave_out_single(kept, 4, SIZE_MAX);
  std::size_t components = components_among(kept, layout, is_component);
  components = leave_out_single(kept, components == SIZE_MAX ? 3 : 4, components);
  std::vector<Dimension> space = kept;
  if (components != SIZE_MAX) {
    space.erase(space.begin() + static_cast<std::ptrdiff_t>(components));
    if (kept[components].length != 3)
      throw LoadError("has " + std::to_string(kept[components].length) + " components; a vector has 3");
    if (components != 0 && components + 1 != kept.size())
      throw LoadError("has its components between its other indices; write them first or last");
    made.layout.components = components == 0 ? "first" : "last";
  }
  if (space.size() > 3) {
    throw LoadError("has " + std::to_string(space.size()) +
                    " indices of more than one value, and which is that of time or of the components is not clear; say "
                    "axes = \"tzyx\" (t: time), or components = \"first\" or \"last\" of a vector of 3");
  }
  if (space.size() < 2 || dimensions.size() < 3)
    throw LoadError("has " + std::to_string(space.size()) + " indices in space; a volume has 3");
  name_axes(space, said);
  if (space.size() == 2) {  // a slice
    std::string left = "zyx";
    for (const Dimension& dimension : space) std::erase(left, dimension.along);
    Dimension across;
    across.along = left.front();
    space.insert(space.begin(), across);
  }
  for (const Dimension& dimension : space) {
    made.layout.axes += dimension.along;
    made.space[static_cast<std::size_t>(dimension.along - 'x')] = dimension;
    made.lengths.push_back(dimension.length);
  }
  if (components != SIZE_MAX) made.lengths.insert(components == 0 ? made.lengths.begin() : made.lengths.end(), 3);
  return made;
}

/// True if an array has the name of a vector component: u, Vy, velocity_z.
bool is_named_as_component(const std::string& path) {
  std::string name = path.substr(path.rfind('/') + 1);
  for (char& c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  const bool ends = !name.empty() && std::string_view("uvwxyz").find(name.back()) != std::string_view::npos;
  return ends && (name.size() == 1 || name.size() == 2 || name[name.size() - 2] == '_');
}

/// Refuses arrays of programs that store voxel sizes and value scales elsewhere in the file. Throws LoadError.
void check_program(const std::string& path, const ArrayLayout& layout) {
  if (path.starts_with("/minc-2.0/"))
    throw LoadError("is MINC, whose numbers are scaled slice by slice, which is not read; convert it (mnc2nii IN.mnc OUT.nii)");
  const bool of_itk = path.starts_with("/ITKImage/"), of_imaris = path.starts_with("/DataSet/ResolutionLevel");
  if ((of_itk || of_imaris) && layout.spacing_m == Vec3{})
    throw LoadError(std::string("is of ") +
                    (of_itk ? "ITK, whose Spacing, Origin and Directions are" : "Imaris, whose ExtMin and ExtMax are") +
                    " not read; save it as NRRD, or give spacing_m = [x, y, z] in metres");
}

/// Opens a file, or a copy of its decompressed content: the library resolves the names of memory files to nonexistent paths.
hid_t opened(const protocol::Request& request) {
  if (request.packed.empty()) return H5Fopen(request.path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const detail::InputFile file(request.path);
  std::vector<std::byte> bytes(file.bytes());
  bytes.resize(file.read(0, bytes.data(), bytes.size()));
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  constexpr std::size_t growth_bytes = 1 << 16;
  H5Pset_fapl_core(access, growth_bytes, 0);
  H5Pset_file_image(access, bytes.data(), bytes.size());
  return H5Fopen("unpacked", H5F_ACC_RDONLY, access);
}

class Hdf5Source final : public Source {
 public:
  explicit Hdf5Source(const protocol::Request& request) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    H5PLset_loading_state(0);
    H5Lunregister(H5L_TYPE_EXTERNAL);
    file_ = opened(request);
    if (file_ < 0) throw LoadError("cannot be read as HDF5; check that the file is whole");
    header.default_unit = "m";
    header.named = true;
    takes.inside = true, takes.layout = true, takes.index_axes = true;
    along_index_ = request.components_along == "index";
    files.push_back(request.path);
    if (request.inside.empty() && H5Lexists(file_, "VTKHDF", H5P_DEFAULT) > 0) {
      choose_frames(request, 1);
      open_image();
    } else {
      open_arrays(request);
    }
    for (const auto& field : header.fields) header.working_bytes += 2 * protocol::voxel_bytes(field).value_or(0);
  }
  ~Hdf5Source() override {
    rows_of_.reset();
    H5Fclose(file_);
  }

  void read(const std::vector<std::uint32_t>& wanted, const std::vector<std::byte*>& to) override {
    for (std::size_t n = 0; n < to.size(); ++n) {
      const std::uint32_t field = wanted[n % wanted.size()];
      const Array& array = arrays_[field];
      const Handle dataset(H5Dopen2(file_, array.path.c_str(), H5P_DEFAULT), H5Dclose);
      check_whole(array, dataset);
      read_box(array, dataset, header.fields[field], whole_of(array, static_cast<std::int64_t>(n / wanted.size())), to[n]);
    }
  }

  void read_rows(std::uint32_t field, std::int64_t slice, std::int64_t first, std::int64_t count, std::byte* to) override {
    const Array& array = arrays_[field];
    if (!rows_of_ || rows_field_ != field) {
      rows_of_.emplace(H5Dopen2(file_, array.path.c_str(), keeps_chunks()), H5Dclose);
      rows_field_ = field;
      check_whole(array, *rows_of_);
    }
    Box box = whole_of(array, 0);
    box.raw.dims = {array.raw.dims[0], count, 1};
    const auto part = [&](int along, std::int64_t from, std::int64_t length) {
      const std::size_t index = (*array.rows)[static_cast<std::size_t>(along)];
      if (index == SIZE_MAX) return;  // one voxel, without an index of its own
      box.first[index] = static_cast<hsize_t>(from), box.lengths[index] = static_cast<hsize_t>(length);
    };
    part(0, first, count), part(1, slice, 1);
    protocol::FieldHeader of = header.fields[field];
    of.grid.dims = box.raw.dims;
    read_box(array, *rows_of_, of, box, to);
  }

 private:
  struct Array {
    std::string path;
    Shape shape;
    RawVoxels raw;
    VectorTurn turn;
    Packing packing;
    std::size_t time = SIZE_MAX;  ///< index that counts frames
    /// Indices along j and k, SIZE_MAX without one, if rows can be read alone.
    std::optional<std::array<std::size_t, 2>> rows{};
  };

  /// Part of an array, by its indices.
  struct Box {
    std::vector<hsize_t> first, lengths;
    RawVoxels raw;  ///< in memory
  };

  Box whole_of(const Array& array, std::int64_t frame) const {
    Box box{std::vector<hsize_t>(array.shape.lengths.size(), 0),
            std::vector<hsize_t>(array.shape.lengths.begin(), array.shape.lengths.end()), array.raw};
    if (array.time != SIZE_MAX) box.first[array.time] = static_cast<hsize_t>(first_ + frame), box.lengths[array.time] = 1;
    return box;
  }

  [[noreturn]] static void refuse(const Array& array) {
    throw LoadError("array '" + array.path + "' cannot be read; it is damaged, or the file is not whole");
  }

  static void check_whole(const Array& array, hid_t dataset) {
    if (is_stored_short(dataset)) refuse(array);
  }

  void read_box(const Array& array, hid_t dataset, const protocol::FieldHeader& field, const Box& box, std::byte* to) const {
    const Handle space(H5Dget_space(dataset), H5Sclose);
    std::size_t count = static_cast<std::size_t>(box.raw.components);
    for (const std::int64_t n : box.raw.dims) count *= static_cast<std::size_t>(n);
    const hsize_t numbers = count;
    const Handle memory(H5Screate_simple(1, &numbers, nullptr), H5Sclose);
    const bool direct = kept_as_they_are(box.raw, array.turn, field);
    std::vector<std::byte> room(direct ? 0 : count * size_of(array.raw.type));
    std::byte* const at = direct ? to : room.data();
    if (H5Sselect_hyperslab(space, H5S_SELECT_SET, box.first.data(), nullptr, box.lengths.data(), nullptr) < 0 ||
        H5Dread(dataset, memory_type(array.raw.type), memory, space, H5P_DEFAULT, at) < 0)
      refuse(array);
    if (array.packing.marks_any()) {
      if (array.raw.type == RawType::float32) array.packing.mark(reinterpret_cast<float*>(at), count);
      if (array.raw.type == RawType::float64) array.packing.mark(reinterpret_cast<double*>(at), count);
    }
    if (!direct) copy_voxels(room.data(), box.raw, array.turn, field, to);
  }

  /// Indices along j and k of an array that lies in memory as in the file, k slowest; none for others.
  static std::optional<std::array<std::size_t, 2>> rows_of(const Array& array) {
    const RawVoxels& raw = array.raw;
    const std::int64_t c = raw.components;
    if ((c > 1 && raw.component_stride != 1) || raw.stride[0] != c || raw.stride[1] != c * raw.dims[0] ||
        raw.stride[2] != c * raw.dims[0] * raw.dims[1])
      return std::nullopt;
    const std::int64_t wanted[] = {raw.dims[2], raw.dims[1], raw.dims[0], c};
    std::array<std::size_t, 4> index{SIZE_MAX, SIZE_MAX, SIZE_MAX, SIZE_MAX};
    std::size_t w = 0;
    for (std::size_t n = 0; n < array.shape.lengths.size(); ++n) {
      const std::int64_t length = array.shape.lengths[n];
      if (n == array.time || length == 1) continue;
      while (w < 4 && wanted[w] == 1) ++w;
      if (w == 4 || wanted[w] != length) return std::nullopt;
      index[w++] = n;
    }
    return std::array{index[1], index[0]};
  }

  /// Access that keeps the chunks of a row of them in memory, so that each is decoded once for all its slices.
  static hid_t keeps_chunks() {
    // More: more memory; less: chunks of large slices are decoded several times.
    constexpr std::size_t cache_bytes = 512'000'000, most_chunks = 100'003;
    static const hid_t access = [] {
      const hid_t made = H5Pcreate(H5P_DATASET_ACCESS);
      H5Pset_chunk_cache(made, most_chunks, cache_bytes, 1.0);
      return made;
    }();
    return access;
  }

  /// Adds warnings that hold for all arrays once.
  void warn(const std::vector<std::string>& words) {
    for (const std::string& word : words) {
      if (std::ranges::find(header.warnings, word) == header.warnings.end()) header.warnings.push_back(word);
    }
  }

  /// Adds a field for an array. If some numbers are no data, it is read as floating point.
  void add(const std::string& path, const std::string& name, const Shape& shape, const Arranged& arranged,
           const GridGeometry& grid) {
    Array array{.path = path, .shape = shape, .raw = {}, .turn = {}, .packing = {}, .time = arranged.time};
    array.raw = protocol::arranged(shape.type, arranged.lengths, arranged.layout);
    const Handle dataset(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose);
    std::vector<std::string> notes;
    array.packing = packing_of(dataset, shape.type, is_netcdf(file_, dataset), notes);
    if (array.packing.marks_any()) {
      const bool exact = shape.type == RawType::float32 || protocol::size_of(shape.type) < 4;  // as float32
      array.raw.type = exact ? RawType::float32 : RawType::float64;
    }
    protocol::FieldHeader field;
    field.name = name;
    field.grid = grid;
    field.scale = array.packing.scale, field.offset = array.packing.offset;
    if (along_index_) array.turn.axes = protocol::unit_axes(grid);
    keep(array.raw, array.turn, field, header.warnings);
    for (const char* key : {"units", "unit"}) {
      if (field.unit.empty()) field.unit = text_attribute(dataset, key);
    }
    for (std::string& note : notes) note = "array '" + name + "' " + note;
    warn(notes);
    header.fields.push_back(field);
    array.rows = rows_of(array);
    header.reads_rows = (arrays_.empty() || header.reads_rows) && array.rows;
    arrays_.push_back(std::move(array));
  }

  /// Arrays of a request without a path: the largest, if all of that size have one shape up to indices of length 1.
  std::vector<FoundArray> chosen_arrays(const protocol::Request& request) {
    const std::vector<FoundArray> found = arrays_in(file_);
    if (found.empty()) throw LoadError("has no array of three or more indices; give a file with a volume");
    const auto size = [](const FoundArray& array) {
      double numbers = 1;
      for (const std::int64_t n : array.shape.lengths) numbers *= static_cast<double>(n);
      return numbers;
    };
    double most = 0;
    for (const FoundArray& array : found) most = std::max(most, size(array));
    std::vector<FoundArray> chosen, others;
    for (const FoundArray& array : found) (size(array) == most ? chosen : others).push_back(array);
    const auto shape = [](const FoundArray& array) {
      std::vector<std::int64_t> lengths = array.shape.lengths;
      std::erase(lengths, 1);
      return lengths;
    };
    const std::string& file = request.packed.empty() ? request.path : request.packed;
    const std::string by_path = file.substr(file.rfind('/') + 1) + ":";
    if (std::ranges::any_of(chosen, [&](const FoundArray& a) { return shape(a) != shape(chosen.front()); })) {
      if (request.listing) return list(found, size), std::vector<FoundArray>();
      throw LoadError("holds several arrays (" + joined(found) + "); name one: " + by_path + found.front().path);
    }
    if (!others.empty()) {
      header.warnings.push_back("holds smaller arrays, too (" + joined(others) + "), which are left out: " + by_path +
                                others.front().path + " takes one of them");
    }
    return chosen;
  }

  /// Lists arrays of which a request names one.
  template <class Size>
  void list(const std::vector<FoundArray>& found, const Size& size) {
    for (const FoundArray& array : found) {
      std::string lengths;
      for (const std::int64_t n : array.shape.lengths) lengths += (lengths.empty() ? "" : " × ") + std::to_string(n);
      header.alternatives.push_back({array.path, lengths, static_cast<std::int64_t>(size(array))});
    }
  }

  void open_arrays(const protocol::Request& request) {
    header.format = "hdf5";
    std::vector<FoundArray> chosen;
    if (request.inside.empty()) {
      chosen = chosen_arrays(request);
    } else {
      chosen.push_back({request.inside, {}});
    }
    std::set<std::string> names;
    std::int64_t frames = 0;
    for (FoundArray& array : chosen) {
      const Handle dataset(H5Dopen2(file_, array.path.c_str(), H5P_DEFAULT), H5Dclose);
      if (!dataset.is_open())
        throw LoadError("has no array '" + array.path + "' of its own; it has " + joined(arrays_in(file_)));
      array.shape = {};
      if (const std::string why = shape_of(dataset, array.shape); !why.empty())
        throw LoadError("array '" + array.path + "' cannot be felt: " + why + "; give one that holds a volume");
      try {
        check_program(array.path, request.layout);
        std::vector<std::string> notes;
        const Arranged arranged =
            arrangement_of(dimensions_of(dataset, array.shape, notes), request.layout, is_named_as_component(array.path));
        const GridGeometry grid = placed(dataset, arranged, request.layout, notes);
        warn(notes);
        const std::int64_t of_array = arranged.time == SIZE_MAX ? 1 : array.shape.lengths[arranged.time];
        if (frames == 0) frames = of_array, first_ = choose_frames(request, frames);
        if (frames != of_array)
          throw LoadError("has " + std::to_string(of_array) + " frames, where another has " + std::to_string(frames) +
                          "; name one array");
        std::string name = array.path.substr(array.path.rfind('/') + 1);
        if (!names.insert(name).second) name = array.path.substr(1);
        add(array.path, name, array.shape, arranged, grid);
      } catch (const LoadError& error) {
        throw LoadError("array '" + array.path + "' " + error.what());
      }
    }
  }

  /// Grid of an array: by the request, else its coordinates, else its steps as from Fiji and ilastik, else its indices.
  GridGeometry placed(hid_t dataset, const Arranged& arranged, ArrayLayout layout, std::vector<std::string>& notes) {
    const auto steps_um = numbers_attribute(dataset, "element_size_um");
    if (layout.spacing_m == Vec3{} && !has_places(arranged.space) && steps_um && steps_um->size() == 3) {
      const auto step = [&](char axis) { return (*steps_um)[arranged.layout.axes.find(axis)]; };
      layout.spacing_m = {step('x'), step('y'), step('z')};
      protocol::Header of_layout;
      header.length_unit = "um";
      return protocol::placed_by(layout, of_layout);
    }
    if (layout.spacing_m != Vec3{} || !has_places(arranged.space)) {
      protocol::Header of_layout;
      const GridGeometry grid = protocol::placed_by(layout, of_layout);
      header.length_unit = of_layout.length_unit;
      notes.insert(notes.end(), of_layout.warnings.begin(), of_layout.warnings.end());
      return grid;
    }
    if (layout.origin_m) throw LoadError("has coordinates of its own; give spacing_m with origin_m, or neither");
    const Coordinates coordinates = in_one_unit(arranged.space, notes);
    header.length_unit = coordinates.unit;
    try {
      return grids_of(coordinates.of, Mat3::identity(), {}).points;
    } catch (const std::invalid_argument& problem) {
      throw LoadError(std::string("has coordinates that are no grid (") + problem.what() +
                      "); correct them, or give spacing_m");
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
    const auto take = [&](const char* name, double* to, std::size_t count) {
      const auto numbers = numbers_attribute(root, name);
      const bool fits = numbers && numbers->size() == count;
      if (fits) std::ranges::copy(*numbers, to);
      return fits;
    };
    if (!take("WholeExtent", whole, 6)) throw LoadError("has no WholeExtent; export it again");
    take("Origin", origin, 3), take("Spacing", spacing, 3), take("Direction", direction, 9);
    int extent[6];
    for (int n = 0; n < 6; ++n) {
      if (!(std::abs(whole[n]) < 2e9)) throw LoadError("has an extent that cannot be; export it again");
      extent[n] = static_cast<int>(whole[n]);
    }
    add_image(grids_of(extent, origin, spacing, direction));
  }

  void add_image(const PointsAndCells& grids) {
    std::set<std::string> names;
    for (const bool of_cells : {false, true}) {
      const std::string group = of_cells ? "/VTKHDF/CellData" : "/VTKHDF/PointData";
      for (const auto& [path, shape] : arrays_in(file_)) {
        if (path.compare(0, group.size() + 1, group + "/") != 0 || shape.lengths.size() > 4) continue;
        std::string name = path.substr(group.size() + 1);
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
        Arranged as_it_is;
        as_it_is.lengths = shape.lengths;
        if (vector) as_it_is.layout.components = "last";
        add(path, name, shape, as_it_is, grid);
      }
    }
    if (header.fields.empty())
      throw LoadError("has no array that can be felt; one number per point, or a vector of three, is needed");
  }

  hid_t file_ = H5I_INVALID_HID;
  std::int64_t first_ = 0;         ///< frame to read
  bool along_index_ = false;       ///< vectors are along the grid's axes
  std::vector<Array> arrays_;      ///< one per field
  std::optional<Handle> rows_of_;  ///< array whose rows were read last
  std::uint32_t rows_field_ = 0;
};

}  // namespace

std::unique_ptr<Source> open_hdf5(const protocol::Request& request) { return std::make_unique<Hdf5Source>(request); }

}  // namespace palpa::reader
