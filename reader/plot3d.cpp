// PLOT3D: a grid and its solution in two files, without a mark or a description of their number storage.
#include <vtkDataArray.h>
#include <vtkDataSetAttributes.h>
#include <vtkFloatArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkMultiBlockPLOT3DReader.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkStructuredGrid.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "file_names.h"
#include "messages.h"
#include "plot3d_text.h"
#include "source.h"
#include "vtk_data.h"

namespace palpa::reader {
namespace {

namespace fs = std::filesystem;

constexpr double gamma = 1.4;  // ratio of specific heats, for files without one

/// True if the density is 1 at all points with data: an incompressible solution, without energy or speed of sound, and with
/// velocities divided by the inflow's.
bool is_incompressible(const std::vector<vtkSmartPointer<vtkDataSet>>& blocks) {
  constexpr double rounding = 1e-6;  // [1] More: a nearly incompressible gas counts as a liquid; less: single precision
  bool any = false;
  for (const auto& block : blocks) {
    vtkDataArray* density = block->GetPointData()->GetArray("Density");
    vtkUnsignedCharArray* ghosts = block->GetPointGhostArray();
    for (vtkIdType p = 0; density != nullptr && p < density->GetNumberOfTuples(); ++p) {
      if (ghosts != nullptr && (ghosts->GetValue(p) & vtkDataSetAttributes::HIDDENPOINT) != 0) continue;
      if (!(std::abs(density->GetComponent(p, 0) - 1.0) <= rounding)) return false;
      any = true;
    }
  }
  return any;
}

/// Renames the fifth number of an incompressible solution, which is no energy, to a neutral name; removes it if it is 0
/// everywhere.
void name_fifth(vtkPointData& data, vtkDataArray* fifth) {
  if (fifth == nullptr) return;
  double range[2];
  fifth->GetRange(range);
  fifth->SetName("q5");
  if (range[0] == 0.0 && range[1] == 0.0) data.RemoveArray("q5");
}

/// Derives velocity and, for a gas, pressure and Mach number from VTK's arrays.
void derive(vtkStructuredGrid& grid, bool incompressible, std::vector<std::string>& warnings) {
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
  data.AddArray(velocity);
  if (incompressible) return name_fifth(data, energy);
  if (energy != nullptr) energy->SetName("energy");
  if (any_energy) {
    data.AddArray(pressure);
    data.AddArray(mach);
  } else if (warnings.empty()) {
    warnings.emplace_back("has energy 0 everywhere: pressure and Mach number cannot be told");
  }
}

/// Refuses blocks of more points than the file can hold: VTK trusts the header's count and, if it overflows, writes beyond its
/// memory.
class CheckedReader : public vtkMultiBlockPLOT3DReader {
 public:
  static CheckedReader* New() { VTK_STANDARD_NEW_BODY(CheckedReader); }
  double most_points = 0;  ///< per block

 protected:
  int ReadVector(void* file, int extent[6], int whole[6], int components, vtkDataArray* vector, vtkTypeUInt64 offset,
                 const vtkMultiBlockPLOT3DReaderRecord& record) override {
    double points = 1;
    for (int a = 0; a < 3; ++a) points *= std::max(0.0, static_cast<double>(whole[2 * a + 1]) - whole[2 * a] + 1);
    if (points < 1 || points > most_points) return 0;
    return vtkMultiBlockPLOT3DReader::ReadVector(file, extent, whole, components, vector, offset, record);
  }
};

std::string unit_of(const std::string& name, bool incompressible) {
  if (name == "density") return "ρ∞";
  if (incompressible) return name == "velocity" ? "U∞" : name == "momentum" ? "ρ∞·U∞" : "";
  if (name == "velocity") return "a∞";
  if (name == "momentum") return "ρ∞·a∞";
  if (name == "pressure" || name == "energy") return "ρ∞·a∞²";
  return {};
}

std::vector<vtkSmartPointer<vtkDataSet>> read_binary(const fs::path& grid, const fs::path& solution) {
  vtkNew<CheckedReader> reader;
  reader->most_points = static_cast<double>(file_bytes(grid.string()));  // a point takes more than a byte
  reader->SetXYZFileName(grid.c_str());
  reader->SetQFileName(solution.c_str());
  reader->AutoDetectFormatOn();
  reader->RemoveAllFunctions();
  reader->SetScalarFunctionNumber(-1);
  reader->SetVectorFunctionNumber(202);  // momentum, as stored
  reader->Update();
  if (library_complained() || reader->GetErrorCode() != 0) {
    throw LoadError("cannot be read as PLOT3D (" + take_library_error() +
                    "); check that grid and solution are whole and belong together");
  }
  std::vector<vtkSmartPointer<vtkDataSet>> blocks;
  auto* all = vtkMultiBlockDataSet::SafeDownCast(reader->GetOutputDataObject(0));
  for (unsigned int b = 0; all != nullptr && b < all->GetNumberOfBlocks(); ++b) {
    if (auto* block = vtkStructuredGrid::SafeDownCast(all->GetBlock(b))) blocks.emplace_back(block);
  }
  return blocks;
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
  const bool is_text = is_plot3d_text(grid.string());
  if (is_text != is_plot3d_text(solution.string()))
    throw LoadError("is PLOT3D of which one file is text and the other binary; write both in one way");
  std::vector<vtkSmartPointer<vtkDataSet>> blocks =
      is_text ? read_plot3d_text(grid.string(), solution.string()) : read_binary(grid, solution);
  const bool incompressible = is_incompressible(blocks);
  std::vector<std::string> warnings;
  for (const auto& block : blocks) derive(static_cast<vtkStructuredGrid&>(*block), incompressible, warnings);
  if (incompressible)
    warnings.emplace_back(
        "has density 1 everywhere, as an incompressible fluid: velocities are in U∞, there are no pressure and no Mach number, "
        "and q5 is what stands in the place of the energy, if that is not 0");
  auto source = source_of(request, "plot3d", std::move(blocks), {grid.string(), solution.string()},
                          [&](const std::string& name) { return unit_of(name, incompressible); });
  source->takes.partners = true;
  source->header.warnings.insert(source->header.warnings.end(), warnings.begin(), warnings.end());
  return source;
}

}  // namespace palpa::reader
