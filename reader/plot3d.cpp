// PLOT3D: a grid and its solution in two files, which do not say what they are or how their numbers are stored.
#include <vtkDataArray.h>
#include <vtkFloatArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkMultiBlockPLOT3DReader.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkStructuredGrid.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "file_names.h"
#include "messages.h"
#include "source.h"
#include "vtk_data.h"

namespace palpa::reader {
namespace {

namespace fs = std::filesystem;

constexpr double gamma = 1.4;  // ratio of specific heats, of a file that says none

/// What VTK makes of a solution, and what follows from it: velocity, pressure and Mach number.
void derive(vtkStructuredGrid& grid, std::vector<std::string>& warnings) {
  vtkPointData& data = *grid.GetPointData();
  vtkDataArray* density = data.GetArray("Density");
  vtkDataArray* momentum = data.GetArray("Momentum");
  vtkDataArray* energy = data.GetArray("StagnationEnergy");
  if (density == nullptr || momentum == nullptr) throw LoadError("has no density and momentum; give a whole solution (q) file");
  const vtkIdType count = density->GetNumberOfTuples();
  vtkNew<vtkFloatArray> velocity, pressure, mach;
  velocity->SetName("velocity"), pressure->SetName("pressure"), mach->SetName("mach");
  velocity->SetNumberOfComponents(3);
  for (vtkFloatArray* array : {velocity.Get(), pressure.Get(), mach.Get()}) array->SetNumberOfTuples(count);
  bool any_energy = false;
  for (vtkIdType p = 0; p < count; ++p) {
    double m[3];
    momentum->GetTuple(p, m);
    const double rho = density->GetComponent(p, 0), e = energy != nullptr ? energy->GetComponent(p, 0) : 0.0;
    const Vec3 u = rho != 0.0 ? Vec3{m[0], m[1], m[2]} / rho : Vec3{};
    const double of_heat = (gamma - 1.0) * (e - 0.5 * rho * dot(u, u));
    velocity->SetTuple3(p, u.x, u.y, u.z);
    pressure->SetValue(p, static_cast<float>(of_heat));
    mach->SetValue(p, of_heat > 0.0 && rho > 0.0 ? static_cast<float>(norm(u) / std::sqrt(gamma * of_heat / rho)) : 0.0F);
    any_energy = any_energy || e != 0.0;
  }
  density->SetName("density"), momentum->SetName("momentum");
  if (energy != nullptr) energy->SetName("energy");
  data.AddArray(velocity);
  if (any_energy) {
    data.AddArray(pressure);
    data.AddArray(mach);
  } else if (warnings.empty()) {
    warnings.emplace_back("has energy 0 everywhere: pressure and Mach number cannot be told");
  }
}

/// Refuses blocks of more points than the file can hold: VTK reads as many as a header says and, where that number overflows,
/// writes beyond its memory.
class CheckedReader : public vtkMultiBlockPLOT3DReader {
 public:
  static CheckedReader* New() { VTK_STANDARD_NEW_BODY(CheckedReader); }
  double most_points = 0;  ///< in a block

 protected:
  int ReadVector(void* file, int extent[6], int whole[6], int components, vtkDataArray* vector, vtkTypeUInt64 offset,
                 const vtkMultiBlockPLOT3DReaderRecord& record) override {
    double points = 1;
    for (int a = 0; a < 3; ++a) points *= std::max(0.0, static_cast<double>(whole[2 * a + 1]) - whole[2 * a] + 1);
    if (points < 1 || points > most_points) return 0;
    return vtkMultiBlockPLOT3DReader::ReadVector(file, extent, whole, components, vector, offset, record);
  }
};

std::string unit_of(const std::string& name) {
  if (name == "density") return "ρ∞";
  if (name == "velocity") return "a∞";
  if (name == "momentum") return "ρ∞·a∞";
  if (name == "pressure" || name == "energy") return "ρ∞·a∞²";
  return {};
}

}  // namespace

std::unique_ptr<Source> open_plot3d(const protocol::Request& request) {
  fs::path grid = request.path, solution;
  if (!request.partners.empty()) {
    if (request.partners.size() > 1)
      throw LoadError("comes with " + std::to_string(request.partners.size()) +
                      " more files; a grid (xyz) and its solution (q) are two");
    solution = request.partners.front();
  } else {
    solution = plot3d_partner(grid);
    if (solution.empty()) {
      throw LoadError(
          plot3d_part(grid) == Plot3dPart::solution
              ? "is a PLOT3D solution without its grid; put the xyz file beside it, or name both ('file' of a scene, --with)"
              : "is a PLOT3D grid without its solution; put the q file beside it, or name both ('file' of a scene, --with)");
    }
  }
  if (plot3d_part(grid) == Plot3dPart::solution) std::swap(grid, solution);

  constexpr std::uint64_t shortest_bytes = 36;  // three counts and two points; VTK crashes on some shorter files
  if (file_bytes(grid.string()) < shortest_bytes) throw LoadError("is shorter than any PLOT3D grid; get the whole file");
  vtkNew<CheckedReader> reader;
  reader->most_points = static_cast<double>(file_bytes(grid.string()));  // a point takes more than a byte
  reader->SetXYZFileName(grid.c_str());
  reader->SetQFileName(solution.c_str());
  reader->AutoDetectFormatOn();
  reader->RemoveAllFunctions();
  reader->SetScalarFunctionNumber(-1);
  reader->SetVectorFunctionNumber(202);  // momentum, as the file has it
  reader->Update();
  if (library_complained() || reader->GetErrorCode() != 0) {
    throw LoadError("cannot be read as PLOT3D (" + take_library_error() +
                    "); check that grid and solution are whole and belong "
                    "together");
  }
  std::vector<vtkSmartPointer<vtkDataSet>> blocks;
  std::vector<std::string> warnings;
  auto* all = vtkMultiBlockDataSet::SafeDownCast(reader->GetOutputDataObject(0));
  for (unsigned int b = 0; all != nullptr && b < all->GetNumberOfBlocks(); ++b) {
    auto* block = vtkStructuredGrid::SafeDownCast(all->GetBlock(b));
    if (block == nullptr) continue;
    derive(*block, warnings);
    blocks.emplace_back(block);
  }
  auto source = source_of(request, "plot3d", std::move(blocks), {grid.string(), solution.string()}, unit_of);
  source->takes.partners = true;
  source->header.warnings.insert(source->header.warnings.end(), warnings.begin(), warnings.end());
  return source;
}

}  // namespace palpa::reader
