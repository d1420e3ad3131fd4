#include "palpa/data/grid.h"

#include <limits>
#include <stdexcept>

#include "palpa/data/analytic.h"
#include "palpa/data/row_samples.h"
#include "palpa/data/timed_field.h"
#include "tests/data/test_fields.h"

namespace palpa {
namespace grid_test {

using namespace test;

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Affines of every kind: straight, oblique, sheared (a tilted gantry), mirrored, all combined.
std::vector<Mat3> affines() {
  std::mt19937 random(7);
  const Mat3 steps{{{0.8e-3, 0, 0}, {0, 1.1e-3, 0}, {0, 0, 2.5e-3}}};
  const Mat3 sheared{{{0.8e-3, 0, 0.3e-3}, {0, 1.1e-3, -0.9e-3}, {0, 0, 2.5e-3}}};
  const Mat3 mirrored{{{-0.8e-3, 0, 0}, {0, 1.1e-3, 0}, {0, 0, 2.5e-3}}};
  const Mat3 swapped{{{0, 0, 2.5e-3}, {-0.8e-3, 0, 0}, {0, 1.1e-3, 0}}};
  return {steps,   rotation(random) * steps,
          sheared, mirrored,
          swapped, rotation(random) * sheared * mirrored * Mat3{{{1e3, 0, 0}, {0, 1e3, 0}, {0, 0, 1e3}}}};
}

GridGeometry small_grid(const Mat3& index_to_world_m) { return {{4, 5, 3}, index_to_world_m, {0.12, -0.34, 0.05}}; }

/// A trilinear function of the index that fits every voxel type, and its derivative by the index.
double trilinear(double i, double j, double k) { return 1 + 2 * i + 3 * j + 5 * k + i * j + 2 * j * k + i * k + i * j * k; }
Vec3 trilinear_slopes(double i, double j, double k) {
  return {2 + j + k + j * k, 3 + i + 2 * k + i * k, 5 + 2 * j + i + i * j};
}

template <class T>
class EveryVoxelType : public testing::Test {};
using VoxelTypes = testing::Types<std::uint8_t, std::int16_t, std::uint16_t, std::int32_t, float, double>;
TYPED_TEST_SUITE(EveryVoxelType, VoxelTypes);

TYPED_TEST(EveryVoxelType, is_exact_on_trilinear_functions_whatever_the_affine) {
  std::mt19937 random(1);
  for (const Mat3& affine : affines()) {
    const GridGeometry geometry = small_grid(affine);
    std::vector<TypeParam> scalars, vectors;
    for (int k = 0; k < 3; ++k) {
      for (int j = 0; j < 5; ++j) {
        for (int i = 0; i < 4; ++i) {
          const auto v = static_cast<TypeParam>(trilinear(i, j, k));
          scalars.push_back(v);
          vectors.insert(vectors.end(), {v, static_cast<TypeParam>(100 - v), static_cast<TypeParam>(i)});
        }
      }
    }
    const double scale = -2.5, offset = 17.0;
    const FieldPtr scalar = grid_field(geometry, voxels_of(scalars), scale, offset);
    const FieldPtr vector = grid_field(geometry, voxels_of(vectors, 3), scale, offset);
    EXPECT_EQ(scalar->components(), 1);
    EXPECT_EQ(vector->components(), 3);
    for (int n = 0; n < 300; ++n) {
      const GridPoint p{uniform(random, 0, 3), uniform(random, 0, 4), uniform(random, 0, 2)};
      const Vec3 at = geometry.to_world(p);
      const double value = trilinear(p.i, p.j, p.k);
      const Vec3 slopes = trilinear_slopes(p.i, p.j, p.k);

      const ScalarSample s = scalar->scalar(at);
      ASSERT_TRUE(s.inside);
      EXPECT_NEAR(s.value, scale * value + offset, 1e-9);
      // The gradient along an index step is the change per step, without an inverse.
      EXPECT_LT(largest_component(transposed_times(affine, s.gradient) - scale * slopes), 1e-8);

      const VectorSample v = vector->vector(at);
      ASSERT_TRUE(v.inside);
      EXPECT_LT(largest_component(v.value - Vec3{scale * value + offset, scale * (100 - value) + offset, scale * p.i + offset}),
                1e-9);
      const Mat3 per_step = v.jacobian * affine;
      EXPECT_LT(largest_difference(per_step, scale * Mat3{{slopes, -slopes, {1, 0, 0}}}), 1e-8);

      EXPECT_FALSE(scalar->vector(at).inside);
      EXPECT_FALSE(vector->scalar(at).inside);
    }
  }
}

TYPED_TEST(EveryVoxelType, states_the_range_of_its_values) {
  std::vector<TypeParam> values(60, static_cast<TypeParam>(7));
  values[13] = static_cast<TypeParam>(3);
  values[59] = static_cast<TypeParam>(111);
  const FieldPtr field = grid_field(small_grid(affines()[0]), voxels_of(values), -2.0, 1.0);
  ASSERT_EQ(field->value_ranges().size(), 1u);
  EXPECT_EQ(field->value_ranges()[0].min, -221.0);
  EXPECT_EQ(field->value_ranges()[0].max, -5.0);
  EXPECT_EQ(grid_of(*field)->valid_share, 1.0);
  EXPECT_EQ(size_of(VoxelTypeOf<TypeParam>::value), sizeof(TypeParam));
  EXPECT_EQ(grid_of(*field)->voxels.type, VoxelTypeOf<TypeParam>::value);
}

TYPED_TEST(EveryVoxelType, holds_the_extremes_of_its_type) {
  using Limits = std::numeric_limits<TypeParam>;
  std::vector<TypeParam> values(60, TypeParam{1});
  values[0] = Limits::lowest();
  values[59] = Limits::max();
  const FieldPtr field = grid_field(small_grid(affines()[0]), voxels_of(values));
  EXPECT_EQ(field->value_ranges()[0].min, static_cast<double>(Limits::lowest()));
  EXPECT_EQ(field->value_ranges()[0].max, static_cast<double>(Limits::max()));
}

FieldPtr random_grid(std::mt19937& random, const GridGeometry& geometry, int components = 1) {
  std::vector<float> values(geometry.voxels() * components);
  for (float& v : values) v = static_cast<float>(uniform(random, -1, 1));
  return grid_field(geometry, voxels_of(values, components));
}

TEST(Grid, derivative_is_that_of_the_interpolant_within_a_cell) {
  std::mt19937 random(3);
  for (const Mat3& affine : affines()) {
    const GridGeometry geometry = small_grid(affine);
    const FieldPtr scalar = random_grid(random, geometry);
    const FieldPtr vector = random_grid(random, geometry, 3);
    const double h = 1e-3 * scalar->spacing_m();
    for (int n = 0; n < 200; ++n) {
      const auto inner = [&](int cells) { return std::floor(uniform(random, 0, cells)) + uniform(random, 0.1, 0.9); };
      const Vec3 at = geometry.to_world({inner(3), inner(4), inner(2)});
      const double scale = 1.0 / scalar->spacing_m();
      EXPECT_LT(largest_component(scalar->scalar(at).gradient - numeric_gradient(*scalar, at, h)), 1e-9 * scale);
      EXPECT_LT(largest_difference(vector->vector(at).jacobian, numeric_jacobian(*vector, at, h)), 1e-9 * scale);
    }
  }
}

TEST(Grid, value_is_continuous_across_cell_faces) {
  std::mt19937 random(4);
  const GridGeometry geometry = small_grid(affines().back());
  const FieldPtr field = random_grid(random, geometry);
  for (int n = 0; n < 100; ++n) {
    const double j = uniform(random, 0, 4), k = uniform(random, 0, 2);
    const double before = field->scalar(geometry.to_world({1.0 - 1e-9, j, k})).value;
    const double after = field->scalar(geometry.to_world({1.0 + 1e-9, j, k})).value;
    EXPECT_NEAR(before, after, 1e-8);
  }
}

/// Root mean square errors of value and derivative of a grid against its formula.
struct Errors {
  double value = 0.0;
  double derivative = 0.0;
};
Errors errors_of(const Field& grid, const Field& truth, const Box& box) {
  std::mt19937 random(5);
  Errors sum;
  constexpr int count = 20000;
  for (int n = 0; n < count; ++n) {
    const Vec3 at = within(random, box);
    if (truth.components() == 1) {
      const ScalarSample a = grid.scalar(at), b = truth.scalar(at);
      sum.value += std::pow(a.value - b.value, 2);
      sum.derivative += norm_squared(a.gradient - b.gradient);
    } else {
      const VectorSample a = grid.vector(at), b = truth.vector(at);
      sum.value += norm_squared(a.value - b.value);
      for (int i = 0; i < 3; ++i) sum.derivative += norm_squared(a.jacobian.row[i] - b.jacobian.row[i]);
    }
  }
  return {std::sqrt(sum.value / count), std::sqrt(sum.derivative / count)};
}

TEST(Grid, halving_the_spacing_quarters_the_error_of_the_value_and_halves_that_of_the_derivative) {
  const FieldPtr vortex = burgers_vortex().fields[0].field;
  const FieldPtr ball = sphere_field().fields[0].field;
  const Box near_surface{{0.02, 0.02, 0.02}, {0.04, 0.04, 0.04}};  // away from the ball's centre, a true cone
  const struct {
    const Field& truth;
    Box box;
  } cases[] = {{*vortex, vortex->bounds_m()}, {*ball, near_surface}};
  for (const auto& c : cases) {
    const Errors coarse = errors_of(*grid_of_doubles(c.truth, 49), c.truth, c.box);
    const Errors fine = errors_of(*grid_of_doubles(c.truth, 97), c.truth, c.box);
    EXPECT_NEAR(coarse.value / fine.value, 4.0, 0.3);
    EXPECT_NEAR(coarse.derivative / fine.derivative, 2.0, 0.15);
  }
}

TEST(Grid, has_data_from_the_first_to_the_last_voxel_centre) {
  std::mt19937 random(6);
  for (const Mat3& affine : affines()) {
    const GridGeometry geometry = small_grid(affine);
    const FieldPtr field = random_grid(random, geometry);
    const double last[3] = {3, 4, 2};
    for (int corner = 0; corner < 8; ++corner) {
      const auto at = [&](int a, double out) { return corner >> a & 1 ? last[a] + out : -out; };
      EXPECT_TRUE(field->scalar(geometry.to_world({at(0, 0), at(1, 0), at(2, 0)})).inside);
      EXPECT_FALSE(field->scalar(geometry.to_world({at(0, 1e-5), at(1, 0), at(2, 0)})).inside);
      EXPECT_FALSE(field->scalar(geometry.to_world({at(0, 0), at(1, 1e-5), at(2, 0)})).inside);
      EXPECT_FALSE(field->scalar(geometry.to_world({at(0, 0), at(1, 0), at(2, 1e-5)})).inside);
    }
    const Box box = field->bounds_m();
    const Box around{box.low_m - box.size_m(), box.high_m + box.size_m()};
    for (int n = 0; n < 2000; ++n) {
      const Vec3 x = within(random, around);
      const bool in_box = x.x >= box.low_m.x && x.x <= box.high_m.x && x.y >= box.low_m.y && x.y <= box.high_m.y &&
                          x.z >= box.low_m.z && x.z <= box.high_m.z;
      const bool inside = field->scalar(x).inside;
      EXPECT_TRUE(in_box || !inside);
      if (inside) {
        EXPECT_GE(field->depth_m(x), 0.0);
      } else {
        EXPECT_LE(field->depth_m(x), 0.0);
        expect_outside_and_finite(*field, x);
      }
    }
  }
}

TEST(Grid, depth_is_the_distance_to_the_nearest_face) {
  std::mt19937 random(8);
  for (const Mat3& affine : affines()) {
    const GridGeometry geometry = small_grid(affine);
    const FieldPtr field = random_grid(random, geometry);
    for (int n = 0; n < 50; ++n) {
      const GridPoint p{uniform(random, 0, 3), uniform(random, 0, 4), uniform(random, 0, 2)};
      const Vec3 at = geometry.to_world(p);
      const double depth = field->depth_m(at);
      // A ball of that radius lies within the data, and touches its surface.
      bool touches = false;
      for (int m = 0; m < 4000; ++m) {
        const Vec3 way = normalized({uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)});
        EXPECT_TRUE(field->scalar(at + 0.999 * depth * way).inside);
        touches = touches || !field->scalar(at + (1.02 * depth + 1e-5 * field->spacing_m()) * way).inside;
      }
      EXPECT_TRUE(touches);
    }
  }
}

TEST(Grid, spacing_is_the_least_distance_of_sample_planes) {
  const Mat3 steps{{{0.8e-3, 0, 0}, {0, 1.1e-3, 0}, {0, 0, 2.5e-3}}};
  std::mt19937 random(9);
  EXPECT_NEAR(random_grid(random, small_grid(steps))->spacing_m(), 0.8e-3, 1e-15);
  EXPECT_NEAR(random_grid(random, small_grid(rotation(random) * steps))->spacing_m(), 0.8e-3, 1e-15);
  const double tilt = 0.5;  // rad: planes of a sheared slice stack are closer than their slices' centres
  const Mat3 tilted{{{5e-3, 0, 0}, {0, 5e-3, 2.5e-3 * std::sin(tilt)}, {0, 0, 2.5e-3 * std::cos(tilt)}}};
  EXPECT_NEAR(random_grid(random, small_grid(tilted))->spacing_m(), 2.5e-3 * std::cos(tilt), 1e-15);
}

template <class T>
void expect_hole(T bad) {
  const GridGeometry geometry{{5, 5, 5}, Mat3::identity(), {}};
  std::vector<T> values(125, T{2});
  values[2 + 5 * (2 + 5 * 2)] = bad;
  const FieldPtr field = grid_field(geometry, voxels_of(values));
  std::mt19937 random(10);
  for (int n = 0; n < 3000; ++n) {
    const Vec3 at = within(random, field->bounds_m());
    const bool beside_the_hole = largest_component(at - Vec3{2, 2, 2}) < 1.0;
    ASSERT_EQ(field->scalar(at).inside, !beside_the_hole);
    if (beside_the_hole) {
      EXPECT_EQ(field->scalar(at).value, 0.0);
    }
  }
  // Also where the bad voxel has weight 0 or 1.
  EXPECT_FALSE(field->scalar({2, 2, 2}).inside);
  EXPECT_FALSE(field->scalar({1.5, 1, 1}).inside);
  EXPECT_FALSE(field->scalar({1, 1, 1}).inside);
  EXPECT_TRUE(field->scalar({3, 3, 3}).inside);
  EXPECT_EQ(grid_of(*field)->valid_share, 124.0 / 125.0);
  EXPECT_EQ(field->value_ranges()[0].min, 2.0);
  EXPECT_EQ(field->value_ranges()[0].max, 2.0);

  std::vector<T> vectors(375, T{2});
  vectors[1 + 3 * (2 + 5 * (2 + 5 * 2))] = bad;
  const FieldPtr vector = grid_field(geometry, voxels_of(vectors, 3));
  EXPECT_FALSE(vector->vector({1.5, 1.5, 1.5}).inside);
  EXPECT_EQ(vector->vector({1.5, 1.5, 1.5}).value, Vec3{});
  EXPECT_TRUE(vector->vector({0.5, 1.5, 1.5}).inside);
  EXPECT_EQ(grid_of(*vector)->valid_share, 124.0 / 125.0);
}

TEST(Grid, a_voxel_that_is_not_finite_makes_its_cells_outside) {
  expect_hole<float>(std::numeric_limits<float>::quiet_NaN());
  expect_hole<float>(std::numeric_limits<float>::infinity());
  expect_hole<float>(-std::numeric_limits<float>::infinity());
  expect_hole<double>(nan);
  expect_hole<double>(infinity);
  expect_hole<double>(-infinity);
}

/// Value ranges by the library against a plain search and against an interpolated field.
template <class T>
void expect_looked_at(std::mt19937& random, const GridGeometry& geometry, int components, std::int64_t one_row_in,
                      bool with_holes) {
  std::vector<T> values(geometry.voxels() * components);
  for (T& v : values) v = static_cast<T>(uniform(random, std::is_unsigned_v<T> ? 0 : -120, 120));
  if constexpr (std::is_floating_point_v<T>) {
    const T bad[] = {std::numeric_limits<T>::quiet_NaN(), static_cast<T>(infinity), static_cast<T>(-infinity)};
    for (std::size_t n = 0; with_holes && n < 1 + values.size() / 50; ++n) values[random() % values.size()] = bad[n % 3];
  }
  std::vector<ValueRange> ranges(components, {infinity, -infinity});
  double all = 0.0, valid = 0.0;
  const detail::RowSamples rows{geometry.dims[1] * geometry.dims[2], one_row_in};
  for (std::int64_t sample = 0; sample < rows.count(); ++sample) {
    const std::int64_t row = rows[sample];
    for (std::int64_t i = 0; i < geometry.dims[0]; ++i) {
      bool is_valid = true;
      for (int c = 0; c < components; ++c) {
        const auto v = static_cast<double>(values[c + components * (i + geometry.dims[0] * row)]);
        is_valid = is_valid && std::isfinite(v);
        if (std::isfinite(v)) ranges[c] = {std::min(ranges[c].min, v), std::max(ranges[c].max, v)};
      }
      all += 1.0, valid += is_valid;
    }
  }
  for (ValueRange& range : ranges) {
    if (range.min > range.max) range = {0.0, 0.0};
  }
  const Voxels voxels = voxels_of(values, components);
  const FieldPtr field = preview_grid_field(geometry, voxels, 1.0, 0.0, one_row_in);
  EXPECT_EQ(field->value_ranges(), ranges);
  EXPECT_EQ(grid_of(*field)->valid_share, valid / all);
  if (one_row_in > 1) return;
  const FieldPtr felt = grid_field(geometry, voxels);
  EXPECT_EQ(field->value_ranges(), felt->value_ranges());
  EXPECT_EQ(grid_of(*field)->valid_share, grid_of(*felt)->valid_share);
  for (int n = 0; n < 20; ++n) {
    const Vec3 at = within(random, felt->bounds_m());
    EXPECT_EQ(field->depth_m(at), felt->depth_m(at)) << "holes have no depth";
    if (components == 1) {
      EXPECT_EQ(field->scalar(at).inside, felt->scalar(at).inside);
    }
  }
}

TEST(Grid, looked_at_has_the_range_of_its_rows) {
  std::mt19937 random(17);
  for (const std::array<std::int64_t, 3>& dims :
       {std::array<std::int64_t, 3>{1, 1, 1}, {5, 4, 3}, {47, 3, 2}, {48, 2, 5}, {131, 7, 9}, {97, 53, 31}}) {
    const GridGeometry geometry{dims, Mat3::identity(), {}};
    for (const int components : {1, 3}) {
      for (const std::int64_t one_row_in : {1, 2, 7}) {
        SCOPED_TRACE(testing::Message() << dims[0] << " along i, " << components << " components, one row in " << one_row_in);
        expect_looked_at<std::uint8_t>(random, geometry, components, one_row_in, false);
        expect_looked_at<std::int16_t>(random, geometry, components, one_row_in, false);
        expect_looked_at<std::int32_t>(random, geometry, components, one_row_in, false);
        for (const bool with_holes : {false, true}) {
          expect_looked_at<float>(random, geometry, components, one_row_in, with_holes);
          expect_looked_at<double>(random, geometry, components, one_row_in, with_holes);
        }
      }
    }
  }
}

TEST(Grid, a_cell_of_nothing_but_infinities_is_outside) {
  for (const double other : {infinity, -infinity, nan}) {
    std::vector<double> values(27, infinity);
    for (std::size_t i = 0; i < values.size(); i += 2) values[i] = other;
    const FieldPtr field = grid_field({{3, 3, 3}, Mat3::identity(), {}}, voxels_of(values));
    std::mt19937 random(11);
    for (int n = 0; n < 200; ++n) EXPECT_FALSE(field->scalar(within(random, field->bounds_m())).inside);
    for (int n = 0; n < 27; ++n) EXPECT_FALSE(field->scalar({double(n % 3), double(n / 3 % 3), double(n / 9)}).inside);
    EXPECT_EQ(grid_of(*field)->valid_share, 0.0);
    EXPECT_EQ(field->value_ranges()[0].min, 0.0);
    EXPECT_EQ(field->value_ranges()[0].max, 0.0);
  }
}

TEST(Grid, what_overflows_is_outside) {
  std::vector<double> values(27, 1.7e308);
  for (std::size_t i = 0; i < values.size(); i += 2) values[i] = -1.7e308;
  const FieldPtr wild = grid_field({{3, 3, 3}, Mat3::identity(), {}}, voxels_of(values));
  expect_outside_and_finite(*posed(wild, {.translation_m = {10, 0, 0}}), {0.5, 0.5, 0.5});
  EXPECT_FALSE(wild->scalar({0.5, 0.5, 0.5}).inside);

  // The values are finite, the slope per metre is not.
  std::vector<double> steep(27, 1e300);
  steep[13] = 2e300;
  const Mat3 tiny{{{1e-20, 0, 0}, {0, 1e-20, 0}, {0, 0, 1e-20}}};
  const FieldPtr field = grid_field({{3, 3, 3}, tiny, {}}, voxels_of(steep));
  const ScalarSample s = field->scalar({0.5e-20, 0.5e-20, 0.5e-20});
  EXPECT_FALSE(s.inside);
  EXPECT_EQ(s.gradient, Vec3{});
}

TEST(Grid, absurd_positions_are_outside) {
  std::mt19937 random(12);
  for (const Mat3& affine : affines()) {
    for (const int components : {1, 3}) {
      const FieldPtr field = random_grid(random, small_grid(affine), components);
      for (const Vec3& at : absurd_positions()) expect_outside_and_finite(*field, at);
    }
  }
}

TEST(Grid, is_constant_across_an_axis_of_one_voxel) {
  std::mt19937 random(13);
  const Mat3 affine = affines()[2];
  const GridGeometry geometry{{4, 5, 1}, affine, {0.1, 0.2, 0.3}};
  const FieldPtr sheet = random_grid(random, geometry);
  const ScalarSample middle = sheet->scalar(geometry.to_world({1.3, 2.6, 0}));
  ASSERT_TRUE(middle.inside);
  for (const double k : {-0.49, 0.2, 0.49}) {
    const ScalarSample s = sheet->scalar(geometry.to_world({1.3, 2.6, k}));
    EXPECT_TRUE(s.inside);
    EXPECT_NEAR(s.value, middle.value, 1e-9);
    EXPECT_LT(largest_component(s.gradient - middle.gradient), 1e-6);
  }
  EXPECT_NEAR(dot(middle.gradient, {affine.row[0].z, affine.row[1].z, affine.row[2].z}), 0.0, 1e-12);
  EXPECT_FALSE(sheet->scalar(geometry.to_world({1.3, 2.6, 0.51})).inside);
  EXPECT_FALSE(sheet->scalar(geometry.to_world({1.3, 2.6, -0.51})).inside);
  EXPECT_NEAR(sheet->bounds_m().size_m().z, 2.5e-3, 1e-15);
  EXPECT_NEAR(sheet->depth_m(geometry.to_world({1.5, 2, 0.3})), 0.2 * 2.5e-3, 1e-12);

  const FieldPtr speck = grid_field({{1, 1, 1}, Mat3::identity(), {}}, voxels_of(std::vector<double>{4.0}));
  EXPECT_EQ(speck->scalar({0.4, -0.4, 0.1}).value, 4.0);
  EXPECT_EQ(speck->scalar({0.4, -0.4, 0.1}).gradient, Vec3{});
  EXPECT_FALSE(speck->scalar({0.6, 0, 0}).inside);
}

TEST(Grid, scaling_the_world_by_a_power_of_two_changes_no_bit) {
  std::mt19937 random(14);
  for (const Mat3& affine : affines()) {
    for (const int exponent : {-100, -30, -1, 1, 23, 100}) {
      const double factor = std::ldexp(1.0, exponent);
      const GridGeometry geometry = small_grid(affine);
      const GridGeometry scaled{geometry.dims, factor * geometry.index_to_world_m, factor * geometry.origin_m};
      std::vector<float> values(180);
      for (float& v : values) v = static_cast<float>(uniform(random, -1, 1));
      const std::vector<float> first(values.begin(), values.begin() + 60);
      const FieldPtr a = grid_field(geometry, voxels_of(first), 0.3, 0.7), b = grid_field(scaled, voxels_of(first), 0.3, 0.7);
      const FieldPtr va = grid_field(geometry, voxels_of(values, 3)), vb = grid_field(scaled, voxels_of(values, 3));
      EXPECT_EQ(a->spacing_m() * factor, b->spacing_m());
      EXPECT_EQ(factor * a->bounds_m().low_m, b->bounds_m().low_m);
      for (int n = 0; n < 300; ++n) {
        const Vec3 at = within(random, a->bounds_m());
        const ScalarSample s = a->scalar(at), t = b->scalar(factor * at);
        EXPECT_EQ(s.inside, t.inside);
        EXPECT_EQ(s.value, t.value);
        EXPECT_EQ(s.gradient, factor * t.gradient);
        EXPECT_EQ(factor * a->depth_m(at), b->depth_m(factor * at));
        const VectorSample v = va->vector(at), w = vb->vector(factor * at);
        EXPECT_EQ(v.value, w.value);
        EXPECT_EQ(v.jacobian, factor * w.jacobian);
      }
    }
  }
}

TEST(Grid, shows_what_it_is_made_of_and_keeps_the_voxels_alive) {
  const GridGeometry geometry = small_grid(affines()[2]);
  Voxels voxels = voxels_of(std::vector<std::int16_t>(60, 5));
  const void* data = voxels.data.get();
  const FieldPtr field = grid_field(geometry, std::move(voxels), 2.0, 3.0);
  const GridView* view = grid_of(*field);
  ASSERT_NE(view, nullptr);
  EXPECT_EQ(view->geometry, geometry);
  EXPECT_EQ(view->voxels.data.get(), data);
  EXPECT_EQ(view->scale, 2.0);
  EXPECT_EQ(view->offset, 3.0);
  EXPECT_EQ(field->scalar(geometry.to_world({1, 1, 1})).value, 13.0);
  EXPECT_EQ(grid_of(*sphere_field().fields[0].field), nullptr);
}

void expect_refused(const GridGeometry& geometry, const char* word) {
  const char* problem = problem_with(geometry);
  ASSERT_NE(problem, nullptr) << word;
  EXPECT_THAT(problem, testing::HasSubstr(word));
  EXPECT_THROW(grid_field(geometry, voxels_of(std::vector<float>(1))), std::invalid_argument);
}

TEST(Grid, refuses_a_geometry_that_cannot_be_in_a_sentence) {
  const Mat3 one = Mat3::identity();
  expect_refused({{0, 1, 1}, one, {}}, "no voxels");
  expect_refused({{1, -3, 1}, one, {}}, "no voxels");
  expect_refused({{std::int64_t{1} << 40, std::int64_t{1} << 40, 1}, one, {}}, "more voxels");
  expect_refused({{std::numeric_limits<std::int64_t>::max(), 1, 1}, one, {}}, "more voxels");
  expect_refused({{2, 2, 2}, {{{1, 0, 0}, {0, 0, 0}, {0, 0, 1}}}, {}}, "zero");
  expect_refused({{2, 2, 2}, {{{1, 0, 0}, {0, nan, 0}, {0, 0, 1}}}, {}}, "not finite");
  expect_refused({{2, 2, 2}, {{{1, 0, 0}, {0, infinity, 0}, {0, 0, 1}}}, {}}, "not finite");
  expect_refused({{2, 2, 2}, {{{1, 1, 0}, {1, 1, 0}, {0, 0, 1}}}, {}}, "one plane");
  expect_refused({{2, 2, 2}, {{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}}, {}}, "one plane");
  expect_refused({{2, 2, 2}, one, {0, nan, 0}}, "origin");
  EXPECT_EQ(problem_with({{2, 2, 2}, one, {}}), nullptr);
  // Any step size is valid: molecules and storms.
  EXPECT_EQ(problem_with({{2, 2, 2}, 1e-10 * one, {}}), nullptr);
  EXPECT_EQ(problem_with({{2, 2, 2}, 1e6 * one, {}}), nullptr);
}

TEST(Grid, refuses_voxels_that_cannot_be_in_a_sentence) {
  const GridGeometry geometry{{2, 2, 2}, Mat3::identity(), {}};
  const auto refused = [&](Voxels voxels, double scale, double offset, const char* word) {
    try {
      grid_field(geometry, std::move(voxels), scale, offset);
      FAIL() << "accepted; expected a word about " << word;
    } catch (const std::invalid_argument& e) {
      EXPECT_THAT(e.what(), testing::HasSubstr(word));
    }
  };
  const Voxels good = voxels_of(std::vector<float>(24, 2.0f));
  refused({VoxelType::float32, 1, nullptr}, 1, 0, "no voxels in memory");
  refused({VoxelType::float32, 2, good.data}, 1, 0, "2 components");
  refused({VoxelType::float32, 0, good.data}, 1, 0, "0 components");
  refused({static_cast<VoxelType>(17), 1, good.data}, 1, 0, "type of voxel");
  refused(good, nan, 0, "scale and offset must be finite");
  refused(good, 1, infinity, "scale and offset must be finite");
  refused(voxels_of(std::vector<float>(8, 3e38f)), 1e300, 0, "beyond the largest number");
  const auto* bytes = static_cast<const char*>(good.data.get());
  refused({VoxelType::float32, 1, std::shared_ptr<const void>(good.data, bytes + 1)}, 1, 0, "not aligned");
}

TEST(VoxelType, has_the_names_that_files_and_reports_use) {
  EXPECT_STREQ(name_of(VoxelType::uint8), "uint8");
  EXPECT_STREQ(name_of(VoxelType::int16), "int16");
  EXPECT_STREQ(name_of(VoxelType::uint16), "uint16");
  EXPECT_STREQ(name_of(VoxelType::int32), "int32");
  EXPECT_STREQ(name_of(VoxelType::float32), "float32");
  EXPECT_STREQ(name_of(VoxelType::float64), "float64");
}

}  // namespace grid_test
}  // namespace palpa
