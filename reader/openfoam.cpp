// Cases of OpenFOAM: a folder with a mesh and the fields of several moments.
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
#include "messages.h"
#include "palpa/core/printed.h"
#include "source.h"
#include "vtk_data.h"

namespace palpa::reader {
namespace {

namespace fs = std::filesystem;

std::string in_words(double time_s) { return detail::text("%.9g", time_s); }

/// The moment to read [s]: the one asked for, else the latest. Throws LoadError if the case does not have it.
/// \param times_s  [s] of the case, in rising order
double chosen_time(const std::vector<double>& times_s, const std::optional<double>& wanted_s) {
  if (times_s.empty()) throw LoadError("has no folder of a moment with fields; run the case, or get its results");
  if (!wanted_s) return times_s.back();
  const auto nearest = *std::min_element(times_s.begin(), times_s.end(),
                                         [&](double a, double b) { return std::abs(a - *wanted_s) < std::abs(b - *wanted_s); });
  if (std::abs(nearest - *wanted_s) <= 1e-6 * std::max(1.0, std::abs(*wanted_s))) return nearest;
  throw LoadError("has no moment " + in_words(*wanted_s) + " s among its " + std::to_string(times_s.size()) + " from " +
                  in_words(times_s.front()) + " to " + in_words(times_s.back()) + " s; the nearest is " + in_words(nearest));
}

/// Takes units such as " [m/s]" off the names of arrays and returns them by name.
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

/// The files of the mesh and of one moment.
std::vector<std::string> files_of(const fs::path& folder, double time_s) {
  std::vector<std::string> files{(folder / "system" / "controlDict").string()};
  std::error_code problem;
  std::vector<fs::path> parts{folder / "constant" / "polyMesh"};
  for (fs::directory_iterator entry(folder, problem), end; !problem && entry != end; entry.increment(problem)) {
    const std::string name = entry->path().filename().string();
    char* rest = nullptr;
    const double value = std::strtod(name.c_str(), &rest);
    std::error_code gone;
    if (*rest == '\0' && value == time_s && entry->is_directory(gone)) parts.push_back(entry->path());
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

}  // namespace

std::unique_ptr<Source> open_openfoam(const protocol::Request& request) {
  const fs::path folder = openfoam_case(request.path);
  std::error_code ignored;
  if (!fs::exists(folder / "constant" / "polyMesh", ignored)) {
    throw LoadError(fs::exists(folder / "processor0", ignored)
                        ? "is a case in pieces (processor0, …); put it together with reconstructPar"
                        : "is a case without constant/polyMesh; get the whole case, or make its mesh");
  }
  vtkNew<vtkOpenFOAMReader> reader;
  reader->SetFileName((folder / "system" / "controlDict").c_str());
  reader->CreateCellToPointOff();
  reader->DecomposePolyhedraOn();
  reader->AddDimensionsToArrayNamesOn();
  reader->UpdateInformation();
  const auto check = [&] {
    if (library_complained() || reader->GetErrorCode() != 0)
      throw LoadError("cannot be read as an OpenFOAM case (" + take_library_error() + "); check that it is whole");
  };
  check();
  std::vector<double> times_s;
  vtkInformation* info = reader->GetOutputInformation(0);
  for (int t = 0; t < info->Length(vtkStreamingDemandDrivenPipeline::TIME_STEPS()); ++t)
    times_s.push_back(info->Get(vtkStreamingDemandDrivenPipeline::TIME_STEPS(), t));
  const double time_s = chosen_time(times_s, request.time_s);
  reader->DisableAllPatchArrays();
  reader->SetPatchArrayStatus("internalMesh", 1);
  reader->EnableAllCellArrays();
  reader->DisableAllPointArrays();
  reader->DisableAllLagrangianArrays();
  reader->UpdateTimeStep(time_s);
  check();

  auto* blocks = vtkMultiBlockDataSet::SafeDownCast(reader->GetOutputDataObject(0));
  vtkSmartPointer<vtkDataSet> mesh;
  for (unsigned int b = 0; blocks != nullptr && b < blocks->GetNumberOfBlocks() && mesh == nullptr; ++b)
    mesh = vtkUnstructuredGrid::SafeDownCast(blocks->GetBlock(b));
  if (mesh == nullptr) throw LoadError("has no internal mesh that can be read; check that the case is whole");
  const std::map<std::string, std::string> units = take_units(*mesh->GetCellData());
  auto source = source_of(request, "openfoam", {mesh}, files_of(folder, time_s), [&](const std::string& name) {
    const auto found = units.find(name);
    return found != units.end() ? found->second : std::string();
  });
  source->takes.time = true;
  source->header.length_unit = "m";
  if (!request.time_s && times_s.size() > 1) {
    source->header.warnings.push_back("holds " + std::to_string(times_s.size()) + " moments: the latest, " + in_words(time_s) +
                                      " s, is read (time = seconds takes another)");
  }
  return source;
}

}  // namespace palpa::reader
