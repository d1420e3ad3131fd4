// Arrays of HDF5 files, written with the library itself.
#pragma once

#include <hdf5.h>

#include "files.h"

namespace palpa::test {

template <class T>
hid_t number_type() {
  if constexpr (std::is_same_v<T, double>) return H5T_NATIVE_DOUBLE;
  if constexpr (std::is_same_v<T, float>) return H5T_NATIVE_FLOAT;
  if constexpr (std::is_same_v<T, std::int16_t>) return H5T_STD_I16BE;
  return H5T_NATIVE_INT64;
}

/// Writes bytes of numbers as an array; gzip packs it in chunks.
template <class T>
void write_array(hid_t file, const std::string& path, std::vector<hsize_t> lengths, const std::string& bytes,
                 bool gzip = false) {
  const hid_t space = H5Screate_simple(static_cast<int>(lengths.size()), lengths.data(), nullptr);
  const hid_t links = H5Pcreate(H5P_LINK_CREATE), creation = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_create_intermediate_group(links, 1);
  if (gzip) {
    H5Pset_chunk(creation, static_cast<int>(lengths.size()), lengths.data());
    H5Pset_shuffle(creation);
    H5Pset_deflate(creation, 6);
  }
  const hid_t data = H5Dcreate2(file, path.c_str(), number_type<T>(), space, links, creation, H5P_DEFAULT);
  const hid_t memory = std::is_same_v<T, std::int16_t> ? H5T_NATIVE_INT16 : number_type<T>();
  H5Dwrite(data, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data());
  H5Dclose(data), H5Pclose(links), H5Pclose(creation), H5Sclose(space);
}

inline void write_numbers(hid_t object, const char* name, std::vector<double> numbers) {
  const hsize_t count = numbers.size();
  const hid_t space = H5Screate_simple(1, &count, nullptr);
  const hid_t attribute = H5Acreate2(object, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT);
  H5Awrite(attribute, H5T_NATIVE_DOUBLE, numbers.data());
  H5Aclose(attribute), H5Sclose(space);
}

inline void write_text(hid_t object, const char* name, const std::string& text) {
  const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
  H5Tset_size(type, text.size());
  const hid_t attribute = H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
  H5Awrite(attribute, type, text.data());
  H5Aclose(attribute), H5Sclose(space), H5Tclose(type);
}

}  // namespace palpa::test
