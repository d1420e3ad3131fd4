// Reloaded data of suggested scenes and of scenes printed by a program: from any folder, format and reading request.
#include <algorithm>
#include <fstream>

#include "dicom_file.h"
#include "hdf5_file.h"
#include "openfoam_case.h"
#include "palpa/file/directions.h"
#include "palpa/palpa.h"
#include "palpa/scene/first_scene.h"

namespace palpa::test {
namespace first_scene_files_test {

class FirstSceneFiles : public ReaderTest {
 protected:
  void SetUp() override {
    ReaderTest::SetUp();
    before_ = fs::current_path();
  }
  void TearDown() override { fs::current_path(before_); }

  /// The scenes for a request, made in the data's folder, are loaded from another folder.
  void expect_same_data(const VolumeRequest& request) {
    fs::current_path(folder_.path());
    const Volume volume = read_volume(request, options_);
    std::vector<Statistics> values;
    for (const VolumeField& field : volume.fields) values.push_back(statistics(*field.field));
    const auto felt = field_to_feel(volume, values);
    ASSERT_TRUE(felt);
    Scene code;
    code.add("fluid", Viscosity{.drag_ns_per_m = 1.0});
    code.add("data", volume);
    const std::string first = first_scene(volume, request), printed = to_toml(code);
    const fs::path elsewhere = folder_.path() / "else" / "where";
    fs::create_directories(elsewhere);
    fs::current_path(elsewhere);
    for (const bool is_printed : {false, true}) {
      const std::string& text = is_printed ? printed : first;
      SCOPED_TRACE(text);
      std::ofstream(elsewhere / "scene.toml") << text;
      const LoadedScene loaded = load_scene(elsewhere / "scene.toml", volume_reader(options_), standard_modes());
      const Volume& again = loaded.scene.volumes()[0].volume;
      ASSERT_EQ(again.fields.size(), is_printed ? volume.fields.size() : 1U);
      const std::string& name = volume.fields[*felt].name;  // a scene's table loses the order of its fields
      const auto same = std::ranges::find(again.fields, name, &VolumeField::name);
      ASSERT_NE(same, again.fields.end());
      const GridView &a = *grid_behind(*volume.fields[*felt].field), &b = *grid_behind(*same->field);
      EXPECT_EQ(a.geometry, b.geometry);
      ASSERT_EQ(a.voxels.type, b.voxels.type);
      ASSERT_EQ(a.voxels.components, b.voxels.components);
      const std::size_t bytes = static_cast<std::size_t>(a.geometry.voxels()) * static_cast<std::size_t>(a.voxels.components) *
                                size_of(a.voxels.type);
      EXPECT_EQ(std::memcmp(a.voxels.data.get(), b.voxels.data.get(), bytes), 0);
      EXPECT_EQ(a.scale, b.scale);
      EXPECT_EQ(a.offset, b.offset);
      EXPECT_EQ(again.medical_frame, volume.medical_frame);
    }
  }
  fs::path before_;
};

const FileGrid grid{{6, 5, 4}, {{{0.5, 0, 0}, {0, 0.25, 0}, {0, 0, 2}}}, {1, 2, 3}};
Vec3 metres(const Vec3& p) { return p; }

TEST_F(FirstSceneFiles, OfBareNumbersByARelativePath) {
  folder_.write("a.raw", "#" + linear_voxels<std::int16_t>(grid, metres, true, {{2, 4, 1}, 30}));
  VolumeRequest request;
  request.files = {"a.raw"};
  request.layout = {.type = "int16",
                    .byte_order = "big",
                    .header_bytes = 1,
                    .dims = {6, 5, 4},
                    .spacing_m = {0.5, 0.25, 2},
                    .origin_m = Vec3{1, 2, 3}};
  expect_same_data(request);
}

TEST_F(FirstSceneFiles, OfAnArrayInHdf5) {
  const hid_t file = H5Fcreate((folder_.path() / "a.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  write_array<double>(file, "/p", {4, 5, 6}, linear_voxels<double>(grid, metres));
  write_array<double>(file, "/flow/q", {4, 5, 6}, linear_voxels<double>(grid, metres, false, {{1, 2, 3}, 4}));
  H5Fclose(file);
  VolumeRequest request;
  request.files = {"a.h5:/flow/q"};
  request.layout.axes = "xyz";
  request.layout.spacing_m = {1, 2, 3};
  expect_same_data(request);
}

TEST_F(FirstSceneFiles, OfACaseAtAMoment) {
  write_openfoam_case(folder_);
  VolumeRequest request;
  request.files = {folder_.path()};
  request.time_s = 1.0;
  expect_same_data(request);
  request.fields = {{"pressure", "p", "Pa"}};
  expect_same_data(request);
}

TEST_F(FirstSceneFiles, OfOneSeriesOfAFolder) {
  DicomSeries large, small;
  small.uid = "1.2.4", small.intercept = 0, small.linear.at_origin = 3000;
  for (const auto& [series, slices] : {std::pair{large, 6}, {small, 4}}) {
    for (int n = 0; n < slices; ++n)
      folder_.write("i" + series.uid + std::to_string(n), series.file(series.image(series.at_mm({0, 0, double(n)}), n)));
  }
  VolumeRequest request;
  request.files = {folder_.path()};
  expect_same_data(request);
  request.series = "1.2.4";
  expect_same_data(request);
}

TEST_F(FirstSceneFiles, OfAPartnerOfAnotherNameAndAPart) {
  const fs::path points = shared_file("cfd_combustor/combxyz.bin"), solution = shared_file("cfd_combustor/combq.bin");
  if (points.empty() || solution.empty()) GTEST_SKIP() << "the shared data are not here: set PALPA_SHARED to their folder";
  fs::copy_file(points, folder_.path() / "where.xyz");
  fs::copy_file(solution, folder_.path() / "what.q");
  VolumeRequest request;
  request.files = {"where.xyz", "what.q"};
  request.length_unit = "cm";
  request.crop = Box{{0.05, -0.02, 0.25}, {0.1, 0.02, 0.3}};
  expect_same_data(request);
  request.fields = {{"u", "velocity", ""}, {"rho", "density", "kg/m3"}};
  expect_same_data(request);
}

TEST_F(FirstSceneFiles, OfOneFrameAndOfDirections) {
  const fs::path frames = shared_file("mri_epi_4d/example_nifti2.nii.gz"), tracts = shared_file("dti_brain/V1.nii.gz");
  if (frames.empty() || tracts.empty()) GTEST_SKIP() << "the shared data are not here: set PALPA_SHARED to their folder";
  VolumeRequest request;
  request.files = {frames};
  request.frame = 1;
  expect_same_data(request);
  request = {};
  request.files = {tracts};
  const auto directions = as_directions(request, read_volume_file(request, options_), options_);
  ASSERT_TRUE(directions);
  EXPECT_EQ(directions->components_along, "index") << "taken as RAS, the tracts are mirrored";
  expect_same_data(*directions);
  request.components_along = "file";
  EXPECT_EQ(as_directions(request, read_volume_file(request, options_), options_)->components_along, "file");
}

}  // namespace first_scene_files_test
}  // namespace palpa::test
