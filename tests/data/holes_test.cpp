// Depth in data with holes.
#include <algorithm>
#include <cmath>
#include <limits>

#include "palpa/data/axis_grid.h"
#include "palpa/data/derived.h"
#include "palpa/data/filter.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/timed_field.h"
#include "tests/data/test_fields.h"

namespace palpa {
namespace holes_test {

using namespace test;

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr std::int64_t n = 14;

struct Lattice {
  const char* name;
  GridGeometry geometry;
};

std::vector<Lattice> lattices() {
  std::mt19937 random(3);
  const Mat3 cubes{{{1e-3, 0, 0}, {0, 1e-3, 0}, {0, 0, 1e-3}}};
  const Mat3 steps{{{0.8e-3, 0, 0}, {0, 1.1e-3, 0}, {0, 0, 2.5e-3}}};
  const Mat3 sheared{{{0.8e-3, 0, 0.3e-3}, {0, 1.1e-3, -0.9e-3}, {0, 0, 2.5e-3}}};
  GridGeometry uneven{{n, n, n}, steps, {}};
  for (double at = 0, step = 0.05; uneven.planes[1].size() < n; at += step, step *= 1.35) uneven.planes[1].push_back(at);
  for (double& at : uneven.planes[1]) at *= (n - 1) / uneven.planes[1].back();
  return {{"cubes", {{n, n, n}, cubes, {0.1, 0, -0.2}}},
          {"oblique", {{n, n, n}, rotation(random) * steps, {}}},
          {"sheared", {{n, n, n}, sheared, {}}},
          {"uneven", uneven},
          {"flat", {{n, n, 1}, steps, {}}}};
}

/// Random numbers with about this many voxels missing.
std::vector<float> with_holes(std::mt19937& random, const GridGeometry& geometry, int components, double holes) {
  const double share = holes / static_cast<double>(geometry.voxels());
  std::vector<float> values(static_cast<std::size_t>(geometry.voxels() * components));
  for (float& v : values) v = static_cast<float>(uniform(random, -1, 1));
  for (std::int64_t at = 0; at < geometry.voxels(); ++at) {
    if (uniform(random, 0, 1) < share) values[static_cast<std::size_t>(at * components + random() % components)] = nan;
  }
  return values;
}

std::vector<FieldPtr> fields_with_holes(std::mt19937& random, const GridGeometry& geometry) {
  const Voxels scalars = voxels_of(with_holes(random, geometry, 1, 10));
  const Voxels vectors = voxels_of(with_holes(random, geometry, 3, 10), 3);
  return {grid_field(geometry, scalars),
          smooth_grid_field(geometry, scalars),
          cubic_grid_field(geometry, scalars),
          grid_field(geometry, vectors),
          smooth_grid_field(geometry, vectors),
          axis_grid_field(geometry, vectors),
          axis_grid_field(geometry, vectors, 1, 0, Filter::smooth)};
}

bool is_inside(const Field& field, const Vec3& x) { return field.scalar(x).inside || field.vector(x).inside; }

TEST(Holes, DepthIsZeroWhereSamplingFailsAndChangesByAtMostTheWay) {
  std::mt19937 random(1);
  for (const Lattice& lattice : lattices()) {
    SCOPED_TRACE(lattice.name);
    for (const FieldPtr& field : fields_with_holes(random, lattice.geometry)) {
      double steepest = 0.0;
      int held = 0, failed = 0;
      for (int i = 0; i < 20000; ++i) {
        const Vec3 x = within(random, field->bounds_m());
        const Vec3 step = uniform(random, 1e-6, 1.5) * field->spacing_m() *
                          normalized({uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)});
        const double here = field->depth_m(x), there = field->depth_m(x + step);
        steepest = std::max(steepest, std::abs(there - here) / norm(step));
        if (here > 0.0) {
          EXPECT_TRUE(is_inside(*field, x));
          // The data reach that far in every direction.
          EXPECT_TRUE(norm(step) >= here || is_inside(*field, x + step));
        }
        if (!is_inside(*field, x)) {
          EXPECT_LE(here, 0.0);
        }
        ++(here > 0.0 ? held : failed);
      }
      EXPECT_LE(steepest, 1.0 + 1e-6);
      EXPECT_GT(held, 200);
      EXPECT_GT(failed, 200);
    }
  }
}

TEST(Holes, DepthWithoutAnyIsThatOfTheBoxToTheBit) {
  std::mt19937 random(2);
  for (const Lattice& lattice : lattices()) {
    const Voxels scalars = voxels_of(with_holes(random, lattice.geometry, 1, 0));
    const Voxels whole = voxels_of(std::vector<std::int16_t>(static_cast<std::size_t>(lattice.geometry.voxels()), 7));
    const FieldPtr plain = grid_field(lattice.geometry, whole);
    for (const FieldPtr& field : {grid_field(lattice.geometry, scalars), cubic_grid_field(lattice.geometry, scalars)}) {
      for (int i = 0; i < 1000; ++i) {
        const Vec3 x = within(random, field->bounds_m());
        EXPECT_EQ(field->depth_m(x), plain->depth_m(x));
      }
    }
  }
}

// One missing voxel in the middle: depth along an axis, a face's diagonal, and the cube's.
TEST(Holes, DepthIsTheWayAlongTheAxes) {
  const double h = 1e-3;
  const GridGeometry geometry{{41, 41, 41}, {{{h, 0, 0}, {0, h, 0}, {0, 0, h}}}, {}};
  std::vector<float> values(41 * 41 * 41, 1.0F);
  values[20 + 41 * (20 + 41 * 20)] = std::numeric_limits<float>::infinity();
  const auto depth_at = [&](const FieldPtr& field, double i, double j, double k) {
    return field->depth_m({h * (20 + i), h * (20 + j), h * (20 + k)});
  };
  for (const auto& [field, reach] : {std::pair{grid_field(geometry, voxels_of(values)), 1.0},
                                     std::pair{smooth_grid_field(geometry, voxels_of(values)), 2.0}}) {
    const double along_axis = h / std::sqrt(3.0), tolerance = 1e-8 * h;
    EXPECT_NEAR(depth_at(field, reach + 3.25, 0, 0.5), 3.25 * along_axis, tolerance);
    EXPECT_NEAR(depth_at(field, 0, -reach - 3.25, 0), 3.25 * along_axis, tolerance);
    EXPECT_NEAR(depth_at(field, reach + 3, reach + 4, 0), 7 * along_axis, tolerance);
    EXPECT_NEAR(depth_at(field, reach + 3, reach + 3, reach + 3), 3 * h * std::sqrt(3.0), 1e-7 * h);
    EXPECT_EQ(depth_at(field, reach, 0, 0), 0.0);
    EXPECT_NEAR(depth_at(field, 19, 19, 19), h, tolerance) << "the box is nearer";
  }
}

TEST(Holes, ArePassedOnByWhatIsMadeOfAField) {
  std::mt19937 random(5);
  const GridGeometry geometry = lattices().front().geometry;
  const Voxels vectors = voxels_of(with_holes(random, geometry, 3, 8), 3);
  const Voxels scalars = voxels_of(with_holes(random, geometry, 1, 8));
  const FieldPtr velocity = grid_field(geometry, vectors), frame = grid_field(geometry, scalars);
  const FieldPtr other = grid_field(geometry, voxels_of(with_holes(random, geometry, 1, 8)));
  const Similarity pose{rotation(random), 2.0, {0.1, 0.2, 0.3}};
  const FieldPtr moved = posed(frame, pose);
  const FieldPtr series = time_series({frame, other}, 0.1, BetweenFrames::linear);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 x = within(random, velocity->bounds_m());
    for (const Derivation d : {Derivation::magnitude, Derivation::component_y})
      EXPECT_EQ(derived(d, velocity)->depth_m(x), velocity->depth_m(x));
    EXPECT_NEAR(moved->depth_m(pose.to_world(x)), 2.0 * frame->depth_m(x), 1e-12);
    EXPECT_EQ(timed(*series)->depth_at(x, 0.05), std::min(frame->depth_m(x), other->depth_m(x)));
  }
  for (const Derivation d : {Derivation::q, Derivation::coherence, Derivation::curl, Derivation::smooth_vector}) {
    const FieldPtr made = derived(d, velocity);
    for (int i = 0; i < 2000; ++i) {
      const Vec3 x = within(random, velocity->bounds_m());
      if (!is_inside(*made, x)) {
        EXPECT_LE(made->depth_m(x), 0.0);
      }
    }
  }
}

TEST(Holes, EverywhereLeaveNoDepth) {
  const GridGeometry geometry = lattices().front().geometry;
  const FieldPtr field = grid_field(geometry, voxels_of(std::vector<float>(n * n * n, nan)));
  EXPECT_EQ(field->depth_m(field->bounds_m().centre_m()), 0.0);
  const FieldPtr one = grid_field({{1, 1, 1}, geometry.index_to_world_m, {}}, voxels_of(std::vector<float>{nan}));
  EXPECT_FALSE(is_inside(*one, {}));
  EXPECT_EQ(one->depth_m({}), 0.0);
}

}  // namespace holes_test
}  // namespace palpa
