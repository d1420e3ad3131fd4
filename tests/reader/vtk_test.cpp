#include "files.h"

namespace palpa::test {
namespace vtk_test {

class Vtk : public ReaderTest {};

Vec3 metres(const Vec3& p) { return p; }

/// A grid whose indices begin at 3, 4, 5, with an oblique Direction; `grid` has its first voxel at index 0.
struct Offset {
  FileGrid grid;
  std::string attributes;
};
Offset offset_grid() {
  const Mat3 direction{{{0.6, -0.8, 0}, {0.8, 0.6, 0}, {0, 0, 1}}};
  const Mat3 step = direction * Mat3{{{0.5, 0, 0}, {0, 0.25, 0}, {0, 0, 2}}};
  return {{{6, 5, 4}, step, step * Vec3{3, 4, 5} + Vec3{10, 20, 30}},
          "Origin=\"10 20 30\" Spacing=\"0.5 0.25 2\" Direction=\"0.6 -0.8 0 0.8 0.6 0 0 0 1\""};
}

std::string numbers_of(const std::string& doubles) {
  std::string text;
  for (std::size_t at = 0; at < doubles.size(); at += 8) {
    double value = 0;
    std::memcpy(&value, doubles.data() + at, 8);
    char number[40];
    std::snprintf(number, sizeof number, "%.17g ", value);
    text += number;
  }
  return text;
}

std::string vti(const std::string& attributes, const std::string& extent, const std::string& pieces,
                const std::string& order = "LittleEndian") {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"" + order +
         "\" header_type=\"UInt64\">\n<ImageData WholeExtent=\"" + extent + "\" " + attributes + ">" + pieces +
         "</ImageData>\n";
}

std::string ascii_array(const std::string& name, const std::string& type, const std::string& numbers, int components = 1) {
  return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" + std::to_string(components) +
         "\" format=\"ascii\">" + numbers + "</DataArray>";
}

TEST_F(Vtk, ExtentsNeedNotBeginAtZeroAndDirectionIsKept) {
  const Offset o = offset_grid();
  const std::string numbers = numbers_of(linear_voxels<double>(o.grid, metres));
  const Volume volume = read(folder_.write("a.vti", vti(o.attributes, "3 8 4 8 5 8",
                                                        "<Piece Extent=\"3 8 4 8 5 8\"><PointData>" +
                                                            ascii_array("a", "Float64", numbers) + "</PointData></Piece>") +
                                                        "</VTKFile>"));
  EXPECT_TRUE(warns_of(volume, "metres are taken"));
  EXPECT_FALSE(volume.medical_frame);
  expect_linear(*volume.fields[0].field, o.grid, metres);
}

TEST_F(Vtk, AppendedNumbersDoNotBeginInTheHeader) {
  const FileGrid grid{{6, 5, 4}, {{{0.5, 0, 0}, {0, 0.25, 0}, {0, 0, 2}}}, {1, 2, 3}};
  const std::string voxels = linear_voxels<double>(grid, metres);
  const auto file = [&](const std::string& offset, bool with_data) {
    return folder_.write(
        "a.vti", vti("Origin=\"1 2 3\" Spacing=\"0.5 0.25 2\"", "0 5 0 4 0 3",
                     "<Piece Extent=\"0 5 0 4 0 3\"><PointData><DataArray type=\"Float64\" Name=\"a\" format=\"appended\" "
                     "offset=\"" +
                         offset + "\"/></PointData></Piece>") +
                     (with_data ? "<AppendedData encoding=\"raw\">_" + bytes_of(static_cast<std::uint64_t>(voxels.size())) +
                                      voxels + "</AppendedData>"
                                : "") +
                     "</VTKFile>");
  };
  expect_linear(*read(file("0", true)).fields[0].field, grid, metres);
  for (const char* offset : {"-8", "-300", "-1000000"}) {
    EXPECT_NE(error_of([&] { read(file(offset, true)); }).find("offset"), std::string::npos) << offset;
  }
  error_of([&] { read(file("0", false)); });
}

TEST_F(Vtk, CellDataLieAtTheCentresOfCells) {
  const Offset o = offset_grid();
  const FileGrid cells{{5, 4, 3}, o.grid.step, o.grid.at({0.5, 0.5, 0.5})};
  const Linear other{{1, 2, 3}, 4};
  const Volume volume = read(folder_.write(
      "a.vti",
      vti(o.attributes, "3 8 4 8 5 8",
          "<Piece Extent=\"3 8 4 8 5 8\"><PointData>" +
              ascii_array("a", "Float64", numbers_of(linear_voxels<double>(o.grid, metres))) + "</PointData><CellData>" +
              ascii_array("a", "Float64", numbers_of(linear_voxels<double>(cells, metres, false, other))) +
              "</CellData></Piece>") +
          "</VTKFile>"));
  ASSERT_EQ(volume.fields.size(), 2U);
  EXPECT_EQ(volume.fields[0].name, "a");
  EXPECT_EQ(volume.fields[1].name, "a_cells");
  expect_linear(*volume.fields[0].field, o.grid, metres);
  expect_linear(*volume.fields[1].field, cells, metres, other);
}

TEST_F(Vtk, DamagedFieldDataAreNotLookedAt) {
  const Offset o = offset_grid();
  const std::string piece = "<Piece Extent=\"3 8 4 8 5 8\"><PointData>" +
                            ascii_array("a", "Float64", numbers_of(linear_voxels<double>(o.grid, metres))) +
                            "</PointData></Piece>";
  for (const std::string array :
       {"<DataArray type=\"Floa-64\" Name=\"t\" NumberOfTuples=\"1\" format=\"ascii\">1</DataArray>",
        "<DataArray typ9=\"9loat64\" Name=\"t\" NumberOfTuples=\"1\" format=\"appended\" offset=\"0\"/>",
        "<DataArray type=\"Float64\" Name=\"t\" NumberOfTuples=\"-1\" format=\"appended\" offset=\"0\"/>"}) {
    const std::string field_data = "<FieldData>" + array + "</FieldData>";
    const Volume volume =
        read(folder_.write("a.vti", vti(o.attributes, "3 8 4 8 5 8", field_data + field_data + piece) + "</VTKFile>"));
    ASSERT_EQ(volume.fields.size(), 1U) << array;
    expect_linear(*volume.fields[0].field, o.grid, metres);
  }
}

TEST_F(Vtk, PiecesMustFillTheGrid) {
  const Offset o = offset_grid();
  FileGrid low = o.grid, high = o.grid;
  low.dims[2] = 3, high.dims[2] = 2;
  high.origin = o.grid.at({0, 0, 2});
  const auto piece = [&](const std::string& extent, const FileGrid& grid) {
    return "<Piece Extent=\"" + extent + "\"><PointData>" +
           ascii_array("a", "Float64", numbers_of(linear_voxels<double>(grid, metres))) + "</PointData></Piece>";
  };
  const std::string first = piece("3 8 4 8 5 7", low), second = piece("3 8 4 8 7 8", high);
  const Volume volume = read(folder_.write("a.vti", vti(o.attributes, "3 8 4 8 5 8", first + second) + "</VTKFile>"));
  expect_linear(*volume.fields[0].field, o.grid, metres);
  EXPECT_NE(error_of([&] {
              read(folder_.write("b.vti", vti(o.attributes, "3 8 4 8 5 8", first) + "</VTKFile>"));
            }).find("do not fill"),
            std::string::npos);
}

TEST_F(Vtk, AppendedDataOfEitherByteOrderAndTheirLoss) {
  const Offset o = offset_grid();
  for (const bool big : {false, true}) {
    const std::string voxels = linear_voxels<float>(o.grid, metres, big);
    const std::string start =
        vti(o.attributes, "3 8 4 8 5 8",
            "<Piece Extent=\"3 8 4 8 5 8\"><PointData><DataArray type=\"Float32\" Name=\"a\" format=\"appended\" "
            "offset=\"0\"/></PointData></Piece>",
            big ? "BigEndian" : "LittleEndian") +
        "<AppendedData encoding=\"raw\">_";
    const std::string size = bytes_of(static_cast<std::uint64_t>(voxels.size()), big);
    const Volume volume = read(folder_.write("a.vti", start + size + voxels + "</AppendedData></VTKFile>"));
    expect_linear(*volume.fields[0].field, o.grid, metres);
    error_of([&] { read(folder_.write("b.vti", start + size + voxels.substr(0, 200))); });
    error_of(
        [&] { read(folder_.write("c.vti", start + bytes_of(std::uint64_t{17}, big) + voxels + "</AppendedData></VTKFile>")); });
  }
}

TEST_F(Vtk, ArraysThatCannotBeFeltAreLeftOutAndSaid) {
  std::string ones;
  for (int n = 0; n < 8 * 9; ++n) ones += "1 ";
  const auto some = [&](int count) { return ones.substr(0, static_cast<std::size_t>(2 * count)); };
  const std::string arrays = ascii_array("tensor", "Float32", some(72), 9) + ascii_array("colour", "UInt8", some(24), 3) +
                             ascii_array("big", "Int64", some(8)) + ascii_array("wind", "Int16", some(24), 3);
  const std::string attributes = "Origin=\"0 0 0\" Spacing=\"1 1 1\"";
  const auto file = [&](const std::string& inside) {
    return vti(attributes, "0 1 0 1 0 1", "<Piece Extent=\"0 1 0 1 0 1\"><PointData>" + inside + "</PointData></Piece>") +
           "</VTKFile>";
  };
  const Volume volume = read(folder_.write("a.vti", file(arrays)));
  ASSERT_EQ(volume.fields.size(), 2U) << all_warnings(volume);
  EXPECT_EQ(volume.fields[0].name, "big");
  EXPECT_EQ(grid_of(*volume.fields[0].field)->voxels.type, VoxelType::float64);
  EXPECT_EQ(volume.fields[1].field->components(), 3);
  EXPECT_EQ(grid_of(*volume.fields[1].field)->voxels.type, VoxelType::int16);
  EXPECT_TRUE(warns_of(volume, "'tensor' is left out"));
  EXPECT_TRUE(warns_of(volume, "'colour' is left out"));
  EXPECT_TRUE(warns_of(volume, "'big': 64-bit"));
  EXPECT_NE(error_of([&] {
              read(folder_.write("b.vti", file(ascii_array("tensor", "Float32", some(72), 9))));
            }).find("no array that can be felt"),
            std::string::npos);
}

TEST_F(Vtk, RequestsTakeAndRenameArrays) {
  const std::string attributes = "Origin=\"0 0 0\" Spacing=\"1 1 1\"";
  const fs::path file = folder_.write(
      "a.vti", vti(attributes, "0 1 0 1 0 1",
                   "<Piece Extent=\"0 1 0 1 0 1\"><PointData>" + ascii_array("p", "Float32", "1 1 1 1 1 1 1 1") +
                       ascii_array("q [m/s]", "Float32", "2 2 2 2 2 2 2 2") + ascii_array("r", "Float32", "3 3 3 3 3 3 3 3") +
                       "</PointData></Piece>") +
                   "</VTKFile>");
  VolumeRequest request;
  request.fields = {{"speed", "q [m/s]", "m/s"}, {"p", "", ""}};
  const Volume volume = read(file, request);
  ASSERT_EQ(volume.fields.size(), 2U);
  EXPECT_EQ(volume.fields[0].name, "speed");
  EXPECT_EQ(volume.fields[0].unit, "m/s");
  EXPECT_EQ(volume.fields[0].field->scalar({0.5, 0.5, 0.5}).value, 2.0);
  EXPECT_EQ(volume.fields[1].field->scalar({0.5, 0.5, 0.5}).value, 1.0);
  request.fields = {{"speed", "s", ""}};
  EXPECT_NE(error_of([&] { read(file, request); }).find("no array 's'; it has 'p', 'q [m/s]', 'r'"), std::string::npos);
}

const char* const legacy_start =
    "# vtk DataFile Version 3.0\na test\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\nORIGIN 1 2 3\nSPACING 0.5 0.5 2\n";

TEST_F(Vtk, LegacyFilesGiveAllTheirArrays) {
  const Volume volume = read(folder_.write(
      "a.vtk",
      std::string(legacy_start) +
          "POINT_DATA 8\nSCALARS first float\nLOOKUP_TABLE default\n1 2 3 4 5 6 7 8\nSCALARS second short\nLOOKUP_TABLE "
          "default\n8 7 6 5 4 3 2 1\n"
          "VECTORS wind double\n1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0\nFIELD more 1\nthird 1 8 int\n1 1 1 1 1 1 1 9\n"
          "CELL_DATA 1\nSCALARS inside float\nLOOKUP_TABLE default\n42\n"));
  ASSERT_EQ(volume.fields.size(), 5U) << all_warnings(volume);
  const auto field = [&](const std::string& name) -> const Field& {
    for (const VolumeField& f : volume.fields) {
      if (f.name == name) return *f.field;
    }
    throw std::runtime_error("no field " + name);
  };
  EXPECT_EQ(field("first").scalar({1.5, 2, 3}).value, 2.0);
  EXPECT_EQ(field("second").scalar({1, 2.5, 3}).value, 6.0);
  EXPECT_EQ(field("wind").vector({1.2, 2.2, 4}).value, (Vec3{1, 0, 0}));
  EXPECT_EQ(field("third").scalar({1.5, 2.5, 5}).value, 9.0);
  EXPECT_EQ(field("inside").scalar({1.25, 2.25, 4}).value, 42.0);
}

TEST_F(Vtk, LegacyFilesThatAreShortOrElse) {
  const std::string start = legacy_start;
  const std::string scalars = "POINT_DATA 8\nSCALARS a float\nLOOKUP_TABLE default\n";
  error_of([&] { read(folder_.write("a.vtk", start + scalars + "1 2 3 4 5\n")); });
  std::string binary = start + scalars + std::string(20, 'x');
  binary.replace(binary.find("ASCII"), 5, "BINARY");
  error_of([&] { read(folder_.write("b.vtk", binary)); });
  error_of([&] {
    read(folder_.write("c.vtk", start + "POINT_DATA 9\nSCALARS a float\nLOOKUP_TABLE default\n1 2 3 4 5 6 7 8 9\n"));
  });
  error_of([&] { read(folder_.write("d.vtk", start)); });
  EXPECT_NE(error_of([&] {
              read(folder_.write("e.vtk", "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 0 float\n"));
            }).find("POLYDATA"),
            std::string::npos);
  EXPECT_NE(error_of([&] {
              read(folder_.write("f.vtp", "<VTKFile type=\"PolyData\" version=\"1.0\"><PolyData/></VTKFile>"));
            }).find("PolyData"),
            std::string::npos);
}

}  // namespace vtk_test
}  // namespace palpa::test
