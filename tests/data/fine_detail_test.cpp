// Detail removed by the smoothing filter: closed forms of alternating voxels.
#include "palpa/data/fine_detail.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpa/data/analytic.h"
#include "palpa/data/derived.h"
#include "palpa/data/filter.h"
#include "palpa/data/sampled.h"
#include "palpa/data/timed_field.h"
#include "tests/data/test_fields.h"

namespace palpa {
namespace fine_detail_test {

using namespace test;

constexpr int n = 41;
const Mat3 skew_steps{{{0.011, 0.002, -0.001}, {-0.003, 0.009, 0.002}, {0.001, 0.001, -0.014}}};
const GridGeometry skew{{n, n, n}, skew_steps, {0.3, -0.2, 0.1}};

/// Linear along k from 0 to `range`, with `amplitude` up and down from voxel to voxel.
FieldPtr alternating(double amplitude, double range, Filter filter = Filter::smooth, const GridGeometry& geometry = skew) {
  std::vector<double> values;
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) values.push_back(range * k / (n - 1) + ((i + j + k) % 2 == 0 ? amplitude : -amplitude));
    }
  }
  return filtered(grid_field(geometry, voxels_of(std::move(values))), filter);
}

/// Voxels ±1 along one axis at the fraction f of a cell: linear, and as a uniform cubic B-spline.
double straight(double f) { return 1.0 - 2.0 * f; }
double smoothed(double f) {
  const double g = 1.0 - f;
  return -g * g * g / 6.0 + (2.0 / 3.0 - f * f + f * f * f / 2.0) - (2.0 / 3.0 - g * g + g * g * g / 2.0) + f * f * f / 6.0;
}

/// Three times the root mean square over a cell of the product of `straight` less that of `smoothed`.
double three_deviations() {
  constexpr int parts = 1000;
  double ll = 0.0, ls = 0.0, ss = 0.0;
  for (int p = 0; p < parts; ++p) {
    const double f = (p + 0.5) / parts, l = straight(f), s = smoothed(f);
    ll += l * l / parts, ls += l * s / parts, ss += s * s / parts;
  }
  return 3.0 * std::sqrt(ll * ll * ll - 2.0 * ls * ls * ls + ss * ss * ss);
}

TEST(FineDetail, OfVoxelsThatAlternateIsTheShareOfThreeDeviations) {
  std::mt19937 random(1);
  // Below a thousandth of the range the amplitude counts as a share of that thousandth.
  for (const double range : {0.0, 10.0, 1e4}) {
    const FieldPtr field = derived(Derivation::detail, alternating(2.0, range));
    const double scale = std::max(2.0 * three_deviations(), 0.001 * (range + 4.0));
    double sum = 0.0, clamped = 0.0;
    constexpr int places = 20000;
    for (int p = 0; p < places; ++p) {
      const double at[3] = {uniform(random, 2, n - 3), uniform(random, 2, n - 3), uniform(random, 2, n - 3)};
      double l = 1.0, s = 1.0;
      int cells = 0;
      for (const double x : at) {
        const double first = std::floor(x);
        cells += static_cast<int>(first);
        l *= straight(x - first);
        s *= smoothed(x - first);
      }
      const double expected = std::clamp((cells % 2 == 0 ? 2.0 : -2.0) * (l - s) / scale, -1.0, 1.0);
      const ScalarSample sample = field->scalar(skew.to_world({at[0], at[1], at[2]}));
      ASSERT_TRUE(sample.inside);
      ASSERT_LE(std::abs(sample.value), 1.0);
      EXPECT_NEAR(sample.value, expected, 0.04) << "4096 places tell the deviation to a few parts in a hundred";
      sum += sample.value;
      clamped += std::abs(sample.value) == 1.0;
    }
    EXPECT_NEAR(sum / places, 0.0, 0.01) << range;
    EXPECT_EQ(clamped > 0.0, range < 1e3);
  }
}

TEST(FineDetail, IsTheSameInAnyUnitAndAnyWorld) {
  const FieldPtr field = alternating(2.0, 10.0);
  std::mt19937 random(2);
  const Similarity pose{rotation(random), 3.0, {0.1, 0.2, -0.3}};
  const FieldPtr one = derived(Derivation::detail, field), turned = derived(Derivation::detail, posed(field, pose));
  const FieldPtr other = derived(Derivation::detail, alternating(2.0 * 1024, 10.0 * 1024));
  const FieldPtr moved = derived(Derivation::detail, moving(field, {{0.0, pose}, {1.0, {}}}, 2));
  for (int p = 0; p < 2000; ++p) {
    const Vec3 x = within(random, field->bounds_m());
    EXPECT_EQ(other->scalar(x).value, one->scalar(x).value) << "a power of two changes no bit";
    EXPECT_NEAR(turned->scalar(pose.to_world(x)).value, one->scalar(x).value, 1e-8);
    EXPECT_NEAR(moved->scalar(pose.to_world(x)).value, one->scalar(x).value, 1e-8);
    EXPECT_EQ(turned->depth_m(pose.to_world(x)), posed(field, pose)->depth_m(pose.to_world(x)));
  }
}

TEST(FineDetail, HasItsOwnDerivative) {
  const FieldPtr field = derived(Derivation::detail, alternating(2.0, 1e4));
  std::mt19937 random(3);
  for (int p = 0; p < 500; ++p) {
    GridPoint at;
    for (double* x : {&at.i, &at.j, &at.k}) *x = std::floor(uniform(random, 1, n - 2)) + uniform(random, 0.1, 0.9);
    const Vec3 x = skew.to_world(at);
    EXPECT_LT(largest_component(field->scalar(x).gradient - numeric_gradient(*field, x, 1e-5)), 1e-4);
  }
}

TEST(FineDetail, IsNothingWhereTheFilterLeavesNothing) {
  const FieldPtr flow = sampled(*lamb_oseen_vortex(0.02, 0.01).fields[0].field, 12);
  const FieldPtr formula = sphere_field(0.05).fields[0].field;
  const FieldPtr straight_only = alternating(0.0, 10.0), flat = alternating(0.0, 0.0);
  EXPECT_TRUE(has_detail(*alternating(2.0, 0.0)));
  EXPECT_TRUE(has_detail(*posed(alternating(2.0, 0.0), {.scale = 2.0})));
  EXPECT_TRUE(has_detail(*time_series({alternating(2.0, 0.0), alternating(1.0, 0.0)}, 0.1)));
  std::mt19937 random(4);
  for (const FieldPtr& none :
       {alternating(2.0, 10.0, Filter::trilinear), alternating(2.0, 10.0, Filter::cubic), formula,
        derived(Derivation::magnitude, flow), derived(Derivation::component_x, filtered(flow, Filter::smooth))}) {
    EXPECT_FALSE(has_detail(*none));
    const FieldPtr field = derived(Derivation::detail, none);
    for (int p = 0; p < 200; ++p) {
      const Vec3 x = within(random, none->bounds_m());
      EXPECT_EQ(field->scalar(x).value, 0.0);
      EXPECT_EQ(field->scalar(x).inside, none->scalar(x).inside);
    }
  }
  for (const FieldPtr& calm : {straight_only, flat}) {
    const FieldPtr field = derived(Derivation::detail, calm);
    for (int p = 0; p < 200; ++p) {
      const Vec3 x = skew.to_world({uniform(random, 2, n - 3), uniform(random, 2, n - 3), uniform(random, 2, n - 3)});
      EXPECT_NEAR(field->scalar(x).value, 0.0, 1e-12) << "rounding is not blown up";
    }
  }
  EXPECT_THROW(derived(Derivation::detail, flow), std::invalid_argument);
}

TEST(FineDetail, IsFiniteAnywhere) {
  const FieldPtr field = derived(Derivation::detail, alternating(2.0, 10.0));
  for (const Vec3& x : absurd_positions()) expect_outside_and_finite(*field, x);
  // Voxels without a value are holes of detail and field alike.
  std::vector<float> values;
  std::mt19937 random(5);
  for (int v = 0; v < 20 * 20 * 20; ++v) {
    const float value = static_cast<float>(uniform(random, -1, 1));
    values.push_back(v % 97 == 0 ? std::numeric_limits<float>::quiet_NaN() : v % 89 == 0 ? 3e38f : value);
  }
  const FieldPtr torn = filtered(grid_field({{20, 20, 20}, skew_steps, {}}, voxels_of(std::move(values))), Filter::smooth);
  const FieldPtr of_torn = derived(Derivation::detail, torn);
  int inside = 0;
  for (int p = 0; p < 5000; ++p) {
    const Vec3 x = within(random, torn->bounds_m());
    const ScalarSample s = of_torn->scalar(x);
    ASSERT_EQ(s.inside, torn->scalar(x).inside);
    ASSERT_LE(std::abs(s.value), 1.0);
    ASSERT_TRUE(is_finite(s.gradient));
    inside += s.inside;
  }
  EXPECT_GT(inside, 100);
}

}  // namespace fine_detail_test
}  // namespace palpa
