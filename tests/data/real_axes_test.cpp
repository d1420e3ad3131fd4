// Main direction of diffusion in a measured brain, independent of the file's signs.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "palpa/data/axis_grid.h"
#include "palpa/data/derived.h"
#include "palpa/data/filter.h"
#include "palpa/file/read_volume.h"
#include "tests/data/test_fields.h"
#include "tests/shared_data.h"

namespace palpa {
namespace real_axes_test {

namespace fs = std::filesystem;

class RealAxes : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* bin = std::getenv("PALPA_BIN");
    ReadOptions options;
    if (bin) options.reader = fs::path(bin) / "palpa-read";
    const fs::path folder = test::shared_data("dti_brain");
    if (!fs::exists(options.reader)) GTEST_SKIP() << "palpa-read is not built";
    if (!fs::exists(folder)) GTEST_SKIP() << "the shared data are not there; PALPA_SHARED names their folder";
    VolumeRequest request;
    request.files = {folder / "V1.nii.gz"};
    request.as = "vector";
    v1_ = read_volume(request, options).fields[0].field;
    fa_ = read_volume(folder / "FA.nii.gz", options).fields[0].field;
  }
  FieldPtr v1_, fa_;
};

TEST_F(RealAxes, flipping_signs_changes_no_bit_and_directions_are_those_of_the_voxels_around) {
  std::mt19937 random(1);
  const GridView& grid = *grid_behind(*v1_);
  ASSERT_EQ(grid.voxels.type, VoxelType::float32);
  const auto* voxels = static_cast<const float*>(grid.voxels.data.get());
  std::vector<float> flipped(voxels, voxels + 3 * grid.geometry.voxels());
  for (std::size_t v = 0; v < flipped.size(); v += 3) {
    if (random() & 1) continue;
    for (std::size_t c = v; c < v + 3; ++c) flipped[c] = -flipped[c];
  }
  const FieldPtr turned = grid_field(grid.geometry, test::voxels_of(flipped, 3), grid.scale, grid.offset);
  const auto& dims = grid.geometry.dims;
  for (const Filter filter : {Filter::trilinear, Filter::smooth}) {
    const FieldPtr axes = filtered(signless(v1_), filter), others = filtered(signless(turned), filter);
    const FieldPtr worth = derived(Derivation::magnitude, axes);
    std::vector<double> angles_deg, sure_deg;
    while (angles_deg.size() < 20000) {
      const Vec3 p{test::uniform(random, 0, double(dims[0] - 1)), test::uniform(random, 0, double(dims[1] - 1)),
                   test::uniform(random, 0, double(dims[2] - 1))};
      const Vec3 x = grid.geometry.to_world({p.x, p.y, p.z});
      const ScalarSample fa = fa_->scalar(x);
      if (!fa.inside || fa.value < 0.3) continue;
      const VectorSample a = axes->vector(x), b = others->vector(x);
      ASSERT_EQ(a.inside, b.inside);
      ASSERT_EQ(a.value, b.value);
      ASSERT_EQ(a.jacobian, b.jacobian);
      EXPECT_LE(worth->scalar(x).value, 1.0 + 1e-5);
      const std::int64_t nearest = (std::llround(p.z) * dims[1] + std::llround(p.y)) * dims[0] + std::llround(p.x);
      // The file's components, as the field returns them at the voxel.
      const Vec3 there = grid.scale * Vec3{voxels[3 * nearest], voxels[3 * nearest + 1], voxels[3 * nearest + 2]};
      const double angle_deg =
          std::acos(std::min(1.0, std::abs(dot(normalized(a.value), normalized(there))))) * 180.0 / std::numbers::pi;
      angles_deg.push_back(angle_deg);
      if (norm(a.value) > 0.8) sure_deg.push_back(angle_deg);
    }
    std::sort(angles_deg.begin(), angles_deg.end());
    std::sort(sure_deg.begin(), sure_deg.end());
    ASSERT_GT(sure_deg.size(), 1000U);
    const double median_deg = angles_deg[angles_deg.size() / 2];
    // Half of random directions would be beyond 60°.
    EXPECT_LT(median_deg, 15.0);
    EXPECT_LT(sure_deg[sure_deg.size() * 99 / 100], 30.0);
    RecordProperty(std::string(name_of(filter)) + "_median_deg", std::to_string(median_deg));
    RecordProperty(std::string(name_of(filter)) + "_sure_p99_deg", std::to_string(sure_deg[sure_deg.size() * 99 / 100]));
  }
}

}  // namespace real_axes_test
}  // namespace palpa
