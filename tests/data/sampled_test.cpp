#include "palpa/data/sampled.h"

#include <stdexcept>

#include "palpa/data/analytic.h"
#include "palpa/data/volume.h"
#include "tests/data/test_fields.h"

namespace palpa {
namespace sampled_test {

using namespace test;

TEST(Sampled, has_the_formula_at_every_sample) {
  for (const Volume& volume : {head_phantom(), sphere_field(), burgers_vortex()}) {
    const Volume grid = sampled(volume, 24);
    EXPECT_EQ(grid.format, "grid");
    EXPECT_EQ(grid.medical_frame, volume.medical_frame);
    ASSERT_EQ(grid.fields.size(), 1u);
    EXPECT_EQ(grid.fields[0].name, volume.fields[0].name);
    EXPECT_EQ(grid.fields[0].unit, volume.fields[0].unit);
    const Field& formula = *volume.fields[0].field;
    const Field& field = *grid.fields[0].field;
    const GridView* view = grid_of(field);
    ASSERT_NE(view, nullptr);
    EXPECT_EQ(view->voxels.type, VoxelType::float32);
    EXPECT_EQ(*std::max_element(view->geometry.dims.begin(), view->geometry.dims.end()), 24);
    EXPECT_EQ(view->valid_share, 1.0);  // the faces of the box belong to it
    const auto [di, dj, dk] = view->geometry.dims;
    const double size = std::abs(formula.value_ranges()[0].max) + std::abs(formula.value_ranges()[0].min);
    for (std::int64_t k = 0; k < dk; ++k) {
      for (std::int64_t j = 0; j < dj; ++j) {
        for (std::int64_t i = 0; i < di; ++i) {
          // The sample's position, pulled in by more than rounding, where the formula has data.
          const Vec3 at = view->geometry.to_world({double(i), double(j), double(k)});
          const Vec3 centre = formula.bounds_m().centre_m();
          const Vec3 in = centre + (1.0 - 1e-12) * (at - centre);
          if (formula.components() == 1) {
            ASSERT_NEAR(field.scalar(at).value, formula.scalar(in).value, 1e-6 * size);
          } else {
            ASSERT_LT(largest_component(field.vector(at).value - formula.vector(in).value), 1e-6 * size);
          }
        }
      }
    }
  }
}

TEST(Sampled, spans_the_box_with_nearly_cubic_voxels) {
  const FieldPtr head = head_phantom().fields[0].field;
  const FieldPtr grid = sampled(*head, 100);
  EXPECT_LT(largest_component(grid->bounds_m().low_m - head->bounds_m().low_m), 1e-12);
  EXPECT_LT(largest_component(grid->bounds_m().high_m - head->bounds_m().high_m), 1e-12);
  const Mat3& affine = grid_of(*grid)->geometry.index_to_world_m;
  const double longest = head->bounds_m().size_m().z / 99;
  for (const double step : {affine.row[0].x, affine.row[1].y, affine.row[2].z}) EXPECT_NEAR(step, longest, 0.01 * longest);
}

TEST(Sampled, is_outside_where_the_field_has_no_data) {
  std::mt19937 random(2);
  const FieldPtr turned = posed(sphere_field().fields[0].field, {.rotation = rotation(random)});
  const FieldPtr grid = sampled(*turned, 40);
  EXPECT_LT(grid_of(*grid)->valid_share, 0.9);
  int inside = 0;
  for (int n = 0; n < 5000; ++n) {
    const Vec3 at = within(random, grid->bounds_m());
    if (!grid->scalar(at).inside) continue;
    ++inside;
    ASSERT_TRUE(turned->scalar(at).inside);
  }
  EXPECT_GT(inside, 1000);
}

TEST(Sampled, of_a_scaled_world_has_the_same_bits) {
  const FieldPtr head = head_phantom().fields[0].field;
  const double factor = std::ldexp(1.0, -30);
  const FieldPtr small = sampled(*posed(head, {.scale = factor}), 30);
  const FieldPtr large = sampled(*head, 30);
  ASSERT_EQ(grid_of(*small)->geometry.dims, grid_of(*large)->geometry.dims);
  std::mt19937 random(3);
  for (int n = 0; n < 2000; ++n) {
    const Vec3 at = within(random, large->bounds_m());
    const ScalarSample a = large->scalar(at), b = small->scalar(factor * at);
    ASSERT_EQ(a.inside, b.inside);
    ASSERT_EQ(a.value, b.value);
    ASSERT_EQ(a.gradient, factor * b.gradient);
  }
}

TEST(Sampled, a_value_beyond_a_float_is_outside) {
  const FieldPtr huge = grid_field({{2, 2, 2}, Mat3::identity(), {}}, voxels_of(std::vector<double>(8, 1e200)));
  const FieldPtr grid = sampled(*huge, 4);
  EXPECT_EQ(grid_of(*grid)->valid_share, 0.0);
  expect_outside_and_finite(*grid, {2, 0.5, 0.5});
  EXPECT_FALSE(grid->scalar({0.5, 0.5, 0.5}).inside);
}

TEST(Sampled, refuses_a_number_of_samples_that_makes_no_grid) {
  const FieldPtr ball = sphere_field().fields[0].field;
  for (const int longest : {-1, 0, 1, 1025, 1 << 30}) EXPECT_THROW(sampled(*ball, longest), std::invalid_argument);
  EXPECT_EQ(grid_of(*sampled(*ball, 2))->geometry.voxels(), 8);
}

}  // namespace sampled_test
}  // namespace palpa
