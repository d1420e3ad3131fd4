#include "palpa/file/nifti_header.h"

#include <cstring>

namespace palpa::detail {
namespace {

constexpr std::size_t header_bytes = 352;  // with the empty mark of extensions

template <class T>
void put(std::string& header, std::size_t at, T value) {
  std::memcpy(header.data() + at, &value, sizeof value);
}

/// Codes of the standard (nifti1.h).
std::int16_t type_code(VoxelType type) {
  switch (type) {
    case VoxelType::uint8: return 2;
    case VoxelType::int16: return 4;
    case VoxelType::int32: return 8;
    case VoxelType::float32: return 16;
    case VoxelType::float64: return 64;
    case VoxelType::uint16: return 512;
  }
  return 0;
}
constexpr std::int16_t of_vectors = 1007, scanner_frame = 1, other_frame = 2;
constexpr char millimetres = 2;

}  // namespace

std::string nifti_header(const WrittenVolume& volume) {
  const WrittenField& field = volume.fields.front();
  const bool vectors = field.components == 3;
  std::string header(header_bytes, '\0');
  put(header, 0, std::int32_t{348});
  put(header, 40, static_cast<std::int16_t>(vectors ? 5 : 3));
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t count = volume.grid.dims[a];
    if (count > INT16_MAX)
      throw LoadError("has " + std::to_string(count) + " voxels along an axis, where NIfTI-1 holds 32767; write .nrrd");
    put(header, 42 + 2 * a, static_cast<std::int16_t>(count));
  }
  for (std::size_t a = 3; a < 7; ++a) put(header, 42 + 2 * a, static_cast<std::int16_t>(a == 4 && vectors ? 3 : 1));
  if (vectors) put(header, 68, of_vectors);
  put(header, 70, type_code(field.type));
  put(header, 72, static_cast<std::int16_t>(8 * size_of(field.type)));
  const Mat3 steps = transposed(volume.grid.index_to_world_m);
  put(header, 76, 1.0f);
  for (std::size_t a = 0; a < 3; ++a) put(header, 80 + 4 * a, static_cast<float>(1e3 * norm(steps.row[a])));
  put(header, 108, static_cast<float>(header_bytes));
  put(header, 112, 1.0f);
  header[123] = millimetres;
  std::memcpy(header.data() + 148, "palpa convert", 13);
  put(header, 254, volume.medical_frame ? scanner_frame : other_frame);
  const double origin_m[] = {volume.grid.origin_m.x, volume.grid.origin_m.y, volume.grid.origin_m.z};
  for (std::size_t r = 0; r < 3; ++r) {
    const double per_m = r < 2 ? -1e3 : 1e3;  // LPS to RAS
    const Vec3& row = volume.grid.index_to_world_m.row[r];
    const double numbers[] = {row.x, row.y, row.z, origin_m[r]};
    for (std::size_t c = 0; c < 4; ++c) put(header, 280 + 16 * r + 4 * c, static_cast<float>(per_m * numbers[c] + 0.0));
  }
  std::memcpy(header.data() + 344, "n+1", 3);
  return header;
}

}  // namespace palpa::detail
