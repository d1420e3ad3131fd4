// OpenFOAM cases: a folder with a mesh and fields at several times.
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkInformation.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkNew.h>
#include <vtkOpenFOAMReader.h>
#include <vtkPointData.h>
#include <vtkStreamingDemandDrivenPipeline.h>
#include <vtkUnstructuredGrid.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>

#include "file_names.h"
#include "first_bytes.h"
#include "messages.h"
#include "source.h"
#include "vtk_data.h"

namespace palpa::reader {
namespace {

namespace fs = std::filesystem;

/// Removes units such as " [m/s]" from the names of arrays and returns them by name.
std::map<std::string, std::string> take_units(vtkFieldData& arrays) {
  std::map<std::string, std::string> units;
  for (int a = 0; a < arrays.GetNumberOfArrays(); ++a) {
    vtkAbstractArray* array = arrays.GetAbstractArray(a);
    const std::string name = array->GetName() != nullptr ? array->GetName() : "";
    const std::size_t at = name.find(" [");
    if (at == std::string::npos || name.back() != ']') continue;
    units[name.substr(0, at)] = name.substr(at + 2, name.size() - at - 3);
    array->SetName(name.substr(0, at).c_str());
  }
  return units;
}

/// Files of the mesh and of one time.
std::vector<std::string> files_of(const fs::path& folder, const std::string& region, double time_s) {
  std::vector<std::string> files{(folder / "system" / "controlDict").string()};
  std::error_code problem;
  std::vector<fs::path> parts{folder / "constant" / region / "polyMesh"};
  for (fs::directory_iterator entry(folder, problem), end; !problem && entry != end; entry.increment(problem)) {
    const std::string name = entry->path().filename().string();
    char* rest = nullptr;
    const double value = std::strtod(name.c_str(), &rest);
    std::error_code gone;
    if (*rest == '\0' && value == time_s && entry->is_directory(gone)) parts.push_back(entry->path() / region);
  }
  for (const fs::path& part : parts) {
    for (fs::directory_iterator entry(part, problem), end; !problem && entry != end; entry.increment(problem)) {
      std::error_code gone;
      if (entry->is_regular_file(gone)) files.push_back(entry->path().string());
    }
  }
  std::sort(files.begin() + 1, files.end());
  return files;
}

/// Regions of a case with a mesh, each in a folder of its own.
std::vector<std::string> regions_of(const fs::path& folder) {
  std::vector<std::string> regions;
  std::error_code problem, ignored;
  for (fs::directory_iterator entry(folder / "constant", problem), end; !problem && entry != end; entry.increment(problem)) {
    if (fs::exists(entry->path() / "polyMesh", ignored)) regions.push_back(entry->path().filename().string());
  }
  std::ranges::sort(regions);
  return regions;
}

/// Region to read: the named one, else the case's own mesh, which has no name, else the only one. Throws LoadError.
std::string chosen_region(const fs::path& folder, const protocol::Request& request) {
  const std::vector<std::string> regions = regions_of(folder);
  std::string all;
  for (const std::string& region : regions) all += (all.empty() ? "" : ", ") + region;
  if (!request.inside.empty()) {
    const std::string wanted = request.inside.substr(1);
    if (std::ranges::find(regions, wanted) != regions.end()) return wanted;
    throw LoadError("has no region '" + wanted + "' with a mesh; " +
                    (regions.empty() ? "it has none: give the case alone" : "it has " + all));
  }
  std::error_code ignored;
  if (fs::exists(folder / "constant" / "polyMesh", ignored)) return {};
  if (regions.size() == 1) return regions.front();
  if (regions.size() > 1)
    throw LoadError("is a case of several regions (" + all + "); name one behind the folder: CASE:/" + regions.front());
  throw LoadError(fs::exists(folder / "processor0", ignored)
                      ? "is a case in pieces (processor0, …); put it together with reconstructPar"
                      : "is a case without constant/polyMesh; get the whole case, or make its mesh");
}

struct Widths {
  bool labels_64 = false, floats_64 = true;
};

/// Sizes to try in order: all for binary files without `arch`; else one, as the library reads `arch` itself.
std::vector<Widths> possible_widths(const fs::path& folder, const std::string& region) {
  for (const char* name : {"owner", "owner.gz"}) {
    const fs::path owner = folder / "constant" / region / "polyMesh" / name;
    std::error_code ignored;
    if (!fs::is_regular_file(owner, ignored)) continue;
    const std::string start = first_bytes(owner.string());
    if (start.find("arch") == std::string::npos && start.find("binary") != std::string::npos)
      return {{false, true}, {true, true}, {false, false}, {true, false}};
  }
  return {{}};
}

vtkSmartPointer<vtkDataSet> mesh_in(vtkMultiBlockDataSet* blocks) {
  for (unsigned int b = 0; blocks != nullptr && b < blocks->GetNumberOfBlocks(); ++b) {
    vtkDataObject* block = blocks->GetBlock(b);
    vtkSmartPointer<vtkDataSet> mesh = vtkUnstructuredGrid::SafeDownCast(block);
    if (mesh == nullptr) mesh = mesh_in(vtkMultiBlockDataSet::SafeDownCast(block));
    if (mesh != nullptr) return mesh;
  }
  return nullptr;
}

struct CaseAtMoment {
  vtkSmartPointer<vtkDataSet> mesh;
  std::vector<double> times_s;  ///< of the case
  double time_s = 0.0;
};

/// Reads it, or stores the library's error in `problem`. Throws LoadError if the time does not exist.
CaseAtMoment read_case(const fs::path& folder, const std::string& region, const protocol::Request& request, Widths widths,
                       std::string& problem) {
  vtkNew<vtkOpenFOAMReader> reader;
  reader->SetFileName((folder / "system" / "controlDict").c_str());
  reader->SetUse64BitLabels(widths.labels_64);
  reader->SetUse64BitFloats(widths.floats_64);
  reader->CreateCellToPointOff();
  reader->DecomposePolyhedraOn();
  reader->AddDimensionsToArrayNamesOn();
  const auto has_failed = [&] {
    if (!library_complained() && reader->GetErrorCode() == 0) return false;
    problem = take_library_error();
    return true;
  };
  CaseAtMoment made;
  reader->UpdateInformation();
  if (has_failed()) return made;
  vtkInformation* info = reader->GetOutputInformation(0);
  for (int t = 0; t < info->Length(vtkStreamingDemandDrivenPipeline::TIME_STEPS()); ++t)
    made.times_s.push_back(info->Get(vtkStreamingDemandDrivenPipeline::TIME_STEPS(), t));
  made.time_s = chosen_time(made.times_s, request.time_s);
  reader->DisableAllPatchArrays();
  for (int p = 0; p < reader->GetNumberOfPatchArrays(); ++p) {  // patches of regions have names like paths
    const std::string name = reader->GetPatchArrayName(p), path = name.starts_with("/") ? name.substr(1) : name;
    if (path == (region.empty() ? "internalMesh" : region + "/internalMesh")) reader->SetPatchArrayStatus(name.c_str(), 1);
  }
  reader->EnableAllCellArrays();
  reader->DisableAllPointArrays();
  reader->DisableAllLagrangianArrays();
  reader->UpdateTimeStep(made.time_s);
  if (!has_failed()) made.mesh = mesh_in(vtkMultiBlockDataSet::SafeDownCast(reader->GetOutputDataObject(0)));
  return made;
}

}  // namespace

std::unique_ptr<Source> open_openfoam(const protocol::Request& request) {
  const fs::path folder = openfoam_case(request.path);
  const std::string region = chosen_region(folder, request);
  CaseAtMoment read;
  std::string first_problem;
  for (const Widths widths : possible_widths(folder, region)) {
    std::string problem;
    read = read_case(folder, region, request, widths, problem);
    if (problem.empty()) {
      first_problem.clear();
      break;
    }
    if (first_problem.empty()) first_problem = problem;
  }
  if (!first_problem.empty())
    throw LoadError("cannot be read as an OpenFOAM case (" + first_problem + "); check that it is whole");
  if (read.mesh == nullptr) throw LoadError("has no internal mesh that can be read; check that the case is whole");
  const std::map<std::string, std::string> units = take_units(*read.mesh->GetCellData());
  auto source =
      source_of(request, "openfoam", {read.mesh}, files_of(folder, region, read.time_s), [&](const std::string& name) {
        const auto found = units.find(name);
        return found != units.end() ? found->second : std::string();
      });
  source->takes.time = true, source->takes.inside = true;
  source->header.length_unit = "m";
  if (!region.empty() && request.inside.empty())
    source->header.warnings.push_back("has its mesh in one region, '" + region + "', which is read");
  if (!request.time_s) warn_of_moments(read.times_s, source->header.warnings);
  return source;
}

}  // namespace palpa::reader
