#include "vtk_data.h"

#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkRectilinearGrid.h>
#include <vtkStructuredGrid.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "palpa/base/printed.h"
#include "resample.h"

namespace palpa::reader {
namespace {

std::string in_words(double time_s) { return detail::text("%.9g", time_s); }

constexpr std::size_t max_fields = 200;  // of one file; a warning reports the rest

/// Number type of a VTK type; false if it cannot be read.
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

/// Unique name of a field; if points and cells share a name, the cells' name is marked.
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

/// Calls act(name, type, components, of_cells) for every array; gives names to arrays without one.
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

/// Data set as a point set with movable points; blanks are kept.
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

bool lacks(vtkDataSet& block, const std::string& name, int components, bool of_cells) {
  vtkFieldData& arrays = of_cells ? static_cast<vtkFieldData&>(*block.GetCellData()) : *block.GetPointData();
  vtkDataArray* array = arrays.GetArray(name.c_str());
  return array == nullptr || array->GetNumberOfComponents() != components;
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
    choose_frames(request, 1);
    if (const std::string said = resampler_.description(); !said.empty()) header.warnings.push_back(said);
    std::set<std::string> names, lacking;
    bool of_cells_too = false;
    for_arrays(*blocks.front(), [&](const std::string& name, int type, int components, bool of_cells) {
      RawType raw;
      if (const std::string why = why_left_out(name, type, components, raw); !why.empty()) {
        if (name != "vtkGhostType") header.warnings.push_back("array '" + name + "' is left out: " + why);
        return;
      }
      if (header.fields.size() >= max_fields) return;
      if (std::ranges::any_of(blocks, [&](const auto& block) { return lacks(*block, name, components, of_cells); })) {
        lacking.insert(name);
        return;
      }
      protocol::FieldHeader field;
      field.name = own_name(names, name, of_cells);
      field.components = components;
      field.grid = resampler_.grid();
      header.fields.push_back(field);
      arrays_.push_back({name, of_cells, components});
      header.working_bytes += resampler_.working_bytes(components);
      of_cells_too = of_cells_too || of_cells;
    });
    for (const auto& block : blocks) {
      for_arrays(*block, [&](const std::string& name, int type, int components, bool of_cells) {
        RawType raw;
        if (why_left_out(name, type, components, raw).empty() && lacks(*blocks.front(), name, components, of_cells))
          lacking.insert(name);
      });
    }
    for (const std::string& name : lacking)
      header.warnings.push_back("array '" + name + "' is left out: some blocks do not have it");
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
    constexpr double much_lost = 0.05;  // of the volume. Less: more warnings; more: losses that are felt go unreported
    if (!made.empty() && made.front().report.by_volume.covered < 1.0 - much_lost) {
      char text[300];
      std::snprintf(text, sizeof text,
                    "lost %.0f %% of its volume when resampled: cells that are thinner than a step of the new grid, and those "
                    "at its walls, have no data there; crop_m makes a part finer",
                    100.0 * (1.0 - made.front().report.by_volume.covered));
      warnings.emplace_back(text);
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
  std::vector<ArrayName> arrays_;  ///< one per field
};

}  // namespace

std::string why_left_out(const std::string& name, int vtk_type, int components, RawType& type) {
  if (name == "vtkGhostType") return "it marks ghosts, not data";
  if (!find_raw_type(vtk_type, type)) return "it holds no numbers";
  if (components != 1 && components != 3) return std::to_string(components) + " components; one or three can be felt";
  if (components == 3 && type == RawType::uint8) return "three bytes are a colour, not a vector";
  return {};
}

GridSource::GridSource(const protocol::Request& request, const char* format) {
  header.format = format;
  header.default_unit = "m";
  header.named = true;
  takes.index_axes = true;
  along_index_ = request.components_along == "index";
  files.push_back(request.path);
  choose_frames(request, 1);
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
  field.name = own_name(names_, name, of_cells);
  VectorTurn turn;
  if (along_index_) turn.axes = protocol::unit_axes(grid);
  std::vector<std::string> notes;
  keep(raw, turn, field, notes);
  arrays_.push_back({name, of_cells, raw, turn});
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
      copy_voxels(voxels->GetVoidPointer(0), array.raw, array.turn, header.fields[wanted[i]], to[i]);
    }
    arrays.RemoveArray(array.name.c_str());
  }
}

double chosen_time(const std::vector<double>& times_s, const std::optional<double>& wanted_s) {
  if (times_s.empty()) throw LoadError("has no folder of a moment with fields; run the case, or get its results");
  if (!wanted_s) return times_s.back();
  const auto nearest = *std::min_element(times_s.begin(), times_s.end(),
                                         [&](double a, double b) { return std::abs(a - *wanted_s) < std::abs(b - *wanted_s); });
  if (std::abs(nearest - *wanted_s) <= 1e-6 * std::max(1.0, std::abs(*wanted_s))) return nearest;
  throw LoadError("has no moment " + in_words(*wanted_s) + " s among its " + std::to_string(times_s.size()) + " from " +
                  in_words(times_s.front()) + " to " + in_words(times_s.back()) + " s; the nearest is " + in_words(nearest));
}

void warn_of_moments(const std::vector<double>& times_s, std::vector<std::string>& warnings) {
  if (times_s.size() > 1)
    warnings.push_back("holds " + std::to_string(times_s.size()) + " moments: the latest, " + in_words(times_s.back()) +
                       " s, is read (time = seconds takes another)");
}

std::unique_ptr<Source> source_of(const protocol::Request& request, const char* format,
                                  std::vector<vtkSmartPointer<vtkDataSet>> blocks, std::vector<std::string> files,
                                  const std::function<std::string(const std::string&)>& unit_of) {
  std::erase_if(blocks, [](const auto& block) { return block == nullptr || block->GetNumberOfCells() == 0; });
  if (blocks.empty()) throw LoadError("has no cells; give a file with a volume");
  for (const auto& block : blocks) check_cells(*block);
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
