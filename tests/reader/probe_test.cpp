// Non-affine grids against VTK's own probe of the original data at random points.
#include <vtkAutoInit.h>
#include <vtkDataSetReader.h>
#include <vtkGenericCell.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkMultiBlockPLOT3DReader.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkProbeFilter.h>
#include <vtkSmartPointer.h>
#include <vtkStructuredGrid.h>

#include <cmath>
#include <random>

#include "files.h"

namespace palpa::test {
namespace probe_test {

class Probe : public ReaderTest {
 protected:
  void SetUp() override {
    ReaderTest::SetUp();
    if (!IsSkipped() && shared_file("facts.json").empty())
      GTEST_SKIP() << "the shared data are not here: set PALPA_SHARED to their folder";
  }
};

/// A PLOT3D grid with its solution, read by VTK instead of palpa-read: velocity by VTK's own function.
vtkSmartPointer<vtkStructuredGrid> plot3d(const std::string& grid, const std::string& solution) {
  vtkNew<vtkMultiBlockPLOT3DReader> reader;
  reader->SetXYZFileName(shared_file(grid).c_str());
  reader->SetQFileName(shared_file(solution).c_str());
  reader->SetByteOrderToBigEndian();
  reader->SetScalarFunctionNumber(100);
  reader->SetVectorFunctionNumber(202);
  reader->AddFunction(200);
  reader->Update();
  return vtkStructuredGrid::SafeDownCast(reader->GetOutput()->GetBlock(0));
}

double share(std::mt19937& random) { return static_cast<double>(random()) / 4294967296.0; }

/// Points within the grid, from the corners of its cells: in random cells, or evenly in space by rejection.
std::vector<Vec3> places_in(vtkDataSet& data, int count, bool by_volume, unsigned seed) {
  std::mt19937 random(seed);
  vtkNew<vtkGenericCell> cell;
  std::vector<Vec3> places;
  double bounds[6], weights[8], parametric[3];
  data.GetBounds(bounds);
  while (static_cast<int>(places.size()) < count) {
    double at[3];
    if (by_volume) {
      for (int a = 0; a < 3; ++a) at[a] = bounds[2 * a] + share(random) * (bounds[2 * a + 1] - bounds[2 * a]);
      int sub = 0;
      if (data.FindCell(at, nullptr, cell, -1, 0.0, sub, parametric, weights) < 0) continue;
    } else {
      const auto any = static_cast<vtkIdType>(share(random) * static_cast<double>(data.GetNumberOfCells()));
      data.GetCell(any, cell);
      int sub = 0;
      for (double& p : parametric) p = share(random);
      cell->EvaluateLocation(sub, parametric, at, weights);
    }
    places.push_back({at[0], at[1], at[2]});
  }
  return places;
}

struct Probed {
  vtkSmartPointer<vtkDataSet> values;
  bool valid(vtkIdType n) const { return values->GetPointData()->GetArray("vtkValidPointMask")->GetComponent(n, 0) != 0; }
  std::vector<double> at(const char* array, vtkIdType n) const {
    vtkDataArray* from = values->GetPointData()->GetArray(array);
    std::vector<double> tuple(static_cast<std::size_t>(from->GetNumberOfComponents()));
    from->GetTuple(n, tuple.data());
    return tuple;
  }
};
Probed probed(vtkDataSet& data, const std::vector<Vec3>& places) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vec3& x : places) points->InsertNextPoint(x.x, x.y, x.z);
  vtkNew<vtkPolyData> cloud;
  cloud->SetPoints(points);
  vtkNew<vtkProbeFilter> probe;
  probe->SetInputData(cloud);
  probe->SetSourceData(&data);
  probe->Update();
  return {probe->GetOutput()};
}

const VolumeField& field_of(const Volume& volume, const std::string& name) {
  for (const VolumeField& field : volume.fields) {
    if (field.name == name) return field;
  }
  throw std::runtime_error("no field " + name);
}

/// The shares of points with an error above the reported p99, and without data.
struct Compared {
  double above = 0.0, worst = 0.0, covered = 0.0;
};
Compared compared(const VolumeField& field, const std::vector<Vec3>& places, const Probed& truth, const char* array,
                  double p99) {
  double range = 0.0;
  for (const ValueRange& e : field.resampling->value_ranges) range = std::max(range, e.max - e.min);
  int inside = 0, above = 0, counted = 0;
  double worst = 0.0;
  for (std::size_t n = 0; n < places.size(); ++n) {
    if (!truth.valid(static_cast<vtkIdType>(n))) continue;
    ++counted;
    const std::vector<double> expected = truth.at(array, static_cast<vtkIdType>(n));
    double error = 0.0;
    if (field.field->components() == 1) {
      const ScalarSample s = field.field->scalar(places[n]);
      if (!s.inside) continue;
      error = std::abs(s.value - expected[0]) / range;
    } else {
      const VectorSample s = field.field->vector(places[n]);
      if (!s.inside) continue;
      error = norm(s.value - Vec3{expected[0], expected[1], expected[2]}) / range;
    }
    ++inside;
    above += error > p99;
    worst = std::max(worst, error);
  }
  return {static_cast<double>(above) / inside, worst, static_cast<double>(inside) / counted};
}

TEST_F(Probe, CurvilinearGridsAreAsWrongAsTheySay) {
  struct {
    const char *grid, *solution;
  } sets[] = {{"cfd_bluntfin/bluntfinxyz.bin", "cfd_bluntfin/bluntfinq.bin"},
              {"cfd_combustor/combxyz.bin", "cfd_combustor/combq.bin"}};
  for (const auto& set : sets) {
    const Volume volume = read(shared_file(set.solution));
    const vtkSmartPointer<vtkStructuredGrid> truth = plot3d(set.grid, set.solution);
    for (const bool by_volume : {false, true}) {
      const std::vector<Vec3> places = places_in(*truth, 1000, by_volume, by_volume ? 11 : 12);
      const Probed values = probed(*truth, places);
      const std::pair<const char*, const char*> fields[] = {
          {"density", "Density"}, {"momentum", "Momentum"}, {"velocity", "Velocity"}};
      for (const auto& [name, array] : fields) {
        const VolumeField& field = field_of(volume, name);
        ASSERT_TRUE(field.resampling);
        const ResamplingError& said = by_volume ? field.resampling->by_volume : field.resampling->by_cell;
        const Compared found = compared(field, places, values, array, said.p99);
        std::printf(
            "%-28s %-9s by %-6s p50 %.2g %% p99 %.2g %% max %.2g %%; fresh: %.2g %% above p99, worst %.2g %%, covered %.3g %% "
            "(said %.3g %%)\n",
            set.solution, name, by_volume ? "volume" : "cell", 100 * said.p50, 100 * said.p99, 100 * said.max,
            100 * found.above, 100 * found.worst, 100 * found.covered, 100 * said.covered);
        EXPECT_LE(found.above, 0.02) << set.solution << " " << name;
        EXPECT_NEAR(found.covered, said.covered, 0.04);
        EXPECT_GT(said.covered, by_volume ? 0.9 : 0.7);
      }
    }
  }
}

TEST_F(Probe, ACropMakesAPartFiner) {
  const fs::path file = shared_file("cfd_bluntfin/bluntfinq.bin");
  const vtkSmartPointer<vtkStructuredGrid> truth = plot3d("cfd_bluntfin/bluntfinxyz.bin", "cfd_bluntfin/bluntfinq.bin");
  VolumeRequest request;
  request.crop = Box{{-2, 0, 0}, {2, 3, 0.02}};
  const Volume part = read(file, request), all = read(file);
  const Field &finer = *field_of(part, "velocity").field, &coarser = *field_of(all, "velocity").field;
  EXPECT_LT(finer.spacing_m(), 0.2 * coarser.spacing_m());
  EXPECT_LE(finer.bounds_m().high_m.z, 0.02 + 1e-9);
  std::vector<Vec3> places;
  for (const Vec3& x : places_in(*truth, 4000, false, 13)) {
    if (x.x > -2 && x.x < 2 && x.y < 3 && x.z < 0.02) places.push_back(x);
  }
  ASSERT_GT(places.size(), 100U);
  const Probed values = probed(*truth, places);
  const auto& said = field_of(part, "velocity").resampling->by_cell;
  const Compared with_crop = compared(field_of(part, "velocity"), places, values, "Velocity", said.p99);
  const Compared without = compared(field_of(all, "velocity"), places, values, "Velocity", said.p99);
  EXPECT_LE(with_crop.above, 0.02);
  EXPECT_GT(with_crop.covered, 0.9);
  EXPECT_LT(without.covered, 0.7);
}

TEST_F(Probe, APartAsFineAsItsCellsIsNoWarning) {
  const fs::path file = shared_file("cfd_bluntfin/bluntfinxyz.bin");
  VolumeRequest request;
  request.length_unit = "m";
  EXPECT_TRUE(warns_of(read(file, request), "resampled to"));
  request.crop = Box{{-2, 0, 0}, {2, 3, 0.02}};  // cells of 1e-11 at the wall
  EXPECT_TRUE(warns_of(read(file, request), "no more because memory is finite"));
  request.crop = Box{{-3, 0.7, 0.1}, {4, 4.5, 2}};
  const Volume part = read(file, request);
  EXPECT_TRUE(part.warnings.empty()) << all_warnings(part);
}

TEST_F(Probe, ARectilinearGridIsFeltAsItIs) {
  const Volume volume = read(shared_file("cfd_office/office.binary.vtk"));
  vtkNew<vtkDataSetReader> reader;
  reader->SetFileName(shared_file("cfd_office/office.binary.vtk").c_str());
  reader->Update();
  const std::vector<Vec3> places = places_in(*reader->GetOutput(), 1000, false, 14);
  const Probed values = probed(*reader->GetOutput(), places);
  const Field& velocity = *field_of(volume, "vectors").field;
  EXPECT_FALSE(field_of(volume, "vectors").resampling);
  int inside = 0;
  for (std::size_t n = 0; n < places.size(); ++n) {
    if (!values.valid(static_cast<vtkIdType>(n))) continue;
    const VectorSample s = velocity.vector(places[n]);
    const std::vector<double> expected = values.at("vectors", static_cast<vtkIdType>(n));
    ASSERT_TRUE(s.inside);
    ++inside;
    ASSERT_LT(norm(s.value - Vec3{expected[0], expected[1], expected[2]}), 2e-6) << n;
  }
  EXPECT_GT(inside, 990);
}

}  // namespace probe_test
}  // namespace palpa::test
