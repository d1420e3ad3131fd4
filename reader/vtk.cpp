// Image data of VTK: XML (.vti) and legacy (.vtk).
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataArraySelection.h>
#include <vtkDataObject.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkStructuredPoints.h>
#include <vtkStructuredPointsReader.h>
#include <vtkXMLImageDataReader.h>

#include <algorithm>
#include <set>

#include "messages.h"
#include "source.h"
#include "voxels.h"

namespace palpa::reader {
namespace {

constexpr std::size_t max_fields = 200;

/// The number type of a VTK type; false where it is none that can be read.
bool find_raw_type(int type, RawType& raw) {
  switch (type) {
    case VTK_BIT:  // read as bytes of 0 and 1
    case VTK_UNSIGNED_CHAR: return raw = RawType::uint8, true;
    case VTK_CHAR:
    case VTK_SIGNED_CHAR: return raw = RawType::int8, true;
    case VTK_SHORT: return raw = RawType::int16, true;
    case VTK_UNSIGNED_SHORT: return raw = RawType::uint16, true;
    case VTK_INT: return raw = RawType::int32, true;
    case VTK_UNSIGNED_INT: return raw = RawType::uint32, true;
    case VTK_LONG:
    case VTK_LONG_LONG:
    case VTK_ID_TYPE: return raw = RawType::int64, true;
    case VTK_UNSIGNED_LONG:
    case VTK_UNSIGNED_LONG_LONG: return raw = RawType::uint64, true;
    case VTK_FLOAT: return raw = RawType::float32, true;
    case VTK_DOUBLE: return raw = RawType::float64, true;
    default: return false;
  }
}

/// What both readers share: fields from the arrays of points and cells of one grid.
class ImageSource : public Source {
 protected:
  ImageSource(const protocol::Request& request, const char* format) {
    header.format = format;
    header.default_unit = "m";
    header.named = true;
    files.push_back(request.path);
    chosen_frame(request, 1, header.warnings);
  }

  /// Where the grid lies: extent, and the affine from VTK's indices, which need not start at 0.
  void set_grid(const int extent[6], const double origin[3], const double spacing[3], const double direction[9]) {
    std::copy_n(extent, 6, extent_);
    for (int r = 0; r < 3; ++r) {
      const double* d = direction + 3 * r;
      index_to_world_.row[r] = {d[0] * spacing[0], d[1] * spacing[1], d[2] * spacing[2]};
    }
    origin_ = {origin[0], origin[1], origin[2]};
    for (int a = 0; a < 3; ++a) {
      if (extent[2 * a + 1] < extent[2 * a]) throw LoadError("has no voxels; the grid's extent is empty");
    }
  }

  std::int64_t points(int axis) const { return std::int64_t{extent_[2 * axis + 1]} - extent_[2 * axis] + 1; }
  std::int64_t cells(int axis) const { return std::max<std::int64_t>(points(axis) - 1, 1); }

  /// Adds a field for an array, or a warning that says why not.
  void add(std::string name, int vtk_type, int components, bool of_cells) {
    if (name.empty()) name = "array_" + std::to_string(header.fields.size());
    const auto leave_out = [&](const std::string& why) {
      header.warnings.push_back("array '" + name + "' is left out: " + why);
    };
    RawVoxels raw;
    if (name == "vtkGhostType") return leave_out("it marks ghosts, not data");
    if (!find_raw_type(vtk_type, raw.type)) return leave_out("it holds no numbers");
    if (components != 1 && components != 3)
      return leave_out(std::to_string(components) + " components; one or three can be felt");
    if (components == 3 && raw.type == RawType::uint8) return leave_out("three bytes are a colour, not a vector");
    if (header.fields.size() >= max_fields) return leave_out("only the first " + std::to_string(max_fields) + " are read");
    raw.components = components;
    Vec3 first{static_cast<double>(extent_[0]), static_cast<double>(extent_[2]), static_cast<double>(extent_[4])};
    for (int a = 0; a < 3; ++a) raw.dims[static_cast<std::size_t>(a)] = of_cells ? cells(a) : points(a);
    if (of_cells) first += Vec3{points(0) > 1 ? 0.5 : 0, points(1) > 1 ? 0.5 : 0, points(2) > 1 ? 0.5 : 0};
    raw.stride = {components, components * raw.dims[0], components * raw.dims[0] * raw.dims[1]};

    protocol::FieldHeader field;
    field.grid.index_to_world_m = index_to_world_;
    field.grid.origin_m = index_to_world_ * first + origin_;
    arrays_.push_back({name, of_cells, raw});
    field.name = name;
    for (int n = 2; !names_.insert(field.name).second; ++n) {
      field.name = name + (of_cells ? "_cells" : "_") + (of_cells && n == 2 ? "" : std::to_string(n));
    }
    Turn turn;
    std::vector<std::string> notes;
    keep(raw, turn, field, notes);
    for (const std::string& note : notes) header.warnings.push_back("array '" + field.name + "': " + note);
    header.fields.push_back(field);
  }

  void finish_header() {
    if (!header.fields.empty()) return;
    std::string why = "has no array that can be felt; one number per point, or a vector of three, is needed";
    if (!header.warnings.empty())
      why = "has no array that can be felt (" + header.warnings.back() + "); one with 1 or 3 numbers is needed";
    throw LoadError(why);
  }

  /// Copies the wanted arrays out of `image` and lets go of each.
  void copy_out(vtkImageData& image, const std::vector<std::uint32_t>& wanted, const std::vector<std::byte*>& to) {
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const Array& array = arrays_[wanted[i]];
      vtkFieldData& data = array.of_cells ? static_cast<vtkFieldData&>(*image.GetCellData()) : *image.GetPointData();
      vtkDataArray* voxels = data.GetArray(array.name.c_str());
      const std::int64_t count = array.raw.dims[0] * array.raw.dims[1] * array.raw.dims[2];
      if (voxels == nullptr || voxels->GetNumberOfTuples() != count ||
          voxels->GetNumberOfComponents() != array.raw.components) {
        throw LoadError("has not all values of array '" + array.name + "'; check that the file is whole");
      }
      if (voxels->GetDataType() == VTK_BIT) {
        for (std::int64_t v = 0; v < count * array.raw.components; ++v) {
          to[i][v] = static_cast<std::byte>(
              voxels->GetComponent(v / array.raw.components, static_cast<int>(v % array.raw.components)));
        }
      } else {
        copy_voxels(voxels->GetVoidPointer(0), array.raw, {}, header.fields[wanted[i]], to[i]);
      }
      data.RemoveArray(array.name.c_str());
    }
  }

 private:
  struct Array {
    std::string name;
    bool of_cells;
    RawVoxels raw;
  };
  int extent_[6] = {};
  Mat3 index_to_world_;
  Vec3 origin_;
  std::vector<Array> arrays_;  ///< one for each field
  std::set<std::string> names_;
};

/// Notices what VTK passes over in silence, leaving parts of the arrays as it found the memory: pieces that
/// do not fill the grid, and a file that ends before its data.
class PiecewiseReader : public vtkXMLImageDataReader {
 public:
  static PiecewiseReader* New();
  vtkTypeMacro(PiecewiseReader, vtkXMLImageDataReader);

  bool pieces_fill(const int whole[6]) const {
    double have = 0;
    for (int p = 0; p < this->NumberOfPieces; ++p) have += cells_in(this->PieceExtents + 6 * p);
    return have >= cells_in(whole);
  }
  bool met_end_of_file() const { return met_end_of_file_; }

 protected:
  int ReadArrayValues(vtkXMLDataElement* element, vtkIdType index, vtkAbstractArray* array, vtkIdType first, vtkIdType count,
                      FieldType type) override {
    const int done = Superclass::ReadArrayValues(element, index, array, first, count, type);
    met_end_of_file_ = met_end_of_file_ || this->Stream == nullptr || this->Stream->eof();
    return done;
  }

 private:
  bool met_end_of_file_ = false;

  static double cells_in(const int* extent) {
    double cells = 1;
    for (int a = 0; a < 3; ++a) cells *= std::max(1.0, static_cast<double>(extent[2 * a + 1]) - extent[2 * a]);
    return cells;
  }
};
vtkStandardNewMacro(PiecewiseReader);

class VtiSource : public ImageSource {
 public:
  explicit VtiSource(const protocol::Request& request) : ImageSource(request, "vti") {
    reader_->SetFileName(request.path.c_str());
    reader_->UpdateInformation();
    check();
    vtkInformation* info = reader_->GetOutputInformation(0);
    int extent[6] = {};
    double origin[3] = {0, 0, 0}, spacing[3] = {1, 1, 1}, direction[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    if (info->Has(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT()) == 0)
      throw LoadError("has no extent; it is no VTK image data");
    info->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), extent);
    if (info->Has(vtkDataObject::ORIGIN()) != 0) info->Get(vtkDataObject::ORIGIN(), origin);
    if (info->Has(vtkDataObject::SPACING()) != 0) info->Get(vtkDataObject::SPACING(), spacing);
    if (info->Has(vtkDataObject::DIRECTION()) != 0) info->Get(vtkDataObject::DIRECTION(), direction);
    set_grid(extent, origin, spacing, direction);
    if (!reader_->pieces_fill(extent)) throw LoadError("has pieces that do not fill its grid; get the whole file");
    list(info->Get(vtkDataObject::POINT_DATA_VECTOR()), false);
    list(info->Get(vtkDataObject::CELL_DATA_VECTOR()), true);
    finish_header();
    for (const auto& field : header.fields) header.working_bytes += protocol::voxel_bytes(field).value_or(0);
  }

  void read(const std::vector<std::uint32_t>& wanted, const std::vector<std::byte*>& to) override {
    vtkDataArraySelection* points = reader_->GetPointDataArraySelection();
    vtkDataArraySelection* cells = reader_->GetCellDataArraySelection();
    points->DisableAllArrays();
    cells->DisableAllArrays();
    for (const std::uint32_t field : wanted)
      (stored_[field].second ? cells : points)->EnableArray(stored_[field].first.c_str());
    reader_->Update();
    check();
    if (reader_->met_end_of_file()) throw LoadError("is shorter than its header says; get the whole file");
    copy_out(*reader_->GetOutput(), wanted, to);
  }

 private:
  void check() {
    if (library_complained() || reader_->GetErrorCode() != 0) {
      throw LoadError("cannot be read as VTI (" + take_library_error() + "); check that the file is whole");
    }
  }

  void list(vtkInformationVector* arrays, bool of_cells) {
    for (int i = 0; arrays != nullptr && i < arrays->GetNumberOfInformationObjects(); ++i) {
      vtkInformation* array = arrays->GetInformationObject(i);
      const char* name = array->Get(vtkDataObject::FIELD_NAME());
      const std::size_t before = header.fields.size();
      if (name == nullptr) continue;
      add(name, array->Get(vtkDataObject::FIELD_ARRAY_TYPE()), array->Get(vtkDataObject::FIELD_NUMBER_OF_COMPONENTS()),
          of_cells);
      if (header.fields.size() > before) stored_.emplace_back(name, of_cells);
    }
  }

  vtkNew<PiecewiseReader> reader_;
  std::vector<std::pair<std::string, bool>> stored_;  ///< name in the file and whether of cells, for each field
};

class LegacySource : public ImageSource {
 public:
  explicit LegacySource(const protocol::Request& request) : ImageSource(request, "vtk") {
    reader_->SetFileName(request.path.c_str());
    reader_->ReadAllScalarsOn();
    reader_->ReadAllVectorsOn();
    reader_->ReadAllNormalsOn();
    reader_->ReadAllTensorsOn();
    reader_->ReadAllColorScalarsOn();
    reader_->ReadAllTCoordsOn();
    reader_->ReadAllFieldsOn();
    reader_->UpdateInformation();
    check();
    int extent[6] = {};
    reader_->GetOutputInformation(0)->Get(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), extent);

    // The arrays are known only once they are read, so the claim is held against the file first: it is not
    // compressed, and a voxel takes a bit at least.
    double voxels = 1;
    for (int a = 0; a < 3; ++a) voxels *= std::max(0.0, static_cast<double>(extent[2 * a + 1]) - extent[2 * a] + 1);
    if (voxels > 8.0 * static_cast<double>(file_bytes(request.path)) || voxels > static_cast<double>(request.max_bytes)) {
      throw LoadError("claims " + std::to_string(points_of(extent, 0)) + " × " + std::to_string(points_of(extent, 1)) + " × " +
                      std::to_string(points_of(extent, 2)) + " voxels, but has " +
                      protocol::readable_bytes(static_cast<double>(file_bytes(request.path))) +
                      "; correct DIMENSIONS, or get the whole file");
    }
    reader_->Update();
    check();
    vtkImageData& image = *reader_->GetOutput();
    image.GetExtent(extent);
    set_grid(extent, image.GetOrigin(), image.GetSpacing(), image.GetDirectionMatrix()->GetData());
    list(*image.GetPointData(), false);
    list(*image.GetCellData(), true);
    finish_header();
    for (const auto& field : header.fields) header.working_bytes += protocol::voxel_bytes(field).value_or(0);
  }

  void read(const std::vector<std::uint32_t>& wanted, const std::vector<std::byte*>& to) override {
    copy_out(*reader_->GetOutput(), wanted, to);
  }

 private:
  static std::int64_t points_of(const int* extent, int a) { return std::int64_t{extent[2 * a + 1]} - extent[2 * a] + 1; }

  void check() {
    if (library_complained() || reader_->GetErrorCode() != 0) {
      throw LoadError("cannot be read as legacy VTK (" + take_library_error() + "); check that the file is whole");
    }
  }

  void list(vtkFieldData& data, bool of_cells) {
    for (int i = 0; i < data.GetNumberOfArrays(); ++i) {
      vtkAbstractArray* array = data.GetAbstractArray(i);
      if (array->GetName() == nullptr) array->SetName(("array_" + std::to_string(i)).c_str());
      add(array->GetName(), array->GetDataType(), array->GetNumberOfComponents(), of_cells);
    }
  }

  vtkNew<vtkStructuredPointsReader> reader_;
};

}  // namespace

std::unique_ptr<Source> open_vti(const protocol::Request& request) { return std::make_unique<VtiSource>(request); }
std::unique_ptr<Source> open_legacy_vtk(const protocol::Request& request) { return std::make_unique<LegacySource>(request); }

}  // namespace palpa::reader
