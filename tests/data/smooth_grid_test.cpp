#include "palpa/data/smooth_grid.h"

#include <cmath>
#include <functional>
#include <stdexcept>

#include "tests/data/test_fields.h"

namespace palpa {
namespace smooth_grid_test {

using namespace test;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// The cubic B-spline, by its definition.
double spline(double x) {
  const double a = std::abs(x);
  if (a >= 2.0) return 0.0;
  return a >= 1.0 ? std::pow(2.0 - a, 3) / 6.0 : 2.0 / 3.0 - a * a * (1.0 - 0.5 * a);
}

/// Σ c β β β over all of the grid and three rows of repeated edges around it.
double reference(const GridGeometry& g, const std::function<double(std::int64_t)>& coefficient, const Vec3& index) {
  double sum = 0.0;
  const auto at = [](std::int64_t i, std::int64_t n) { return std::clamp<std::int64_t>(i, 0, n - 1); };
  for (std::int64_t k = -3; k < g.dims[2] + 3; ++k)
    for (std::int64_t j = -3; j < g.dims[1] + 3; ++j)
      for (std::int64_t i = -3; i < g.dims[0] + 3; ++i) {
        const double w = spline(index.x - double(i)) * spline(index.y - double(j)) * spline(index.z - double(k));
        if (w == 0.0) continue;
        sum += w * coefficient((at(k, g.dims[2]) * g.dims[1] + at(j, g.dims[1])) * g.dims[0] + at(i, g.dims[0]));
      }
  return sum;
}

const GridGeometry sheared{
    {7, 6, 5}, {{{0.011, 0.002, -0.001}, {-0.003, 0.009, 0.002}, {0.001, 0.001, -0.014}}}, {0.3, -0.2, 0.1}};

Vec3 random_index(std::mt19937& random, const GridGeometry& g, double margin = 0.0) {
  return {uniform(random, margin, double(g.dims[0] - 1) - margin), uniform(random, margin, double(g.dims[1] - 1) - margin),
          uniform(random, margin, double(g.dims[2] - 1) - margin)};
}
Vec3 world_of(const GridGeometry& g, const Vec3& index) { return g.to_world({index.x, index.y, index.z}); }

/// Voxels by a function of the world position.
FieldPtr smooth_of(const GridGeometry& g, const std::function<double(const Vec3&)>& value) {
  std::vector<double> values;
  for (std::int64_t k = 0; k < g.dims[2]; ++k)
    for (std::int64_t j = 0; j < g.dims[1]; ++j)
      for (std::int64_t i = 0; i < g.dims[0]; ++i) values.push_back(value(g.to_world({double(i), double(j), double(k)})));
  return smooth_grid_field(g, voxels_of(std::move(values)));
}

template <class T>
class SmoothGridOf : public ::testing::Test {};
using Types = ::testing::Types<std::uint8_t, std::int16_t, std::uint16_t, std::int32_t, float, double>;
TYPED_TEST_SUITE(SmoothGridOf, Types);

TYPED_TEST(SmoothGridOf, is_the_sum_of_splines_with_scale_and_offset) {
  std::mt19937 random(1);
  for (const int components : {1, 3}) {
    std::vector<TypeParam> values;
    for (std::int64_t n = 0; n < components * sheared.voxels(); ++n)
      values.push_back(static_cast<TypeParam>(uniform(random, 0, 250)));
    const auto kept = values;
    const FieldPtr field = smooth_grid_field(sheared, voxels_of(std::move(values), components), -0.5, 20.0);
    EXPECT_EQ(field->components(), components);
    EXPECT_EQ(smooth_grid_of(*field)->voxels.type, VoxelTypeOf<TypeParam>::value);
    EXPECT_EQ(grid_of(*field), nullptr);
    for (int n = 0; n < 200; ++n) {
      const Vec3 index = random_index(random, sheared), x = world_of(sheared, index);
      double found[3];
      for (int c = 0; c < components; ++c) {
        found[c] = reference(
            sheared, [&](std::int64_t v) { return -0.5 * double(kept[components * v + c]) + 20.0; }, index);
      }
      if (components == 1) {
        ASSERT_TRUE(field->scalar(x).inside);
        EXPECT_NEAR(field->scalar(x).value, found[0], 1e-10);
        EXPECT_FALSE(field->vector(x).inside);
      } else {
        ASSERT_TRUE(field->vector(x).inside);
        EXPECT_LT(norm(field->vector(x).value - Vec3{found[0], found[1], found[2]}), 1e-10);
        EXPECT_FALSE(field->scalar(x).inside);
        EXPECT_EQ(field->hessian(x), Mat3{});
      }
    }
  }
}

TEST(SmoothGrid, derivatives_are_those_of_the_value) {
  std::mt19937 random(2);
  std::vector<double> values, vectors;
  for (std::int64_t n = 0; n < sheared.voxels(); ++n) values.push_back(uniform(random, -1, 1));
  for (std::int64_t n = 0; n < 3 * sheared.voxels(); ++n) vectors.push_back(uniform(random, -1, 1));
  const FieldPtr field = smooth_grid_field(sheared, voxels_of(std::move(values)));
  const FieldPtr flow = smooth_grid_field(sheared, voxels_of(std::move(vectors), 3));
  constexpr double h = 1e-6;
  for (int n = 0; n < 500; ++n) {
    const Vec3 x = world_of(sheared, random_index(random, sheared, 0.01));
    EXPECT_LT(norm(field->scalar(x).gradient - numeric_gradient(*field, x, h)), 1e-6);
    EXPECT_LT(largest_difference(flow->vector(x).jacobian, numeric_jacobian(*flow, x, h)), 1e-6);
    const Mat3 hessian = field->hessian(x);
    for (int a = 0; a < 3; ++a) {
      const Vec3 slope = (field->scalar(x + h * axis(a)).gradient - field->scalar(x - h * axis(a)).gradient) / (2.0 * h);
      EXPECT_LT(norm(hessian.row[a] - slope), 1.0);  // of 1e4; the third derivative jumps at cell faces
    }
    EXPECT_LT(largest_difference(hessian, transposed(hessian)), 1e-9);
  }
}

TEST(SmoothGrid, hessian_is_continuous_across_cells) {
  std::mt19937 random(3);
  std::vector<double> values;
  for (std::int64_t n = 0; n < sheared.voxels(); ++n) values.push_back(uniform(random, -1, 1));
  const FieldPtr field = smooth_grid_field(sheared, voxels_of(std::move(values)));
  for (int n = 0; n < 300; ++n) {
    Vec3 index = random_index(random, sheared, 1.0);
    index.x = std::round(index.x);
    const double before = 1e-9;
    const Mat3 a = field->hessian(world_of(sheared, index - Vec3{before, 0, 0}));
    const Mat3 b = field->hessian(world_of(sheared, index + Vec3{before, 0, 0}));
    EXPECT_LT(largest_difference(a, b), 1e-4);
  }
}

TEST(SmoothGrid, a_linear_field_stays_and_a_quadratic_rises_by_its_curvature_over_six) {
  std::mt19937 random(4);
  const Vec3 slope{3, -2, 5};
  const FieldPtr linear = smooth_of(sheared, [&](const Vec3& x) { return dot(slope, x) + 7.0; });
  const Mat3 a{{{2, 0.5, -1}, {0.5, -3, 0.25}, {-1, 0.25, 4}}};
  const FieldPtr quadratic = smooth_of(sheared, [&](const Vec3& x) { return 0.5 * dot(x, a * x); });
  double rise = 0.0;  // Σ over the axes of the grid: second derivative along a step, over six
  for (const Vec3& step : transposed(sheared.index_to_world_m).row) rise += dot(step, a * step) / 6.0;
  for (int n = 0; n < 500; ++n) {
    const Vec3 x = world_of(sheared, random_index(random, sheared, 1.0));
    EXPECT_NEAR(linear->scalar(x).value, dot(slope, x) + 7.0, 1e-13);
    EXPECT_LT(norm(linear->scalar(x).gradient - slope), 1e-11);
    EXPECT_LT(largest_difference(linear->hessian(x), {}), 1e-8);
    EXPECT_NEAR(quadratic->scalar(x).value, 0.5 * dot(x, a * x) + rise, 1e-13);
    EXPECT_LT(norm(quadratic->scalar(x).gradient - a * x), 1e-11);
    EXPECT_LT(largest_difference(quadratic->hessian(x), a), 1e-8);
  }
}

TEST(SmoothGrid, has_data_where_a_trilinear_grid_has) {
  std::mt19937 random(5);
  const auto one = [](const Vec3&) { return 4.0; };
  for (const std::array<std::int64_t, 3> dims :
       {std::array<std::int64_t, 3>{7, 6, 5}, {1, 4, 3}, {2, 1, 1}, {1, 1, 1}, {2, 2, 2}, {3, 1, 2}}) {
    const GridGeometry g{dims, sheared.index_to_world_m, sheared.origin_m};
    const FieldPtr smooth = smooth_of(g, one);
    const FieldPtr plain = grid_field(g, voxels_of(std::vector<double>(static_cast<std::size_t>(g.voxels()), 4.0)));
    EXPECT_EQ(smooth->bounds_m().low_m, plain->bounds_m().low_m);
    EXPECT_EQ(smooth->bounds_m().high_m, plain->bounds_m().high_m);
    EXPECT_EQ(smooth->spacing_m(), plain->spacing_m());
    const Box around{plain->bounds_m().low_m - Vec3{0.01, 0.01, 0.01}, plain->bounds_m().high_m + Vec3{0.01, 0.01, 0.01}};
    for (int n = 0; n < 3000; ++n) {
      const Vec3 x = within(random, around);
      const ScalarSample s = smooth->scalar(x);
      ASSERT_EQ(s.inside, plain->scalar(x).inside);
      EXPECT_EQ(smooth->depth_m(x), plain->depth_m(x));
      if (!s.inside) {
        expect_outside_and_finite(*smooth, x);
        EXPECT_EQ(smooth->hessian(x), Mat3{});
        continue;
      }
      EXPECT_NEAR(s.value, 4.0, 1e-14);
      EXPECT_LT(norm(s.gradient), 1e-11);
      EXPECT_LT(largest_difference(smooth->hessian(x), {}), 1e-8);
    }
    for (const Vec3& at : absurd_positions()) expect_outside_and_finite(*smooth, at);
  }
}

TEST(SmoothGrid, is_outside_where_one_of_64_coefficients_is_not_finite) {
  std::mt19937 random(6);
  const GridGeometry g{{9, 8, 7}, Mat3::identity(), {}};
  for (const double bad : {nan, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()}) {
    for (const int components : {1, 3}) {
      std::vector<double> values(static_cast<std::size_t>(components * g.voxels()), 1.0);
      values[static_cast<std::size_t>(components * ((3 * 8 + 4) * 9 + 5))] = bad;
      const FieldPtr field = smooth_grid_field(g, voxels_of(std::move(values), components));
      EXPECT_EQ(field->value_ranges()[0].max, 1.0);
      for (int n = 0; n < 5000; ++n) {
        const Vec3 x = random_index(random, g);
        const auto far = [](double at, double voxel) { return std::floor(at) + 2.0 < voxel || std::floor(at) - 1.0 > voxel; };
        const bool free = far(x.x, 5) || far(x.y, 4) || far(x.z, 3);
        const bool inside = components == 1 ? field->scalar(x).inside : field->vector(x).inside;
        ASSERT_EQ(inside, free) << x.x << ' ' << x.y << ' ' << x.z;
        EXPECT_TRUE(is_finite(field->hessian(x)));
        EXPECT_TRUE(free || field->hessian(x) == Mat3{});
      }
    }
  }
}

TEST(SmoothGrid, range_holds_every_value) {
  std::mt19937 random(7);
  std::vector<std::int16_t> values;
  for (std::int64_t n = 0; n < sheared.voxels(); ++n)
    values.push_back(static_cast<std::int16_t>(uniform(random, -30000, 30000)));
  const FieldPtr field = smooth_grid_field(sheared, voxels_of(std::move(values)), -2.0, 5.0);
  const ValueRange range = field->value_ranges()[0];
  for (int n = 0; n < 5000; ++n) {
    const double value = field->scalar(world_of(sheared, random_index(random, sheared))).value;
    EXPECT_GE(value, range.min);
    EXPECT_LE(value, range.max);
  }
}

TEST(SmoothGrid, finds_the_direction_to_a_ball_of_eight_bit_voxels_more_truly_than_a_trilinear_field) {
  std::mt19937 random(8);
  const GridGeometry g{{41, 41, 41}, 1e-3 * Mat3::identity(), {-0.02, -0.02, -0.02}};
  std::vector<std::uint8_t> values;
  for (int k = 0; k < 41; ++k)
    for (int j = 0; j < 41; ++j)
      for (int i = 0; i < 41; ++i) {
        const double depth_m = 0.012 - norm(g.to_world({double(i), double(j), double(k)}));
        values.push_back(static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(0.5 + depth_m / 6e-3, 0.0, 1.0))));
      }
  const Voxels voxels = voxels_of(std::move(values));
  const FieldPtr smooth = smooth_grid_field(g, voxels), plain = grid_field(g, voxels);
  std::vector<double> of_smooth, of_plain;
  for (int n = 0; n < 20000; ++n) {
    const Vec3 way = normalized({uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)});
    const auto angle = [&](const Field& f) { return norm(normalized(f.scalar(0.012 * way).gradient) + way); };
    of_smooth.push_back(angle(*smooth));
    of_plain.push_back(angle(*plain));
  }
  std::sort(of_smooth.begin(), of_smooth.end());
  std::sort(of_plain.begin(), of_plain.end());
  EXPECT_LT(of_smooth[19800], 0.5 * of_plain[19800]);
}

TEST(SmoothGrid, refuses_what_is_no_grid) {
  const GridGeometry g{{2, 2, 2}, Mat3::identity(), {}};
  const Voxels voxels = voxels_of(std::vector<float>(8));
  EXPECT_THROW(smooth_grid_field({{0, 2, 2}, Mat3::identity(), {}}, voxels), std::invalid_argument);
  EXPECT_THROW(smooth_grid_field(g, {VoxelType::float32, 1, nullptr}), std::invalid_argument);
  EXPECT_THROW(smooth_grid_field(g, {VoxelType::float32, 2, voxels.data}), std::invalid_argument);
  EXPECT_THROW(smooth_grid_field(g, voxels, nan), std::invalid_argument);
  EXPECT_THROW(smooth_grid_field(g, voxels, 1.0, nan), std::invalid_argument);
}

}  // namespace smooth_grid_test
}  // namespace palpa
