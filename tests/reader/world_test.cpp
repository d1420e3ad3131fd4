// World positions of the data against ITK and one another, at points between voxels.
#include <cmath>
#include <random>

#include "dicom_file.h"
#include "itk_image.h"

namespace palpa::test {
namespace world_test {

class World : public ReaderTest {
 protected:
  void SetUp() override {
    ReaderTest::SetUp();
    if (!IsSkipped() && shared_file("facts.json").empty()) {
      GTEST_SKIP() << "the shared data are not here: set PALPA_SHARED to their folder";
    }
  }
  Volume open(const std::string& name, VolumeRequest request = {}) const { return read(shared_file(name), std::move(request)); }

  std::mt19937 random_{7};
  Vec3 point_in(const Box& box_m) {
    const auto between = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random_); };
    return {between(box_m.low_m.x, box_m.high_m.x), between(box_m.low_m.y, box_m.high_m.y),
            between(box_m.low_m.z, box_m.high_m.z)};
  }

  /// Expects ITK's values at 1000 points of the box, except at its rim, where either may be outside.
  void expect_as_itk(const Volume& volume, const ItkImage& itk) {
    const Field& field = *volume.fields[0].field;
    const ValueRange extent = field.value_ranges()[0];
    int inside = 0, rim = 0;
    for (int n = 0; n < 1000; ++n) {
      const Vec3 at_m = point_in(field.bounds_m());
      const ScalarSample sample = field.scalar(at_m);
      const double expected = itk.at(1e3 * at_m);
      rim += sample.inside != std::isfinite(expected);
      if (!sample.inside || !std::isfinite(expected)) continue;
      ++inside;
      ASSERT_NEAR(sample.value, expected, 1e-4 * (extent.max - extent.min)) << at_m.x << " " << at_m.y << " " << at_m.z;
    }
    EXPECT_GT(inside, 100);
    EXPECT_LE(rim, 2);
  }
};

TEST_F(World, DicomAgreesWithItk) {
  expect_as_itk(open("ct_headphantom_dicom"), dicom_by_itk(shared_file("ct_headphantom_dicom")));

  DicomSeries series;
  series.right = normalized(Vec3{0.9, 0.3, -0.2});
  series.down = normalized(cross(Vec3{0.1, -0.4, 1}, series.right));
  series.step_mm = -3.0 * cross(series.right, series.down);
  for (int n = 0; n < 9; ++n)
    folder_.write("s" + std::to_string(n * 7 % 9), series.file(series.image(series.at_mm({0, 0, double(n)}), n)));
  expect_as_itk(read(folder_.path()), dicom_by_itk(folder_.path()));
}

TEST_F(World, NiftiAgreesWithItk) {
  std::vector<fs::path> files{shared_file("dti_brain/FA.nii.gz"), shared_file("mri_avg152_bigendian/avg152T1_RL_nifti.nii.gz")};
  for (const auto& entry : fs::directory_iterator(shared_file("nifti_orientations"))) files.push_back(entry.path());
  for (const fs::path& file : files) {
    if (file.extension() != ".gz") continue;
    SCOPED_TRACE(file.filename());
    expect_as_itk(read(file), nifti_by_itk(file));
  }
}

TEST_F(World, TwelveOrientationsAreOneBrainEverywhere) {
  std::vector<Volume> volumes;
  for (const auto& entry : fs::directory_iterator(shared_file("nifti_orientations"))) {
    if (entry.path().extension() == ".gz") volumes.push_back(read(entry.path()));
  }
  ASSERT_EQ(volumes.size(), 12U);
  int inside = 0;
  for (int n = 0; n < 1000; ++n) {
    const Vec3 at_m = point_in(volumes[0].bounds_m());
    const ScalarSample first = volumes[0].fields[0].field->scalar(at_m);
    inside += first.inside;
    for (const Volume& volume : volumes) {
      const ScalarSample sample = volume.fields[0].field->scalar(at_m);
      if (!first.inside || !sample.inside) continue;
      ASSERT_NEAR(sample.value, first.value, 1e-3);
    }
  }
  EXPECT_GT(inside, 900);
}

/// Agreement of diffusion directions with those one step along them in the world: mean of |cos| where diffusion is directed.
double coherence(const Field& directions, const Field& anisotropy, double step_m) {
  const GridGeometry& grid = grid_of(directions)->geometry;
  const Mat3 to_index = inverse(grid.index_to_world_m);
  double sum = 0;
  int count = 0;
  for (std::int64_t k = 3; k < grid.dims[2] - 3; k += 2) {
    for (std::int64_t j = 3; j < grid.dims[1] - 3; j += 2) {
      for (std::int64_t i = 3; i < grid.dims[0] - 3; i += 2) {
        const Vec3 at_m = grid.to_world({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
        const Vec3 here = directions.vector(at_m).value;
        if (anisotropy.scalar(at_m).value < 0.5 || norm(here) < 0.5) continue;
        // At a voxel: neighbours' signs may differ, which makes their blend meaningless.
        const Vec3 index = to_index * (at_m + step_m * here - grid.origin_m);
        const Vec3 there_m = grid.to_world({std::round(index.x), std::round(index.y), std::round(index.z)});
        sum += std::abs(dot(here, directions.vector(there_m).value));
        ++count;
      }
    }
  }
  return sum / count;
}

TEST_F(World, DirectionsAlongTheGridFollowTheTracts) {
  // FSL's directions are along the axes of the grid. Taken as RAS they are mirrored, and lead out of the tracts.
  VolumeRequest request;
  request.as = "vector";
  const Volume anisotropy = open("dti_brain/FA.nii.gz"), mirrored = open("dti_brain/V1.nii.gz", request);
  request.components_along = "index";
  const Volume volume = open("dti_brain/V1.nii.gz", request);
  const double right = coherence(*volume.fields[0].field, *anisotropy.fields[0].field, 6.6e-3);
  const double wrong = coherence(*mirrored.fields[0].field, *anisotropy.fields[0].field, 6.6e-3);
  RecordProperty("coherence_along_index", std::to_string(right));
  RecordProperty("coherence_along_file", std::to_string(wrong));
  EXPECT_NEAR(right, 0.68, 0.01);
  EXPECT_LT(wrong, 0.60);
}

TEST_F(World, LeftIsLeft) {
  // The left half of the head contains an L and the right half an R, the brightest voxels.
  const Volume volume = open("mri_avg152_bigendian/avg152T1_RL_nifti.nii.gz");
  const auto bright = [&](double x_mm, double y_mm) {
    return volume.fields[0].field->scalar(1e-3 * Vec3{x_mm, y_mm, 18}).value > 250;
  };
  EXPECT_TRUE(volume.medical_frame);
  EXPECT_TRUE(bright(62, 50)) << "the foot of the L, on the left: x of LPS rises to the left";
  EXPECT_FALSE(bright(-62, 50));
  EXPECT_TRUE(bright(-48, 38)) << "the stem of the R";
  EXPECT_FALSE(bright(48, 38));
}

}  // namespace world_test
}  // namespace palpa::test
