#include "palpa/file/write_volume.h"

#include <bit>
#include <charconv>
#include <cmath>

#include "palpa/file/gzip_writer.h"
#include "palpa/file/nifti_header.h"
#include "palpa/file/protocol.h"
#include "palpa/file/vtk_xml.h"

static_assert(std::endian::native == std::endian::little, "the headers say so");

namespace palpa {
namespace {

namespace fs = std::filesystem;
using detail::NewFile;

/// Shortest decimal that parses to an equal value.
std::string text_of(double value) {
  char text[40];
  return {text, std::to_chars(text, text + sizeof text, value + 0.0).ptr};
}
std::string list(const Vec3& v, const char* between) { return text_of(v.x) + between + text_of(v.y) + between + text_of(v.z); }

/// Values of a slice in the file's type.
void put(const WrittenField& field, const std::vector<double>& values, std::vector<std::byte>& bytes) {
  const auto as = [&](auto kept) {
    using T = decltype(kept);
    bytes.resize(values.size() * sizeof(T));
    T* out = reinterpret_cast<T*>(bytes.data());
    for (const double value : values) *out++ = static_cast<T>(value);
  };
  switch (field.type) {
    case VoxelType::uint8: return as(std::uint8_t{});
    case VoxelType::int16: return as(std::int16_t{});
    case VoxelType::uint16: return as(std::uint16_t{});
    case VoxelType::int32: return as(std::int32_t{});
    case VoxelType::float32: return as(float{});
    case VoxelType::float64: return as(double{});
  }
}

std::uint64_t bytes_of(const WrittenVolume& volume, const WrittenField& field) {
  protocol::FieldHeader header;
  header.type = field.type, header.components = field.components, header.grid = volume.grid;
  const auto bytes = protocol::voxel_bytes(header);
  if (!bytes) throw LoadError("would have more voxels than can be counted; take fewer");
  return *bytes;
}

class VoxelWriter {
 public:
  VoxelWriter(const WrittenVolume& volume, const std::function<void(double)>& progress)
      : volume_(volume), progress_(progress) {}

  /// Writes each component of vectors behind the other, along RAS.
  template <class To>
  void write_apart(const WrittenField& field, To& to) {
    parts_ = field.components;
    for (int c = 0; c < field.components; ++c) {
      WrittenField part = field;
      part.components = 1;
      part.slice = [&field, c, count = volume_.grid.dims[0] * volume_.grid.dims[1], all = std::vector<double>()](
                       std::int64_t k, double* values) mutable {
        all.resize(static_cast<std::size_t>(count * field.components));
        field.slice(k, all.data());
        const double sign = field.components == 3 && c < 2 ? -1.0 : 1.0;
        for (std::int64_t n = 0; n < count; ++n) values[n] = sign * all[static_cast<std::size_t>(n * field.components + c)];
      };
      write(part, to);
    }
  }

  template <class To>
  void write(const WrittenField& field, To& to) {
    const auto& dims = volume_.grid.dims;
    std::vector<double> values(static_cast<std::size_t>(dims[0] * dims[1] * field.components));
    std::vector<std::byte> bytes;
    for (std::int64_t k = 0; k < dims[2]; ++k) {
      field.slice(k, values.data());
      put(field, values, bytes);
      to.write(bytes.data(), bytes.size());
      ++done_;
      if (progress_)
        progress_(static_cast<double>(done_) /
                  (static_cast<double>(dims[2] * parts_) * static_cast<double>(volume_.fields.size())));
    }
  }

 private:
  const WrittenVolume& volume_;
  const std::function<void(double)>& progress_;
  std::int64_t done_ = 0, parts_ = 1;
};

std::string nrrd_header(const WrittenVolume& volume, const std::string& data_file) {
  static constexpr const char* types[] = {"uint8", "int16", "uint16", "int32", "float", "double"};
  const WrittenField& field = volume.fields.front();
  const bool vectors = field.components == 3;
  const double per_m = volume.length_unit == "mm" ? 1e3 : 1.0;
  const Mat3 steps = per_m * transposed(volume.grid.index_to_world_m);
  const auto& dims = volume.grid.dims;
  std::string text = "NRRD0005\n# written by palpa convert\n";
  text += std::string("type: ") + types[static_cast<std::size_t>(field.type)] + "\n";
  text += std::string("dimension: ") + (vectors ? "4" : "3") + "\n";
  text += volume.medical_frame ? "space: left-posterior-superior\n" : "space dimension: 3\n";
  text += std::string("sizes: ") + (vectors ? "3 " : "") + std::to_string(dims[0]) + " " + std::to_string(dims[1]) + " " +
          std::to_string(dims[2]) + "\n";
  text += std::string("space directions: ") + (vectors ? "none " : "") + "(" + list(steps.row[0], ",") + ") (" +
          list(steps.row[1], ",") + ") (" + list(steps.row[2], ",") + ")\n";
  text += std::string("kinds: ") + (vectors ? "vector " : "") + "domain domain domain\n";
  text += "endian: little\nencoding: raw\n";
  text += "space origin: (" + list(per_m * volume.grid.origin_m, ",") + ")\n";
  text += "space units: \"" + volume.length_unit + "\" \"" + volume.length_unit + "\" \"" + volume.length_unit + "\"\n";
  if (vectors) text += "measurement frame: (1,0,0) (0,1,0) (0,0,1)\n";
  if (!field.unit.empty() && field.unit.find_first_of("\"\n") == std::string::npos)
    text += "sample units: \"" + field.unit + "\"\n";
  text += data_file.empty() ? "\n" : "data file: " + data_file + "\n";
  return text;
}

void check_one_field(const WrittenVolume& volume, const char* format) {
  if (volume.fields.size() == 1) return;
  throw LoadError("would have " + std::to_string(volume.fields.size()) + " fields, and " + format +
                  " holds one; choose one, or write .vti");
}

void write_nifti(WrittenVolume volume, const fs::path& file, detail::Existing existing,
                 const std::function<void(double)>& progress) {
  check_one_field(volume, "NIfTI");
  WrittenField& field = volume.fields.front();
  // Vectors change their sign, which not all whole numbers can.
  const bool fractions = field.type == VoxelType::float32 || field.type == VoxelType::float64;
  if (field.components == 3 && !fractions)
    field.type = field.type == VoxelType::int32 ? VoxelType::float64 : VoxelType::float32;
  NewFile whole(file, existing);
  const auto write_to = [&](auto& to) {
    to.write(detail::nifti_header(volume));
    VoxelWriter(volume, progress).write_apart(field, to);
    to.finish();
  };
  if (file.extension() != ".gz") return write_to(whole);
  detail::GzipWriter packed(whole);
  write_to(packed);
  whole.finish();
}

void write_nrrd(const WrittenVolume& volume, const fs::path& file, detail::Existing existing, VoxelWriter& voxels) {
  check_one_field(volume, "NRRD");
  if (file.extension() != ".nhdr") {
    NewFile whole(file, existing);
    whole.write(nrrd_header(volume, ""));
    voxels.write(volume.fields.front(), whole);
    return whole.finish();
  }
  const fs::path raw_name = fs::path(file).replace_extension(".raw");
  NewFile raw(raw_name, existing), header(file, existing);
  voxels.write(volume.fields.front(), raw);
  header.write(nrrd_header(volume, raw_name.filename().string()));
  raw.finish();
  header.finish();
}

void write_vti(const WrittenVolume& volume, const fs::path& file, detail::Existing existing, VoxelWriter& voxels) {
  static constexpr const char* types[] = {"UInt8", "Int16", "UInt16", "Int32", "Float32", "Float64"};
  const Mat3 steps = transposed(volume.grid.index_to_world_m);
  const Vec3 spacing_m{norm(steps.row[0]), norm(steps.row[1]), norm(steps.row[2])};
  const Mat3 columns{
      {(1.0 / spacing_m.x) * steps.row[0], (1.0 / spacing_m.y) * steps.row[1], (1.0 / spacing_m.z) * steps.row[2]}};
  for (int a = 0; a < 3; ++a) {
    if (std::abs(dot(columns.row[a], columns.row[(a + 1) % 3])) > 1e-6) {
      throw LoadError("cannot store a sheared grid; write .nrrd, or resample it (--resample-m)");
    }
  }
  const Mat3 direction = transposed(columns);
  const auto& dims = volume.grid.dims;
  const std::string extent =
      "0 " + std::to_string(dims[0] - 1) + " 0 " + std::to_string(dims[1] - 1) + " 0 " + std::to_string(dims[2] - 1);
  std::string text = detail::vtk_xml_begin("ImageData");
  text += "<ImageData WholeExtent=\"" + extent + "\" Origin=\"" + list(volume.grid.origin_m, " ") + "\" Spacing=\"" +
          list(spacing_m, " ") + "\" Direction=\"" + list(direction.row[0], " ") + " " + list(direction.row[1], " ") + " " +
          list(direction.row[2], " ") + "\">\n";
  text += "<Piece Extent=\"" + extent + "\">\n<PointData>\n";
  NewFile whole(file, existing);
  whole.write(text);
  for (const WrittenField& field : volume.fields) {
    detail::VtkArrayWriter array(whole, types[static_cast<std::size_t>(field.type)], field.name, field.components,
                                 bytes_of(volume, field));
    voxels.write(field, array);
    array.finish();
  }
  whole.write("</PointData>\n</Piece>\n</ImageData>\n</VTKFile>\n");
  whole.finish();
}

void check_room(const fs::path& folder, std::uint64_t bytes) {
  std::error_code error;
  const fs::space_info space = fs::space(folder, error);
  if (error) throw LoadError("cannot be written: its folder does not exist; make it first");
  if (bytes > space.available) {
    throw LoadError("would need " + protocol::readable_bytes(static_cast<double>(bytes)) + " where the disk has " +
                    protocol::readable_bytes(static_cast<double>(space.available)) +
                    "; crop or downsample it, or name another disk");
  }
}

}  // namespace

std::uint64_t written_bytes(const WrittenVolume& volume) {
  std::uint64_t all = 0;
  for (const WrittenField& field : volume.fields) {
    if (__builtin_add_overflow(all, bytes_of(volume, field), &all))
      throw LoadError("would be larger than can be counted; take less");
  }
  return all;
}

bool is_nifti(const fs::path& file) {
  return file.extension() == ".nii" || (file.extension() == ".gz" && file.stem().extension() == ".nii");
}

void write_volume(const WrittenVolume& volume, const fs::path& file, detail::Existing existing,
                  const std::function<void(double)>& progress) {
  try {
    const std::string ending = file.extension().string();
    const bool to_nifti = is_nifti(file);
    if (ending != ".nrrd" && ending != ".nhdr" && !to_nifti && ending != ".vti")
      throw LoadError("has an ending of no format that is written; name it .nrrd, .nhdr, .nii, .nii.gz or .vti");
    const std::uint64_t bytes = written_bytes(volume);
    check_room(fs::absolute(file).parent_path(), ending == ".vti" ? bytes / 3 * 4 : bytes);
    if (to_nifti) return write_nifti(volume, file, existing, progress);
    VoxelWriter voxels(volume, progress);
    ending == ".vti" ? write_vti(volume, file, existing, voxels) : write_nrrd(volume, file, existing, voxels);
  } catch (const LoadError& error) {
    throw LoadError(file.string() + ": " + error.what());
  }
}

}  // namespace palpa
