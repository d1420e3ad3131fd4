// Values per sample, counted by changing every value of a grid in turn.
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "palpa/data/axis_grid.h"
#include "palpa/data/derived.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/timed_field.h"
#include "tests/data/test_fields.h"

namespace palpa {
namespace values_per_sample_test {

constexpr std::int64_t n = 7;
const GridGeometry geometry{{n, n, n}, Mat3::identity(), Vec3{}};
const Vec3 inside_m{3.3, 2.8, 3.6};  // with four voxels before it and behind it

std::vector<float> noise(int components) {
  std::mt19937 random(4);
  std::vector<float> values;
  for (std::int64_t i = 0; i < n * n * n * components; ++i)
    values.push_back(static_cast<float>(test::uniform(random, 0.5, 1.0)));
  return values;
}

bool are_alike(const Field& a, const Field& b) {
  const ScalarSample s = a.scalar(inside_m), t = b.scalar(inside_m);
  const VectorSample u = a.vector(inside_m), v = b.vector(inside_m);
  return s.value == t.value && s.gradient == t.gradient && u.value == v.value && u.jacobian.row[0] == v.jacobian.row[0] &&
         u.jacobian.row[1] == v.jacobian.row[1] && u.jacobian.row[2] == v.jacobian.row[2];
}

using Make = FieldPtr (*)(std::vector<float> values, int components);

int values_read(Make make, int components) {
  const std::vector<float> values = noise(components);
  const FieldPtr as_it_is = make(values, components);
  int read = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::vector<float> changed = values;
    changed[i] *= 1.5f;
    read += !are_alike(*as_it_is, *make(changed, components));
  }
  return read;
}

FieldPtr linear(std::vector<float> values, int components) {
  return grid_field(geometry, test::voxels_of(std::move(values), components));
}
FieldPtr smooth(std::vector<float> values, int components) {
  return smooth_grid_field(geometry, test::voxels_of(std::move(values), components));
}
FieldPtr axes(std::vector<float> values, int) { return axis_grid_field(geometry, test::voxels_of(std::move(values), 3)); }
FieldPtr smooth_axes(std::vector<float> values, int) {
  return axis_grid_field(geometry, test::voxels_of(std::move(values), 3), 1.0, 0.0, Filter::smooth);
}

TEST(ValuesPerSample, AreThoseThatASampleDependsOn) {
  for (const int components : {1, 3}) {
    EXPECT_EQ(linear(noise(components), components)->values_per_sample(), values_read(linear, components));
    EXPECT_EQ(smooth(noise(components), components)->values_per_sample(), values_read(smooth, components));
  }
  // Of each direction six products of its parts and its length are summed.
  EXPECT_EQ(axes(noise(3), 3)->values_per_sample(), 7 * values_read(axes, 3) / 3);
  EXPECT_EQ(smooth_axes(noise(3), 3)->values_per_sample(), 7 * values_read(smooth_axes, 3) / 3);
}

TEST(ValuesPerSample, OfWhatIsTakenOfOthersAreTheirs) {
  const FieldPtr still = smooth_axes(noise(3), 3);
  const FieldPtr series = time_series({still, still, still}, 1.0),
                 nearest = time_series({still, still}, 1.0, BetweenFrames::nearest);
  EXPECT_EQ(derived(Derivation::magnitude, still)->values_per_sample(), still->values_per_sample());
  EXPECT_EQ(posed(still, {.translation_m = {1, 0, 0}})->values_per_sample(), still->values_per_sample());
  EXPECT_EQ(series->values_per_sample(), 2 * still->values_per_sample());
  EXPECT_EQ(nearest->values_per_sample(), still->values_per_sample());
  EXPECT_EQ(frozen(series, 0.5)->values_per_sample(), series->values_per_sample());
  EXPECT_EQ(derived(Derivation::magnitude, series)->values_per_sample(), series->values_per_sample());
  EXPECT_EQ(moving(series, {{0.0, {}}, {1.0, {.translation_m = {1, 0, 0}}}})->values_per_sample(), series->values_per_sample());
  const FieldPtr numbers = smooth(noise(1), 1);
  EXPECT_EQ(derived(Derivation::detail, numbers)->values_per_sample(), numbers->values_per_sample() + 8);
}

}  // namespace values_per_sample_test
}  // namespace palpa
