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
      EXPECT_EQ(number("settled", 0), !point.unsettled);
    }
  }
  fs::remove_all(folder);
}

}  // namespace map_file_test
}  // namespace palpa
