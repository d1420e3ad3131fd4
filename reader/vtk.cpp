// VTK's own formats: XML in one file or in pieces, and legacy.
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataArraySelection.h>
#include <vtkDataObject.h>
#include <vtkDataSet.h>
#include <vtkDataSetReader.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkRectilinearGrid.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLImageDataReader.h>
#include <vtkXMLPImageDataReader.h>
#include <vtkXMLPRectilinearGridReader.h>
#include <vtkXMLPStructuredGridReader.h>
#include <vtkXMLPUnstructuredGridReader.h>
#include <vtkXMLRectilinearGridReader.h>
#include <vtkXMLStructuredGridReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <sstream>
#include <string_view>

#include "data_file.h"
#include "first_bytes.h"
#include "library_words.h"
#include "messages.h"
#include "serve.h"
#include "source.h"
#include "stand_ins.h"
#include "vtk_blocks.h"
#include "vtk_data.h"

namespace palpa::reader {
namespace {

/// Throws LoadError if VTK has reported an error.
void check(vtkAlgorithm& reader, const char* as) {
  if (library_complained() || reader.GetErrorCode() != 0) {
    throw LoadError(std::string("cannot be read as ") + as + " (" + take_library_error() + "); check that the file is whole");
  }
}

/// Refuses claims that the file cannot hold: VTK makes as many components as an element claims, and allocates all points and
/// cells.
void check_claims(vtkXMLDataElement& element, std::uint64_t bytes) {
  // Limits on claims. Larger: VTK takes more memory for damaged files; smaller: sound files could be refused.
  constexpr int most_components = 10'000;
  constexpr std::uint64_t most_per_byte = 1000;  // points or cells per byte of the file, at any compression
  int components = 1;
  vtkTypeInt64 offset = 0;
  if (element.GetScalarAttribute("offset", offset) != 0 && offset < 0)
    throw LoadError("has an array whose numbers begin before the others, at offset " + std::to_string(offset) +
                    "; correct its offset");
  element.GetScalarAttribute("NumberOfComponents", components);  // INT_MAX if too large for an int
  if (components < 0 || components > most_components)
    throw LoadError("claims an array of " + std::to_string(components) + " components; correct its NumberOfComponents");
  for (const char* key : {"NumberOfPoints", "NumberOfCells"}) {
    vtkIdType count = 0;
    element.GetScalarAttribute(key, count);
    if (count < 0 || static_cast<std::uint64_t>(count) / most_per_byte > bytes)
      throw LoadError("claims " + std::to_string(count) + " as " + key +
                      ", more than a file of its size can hold; get it whole");
  }
  for (int n = 0; n < element.GetNumberOfNestedElements(); ++n) check_claims(*element.GetNestedElement(n), bytes);
}

/// Removes field data: they belong to no point or cell, and VTK crashes if they are damaged.
void leave_out_field_data(vtkXMLDataElement& primary) {
  while (vtkXMLDataElement* field_data = primary.FindNestedElementWithName("FieldData")) {
    primary.RemoveNestedElement(field_data);
  }
}

bool are_apart(vtkXMLDataElement& element) {
  const char* format = element.GetAttribute("format");
  if (format != nullptr && std::string_view(format) != "appended") return false;
  for (int n = 0; n < element.GetNumberOfNestedElements(); ++n) {
    if (!are_apart(*element.GetNestedElement(n))) return false;
  }
  return true;
}

double cells_in(const int* extent) {
  double cells = 1;
  for (int a = 0; a < 3; ++a) cells *= std::max(1.0, static_cast<double>(extent[2 * a + 1]) - extent[2 * a]);
  return cells;
}

/// Detects a file that ends before its data: VTK does not report that, and leaves the rest of the arrays uninitialised.
template <class Reader>
class Checked : public Reader {
 public:
  static Checked* New() { VTK_STANDARD_NEW_BODY(Checked); }
  bool met_end_of_file() const { return met_end_of_file_; }
  /// Whether all arrays lie behind the XML, so that a part is read without the others.
  bool has_numbers_apart() const { return has_numbers_apart_; }

 protected:
  int ReadPrimaryElement(vtkXMLDataElement* primary) override {
    check_claims(*primary, file_bytes(this->GetFileName()));
    leave_out_field_data(*primary);
    has_numbers_apart_ = are_apart(*primary);
    return Reader::ReadPrimaryElement(primary);
  }
  int ReadArrayValues(vtkXMLDataElement* element, vtkIdType index, vtkAbstractArray* array, vtkIdType first, vtkIdType count,
                      vtkXMLDataReader::FieldType type) override {
    const int done = Reader::ReadArrayValues(element, index, array, first, count, type);
    // For numbers as text the stream ends with their element, and VTK counts them itself.
    const char* format = element->GetAttribute("format");
    const bool text = format != nullptr && std::string_view(format) == "ascii";
    met_end_of_file_ = met_end_of_file_ || this->Stream == nullptr || (!text && this->Stream->eof());
    return done;
  }

 private:
  bool met_end_of_file_ = false, has_numbers_apart_ = false;
};

/// Detects pieces that do not fill the grid.
template <class Reader>
class CheckedGrid : public Checked<Reader> {
 public:
  static CheckedGrid* New() { VTK_STANDARD_NEW_BODY(CheckedGrid); }
  bool pieces_fill(const int whole[6]) const {
    double have = 0;
    for (int p = 0; p < this->NumberOfPieces; ++p) have += cells_in(this->PieceExtents + 6 * p);
    return have >= cells_in(whole);
  }
};

/// True if a piece has the arrays that the main file declares: VTK copies as many bytes as these should have.
bool fits(vtkDataSet& piece, vtkDataSet& whole) {
  if (piece.GetNumberOfPoints() == 0) return true;
  for (const bool of_cells : {false, true}) {
    vtkFieldData& have = of_cells ? static_cast<vtkFieldData&>(*piece.GetCellData()) : *piece.GetPointData();
    vtkFieldData& said = of_cells ? static_cast<vtkFieldData&>(*whole.GetCellData()) : *whole.GetPointData();
    for (int a = 0; a < said.GetNumberOfArrays(); ++a) {
      vtkAbstractArray& array = *said.GetAbstractArray(a);
      vtkAbstractArray* same = array.GetName() != nullptr ? have.GetAbstractArray(array.GetName()) : nullptr;
      if (same == nullptr || same->GetDataType() != array.GetDataType() ||
          same->GetNumberOfComponents() != array.GetNumberOfComponents())
        return false;
    }
  }
  auto* planes = vtkRectilinearGrid::SafeDownCast(&piece);
  return planes == nullptr ||
         (planes->GetXCoordinates()->GetNumberOfComponents() == 1 && planes->GetYCoordinates()->GetNumberOfComponents() == 1 &&
          planes->GetZCoordinates()->GetNumberOfComponents() == 1);
}

/// File that names its pieces' files; `PieceReader` reads a piece.
template <class Reader, class PieceReader>
class Pieces : public Reader {
 public:
  static Pieces* New() { VTK_STANDARD_NEW_BODY(Pieces); }
  /// Throws if a piece is missing or may not be read.
  std::vector<std::string> files() {
    std::vector<std::string> names;
    for (int p = 0; p < this->NumberOfPieces; ++p) {
      vtkXMLDataReader* piece = this->PieceReaders[p];
      const char* name = piece != nullptr ? piece->GetFileName() : nullptr;
      if (name == nullptr) continue;  // a piece without data
      check_not_unpacked(this->GetFileName());
      if (file_bytes(name) == 0)
        throw LoadError("needs its piece '" + std::string(name) + "', which is not there; put it back");
      check_data_file(this->GetFileName(), name);
      names.emplace_back(name);
    }
    return names;
  }
  bool met_end_of_file() const { return met_end_of_file_; }

 protected:
  int ReadPrimaryElement(vtkXMLDataElement* primary) override {
    check_claims(*primary, file_bytes(this->GetFileName()));
    leave_out_field_data(*primary);
    return Reader::ReadPrimaryElement(primary);
  }
  vtkXMLDataReader* CreatePieceReader() override { return Checked<PieceReader>::New(); }
  /// Refuses pieces that failed or do not fit, because VTK copies from them without a check.
  int ReadPieceData() override {
    auto& piece = static_cast<Checked<PieceReader>&>(*this->PieceReaders[this->Piece]);
    if constexpr (requires { this->SubExtent; })
      static_cast<vtkAlgorithm&>(piece).UpdateExtent(this->SubExtent);
    else
      piece.Update();
    met_end_of_file_ = met_end_of_file_ || piece.met_end_of_file();
    auto* whole = vtkDataSet::SafeDownCast(this->GetCurrentOutput());
    if (library_complained() || whole == nullptr) return 0;
    if (!fits(*piece.GetOutputAsDataSet(), *whole)) {
      vtkErrorMacro("a piece has not the arrays that the file says");
      return 0;
    }
    return Reader::ReadPieceData();
  }

 private:
  bool met_end_of_file_ = false;
};
template <class Reader, class PieceReader>
class GridPieces : public Pieces<Reader, PieceReader> {
 public:
  static GridPieces* New() { VTK_STANDARD_NEW_BODY(GridPieces); }
  bool pieces_fill(const int whole[6]) const {
    double have = 0;
    for (int p = 0; p < this->NumberOfPieces; ++p) have += cells_in(this->PieceExtents + 6 * p);
    return have >= cells_in(whole);
  }
};

/// Image data in one file, read array by array into the caller's memory.
class VtiSource final : public GridSource {
 public:
  explicit VtiSource(const protocol::Request& request) : GridSource(request, "vti") {
    reader_->SetFileName(request.path.c_str());
    reader_->UpdateInformation();
    check(*reader_, "VTI");
    vtkInformation* info = reader_->GetOutputInformation(0);
    int extent[6] = {};
    double origin[3] = {0, 0, 0}, spacing[3] = {1, 1, 1}, direction[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    if (info->Has(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT()) == 0)
      throw LoadError("has no extent; it is no VTK image data");
    info->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), extent);
    if (info->Has(vtkDataObject::ORIGIN()) != 0) info->Get(vtkDataObject::ORIGIN(), origin);
    if (info->Has(vtkDataObject::SPACING()) != 0) info->Get(vtkDataObject::SPACING(), spacing);
    if (info->Has(vtkDataObject::DIRECTION()) != 0) info->Get(vtkDataObject::DIRECTION(), direction);
    set_grids(grids_of(extent, origin, spacing, direction));
    if (!reader_->pieces_fill(extent)) throw LoadError("has pieces that do not fill its grid; get the whole file");
    list(info->Get(vtkDataObject::POINT_DATA_VECTOR()), false);
    list(info->Get(vtkDataObject::CELL_DATA_VECTOR()), true);
    finish_header();
    std::copy_n(extent, 6, extent_.begin());
    header.reads_rows = reader_->has_numbers_apart() && !has_ghosts_ && !has_bits_ &&
                        std::ranges::none_of(arrays_, [](const Array& array) { return array.of_cells; });
  }

  /// True if some points or cells may be blank; known exactly only after reading.
  bool has_ghosts() const noexcept { return has_ghosts_; }

  void read(const std::vector<std::uint32_t>& wanted, const std::vector<std::byte*>& to) override {
    select(wanted);
    reader_->Update();
    check_read();
    copy_out(*reader_->GetOutput(), wanted, to);
  }

  void read_rows(std::uint32_t field, std::int64_t slice, std::int64_t first, std::int64_t count, std::byte* to) override {
    select({field});
    std::array<int, 6> part = extent_;
    part[2] = extent_[2] + static_cast<int>(first), part[3] = part[2] + static_cast<int>(count) - 1;
    part[4] = part[5] = extent_[4] + static_cast<int>(slice);
    static_cast<vtkAlgorithm&>(*reader_).UpdateExtent(part.data());
    check_read();
    const Array& array = arrays_[field];
    vtkImageData& image = *reader_->GetOutput();
    vtkDataArray* values = image.GetPointData()->GetArray(array.name.c_str());
    RawVoxels raw = array.raw;
    raw.dims = {raw.dims[0], count, 1};
    if (values == nullptr || !std::equal(part.begin(), part.end(), image.GetExtent()) ||
        values->GetNumberOfTuples() != raw.dims[0] * count || values->GetNumberOfComponents() != raw.components)
      throw LoadError("has not the array that its header says; get the whole file");
    protocol::FieldHeader of = header.fields[field];
    of.grid.dims = raw.dims;
    copy_voxels(values->GetVoidPointer(0), raw, array.turn, of, to);
  }

 private:
  void select(const std::vector<std::uint32_t>& wanted) {
    vtkDataArraySelection* points = reader_->GetPointDataArraySelection();
    vtkDataArraySelection* cells = reader_->GetCellDataArraySelection();
    points->DisableAllArrays();
    cells->DisableAllArrays();
    for (const std::uint32_t field : wanted)
      (arrays_[field].of_cells ? cells : points)->EnableArray(arrays_[field].name.c_str());
  }

  void check_read() {
    check(*reader_, "VTI");
    if (reader_->met_end_of_file()) throw LoadError("is shorter than its header says; get the whole file");
  }

  void list(vtkInformationVector* arrays, bool of_cells) {
    for (int i = 0; arrays != nullptr && i < arrays->GetNumberOfInformationObjects(); ++i) {
      vtkInformation* array = arrays->GetInformationObject(i);
      const char* name = array->Get(vtkDataObject::FIELD_NAME());
      if (name == nullptr) continue;
      has_ghosts_ = has_ghosts_ || std::string_view(name) == "vtkGhostType";
      has_bits_ = has_bits_ || array->Get(vtkDataObject::FIELD_ARRAY_TYPE()) == VTK_BIT;
      add(name, array->Get(vtkDataObject::FIELD_ARRAY_TYPE()), array->Get(vtkDataObject::FIELD_NUMBER_OF_COMPONENTS()),
          of_cells);
    }
  }

  vtkNew<CheckedGrid<vtkXMLImageDataReader>> reader_;
  std::array<int, 6> extent_{};
  bool has_ghosts_ = false, has_bits_ = false;
};

/// Data set of one file with all its pieces, whose files are added.
template <class Reader>
vtkSmartPointer<vtkDataSet> loaded(const std::string& path, std::vector<std::string>& files) {
  constexpr bool parallel = requires(Reader & reader) { reader.files(); };
  constexpr bool grid = requires(const Reader& reader, const int* extent) { reader.pieces_fill(extent); };
  vtkNew<Reader> reader;
  reader->SetFileName(path.c_str());
  reader->UpdateInformation();
  check(*reader, "VTK's XML");
  files.push_back(path);
  if constexpr (parallel) {
    for (std::string& piece : reader->files()) files.push_back(std::move(piece));
  }
  if constexpr (grid) {
    int extent[6] = {};
    reader->GetOutputInformation(0)->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), extent);
    if (!reader->pieces_fill(extent)) throw LoadError("has pieces that do not fill its grid; get the whole file");
  }
  reader->Update();
  check(*reader, "VTK's XML");
  if (reader->met_end_of_file()) throw LoadError("is shorter than its header says; get the whole file");
  return vtkDataSet::SafeDownCast(reader->GetOutputDataObject(0));
}

/// Types of VTK's XML that hold one data set.
struct XmlKind {
  std::string_view type, format;
  vtkSmartPointer<vtkDataSet> (*load)(const std::string& path, std::vector<std::string>& files);
};
constexpr XmlKind xml_kinds[] = {
    {"ImageData", "vti", loaded<CheckedGrid<vtkXMLImageDataReader>>},
    {"RectilinearGrid", "vtr", loaded<CheckedGrid<vtkXMLRectilinearGridReader>>},
    {"StructuredGrid", "vts", loaded<CheckedGrid<vtkXMLStructuredGridReader>>},
    {"UnstructuredGrid", "vtu", loaded<Checked<vtkXMLUnstructuredGridReader>>},
    {"PImageData", "pvti", loaded<GridPieces<vtkXMLPImageDataReader, vtkXMLImageDataReader>>},
    {"PRectilinearGrid", "pvtr", loaded<GridPieces<vtkXMLPRectilinearGridReader, vtkXMLRectilinearGridReader>>},
    {"PStructuredGrid", "pvts", loaded<GridPieces<vtkXMLPStructuredGridReader, vtkXMLStructuredGridReader>>},
    {"PUnstructuredGrid", "pvtu", loaded<Pieces<vtkXMLPUnstructuredGridReader, vtkXMLUnstructuredGridReader>>}};

const XmlKind* kind_of_xml(const std::string& type) {
  const auto known = std::ranges::find(xml_kinds, type, &XmlKind::type);
  return known != std::end(xml_kinds) ? known : nullptr;
}

std::string xml_type(const std::string& path) { return attribute_in(xml_root(path), "type"); }

[[noreturn]] void refuse_type(const std::string& type) {
  throw LoadError(
      "holds " + (type.empty() ? std::string("data of no type") : known_words(type)) +
      "; of VTK's XML files images, rectilinear, structured and unstructured grids, and .vtm and .pvd of them can be "
      "read");
}

/// Blocks of one grid in files of their own.
class Blocks {
 public:
  explicit Blocks(const protocol::Request& request) : request_(request) {}

  /// Adds a file, or the files that it names.
  void add(const std::string& path, int depth = 0) {
    constexpr int deepest = 4;  // an index of indices. More: a circle of them takes longer; less: large cases are refused
    const std::string type = xml_type(path);
    try {
      if (const XmlKind* known = kind_of_xml(type)) {
        blocks_.push_back(known->load(path, files_));
      } else if (is_vtk_index(type) && depth < deepest) {
        add_index(path, depth);
      } else if (depth > 0 && (type == "PolyData" || type == "PPolyData")) {
        ++surfaces_;
      } else {
        refuse_type(type);
      }
    } catch (const LoadError& error) {
      if (depth == 0) throw;
      throw LoadError("has a block '" + std::filesystem::path(path).filename().string() + "' that " + error.what());
    }
  }

  std::unique_ptr<Source> source(const std::string& format) {
    if (blocks_.empty()) throw LoadError("names only surfaces, which have no volume; give the grid that they were made from");
    std::unique_ptr<Source> source = source_of(request_, format.c_str(), blocks_, files_);
    source->takes.partners = true;
    source->takes.time = !times_s_.empty();
    if (!request_.time_s) warn_of_moments(times_s_, source->header.warnings);
    if (surfaces_ > 0)
      source->header.warnings.push_back("has " + std::to_string(surfaces_) + " surfaces beside its grids, which are left out");
    return source;
  }

 private:
  void add_index(const std::string& path, int depth) {
    const VtkIndex index = read_vtk_index(path, depth == 0 ? request_.time_s : std::nullopt);
    if (depth == 0) times_s_ = index.times_s;
    files_.push_back(path);
    std::uint64_t bytes = 0;
    for (const std::string& file : index.files) bytes += file_bytes(file);
    allow_memory(request_, bytes);
    for (const std::string& file : index.files) add(file, depth + 1);
  }

  const protocol::Request& request_;
  std::vector<vtkSmartPointer<vtkDataSet>> blocks_;
  std::vector<std::string> files_;
  std::vector<double> times_s_;
  int surfaces_ = 0;
};

std::int64_t points_of(const int* extent, int a) { return std::int64_t{extent[2 * a + 1]} - extent[2 * a] + 1; }

/// Refuses a legacy file that claims more points than its size can hold: a point needs at least one bit, uncompressed.
void check_claim(const protocol::Request& request, const int* extent) {
  double voxels = 1;
  for (int a = 0; a < 3; ++a) voxels *= std::max(0.0, static_cast<double>(points_of(extent, a)));
  const auto bytes = static_cast<double>(file_bytes(request.path));
  if (voxels > 8.0 * bytes || voxels > static_cast<double>(request.max_bytes)) {
    throw LoadError("claims " + std::to_string(points_of(extent, 0)) + " × " + std::to_string(points_of(extent, 1)) + " × " +
                    std::to_string(points_of(extent, 2)) + " voxels, but has " + protocol::readable_bytes(bytes) +
                    "; correct DIMENSIONS, or get the whole file");
  }
}

std::unique_ptr<Source> open_xml(const protocol::Request& request) {
  const std::string type = xml_type(request.path);
  if (type == "ImageData" && request.partners.empty()) {
    auto source = std::make_unique<VtiSource>(request);
    if (!source->has_ghosts()) return source;
  }
  Blocks blocks(request);
  blocks.add(request.path);
  for (const std::string& partner : request.partners) {
    if (kind_of_xml(xml_type(partner)) == nullptr)
      throw LoadError("is named with '" + std::filesystem::path(partner).filename().string() +
                      "', which is no grid of VTK's XML; name blocks of one grid, or one file");
    blocks.add(partner, 1);
  }
  if (const XmlKind* known = kind_of_xml(type)) return blocks.source(std::string(known->format));
  return blocks.source(type == "Collection" ? "pvd" : "vtm");
}

/// Kind of data set of a legacy file, in capitals: from the first line that begins with DATASET. The second line is a title.
std::string kind_of_legacy(const std::string& start) {
  std::istringstream lines(start);
  std::string line;
  for (int n = 0; std::getline(lines, line); ++n) {
    for (char& c : line) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    if (n >= 2 && first_word(line) == "DATASET") return word_after(line, "DATASET");
  }
  return {};
}

/// Data of a legacy file, or of a text in its place; unusable if the library has reported an error.
vtkSmartPointer<vtkDataSet> read_legacy(const protocol::Request& request, const std::string* text) {
  vtkNew<vtkDataSetReader> reader;
  if (text != nullptr) {
    reader->ReadFromInputStringOn();
    reader->SetInputString(*text);
  } else {
    reader->SetFileName(request.path.c_str());
  }
  reader->ReadAllScalarsOn();
  reader->ReadAllVectorsOn();
  reader->ReadAllNormalsOn();
  reader->ReadAllTensorsOn();
  reader->ReadAllColorScalarsOn();
  reader->ReadAllTCoordsOn();
  reader->ReadAllFieldsOn();
  reader->UpdateInformation();
  if (library_complained()) return nullptr;
  check(*reader, "legacy VTK");
  vtkInformation* info = reader->GetOutputInformation(0);
  if (info->Has(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT()) != 0) {
    int extent[6] = {};
    info->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), extent);
    check_claim(request, extent);
  }
  reader->Update();
  if (library_complained()) return nullptr;
  check(*reader, "legacy VTK");
  return reader->GetOutput();
}

std::unique_ptr<Source> open_legacy(const protocol::Request& request, const std::string& start) {
  const std::string kind = kind_of_legacy(start);
  if (kind != "STRUCTURED_POINTS" && kind != "RECTILINEAR_GRID" && kind != "STRUCTURED_GRID" && kind != "UNSTRUCTURED_GRID") {
    throw LoadError("holds " + (kind.empty() ? std::string("no DATASET that can be found") : known_words(kind)) +
                    "; of legacy VTK files STRUCTURED_POINTS (image data) and RECTILINEAR_, STRUCTURED_ and UNSTRUCTURED_GRID "
                    "can be read");
  }
  vtkSmartPointer<vtkDataSet> data = read_legacy(request, nullptr);
  if (library_complained()) {
    // The library does not read "nan" and "inf": a text with them is read again with stand-ins.
    const std::optional<std::string> text = with_stand_ins(request.path);
    const std::string problem = take_library_error();
    if (text) data = read_legacy(request, &*text);
    if (!text || library_complained()) {
      throw LoadError("cannot be read as legacy VTK (" + (text ? take_library_error() : problem) +
                      "); check that the file is whole");
    }
    if (data != nullptr) put_back_not_finite(*data);
  }
  if (data == nullptr) throw LoadError("holds no data set; it is no VTK file of a volume");
  return source_of(request, "vtk", {data}, {request.path});
}

}  // namespace

std::unique_ptr<Source> open_vtk(const protocol::Request& request) {
  const std::string start = first_bytes(request.path);
  return start.starts_with("# vtk DataFile") ? open_legacy(request, start) : open_xml(request);
}

}  // namespace palpa::reader
