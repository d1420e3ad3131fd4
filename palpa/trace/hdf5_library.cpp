// palpa-hdf5.so (hdf5.h).
#include <hdf5.h>

#include <algorithm>

#include "palpa/base/sanitized.h"
#include "palpa/trace/hdf5.h"
#include "palpa/version.h"

namespace palpa::detail {
namespace {

/// Object of the library, closed with its scope.
class Held {
 public:
  Held(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Held() {
    if (id_ >= 0) close_(id_);
  }
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;
  operator hid_t() const noexcept { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

bool write(hid_t file, const FeltColumn& column) {
  const auto components = static_cast<hsize_t>(column.components);
  const hsize_t lengths[2] = {column.values.size() / components, components};
  const Held space(H5Screate_simple(components > 1 ? 2 : 1, lengths, nullptr), H5Sclose);
  std::string name = sanitized(column.name);
  std::replace(name.begin(), name.end(), '/', '_');              // '/' would be a group
  const Held timeless(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);  // equal traces, equal bytes
  if (H5Pset_obj_track_times(timeless, false) < 0) return false;
  const Held data(H5Dcreate2(file, name.c_str(), column.is_whole ? H5T_STD_I64LE : H5T_IEEE_F64LE, space, H5P_DEFAULT, timeless,
                             H5P_DEFAULT),
                  H5Dclose);
  return data >= 0 && H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, column.values.data()) >= 0;
}

/// In memory: palpa/base/new_file.h writes the bytes.
std::string file_of(const FeltPath& path) {
  constexpr std::size_t step_bytes = std::size_t{1} << 20;  // growth increment
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const Held access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  if (H5Pset_fapl_core(access, step_bytes, false) < 0) return {};
  const Held file(H5Fcreate("trace.h5", H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose);
  if (file < 0) return {};
  for (const FeltColumn& column : path.columns) {
    if (!write(file, column)) return {};
  }
  if (H5Fflush(file, H5F_SCOPE_GLOBAL) < 0) return {};
  const ssize_t bytes = H5Fget_file_image(file, nullptr, 0);
  if (bytes <= 0) return {};
  std::string image(static_cast<std::size_t>(bytes), '\0');
  return H5Fget_file_image(file, image.data(), image.size()) == bytes ? image : std::string();
}

}  // namespace

extern "C" __attribute__((visibility("default"))) const Hdf5 palpa_hdf5;
const Hdf5 palpa_hdf5{version, file_of};

}  // namespace palpa::detail
