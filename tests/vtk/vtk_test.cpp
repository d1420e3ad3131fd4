// Headers for programs with VTK: data of VTK's readers, bit-identical and without copies; reports of unusable data.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <vtkActorCollection.h>
#include <vtkCellData.h>
#include <vtkCellTypes.h>
#include <vtkDataSetReader.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkSOADataArrayTemplate.h>
#include <vtkStringArray.h>
#include <vtkStructuredGrid.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnstructuredGrid.h>
#include <vtkWeakPointer.h>
#include <vtkXMLImageDataReader.h>

#include <cmath>
#include <filesystem>
#include <thread>

#include "palpa/device/mouse_hand.h"
#include "palpa/palpa.h"
#include "palpa/vtk/felt_actors.h"
#include "palpa/vtk/felt_tool.h"
#include "palpa/vtk/from_vtk.h"
#include "palpa/vtk/to_vtk.h"
#include "tests/shared_data.h"

namespace palpa {
namespace vtk_test {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;
using testing::StartsWith;

ReadOptions reader() { return {.reader = fs::path(std::getenv("PALPA_BIN")) / "palpa-read"}; }

template <class Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "(no error)";
}

/// 4 × 3 × 2 points of an oblique grid with unique values.
vtkSmartPointer<vtkImageData> oblique(int type = VTK_SHORT) {
  const auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetExtent(1, 4, -1, 1, 2, 3);
  image->SetSpacing(0.001, 0.002, 0.003);
  image->SetOrigin(0.1, 0.2, 0.3);
  const Mat3 turn = rotation_about({1, 2, 3}, 40.0);
  const Mat3& t = turn;
  image->SetDirectionMatrix(t.row[0].x, t.row[0].y, t.row[0].z, t.row[1].x, t.row[1].y, t.row[1].z, t.row[2].x, t.row[2].y,
                            t.row[2].z);
  image->AllocateScalars(type, 1);
  image->GetPointData()->GetScalars()->SetName("ct");
  for (vtkIdType n = 0; n < image->GetNumberOfPoints(); ++n)
    image->GetPointData()->GetScalars()->SetComponent(n, 0, static_cast<double>(n * n % 101));
  return image;
}

void expect_values(const Field& field, vtkDataSet& data, vtkDataArray& values) {
  for (vtkIdType n = 0; n < data.GetNumberOfPoints(); ++n) {
    double at[3];
    data.GetPoint(n, at);
    const ScalarSample sample = field.scalar({at[0], at[1], at[2]});
    ASSERT_TRUE(sample.inside) << n;
    EXPECT_NEAR(sample.value, values.GetComponent(n, 0), 1e-6) << n;
  }
}

TEST(FromVtk, AnImageIsReadWhereItIsAndKept) {
  Volume volume;
  std::int16_t* memory = nullptr;
  vtkWeakPointer<vtkDataArray> array;
  {
    const auto image = oblique();
    array = image->GetPointData()->GetScalars();
    memory = static_cast<std::int16_t*>(array->GetVoidPointer(0));
    volume = from_vtk(image);
    expect_values(*volume.fields[0].field, *image, *array);
  }
  ASSERT_THAT(volume.fields, SizeIs(1));
  EXPECT_EQ(volume.fields[0].name, "ct");
  const GridView& grid = *grid_of(*volume.fields[0].field);
  EXPECT_EQ(grid.voxels.data.get(), memory) << "no copy";
  EXPECT_EQ(grid.voxels.type, VoxelType::int16);
  EXPECT_THAT(volume.fields[0].field->value_ranges(), ElementsAre(ValueRange{0, 100}));
  EXPECT_NE(array, nullptr) << "kept while it is felt";
  volume = {};
  EXPECT_EQ(array, nullptr) << "and no longer";

  const auto changing = oblique();
  const Volume copy = from_vtk(changing, {.copy = true});
  changing->GetPointData()->GetScalars()->SetComponent(0, 0, 9999);
  EXPECT_EQ(copy.fields[0].field->value_ranges()[0].max, 100);
}

TEST(FromVtk, NumbersOfEveryTypeAndOrder) {
  for (const int type : {VTK_UNSIGNED_CHAR, VTK_SIGNED_CHAR, VTK_SHORT, VTK_UNSIGNED_SHORT, VTK_INT, VTK_UNSIGNED_INT, VTK_LONG,
                         VTK_FLOAT, VTK_DOUBLE}) {
    const auto image = oblique(type);
    const Volume volume = from_vtk(image);
    expect_values(*volume.fields[0].field, *image, *image->GetPointData()->GetScalars());
  }
  const auto image = oblique();
  vtkNew<vtkSOADataArrayTemplate<float>> apart;
  apart->SetName("apart");
  apart->SetNumberOfComponents(3);
  apart->SetNumberOfTuples(24);
  for (vtkIdType n = 0; n < 24; ++n) apart->SetTuple3(n, static_cast<double>(n), 1.0, -static_cast<double>(n));
  image->GetPointData()->AddArray(apart);
  double at[3];
  image->GetPoint(7, at);
  const Vec3 v = from_vtk(image).fields.at(1).field->vector({at[0], at[1], at[2]}).value;
  EXPECT_NEAR(norm(v - Vec3{7, 1, -7}), 0.0, 1e-5);
}

TEST(FromVtk, PlanesAtUnevenDistancesStayWhereTheyAre) {
  vtkNew<vtkRectilinearGrid> grid;
  vtkNew<vtkDoubleArray> x, y, z, values;
  for (const double at : {0.0, 0.1, 0.4}) x->InsertNextValue(at);
  for (const double at : {0.0, 0.1}) y->InsertNextValue(at);
  for (const double at : {0.0, 0.3, 0.4}) z->InsertNextValue(at);
  grid->SetDimensions(3, 2, 3);
  grid->SetXCoordinates(x);
  grid->SetYCoordinates(y);
  grid->SetZCoordinates(z);
  for (int n = 0; n < 18; ++n) values->InsertNextValue(n * n);
  values->SetName("v");
  grid->GetPointData()->AddArray(values);
  const Volume volume = from_vtk(grid);
  expect_values(*volume.fields[0].field, *grid, *values);
  EXPECT_NEAR(volume.fields[0].field->scalar({0.25, 0, 0}).value, 0.5 * (1 + 4), 1e-12) << "midway between planes";
  const Volume in_mm = from_vtk(grid, {.metres_per_unit = 0.001});
  EXPECT_NEAR(in_mm.fields[0].field->scalar({0.00025, 0, 0}).value, 2.5, 1e-9);
}

TEST(FromVtk, CellsAreVoxelsInTheirMiddles) {
  const auto image = oblique();
  vtkNew<vtkDoubleArray> cells;
  cells->SetName("ct");
  for (int n = 0; n < 6; ++n) cells->InsertNextValue(n);
  image->GetCellData()->AddArray(cells);
  const Volume volume = from_vtk(image);
  ASSERT_THAT(volume.fields, SizeIs(2));
  EXPECT_EQ(volume.fields[1].name, "ct_cells");
  const GridGeometry& grid = grid_of(*volume.fields[1].field)->geometry;
  EXPECT_THAT(grid.dims, ElementsAre(3, 2, 1));
  double a[3], b[3];
  image->GetPoint(0, a);
  image->GetPoint(1 + 4 + 12, b);
  EXPECT_NEAR(norm(grid.origin_m - 0.5 * Vec3{a[0] + b[0], a[1] + b[1], a[2] + b[2]}), 0.0, 1e-12);
}

TEST(FromVtk, BlankPointsHaveNoDataAndGhostsThatRepeatOnesHave) {
  const auto image = oblique(VTK_FLOAT);
  image->AllocatePointGhostArray();
  image->GetPointGhostArray()->SetValue(0, vtkDataSetAttributes::DUPLICATEPOINT);
  EXPECT_THAT(grid_of(*from_vtk(image).fields[0].field)->geometry.dims, ElementsAre(4, 3, 2)) << "data like all others";
  vtkNew<vtkImageData> flat;
  flat->SetDimensions(9, 9, 9);
  flat->AllocateScalars(VTK_FLOAT, 1);
  flat->GetPointData()->GetScalars()->SetName("v");
  flat->GetPointData()->GetScalars()->Fill(5.0);
  flat->AllocateCellGhostArray();
  flat->GetCellGhostArray()->SetValue(0, vtkDataSetAttributes::HIDDENCELL);
  const Volume volume = from_vtk(flat, {.read = reader()});
  ASSERT_TRUE(volume.fields[0].resampling) << "on a grid of its own";
  EXPECT_FALSE(volume.fields[0].field->scalar({0.5, 0.5, 0.5}).inside);
  EXPECT_NEAR(volume.fields[0].field->scalar({6.5, 6.5, 6.5}).value, 5.0, 1e-6);
}

TEST(FromVtk, WhatHasNoGridOfItsOwnIsResampledAndTellsItsError) {
  // A block of 5 × 5 × 5 cells along x, y and z, without one.
  vtkNew<vtkUnstructuredGrid> mesh;
  vtkNew<vtkPoints> points;
  vtkNew<vtkDoubleArray> values;
  values->SetName("x");
  for (int n = 0; n < 216; ++n) {
    points->InsertNextPoint(0.2 * (n % 6), 0.2 * (n / 6 % 6), 0.2 * (n / 36));
    values->InsertNextValue(0.2 * (n % 6));
  }
  mesh->SetPoints(points);
  mesh->GetPointData()->AddArray(values);
  for (int cell = 0; cell < 124; ++cell) {
    const vtkIdType at = cell % 5 + 6 * (cell / 5 % 5) + 36 * (cell / 25);
    const vtkIdType corners[] = {at, at + 1, at + 7, at + 6, at + 36, at + 37, at + 43, at + 42};
    mesh->InsertNextCell(VTK_HEXAHEDRON, 8, corners);
  }
  const Volume volume = from_vtk(mesh, {.read = reader()});
  ASSERT_TRUE(volume.fields[0].resampling);
  EXPECT_LT(volume.fields[0].resampling->by_volume.p99, 0.01);
  EXPECT_NEAR(volume.fields[0].field->scalar({0.3, 0.2, 0.2}).value, 0.3, 1e-3);
  EXPECT_FALSE(volume.fields[0].field->scalar({0.95, 0.95, 0.95}).inside);
  EXPECT_FALSE(volume.warnings.empty());
  EXPECT_THAT(volume.files, SizeIs(0)) << "a file on its way";
  const Volume in_mm = from_vtk(mesh, {.metres_per_unit = 0.001, .read = reader()});
  EXPECT_NEAR(in_mm.fields[0].field->scalar({0.0003, 0.0002, 0.0002}).value, 0.3, 1e-3);
}

TEST(FromVtk, WhatIsWrongIsSaidInOneLine) {
  EXPECT_THAT(error_of([] { from_vtk(nullptr); }), StartsWith("vtkDataSet: is none; "));
  vtkNew<vtkImageData> none;
  EXPECT_THAT(error_of([&] { from_vtk(none); }), HasSubstr("vtkImageData: has no voxels; "));
  none->SetDimensions(2, 2, 2);
  EXPECT_THAT(error_of([&] { from_vtk(none); }), HasSubstr("vtkImageData: has no array; one with 1 or 3 numbers"));
  none->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  none->GetPointData()->GetScalars()->SetName("rgb");
  EXPECT_THAT(error_of([&] { from_vtk(none); }), HasSubstr("array 'rgb' is left out: three bytes are a colour"));
  vtkNew<vtkStringArray> words;
  words->SetName("words");
  words->SetNumberOfValues(8);
  none->GetPointData()->RemoveArray("rgb");
  none->GetPointData()->AddArray(words);
  EXPECT_THAT(error_of([&] { from_vtk(none); }), HasSubstr("holds no numbers"));
  const auto image = oblique();
  vtkNew<vtkDoubleArray> short_one;
  short_one->SetName("short");
  short_one->SetNumberOfTuples(3);
  image->GetPointData()->AddArray(short_one);
  const Volume volume = from_vtk(image);
  EXPECT_THAT(volume.warnings, ElementsAre("array 'short' is left out: it has 3 values for 24 places"));
  image->SetSpacing(0, 1, 1);
  EXPECT_THAT(error_of([&] { from_vtk(image); }), HasSubstr("vtkImageData: cannot be placed in the world ("));
  image->SetSpacing(1, 1, 1);
  EXPECT_THAT(error_of([&] { from_vtk(image, {.metres_per_unit = std::nan("")}); }), HasSubstr("metres_per_unit"));
  vtkNew<vtkTypeInt64Array> large;
  large->SetName("large");
  large->SetNumberOfTuples(24);
  large->Fill(9.1e18);
  image->GetPointData()->AddArray(large);
  EXPECT_THAT(error_of([&] { from_vtk(image); }), HasSubstr("beyond 2^53"));
  vtkNew<vtkPolyData> surface;
  EXPECT_THAT(error_of([&] { from_vtk(surface); }), StartsWith("vtkPolyData: "));
}

/// Three ticks of a thousand of a hand through both, number by number.
void expect_felt_alike(const Volume& ours, const Volume& theirs, const std::string& field) {
  Scene scenes[2];
  const Volume* const volumes[] = {&ours, &theirs};
  for (int n = 0; n < 2; ++n) {
    scenes[n].add("data", *volumes[n]);
    const ValueRange range = volumes[n]->fields[0].field->value_ranges()[0];
    if (volumes[n]->fields[0].field->components() == 1) {
      scenes[n].add("wall",
                    SurfaceAndFriction{.field = {field},
                                       .levels = {{.value = range.min + 0.2 * (range.max - range.min), .strength_n = 1}}});
    } else {
      scenes[n].add("rail", Follow{.field = {field}, .strength_n = 1.0});
    }
  }
  Session one(scenes[0]), other(scenes[1]);
  double felt_n = 0.0;
  for (int n = 0; n < 1000; ++n) {
    const double s = 0.001 * n;
    const Probe probe{.position_m = {0.06 * std::sin(7 * s), 0.05 * std::cos(5 * s), 0.06 * std::sin(3 * s)}};
    const Tick a = one.tick(probe, 1e-3), b = other.tick(probe, 1e-3);
    ASSERT_EQ(a.proxy_m, b.proxy_m) << n;
    ASSERT_EQ(a.force_n, b.force_n) << n;
    felt_n = std::max(felt_n, norm(a.force_n));
  }
  EXPECT_GT(felt_n, 0.1) << "nothing is felt";
}

TEST(FromVtk, WhatVtksOwnReadersHaveIsWhatOursHas) {
  const fs::path data = test::shared_data();
  if (!fs::exists(data)) GTEST_SKIP() << "no real data";
  for (const char* name :
       {"cfd_wing/wing.vti", "mol_hydrogen/hydrogen.vti", "mri_flow_carotid/carotid.vtk", "mol_ironprot/ironProt.vtk"}) {
    SCOPED_TRACE(name);
    const fs::path file = data / name;
    vtkSmartPointer<vtkDataSet> read;
    if (file.extension() == ".vti") {
      vtkNew<vtkXMLImageDataReader> xml;
      xml->SetFileName(file.c_str());
      xml->Update();
      read = xml->GetOutput();
    } else {
      vtkNew<vtkDataSetReader> legacy;
      legacy->SetFileName(file.c_str());
      legacy->ReadAllScalarsOn();
      legacy->ReadAllVectorsOn();
      legacy->Update();
      read = legacy->GetOutput();
    }
    const Volume theirs = from_vtk(read), ours = read_volume(file, reader());
    ASSERT_EQ(theirs.fields.size(), ours.fields.size());
    for (std::size_t n = 0; n < ours.fields.size(); ++n) {
      const VolumeField &a = ours.fields[n], &b = theirs.fields[n];
      EXPECT_EQ(a.name, b.name);
      EXPECT_EQ(a.field->value_ranges(), b.field->value_ranges());
      const GridView &x = *grid_of(*a.field), &y = *grid_of(*b.field);
      EXPECT_EQ(x.geometry, y.geometry);
      EXPECT_EQ(x.voxels.type, y.voxels.type);
      EXPECT_EQ(x.valid_share, y.valid_share);
    }
    expect_felt_alike(ours, theirs, ours.fields.size() == 1 ? "data" : "data." + ours.fields[0].name);
  }
}

TEST(ToVtk, AFieldKeepsItsVoxelsAndItsPlace) {
  const auto image = oblique();
  const auto back = to_vtk(*from_vtk(image).fields[0].field, "ct");
  ASSERT_EQ(back->GetNumberOfPoints(), image->GetNumberOfPoints());
  EXPECT_EQ(back->GetScalarType(), VTK_SHORT);
  for (vtkIdType n = 0; n < back->GetNumberOfPoints(); ++n) {
    double a[3], b[3];
    image->GetPoint(n, a);
    back->GetPoint(n, b);
    EXPECT_NEAR(std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]), 0.0, 1e-12);
    EXPECT_EQ(back->GetPointData()->GetScalars()->GetComponent(n, 0), image->GetPointData()->GetScalars()->GetComponent(n, 0));
  }
  const auto voxels = std::make_shared<std::vector<std::uint8_t>>(std::vector<std::uint8_t>{0, 1, 2, 3, 4, 5, 6, 7});
  const auto scaled = grid_field({.dims = {2, 2, 2}}, {VoxelType::uint8, 1, {voxels, voxels->data()}}, 0.5, -10);
  EXPECT_EQ(to_vtk(*scaled)->GetPointData()->GetScalars()->GetComponent(7, 0), -6.5);
}

TEST(ToVtk, AFormulaIsSampledOverItsBox) {
  const Volume ball = sphere_field(0.05);
  const auto image = to_vtk(*ball.fields[0].field, "depth", 21);
  EXPECT_EQ(image->GetDimensions()[0], 21);
  for (vtkIdType n = 0; n < image->GetNumberOfPoints(); n += 97) {
    double at[3];
    image->GetPoint(n, at);
    EXPECT_NEAR(image->GetPointData()->GetScalars()->GetComponent(n, 0), 0.05 - std::hypot(at[0], at[1], at[2]), 1e-6);
  }
  const auto flow = to_vtk(*lamb_oseen_vortex().fields[0].field, "velocity", 8);
  EXPECT_EQ(flow->GetPointData()->GetVectors()->GetNumberOfComponents(), 3);
  EXPECT_THROW(to_vtk(*ball.fields[0].field, "", 1), std::invalid_argument);
}

TEST(TransferFunctions, AreTheSameThereAndBack) {
  const TransferFunction curve({{-300, 0}, {0, 1}, {0, 4}, {500, 5}, {500, 0}});
  const auto seen = to_vtk(curve, 0.2);
  for (double value = -500; value < 700; value += 0.37)
    EXPECT_NEAR(seen->GetValue(value), 0.2 * curve.at(value), 1e-12) << value;
  const TransferFunction back = transfer_function_from_vtk(*seen, 5.0);
  for (double value = -500; value < 700; value += 0.37) EXPECT_NEAR(back.at(value), curve.at(value), 1e-11) << value;

  const TransferFunction above({{0, 1}, {1, 2}}, 2.0);
  const auto clamped = to_vtk(above);
  for (const double value : {-9.0, 0.0, 0.5, 1.0, 9.0}) EXPECT_NEAR(clamped->GetValue(value), above.at(value), 1e-12) << value;

  vtkNew<vtkPiecewiseFunction> bent;
  bent->AddPoint(0, 0, 0.3, 0.6);
  bent->AddPoint(1, 1);
  bent->ClampingOff();
  const TransferFunction straightened = transfer_function_from_vtk(*bent);
  for (double value = 0; value <= 1; value += 0.01) EXPECT_NEAR(straightened.at(value), bent->GetValue(value), 0.05) << value;
  EXPECT_EQ(straightened.at(2), 0);

  bent->ClampingOn();
  EXPECT_THAT(error_of([&] { transfer_function_from_vtk(*bent); }), HasSubstr("clamps to 0"));
  EXPECT_THAT(error_of([&] { transfer_function_from_vtk(*vtkNew<vtkPiecewiseFunction>()); }), HasSubstr("has no points"));
}

std::vector<Vec3> seen_in(vtkRenderer& renderer) {
  std::vector<Vec3> all;
  vtkActorCollection& actors = *renderer.GetActors();
  actors.InitTraversal();
  while (vtkActor* const actor = actors.GetNextActor()) {
    const double* const b = actor->GetBounds();
    if (actor->GetVisibility() != 0) all.push_back(0.5 * Vec3{b[0] + b[1], b[2] + b[3], b[4] + b[5]});
  }
  return all;
}

TEST(Actors, AreWhereTheHandIsInTheData) {
  vtkNew<vtkRenderer> renderer;
  const Similarity map{rotation_about({0, 0, 1}, 90.0), 2.0, {1, 0, 0}};
  FeltActors actors(renderer, 0.1, map);
  PlacedPrimitive plane{.primitive = {.kind = PrimitiveKind::plane, .position_m = {0, 0, 0.5}, .direction = {0, 0, 1}}};
  actors.show({0.1, 0, 0}, {0, 0.1, 0}, {&plane, 1});
  const std::vector<Vec3> seen = seen_in(*renderer);
  ASSERT_THAT(seen, SizeIs(6)) << "disc, shaft and tip; spring; proxy and probe";
  const auto has = [&](const Vec3& at_m) {
    return std::any_of(seen.begin(), seen.end(), [&](const Vec3& s) { return distance(s, at_m) < 1e-6; });
  };
  EXPECT_TRUE(has(map.to_world({0.1, 0, 0})));
  EXPECT_TRUE(has(map.to_world({0, 0.1, 0})));
  EXPECT_TRUE(has(map.to_world({0.05, 0.05, 0}))) << "the spring";
  EXPECT_TRUE(has(map.to_world({0, 0, 0.5})));
  actors.show({0.1, 0, 0}, {0, 0.1, 0}, {});
  EXPECT_THAT(seen_in(*renderer), SizeIs(3));
  actors.remove();
  EXPECT_THAT(seen_in(*renderer), SizeIs(0));
}

/// Points of the actor's data.
std::vector<Vec3> feet_of(vtkActor& actor) {
  std::vector<Vec3> feet;
  vtkPoints& points = *vtkPolyData::SafeDownCast(actor.GetMapper()->GetInputDataObject(0, 0))->GetPoints();
  for (vtkIdType n = 0; n < points.GetNumberOfPoints(); ++n)
    feet.push_back(Vec3{points.GetPoint(n)[0], points.GetPoint(n)[1], points.GetPoint(n)[2]});
  return feet;
}

TEST(Actors, OfAToolAreItsFeetInBothPoses) {
  vtkNew<vtkRenderer> renderer;
  const Similarity map{rotation_about({0, 0, 1}, 90.0), 2.0, {1, 0, 0}};
  const Tool tool({.shape = ToolOptions::Shape::rod, .length_m = 0.1, .points = 5}, {});
  FeltTool actors(renderer, tool, 0.1, map);
  EXPECT_EQ(renderer->GetActors()->GetNumberOfItems(), 0);
  const Pose probe{{0.1, 0, 0}, turn_by({0.3, 0, 0})}, proxy{{0, 0.1, 0}, turn_by({0, 1.2, 0})};
  actors.show(probe, proxy, {});
  ASSERT_EQ(renderer->GetActors()->GetNumberOfItems(), 2);
  const auto expect_feet = [&](int number, const Pose& pose) {
    const std::vector<Vec3> seen = feet_of(*vtkActor::SafeDownCast(renderer->GetActors()->GetItemAsObject(number)));
    ASSERT_THAT(seen, SizeIs(5));
    for (std::size_t foot = 0; foot < 5; ++foot) EXPECT_LT(distance(seen[foot], map.to_world(tool.foot_m(pose, foot))), 1e-12);
  };
  expect_feet(0, probe);
  expect_feet(1, proxy);
  actors.show({{NAN, 0, 0}, {}}, proxy, {});
  expect_feet(0, probe);
  actors.remove();
  EXPECT_EQ(renderer->GetActors()->GetNumberOfItems(), 0);
  FeltTool of_point(renderer, Tool(), 0.1);
  of_point.show(probe, proxy, {});
  EXPECT_EQ(renderer->GetActors()->GetNumberOfItems(), 0);
}

TEST(Actors, OfAToolFollowALiveSession) {
  Scene scene;
  scene.set(ToolOptions{.shape = ToolOptions::Shape::pad, .radius_m = 0.01, .points = 4});
  scene.add("ball", sphere_field());
  scene.add("wall", SurfaceAndFriction{.field = {"ball"}, .levels = {{.value = 0, .strength_n = 2}}});
  MouseHand hand;
  LiveScene live(scene, hand.limits());
  LiveLoop loop(live, hand, {.duration_s = 0.1, .guard = {.motors = false}});
  vtkNew<vtkRenderer> renderer;
  FeltTool actors(renderer, Tool(scene.tool(), scene.coupling()), 0.1);
  EXPECT_FALSE(actors.update()) << "nothing was felt yet";
  const std::atomic<bool> stop{false};
  loop.run(stop, actors.observer());
  EXPECT_TRUE(actors.update());
  EXPECT_EQ(renderer->GetActors()->GetNumberOfItems(), 2);
}

TEST(Actors, FollowALiveSessionThatNeverWaitsForThem) {
  Scene scene;
  scene.add("ball", sphere_field());
  scene.add("wall", SurfaceAndFriction{.field = {"ball"}, .levels = {{.value = 0, .strength_n = 2}}});
  MouseHand hand;
  LiveScene live(scene, hand.limits());
  LiveLoop loop(live, hand, {.duration_s = 0.3, .guard = {.motors = false}});
  vtkNew<vtkRenderer> renderer;
  FeltActors actors(renderer, 0.1);
  EXPECT_FALSE(actors.update()) << "nothing was felt yet";
  std::atomic<bool> stop{false}, over{false};
  std::thread haptic([&] {
    loop.run(stop, actors.observer());
    over = true;
  });
  int updates = 0;
  while (!over) {
    hand.move({0.0, 1e-4, 0.0});
    updates += actors.update() ? 1 : 0;
  }
  haptic.join();
  EXPECT_GT(updates, 3);
  EXPECT_GE(seen_in(*renderer).size(), 2u);
}

}  // namespace vtk_test
}  // namespace palpa
