// Blocks of one grid in several files of VTK's XML: .vtm, .pvd, several .vts.
#include <functional>

#include "files.h"

namespace palpa::test {
namespace blocks_test {

const Linear linear{{3, -2, 5}, 7};
constexpr int columns = 9, rows = 5, layers = 4;

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g ", value);
  return text;
}

/// Columns [first, last] of a bent grid with steps of 0.25, as a .vts. \param more  added to each value
std::string vts(int first, int last, double more = 0.0, const std::string& extra = "") {
  std::string points, values;
  for (int k = 0; k < layers; ++k)
    for (int j = 0; j < rows; ++j)
      for (int i = first; i <= last; ++i) {
        const Vec3 p{0.25 * i + 0.02 * j * j, 0.25 * j, 0.25 * k + 0.01 * i * i};
        points += number(p.x) + number(p.y) + number(p.z);
        values += number(linear(p) + more);
      }
  const auto array = [](const std::string& name, int components, const std::string& numbers) {
    return "<DataArray type=\"Float64\" Name=\"" + name + "\" NumberOfComponents=\"" + std::to_string(components) +
           "\" format=\"ascii\">" + numbers + "</DataArray>";
  };
  const std::string extent = std::to_string(first) + " " + std::to_string(last) + " 0 " + std::to_string(rows - 1) + " 0 " +
                             std::to_string(layers - 1);
  return "<VTKFile type=\"StructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\"><StructuredGrid WholeExtent=\"" +
         extent + "\"><Piece Extent=\"" + extent + "\"><PointData>" + array("p", 1, values) +
         (extra.empty() ? "" : array(extra, 1, values)) + "</PointData><Points>" + array("points", 3, points) +
         "</Points></Piece></StructuredGrid></VTKFile>";
}

class Blocks : public ReaderTest {
 protected:
  void SetUp() override {
    ReaderTest::SetUp();
    fs::create_directory(folder_.path() / "parts");
    folder_.write("parts/left.vts", vts(0, 4));
    folder_.write("parts/right.vts", vts(4, 8, 0.0, "only_here"));
  }
  static std::string vtm(const std::string& inside) {
    return "<VTKFile type=\"vtkMultiBlockDataSet\" version=\"1.0\"><vtkMultiBlockDataSet>" + inside +
           "</vtkMultiBlockDataSet></VTKFile>";
  }
  static std::string data_set(const std::string& file, const std::string& attributes = "index=\"0\"") {
    return "<DataSet " + attributes + " file=\"" + file + "\"/>";
  }
  static void expect_whole(const Volume& volume, double more = 0.0) {
    ASSERT_EQ(volume.fields.size(), 1U);
    int inside = 0;
    for (int n = 0; n < 300; ++n) {  // on both sides of the blocks' common border, x = 1 and beyond
      const Vec3 at{0.5 + (n % 17) / 16.0, 0.2 + 0.5 * (n % 7) / 6.0, 0.52 + 0.08 * (n % 5) / 4.0};
      const ScalarSample s = volume.fields[0].field->scalar(at);
      inside += s.inside;
      if (!s.inside) continue;
      ASSERT_NEAR(s.value, linear(at) + more, 1e-4) << at.x << " " << at.y << " " << at.z;
    }
    EXPECT_GT(inside, 280);
  }
};

TEST_F(Blocks, OfAMultiBlockFileAreOneVolume) {
  const std::string tree = "<Block index=\"0\" name=\"fluid\">" + data_set("parts/left.vts") +
                           data_set("parts/right.vts", "index=\"1\"") + data_set("", "index=\"2\"") + "</Block>";
  const Volume volume = read(folder_.write("a.vtm", vtm(tree)));
  expect_whole(volume);
  EXPECT_EQ(volume.format, "vtm");
  EXPECT_EQ(volume.files.size(), 3U);
  EXPECT_TRUE(warns_of(volume, "'only_here' is left out: some blocks do not have it")) << all_warnings(volume);
}

TEST_F(Blocks, InSeveralFilesAreOneVolume) {
  VolumeRequest request;
  request.files = {folder_.path() / "parts/left.vts", folder_.path() / "parts/right.vts"};
  const Volume volume = read_volume(request, options_);
  expect_whole(volume);
  EXPECT_EQ(volume.files.size(), 2U);
  request.files[1] = folder_.write("b.vtk", "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\n");
  EXPECT_NE(error_of([&] { read_volume(request, options_); }).find("no grid of VTK's XML"), std::string::npos);
}

TEST_F(Blocks, OfOneMomentOfACollectionAreOneVolume) {
  folder_.write("parts/later.vtm", vtm(data_set("late_left.vts") + data_set("late_right.vts")));
  folder_.write("parts/late_left.vts", vts(0, 4, 100.0));
  folder_.write("parts/late_right.vts", vts(4, 8, 100.0));
  const fs::path file = folder_.write("a.pvd", "<VTKFile type=\"Collection\" version=\"0.1\"><Collection>" +
                                                   data_set("parts/left.vts", "timestep=\"0.5\" part=\"0\"") +
                                                   data_set("parts/right.vts", "timestep=\"0.5\" part=\"1\"") +
                                                   data_set("parts/later.vtm", "timestep=\"2\"") + "</Collection></VTKFile>");
  const Volume latest = read(file);
  expect_whole(latest, 100.0);
  EXPECT_TRUE(warns_of(latest, "holds 2 moments: the latest, 2 s, is read")) << all_warnings(latest);
  VolumeRequest request;
  request.time_s = 0.5;
  expect_whole(read(file, request));
  request.time_s = 1.0;
  EXPECT_NE(error_of([&] { read(file, request); }).find("no moment 1 s"), std::string::npos);
}

TEST_F(Blocks, ThatCannotBeReadAreNamed) {
  const auto error = [&](const std::string& inside) { return error_of([&] { read(folder_.write("a.vtm", vtm(inside))); }); };
  EXPECT_NE(error(data_set("parts/lost.vts")).find("lost.vts"), std::string::npos);
  EXPECT_NE(error(data_set("/etc/passwd")).find("outside"), std::string::npos);
  EXPECT_NE(error("").find("names no file"), std::string::npos);
  EXPECT_NE(error(data_set("a.vtm")).find("a.vtm"), std::string::npos) << "a circle";
  EXPECT_NE(error("<Block").find("whole"), std::string::npos);
  folder_.write("parts/cut.vts", vts(0, 4).substr(0, 900));
  const std::string cut = error(data_set("parts/left.vts") + data_set("parts/cut.vts"));
  EXPECT_NE(cut.find("has a block 'cut.vts' that"), std::string::npos) << cut;
  folder_.write("parts/skin.vtp", "<VTKFile type=\"PolyData\" version=\"1.0\"><PolyData/></VTKFile>");
  EXPECT_NE(error(data_set("parts/skin.vtp")).find("only surfaces"), std::string::npos);
  const Volume volume =
      read(folder_.write("b.vtm", vtm(data_set("parts/left.vts") + data_set("parts/right.vts") + data_set("parts/skin.vtp"))));
  EXPECT_TRUE(warns_of(volume, "1 surfaces beside its grids")) << all_warnings(volume);
}

}  // namespace blocks_test
}  // namespace palpa::test
