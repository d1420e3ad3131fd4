// Non-affine grids of VTK: rectilinear, structured, unstructured, in pieces, with blanks.
#include <cmath>

#include "files.h"

namespace palpa::test {
namespace grids_test {

class Grids : public ReaderTest {};

const Linear linear{{3, -2, 5}, 7};
const double xs[] = {0.0, 0.1, 0.4, 1.0, 2.0}, ys[] = {1.0, 1.5, 3.0, 3.2}, zs[] = {-1.0, 0.0, 0.25};

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g ", value);
  return text;
}

std::string array(const std::string& name, const std::string& numbers, int components = 1,
                  const std::string& type = "Float64") {
  return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" + std::to_string(components) +
         "\" format=\"ascii\">" + numbers + "</DataArray>";
}

std::string file_of(const std::string& kind, const std::string& extent, const std::string& inside) {
  return "<VTKFile type=\"" + kind + "\" version=\"1.0\" byte_order=\"LittleEndian\"><" + kind +
         (extent.empty() ? "" : " WholeExtent=\"" + extent + "\"") + ">" + inside + "</" + kind + "></VTKFile>";
}

/// Numbers for every point of the uneven grid, x fastest.
template <class Value>
std::string over_points(Value value) {
  std::string text;
  for (const double z : zs)
    for (const double y : ys)
      for (const double x : xs) text += value(Vec3{x, y, z});
  return text;
}
std::string point_values() {
  return over_points([](const Vec3& p) { return number(linear(p)); });
}
std::string cell_values() {
  std::string text;
  for (int k = 0; k + 1 < 3; ++k)
    for (int j = 0; j + 1 < 4; ++j)
      for (int i = 0; i + 1 < 5; ++i) {
        text += number(linear({0.5 * (xs[i] + xs[i + 1]), 0.5 * (ys[j] + ys[j + 1]), 0.5 * (zs[k] + zs[k + 1])}));
      }
  return text;
}

const Field& field_of(const Volume& volume, const std::string& name) {
  for (const VolumeField& f : volume.fields) {
    if (f.name == name) return *f.field;
  }
  throw std::runtime_error("no field " + name);
}

/// Linear within the inner box, which cells of points and of cells both cover.
void expect_linear_inside(const Field& field, double tolerance) {
  for (int n = 0; n < 200; ++n) {
    const Vec3 at{0.06 + 1.4 * (n % 7) / 6.0, 1.3 + 1.75 * (n % 11) / 10.0, -0.45 + 0.55 * (n % 13) / 12.0};
    const ScalarSample s = field.scalar(at);
    ASSERT_TRUE(s.inside) << at.x << " " << at.y << " " << at.z;
    ASSERT_NEAR(s.value, linear(at), tolerance);
    ASSERT_LT(norm(s.gradient - linear.gradient), 1e3 * tolerance);
  }
}

TEST_F(Grids, RectilinearPlanesAndTheCentresOfTheirCells) {
  std::string coordinates = "<Coordinates>";
  std::string x, y, z;
  for (const double v : xs) x += number(v);
  for (const double v : ys) y += number(v);
  for (const double v : zs) z += number(v);
  coordinates += array("x", x) + array("y", y) + array("z", z) + "</Coordinates>";
  // Indices begin at 3, 4, 5: coordinates give the planes' positions for any index range.
  const std::string piece = "<Piece Extent=\"3 7 4 7 5 7\"><PointData>" + array("p", point_values()) +
                            "</PointData><CellData>" + array("c", cell_values()) + "</CellData>" + coordinates + "</Piece>";
  const Volume xml = read(folder_.write("a.vtr", file_of("RectilinearGrid", "3 7 4 7 5 7", piece)));
  const Volume legacy = read(folder_.write(
      "a.vtk", "# vtk DataFile Version 3.0\nx\nASCII\nDATASET RECTILINEAR_GRID\nDIMENSIONS 5 4 3\nX_COORDINATES 5 double\n" +
                   x + "\nY_COORDINATES 4 double\n" + y + "\nZ_COORDINATES 3 double\n" + z +
                   "\nPOINT_DATA 60\nSCALARS p double\nLOOKUP_TABLE default\n" + point_values() +
                   "\nCELL_DATA 24\nSCALARS c double\nLOOKUP_TABLE default\n" + cell_values() + "\n"));
  for (const Volume* volume : {&xml, &legacy}) {
    EXPECT_TRUE(grid_of(field_of(*volume, "p"))->geometry.is_rectilinear());
    expect_linear_inside(field_of(*volume, "p"), 1e-12);
    expect_linear_inside(field_of(*volume, "c"), 1e-12);
    EXPECT_TRUE(field_of(*volume, "p").scalar({0, 1, -1}).inside);
    EXPECT_FALSE(field_of(*volume, "c").scalar({0, 1, -1}).inside);  // half a cell further in
  }
}

std::string structured(const std::string& more, const std::function<Vec3(const Vec3&)>& bend) {
  const std::string points = over_points([&](const Vec3& p) {
    const Vec3 b = bend(p);
    return number(b.x) + number(b.y) + number(b.z);
  });
  return "<Piece Extent=\"0 4 0 3 0 2\">" + more + "<Points>" + array("points", points, 3) + "</Points></Piece>";
}

TEST_F(Grids, AStructuredGridOfStraightPlanesIsRectilinear) {
  const auto turned = [](const Vec3& p) {
    return Vec3{0.6 * p.x - 0.8 * p.y, 0.8 * p.x + 0.6 * p.y, 2.0 * p.z} + Vec3{5, 6, 7};
  };
  const std::string values = over_points([&](const Vec3& p) { return number(linear(turned(p))); });
  const Volume volume =
      read(folder_.write("a.vts", file_of("StructuredGrid", "0 4 0 3 0 2",
                                          structured("<PointData>" + array("p", values) + "</PointData>", turned))));
  EXPECT_FALSE(volume.fields[0].resampling);
  for (const Vec3 p : {Vec3{0.2, 1.2, -0.5}, Vec3{1.7, 3.1, 0.2}}) {
    const ScalarSample s = volume.fields[0].field->scalar(turned(p));
    ASSERT_TRUE(s.inside);
    EXPECT_NEAR(s.value, linear(turned(p)), 1e-11);
    EXPECT_LT(norm(s.gradient - linear.gradient), 1e-9);
  }
}

TEST_F(Grids, BentGridsAreResampledAndSayHowWell) {
  const auto bent = [](const Vec3& p) { return Vec3{p.x + 0.1 * p.y * p.y, p.y, p.z + 0.05 * p.x}; };
  const std::string values = over_points([&](const Vec3& p) { return number(linear(bent(p))); });
  const std::string data = "<PointData>" + array("p", values) + "</PointData>";
  const Volume volume = read(folder_.write("a.vts", file_of("StructuredGrid", "0 4 0 3 0 2", structured(data, bent))));
  ASSERT_TRUE(volume.fields[0].resampling);
  EXPECT_TRUE(warns_of(volume, "resampled"));
  const Resampling& said = *volume.fields[0].resampling;
  EXPECT_EQ(said.dims, (std::array<std::int64_t, 3>{5, 4, 3}));
  EXPECT_LT(said.by_volume.p99, 1e-5);
  int inside = 0;
  for (int n = 0; n < 200; ++n) {
    const Vec3 at = bent({0.5 + 1.0 * (n % 7) / 6.0, 1.6 + 1.2 * (n % 11) / 10.0, -0.8 + 0.9 * (n % 13) / 12.0});
    const ScalarSample s = volume.fields[0].field->scalar(at);
    inside += s.inside;
    if (!s.inside) continue;
    ASSERT_NEAR(s.value, linear(at), 1e-4);
  }
  EXPECT_GT(inside, 150);
}

/// Two tetrahedra, a hexahedron and a wedge-sized gap: a file of cells of several kinds.
std::string unstructured(double unit) {
  // A cube from 0 to 1 and another from 1 to 2 along x, the second as six tetrahedra.
  std::string points, values;
  for (int x = 0; x < 3; ++x)
    for (int corner = 0; corner < 4; ++corner) {
      const Vec3 p{double(x), double(corner & 1), double(corner >> 1)};
      points += number(unit * p.x) + number(unit * p.y) + number(unit * p.z);
      values += number(linear(p));
    }
  // Points are x·4 + y + 2z.
  const std::string hexahedron = "0 4 5 1 2 6 7 3 ";
  const int path[6][2] = {{1, 2}, {2, 1}, {1, 4}, {4, 1}, {2, 4}, {4, 2}};  // steps 1: x, 2: y, 4: z
  std::string tetrahedra, offsets = "8 ", types = "12 ";
  int offset = 8;
  for (const auto& way : path) {
    int bits = 0;
    const auto point = [&] { return 4 + 4 * (bits & 1) + (bits >> 1 & 1) + 2 * (bits >> 2 & 1); };
    tetrahedra += std::to_string(point()) + " ";
    for (const int step : {way[0], way[1], 7 - way[0] - way[1]}) {
      bits |= step;
      tetrahedra += std::to_string(point()) + " ";
    }
    offsets += std::to_string(offset += 4) + " ";
    types += "10 ";
  }
  return "<Piece NumberOfPoints=\"12\" NumberOfCells=\"7\"><PointData>" + array("p", values) + "</PointData><CellData>" +
         array("c", "1 1 1 1 1 1 1 ") + "</CellData><Points>" + array("points", points, 3) + "</Points><Cells>" +
         array("connectivity", hexahedron + tetrahedra, 1, "Int64") + array("offsets", offsets, 1, "Int64") +
         array("types", types, 1, "UInt8") + "</Cells></Piece>";
}

TEST_F(Grids, UnstructuredCellsOfAnySize) {
  // VTK's own hexahedron fails in cells below 1e-20 of volume, as a micrometre's is in metres.
  for (const double unit : {1.0, 1e-8, 1e6}) {
    const Volume volume = read(folder_.write("a.vtu", file_of("UnstructuredGrid", "", unstructured(unit))));
    ASSERT_EQ(volume.fields.size(), 2U);
    ASSERT_TRUE(volume.fields[0].resampling);
    EXPECT_EQ(grid_of(*volume.fields[0].field)->valid_share, 1.0) << unit;
    EXPECT_EQ(volume.fields[0].resampling->by_cell.covered, 1.0);
    EXPECT_LT(volume.fields[0].resampling->by_cell.p99, 1e-5);
    for (const Vec3 p : {Vec3{0.3, 0.7, 0.4}, Vec3{1.3, 0.2, 0.9}, Vec3{2, 1, 1}, Vec3{0, 0, 0}}) {
      EXPECT_NEAR(volume.fields[0].field->scalar(unit * p).value, linear(p), 1e-4);
      EXPECT_NEAR(volume.fields[1].field->scalar(unit * p).value, 1.0, 1e-6);
    }
    EXPECT_TRUE(warns_of(volume, "averaged to the points"));
  }
}

TEST_F(Grids, BlankedCellsAreNoData) {
  const auto straight = [](const Vec3& p) { return p; };
  std::string ghosts;
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 4; ++i) ghosts += i == 1 ? "32 " : "0 ";  // hidden between x = 0.1 and 0.4
  const std::string data = "<PointData>" + array("p", point_values()) + "</PointData><CellData>" +
                           array("vtkGhostType", ghosts, 1, "UInt8") + "</CellData>";
  const Volume volume = read(folder_.write("a.vts", file_of("StructuredGrid", "0 4 0 3 0 2", structured(data, straight))));
  ASSERT_EQ(volume.fields.size(), 1U);
  const Field& field = *volume.fields[0].field;
  EXPECT_FALSE(field.scalar({0.25, 2, -0.5}).inside);
  ASSERT_TRUE(field.scalar({1.5, 2, -0.5}).inside);
  EXPECT_NEAR(field.scalar({1.5, 2, -0.5}).value, linear({1.5, 2, -0.5}), 1e-4);
}

TEST_F(Grids, PiecesInFilesOfTheirOwn) {
  const FileGrid grid{{5, 4, 6}, {{{0.5, 0, 0}, {0, 0.25, 0}, {0, 0, 2}}}, {10, 20, 30}};
  const auto metres = [](const Vec3& p) { return p; };
  const auto part = [&](const std::string& extent, std::int64_t first, std::int64_t count) {
    FileGrid piece = grid;
    piece.dims[2] = count;
    piece.origin = grid.at({0, 0, static_cast<double>(first)});
    const std::string doubles = linear_voxels<double>(piece, metres);
    std::string numbers;
    for (std::size_t at = 0; at < doubles.size(); at += 8) {
      double value = 0;
      std::memcpy(&value, doubles.data() + at, 8);
      numbers += number(value);
    }
    return "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\"><ImageData WholeExtent=\"" + extent +
           "\" Origin=\"8.5 19 20\" Spacing=\"0.5 0.25 2\"><Piece Extent=\"" + extent + "\"><PointData>" + array("a", numbers) +
           "</PointData></Piece></ImageData></VTKFile>";
  };
  folder_.write("low.vti", part("3 7 4 7 5 8", 0, 4));
  folder_.write("high.vti", part("3 7 4 7 8 10", 3, 3));
  const auto whole = [](const std::string& pieces) {
    return "<VTKFile type=\"PImageData\" version=\"1.0\" byte_order=\"LittleEndian\"><PImageData WholeExtent=\"3 7 4 7 5 10\" "
           "GhostLevel=\"0\" Origin=\"8.5 19 20\" Spacing=\"0.5 0.25 2\"><PPointData><PDataArray type=\"Float64\" "
           "Name=\"a\"/></PPointData>" +
           pieces + "</PImageData></VTKFile>";
  };
  const std::string low = "<Piece Extent=\"3 7 4 7 5 8\" Source=\"low.vti\"/>";
  const std::string high = "<Piece Extent=\"3 7 4 7 8 10\" Source=\"high.vti\"/>";
  const Volume volume = read(folder_.write("a.pvti", whole(low + high)));
  expect_linear(*volume.fields[0].field, grid, metres);
  EXPECT_EQ(volume.files.size(), 3U);
  EXPECT_NE(error_of([&] { read(folder_.write("b.pvti", whole(low))); }).find("do not fill"), std::string::npos);
  const std::string missing = "<Piece Extent=\"3 7 4 7 8 10\" Source=\"lost.vti\"/>";
  EXPECT_NE(error_of([&] { read(folder_.write("c.pvti", whole(low + missing))); }).find("lost.vti"), std::string::npos);

  folder_.write("part.vtu", file_of("UnstructuredGrid", "", unstructured(1.0)));
  const Volume cells = read(folder_.write(
      "a.pvtu",
      "<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\"><PUnstructuredGrid GhostLevel=\"0\"><PPointData><PDataArray "
      "type=\"Float64\" Name=\"p\"/></PPointData><PCellData><PDataArray type=\"Float64\" "
      "Name=\"c\"/></PCellData><PPoints><PDataArray type=\"Float64\" NumberOfComponents=\"3\"/></PPoints><Piece "
      "Source=\"part.vtu\"/></PUnstructuredGrid></VTKFile>"));
  EXPECT_NEAR(field_of(cells, "p").scalar({0.5, 0.5, 0.5}).value, linear({0.5, 0.5, 0.5}), 1e-4);
}

TEST_F(Grids, WhatHasNoVolumeIsRefused) {
  const auto flat = [](const Vec3& p) { return Vec3{p.x, p.y, 0}; };
  const std::string data = "<PointData>" + array("p", point_values()) + "</PointData>";
  error_of([&] { read(folder_.write("a.vts", file_of("StructuredGrid", "0 4 0 3 0 2", structured(data, flat)))); });
  VolumeRequest crop;
  crop.crop = Box{{5, 5, 5}, {6, 6, 6}};
  const fs::path cells = folder_.write("b.vtu", file_of("UnstructuredGrid", "", unstructured(1.0)));
  EXPECT_NE(error_of([&] { read(cells, crop); }).find("crop_m"), std::string::npos);
  const fs::path straight =
      folder_.write("c.vts", file_of("StructuredGrid", "0 4 0 3 0 2", structured(data, [](const Vec3& p) { return p; })));
  EXPECT_NE(error_of([&] { read(straight, crop); }).find("crop_m"), std::string::npos);
  EXPECT_NE(error_of([&] {
              read(folder_.write("d.dx", "object 1 class gridpositions counts 2 2 2\norigin 0 0 0\n"));
            }).find("OpenDX"),
            std::string::npos);
}

TEST_F(Grids, VectorsAlongTheGridTurnWithIt) {
  std::string vectors;
  for (int p = 0; p < 8; ++p) vectors += "1 0 3 ";
  const fs::path file = folder_.write(
      "a.vti",
      "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\"><ImageData WholeExtent=\"0 1 0 1 0 1\" "
      "Origin=\"0 0 0\" Spacing=\"1 2 3\" Direction=\"0 -1 0 1 0 0 0 0 1\"><Piece Extent=\"0 1 0 1 0 1\"><PointData>" +
          array("v", vectors, 3) + "</PointData></Piece></ImageData></VTKFile>");
  VolumeRequest request;
  EXPECT_EQ(read(file, request).fields[0].field->vector({-1, 0.5, 1}).value, (Vec3{1, 0, 3}));
  request.components_along = "index";
  EXPECT_EQ(read(file, request).fields[0].field->vector({-1, 0.5, 1}).value, (Vec3{0, 1, 3}));
  const fs::path bent =
      folder_.write("a.vts", file_of("StructuredGrid", "0 4 0 3 0 2",
                                     structured("<PointData>" + array("p", point_values()) + "</PointData>", [](const Vec3& p) {
                                       return Vec3{p.x, p.y + p.x * p.x, p.z};
                                     })));
  EXPECT_NE(error_of([&] { read(bent, request); }).find("components_along"), std::string::npos);
}

}  // namespace grids_test
}  // namespace palpa::test
