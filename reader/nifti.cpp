// NIfTI-1 and NIfTI-2 by vtk-dicom.
#include <vtkMatrix4x4.h>
#include <vtkNIFTIHeader.h>
#include <vtkNIFTIReader.h>
#include <vtkNew.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string_view>

#include "compression.h"
#include "data_file.h"
#include "first_bytes.h"
#include "messages.h"
#include "palpa/file/protocol_packed.h"
#include "raw_rows.h"
#include "source.h"

namespace palpa::reader {
namespace {

RawType raw_type(int type) {
  switch (type) {
    case vtkNIFTIHeader::TypeUInt8: return RawType::uint8;
    case vtkNIFTIHeader::TypeInt8: return RawType::int8;
    case vtkNIFTIHeader::TypeInt16: return RawType::int16;
    case vtkNIFTIHeader::TypeUInt16: return RawType::uint16;
    case vtkNIFTIHeader::TypeInt32: return RawType::int32;
    case vtkNIFTIHeader::TypeUInt32: return RawType::uint32;
    case vtkNIFTIHeader::TypeInt64: return RawType::int64;
    case vtkNIFTIHeader::TypeUInt64: return RawType::uint64;
    case vtkNIFTIHeader::TypeFloat32: return RawType::float32;
    case vtkNIFTIHeader::TypeFloat64: return RawType::float64;
    case vtkNIFTIHeader::TypeRGB24:
    case vtkNIFTIHeader::TypeRGBA32:
      throw LoadError("holds colours (RGB), which have no one value to feel; export the values that they were made from");
    case vtkNIFTIHeader::TypeComplex64:
    case vtkNIFTIHeader::TypeComplex128: throw LoadError("holds complex numbers; export magnitude or phase");
    default:
      throw LoadError("has NIfTI data type " + std::to_string(type) +
                      "; whole numbers to 64 bits, float32 and float64 can be read");
  }
}

/// Refuses data types that vtkNIFTIReader does not know: it would read beyond the end of its table of types.
/// \return  true if the numbers are in the other byte order than this machine's
bool check_type(const std::string& start) {
  if (start.size() < 348) throw LoadError("is shorter than a NIfTI header; get the whole file");
  const bool second_version = start.substr(4, 3) == "n+2" || start.substr(4, 3) == "ni2";
  std::uint32_t header_bytes = 0;
  std::uint16_t type = 0;
  std::memcpy(&header_bytes, start.data(), sizeof header_bytes);
  std::memcpy(&type, start.data() + (second_version ? 12 : 70), sizeof type);
  const bool swapped = header_bytes != 348 && header_bytes != 540;
  if (swapped) type = static_cast<std::uint16_t>(type >> 8 | type << 8);
  static constexpr int known[] = {2, 4, 8, 16, 32, 64, 128, 256, 512, 768, 1024, 1280, 1792, 2304};
  if (std::find(std::begin(known), std::end(known), type) == std::end(known)) {
    throw LoadError("has NIfTI data type " + std::to_string(type) +
                    "; whole numbers to 64 bits, float32 and float64 can be read");
  }
  return swapped;
}

template <class T>
T number_at(const std::string& start, std::size_t at, bool swapped) {
  std::array<char, sizeof(T)> bytes{};
  std::copy_n(start.data() + at, bytes.size(), bytes.data());
  if (swapped) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

/// Refuses extensions that overlap the voxels. \param start  of the file, up to `offset` or a megabyte
void check_extensions(const std::string& start, bool swapped, std::uint64_t first, std::uint64_t offset) {
  if (start.size() < first + 8 || start[first - 4] == 0) return;
  std::uint64_t end = first;
  do {
    const auto bytes = number_at<std::int32_t>(start, end, swapped), code = number_at<std::int32_t>(start, end + 4, swapped);
    if (bytes < 16 || bytes % 16 != 0 || code < 0) return;  // no extension
    end += static_cast<std::uint64_t>(bytes);
  } while (end < offset && end + 8 <= start.size());
  if (end > offset)
    throw LoadError("has extensions that end at byte " + std::to_string(end) + ", where its voxels begin at " +
                    std::to_string(offset) + "; correct vox_offset");
}

/// Offset of the voxels, in their own file or behind the header. Throws LoadError if within the header.
std::uint64_t voxel_offset(const std::string& path, const std::string& start, bool swapped,
                           std::vector<std::string>& warnings) {
  const bool second_version = start.substr(4, 3) == "n+2" || start.substr(4, 3) == "ni2";
  const std::uint64_t header_bytes = second_version ? 540 : 348, least = header_bytes + 4;
  const bool alone = start[second_version ? 5 : 345] == '+';
  const double said = second_version ? static_cast<double>(number_at<std::int64_t>(start, 168, swapped))
                                     : static_cast<double>(number_at<float>(start, 108, swapped));
  const std::string where = "of " + std::to_string(least) + " bytes or more from the file's beginning";
  if (!(said >= 0.0 && said < 0x1p62) || said != std::floor(said))
    throw LoadError("says no place where its voxels begin; correct vox_offset, a whole number" + (alone ? " " + where : ""));
  auto offset = static_cast<std::uint64_t>(said);
  if (!alone) return offset;
  if (offset == 0) {
    offset = least;
    warnings.push_back("says that its voxels begin at byte 0, where its header is (vox_offset): they are taken from byte " +
                       std::to_string(least) + " on");
  } else if (offset != header_bytes && offset < least) {
    throw LoadError("says that its voxels begin at byte " + std::to_string(offset) +
                    ", which is within its header; correct "
                    "vox_offset, a whole number " +
                    where);
  }
  if (offset >= least)
    check_extensions(first_bytes(path, std::min<std::uint64_t>(offset + 8, 1 << 20)), swapped, least, offset);
  return offset;
}

class NiftiSource : public Source {
 public:
  explicit NiftiSource(const protocol::Request& request) {
    header.format = "nifti";
    takes.index_axes = true;
    header.default_unit = "mm";
    files.push_back(request.path);
    const std::string start = first_bytes(request.path);
    raw_.swapped = check_type(start);
    voxel_offset_ = voxel_offset(request.path, start, raw_.swapped, header.warnings);
    reader_->SetFileName(request.path.c_str());
    reader_->UpdateInformation();
    if (library_complained() || reader_->GetErrorCode() != 0) {
      throw LoadError("cannot be read as NIfTI (" + take_library_error() + "); check its header");
    }
    vtkNIFTIHeader& h = *reader_->GetNIFTIHeader();
    list_image(h);
    raw_.type = raw_type(h.GetDataType());

    Dims dim = dims_of(h);
    raw_.dims = {dim[1], dim[2], dim[3]};
    find_components(h, request, dim);
    find_frames(request, dim);

    protocol::FieldHeader field;
    field.name = raw_.components == 3 ? "vector" : "value";
    find_geometry(h, field.grid);
    if (request.components_along == "index") {
      turn_.axes = protocol::unit_axes(field.grid);
      if (raw_.components == 3 && header.medical_frame && determinant(turn_.axes) > 0) {
        header.warnings.push_back(
            "its grid is right-handed, where FSL negates the first component of its directions: "
            "check that they are not mirrored");
      }
    }
    find_scale(h, field);
    keep(raw_, turn_, field, header.warnings);
    header.fields.push_back(field);
    const std::uint64_t frames = raw_.component_stride > 0 && raw_.components == 3 ? 3 : 1;
    if (!protocol::is_packed(files.back())) {
      rows_.emplace(files.back(), first_byte_, raw_, frames_read);
      if (rows_->can_read()) {
        header.working_bytes = 0;
      } else {
        rows_.reset();
      }
      note_left_over(file_bytes(files.back()), voxel_offset_ + frames * static_cast<std::uint64_t>(dim[4]) * frame_bytes_,
                     "vox_offset", header.warnings);
    }
    switch (h.GetXYZTUnits() & 7) {
      case vtkNIFTIHeader::UnitsMeter: header.length_unit = "m"; break;
      case vtkNIFTIHeader::UnitsMM: header.length_unit = "mm"; break;
      case vtkNIFTIHeader::UnitsMicron: header.length_unit = "um"; break;
      case 0: break;
      default: header.length_unit = "code " + std::to_string(h.GetXYZTUnits() & 7) + " of xyzt_units";
    }
  }

  /// The library reads the first frame or all, and a compressed file from its beginning for each: here all frames are read in
  /// one pass.
  void read(const std::vector<std::uint32_t>&, const std::vector<std::byte*>& to) override {
    if (rows_) return rows_->read_frames(turn_, header.fields[0], to, put);
    const auto numbers = std::make_unique_for_overwrite<std::byte[]>(header.working_bytes);
    read_unpacked(files.back(), first_byte_, numbers.get(), header.working_bytes);
    for (std::size_t n = 0; n < to.size(); ++n) {
      copy_voxels(numbers.get() + n * frame_bytes_, raw_, turn_, header.fields[0], to[n]);
    }
  }

  /// Checks gzip's checksum, because vtk-dicom stops at the last voxel. Files of several frames are not checked: only their
  /// beginning is decompressed.
  void check_files() const override {
    if (header.frames > 1) return;
    for (const std::string& file : files) {
      if (file.size() > 3 && file.compare(file.size() - 3, 3, ".gz") == 0) check_compression(file, 0);
    }
  }

 private:
  using Dims = std::array<std::int64_t, 8>;

  static Dims dims_of(vtkNIFTIHeader& h) {
    Dims dim{};
    const std::int64_t given = h.GetDim(0);
    for (int a = 1; a < 8; ++a) {
      dim[a] = a <= given ? h.GetDim(a) : 1;
      if (dim[a] < 1) throw LoadError("has no voxels along axis " + std::to_string(a) + "; check 'dim' of its header");
      if (a >= 6 && dim[a] > 1) throw LoadError("has " + std::to_string(given) + " dimensions; up to five can be read");
    }
    return dim;
  }

  /// Finds vectors: the fifth dimension, or the fourth by the file's intent or the request.
  void find_components(vtkNIFTIHeader& h, const protocol::Request& request, Dims& dim) {
    const bool intent =
        h.GetIntentCode() == vtkNIFTIHeader::IntentVector || h.GetIntentCode() == vtkNIFTIHeader::IntentDispVect;
    const bool asked = request.as == "vector";
    if (dim[5] == 3 && (intent || asked)) {
      raw_.components = 3;
    } else if (dim[5] == 1 && dim[4] == 3 && (intent || asked)) {
      raw_.components = 3;
      dim[4] = 1;
    } else if (dim[5] > 1) {
      throw LoadError("has " + std::to_string(dim[5]) + " numbers per voxel" +
                      (dim[5] == 3 ? " and does not say that they are a vector; if they are, as = \"vector\" takes them as one"
                                   : "; one, or a vector of three, can be felt"));
    } else if (asked) {
      throw LoadError("has no three frames to take as one vector; leave out as = \"vector\"");
    }
  }

  /// Finds frames. Components are stored one after the other, each for all frames.
  void find_frames(const protocol::Request& request, const Dims& dim) {
    const std::int64_t first = choose_frames(request, dim[4]);
    raw_.stride = {1, dim[1], 0};
    std::int64_t frame_values = 0, frame_bytes = 0, first_byte = 0, frames = 0, bytes = 0;
    if (__builtin_mul_overflow(dim[1] * dim[2], dim[3], &frame_values) ||
        __builtin_mul_overflow(frame_values, dim[4], &raw_.component_stride) ||
        __builtin_mul_overflow(frame_values, static_cast<std::int64_t>(size_of(raw_.type)), &frame_bytes) ||
        __builtin_mul_overflow(dim[4], std::int64_t{raw_.components - 1}, &frames) ||
        __builtin_add_overflow(frames, frames_read, &frames) || __builtin_mul_overflow(frame_bytes, first, &first_byte) ||
        __builtin_mul_overflow(frame_bytes, frames, &bytes)) {
      throw LoadError("claims more voxels than can be counted; the header is damaged");
    }
    raw_.stride[2] = dim[1] * dim[2];
    frame_bytes_ = static_cast<std::uint64_t>(frame_bytes);
    if (__builtin_add_overflow(voxel_offset_, static_cast<std::uint64_t>(first_byte), &first_byte_))
      throw LoadError("claims more voxels than can be counted; the header is damaged");
    header.working_bytes = static_cast<std::uint64_t>(bytes);
  }

  void find_scale(vtkNIFTIHeader& h, protocol::FieldHeader& field) {
    const double slope = h.GetSclSlope();
    if (std::isfinite(slope) && slope != 0) {
      field.scale = slope;
      field.offset = h.GetSclInter();
      if (!std::isfinite(field.offset)) {
        field.offset = 0;
        header.warnings.push_back("scl_inter is not finite: 0 is taken");
      }
    }
  }

  /// Adds the image file of a pair: .img for the header's .hdr.
  void list_image(vtkNIFTIHeader& h) {
    if (std::string_view(h.GetMagic()).substr(0, 2) != "ni") return;
    const std::string& name = files.front();
    const std::size_t dot = name.rfind(".hdr");
    if (dot == std::string::npos) return;
    for (const char* end : {".img", ".img.gz"}) {
      const std::string image = name.substr(0, dot) + end;
      if (file_bytes(image) == 0) continue;
      check_data_file(name, image);
      return files.push_back(image);
    }
    throw LoadError("needs its image, '" + name.substr(0, dot) + ".img', which is not there or empty; put it back");
  }

  /// Affine of the file's own index order: sform if present, else qform, else spacing alone.
  void find_geometry(vtkNIFTIHeader& h, GridGeometry& grid) {
    const Mat3 to_lps{{{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}};
    const double spacing[3] = {h.GetPixDim(1), h.GetPixDim(2), h.GetPixDim(3)};
    const auto length = [&](int a) { return spacing[a] == 0 ? 1.0 : std::abs(spacing[a]); };
    const bool has_sform = h.GetSFormCode() > 0, has_qform = h.GetQFormCode() > 0 && reader_->GetQFormMatrix() != nullptr;
    if (!has_sform && !has_qform) {
      grid.index_to_world_m = {{{length(0), 0, 0}, {0, length(1), 0}, {0, 0, length(2)}}};
      return;
    }
    header.medical_frame = true;
    turn_.axes = to_lps;
    GridGeometry by_qform{raw_.dims}, by_sform{raw_.dims};
    if (has_qform) {
      const vtkMatrix4x4& m = *reader_->GetQFormMatrix();
      const double step[3] = {length(0), length(1), length(2) * reader_->GetQFac()};
      Mat3 affine;
      for (int r = 0; r < 3; ++r)
        affine.row[r] = {m.GetElement(r, 0) * step[0], m.GetElement(r, 1) * step[1], m.GetElement(r, 2) * step[2]};
      by_qform.index_to_world_m = to_lps * affine;
      by_qform.origin_m = to_lps * Vec3{h.GetQOffsetX(), h.GetQOffsetY(), h.GetQOffsetZ()};
    }
    if (has_sform) {
      const double *x = h.GetSRowX(), *y = h.GetSRowY(), *z = h.GetSRowZ();
      by_sform.index_to_world_m = to_lps * Mat3{{{x[0], x[1], x[2]}, {y[0], y[1], y[2]}, {z[0], z[1], z[2]}}};
      by_sform.origin_m = to_lps * Vec3{x[3], y[3], z[3]};
    }
    grid = has_sform ? by_sform : by_qform;
    if (has_sform && has_qform) compare(by_sform, by_qform);
  }

  /// Warns if a corner of the grid by sform and by qform differs by more than a tenth of a voxel.
  void compare(const GridGeometry& by_sform, const GridGeometry& by_qform) {
    const Mat3 to_index = inverse(by_sform.index_to_world_m);
    double apart = 0;  // [voxels]
    for (int corner = 0; corner < 8; ++corner) {
      const auto end = [&](int a) {
        return (corner >> a & 1) != 0 ? static_cast<double>(raw_.dims[static_cast<std::size_t>(a)] - 1) : 0.0;
      };
      const GridPoint at{end(0), end(1), end(2)};
      apart = std::max(apart, norm(to_index * (by_qform.to_world(at) - by_sform.to_world(at))));
    }
    if (!(apart > 0.1)) return;
    char text[32];
    std::snprintf(text, sizeof text, "%.2g", apart);
    header.warnings.push_back("sform and qform put a corner " + std::string(text) + " voxels apart: the sform is used");
  }

  vtkNew<vtkNIFTIReader> reader_;
  RawVoxels raw_;
  std::optional<RawRows> rows_;     ///< of numbers that are the voxels in order
  std::uint64_t voxel_offset_ = 0;  ///< [bytes] in the file of the voxels
  std::uint64_t frame_bytes_ = 0;   ///< per component
  std::uint64_t first_byte_ = 0;    ///< to read
  VectorTurn turn_;
};

}  // namespace

std::unique_ptr<Source> open_nifti(const protocol::Request& request) { return std::make_unique<NiftiSource>(request); }

}  // namespace palpa::reader
