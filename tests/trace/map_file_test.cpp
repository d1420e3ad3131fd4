// Maps as files: another program finds each force at its position in the data.
#include "palpa/study/map_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkXMLImageDataReader.h>

#include <cstdlib>
#include <fstream>

namespace palpa {
namespace map_file_test {

namespace fs = std::filesystem;

TEST(MapFile, VtksOwnReaderFindsEachForceWhereItWasFelt) {
  ForceMap map(map_slice(1, 0.01, 0.1, 5));
  for (std::size_t n = 0; n < map.points.size(); ++n) {
    const double number = static_cast<double>(n);
    map.points[n] = {{0.5, 0.25 * number, 0}, {0, 1, number}, 1e-3 * number, static_cast<int>(n), n % 2 == 0};
  }
  const Similarity map_to_world{rotation_about({0, 0, 1}, 90.0), 2.0, {1, 2, 3}};
  std::string folder = (fs::temp_directory_path() / "palpa-map-XXXXXX").string();
  const fs::path file = fs::path(::mkdtemp(folder.data())) / "map.vti";
  write_map(map, map_to_world, file, detail::Existing::refused);
  vtkNew<vtkXMLImageDataReader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  vtkImageData& image = *reader->GetOutput();
  ASSERT_EQ(image.GetNumberOfPoints(), 25);
  for (int k = 0; k < 5; ++k) {
    for (int i = 0; i < 5; ++i) {
      const auto n = static_cast<vtkIdType>(map.lattice.number(i, 0, k));
      const MapPoint& point = map.points[static_cast<std::size_t>(n)];
      double at_m[3];
      image.GetPoint(n, at_m);
      EXPECT_LT(distance({at_m[0], at_m[1], at_m[2]}, map_to_world.to_world(map.lattice.place_m(i, 0, k))), 1e-9);
      const auto number = [&](const char* name, int c) { return image.GetPointData()->GetArray(name)->GetComponent(n, c); };
      // x of the hand is y of the world.
      EXPECT_NEAR(number("first_contact_n", 1), point.first_contact_n.x, 1e-6);
      EXPECT_NEAR(number("first_contact_n", 0), -point.first_contact_n.y, 1e-6) << "newtons, not scaled";
      EXPECT_NEAR(number("steady_n", 2), point.steady_n.z, 1e-6);
      EXPECT_NEAR(number("proxy_distance_m", 0), point.proxy_distance_m, 1e-9);
      EXPECT_EQ(number("broken_levels", 0), point.broken_levels);
      EXPECT_EQ(number("settled", 0), point.settled);
    }
  }
  fs::remove_all(folder);
}

TEST(MapFile, ParaViewOpensIt) {
  if (std::string(PALPA_PVPYTHON).empty()) GTEST_SKIP() << "no pvpython; install python3-paraview to try maps in ParaView";
  ForceMap map(map_slice(0, 0.0, 0.1, 4));
  for (MapPoint& point : map.points) point.steady_n = {0.0, 3.0, 4.0};
  std::string name = (fs::temp_directory_path() / "palpa-map-XXXXXX").string();
  const fs::path folder = ::mkdtemp(name.data());
  write_map(map, Similarity{}, folder / "map.vti", detail::Existing::refused);
  std::ofstream(folder / "look.py") << "from paraview.simple import *\n"
                                       "read = XMLImageDataReader(FileName=['map.vti'])\n"
                                       "read.UpdatePipeline()\n"
                                       "open('seen', 'w').write('%d %.6f' % (read.GetDataInformation().GetNumberOfPoints(), "
                                       "read.PointData['steady_n'].GetRange(-1)[1]))\n";
  const std::string command = "cd '" + folder.string() + "' && '" PALPA_PVPYTHON "' look.py >output 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0);
  std::string seen;
  std::getline(std::ifstream(folder / "seen"), seen);
  EXPECT_EQ(seen, "16 5.000000");
  fs::remove_all(folder);
}

}  // namespace map_file_test
}  // namespace palpa
