// Grids of unread voxels against read grids, and batches of samples against single samples.
#include "palpa/data/unread_grid.h"

#include <gtest/gtest.h>
#include <sys/mman.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <thread>

#include "palpa/data/analytic.h"
#include "palpa/data/filter.h"
#include "palpa/data/samples.h"
#include "palpa/data/timed_field.h"

namespace palpa {
namespace unread_grid_test {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
const GridGeometry oblique{{9, 8, 7}, {{{1e-3, 2e-4, 0}, {-2e-4, 1e-3, 1e-4}, {0, -1e-4, 2e-3}}}, {0.1, -0.2, 0.3}};

Voxels random_voxels(bool with_holes) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  const auto values = std::make_shared<std::vector<float>>();
  for (std::int64_t n = 0; n < oblique.voxels(); ++n) values->push_back(normal(random));
  if (with_holes) (*values)[150] = std::numeric_limits<float>::quiet_NaN();
  return {VoxelType::float32, 1, {values, values->data()}};
}

std::vector<Vec3> places(int count) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> share(-0.2, 1.2);
  std::vector<Vec3> all{{nan, 0, 0}, {1e300, 0, 0}, oblique.origin_m};
  while (static_cast<int>(all.size()) < count)
    all.push_back(oblique.to_world({8 * share(random), 7 * share(random), 6 * share(random)}));
  return all;
}

void expect_same(const Field& a, const Field& b) {
  for (const Vec3& at_m : places(500)) {
    const ScalarSample x = a.scalar(at_m), y = b.scalar(at_m);
    ASSERT_EQ(x.inside, y.inside);
    EXPECT_EQ(x.value, y.value);
    EXPECT_EQ(x.gradient, y.gradient);
    EXPECT_EQ(a.depth_m(at_m), b.depth_m(at_m));
    const LipschitzBound c = a.lipschitz_bound(at_m), d = b.lipschitz_bound(at_m);
    EXPECT_EQ(c.radius_m, d.radius_m);
    EXPECT_EQ(c.slope_per_m, d.slope_per_m);
    const PolynomialPiece s = a.piece_along(oblique.origin_m, at_m, 0.0, {-1.0, 1.0}),
                          t = b.piece_along(oblique.origin_m, at_m, 0.0, {-1.0, 1.0});
    EXPECT_EQ(s.end, t.end);
    EXPECT_EQ(s.degree, t.degree);
  }
  EXPECT_EQ(a.value_ranges(), b.value_ranges());
  EXPECT_EQ(a.spacing_m(), b.spacing_m());
  EXPECT_EQ(a.bounds_m().low_m, b.bounds_m().low_m);
  EXPECT_EQ(grid_of(a)->valid_share, grid_of(b)->valid_share);
}

TEST(UnreadGrid, IsTheFieldThatWasRead) {
  for (const bool with_holes : {false, true}) {
    const Voxels voxels = random_voxels(with_holes);
    expect_same(*unread_grid_field(oblique, voxels, 2.0, 5.0), *grid_field(oblique, voxels, 2.0, 5.0));
  }
  EXPECT_THROW(unread_grid_field(oblique, {}), std::invalid_argument);
  EXPECT_THROW(unread_grid_field({{0, 1, 1}}, random_voxels(false)), std::invalid_argument);
  EXPECT_THROW(unread_grid_field(oblique, random_voxels(false), nan), std::invalid_argument);
}

// The first page alone can be read: further access ends the test.
TEST(UnreadGrid, IsMadeAndSampledWithoutReadingAllVoxels) {
  constexpr std::int64_t side = 64;
  void* const memory = ::mmap(nullptr, side * side * side, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  ASSERT_EQ(::mprotect(static_cast<char*>(memory) + 2 * side * side, side * side * (side - 2), PROT_NONE), 0);
  const Voxels voxels{
      VoxelType::uint8, 1, {memory, [](const void* all) { ::munmap(const_cast<void*>(all), side * side * side); }}};
  const FieldPtr field = unread_grid_field({.dims = {side, side, side}}, voxels);
  EXPECT_TRUE(field->scalar({5.5, 6.5, 0.5}).inside);
  EXPECT_EQ(field->bounds_m().high_m, (Vec3{side - 1, side - 1, side - 1}));
  double value = nan, gradient[3];
  const double place[] = {5.5, 6.5, 0.5};
  detail::sample_scalars(*field, place, 1, &value, gradient);
  EXPECT_EQ(value, 0.0);
}

// A scene adds volumes through `filtered`, so that ticks sample a grid that has been read.
TEST(UnreadGrid, IsReadWhereItGetsItsFilter) {
  const Voxels voxels = random_voxels(true);
  for (const Filter filter : {Filter::trilinear, Filter::smooth, Filter::cubic}) {
    const FieldPtr felt = filtered(unread_grid_field(oblique, voxels), filter);
    EXPECT_EQ(detail::view_read_now(*felt), nullptr) << "no unread grid any more";
    EXPECT_EQ(grid_behind(*felt)->filter, filter);
  }
  const FieldPtr moved = posed(unread_grid_field(oblique, voxels), {.scale = 2.0});
  EXPECT_LT(grid_below(*moved)->valid_share, 1.0);
}

TEST(UnreadGrid, IsReadOnceHoweverManyAsk) {
  constexpr std::int64_t side = 200;  // enough voxels for all threads to sample during the first read
  const auto values = std::make_shared<std::vector<std::uint8_t>>(side * side * side);
  const FieldPtr field = unread_grid_field({.dims = {side, side, side}}, {VoxelType::uint8, 1, {values, values->data()}});
  std::vector<const GridView*> seen(8);
  std::vector<std::thread> threads;
  for (const GridView*& view : seen) threads.emplace_back([&] { view = grid_of(*field); });
  for (std::thread& thread : threads) thread.join();
  for (const GridView* const view : seen) EXPECT_EQ(view, seen[0]);
}

TEST(ManySamples, AreTheSameBitsAsOneByOne) {
  const std::vector<Vec3> at_m = places(1003);
  std::vector<double> numbers;
  for (const Vec3& p : at_m) numbers.insert(numbers.end(), {p.x, p.y, p.z});
  for (const FieldPtr& field :
       {grid_field(oblique, random_voxels(true)), filtered(grid_field(oblique, random_voxels(false)), Filter::smooth),
        unread_grid_field(oblique, random_voxels(true), -3.0, 1.0), sphere_field(0.3).fields[0].field}) {
    std::vector<double> values(at_m.size()), gradients(numbers.size());
    detail::sample_scalars(*field, numbers.data(), static_cast<std::int64_t>(at_m.size()), values.data(), gradients.data());
    int inside = 0;
    for (std::size_t n = 0; n < at_m.size(); ++n) {
      const ScalarSample sample = field->scalar(at_m[n]);
      inside += sample.inside ? 1 : 0;
      ASSERT_EQ(std::isnan(values[n]), !sample.inside) << n;
      if (!sample.inside) continue;
      EXPECT_EQ(std::bit_cast<std::uint64_t>(values[n]), std::bit_cast<std::uint64_t>(sample.value));
      EXPECT_EQ((Vec3{gradients[3 * n], gradients[3 * n + 1], gradients[3 * n + 2]}), sample.gradient);
    }
    EXPECT_GT(inside, 100);
    EXPECT_LT(inside, 1003);
  }
}

}  // namespace unread_grid_test
}  // namespace palpa
