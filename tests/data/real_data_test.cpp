// Derived fields of measured and simulated flow, by the real palpa-read. Facts: shared/data/facts.json, computed with
// numpy.gradient.
#include <cstdlib>
#include <filesystem>

#include "palpa/data/derived.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/volume.h"
#include "palpa/file/read_volume.h"
#include "tests/data/test_fields.h"
#include "tests/shared_data.h"

namespace palpa {
namespace real_data_test {

namespace fs = std::filesystem;

class RealFlow : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* bin = std::getenv("PALPA_BIN");
    if (bin) options_.reader = fs::path(bin) / "palpa-read";
    data_ = test::shared_data();
    if (!fs::exists(options_.reader)) GTEST_SKIP() << "palpa-read is not built";
    if (!fs::exists(data_)) GTEST_SKIP() << "the shared data are not there; PALPA_SHARED names their folder";
  }

  FieldPtr field(const char* file, const char* name) const {
    const Volume volume = read_volume(data_ / file, options_);
    for (const VolumeField& f : volume.fields) {
      if (f.name == name) return f.field;
    }
    ADD_FAILURE() << file << " has no field " << name;
    return nullptr;
  }

  ReadOptions options_;
  fs::path data_;
};

/// Curl at a voxel, per step of the grid, in the file's axes (along which both grids lie).
Vec3 curl_per_step(const Field& curl, std::int64_t i, std::int64_t j, std::int64_t k) {
  const GridView& grid = *smooth_grid_of(curl);
  const auto* v = static_cast<const float*>(grid.voxels.data.get());
  const std::int64_t at = 3 * ((k * grid.geometry.dims[1] + j) * grid.geometry.dims[0] + i);
  return grid.scale * curl.spacing_m() * Vec3{v[at], v[at + 1], v[at + 2]};
}

struct Place {
  std::int64_t i, j, k;
  double size;  ///< per step
};
Place largest_interior(const Field& curl) {
  const auto& dims = smooth_grid_of(curl)->geometry.dims;
  Place found{0, 0, 0, -1.0};
  for (std::int64_t k = 1; k < dims[2] - 1; ++k)
    for (std::int64_t j = 1; j < dims[1] - 1; ++j)
      for (std::int64_t i = 1; i < dims[0] - 1; ++i) {
        const double size = norm(curl_per_step(curl, i, j, k));
        if (size > found.size) found = {i, j, k, size};
      }
  return found;
}

TEST_F(RealFlow, curl_at_the_voxels_is_that_of_another_tool) {
  const FieldPtr wing = field("cfd_wing/wing.vti", "velocity");
  ASSERT_TRUE(wing);
  const FieldPtr wing_curl = derived(Derivation::curl, wing);
  const Place at_wing = largest_interior(*wing_curl);
  EXPECT_EQ(at_wing.i, 9);
  EXPECT_EQ(at_wing.j, 59);
  EXPECT_EQ(at_wing.k, 13);
  EXPECT_NEAR(at_wing.size, 0.03 * 32.3876826, 1e-5);  // the facts are per metre, steps of 0.03
  const FieldPtr carotid = field("mri_flow_carotid/carotid.vtk", "vectors");
  ASSERT_TRUE(carotid);
  const FieldPtr carotid_curl = derived(Derivation::curl, carotid);
  const Place at_carotid = largest_interior(*carotid_curl);
  EXPECT_EQ(at_carotid.i, 44);
  EXPECT_EQ(at_carotid.j, 22);
  EXPECT_EQ(at_carotid.k, 27);
  EXPECT_NEAR(at_carotid.size, 17.5397586, 1e-4);  // steps of 1
  const Vec3 vector = curl_per_step(*carotid_curl, 44, 22, 27);
  EXPECT_NEAR(norm(vector - Vec3{-4.78187858, 1.65910449, 16.7935744}), 0.0, 1e-4);
}

TEST_F(RealFlow, q_is_finite_and_highest_in_the_vortices) {
  const FieldPtr wing = field("cfd_wing/wing.vti", "velocity");
  ASSERT_TRUE(wing);
  const FieldPtr q = derived(Derivation::q, wing);
  const GridGeometry& g = smooth_grid_of(*q)->geometry;
  EXPECT_EQ(smooth_grid_of(*q)->valid_share, 1.0);
  // Behind the wing (chord and span end at x = 1, y = ±1.5) Q is highest in the two tip vortices, once on each side.
  const std::int64_t behind = (g.dims[0] * 3) / 5;
  struct {
    double value = -1.0, y = 0.0;
  } left, right;
  for (std::int64_t k = 0; k < g.dims[2]; ++k)
    for (std::int64_t j = 0; j < g.dims[1]; ++j) {
      const ScalarSample s = q->scalar(g.to_world({double(behind), double(j), double(k)}));
      ASSERT_TRUE(s.inside && std::isfinite(s.value) && is_finite(s.gradient));
      auto& side = j < g.dims[1] / 2 ? left : right;
      if (s.value > side.value) side = {s.value, -1.8 + 0.03 * double(j)};
    }
  EXPECT_GT(left.value, 0.0);
  EXPECT_NEAR(right.value, left.value, 0.2 * left.value);
  EXPECT_NEAR(left.y, -1.5, 0.2);
  EXPECT_NEAR(right.y, 1.5, 0.2);

  const FieldPtr carotid = field("mri_flow_carotid/carotid.vtk", "vectors");
  ASSERT_TRUE(carotid);
  for (const Derivation d : {Derivation::q, Derivation::lambda2, Derivation::divergence}) {
    const FieldPtr of_blood = derived(d, carotid);
    EXPECT_EQ(smooth_grid_of(*of_blood)->valid_share, 1.0);
    const ValueRange range = of_blood->value_ranges()[0];
    EXPECT_TRUE(range.min < 0.0 && range.max > 0.0) << name_of(d);
  }
}

}  // namespace real_data_test
}  // namespace palpa
