#include "vtk_data.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkRectilinearGrid.h>
#include <vtkStructuredGrid.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <stdexcept>

#include "resample.h"

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

/// A name that no field has yet; where points and cells share one, that of the cells says so.
std::string own_name(std::set<std::string>& names, const std::string& wanted, bool of_cells) {
  std::string name = wanted;
  for (int n = 2; !names.insert(name).second; ++n) {
    name = wanted + (of_cells ? "_cells" : "_") + (of_cells && n == 2 ? "" : std::to_string(n));
  }
  return name;
}

void check_fields(const protocol::Header& header) {
  if (!header.fields.empty()) return;
  std::string why = "has no array that can be felt; one number per point, or a vector of three, is needed";
  if (!header.warnings.empty())
    why = "has no array that can be felt (" + header.warnings.back() + "); one with 1 or 3 numbers is needed";
  throw LoadError(why);
}

/// Names what has none, and calls act(name, type, components, of_cells) for every array.
void for_arrays(vtkDataSet& data, const std::function<void(const std::string&, int, int, bool)>& act) {
  for (const bool of_cells : {false, true}) {
    vtkFieldData& arrays = of_cells ? static_cast<vtkFieldData&>(*data.GetCellData()) : *data.GetPointData();
    for (int i = 0; i < arrays.GetNumberOfArrays(); ++i) {
      vtkAbstractArray* array = arrays.GetAbstractArray(i);
      if (array->GetName() == nullptr) array->SetName(("array_" + std::to_string(i)).c_str());
      act(array->GetName(), array->GetDataType(), array->GetNumberOfComponents(), of_cells);
    }
  }
}

bool hides(vtkUnsignedCharArray* ghosts, unsigned char kind) {
  for (vtkIdType n = 0; ghosts != nullptr && n < ghosts->GetNumberOfTuples(); ++n) {
    if ((ghosts->GetValue(n) & kind) != 0) return true;
  }
  return false;
}
/// Points or cells that are no data cannot be said by voxels of an affine grid that have values.
bool has_blanks(vtkDataSet& data) {
  return hides(data.GetPointGhostArray(), vtkDataSetAttributes::HIDDENPOINT) ||
         hides(data.GetCellGhostArray(), vtkDataSetAttributes::HIDDENCELL);
}

Vec3 point_of(vtkDataSet& data, std::int64_t i, std::int64_t j, std::int64_t k, const int (&dims)[3]) {
  double at[3];
  data.GetPoint(i + dims[0] * (j + dims[1] * k), at);
  return {at[0], at[1], at[2]};
}

/// A structured grid whose points are those of straight planes along three directions: rectilinear, whatever it is called.
std::optional<PointsAndCells> straight_grids(vtkStructuredGrid& grid) {
  int dims[3];
  grid.GetDimensions(dims);
  double bounds[6];
  grid.GetBounds(bounds);
  const Vec3 first = point_of(grid, 0, 0, 0, dims);
  Vec3 along[3];
  std::array<std::vector<double>, 3> coordinates;
  double largest = 0.0;
  for (const double bound : bounds) largest = std::max(largest, std::abs(bound));
  const double rounding = 2.0 * static_cast<double>(std::numeric_limits<float>::epsilon()) * largest;
  for (int a = 0; a < 3; ++a) {
    if (dims[a] < 2) return std::nullopt;
    const auto at = [&](int n) { return point_of(grid, a == 0 ? n : 0, a == 1 ? n : 0, a == 2 ? n : 0, dims); };
    along[a] = normalized(at(dims[a] - 1) - first);
    for (int n = 0; n < dims[a]; ++n) coordinates[static_cast<std::size_t>(a)].push_back(dot(at(n) - first, along[a]));
  }
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i) {
        const Vec3 straight = first + coordinates[0][static_cast<std::size_t>(i)] * along[0] +
                              coordinates[1][static_cast<std::size_t>(j)] * along[1] +
                              coordinates[2][static_cast<std::size_t>(k)] * along[2];
        if (!(largest_component(point_of(grid, i, j, k, dims) - straight) <= rounding)) return std::nullopt;
      }
    }
  }
  try {
    return grids_of(coordinates, transposed(Mat3{{along[0], along[1], along[2]}}), first);
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // straight, but folded
  }
}

std::vector<double> numbers_of(vtkDataArray* array) {
  std::vector<double> numbers;
  for (vtkIdType n = 0; array != nullptr && n < array->GetNumberOfTuples(); ++n) numbers.push_back(array->GetComponent(n, 0));
  return numbers;
}

/// Its own grid, where it is affine or rectilinear and all of it is data.
std::optional<PointsAndCells> own_grids(vtkDataSet& data) {
  if (has_blanks(data)) return std::nullopt;
  if (auto* image = vtkImageData::SafeDownCast(&data)) {
    return grids_of(image->GetExtent(), image->GetOrigin(), image->GetSpacing(), image->GetDirectionMatrix()->GetData());
  }
  if (auto* grid = vtkRectilinearGrid::SafeDownCast(&data)) {
    try {
      return grids_of(
          {numbers_of(grid->GetXCoordinates()), numbers_of(grid->GetYCoordinates()), numbers_of(grid->GetZCoordinates())},
          Mat3::identity(), {});
    } catch (const std::invalid_argument& problem) {
      throw LoadError(std::string("cannot be placed in the world (") + problem.what() + "); correct its coordinates");
    }
  }
  auto* grid = vtkStructuredGrid::SafeDownCast(&data);
  return grid != nullptr ? straight_grids(*grid) : std::nullopt;
}

/// A data set in memory on its own grid.
class OwnGridSource final : public GridSource {
 public:
  OwnGridSource(const protocol::Request& request, const char* format, vtkSmartPointer<vtkDataSet> data, PointsAndCells grids,
                std::vector<std::string> of_files)
      : GridSource(request, format), data_(std::move(data)) {
    files = std::move(of_files);
    set_grids(std::move(grids));
    add_all(*data_);
    finish_header();
  }
  void read(const std::vector<std::uint32_t>& wanted, const std::vector<std::byte*>& to) override {
    copy_out(*data_, wanted, to);
  }

 private:
  vtkSmartPointer<vtkDataSet> data_;
};

/// The data set as points that can be moved, with its blanks.
vtkSmartPointer<vtkPointSet> with_points(vtkDataSet& data) {
  if (auto* points = vtkPointSet::SafeDownCast(&data)) {
    vtkSmartPointer<vtkPointSet> copy = vtkSmartPointer<vtkPointSet>::Take(points->NewInstance());
    copy->ShallowCopy(points);
    return copy;
  }
  auto copy = vtkSmartPointer<vtkStructuredGrid>::New();
  if (auto* image = vtkImageData::SafeDownCast(&data)) copy->SetExtent(image->GetExtent());
  if (auto* grid = vtkRectilinearGrid::SafeDownCast(&data)) copy->SetExtent(grid->GetExtent());
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(data.GetNumberOfPoints());
  for (vtkIdType p = 0; p < data.GetNumberOfPoints(); ++p) {
    double at[3];
    data.GetPoint(p, at);
    points->SetPoint(p, at);
  }
  copy->SetPoints(points);
  copy->GetPointData()->ShallowCopy(data.GetPointData());
  copy->GetCellData()->ShallowCopy(data.GetCellData());
  return copy;
}

std::vector<vtkSmartPointer<vtkPointSet>> with_points(const std::vector<vtkSmartPointer<vtkDataSet>>& blocks) {
  std::vector<vtkSmartPointer<vtkPointSet>> all;
  for (const auto& block : blocks) all.push_back(with_points(*block));
  return all;
}

class ResampledSource final : public Source {
 public:
  ResampledSource(const protocol::Request& request, const char* format, const std::vector<vtkSmartPointer<vtkDataSet>>& blocks,
                  std::vector<std::string> of_files)
      : resampler_(with_points(blocks), request.crop) {
    header.format = format;
    header.default_unit = "m";
    header.named = true;
    takes.crop = true;
    files = std::move(of_files);
    chosen_frame(request, 1, header.warnings);
    header.warnings.push_back(resampler_.description());
    std::set<std::string> names;
    bool of_cells_too = false;
    for_arrays(*blocks.front(), [&](const std::string& name, int type, int components, bool of_cells) {
      RawType raw;
      if (const std::string why = why_left_out(name, type, components, raw); !why.empty()) {
        if (name != "vtkGhostType") header.warnings.push_back("array '" + name + "' is left out: " + why);
        return;
      }
      if (header.fields.size() >= max_fields) return;
      protocol::FieldHeader field;
      field.name = own_name(names, name, of_cells);
      field.components = components;
      field.grid = resampler_.grid();
      header.fields.push_back(field);
      arrays_.push_back({name, of_cells, components});
      header.working_bytes += resampler_.working_bytes(components);
      of_cells_too = of_cells_too || of_cells;
    });
    check_fields(header);
    if (of_cells_too) header.warnings.push_back("has values of cells, which are averaged to the points between them");
  }

  void read(const std::vector<std::uint32_t>& wanted, const std::vector<std::byte*>& to) override {
    std::vector<ArrayName> arrays;
    std::vector<float*> voxels;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      arrays.push_back(arrays_[wanted[i]]);
      voxels.push_back(reinterpret_cast<float*>(to[i]));
    }
    const std::vector<Resampled> made = resampler_.sample(arrays, voxels);
    for (std::size_t i = 0; i < made.size(); ++i) {
      resampled.push_back(made[i].report);
      if (made[i].worst) warn(header.fields[wanted[i]].name, made[i]);
    }
  }

 private:
  void warn(const std::string& name, const Resampled& made) {
    char text[500];
    const Box& box = *made.worst;
    std::snprintf(
        text, sizeof text,
        "field '%s' lost detail when resampled: 1 %% of its places are wrong by more than %.0f %% of the range by cell, "
        "%.1f %% by volume; try crop_m = [%.4g, %.4g, %.4g, %.4g, %.4g, %.4g]",
        name.substr(0, 100).c_str(), 100.0 * made.report.by_cell.p99, 100.0 * made.report.by_volume.p99, box.low_m.x,
        box.low_m.y, box.low_m.z, box.high_m.x, box.high_m.y, box.high_m.z);
    warnings.emplace_back(text);
  }

  Resampler resampler_;
  std::vector<ArrayName> arrays_;  ///< one for each field
};

}  // namespace

std::string why_left_out(const std::string& name, int vtk_type, int components, RawType& type) {
  if (name == "vtkGhostType") return "it marks ghosts, not data";
  if (!find_raw_type(vtk_type, type)) return "it holds no numbers";
  if (components != 1 && components != 3) return std::to_string(components) + " components; one or three can be felt";
  if (components == 3 && type == RawType::uint8) return "three bytes are a colour, not a vector";
  return {};
}

PointsAndCells grids_of(const std::array<std::vector<double>, 3>& coordinates, const Mat3& directions, const Vec3& origin) {
  std::array<std::vector<double>, 3> centres;
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t i = 1; i < coordinates[a].size(); ++i)
      centres[a].push_back(0.5 * (coordinates[a][i - 1] + coordinates[a][i]));
    if (centres[a].empty()) centres[a] = coordinates[a];
  }
  const auto turned = [&](GridGeometry grid) {
    grid.index_to_world_m = directions * grid.index_to_world_m;
    grid.origin_m = directions * grid.origin_m + origin;
    return grid;
  };
  return {turned(rectilinear_geometry(coordinates)), turned(rectilinear_geometry(centres))};
}

PointsAndCells grids_of(const int extent[6], const double origin[3], const double spacing[3], const double direction[9]) {
  GridGeometry points, cells;
  double first[3], centre[3];
  for (int a = 0; a < 3; ++a) {
    if (extent[2 * a + 1] < extent[2 * a]) throw LoadError("has no voxels; the grid's extent is empty");
    const std::int64_t count = std::int64_t{extent[2 * a + 1]} - extent[2 * a] + 1;
    points.dims[static_cast<std::size_t>(a)] = count;
    cells.dims[static_cast<std::size_t>(a)] = std::max<std::int64_t>(count - 1, 1);
    const double* d = direction + 3 * a;
    points.index_to_world_m.row[a] = {d[0] * spacing[0], d[1] * spacing[1], d[2] * spacing[2]};
    first[a] = static_cast<double>(extent[2 * a]);
    centre[a] = first[a] + (count > 1 ? 0.5 : 0.0);
  }
  cells.index_to_world_m = points.index_to_world_m;
  const Vec3 start{origin[0], origin[1], origin[2]};
  points.origin_m = points.index_to_world_m * Vec3{first[0], first[1], first[2]} + start;
  cells.origin_m = points.index_to_world_m * Vec3{centre[0], centre[1], centre[2]} + start;
  return {points, cells};
}

GridSource::GridSource(const protocol::Request& request, const char* format) {
  header.format = format;
  header.default_unit = "m";
  header.named = true;
  files.push_back(request.path);
  chosen_frame(request, 1, header.warnings);
}

bool GridSource::add(std::string name, int vtk_type, int components, bool of_cells) {
  if (name.empty()) name = "array_" + std::to_string(header.fields.size());
  RawVoxels raw;
  std::string why = why_left_out(name, vtk_type, components, raw.type);
  if (why.empty() && header.fields.size() >= max_fields) why = "only the first " + std::to_string(max_fields) + " are read";
  if (!why.empty()) {
    header.warnings.push_back("array '" + name + "' is left out: " + why);
    return false;
  }
  const GridGeometry& grid = of_cells ? grids_.cells : grids_.points;
  raw.components = components;
  raw.dims = grid.dims;
  raw.stride = {components, components * raw.dims[0], components * raw.dims[0] * raw.dims[1]};

  protocol::FieldHeader field;
  field.grid = grid;
  arrays_.push_back({name, of_cells, raw});
  field.name = own_name(names_, name, of_cells);
  Turn turn;
  std::vector<std::string> notes;
  keep(raw, turn, field, notes);
  for (const std::string& note : notes) header.warnings.push_back("array '" + field.name + "': " + note);
  header.fields.push_back(field);
  return true;
}

void GridSource::add_all(vtkDataSet& data) {
  for_arrays(data,
             [&](const std::string& name, int type, int components, bool of_cells) { add(name, type, components, of_cells); });
}

void GridSource::finish_header() {
  check_fields(header);
  for (const auto& field : header.fields) header.working_bytes += protocol::voxel_bytes(field).value_or(0);
}

void GridSource::copy_out(vtkDataSet& data, const std::vector<std::uint32_t>& wanted, const std::vector<std::byte*>& to) {
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const Array& array = arrays_[wanted[i]];
    vtkFieldData& arrays = array.of_cells ? static_cast<vtkFieldData&>(*data.GetCellData()) : *data.GetPointData();
    vtkDataArray* voxels = arrays.GetArray(array.name.c_str());
    const std::int64_t count = array.raw.dims[0] * array.raw.dims[1] * array.raw.dims[2];
    if (voxels == nullptr || voxels->GetNumberOfTuples() != count || voxels->GetNumberOfComponents() != array.raw.components) {
      throw LoadError("has not all values of array '" + array.name + "'; check that the file is whole");
    }
    if (voxels->GetDataType() == VTK_BIT) {
      for (std::int64_t v = 0; v < count * array.raw.components; ++v) {
        to[i][v] =
            static_cast<std::byte>(voxels->GetComponent(v / array.raw.components, static_cast<int>(v % array.raw.components)));
      }
    } else {
      copy_voxels(voxels->GetVoidPointer(0), array.raw, {}, header.fields[wanted[i]], to[i]);
    }
    arrays.RemoveArray(array.name.c_str());
  }
}

std::unique_ptr<Source> source_of(const protocol::Request& request, const char* format,
                                  std::vector<vtkSmartPointer<vtkDataSet>> blocks, std::vector<std::string> files,
                                  const std::function<std::string(const std::string&)>& unit_of) {
  std::erase_if(blocks, [](const auto& block) { return block == nullptr || block->GetNumberOfCells() == 0; });
  if (blocks.empty()) throw LoadError("has no cells; give a file with a volume");
  std::unique_ptr<Source> source;
  if (blocks.size() == 1) {
    if (auto grids = own_grids(*blocks.front())) {
      source = std::make_unique<OwnGridSource>(request, format, blocks.front(), std::move(*grids), std::move(files));
    }
  }
  if (!source) {
    source = std::make_unique<ResampledSource>(request, format, blocks, std::move(files));
  }
  for (auto& field : source->header.fields) {
    if (unit_of) field.unit = unit_of(field.name);
  }
  return source;
}

}  // namespace palpa::reader
