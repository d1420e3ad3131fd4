// Arrays of HDF5 files and VTKHDF images, written here with the library itself.
#include "hdf5_file.h"

namespace palpa::test {
namespace hdf5_test {

class Hdf5 : public ReaderTest {
 protected:
  fs::path path(const std::string& name) const { return folder_.path() / name; }
};

const FileGrid grid{{6, 5, 4}, {{{0.5, 0, 0}, {0, 0.25, 0}, {0, 0, 2}}}, {1, 2, 3}};
Vec3 metres(const Vec3& p) { return p; }

VolumeRequest with_spacing() {
  VolumeRequest request;
  request.layout.spacing_m = {0.5, 0.25, 2};
  request.layout.origin_m = Vec3{1, 2, 3};
  return request;
}

TEST_F(Hdf5, ArraysByPathInAnyOrderOfAxes) {
  const hid_t file = H5Fcreate(path("a.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const std::string zyx = linear_voxels<double>(grid, metres);
  write_array<double>(file, "/flow/p", {4, 5, 6}, zyx, true);
  // Transposed: x slowest.
  std::string xyz;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 5; ++j)
      for (std::size_t k = 0; k < 4; ++k) xyz += zyx.substr(8 * (i + 6 * (j + 5 * k)), 8);
  write_array<double>(file, "/flow/q", {6, 5, 4}, xyz);
  H5Fclose(file);
  VolumeRequest request = with_spacing();
  expect_linear(*read(path("a.h5:/flow/p"), request).fields[0].field, grid, metres);
  request.layout.dims = {6, 5, 4};
  expect_linear(*read(path("a.h5:/flow/p"), request).fields[0].field, grid, metres);
  request.layout.axes = "xyz";
  const Volume turned = read(path("a.h5:/flow/q"), request);
  EXPECT_EQ(turned.fields[0].name, "q");
  expect_linear(*turned.fields[0].field, grid, metres);
  request.layout.axes = "zyx";
  EXPECT_NE(error_of([&] { read(path("a.h5:/flow/q"), request); }).find("dims says"), std::string::npos);
  EXPECT_NE(error_of([&] { read(path("a.h5")); }).find("/flow/p, /flow/q"), std::string::npos);
  EXPECT_NE(error_of([&] { read(path("a.h5:/flow/r")); }).find("/flow/p, /flow/q"), std::string::npos);
  EXPECT_TRUE(warns_of(read(path("a.h5:/flow/p")), "no distances of voxels"));
}

TEST_F(Hdf5, ComponentsFirstOrLast) {
  const hid_t file = H5Fcreate(path("a.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  std::string first, last;
  for (int v = 0; v < 2 * 2 * 2; ++v)
    for (const float c : {1.0F, 2.0F, 3.0F}) last += bytes_of(c);
  for (const float c : {1.0F, 2.0F, 3.0F})
    for (int v = 0; v < 2 * 2 * 2; ++v) first += bytes_of(c);
  write_array<float>(file, "/last", {2, 2, 2, 3}, last);
  write_array<float>(file, "/first", {3, 2, 2, 2}, first);
  write_array<float>(file, "/either", {3, 2, 2, 3}, std::string(4 * 36, '\0'));
  H5Fclose(file);
  for (const char* name : {"first", "last"}) {
    VolumeRequest request = with_spacing();
    for (const char* said : {name, ""}) {
      request.layout.components = said;
      const Volume volume = read(path(std::string("a.h5:/") + name), request);
      EXPECT_EQ(volume.fields[0].field->vector({1.2, 2.1, 4}).value, (Vec3{1, 2, 3})) << name;
    }
  }
  EXPECT_NE(error_of([&] { read(path("a.h5:/either")); }).find("components"), std::string::npos);
}

TEST_F(Hdf5, OtherFilesAreNotFollowed) {
  const hid_t other = H5Fcreate(path("other.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  write_array<float>(other, "/p", {2, 2, 2}, std::string(32, '\0'));
  H5Fclose(other);
  const hid_t file = H5Fcreate(path("a.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  H5Lcreate_external(path("other.h5").c_str(), "/p", file, "linked", H5P_DEFAULT, H5P_DEFAULT);
  H5Lcreate_soft("/linked", file, "twice", H5P_DEFAULT, H5P_DEFAULT);
  const hsize_t lengths[3] = {2, 2, 2};
  const hid_t space = H5Screate_simple(3, lengths, nullptr), creation = H5Pcreate(H5P_DATASET_CREATE);
  folder_.write("numbers.raw", std::string(32, '\0'));
  H5Pset_external(creation, path("numbers.raw").c_str(), 0, 32);
  H5Dclose(H5Dcreate2(file, "/outside", H5T_NATIVE_FLOAT, space, H5P_DEFAULT, creation, H5P_DEFAULT));
  H5Sclose(space), H5Pclose(creation);
  write_array<float>(file, "/own", {2, 2, 2}, std::string(32, '\0'));
  H5Fclose(file);
  EXPECT_EQ(read(path("a.h5:/own"), with_spacing()).fields[0].name, "own");
  error_of([&] { read(path("a.h5:/linked")); });
  error_of([&] { read(path("a.h5:/twice")); });
  EXPECT_NE(error_of([&] { read(path("a.h5:/outside")); }).find("other files"), std::string::npos);
}

TEST_F(Hdf5, VtkhdfImages) {
  const hid_t file = H5Fcreate(path("a.vtkhdf").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  FileGrid cells = grid;
  cells.dims[0] = 5, cells.dims[1] = 4, cells.dims[2] = 3;
  cells.origin = grid.at({0.5, 0.5, 0.5});
  write_array<double>(file, "/VTKHDF/PointData/p", {4, 5, 6}, linear_voxels<double>(grid, metres));
  write_array<double>(file, "/VTKHDF/CellData/p", {3, 4, 5}, linear_voxels<double>(cells, metres));
  write_array<float>(file, "/VTKHDF/PointData/odd", {4, 5, 5}, std::string(400, '\0'));
  const hid_t root = H5Gopen2(file, "VTKHDF", H5P_DEFAULT);
  write_text(root, "Type", "ImageData");
  write_numbers(root, "WholeExtent", {2, 7, 3, 7, 4, 7});
  write_numbers(root, "Origin", {0, 1.25, -5});
  write_numbers(root, "Spacing", {0.5, 0.25, 2});
  H5Gclose(root), H5Fclose(file);
  const Volume volume = read(path("a.vtkhdf"));
  EXPECT_EQ(volume.format, "vtkhdf");
  ASSERT_EQ(volume.fields.size(), 2U);
  expect_linear(*volume.fields[0].field, grid, metres);
  EXPECT_EQ(volume.fields[1].name, "p_cells");
  expect_linear(*volume.fields[1].field, cells, metres);
  EXPECT_TRUE(warns_of(volume, "'odd' is left out"));
}

// HDF5 does not check the length of a chunk without a filter, and returned memory behind it as voxels.
TEST_F(Hdf5, AChunkThatIsShorterThanItsNumbersIsRefused) {
  constexpr std::uint32_t without_deflate = 0b10, without_filters = 0b11;
  const std::string numbers = linear_voxels<double>(grid, metres);
  const auto written = [&](const char* name, std::size_t bytes, std::uint32_t without) {
    const hid_t file = H5Fcreate(path(name).c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    write_array<double>(file, "/p", {4, 5, 6}, numbers, true);
    const hid_t data = H5Dopen2(file, "/p", H5P_DEFAULT);
    const hsize_t first[3] = {0, 0, 0};
    H5Dwrite_chunk(data, H5P_DEFAULT, without, first, bytes, numbers.data());
    H5Dclose(data), H5Fclose(file);
    return path(name);
  };
  expect_linear(*read(written("whole.h5", numbers.size(), without_filters), with_spacing()).fields[0].field, grid, metres);
  for (const std::size_t bytes : {std::size_t{1}, std::size_t{203}, numbers.size() - 1}) {
    for (const std::uint32_t without : {without_filters, without_deflate}) {
      const fs::path file = written("short.h5", bytes, without);
      EXPECT_NE(error_of([&] { read(file, with_spacing()); }).find("it is damaged"), std::string::npos) << bytes;
    }
  }
}

TEST_F(Hdf5, WholeNumbersTurnedRoundAndFilesCutShort) {
  const hid_t file = H5Fcreate(path("a.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  std::string numbers;
  for (std::int16_t v = 0; v < 1000; ++v) numbers += bytes_of(v);
  write_array<std::int16_t>(file, "/ct", {10, 10, 10}, numbers);
  H5Fclose(file);
  const Volume volume = read(path("a.h5"), with_spacing());
  EXPECT_EQ(grid_of(*volume.fields[0].field)->voxels.type, VoxelType::int16);
  EXPECT_EQ(volume.fields[0].field->scalar({1 + 0.5 * 3, 2 + 0.25 * 2, 3 + 2 * 4}).value, 423.0);
  const auto bytes = std::filesystem::file_size(path("a.h5"));
  for (const std::uintmax_t size : {bytes - 1, bytes / 2, std::uintmax_t{100}, std::uintmax_t{8}}) {
    std::filesystem::resize_file(path("a.h5"), size);
    error_of([&] { read(path("a.h5"), with_spacing()); });
  }
  error_of([&] { read(folder_.write("b.h5", "no HDF5 at all")); });
}

}  // namespace hdf5_test
}  // namespace palpa::test
