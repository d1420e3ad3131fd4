// Lipschitz bounds within their radius, and the extent of data.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "palpa/data/analytic.h"
#include "palpa/data/axis_grid.h"
#include "palpa/data/derived.h"
#include "palpa/data/filter.h"
#include "palpa/data/sampled.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/timed_field.h"
#include "tests/data/test_fields.h"

namespace palpa {
namespace certificate_test {

using test::uniform;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// A random valid grid: sheared, far away, flat, with uneven planes.
GridGeometry any_geometry(std::mt19937& random) {
  GridGeometry geometry;
  for (std::int64_t& n : geometry.dims) n = random() % 8 == 0 ? 1 : 2 + static_cast<std::int64_t>(random() % 28);
  const double size_m = std::pow(10.0, uniform(random, -4, 1));
  const Mat3 shear{{{1, uniform(random, -0.4, 0.4), 0}, {0, uniform(random, 0.3, 2), uniform(random, -0.4, 0.4)}, {0, 0, 1}}};
  geometry.index_to_world_m = size_m * (test::rotation(random) * shear);
  geometry.origin_m = size_m * uniform(random, 0, 1000) * test::rotation(random).row[0];
  for (std::size_t a = 0; a < 3; ++a) {
    if (random() % 3 != 0 || geometry.dims[a] < 3) continue;
    std::vector<double>& planes = geometry.planes[a];
    planes.push_back(0.0);
    for (std::int64_t n = 1; n < geometry.dims[a]; ++n) planes.push_back(planes.back() + std::exp(uniform(random, -3, 0)));
    const double stretch = static_cast<double>(geometry.dims[a] - 1) / planes.back();
    for (double& at : planes) at *= stretch;
    planes.back() = static_cast<double>(geometry.dims[a] - 1);
  }
  return geometry;
}

/// Noise on a ramp, with some holes.
template <class T>
Voxels any_voxels(std::mt19937& random, const GridGeometry& geometry, int components) {
  std::vector<T> values;
  const double noise = std::pow(10.0, uniform(random, -3, 2));
  const bool holes = std::is_floating_point_v<T> && random() % 2 == 0;
  bool hole = false;
  for (std::int64_t n = 0; n < geometry.voxels() * components; ++n) {
    const double ramp = static_cast<double>(n / components % geometry.dims[0]);
    if (holes && random() % 400 == 0) hole = !hole;
    values.push_back(hole ? static_cast<T>(nan) : static_cast<T>(100.0 + ramp + uniform(random, -noise, noise)));
  }
  return test::voxels_of(std::move(values), components);
}

FieldPtr any_grid(std::mt19937& random, int components, const GridGeometry& geometry) {
  const double scale = uniform(random, -3, 3), offset = uniform(random, -100, 100);
  switch (random() % 5) {
    case 0: return grid_field(geometry, any_voxels<float>(random, geometry, components), scale, offset);
    case 1: return grid_field(geometry, any_voxels<std::int16_t>(random, geometry, components), scale, offset);
    case 2: return smooth_grid_field(geometry, any_voxels<std::uint8_t>(random, geometry, components), scale, offset);
    case 3: return smooth_grid_field(geometry, any_voxels<double>(random, geometry, components), scale, offset);
    default: return cubic_grid_field(geometry, any_voxels<float>(random, geometry, components), scale, offset);
  }
}

FieldPtr any_grid(std::mt19937& random, int components) { return any_grid(random, components, any_geometry(random)); }

/// Up to three frames, each with a filter, holes and a type of its own.
FieldPtr any_series(std::mt19937& random, int components) {
  const GridGeometry geometry = any_geometry(random);
  const std::size_t size = 1 + random() % 3;
  std::vector<FieldPtr> frames;
  while (frames.size() < size) {
    FieldPtr frame = any_grid(random, components, geometry);
    if (frames.empty() || !problem_with_frame(*frames.front(), *frame)) frames.push_back(std::move(frame));
  }
  return time_series(std::move(frames), 0.1, random() % 8 == 0 ? BetweenFrames::nearest : BetweenFrames::linear);
}

FieldPtr any_field(std::mt19937& random) {
  FieldPtr field;
  switch (random() % 4) {
    case 0: field = any_grid(random, 1); break;
    case 1: field = any_grid(random, 3); break;
    case 2: field = derived(Derivation::magnitude, any_grid(random, 3)); break;
    default: field = derived(Derivation::component_y, any_grid(random, 3));
  }
  if (random() % 3 != 0) return field;
  return posed(field, {test::rotation(random), std::exp(uniform(random, -3, 3)), test::rotation(random).row[1]});
}

Similarity any_pose(std::mt19937& random) {
  return {test::rotation(random), std::exp(uniform(random, -1, 1)), test::rotation(random).row[1]};
}

/// Series and grids, moved along tracks and not, and lengths and components of them.
FieldPtr any_timed_field(std::mt19937& random) {
  FieldPtr field;
  switch (random() % 4) {
    case 0: field = any_grid(random, 1 + 2 * static_cast<int>(random() % 2)); break;
    case 1: field = any_series(random, 3); break;
    default: field = any_series(random, 1);
  }
  if (random() % 2 == 0 || !timed(*field)) {
    const Mat3 turned = test::rotation(random);
    PoseTrack track{{0.0, {turned, 1.0, {}}}};
    const double angle = uniform(random, -2.5, 2.5), c = std::cos(angle), s = std::sin(angle);
    const Mat3 about_z{{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}};
    track.push_back({0.25, {about_z * turned, std::exp(uniform(random, -1, 1)), test::rotation(random).row[0]}});
    field = moving(field, track, static_cast<int>(random() % 3));
  }
  if (random() % 4 == 0) field = posed(field, any_pose(random));
  if (field->components() == 3 && random() % 2 == 0)
    field = derived(random() % 2 == 0 ? Derivation::magnitude : Derivation::component_z, field);
  return field;
}

struct Looked {
  double change = 0.0;
  bool inside = false;
};
Looked look(const Field& field, const Vec3& from_m, const Vec3& to_m) {
  if (field.components() == 1) {
    const ScalarSample a = field.scalar(from_m), b = field.scalar(to_m);
    return {std::abs(b.value - a.value), b.inside};
  }
  const VectorSample a = field.vector(from_m), b = field.vector(to_m);
  return {norm(b.value - a.value), b.inside};
}
bool has_data(const Field& field, const Vec3& at_m) { return look(field, at_m, at_m).inside; }

Vec3 beside(std::mt19937& random, const Box& box) {
  const Vec3 x = test::within(random, box);
  return random() % 4 == 0 ? box.centre_m() + uniform(random, 0.9, 1.5) * (x - box.centre_m()) : x;
}

/// Places looked at: with data, with a bound as well, with one on the bend, with known values, with a bound on having no data.
struct Places {
  int inside = 0, with_certificate = 0, with_bend = 0, with_values = 0, without_data = 0;
};

/// The value at y is as near to the tangent at the centre x as the bound says, and on a way to y to the chord.
void expect_straight(std::mt19937& random, const Field& field, const LipschitzBound& c, const Vec3& x, const Vec3& y) {
  const double way_m = distance(x, y), share = uniform(random, 0, 1);
  const ScalarSample centre = field.scalar(x), to = field.scalar(y);
  ASSERT_LE(std::abs(to.value - (centre.value + dot(centre.gradient, y - x))), c.off_tangent(way_m));
  const Vec3 z = x + uniform(random, 0, way_m) * test::rotation(random).row[0];
  const double from = field.scalar(z).value, between = field.scalar(z + share * (y - z)).value;
  ASSERT_LE(std::abs(between - ((1.0 - share) * from + share * to.value)), c.off_chord(distance(z, y)));
}

void expect_among(const ValueRange& values, double value, double rounding) {
  ASSERT_GE(value, values.min - rounding);
  ASSERT_LE(value, values.max + rounding);
}

void expect_bounds(std::mt19937& random, const Field& field, const Box& box, Places& places) {
  for (int i = 0; i < 50; ++i) {
    const Vec3 x = beside(random, box);
    const LipschitzBound c = field.lipschitz_bound(x);
    const bool inside = has_data(field, x);
    places.inside += inside;
    if (c.radius_m == 0.0) continue;
    places.with_certificate += inside;
    places.without_data += !inside;
    const bool bends = inside && std::isfinite(c.bend_per_m2);
    const bool is_known = inside && std::isfinite(c.values.max);
    places.with_bend += bends, places.with_values += is_known;
    ASSERT_TRUE(c.radius_m > 0.0 && std::isfinite(c.radius_m) && c.slope_per_m >= 0.0 && c.rounding >= 0.0);
    for (int pair = 0; pair < 20; ++pair) {
      const double way_m = (pair % 2 == 0 ? 1.0 : std::pow(10.0, uniform(random, -12, 0))) * c.radius_m;
      const Vec3 y = x + way_m * test::rotation(random).row[2];
      if (distance(x, y) > c.radius_m) continue;
      const Looked at = look(field, x, y);
      ASSERT_EQ(at.inside, inside) << i;
      ASSERT_LE(at.change, c.change(distance(x, y))) << i;
      if (bends) expect_straight(random, field, c, x, y);
      if (is_known) expect_among(c.values, field.scalar(y).value, c.rounding);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
}

TEST(LipschitzBound, BoundsEveryChangeWithinItsRadius) {
  std::mt19937 random(71);
  Places places;
  for (int n = 0; n < 400 && !testing::Test::HasFatalFailure(); ++n) {
    SCOPED_TRACE(n);
    const FieldPtr field = any_field(random);
    expect_bounds(random, *field, field->bounds_m(), places);
  }
  EXPECT_GT(places.with_certificate, places.inside / 3);
  EXPECT_GT(places.with_bend, places.inside / 10);
  EXPECT_GT(places.with_values, places.inside / 5);
  EXPECT_GT(places.without_data, 100);
}

/// Where a field has data at a moment: of a moving one, its box holds for all.
Box box_at(const FieldPtr& field, DataTime at) {
  const MovingView* moved = moving_of(*field);
  return moved ? posed(moved->field, pose_at(moved->track, at))->bounds_m() : field->bounds_m();
}

TEST(LipschitzBound, OfWhatChangesWithTimeBoundsItAtItsMoment) {
  std::mt19937 random(72);
  Places places;
  int between_frames = 0;
  for (int n = 0; n < 900 && !testing::Test::HasFatalFailure(); ++n) {
    SCOPED_TRACE(n);
    const FieldPtr field = any_timed_field(random);
    const DataTime at{n % 4 == 0 ? 0.1 * static_cast<double>(random() % 3) : uniform(random, 0.0, 0.35), n % 2 == 0};
    const FieldPtr now = frozen(field, at);
    Places there;
    expect_bounds(random, *now, box_at(field, at), there);
    const SeriesView* series = series_of(*field);
    between_frames += series && series->frames.size() > 1 && n % 4 != 0 ? there.with_certificate : 0;
    places.inside += there.inside;
    places.with_certificate += there.with_certificate;
    places.with_bend += there.with_bend;
    places.without_data += there.without_data;
    const Vec3 x = test::within(random, field->bounds_m());
    EXPECT_EQ(field->lipschitz_bound(x).radius_m, timed(*field)->lipschitz_bound_at(x, {}).radius_m);
  }
  std::printf("%d places with data, %d with a bound, %d between frames, %d without data\n", places.inside,
              places.with_certificate, between_frames, places.without_data);
  EXPECT_GT(places.with_certificate, places.inside / 4);
  EXPECT_GT(between_frames, 300);
  EXPECT_GT(places.with_bend, places.inside / 20);
  EXPECT_GT(places.without_data, 100);
}

TEST(LipschitzBound, OfASeriesIsThatOfAFrameAndTheWeightedSumOfTwo) {
  const GridGeometry geometry{{32, 32, 32}, 1e-3 * Mat3::identity(), {}};
  std::vector<float> steep, gentle;
  for (int n = 0; n < 32 * 32 * 32; ++n) {
    steep.push_back(static_cast<float>(4 * (n % 32)));
    gentle.push_back(static_cast<float>(n % 32));
  }
  const std::vector<FieldPtr> frames{grid_field(geometry, test::voxels_of(steep)),
                                     grid_field(geometry, test::voxels_of(gentle))};
  const FieldPtr series = time_series(frames, 1.0);
  const Vec3 x{0.0152, 0.0168, 0.0081};
  const LipschitzBound a = frames[0]->lipschitz_bound(x), b = frames[1]->lipschitz_bound(x);
  for (const std::size_t i : {0, 1}) {
    const LipschitzBound own = frames[i]->lipschitz_bound(x);
    const LipschitzBound c = timed(*series)->lipschitz_bound_at(x, static_cast<double>(i));
    EXPECT_EQ(c.radius_m, own.radius_m);
    EXPECT_EQ(c.slope_per_m, own.slope_per_m);
    EXPECT_EQ(c.rounding, own.rounding);
  }
  const LipschitzBound c = timed(*series)->lipschitz_bound_at(x, 0.25);
  EXPECT_EQ(c.radius_m, std::min(a.radius_m, b.radius_m));
  EXPECT_DOUBLE_EQ(c.slope_per_m, 0.75 * a.slope_per_m + 0.25 * b.slope_per_m);
  EXPECT_LT(c.rounding, 2.0 * std::max(a.rounding, b.rounding));
}

TEST(LipschitzBound, IsSharpWhereNothingChangesAndReachesAboutACell) {
  const GridGeometry geometry{{32, 32, 32}, 1e-3 * Mat3::identity(), {}};
  const FieldPtr flat = smooth_grid_field(geometry, test::voxels_of(std::vector<float>(32 * 32 * 32, 7.5F)));
  const LipschitzBound c = flat->lipschitz_bound({0.0152, 0.0168, 0.0081});
  EXPECT_EQ(c.slope_per_m, 0.0);
  EXPECT_LT(c.rounding, 1e-12);
  EXPECT_EQ(c.values, (ValueRange{7.5, 7.5}));
  EXPECT_NEAR(c.radius_m, 1e-3, 1e-6);
}

TEST(LipschitzBound, OfARampIsItsSlope) {
  std::vector<float> values;
  for (int n = 0; n < 64 * 64 * 64; ++n) values.push_back(static_cast<float>(n % 64));
  const GridGeometry geometry{{64, 64, 64}, 1e-3 * Mat3::identity(), {}};
  const FieldPtr ramp = grid_field(geometry, test::voxels_of(values));
  // As if the value had this slope along every axis.
  EXPECT_NEAR(ramp->lipschitz_bound({0.0204, 0.0204, 0.0204}).slope_per_m, 1e3 * std::sqrt(3.0), 1e-2);
}

// A second difference of the voxels is at most twice their largest difference, and along a diagonal three times as steep.
TEST(LipschitzBound, BendsBySecondDifferencesAlone) {
  std::vector<float> saw;
  for (int n = 0; n < 32 * 32 * 32; ++n) saw.push_back(static_cast<float>(n % 2));
  const GridGeometry geometry{{32, 32, 32}, 1e-3 * Mat3::identity(), {}};
  const Vec3 x{0.0152, 0.0168, 0.0081};
  EXPECT_NEAR(smooth_grid_field(geometry, test::voxels_of(saw))->lipschitz_bound(x).bend_per_m2, 6e6, 1.0);
  const double no_bound = std::numeric_limits<double>::infinity();
  EXPECT_EQ(grid_field(geometry, test::voxels_of(saw))->lipschitz_bound(x).bend_per_m2, no_bound);
  const FieldPtr flow = smooth_grid_field({{32, 32, 8}, 1e-3 * Mat3::identity(), {}},
                                          test::voxels_of(std::vector<float>(3 * 32 * 32 * 8, 1.0F), 3));
  const Vec3 inside{0.0152, 0.0168, 0.0041};
  EXPECT_EQ(derived(Derivation::component_x, flow)->lipschitz_bound(inside).bend_per_m2, 0.0);
  EXPECT_EQ(derived(Derivation::magnitude, flow)->lipschitz_bound(inside).bend_per_m2, no_bound);
}

// Where the voxels alternate along their closest planes, tangent and chord are as far off as the bound says.
TEST(LipschitzBound, OfTheBendIsSharpOnASaw) {
  std::vector<float> saw;
  for (int n = 0; n < 32 * 32 * 32; ++n) saw.push_back(static_cast<float>(n % 2));
  const FieldPtr field = smooth_grid_field({{32, 32, 32}, {{{1e-3, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, {}}, test::voxels_of(saw));
  const Vec3 x{0.015, 16, 16}, step{1e-5, 0, 0};
  const LipschitzBound c = field->lipschitz_bound(x);
  const ScalarSample at = field->scalar(x);
  const double ahead = field->scalar(x + step).value, behind = field->scalar(x - step).value;
  const double off_tangent = std::abs(ahead - at.value - dot(at.gradient, step));
  const double off_chord = std::abs(at.value - 0.5 * (ahead + behind));
  EXPECT_LE(off_tangent, c.off_tangent(norm(step)));
  EXPECT_GE(off_tangent, 0.9 * c.off_tangent(norm(step)));
  EXPECT_LE(off_chord, c.off_chord(2.0 * norm(step)));
  EXPECT_GE(off_chord, 0.9 * c.off_chord(2.0 * norm(step)));
}

TEST(LipschitzBound, IsNoneOfFormulasAndAxes) {
  const FieldPtr ball = sphere_field(0.05).fields[0].field;
  const FieldPtr grid = sampled(*ball, 32);
  const Vec3 x{0.01, 0.012, 0.013};
  EXPECT_EQ(ball->lipschitz_bound(x).radius_m, 0.0);
  EXPECT_GT(grid->lipschitz_bound(x).radius_m, 0.0);
  EXPECT_EQ(time_series({grid, grid}, 1.0)->lipschitz_bound(x).radius_m, grid->lipschitz_bound(x).radius_m);
  EXPECT_EQ(time_series({ball, ball}, 1.0)->lipschitz_bound(x).radius_m, 0.0);
  const FieldPtr flow = sampled(*lamb_oseen_vortex().fields[0].field, 32);
  const Vec3 inside = flow->bounds_m().centre_m() + 0.1 * flow->bounds_m().size_m();
  EXPECT_GT(flow->lipschitz_bound(inside).radius_m, 0.0);
  EXPECT_EQ(signless(flow)->lipschitz_bound(inside).radius_m, 0.0);
  for (const Vec3& absurd : test::absurd_positions()) {
    const LipschitzBound c = grid->lipschitz_bound(absurd);
    EXPECT_TRUE(std::isfinite(c.radius_m) && c.slope_per_m == 0.0 && c.rounding == 0.0);
  }
}

TEST(LocalSpacing, IsThatOfTheCell) {
  const GridGeometry geometry = rectilinear_geometry({{{0.0, 0.001, 0.003, 0.007}, {0.0, 0.01, 0.02}, {0.0, 0.01, 0.02}}});
  const FieldPtr grid = grid_field(geometry, test::voxels_of(std::vector<float>(4 * 3 * 3, 1.0F)));
  const double spacings_m[] = {0.001, 0.002, 0.004}, places_m[] = {0.0005, 0.002, 0.005};
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(grid->local_spacing_m({places_m[i], 0.015, 0.005}), spacings_m[i], 1e-15);
  EXPECT_NEAR(grid->local_spacing_m({-1.0, 0.0, 0.0}), 0.001, 1e-15);
  EXPECT_NEAR(grid->local_spacing_m({1.0, 0.0, 0.0}), 0.004, 1e-15);
  const FieldPtr twice = posed(grid, {Mat3::identity(), 2.0, {}});
  EXPECT_NEAR(twice->local_spacing_m({0.004, 0.03, 0.01}), 0.004, 1e-15);
  EXPECT_EQ(twice->spacing_m(), 2.0 * grid->spacing_m());
  const FieldPtr ball = sphere_field(0.05).fields[0].field;
  EXPECT_EQ(ball->local_spacing_m({}), ball->spacing_m());
  for (const Vec3& absurd : test::absurd_positions()) {
    const double spacing_m = grid->local_spacing_m(absurd);
    EXPECT_TRUE(spacing_m > 0.0 && spacing_m <= 0.01);
  }
}

}  // namespace certificate_test
}  // namespace palpa
