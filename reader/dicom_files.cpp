// DICOM files by vtk-dicom. GDCM is called directly for compressed images: vtk-dicom does not check their decoded size.
#include "dicom_files.h"

#include <gdcmImageReader.h>
#include <gdcmTrace.h>
#include <vtkDICOMDictionary.h>
#include <vtkDICOMItem.h>
#include <vtkDICOMMetaData.h>
#include <vtkDICOMParser.h>
#include <vtkDICOMReader.h>
#include <vtkDICOMTagPath.h>
#include <vtkDICOMUtilities.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkSmartPointer.h>
#include <vtkTypeInt64Array.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <set>
#include <string_view>

#include "compression.h"
#include "dicom_words.h"
#include "messages.h"
#include "palpa/base/input_file.h"
#include "sandbox.h"
#include "source.h"

namespace palpa::reader {
namespace {

// Files of a folder. More: reading a wrong folder, such as a whole archive, takes long; fewer: large series are refused.
constexpr std::size_t most_files = 100'000;

/// Elements to read from a header; all others are skipped.
const std::pair<DC::EnumType, vtkDICOMVR> wanted[] = {
    {DC::ImageType, vtkDICOMVR::CS},
    {DC::SOPInstanceUID, vtkDICOMVR::UI},
    {DC::Modality, vtkDICOMVR::CS},
    {DC::EchoTime, vtkDICOMVR::DS},
    {DC::SliceThickness, vtkDICOMVR::DS},
    {DC::SpacingBetweenSlices, vtkDICOMVR::DS},
    {DC::TriggerTime, vtkDICOMVR::DS},
    {DC::ImagerPixelSpacing, vtkDICOMVR::DS},
    {DC::SeriesInstanceUID, vtkDICOMVR::UI},
    {DC::SeriesNumber, vtkDICOMVR::IS},
    {DC::SeriesDescription, vtkDICOMVR::LO},
    {DC::InstanceNumber, vtkDICOMVR::IS},
    {DC::ImagePositionPatient, vtkDICOMVR::DS},
    {DC::ImageOrientationPatient, vtkDICOMVR::DS},
    {DC::FrameOfReferenceUID, vtkDICOMVR::UI},
    {DC::TemporalPositionIdentifier, vtkDICOMVR::IS},
    {DC::SamplesPerPixel, vtkDICOMVR::US},
    {DC::PhotometricInterpretation, vtkDICOMVR::CS},
    {DC::NumberOfFrames, vtkDICOMVR::IS},
    {DC::Rows, vtkDICOMVR::US},
    {DC::Columns, vtkDICOMVR::US},
    {DC::PixelSpacing, vtkDICOMVR::DS},
    {DC::BitsAllocated, vtkDICOMVR::US},
    {DC::BitsStored, vtkDICOMVR::US},
    {DC::HighBit, vtkDICOMVR::US},
    {DC::PixelRepresentation, vtkDICOMVR::US},
    {DC::PixelPaddingValue, vtkDICOMVR::SS},
    {DC::PixelPaddingRangeLimit, vtkDICOMVR::SS},
    {DC::RescaleIntercept, vtkDICOMVR::DS},
    {DC::RescaleSlope, vtkDICOMVR::DS},
    {DC::ModalityLUTSequence, vtkDICOMVR::SQ},
    {DC::DetectorInformationSequence, vtkDICOMVR::SQ},
    {DC::GridFrameOffsetVector, vtkDICOMVR::DS},
    {DC::DoseGridScaling, vtkDICOMVR::DS},
    {DC::DoseUnits, vtkDICOMVR::CS},
    {DC::SharedFunctionalGroupsSequence, vtkDICOMVR::SQ},
    {DC::PerFrameFunctionalGroupsSequence, vtkDICOMVR::SQ},
    {DC::BodyPartExamined, vtkDICOMVR::CS},
    {DC::ProtocolName, vtkDICOMVR::LO},
    {DC::Manufacturer, vtkDICOMVR::LO},
    {DC::ManufacturerModelName, vtkDICOMVR::LO},
    {DC::ContrastBolusAgent, vtkDICOMVR::LO},
    {DC::ScanningSequence, vtkDICOMVR::CS},
    {DC::SequenceVariant, vtkDICOMVR::CS},
    {DC::MRAcquisitionType, vtkDICOMVR::CS},
    {DC::SequenceName, vtkDICOMVR::SH},
    {DC::AngioFlag, vtkDICOMVR::CS},
    {DC::KVP, vtkDICOMVR::DS},
    {DC::XRayTubeCurrent, vtkDICOMVR::IS},
    {DC::ConvolutionKernel, vtkDICOMVR::SH},
    {DC::RepetitionTime, vtkDICOMVR::DS},
    {DC::InversionTime, vtkDICOMVR::DS},
    {DC::FlipAngle, vtkDICOMVR::DS},
    {DC::MagneticFieldStrength, vtkDICOMVR::DS},
    {DC::DiffusionBValue, vtkDICOMVR::FD},
    {DC::VelocityEncodingMaximumValue, vtkDICOMVR::FD},
    {DC::SegmentationType, vtkDICOMVR::CS},
    {DC::SegmentSequence, vtkDICOMVR::SQ},
    {DC::PixelData, vtkDICOMVR::OW},
};

vtkDICOMItem query() {
  vtkDICOMItem query;
  add_traits_to(query);
  for (const auto& [tag, type] : wanted) query.Set(tag, vtkDICOMValue(type));
  return query;
}

RawType raw_type(int bits_allocated, bool negative) {
  switch (bits_allocated) {
    case 1:
    case 8: return negative ? RawType::int8 : RawType::uint8;
    case 12:
    case 16: return negative ? RawType::int16 : RawType::uint16;
    case 32: return negative ? RawType::int32 : RawType::uint32;
    default: throw LoadError("has numbers of " + std::to_string(bits_allocated) + " bits; 8, 16 or 32 can be read");
  }
}

int vtk_type(RawType type) {
  switch (type) {
    case RawType::int8: return VTK_SIGNED_CHAR;
    case RawType::uint8: return VTK_UNSIGNED_CHAR;
    case RawType::int16: return VTK_SHORT;
    case RawType::uint16: return VTK_UNSIGNED_SHORT;
    case RawType::int32: return VTK_INT;
    default: return VTK_UNSIGNED_INT;
  }
}

/// True if the elements of the meta header (group 2, always little endian with types) are undamaged, or the file has none:
/// vtk-dicom and GDCM crash on some damage.
/// \param end  [bytes] its end if undamaged; 0 if absent
bool has_whole_meta_header(const std::string& name, std::size_t& end) {
  // A longer meta header, or element of it, is damaged: real headers have some hundred bytes. More: damage is read for longer.
  constexpr std::size_t most_bytes = 65536, start = 132;
  detail::InputStream file(name);
  char bytes[start] = {};
  end = 0;
  if (!file.read(bytes, start) || std::string_view(bytes + 128, 4) != "DICM") return true;
  const auto number = [&](std::size_t at, std::size_t size) {
    std::uint32_t value = 0;
    for (std::size_t b = size; b-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + b]);
    return value;
  };
  static const std::set<std::string_view> with_long_sizes{"OB", "OW", "OF", "OD", "OL", "OV", "SQ", "UN", "UC", "UR", "UT"};
  std::uint32_t before = 0;
  for (std::size_t at = start; at < most_bytes && file.read(bytes, 8); ++before) {
    end = at;
    if (number(0, 2) != 2) return before > 0 || number(0, 2) == 8;  // some programs omit it after the mark
    const std::uint32_t element = number(2, 2);
    const std::string_view type(bytes + 4, 2);
    const bool letters = std::ranges::all_of(type, [](char c) { return c >= 'A' && c <= 'Z'; });
    const bool is_long = with_long_sizes.count(type) > 0;
    if (!letters || (element == 0 && (before > 0 || type != "UL"))) return false;
    if (is_long && !file.read(bytes + 8, 4)) return false;
    const std::size_t size = is_long ? number(8, 4) : number(6, 2);
    if (size > most_bytes) return false;
    file.ignore(static_cast<std::streamsize>(size));
    at += (is_long ? 12 : 8) + size;
  }
  return false;
}

/// True if JPEG 2000 images have the size of a slice: GDCM allocates any size that they claim.
/// \param stored  items of a compressed image, searched for JPEG 2000 marks only at their start: later these bytes may be
/// chance
bool has_size_of(const Slice& slice, std::string_view stored) {
  constexpr std::string_view item("\xfe\xff\x00\xe0", 4), image("\xff\x4f\xff\x51", 4);
  const auto byte = [&](std::size_t at) { return std::int64_t{static_cast<unsigned char>(stored[at])}; };
  const auto big = [&](std::size_t at) { return byte(at) << 24 | byte(at + 1) << 16 | byte(at + 2) << 8 | byte(at + 3); };
  const auto little = [&](std::size_t at) { return byte(at + 3) << 24 | byte(at + 2) << 16 | byte(at + 1) << 8 | byte(at); };
  for (std::size_t at = 0; at + 8 <= stored.size() && stored.substr(at, 4) == item;
       at += 8 + static_cast<std::size_t>(little(at + 4))) {
    const std::size_t begin = at + 8;
    if (begin + 24 > stored.size() || stored.substr(begin, 4) != image) continue;
    const std::int64_t columns = big(begin + 8) - big(begin + 16), rows = big(begin + 12) - big(begin + 20);
    if (columns != slice.size[0] || rows != slice.size[1]) return false;
  }
  return true;
}

bool is_marked(const std::string& name) {
  detail::InputStream file(name);
  char bytes[132] = {};
  return file.read(bytes, sizeof bytes) && std::string_view(bytes + 128, 4) == "DICM";
}

/// True for a DICOM file: by its mark or, without the preamble, by a first element of group 2 or 8, with or without its type.
bool is_dicom(const std::string& name) {
  if (vtkDICOMUtilities::IsDICOMFile(name.c_str()) || is_marked(name)) return true;
  static const std::set<std::string_view> types{"AE", "AS", "AT", "CS", "DA", "DS", "DT", "IS", "LO",
                                                "OB", "PN", "SH", "SQ", "ST", "TM", "UI", "UL", "US"};
  detail::InputStream file(name);
  char bytes[8] = {};
  if (!file.read(bytes, sizeof bytes)) return false;
  const bool little = (bytes[0] == 2 || bytes[0] == 8) && bytes[1] == 0 && bytes[3] == 0;
  const bool big = (bytes[1] == 2 || bytes[1] == 8) && bytes[0] == 0 && bytes[2] == 0;
  return (little || big) && types.count(std::string_view(bytes + 4, 2)) > 0;
}

/// DICOM files of a folder and its subfolders, by name; or one file.
std::vector<std::string> files_in(const std::string& path) {
  if (!std::filesystem::is_directory(path)) {
    if (is_dicom(path)) return {path};
    throw LoadError("has no format that is known; DICOM, NRRD, MetaImage, NIfTI, VTK, PLOT3D, OpenFOAM and HDF5 can be read");
  }
  std::vector<std::string> files;
  std::error_code problem;
  for (std::filesystem::recursive_directory_iterator entry(path, problem), end; !problem && entry != end;
       entry.increment(problem)) {
    std::error_code gone;
    if (entry->is_symlink(gone)) check_within_cage(entry->path().string());
    if (!entry->is_regular_file(gone) || !is_dicom(entry->path().string())) continue;
    if (files.size() >= most_files) throw LoadError("is a folder of more than 100000 DICOM files; give one series of them");
    files.push_back(entry->path().string());
  }
  if (problem) throw LoadError("is a folder that cannot be read: " + problem.message() + "; check its permissions");
  if (files.empty()) throw LoadError("is a folder without DICOM files; give a file, or a folder of a DICOM series");
  std::sort(files.begin(), files.end());
  return files;
}

bool all_numbers(const vtkDICOMValue& value, std::size_t count, double* to) {
  if (value.GetNumberOfValues() != count) return false;
  value.GetValues(to, count);
  return std::all_of(to, to + count, [](double n) { return std::isfinite(n); });
}

}  // namespace

/// vtkDICOMReader that scans each file separately: the original gives up all files if one is damaged.
class DicomFiles::Reader : public vtkDICOMReader {
 public:
  static Reader* New();
  vtkTypeMacro(Reader, vtkDICOMReader);

  /// Reads the headers of files. Returns for each file whether it holds an image.
  /// \param unpacked  path of a file's decompressed content
  std::vector<bool> scan(const std::vector<std::string>& names,
                         const std::function<std::string(const std::string&)>& unpacked) {
    MetaData->Initialize();
    MetaData->SetNumberOfInstances(static_cast<int>(names.size()));
    FileOffsetArray = vtkTypeInt64Array::New();
    FileOffsetArray->SetNumberOfComponents(2);
    FileOffsetArray->SetNumberOfTuples(static_cast<vtkIdType>(names.size()));
    const vtkDICOMItem wanted = query();
    std::vector<bool> is_image;
    for (std::size_t file = 0; file < names.size(); ++file) {
      vtkNew<vtkDICOMParser> parser;  // one per file, because a parser keeps its first error
      parser->SetMetaData(MetaData);
      parser->SetQueryItem(wanted);
      parser->SetIndex(static_cast<int>(file));
      std::size_t end = 0;
      bool whole = has_whole_meta_header(names[file], end);
      try {
        parser->SetFileName(unpacked(names[file]).c_str());
      } catch (const LoadError& error) {
        problems[static_cast<int>(file)] = error.what(), whole = false;
      }
      if (whole) parser->Update();
      is_image.push_back(whole && !library_complained() && parser->GetErrorCode() == 0 && parser->GetPixelDataFound());
      take_library_error();
      const vtkTypeInt64 place[2] = {parser->GetFileOffset(), parser->GetFileSize()};
      FileOffsetArray->SetTypedTuple(static_cast<vtkIdType>(file), place);
    }
    return is_image;
  }

  std::map<int, std::string> problems;  ///< of files that cannot be decompressed

  const vtkDICOMValue& get(int file, int frame, DC::EnumType tag) { return MetaData->Get(file, frame, tag); }
  /// Element of an image; nuclear medicine stores the position of the first frame with its detector.
  const vtkDICOMValue& get_of_detector(int file, int frame, DC::EnumType tag) {
    const vtkDICOMValue& of_frames = MetaData->Get(file, DC::DetectorVector);
    const auto n = static_cast<std::size_t>(frame);
    const int detector = n < of_frames.GetNumberOfValues() ? std::max(1, of_frames.GetInt(n)) : 1;
    return MetaData->Get(file, vtkDICOMTagPath(DC::DetectorInformationSequence, static_cast<unsigned>(detector - 1), tag));
  }
  std::string text(int file, DC::EnumType tag) { return MetaData->Get(file, tag).AsString(); }
  /// Number of an element; `missing` if it is absent or not finite.
  double number(int file, int frame, DC::EnumType tag, double missing) {
    const vtkDICOMValue& value = get(file, frame, tag);
    const double number = value.GetNumberOfValues() > 0 ? value.GetDouble(0) : missing;
    return std::isfinite(number) ? number : missing;
  }
  int frames(int file) { return std::max(1, MetaData->Get(file, DC::NumberOfFrames).AsInt()); }

  /// Bytes from the beginning of the voxels to the end of the file.
  std::uint64_t stored_bytes(int file) {
    vtkTypeInt64 place[2];
    FileOffsetArray->GetTypedTuple(file, place);
    return static_cast<std::uint64_t>(std::max<vtkTypeInt64>(place[1] - place[0], 0));
  }

  bool compressed(int file) {
    static const std::set<std::string> plain{
        "", "1.2.840.10008.1.2", "1.2.840.10008.1.20", "1.2.840.10008.1.2.1", "1.2.840.10008.1.2.2", "1.2.840.113619.5.2"};
    return plain.count(text(file, DC::TransferSyntaxUID)) == 0;
  }

  void load_plain(const std::string& name, const Slice& slice, unsigned char* to, std::size_t bytes) {
    DataScalarType = FileScalarType = vtk_type(slice.type);
    if (!ReadFileNative(name.c_str(), slice.file, to, static_cast<vtkIdType>(bytes)) || library_complained()) {
      throw LoadError("cannot be read (" + take_library_error() + "); get the whole file");
    }
  }

  /// Reads the value scale and the padding of an image.
  void find_values(Slice& slice, int allocated) {
    const int file = slice.file, frame = slice.frame;
    slice.slope = number(file, frame, DC::RescaleSlope, number(file, frame, DC::DoseGridScaling, 1));
    slice.intercept = number(file, frame, DC::RescaleIntercept, 0);
    if (slice.slope == 0) slice.slope = 1;
    slice.padding.reset();
    if (!get(file, frame, DC::PixelPaddingValue).IsValid()) return;
    // The padding's type is often not the pixels' type but of other signedness: its bits count.
    const auto as_pixel = [&](double value) {
      const double turn = std::ldexp(1.0, allocated);
      if (slice.negative() && value >= turn / 2) return value - turn;
      return !slice.negative() && value < 0 ? value + turn : value;
    };
    const double value = as_pixel(number(file, frame, DC::PixelPaddingValue, 0));
    const double limit = get(file, frame, DC::PixelPaddingRangeLimit).IsValid()
                             ? as_pixel(number(file, frame, DC::PixelPaddingRangeLimit, 0))
                             : value;
    slice.padding = {std::min(value, limit), std::max(value, limit)};
  }

  /// Reads the attributes that distinguish an image from others at its position.
  void find_traits(Slice& slice, int frames) {
    slice.number = number(slice.file, slice.frame, DC::InstanceNumber, 0);
    slice.traits = traits_of(*MetaData, slice.file, slice.frame, frames);
    slice.rest = frames > 1 ? rest_of(*MetaData, slice.file, slice.frame) : std::vector<std::string>();
  }

  /// Distance along the normal from the file's first image [mm], for frames without their own positions.
  double offset_mm(const Slice& slice, int frames) {
    const auto n = static_cast<std::size_t>(slice.frame);
    const auto said = [&](DC::EnumType tag) -> const vtkDICOMValue& { return MetaData->Get(slice.file, tag); };
    const auto of_each = [&](DC::EnumType tag) { return said(tag).GetNumberOfValues() == static_cast<std::size_t>(frames); };
    if (of_each(DC::GridFrameOffsetVector)) {
      return said(DC::GridFrameOffsetVector).GetDouble(n) - said(DC::GridFrameOffsetVector).GetDouble(0);
    }
    const double between_mm = number(slice.file, 0, DC::SpacingBetweenSlices, 0);
    // Nuclear medicine counts slices beside energies, times and views; frames with other counters only are no slices.
    if (of_each(DC::SliceVector)) return between_mm * (said(DC::SliceVector).GetDouble(n) - said(DC::SliceVector).GetDouble(0));
    const bool others = std::ranges::any_of(slice.traits, [](const Trait& t) { return counts_frames(t.attribute); });
    return others ? 0.0 : between_mm * static_cast<double>(n);
  }

  /// Reads the position of an image. A frame without its own position has that of its file.
  void find_place(Slice& slice) {
    const int file = slice.file, frame = slice.frame;
    double rows_columns_mm[2], position[3], directions[6];
    slice.spaced = (all_numbers(get(file, frame, DC::PixelSpacing), 2, rows_columns_mm) ||
                    all_numbers(get(file, frame, DC::ImagerPixelSpacing), 2, rows_columns_mm)) &&
                   rows_columns_mm[0] > 0 && rows_columns_mm[1] > 0;
    if (slice.spaced) slice.spacing_mm = {rows_columns_mm[1], rows_columns_mm[0]};  // the first is from row to row
    const double between_mm = std::abs(number(file, frame, DC::SpacingBetweenSlices, 0));
    slice.thickness_mm = between_mm > 0 ? between_mm : number(file, frame, DC::SliceThickness, 0);
    slice.space = text(file, DC::FrameOfReferenceUID);
    const bool found = (all_numbers(get(file, frame, DC::ImagePositionPatient), 3, position) &&
                        all_numbers(get(file, frame, DC::ImageOrientationPatient), 6, directions)) ||
                       (all_numbers(get_of_detector(file, frame, DC::ImagePositionPatient), 3, position) &&
                        all_numbers(get_of_detector(file, frame, DC::ImageOrientationPatient), 6, directions));
    if (!found) return;
    const Vec3 right{directions[0], directions[1], directions[2]}, down{directions[3], directions[4], directions[5]};
    if (std::abs(norm(right) - 1) > 0.01 || std::abs(norm(down) - 1) > 0.01 || std::abs(dot(right, down)) > 0.01) return;
    slice.placed = true;
    slice.position_mm = {position[0], position[1], position[2]};
    slice.right = normalized(right), slice.down = normalized(down);
  }

  using vtkDICOMReader::MaskBits;
};
vtkStandardNewMacro(DicomFiles::Reader);

void DicomFiles::Delete::operator()(Reader* reader) const { reader->Delete(); }

DicomFiles::DicomFiles(const std::string& path, int memory, std::uint64_t most_bytes)
    : reader_(Reader::New()), names_(files_in(path)), memory_(memory), most_bytes_(most_bytes) {
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  const std::vector<bool> is_image = reader_->scan(names_, [this](const std::string& name) { return unpacked(name); });
  for (std::size_t file = 0; file < names_.size(); ++file) {
    try {
      if (const auto why = reader_->problems.find(static_cast<int>(file)); why != reader_->problems.end())
        throw LoadError(why->second);
      if (!is_image[file]) {
        ++damaged_;
        continue;
      }
      add_slices(static_cast<int>(file));
    } catch (const LoadError& error) {
      ++refused_[error.what()];
    }
  }
}

/// Path of the file or, if its elements are deflated, of a memory file with them decompressed, valid until the next call.
/// Throws LoadError.
std::string DicomFiles::unpacked(const std::string& name) const {
  constexpr std::string_view deflated = "1.2.840.10008.1.2.1.99", plain = "1.2.840.10008.1.2.1";
  std::size_t end = 0;
  if (!has_whole_meta_header(name, end) || end == 0) return name;
  std::string beginning(end, '\0');
  detail::InputStream file(name);
  file.read(beginning.data(), static_cast<std::streamsize>(end));
  const std::size_t syntax = beginning.find(deflated);
  if (syntax == std::string::npos) return name;
  std::fill_n(beginning.begin() + static_cast<std::ptrdiff_t>(syntax), deflated.size(), '\0');
  beginning.replace(syntax, plain.size(), plain);
  unpack_rest(name, beginning, memory_, most_bytes_);
  return unpacked_folder + std::to_string(memory_);
}

/// Adds the images of a file. Throws LoadError if they are unusable.
void DicomFiles::add_slices(int file) {
  Reader& r = *reader_;
  if (r.number(file, 0, DC::SamplesPerPixel, 1) != 1 || r.text(file, DC::PhotometricInterpretation) == "PALETTE COLOR") {
    throw LoadError("holds colours (RGB), which have no one value to feel; export the values that they were made from");
  }
  if (r.text(file, DC::ImageType).find("MOSAIC") != std::string::npos) {
    throw LoadError("holds mosaics, many slices as tiles of one image; convert it to NIfTI with dcm2niix");
  }
  if (r.get(file, 0, DC::ModalityLUTSequence).IsValid()) {
    throw LoadError("has a table of values (Modality LUT), which is not read; export it with slope and intercept");
  }
  Slice slice;
  slice.file = file;
  slice.series = r.text(file, DC::SeriesInstanceUID);
  slice.instance = r.text(file, DC::SOPInstanceUID);
  slice.size = {r.get(file, 0, DC::Columns).AsInt(), r.get(file, 0, DC::Rows).AsInt()};
  const int allocated = r.get(file, 0, DC::BitsAllocated).AsInt();
  slice.type = raw_type(allocated, r.number(file, 0, DC::PixelRepresentation, 0) != 0);
  slice.bits = static_cast<int>(r.number(file, 0, DC::BitsStored, allocated));
  if (slice.bits < 1 || slice.bits > allocated) slice.bits = allocated;
  const double high = r.number(file, 0, DC::HighBit, slice.bits - 1);
  if (!(high >= slice.bits - 1 && high < allocated)) {
    throw LoadError("has numbers whose highest bit (HighBit) does not fit to BitsStored; correct its header");
  }
  slice.first_bit = static_cast<int>(high) + 1 - slice.bits;
  if (slice.first_bit > 0 && r.compressed(file)) {
    throw LoadError(
        "has compressed numbers that do not begin at bit 0 (HighBit), which are not read; unpack it: gdcmconv --raw");
  }
  const int frames = r.frames(file);
  const auto stored = static_cast<double>(r.stored_bytes(file));
  const double bits = static_cast<double>(allocated) * static_cast<double>(slice.pixels()) * frames;
  if (slice.size[0] < 1 || slice.size[1] < 1 || (r.compressed(file) ? stored < 8.0 * frames : 8.0 * stored < bits)) {
    throw LoadError("is shorter than its header says; get the whole file");
  }
  const bool own_places = frames == 1 || r.get(file, 0, DC::PerFrameFunctionalGroupsSequence).IsValid();
  slice.sparse = r.text(file, DC::Modality) == "SEG";
  for (; slice.frame < frames; ++slice.frame) {
    r.find_values(slice, allocated);
    r.find_traits(slice, frames);
    r.find_place(slice);
    if (!own_places) slice.position_mm += r.offset_mm(slice, frames) * normalized(cross(slice.right, slice.down));
    slices_.push_back(slice);
  }
}

std::string DicomFiles::modality(const Slice& slice) const { return reader_->text(slice.file, DC::Modality); }

std::string DicomFiles::unit(const Slice& slice) const {
  static const std::map<std::string, std::string> units{
      {"HU", "HU"},   {"HU_MOD", "HU"},  {"MGML", "mg/ml"},  {"PCT", "%"},    {"ED", "10²³/ml"}, {"EDW", "N/N_water"},
      {"Z_EFF", "Z"}, {"BQML", "Bq/ml"}, {"CNTS", "counts"}, {"GML", "g/ml"}, {"GY", "Gy"}};
  bool said = false;
  for (const DC::EnumType tag : {DC::Units, DC::RescaleType, DC::DoseUnits}) {
    const vtkDICOMValue& value = reader_->get(slice.file, slice.frame, tag);
    const std::string code = value.GetNumberOfValues() > 0 ? value.GetString(0) : std::string();
    if (const auto known = units.find(code); known != units.end()) return known->second;
    said = said || !code.empty();
  }
  return !said && modality(slice) == "CT" ? "HU" : "";
}

/// Acquisition, from the header of one slice. Stacks that vary a quantity on purpose have other values in other slices.
std::vector<ScanFact> DicomFiles::scan(const Slice& slice) const {
  Reader& r = *reader_;
  std::vector<ScanFact> facts;
  const auto text = [&](DC::EnumType tag) { return r.text(slice.file, tag); };
  const auto add_words = [&](ScanFactKind kind, const std::string& words) {
    if (!words.empty()) facts.push_back({kind, words});
  };
  const auto add_number = [&](ScanFactKind kind, DC::EnumType tag, double least) {
    const double number = r.number(slice.file, slice.frame, tag, -1.0);
    if (number >= least) facts.push_back({kind, {}, number});
  };
  add_words(ScanFactKind::body_part, format_protocol(text(DC::BodyPartExamined)));
  add_words(ScanFactKind::protocol, format_protocol(text(DC::ProtocolName)));
  add_words(ScanFactKind::image, format_image_type(text(DC::ImageType)));
  if (text(DC::AngioFlag) == "Y") facts.push_back({ScanFactKind::angiogram, "yes"});
  if (names_contrast_agent(text(DC::ContrastBolusAgent))) facts.push_back({ScanFactKind::contrast, "yes"});
  add_words(ScanFactKind::scanner, format_scanner(text(DC::Manufacturer), text(DC::ManufacturerModelName)));
  add_words(ScanFactKind::kernel, format_kernel(text(DC::ConvolutionKernel)));
  add_words(ScanFactKind::sequence, format_sequence(text(DC::ScanningSequence), text(DC::SequenceVariant),
                                                    text(DC::MRAcquisitionType), text(DC::SequenceName)));
  constexpr double above_zero = 1e-6;  // in each fact's own unit: 0, and -1 for a missing number, are no facts
  add_number(ScanFactKind::slice_thickness_mm, DC::SliceThickness, above_zero);
  add_number(ScanFactKind::tube_voltage_kv, DC::KVP, above_zero);
  add_number(ScanFactKind::tube_current_ma, DC::XRayTubeCurrent, above_zero);
  add_number(ScanFactKind::field_strength_t, DC::MagneticFieldStrength, above_zero);
  add_number(ScanFactKind::repetition_time_ms, DC::RepetitionTime, above_zero);
  add_number(ScanFactKind::echo_time_ms, DC::EchoTime, above_zero);
  add_number(ScanFactKind::inversion_time_ms, DC::InversionTime, above_zero);
  add_number(ScanFactKind::flip_angle_deg, DC::FlipAngle, above_zero);
  add_number(ScanFactKind::b_value_s_per_mm2, DC::DiffusionBValue, 0.0);
  add_number(ScanFactKind::velocity_range_cm_per_s, DC::VelocityEncodingMaximumValue, above_zero);
  return facts;
}

std::string DicomFiles::series_words(const Slice& slice) const {
  std::string words = modality(slice);
  for (const std::string& more :
       {reader_->text(slice.file, DC::SeriesNumber), format_protocol(reader_->text(slice.file, DC::SeriesDescription))})
    words += (words.empty() || more.empty() ? "" : " ") + more;
  return words;
}

std::vector<FilePart> DicomFiles::segments(const Slice& slice) const {
  std::vector<FilePart> segments;
  if (modality(slice) != "SEG" || reader_->text(slice.file, DC::SegmentationType) == "FRACTIONAL") return segments;
  const vtkDICOMValue& items = reader_->get(slice.file, 0, DC::SegmentSequence);
  for (std::size_t n = 0; n < items.GetNumberOfValues(); ++n) {
    const vtkDICOMItem& item = items.GetItem(n);
    segments.push_back({item.Get(DC::SegmentLabel).AsUTF8String(), {}, item.Get(DC::SegmentNumber).AsInt()});
  }
  return segments;
}

bool DicomFiles::is_binary(const Slice& slice) const { return reader_->text(slice.file, DC::SegmentationType) == "BINARY"; }

std::uint64_t DicomFiles::voxel_bytes(const Slice& slice) const {
  return static_cast<std::uint64_t>(reader_->frames(slice.file)) * slice.pixels() * size_of(slice.type);
}

std::uint64_t DicomFiles::stored_bytes(const Slice& slice) const { return reader_->stored_bytes(slice.file); }

void DicomFiles::load(const Slice& slice, bool masked, std::byte* to) {
  const std::uint64_t bytes = voxel_bytes(slice);
  auto* const voxels = reinterpret_cast<unsigned char*>(to);
  if (reader_->compressed(slice.file)) {
    std::string stored(stored_bytes(slice), '\0');
    detail::InputStream file(name(slice));
    file.seekg(-static_cast<std::streamoff>(stored.size()), std::ios::end);
    file.read(stored.data(), static_cast<std::streamsize>(stored.size()));
    if (!has_size_of(slice, stored)) throw LoadError("holds an image of another size than its header says; get the file again");
    gdcm::ImageReader decoder;
    decoder.SetFileName(name(slice).c_str());
    if (!decoder.Read()) throw LoadError("cannot be decompressed; export it uncompressed, or get the file again");
    if (decoder.GetImage().GetBufferLength() != bytes || !decoder.GetImage().GetBuffer(reinterpret_cast<char*>(to))) {
      throw LoadError("cannot be decompressed to the size that its header says; get the file again");
    }
  } else {
    reader_->load_plain(unpacked(name(slice)), slice, voxels, bytes);
  }
  const auto size = static_cast<int>(size_of(slice.type));
  if (slice.first_bit > 0) {
    protocol::with_type(slice.type, [&](auto number) {
      using Number = decltype(number);
      auto* const numbers = reinterpret_cast<Number*>(to);
      for (std::uint64_t n = 0; n < bytes / sizeof(Number); ++n) {
        numbers[n] = static_cast<Number>(static_cast<std::int64_t>(numbers[n]) >> slice.first_bit);
      }
    });
  }
  if (masked && slice.bits < 8 * size) {
    reader_->MaskBits(voxels, static_cast<vtkIdType>(bytes), size, slice.bits, slice.negative() ? 1 : 0);
  }
}

}  // namespace palpa::reader
