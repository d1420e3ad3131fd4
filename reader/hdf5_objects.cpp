#include "hdf5_objects.h"

#include <algorithm>
#include <cstring>
#include <numeric>

namespace palpa::reader {
namespace {

constexpr std::size_t max_listed = 200;           // arrays of a file. More: long lines; fewer: the wanted one may be missing
constexpr std::size_t max_text_bytes = 1000;      // of an attribute. More: memory for damaged ones; fewer: words are cut
constexpr hssize_t max_attribute_numbers = 1000;  // of an attribute, likewise

/// Memory type of an HDF5 number type; false if it cannot be read.
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

/// Library memory for attributes of variable length, freed with its owner.
template <class T>
class Lent {
 public:
  Lent(hid_t type, hid_t space, std::size_t count) : values(count), type_(type), space_(space) {}
  Lent(const Lent&) = delete;
  Lent& operator=(const Lent&) = delete;
  ~Lent() { H5Dvlen_reclaim(type_, space_, H5P_DEFAULT, values.data()); }
  std::vector<T> values;

 private:
  hid_t type_, space_;
};

std::string text_in(const char* text) {
  return text == nullptr ? std::string() : std::string(text, strnlen(text, max_text_bytes));
}

/// Texts of a string attribute with `count` of them; else none.
std::vector<std::string> texts_of(hid_t attribute, std::size_t count) {
  const Handle type(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
  if (!type.is_open() || !space.is_open() || H5Tget_class(type) != H5T_STRING ||
      H5Sget_simple_extent_npoints(space) != static_cast<hssize_t>(count))
    return {};
  std::vector<std::string> texts;
  if (H5Tis_variable_str(type) > 0) {
    const Handle memory(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(memory, H5T_VARIABLE);
    H5Tset_cset(memory, H5Tget_cset(type));  // the library does not convert character sets
    Lent<char*> lent(memory, space, count);
    if (H5Aread(attribute, memory, lent.values.data()) < 0) return {};
    for (const char* text : lent.values) texts.push_back(text_in(text));
    return texts;
  }
  const std::size_t bytes = H5Tget_size(type);
  if (bytes > max_text_bytes) return {};
  std::string all(bytes * count, '\0');
  if (H5Aread(attribute, type, all.data()) < 0) return {};
  for (std::size_t n = 0; n < count; ++n) texts.push_back(text_in(all.substr(n * bytes, bytes).c_str()));
  return texts;
}

}  // namespace

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
  unsigned int packing = 0;  // a bit per filter that may shrink a chunk; set in a chunk's mask if omitted
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

std::vector<FoundArray> arrays_in(hid_t file) {
  std::vector<FoundArray> found;
  const auto visit = [](hid_t at, const char* name, const H5O_info_t* info, void* to) -> herr_t {
    auto& list = *static_cast<std::vector<FoundArray>*>(to);
    if (info->type != H5O_TYPE_DATASET) return 0;
    const Handle dataset(H5Dopen2(at, name, H5P_DEFAULT), H5Dclose);
    Shape shape;
    if (dataset.is_open() && shape_of(dataset, shape).empty() && shape.lengths.size() >= 3)
      list.push_back({std::string("/") + name, shape});
    return list.size() >= max_listed ? 1 : 0;
  };
  H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_INC, visit, &found, H5O_INFO_BASIC);
  return found;
}

std::string text_attribute(hid_t object, const char* name) {
  const std::vector<std::string> texts = texts_attribute(object, name, 1);
  return texts.empty() ? std::string() : texts.front();
}

std::vector<std::string> texts_attribute(hid_t object, const char* name, std::size_t count) {
  if (H5Aexists(object, name) <= 0) return {};
  const Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  return attribute.is_open() ? texts_of(attribute, count) : std::vector<std::string>();
}

std::optional<std::vector<double>> numbers_attribute(hid_t object, const char* name) {
  if (H5Aexists(object, name) <= 0) return std::nullopt;
  const Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose), type(H5Aget_type(attribute), H5Tclose),
      space(H5Aget_space(attribute), H5Sclose);
  const H5T_class_t kind = type.is_open() ? H5Tget_class(type) : H5T_NO_CLASS;
  const hssize_t count = space.is_open() ? H5Sget_simple_extent_npoints(space) : 0;
  std::vector<double> numbers;
  if ((kind != H5T_INTEGER && kind != H5T_FLOAT) || count < 1 || count > max_attribute_numbers) return numbers;
  numbers.resize(static_cast<std::size_t>(count));
  if (H5Aread(attribute, H5T_NATIVE_DOUBLE, numbers.data()) < 0) numbers.clear();
  return numbers;
}

std::vector<Handle> dimension_scales(hid_t dataset, std::size_t rank) {
  std::vector<Handle> scales;
  const auto fill = [&] {
    while (scales.size() < rank) scales.emplace_back(H5I_INVALID_HID, H5Dclose);
    return std::move(scales);
  };
  if (H5Aexists(dataset, "DIMENSION_LIST") <= 0) return fill();
  const Handle attribute(H5Aopen(dataset, "DIMENSION_LIST", H5P_DEFAULT), H5Aclose), type(H5Aget_type(attribute), H5Tclose),
      space(H5Aget_space(attribute), H5Sclose);
  if (!attribute.is_open() || !type.is_open() || !space.is_open() || H5Tget_class(type) != H5T_VLEN ||
      H5Sget_simple_extent_npoints(space) != static_cast<hssize_t>(rank))
    return fill();
  const Handle of(H5Tget_super(type), H5Tclose), memory(H5Tvlen_create(H5T_STD_REF_OBJ), H5Tclose);
  if (H5Tequal(of, H5T_STD_REF_OBJ) <= 0) return fill();
  Lent<hvl_t> lists(memory, space, rank);
  if (H5Aread(attribute, memory, lists.values.data()) < 0) return fill();
  for (const hvl_t& list : lists.values) {
    hid_t scale = H5I_INVALID_HID;
    if (list.len > 0 && list.p != nullptr) scale = H5Rdereference2(dataset, H5P_DEFAULT, H5R_OBJECT, list.p);
    if (scale >= 0 && H5Iget_type(scale) != H5I_DATASET) H5Oclose(scale), scale = H5I_INVALID_HID;
    scales.emplace_back(scale, H5Dclose);
  }
  return fill();
}

}  // namespace palpa::reader
