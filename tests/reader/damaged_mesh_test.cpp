// Reading time of a mesh with a damaged byte.
#include <cmath>

#include "files.h"

namespace palpa::test {
namespace damaged_mesh_test {

class DamagedMesh : public ReaderTest {
 protected:
  /// Reads within few seconds of processor time: a sound mesh of this size takes 0.1 s; a search for damaged cells all over the
  /// grid took 16 s.
  Volume read_quickly(const fs::path& file) const {
    ReadOptions options = options_;
    options.idle_limit_s = 4.0;
    options.checksums = Checksums::none;
    VolumeRequest request;
    request.files = {file};
    return read_volume(request, options);
  }
};

constexpr int n = 22;  // points along each side of a mesh of hexahedra
Vec3 bent(const Vec3& x) {
  return {x.x + 0.2 * std::sin(0.3 * x.y), x.y + 0.2 * std::sin(0.3 * x.z), x.z + 0.1 * std::sin(0.3 * x.x)};
}

/// A mesh over [0, n - 1]³, bent a little, that holds x + 2 y + 3 z; `moved` is the position of its middle point.
std::string mesh(const Vec3* moved) {
  const auto array = [](const std::string& name, const std::string& type, const std::string& numbers, int components = 1) {
    return "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" + std::to_string(components) +
           "\" format=\"ascii\">" + numbers + "</DataArray>";
  };
  std::string points, values, connectivity, offsets, types;
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const Vec3 sound = bent({double(i), double(j), double(k)});
        const Vec3 at = moved && i == n / 2 && j == n / 2 && k == n / 2 ? *moved : sound;
        for (const double x : {at.x, at.y, at.z}) points += std::to_string(x) + " ";
        values += std::to_string(sound.x + 2 * sound.y + 3 * sound.z) + " ";
        if (i + 1 == n || j + 1 == n || k + 1 == n) continue;
        const int p = i + n * (j + n * k);
        for (const int q : {p, p + 1, p + 1 + n, p + n}) connectivity += std::to_string(q) + " ";
        for (const int q : {p, p + 1, p + 1 + n, p + n}) connectivity += std::to_string(q + n * n) + " ";
        offsets += std::to_string(8 * (1 + i + (n - 1) * (j + (n - 1) * k))) + " ";
        types += "12 ";
      }
  const std::string cells = std::to_string((n - 1) * (n - 1) * (n - 1));
  return "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\"><UnstructuredGrid><Piece "
         "NumberOfPoints=\"" +
         std::to_string(n * n * n) + "\" NumberOfCells=\"" + cells + "\"><PointData>" + array("value", "Float32", values) +
         "</PointData><Points>" + array("Points", "Float32", points, 3) + "</Points><Cells>" +
         array("connectivity", "Int64", connectivity) + array("offsets", "Int64", offsets) + array("types", "UInt8", types) +
         "</Cells></Piece></UnstructuredGrid></VTKFile>";
}

double at(const Volume& volume, const Vec3& place) { return volume.fields[0].field->scalar(place).value; }

TEST_F(DamagedMesh, IsReadAsFastAsASoundOne) {
  const Vec3 far{-900.0, 800.0, 1000.0};
  const Volume volume = read_quickly(folder_.write("a.vtu", mesh(&far)));
  EXPECT_GT(grid_of(*volume.fields[0].field)->geometry.voxels(), 1'000'000) << "the grid reaches out to the point";
}

TEST_F(DamagedMesh, OfPlot3dIsReadAsFastAsASoundOne) {
  const Vec3 far{-900.0, 800.0, 1000.0};
  std::string xyz, q;
  for (std::string* file : {&xyz, &q}) {
    for (int axis = 0; axis < 3; ++axis) *file += bytes_of(std::int32_t{n}, false);
  }
  for (const float of : {3.0F, 0.0F, 1e6F, 0.5F}) q += bytes_of(of, false);
  for (double Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z})
    for (int p = 0; p < n * n * n; ++p) {
      const int i = p % n, j = p / n % n, k = p / n / n;
      const Vec3 at = i == n / 2 && j == n / 2 && k == n / 2 ? far : bent({double(i), double(j), double(k)});
      xyz += bytes_of(static_cast<float>(at.*axis), false);
    }
  for (const float value : {2.0F, 1.0F, 1.0F, 1.0F, 10.0F})
    for (int p = 0; p < n * n * n; ++p) q += bytes_of(value, false);
  folder_.write("a.xyz", xyz);
  const Volume volume = read_quickly(folder_.write("a.q", q));
  EXPECT_GT(grid_of(*volume.fields[0].field)->geometry.voxels(), 1'000'000) << "the grid reaches out to the point";
}

// Cells of every size and direction, with a point within the mesh or far out, get the voxels of a full search in each box.
TEST_F(DamagedMesh, HasTheValuesOfItsLongCells) {
  const Vec3 out{40.0, 45.0, 50.0};
  const Volume volume = read_quickly(folder_.write("a.vtu", mesh(&out)));
  const double sound = at(read_quickly(folder_.write("b.vtu", mesh(nullptr))), {3.0, 4.0, 5.0});
  EXPECT_NEAR(at(volume, {3.0, 4.0, 5.0}), sound, 0.3) << "far from the damage";
  // On the line from the middle to the damaged point, in a spike of stretched cells that narrows to 0: a point has data where
  // all eight voxels around it are in the spike, up to 0.3 of its length at half a unit of spacing.
  const Vec3 middle = bent({n / 2.0, n / 2.0, n / 2.0});
  for (int step = 0; step < 95; ++step) {
    const ScalarSample s = volume.fields[0].field->scalar(middle + (step / 100.0) * (out - middle));
    EXPECT_TRUE(s.inside || step > 25) << step;
    if (s.inside) {
      EXPECT_NEAR(s.value, middle.x + 2 * middle.y + 3 * middle.z, 5.0) << step;
    }
  }
}

}  // namespace damaged_mesh_test
}  // namespace palpa::test
