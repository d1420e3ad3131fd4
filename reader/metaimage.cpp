// MetaImage by ITK's MetaIO, without itk::MetaImageIO, which drops the orientation's name, the unit and the rescaling of the
// values.
#include <metaImage.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iomanip>
#include <limits>
#include <optional>
#include <sstream>
#include <string_view>

#include "compression.h"
#include "data_file.h"
#include "messages.h"
#include "palpa/base/input_file.h"
#include "raw_rows.h"
#include "source.h"
#include "text_number.h"

namespace palpa::reader {
namespace {

RawType raw_type(MET_ValueEnumType type) {
  int bytes = 0;
  MET_SizeOfType(type, &bytes);
  switch (type) {
    case MET_CHAR:
    case MET_CHAR_ARRAY: return RawType::int8;
    case MET_UCHAR:
    case MET_UCHAR_ARRAY: return RawType::uint8;
    case MET_SHORT:
    case MET_SHORT_ARRAY: return RawType::int16;
    case MET_USHORT:
    case MET_USHORT_ARRAY: return RawType::uint16;
    case MET_INT:
    case MET_INT_ARRAY: return RawType::int32;
    case MET_UINT:
    case MET_UINT_ARRAY: return RawType::uint32;
    case MET_LONG:
    case MET_LONG_ARRAY: return bytes == 8 ? RawType::int64 : RawType::int32;
    case MET_ULONG:
    case MET_ULONG_ARRAY: return bytes == 8 ? RawType::uint64 : RawType::uint32;
    case MET_LONG_LONG:
    case MET_LONG_LONG_ARRAY: return RawType::int64;
    case MET_ULONG_LONG:
    case MET_ULONG_LONG_ARRAY: return RawType::uint64;
    case MET_FLOAT:
    case MET_FLOAT_ARRAY: return RawType::float32;
    case MET_DOUBLE:
    case MET_DOUBLE_ARRAY: return RawType::float64;
    default: throw LoadError("has an ElementType that is no number; MET_UCHAR, MET_SHORT, MET_FLOAT … can be felt");
  }
}

/// Letter of the side from which an axis points, in MetaIO's form: +x of LPS points from the right, 'R'.
char letter_of(const Vec3& axis) {
  const double x = std::abs(axis.x), y = std::abs(axis.y), z = std::abs(axis.z);
  if (x >= y && x >= z) return axis.x > 0 ? 'R' : 'L';
  if (y >= z) return axis.y > 0 ? 'A' : 'P';
  return axis.z > 0 ? 'I' : 'S';
}

/// Word that a text repeats for each axis, "mm" of "mm mm mm"; else the text, trimmed.
std::string one_of_alike(std::string_view text) {
  std::istringstream words{std::string(text)};
  std::string first, word;
  words >> first;
  bool alike = true;
  while (words >> word) alike = alike && word == first;
  if (alike) return first;
  const std::size_t begin = text.find_first_not_of(" \t"), end = text.find_last_not_of(" \t\r");
  return std::string(text.substr(begin, end + 1 - begin));
}

/// Parts of a header that MetaIO drops.
struct HeaderText {
  double compressed_bytes = 0;  ///< CompressedDataSize; 0 if absent
  std::string distance_units;   ///< as written: MetaIO keeps only um, mm and cm
  std::string modality;         ///< "CT" of MET_MOD_CT; empty if not DICOM's
};

/// Reads a header's text, and refuses headers that crash MetaIO: it reads NDims numbers, even beyond its arrays, and reads on
/// from a line without '=' into the voxels.
HeaderText read_header(const std::string& path) {
  detail::InputStream file(path);
  std::array<char, 4096> line{};
  HeaderText header;
  while (file.getline(line.data(), line.size())) {
    const std::string_view text(line.data());
    if (text.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    const std::size_t sign = text.find_first_of("=:");
    if (sign == std::string_view::npos) throw LoadError("has a line without '=' in its header; get the whole file");
    const std::size_t begin = std::min(text.find_first_not_of(" \t"), sign);
    const std::string_view key = text.substr(begin, sign == begin ? 0 : text.find_last_not_of(" \t", sign - 1) + 1 - begin);
    if (key == "ElementDataFile") return header;  // for MetaIO, a longer key with this ending does not end the header
    const double value = std::strtod(line.data() + sign + 1,
                                     nullptr);  // parsed as in MetaIO, which accepts "1e308" as a number of dimensions
    if (key.find("NDims") != std::string_view::npos && !(value >= 1 && value < 5))
      throw LoadError("has no number of dimensions; give NDims, one to four");
    if (key.find("CompressedDataSize") != std::string_view::npos) header.compressed_bytes = value;
    if (key == "DistanceUnits") header.distance_units = one_of_alike(text.substr(sign + 1));
    for (const std::string_view modality : {"CT", "MR", "NM", "US"}) {
      if (key == "Modality" && one_of_alike(text.substr(sign + 1)) == "MET_MOD_" + std::string(modality))
        header.modality = modality;
    }
  }
  throw LoadError("has no ElementDataFile in its header; get the whole file");
}

class MetaImageSource : public Source {
 public:
  explicit MetaImageSource(const protocol::Request& request) : path_(request.path) {
    const HeaderText text = read_header(path_);
    header.length_unit = text.distance_units;
    header.modality = text.modality;
    if (!image_.Read(path_.c_str(), false)) {
      throw LoadError("cannot be read as MetaImage (" + take_library_error() + "); check its header");
    }
    header.format = "metaimage";
    takes.index_axes = true;
    header.default_unit = "mm";
    const int n = image_.NDims();
    if (n < 1 || n > 4) throw LoadError("has no number of dimensions; give NDims, one to four");
    list_files();
    double stored_bytes = 0;
    for (const std::string& file : files) stored_bytes += static_cast<double>(file_bytes(file));
    if (image_.CompressedData() && !(text.compressed_bytes >= 0 && text.compressed_bytes <= stored_bytes))
      throw LoadError("is shorter than its CompressedDataSize says; get the whole file");

    const std::uint64_t frame_values = read_voxels(request.as, std::min(n, 3));
    const std::int64_t frames = n == 4 ? image_.DimSize(3) : 1;
    if (frames < 1) throw LoadError("has no voxels along an axis; check DimSize");
    if (request.as == "vector" && raw_.components == 1) {
      if (frames != 3) throw LoadError("has no three frames to take as one vector; leave out as = \"vector\"");
      raw_.components = 3, raw_.component_stride = static_cast<std::int64_t>(frame_values);
    } else {
      frame_values_ = static_cast<std::int64_t>(frame_values);
      first_ = choose_frames(request, frames) * frame_values_;
    }

    protocol::FieldHeader field;
    field.name = raw_.components == 3 ? "vector" : "value";
    find_geometry(std::min(n, 3), field.grid);
    if (request.components_along == "index") turn_.axes = protocol::unit_axes(field.grid);
    field.scale = image_.ElementToIntensityFunctionSlope();
    field.offset = image_.ElementToIntensityFunctionOffset();
    keep(raw_, turn_, field, header.warnings);
    header.fields.push_back(field);

    direct_ = frames == 1 && kept_as_they_are(raw_, turn_, field);
    compressed_ = image_.CompressedData();
    if (compressed_) {
      for (const std::string& file : files) header.working_bytes += file_bytes(file);
    }
    if (__builtin_mul_overflow(frame_values * size_of(raw_.type), static_cast<std::uint64_t>(frames), &all_bytes_)) {
      throw LoadError("claims more voxels than can be counted; the header is damaged");
    }
    header_bytes_ = header_bytes(path_);
    check_header_size();
    note_bytes_behind_voxels();
    find_rows();
    if (!direct_ && !header.reads_rows) header.working_bytes += all_bytes_;
  }

  void read_rows(std::uint32_t, std::int64_t slice, std::int64_t first, std::int64_t count, std::byte* to) override {
    rows_->read(turn_, header.fields[0], slice, first, count, to);
  }

  void read(const std::vector<std::uint32_t>&, const std::vector<std::byte*>& to) override {
    if (header.reads_rows) return rows_->read_frames(turn_, header.fields[0], to, put);
    if (direct_) return load(to[0], all_bytes_);
    const std::unique_ptr<std::byte[]> all(new std::byte[all_bytes_]);
    load(all.get(), all_bytes_);
    for (std::size_t n = 0; n < to.size(); ++n) {
      const std::int64_t first = first_ + static_cast<std::int64_t>(n) * frame_values_;
      copy_voxels(all.get() + first * static_cast<std::int64_t>(size_of(raw_.type)), raw_, turn_, header.fields[0], to[n]);
    }
  }

  /// Checks the checksum of compressed data, which MetaIO ignores.
  void check_files() const override {
    if (!compressed_) return;
    if (files.size() > 1) {
      for (std::size_t f = 1; f < files.size(); ++f) check_compression(files[f], 0);
      return;
    }
    check_compression(path_, header_bytes_);
  }

 private:
  /// Rows can be read alone, and frames by several threads, from one file of plain numbers.
  void find_rows() {
    if (compressed_ || !image_.BinaryData() || files.size() > 2 || image_.HeaderSize() < 0) return;
    const auto said = static_cast<std::uint64_t>(image_.HeaderSize());
    RawVoxels stored = raw_;
    stored.swapped = image_.BinaryDataByteOrderMSB() == (std::endian::native == std::endian::little);
    rows_.emplace(
        files.back(),
        (said > 0 || files.size() > 1 ? said : header_bytes_) + static_cast<std::uint64_t>(first_) * size_of(raw_.type), stored,
        frames_read);
    header.reads_rows = rows_->can_read();
  }

  /// Header size of a single file: its voxels follow the line `ElementDataFile = LOCAL`; 0 without that line.
  static std::uint64_t header_bytes(const std::string& path) {
    detail::InputStream text(path);
    for (std::string line; std::getline(text, line);) {
      const std::size_t key = line.find_first_not_of(" \t");
      if (key != std::string::npos && line.compare(key, 15, "ElementDataFile") == 0 && text)
        return static_cast<std::uint64_t>(text.tellg());
    }
    return 0;
  }

  /// Takes type and size of the voxels from the header; returns the number of values in a frame.
  std::uint64_t read_voxels(std::string_view as, int axes) {
    raw_.type = raw_type(image_.ElementType());
    raw_.components = image_.ElementNumberOfChannels();
    if (raw_.components == 3 && raw_.type == RawType::uint8 && as != "vector") {
      throw LoadError("holds colours (3 channels of 8 bits); one number per voxel, or a vector of three, can be felt");
    }
    if (raw_.components != 1 && raw_.components != 3) {
      throw LoadError("has " + std::to_string(raw_.components) + " channels; one, or a vector of three, can be felt");
    }
    std::uint64_t frame_values = static_cast<std::uint64_t>(raw_.components);
    for (int a = 0; a < axes; ++a) {
      raw_.dims[static_cast<std::size_t>(a)] = image_.DimSize(a);
      if (image_.DimSize(a) < 1) throw LoadError("has no voxels along an axis; check DimSize");
      if (__builtin_mul_overflow(frame_values, static_cast<std::uint64_t>(image_.DimSize(a)), &frame_values)) {
        throw LoadError("claims more voxels than can be counted; the header is damaged");
      }
    }
    raw_.stride = {raw_.components, raw_.components * raw_.dims[0], raw_.components * raw_.dims[0] * raw_.dims[1]};
    return frame_values;
  }

  /// Refuses a HeaderSize that makes voxels of the header.
  void check_header_size() const {
    const int said = image_.HeaderSize();
    if (said < -1)
      throw LoadError("has HeaderSize = " + std::to_string(said) + "; give the bytes before the voxels, or -1: all but these");
    const bool within_itself =
        files.size() == 1 || std::ranges::any_of(files.begin() + 1, files.end(), [&](const std::string& file) {
          std::error_code none;
          return std::filesystem::equivalent(file, path_, none);
        });
    if (!within_itself || compressed_) return;
    const std::uint64_t from_end = file_bytes(path_) - std::min(all_bytes_, file_bytes(path_));
    const std::uint64_t first = said == -1 ? from_end : static_cast<std::uint64_t>(said);
    if ((said != 0 || files.size() > 1) && first < header_bytes_)
      throw LoadError("says that its voxels begin at byte " + std::to_string(first) +
                      ", which is within its header; correct "
                      "HeaderSize, or leave it out");
  }

  void note_bytes_behind_voxels() {
    if (!compressed_ && image_.BinaryData() && files.size() <= 2 && image_.HeaderSize() >= 0) {
      const auto said = static_cast<std::uint64_t>(image_.HeaderSize());
      const std::uint64_t first = said > 0 || files.size() > 1 ? said : header_bytes_;
      note_left_over(file_bytes(files.back()), first + all_bytes_, "HeaderSize", header.warnings);
    }
  }

  /// Decompresses the voxels of a single file. MetaIO reads them only with their compressed size in the header.
  void unpack_voxels(std::byte* to, std::uint64_t bytes) {
    const int skip = std::max(image_.HeaderSize(), 0);
    unpack(files.back(), files.size() > 1 ? static_cast<std::uint64_t>(skip) : header_bytes_, to, bytes);
    const std::size_t size = size_of(raw_.type);
    if (size == 1 || image_.BinaryDataByteOrderMSB() == (std::endian::native == std::endian::big)) return;
    for (std::byte* number = to; number + size <= to + bytes; number += size) std::reverse(number, number + size);
  }

  /// Reads numbers as text; MetaIO stops at unknown words, such as nan.
  void load_text(std::byte* to, std::uint64_t bytes) const {
    std::vector<std::string> parts(files.begin() + (files.size() > 1 ? 1 : 0), files.end());
    const std::uint64_t first = files.size() > 1 ? static_cast<std::uint64_t>(std::max(image_.HeaderSize(), 0)) : header_bytes_;
    protocol::with_type(raw_.type, [&](auto kind) {
      using Number = decltype(kind);
      auto* next = reinterpret_cast<Number*>(to);
      Number* const end = next + bytes / sizeof(Number);
      for (const std::string& part : parts) {
        detail::InputStream file(part);
        file.seekg(static_cast<std::streamoff>(first));
        constexpr int longest = 400;  // of a number; damaged files may lack blanks
        std::string word;
        for (; next != end && file >> std::setw(longest) >> word; ++next) {
          const std::optional<double> number = text_number(word);
          const bool fits = number && (std::is_floating_point_v<Number> ||
                                       (*number >= static_cast<double>(std::numeric_limits<Number>::lowest()) &&
                                        *number < std::ldexp(1.0, std::numeric_limits<Number>::digits)));
          if (!fits) throw LoadError("has a word among its numbers that is none of its type; correct it, or write them binary");
          *next = static_cast<Number>(*number);
        }
      }
      if (next != end) throw LoadError("is shorter than its header says; get the whole file");
    });
  }

  /// If data are too short, MetaIO leaves the rest of the memory unchanged, with a message on std::cerr or, for compressed
  /// data, none. So the memory's end is marked before, and the mark must have been overwritten.
  void load(std::byte* to, std::uint64_t bytes) {
    if (compressed_ && files.size() <= 2) return unpack_voxels(to, bytes);
    if (!compressed_ && !image_.BinaryData()) return load_text(to, bytes);
    static constexpr unsigned char mark[] = {0x9e, 0x37, 0x79, 0xb9, 0x7f, 0x4a, 0x7c, 0x15};
    const std::size_t marked = std::min<std::uint64_t>(bytes, sizeof mark);
    std::byte* const end = to + bytes - marked;
    std::memcpy(end, mark, marked);
    if (!image_.Read(path_.c_str(), true, to)) {
      throw LoadError("cannot be read as MetaImage (" + take_library_error() + "); check that the file is whole");
    }
    const std::size_t checked = std::min<std::size_t>(marked, 4);
    const bool untouched = std::memcmp(end + marked - checked, mark + marked - checked, checked) == 0;
    if (untouched || take_library_error().find("not read completely") != std::string::npos) {
      throw LoadError("is shorter than its header says; get the whole file");
    }
    image_.ElementByteOrderFix();
  }

  void list_files() {
    files.push_back(path_);
    const std::filesystem::path folder = std::filesystem::path(path_).parent_path();
    const std::string data = image_.ElementDataFileName();
    std::istringstream words(data);
    std::string name;
    words >> name;
    if (name == "LOCAL" || name == "local" || name == "Local") return;
    if (name.rfind("LIST", 0) == 0) {
      detail::InputStream text(path_);
      for (std::string line; std::getline(text, line) && line.rfind("ElementDataFile", 0) != 0;) {
      }
      while (text >> name && files.size() <= 4096) {
        if (std::ranges::any_of(name, [](char c) { return static_cast<unsigned char>(c) < 0x20; }))
          throw LoadError("lists a data file whose name has characters that none has; correct the list");
        files.push_back((folder / name).string());
      }
      if (files.size() == 1) throw LoadError("lists no data files; write their names behind LIST, a line each");
    } else if (name.find('%') != std::string::npos) {
      throw LoadError("names its data files by a pattern ('" + name + "'); list them, or join them into one");
    } else {
      files.push_back((folder / data).string());
    }
    for (std::size_t f = 1; f < files.size(); ++f) {  // MetaIO skips files that it cannot open
      check_data_file(path_, files[f]);
      if (file_bytes(files[f]) == 0) throw LoadError("needs its data file '" + files[f] + "', which is empty; put it back");
    }
  }

  void find_geometry(int n, GridGeometry& grid) {
    // Row a of TransformMatrix is the direction of axis a.
    Vec3 axis[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    double at[3] = {0, 0, 0};
    const int all = image_.NDims();
    const double* matrix = image_.TransformMatrix();
    for (int a = 0; a < n; ++a) {
      double d[3] = {0, 0, 0};
      for (int c = 0; c < n; ++c) d[c] = matrix[a * all + c];
      axis[a] = {d[0], d[1], d[2]};
      at[a] = image_.Offset()[a];
    }
    if (n == 2) axis[2] = cross(axis[0], axis[1]);
    double length[3] = {1, 1, 1};
    for (int a = 0; a < n; ++a) length[a] = image_.ElementSpacing(a);
    for (int a = n; a < 3; ++a) length[a] = length[0];
    grid.index_to_world_m = transposed(Mat3{{length[0] * axis[0], length[1] * axis[1], length[2] * axis[2]}});
    grid.origin_m = {at[0], at[1], at[2]};

    // ITK treats every MetaImage as LPS; only AnatomicalOrientation marks it as medical.
    const std::string letters = image_.AnatomicalOrientationAcronym();
    if (n != 3 || letters.size() < 3 || letters.find('?') != std::string::npos) return;
    header.medical_frame = true;
    const std::string found = {letter_of(axis[0]), letter_of(axis[1]), letter_of(axis[2])};
    if (letters.substr(0, 3) != found) {
      header.warnings.push_back("AnatomicalOrientation '" + letters.substr(0, 3) + "' does not agree with TransformMatrix ('" +
                                found + "'): the matrix is used");
    }
  }

  std::string path_;
  MetaImage image_;
  RawVoxels raw_;
  VectorTurn turn_;
  std::optional<RawRows> rows_;
  std::int64_t first_ = 0;         ///< index of the first value of the first frame to read
  std::int64_t frame_values_ = 0;  ///< per frame
  std::uint64_t all_bytes_ = 0;    ///< of all frames
  std::uint64_t header_bytes_ = 0;
  bool compressed_ = false;  ///< from the header: reading temporarily clears it in image_
  bool direct_ = false;      ///< the library reads directly into the caller's memory
};

}  // namespace

std::unique_ptr<Source> open_metaimage(const protocol::Request& request) { return std::make_unique<MetaImageSource>(request); }

}  // namespace palpa::reader
