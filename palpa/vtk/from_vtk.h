// Volumes from a program's VTK data. Header-only, for any VTK of the user.
#pragma once

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkDataSetAttributes.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkRectilinearGrid.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkXMLDataSetWriter.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "palpa/base/load_error.h"
#include "palpa/data/unread_grid.h"
#include "palpa/data/volume.h"
#include "palpa/file/read_volume.h"

namespace palpa {

/// Properties that VTK data lack, and conversion options.
struct FromVtkOptions {
  double metres_per_unit = 1.0;  ///< [m] unit of length of the data; 0.001 for millimetres. > 0
  bool copy = false;             ///< copy the voxels: the program may change its own afterwards
  ReadOptions read{};            ///< for data that need resampling
};

namespace detail {

/// Points and cells of a VTK grid, each as voxels.
struct VtkGrids {
  GridGeometry points, cells;
};

inline bool hides(vtkUnsignedCharArray* ghosts, unsigned char kind) {
  for (vtkIdType n = 0; ghosts && n < ghosts->GetNumberOfTuples(); ++n) {
    if ((ghosts->GetValue(n) & kind) != 0) return true;
  }
  return false;
}
/// True if points or cells are blank, which voxels cannot represent.
inline bool has_blanks(vtkDataSet& data) {
  return hides(data.GetPointGhostArray(), vtkDataSetAttributes::HIDDENPOINT) ||
         hides(data.GetCellGhostArray(), vtkDataSetAttributes::HIDDENCELL);
}

inline VtkGrids grids_of(vtkImageData& image, double metres_per_unit) {
  int extent[6];
  image.GetExtent(extent);
  const double *spacing = image.GetSpacing(), *origin = image.GetOrigin(), *d = image.GetDirectionMatrix()->GetData();
  VtkGrids grids;
  Vec3 first, middle;
  double *const firsts[] = {&first.x, &first.y, &first.z}, *const middles[] = {&middle.x, &middle.y, &middle.z};
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t count = std::int64_t{extent[2 * a + 1]} - extent[2 * a] + 1;
    if (count < 1) throw LoadError("has no voxels; give one whose extent is not empty");
    grids.points.dims[a] = count;
    grids.cells.dims[a] = std::max<std::int64_t>(count - 1, 1);
    grids.points.index_to_world_m.row[a] =
        metres_per_unit * Vec3{d[3 * a] * spacing[0], d[3 * a + 1] * spacing[1], d[3 * a + 2] * spacing[2]};
    *firsts[a] = extent[2 * a];
    *middles[a] = *firsts[a] + (count > 1 ? 0.5 : 0.0);
  }
  const Vec3 start_m = metres_per_unit * Vec3{origin[0], origin[1], origin[2]};
  grids.cells.index_to_world_m = grids.points.index_to_world_m;
  grids.points.origin_m = grids.points.index_to_world_m * first + start_m;
  grids.cells.origin_m = grids.points.index_to_world_m * middle + start_m;
  return grids;
}

inline VtkGrids grids_of(vtkRectilinearGrid& grid, double metres_per_unit) {
  std::array<std::vector<double>, 3> points_m, middles_m;
  vtkDataArray* const along[] = {grid.GetXCoordinates(), grid.GetYCoordinates(), grid.GetZCoordinates()};
  for (std::size_t a = 0; a < 3; ++a) {
    for (vtkIdType n = 0; along[a] && n < along[a]->GetNumberOfTuples(); ++n)
      points_m[a].push_back(metres_per_unit * along[a]->GetComponent(n, 0));
    for (std::size_t n = 1; n < points_m[a].size(); ++n) middles_m[a].push_back(0.5 * (points_m[a][n - 1] + points_m[a][n]));
    if (middles_m[a].empty()) middles_m[a] = points_m[a];
  }
  return {rectilinear_geometry(points_m), rectilinear_geometry(middles_m)};
}

/// Voxel type for VTK's numbers, used in place or copied.
struct VtkNumbers {
  VoxelType type;
  bool as_they_are;
};
inline std::optional<VtkNumbers> numbers_of(int vtk_type) {
  switch (vtk_type) {
    case VTK_UNSIGNED_CHAR: return VtkNumbers{VoxelType::uint8, true};
    case VTK_SHORT: return VtkNumbers{VoxelType::int16, true};
    case VTK_UNSIGNED_SHORT: return VtkNumbers{VoxelType::uint16, true};
    case VTK_INT: return VtkNumbers{VoxelType::int32, true};
    case VTK_FLOAT: return VtkNumbers{VoxelType::float32, true};
    case VTK_DOUBLE: return VtkNumbers{VoxelType::float64, true};
    case VTK_BIT: return VtkNumbers{VoxelType::uint8, false};
    case VTK_CHAR:
    case VTK_SIGNED_CHAR: return VtkNumbers{VoxelType::int16, false};
    case VTK_UNSIGNED_INT:
    case VTK_LONG:
    case VTK_LONG_LONG:
    case VTK_ID_TYPE:
    case VTK_UNSIGNED_LONG:
    case VTK_UNSIGNED_LONG_LONG: return VtkNumbers{VoxelType::float64, false};
    default: return {};
  }
}

template <class T>
std::shared_ptr<const void> copy_of(vtkDataArray& array) {
  constexpr double exact = 9007199254740992.0;  // 2^53: larger integers are not exact as doubles
  const vtkIdType tuples = array.GetNumberOfTuples();
  const int components = array.GetNumberOfComponents();
  auto values = std::make_shared<std::vector<T>>(static_cast<std::size_t>(tuples * components));
  T* to = values->data();
  for (vtkIdType n = 0; n < tuples; ++n) {
    for (int c = 0; c < components; ++c) {
      const double value = array.GetComponent(n, c);
      if (std::is_same_v<T, double> && array.GetDataType() != VTK_DOUBLE && !(std::abs(value) <= exact))
        throw LoadError("has whole numbers beyond 2^53, which are no voxels; scale them to smaller ones");
      *to++ = static_cast<T>(value);
    }
  }
  return {values, values->data()};
}

/// Numbers of an array as voxels, in place if possible.
inline Voxels voxels_of(vtkDataArray& array, const VtkNumbers& numbers, bool copy) {
  Voxels voxels{.type = numbers.type, .components = array.GetNumberOfComponents(), .data = {}};
  if (numbers.as_they_are && !copy && array.HasStandardMemoryLayout()) {
    const vtkSmartPointer<vtkDataArray> held = &array;
    voxels.data = {array.GetVoidPointer(0), [held](const void*) {}};
    return voxels;
  }
  switch (numbers.type) {
    case VoxelType::uint8: voxels.data = copy_of<std::uint8_t>(array); break;
    case VoxelType::int16: voxels.data = copy_of<std::int16_t>(array); break;
    case VoxelType::uint16: voxels.data = copy_of<std::uint16_t>(array); break;
    case VoxelType::int32: voxels.data = copy_of<std::int32_t>(array); break;
    case VoxelType::float32: voxels.data = copy_of<float>(array); break;
    case VoxelType::float64: voxels.data = copy_of<double>(array); break;
  }
  return voxels;
}

/// Reason why an array cannot be felt, half a sentence; empty: none.
inline std::string why_not_felt(vtkAbstractArray& array, const std::string& name, std::int64_t tuples) {
  const int components = array.GetNumberOfComponents();
  if (!vtkDataArray::SafeDownCast(&array) || !numbers_of(array.GetDataType())) return "it holds no numbers";
  if (components != 1 && components != 3) return std::to_string(components) + " components; one or three can be felt";
  if (components == 3 && array.GetDataType() == VTK_UNSIGNED_CHAR) return "three bytes are a colour, not a vector";
  if (array.GetNumberOfTuples() != tuples)
    return "it has " + std::to_string(array.GetNumberOfTuples()) + " values for " + std::to_string(tuples) + " places";
  return name == "vtkGhostType" ? "it marks ghosts, not data" : "";
}

/// Fields of a grid's points and cells.
inline Volume volume_of(vtkDataSet& data, const VtkGrids& grids, bool copy) {
  Volume volume;
  volume.format = "grid";
  std::set<std::string> names;
  for (const bool of_cells : {false, true}) {
    vtkFieldData& arrays = of_cells ? static_cast<vtkFieldData&>(*data.GetCellData()) : *data.GetPointData();
    const GridGeometry& grid = of_cells ? grids.cells : grids.points;
    for (int n = 0; n < arrays.GetNumberOfArrays(); ++n) {
      vtkAbstractArray& array = *arrays.GetAbstractArray(n);
      const std::string called = array.GetName() && *array.GetName() ? array.GetName() : "array_" + std::to_string(n);
      if (const std::string why = why_not_felt(array, called, grid.voxels()); !why.empty()) {
        if (called != "vtkGhostType") volume.warnings.push_back("array '" + called + "' is left out: " + why);
        continue;
      }
      std::string name = called;
      for (int again = 2; !names.insert(name).second; ++again)
        name = called + (of_cells ? "_cells" : "_") + (of_cells && again == 2 ? "" : std::to_string(again));
      auto& numbers = static_cast<vtkDataArray&>(array);
      volume.fields.push_back({.name = name,
                               .unit = {},
                               .field = unread_grid_field(grid, voxels_of(numbers, *numbers_of(array.GetDataType()), copy))});
    }
  }
  if (volume.fields.empty()) {
    throw LoadError(volume.warnings.empty()
                        ? "has no array; one with 1 or 3 numbers for each point or cell is needed"
                        : "has no array that can be felt (" + volume.warnings.back() + "); one with 1 or 3 numbers is needed");
  }
  return volume;
}

/// Folder removed with its owner.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "palpa-from-vtk-XXXXXX").string();
    if (!::mkdtemp(name.data())) throw LoadError("cannot be resampled: no folder for a file on its way; set TMPDIR");
    path = name;
  }
  ~TemporaryFolder() {
    std::error_code none;
    std::filesystem::remove_all(path, none);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::filesystem::path path;
};

/// Resampled volume with its error, by `read_volume` of a temporary VTK file.
inline Volume resampled(vtkDataSet& data, const FromVtkOptions& options) {
  const TemporaryFolder folder;
  vtkNew<vtkXMLDataSetWriter> writer;
  writer->SetInputData(&data);
  const std::filesystem::path file = folder.path / "data.xml";
  writer->SetFileName(file.c_str());
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetCompressorTypeToNone();
  writer->SetHeaderTypeToUInt64();
  if (writer->Write() != 1)
    throw LoadError("cannot be resampled: VTK cannot write it into a file on its way; make room, or set TMPDIR");
  ReadOptions read = options.read;
  read.checksums = Checksums::none;
  Volume volume;
  try {
    volume = read_volume(file, read);
  } catch (const LoadError& error) {
    // the temporary name is internal
    std::string what = error.what();
    if (const std::string place = file.string() + ": "; what.rfind(place, 0) == 0) what.erase(0, place.size());
    throw LoadError(what);
  }
  volume.files.clear();
  volume.request.reset();
  volume.length_unit.clear();
  return options.metres_per_unit == 1.0 ? volume : posed(volume, {.scale = options.metres_per_unit});
}

}  // namespace detail

/// Volume of VTK data: every array of one or three numbers of its points and cells becomes a field of that name.
///
/// vtkImageData and vtkRectilinearGrid become grids on the arrays in place, in constant time, if their memory layout is that of
/// voxels (not `copy`; 8-bit unsigned, 16-bit, int, float, double; not arrays of structures, which are copied). The fields keep
/// the arrays alive; the arrays must not change: use `copy` if the pipeline continues. Cells become voxels at their centres.
/// Other data (curvilinear, unstructured, with blank points or cells) are processed like a file: by palpa-read (see
/// read_volume.h), which resamples them and reports the error (`resampling`, `warnings`). Ghost cells that repeat a neighbour's
/// are ordinary data. Allocates; one thread at a time per data set. Throws LoadError, one line, beginning with the data's
/// class.
inline Volume from_vtk(vtkDataSet* data, const FromVtkOptions& options = {}) {
  if (!data) throw LoadError("vtkDataSet: is none; give one that its filter has updated");
  const std::string place = std::string(data->GetClassName()) + ": ";
  if (!(options.metres_per_unit > 0.0) || !std::isfinite(options.metres_per_unit))
    throw LoadError(place + "metres_per_unit is no length; give metres above 0");
  try {
    if (!detail::has_blanks(*data)) {
      if (auto* image = vtkImageData::SafeDownCast(data))
        return detail::volume_of(*image, detail::grids_of(*image, options.metres_per_unit), options.copy);
      if (auto* grid = vtkRectilinearGrid::SafeDownCast(data))
        return detail::volume_of(*grid, detail::grids_of(*grid, options.metres_per_unit), options.copy);
    }
    if (data->GetNumberOfCells() == 0) throw LoadError("has no cells; give one with a volume");
    return detail::resampled(*data, options);
  } catch (const LoadError& error) {
    throw LoadError(place + error.what());
  } catch (const std::invalid_argument& error) {
    throw LoadError(place + "cannot be placed in the world (" + error.what() + "); correct its geometry");
  }
}

}  // namespace palpa
