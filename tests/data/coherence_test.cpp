// coherence(FIELD): 1 for parallel vectors, near 0 for noise.
#include <algorithm>

#include "palpa/data/derived.h"
#include "palpa/data/timed_field.h"
#include "tests/data/test_fields.h"

namespace palpa {
namespace coherence_test {

using namespace test;

constexpr int n = 40;
const GridGeometry grid{{n, n, n}, 0.002 * Mat3::identity(), {0.1, -0.2, 0.3}};

template <class Value>
FieldPtr vectors(Value value) {
  std::vector<double> values;
  for (int at = 0; at < n * n * n; ++at) {
    const Vec3 v = value(grid.to_world({double(at % n), double(at / n % n), double(at / n / n)}));
    values.insert(values.end(), {v.x, v.y, v.z});
  }
  return grid_field(grid, voxels_of(std::move(values), 3));
}

FieldPtr noise(unsigned seed, double factor) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  return vectors([&](const Vec3&) {
    const double x = normal(random), y = normal(random), z = normal(random);
    return factor * Vec3{x, y, z};
  });
}

FieldPtr bent() {
  return vectors([](const Vec3& x) { return Vec3{1.0 + 20.0 * x.y, std::sin(60.0 * x.x), 30.0 * x.z * x.z}; });
}

TEST(Coherence, IsOneInAStreamAndNearZeroInNoise) {
  std::mt19937 random(1);
  const FieldPtr stream = derived(Derivation::coherence, vectors([](const Vec3&) { return Vec3{0.3, -4.0, 2.0}; }));
  const FieldPtr air = derived(Derivation::coherence, noise(2, 7.0));
  std::vector<double> values;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 x = within(random, {grid.to_world({8, 8, 8}), grid.to_world({31, 31, 31})});
    EXPECT_NEAR(stream->scalar(x).value, 1.0, 1e-6);
    values.push_back(air->scalar(x).value);
  }
  std::ranges::sort(values);
  EXPECT_LT(values[1980], 0.15);
  EXPECT_GE(values.front(), 0.0);
  EXPECT_LE(values.back(), 1.0);
}

TEST(Coherence, IsZeroWhereNothingMovesAndOutside) {
  const FieldPtr still = derived(Derivation::coherence, vectors([](const Vec3&) { return Vec3{}; }));
  EXPECT_TRUE(still->scalar(grid.to_world({20, 20, 20})).inside);
  EXPECT_EQ(still->scalar(grid.to_world({20, 20, 20})).value, 0.0);
  EXPECT_FALSE(still->scalar(grid.to_world({-3, 20, 20})).inside);
}

TEST(Coherence, KnowsNoUnitAndNoTurn) {
  std::mt19937 random(3);
  const FieldPtr one = derived(Derivation::coherence, noise(4, 1.0)), other = derived(Derivation::coherence, noise(4, 1e-3));
  const Similarity pose{.rotation = rotation(random), .scale = 3.0, .translation_m = {0.5, 1.0, -2.0}};
  const FieldPtr turned = derived(Derivation::coherence, posed(noise(4, 1.0), pose));
  for (int i = 0; i < 200; ++i) {
    const Vec3 x = within(random, one->bounds_m());
    EXPECT_NEAR(other->scalar(x).value, one->scalar(x).value, 1e-5);
    EXPECT_NEAR(turned->scalar(pose.to_world(x)).value, one->scalar(x).value, 1e-5);
  }
}

TEST(Coherence, HasTheDerivativeOfItsValue) {
  std::mt19937 random(5);
  const FieldPtr field = derived(Derivation::coherence, bent());
  constexpr double h_m = 1e-6;
  for (int i = 0; i < 200; ++i) {
    const Vec3 x = within(random, {grid.to_world({4, 4, 4}), grid.to_world({35, 35, 35})});
    const Vec3 slope = field->scalar(x).gradient;
    const Vec3 by_differences = Vec3{field->scalar(x + Vec3{h_m, 0, 0}).value - field->scalar(x - Vec3{h_m, 0, 0}).value,
                                     field->scalar(x + Vec3{0, h_m, 0}).value - field->scalar(x - Vec3{0, h_m, 0}).value,
                                     field->scalar(x + Vec3{0, 0, h_m}).value - field->scalar(x - Vec3{0, 0, h_m}).value} /
                                (2.0 * h_m);
    EXPECT_LT(norm(slope - by_differences), 1e-5 + 1e-3 * norm(slope));
  }
}

}  // namespace coherence_test
}  // namespace palpa
