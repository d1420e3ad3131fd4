// Interpolation filters: cubics through the voxels, defaults of types, positions of levels.
#include "palpa/data/filter.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "palpa/data/analytic.h"
#include "palpa/data/derived.h"
#include "palpa/data/sampled.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/timed_field.h"
#include "palpa/data/volume.h"
#include "tests/data/test_fields.h"

namespace palpa {
namespace filter_test {

using namespace test;

const GridGeometry sheared{
    {14, 11, 12}, {{{0.011, 0.002, -0.001}, {-0.003, 0.009, 0.002}, {0.001, 0.001, -0.014}}}, {0.3, -0.2, 0.1}};

template <class T>
std::vector<T> random_values(std::mt19937& random, const GridGeometry& g, int components = 1) {
  std::vector<T> values;
  for (std::int64_t n = 0; n < components * g.voxels(); ++n) values.push_back(static_cast<T>(uniform(random, -1, 1)));
  return values;
}
template <class T>
std::vector<T> values_of(const GridGeometry& g, const std::function<double(const Vec3&)>& value) {
  std::vector<T> values;
  for (std::int64_t k = 0; k < g.dims[2]; ++k)
    for (std::int64_t j = 0; j < g.dims[1]; ++j)
      for (std::int64_t i = 0; i < g.dims[0]; ++i)
        values.push_back(static_cast<T>(value(g.to_world({double(i), double(j), double(k)}))));
  return values;
}
void for_voxels(const GridGeometry& g, const std::function<void(const Vec3& world_m, std::size_t number)>& act) {
  std::size_t number = 0;
  for (std::int64_t k = 0; k < g.dims[2]; ++k)
    for (std::int64_t j = 0; j < g.dims[1]; ++j)
      for (std::int64_t i = 0; i < g.dims[0]; ++i) act(g.to_world({double(i), double(j), double(k)}), number++);
}

template <class T>
class CubicOf : public ::testing::Test {};
using Fractions = ::testing::Types<float, double>;
TYPED_TEST_SUITE(CubicOf, Fractions);

TYPED_TEST(CubicOf, meets_every_voxel_at_the_border_too) {
  std::mt19937 random(1);
  // Coefficients of alternating voxels are up to 27 times as large; each axis rounds once.
  const double rounding = 100.0 * std::numeric_limits<TypeParam>::epsilon() + 1e-9;  // and the voxel's position in the world
  for (const std::array<std::int64_t, 3> dims :
       {std::array<std::int64_t, 3>{14, 11, 12}, {1, 4, 3}, {2, 1, 1}, {1, 1, 1}, {2, 2, 2}, {40, 3, 17}}) {
    const GridGeometry g{dims, sheared.index_to_world_m, sheared.origin_m};
    for (const int components : {1, 3}) {
      const auto values = random_values<TypeParam>(random, g, components);
      const FieldPtr field = cubic_grid_field(g, voxels_of(values, components), -2.0, 5.0);
      for_voxels(g, [&](const Vec3& x, std::size_t n) {
        if (components == 1) {
          ASSERT_TRUE(field->scalar(x).inside);
          EXPECT_NEAR(field->scalar(x).value, -2.0 * values[n] + 5.0, 2.0 * rounding);
        } else {
          const Vec3 v = field->vector(x).value, wanted{values[3 * n], values[3 * n + 1], values[3 * n + 2]};
          EXPECT_LT(norm(v - (-2.0 * wanted + Vec3{5, 5, 5})), 4.0 * rounding);
        }
      });
    }
  }
}

TYPED_TEST(CubicOf, reproduces_cubics_away_from_the_border) {
  const std::int64_t n = 44;
  const double middle = 0.5 * double(n - 1);
  const GridGeometry g{{n, n, n}, Mat3::identity(), {-middle, -middle, -middle}};
  const auto cubic = [&](const Vec3& x) {
    const Vec3 u = x / middle;
    return 0.3 + u.x * u.x * u.x - 0.7 * u.y * u.y * u.z + 0.5 * u.x * u.y * u.z + 0.4 * u.z * u.z * u.z - u.x * u.y +
           0.2 * u.y;
  };
  const auto slope = [&](const Vec3& x) {
    const Vec3 u = x / middle;
    return Vec3{3 * u.x * u.x + 0.5 * u.y * u.z - u.y, -1.4 * u.y * u.z + 0.5 * u.x * u.z - u.x + 0.2,
                -0.7 * u.y * u.y + 0.5 * u.x * u.y + 1.2 * u.z * u.z} /
           middle;
  };
  const FieldPtr field = cubic_grid_field(g, voxels_of(values_of<TypeParam>(g, cubic)));
  // The slope 0 at the border decays as (2 − √3)ⁿ: after 15 voxels a slope of 0.14 per voxel is 4e-10.
  const double bound = 2e-9 + 20.0 * std::numeric_limits<TypeParam>::epsilon();
  std::mt19937 random(2);
  for (int m = 0; m < 2000; ++m) {
    const Vec3 x = within(random, {{-6, -6, -6}, {6, 6, 6}});
    EXPECT_NEAR(field->scalar(x).value, cubic(x), bound);
    EXPECT_LT(norm(field->scalar(x).gradient - slope(x)), 3.0 * bound);
  }
}

TYPED_TEST(CubicOf, leaves_gaps_and_meets_what_lies_beside_them) {
  std::mt19937 random(3);
  const GridGeometry& g = sheared;
  auto values = random_values<TypeParam>(random, g);
  for (int n = 0; n < 8; ++n) {
    values[random() % values.size()] =
        n % 2 ? std::numeric_limits<TypeParam>::quiet_NaN() : std::numeric_limits<TypeParam>::infinity();
  }
  const FieldPtr cubic = cubic_grid_field(g, voxels_of(values)), smooth = smooth_grid_field(g, voxels_of(values));
  EXPECT_EQ(grid_behind(*cubic)->valid_share, grid_behind(*smooth)->valid_share);
  int inside = 0;
  for_voxels(g, [&](const Vec3& x, std::size_t n) {
    const Vec3 inwards = x + 1e-9 * (cubic->bounds_m().centre_m() - x);
    ASSERT_EQ(cubic->scalar(inwards).inside, smooth->scalar(inwards).inside);
    if (!cubic->scalar(x).inside) return;
    ++inside;
    EXPECT_NEAR(cubic->scalar(x).value, values[n], 100.0 * std::numeric_limits<TypeParam>::epsilon() + 1e-9);
  });
  EXPECT_GT(inside, 500);
}

TYPED_TEST(CubicOf, derivatives_are_those_of_the_value) {
  std::mt19937 random(4);
  const FieldPtr field = cubic_grid_field(sheared, voxels_of(random_values<TypeParam>(random, sheared)));
  constexpr double h = 1e-6;
  for (int n = 0; n < 300; ++n) {
    const Vec3 index{uniform(random, 0.01, 12.9), uniform(random, 0.01, 9.9), uniform(random, 0.01, 10.9)};
    const Vec3 x = sheared.to_world({index.x, index.y, index.z});
    EXPECT_LT(norm(field->scalar(x).gradient - numeric_gradient(*field, x, h)), 1e-5);
    const Mat3 hessian = field->hessian(x);
    for (int a = 0; a < 3; ++a) {
      const Vec3 slope = (field->scalar(x + h * axis(a)).gradient - field->scalar(x - h * axis(a)).gradient) / (2.0 * h);
      EXPECT_LT(norm(hessian.row[a] - slope), 10.0);  // of 1e5; the third derivative jumps at cell faces
    }
  }
}

TEST(Cubic, turning_and_scaling_the_grid_turns_and_scales_the_gradient) {
  std::mt19937 random(5);
  const auto values = random_values<float>(random, sheared);
  const FieldPtr field = cubic_grid_field(sheared, voxels_of(values));
  for (const double scale : {1e-9, 1.0, 1e7}) {
    const Similarity map{rotation(random), scale, {1.0 * scale, -2.0 * scale, 0.5 * scale}};
    GridGeometry g = sheared;
    g.index_to_world_m = scale * (map.rotation * g.index_to_world_m);
    g.origin_m = map.to_world(g.origin_m);
    const FieldPtr moved = cubic_grid_field(g, voxels_of(values));
    for (int n = 0; n < 100; ++n) {
      const Vec3 x = within(random, field->bounds_m());
      const ScalarSample here = field->scalar(x), there = moved->scalar(map.to_world(x));
      if (field->depth_m(x) < 1e-6) continue;
      EXPECT_NEAR(here.value, there.value, 1e-9);
      EXPECT_LT(norm(map.rotation * here.gradient - scale * there.gradient), 1e-7);
    }
  }
}

TEST(Cubic, is_refused_for_whole_numbers_with_the_reason) {
  const GridGeometry g{{2, 2, 2}, Mat3::identity(), {}};
  const FieldPtr ct = grid_field(g, voxels_of(std::vector<std::int16_t>(8, 1)));
  try {
    filtered(ct, Filter::cubic);
    FAIL() << "no error";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("int16"), testing::HasSubstr("amplify the steps"),
                                             testing::HasSubstr("smooth")));
  }
}

// ---- Filters of fields

TEST(Filtered, shares_the_voxels_and_keeps_scale_and_pose) {
  std::mt19937 random(6);
  const auto values = random_values<float>(random, sheared);
  const Voxels voxels = voxels_of(values);
  const FieldPtr plain = grid_field(sheared, voxels, 3.0, -1.0), smooth = smooth_grid_field(sheared, voxels, 3.0, -1.0);
  const FieldPtr cubic = cubic_grid_field(sheared, voxels, 3.0, -1.0);
  const FieldPtr all[] = {plain, smooth, cubic};
  const Similarity pose{rotation(random), 2.0, {0.1, 0.2, -0.3}};
  for (const FieldPtr& from : all) {
    for (const FieldPtr& to : all) {
      const Filter filter = grid_behind(*to)->filter;
      const FieldPtr made = filtered(from, filter), moved = filtered(posed(from, pose), filter);
      EXPECT_EQ(made == from, from == to);
      EXPECT_EQ(grid_behind(*made)->filter, filter);
      EXPECT_EQ(grid_behind(*made)->voxels.data, voxels.data);
      EXPECT_EQ(grid_below(*moved)->voxels.data, voxels.data);
      EXPECT_EQ(grid_behind(*moved), nullptr);
      for (int n = 0; n < 50; ++n) {
        const Vec3 x = within(random, plain->bounds_m());
        EXPECT_EQ(made->scalar(x).value, to->scalar(x).value);
        EXPECT_EQ(made->scalar(x).gradient, to->scalar(x).gradient);
        EXPECT_EQ(moved->scalar(x).gradient, posed(to, pose)->scalar(x).gradient);
      }
    }
  }
  EXPECT_EQ(name_of(Filter::trilinear), std::string("trilinear"));
  EXPECT_EQ(grid_of(*smooth), nullptr);
  EXPECT_EQ(grid_of(*cubic), nullptr);
  EXPECT_EQ(smooth_grid_of(*cubic), nullptr);
}

TEST(Filtered, goes_into_the_frames_of_a_series_that_moves) {
  std::mt19937 random(9);
  const GridGeometry& g = sheared;
  std::vector<FieldPtr> frames, smooth;
  for (int f = 0; f < 3; ++f) {
    std::vector<std::int16_t> values;
    for (std::int64_t n = 0; n < g.voxels(); ++n) values.push_back(static_cast<std::int16_t>(uniform(random, -999, 999)));
    const Voxels voxels = voxels_of(values);
    frames.push_back(grid_field(g, voxels));
    smooth.push_back(smooth_grid_field(g, voxels));
  }
  const PoseTrack track{{0.0, {}}, {1.0, {.translation_m = {0.01, 0, 0}}}};
  Volume volume;
  volume.fields = {{"f", "", moving(time_series(frames, 0.1), track)}};
  const FieldPtr wanted = moving(time_series(smooth, 0.1), track), found = filtered(volume).fields[0].field;
  for (int n = 0; n < 200; ++n) {
    const Vec3 x = within(random, wanted->bounds_m());
    const double t_s = uniform(random, 0, 0.5);
    EXPECT_EQ(timed(*found)->scalar_at(x, t_s).value, timed(*wanted)->scalar_at(x, t_s).value);
  }
  EXPECT_EQ(grid_below(*found)->filter, Filter::smooth);
}

TEST(Filtered, by_default_whole_numbers_are_smooth_and_what_is_too_small_to_tell_stays) {
  const GridGeometry g{{3, 3, 3}, Mat3::identity(), {}};
  const auto filter_of = [&](auto value) {
    Volume volume;
    volume.fields = {{"f", "", grid_field(g, voxels_of(std::vector<decltype(value)>(27, value)))}};
    return grid_behind(*filtered(volume).fields[0].field)->filter;
  };
  EXPECT_EQ(filter_of(std::uint8_t{1}), Filter::smooth);
  EXPECT_EQ(filter_of(std::int16_t{1}), Filter::smooth);
  EXPECT_EQ(filter_of(std::uint16_t{1}), Filter::smooth);
  EXPECT_EQ(filter_of(std::int32_t{1}), Filter::smooth);
  EXPECT_EQ(filter_of(1.0F), Filter::trilinear);
  EXPECT_EQ(filter_of(1.0), Filter::trilinear);
  Volume kept = sphere_field();
  kept.fields.push_back({"cubic", "", cubic_grid_field(g, voxels_of(std::vector<float>(27, 1.0F)))});
  kept.fields.push_back({"smooth", "", smooth_grid_field(g, voxels_of(std::vector<float>(27, 1.0F)))});
  const Volume same = filtered(kept);
  for (std::size_t f = 0; f < kept.fields.size(); ++f) EXPECT_EQ(same.fields[f].field, kept.fields[f].field);
}

/// A wave of this many voxels along each axis, with noise as a share of it.
GridView wave_of(double length_voxels, double noise, std::int64_t n = 32) {
  std::mt19937 random(9);
  std::vector<float> values;
  for (std::int64_t v = 0; v < n * n * n; ++v) {
    const auto phase = [&](std::int64_t at) { return 2.0 * std::numbers::pi * static_cast<double>(at) / length_voxels; };
    const double wave = std::sin(phase(v % n)) + std::sin(phase(v / n % n)) + std::sin(phase(v / n / n));
    double normal = 0.0;
    for (int i = 0; i < 12; ++i) normal += uniform(random, -0.5, 0.5);
    values.push_back(static_cast<float>(100.0 + wave + noise * normal));
  }
  return *grid_behind(*grid_field({{n, n, n}, 0.001 * Mat3::identity(), {}}, voxels_of(values)));
}

TEST(DefaultFilter, roughness_is_that_of_waves_and_of_noise) {
  for (const double length : {16.0, 11.0, 6.0, 4.0}) {
    const double wanted = std::pow(2.0 * std::sin(std::numbers::pi / length), 4);
    EXPECT_NEAR(roughness(wave_of(length, 0.0)), wanted, 0.03 * wanted) << length;
  }
  EXPECT_NEAR(roughness(wave_of(1e9, 0.1)), 70.0 / 6.0, 0.4);
  EXPECT_EQ(roughness(wave_of(1e9, 0.0)), 0.0) << "nothing but rounding";
}

TEST(DefaultFilter, meets_smooth_voxels_and_smooths_rough_ones) {
  EXPECT_EQ(default_filter(wave_of(12.0, 0.0)).filter, Filter::cubic);
  EXPECT_EQ(default_filter(wave_of(12.0, 0.005)).filter, Filter::cubic);
  EXPECT_EQ(default_filter(wave_of(12.0, 0.2)).filter, Filter::smooth);
  EXPECT_EQ(default_filter(wave_of(4.0, 0.0)).filter, Filter::smooth) << "too short a wave for the voxels";
  const GridGeometry g{{9, 9, 9}, Mat3::identity(), {}};
  const auto ball = [](std::int64_t v) {
    const auto from_middle = [](std::int64_t i) { return static_cast<double>(i) - 4.0; };
    return std::hypot(from_middle(v % 9), from_middle(v / 9 % 9), from_middle(v / 81)) < 3.0 ? 1.0F : 0.0F;
  };
  std::vector<float> sharp, vectors(3 * 729, 1.0F);
  for (std::int64_t v = 0; v < 729; ++v) sharp.push_back(ball(v));
  EXPECT_EQ(default_filter(*grid_behind(*grid_field(g, voxels_of(sharp)))).filter, Filter::smooth);
  EXPECT_EQ(default_filter(*grid_behind(*grid_field(g, voxels_of(vectors, 3)))).filter, Filter::trilinear);
  GridGeometry uneven = g;
  uneven.planes[0] = {0, 0.5, 1, 2, 3, 4, 5, 6.5, 8};
  EXPECT_EQ(default_filter(*grid_behind(*grid_field(uneven, voxels_of(sharp)))).filter, Filter::trilinear);
  // Non-finite voxels do not count.
  std::vector<float> holes(32 * 32 * 32);
  const GridView wave = wave_of(12.0, 0.0);
  for (std::size_t v = 0; v < holes.size(); ++v)
    holes[v] = v % 97 == 0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<const float*>(wave.voxels.data.get())[v];
  EXPECT_EQ(default_filter(*grid_behind(*grid_field(wave.geometry, voxels_of(holes)))).filter, Filter::cubic);
}

// Between any two nearby points; a trilinear gradient's steepest change has no bound.
TEST(DefaultFilter, has_gradients_that_do_not_jump) {
  std::mt19937 random(11);
  for (const double noise : {0.0, 0.3}) {
    const GridView grid = wave_of(12.0, noise);
    Volume volume;
    volume.fields = {{"f", "", grid_field(grid.geometry, grid.voxels)}};
    const FieldPtr plain = volume.fields[0].field, felt = filtered(volume).fields[0].field;
    double jump = 0.0, plain_jump = 0.0;
    for (int i = 0; i < 20000; ++i) {
      const Vec3 at = within(random, {{0.003, 0.003, 0.003}, {0.028, 0.028, 0.028}});
      const Vec3 step = 1e-3 * felt->spacing_m() * normalized({uniform(random, -1, 1), uniform(random, -1, 1), 0.5});
      jump = std::max(jump, norm(felt->scalar(at + step).gradient - felt->scalar(at).gradient));
      plain_jump = std::max(plain_jump, norm(plain->scalar(at + step).gradient - plain->scalar(at).gradient));
    }
    EXPECT_LT(jump, 0.02 * plain_jump) << noise;
  }
}

TEST(Filtered, a_formula_has_no_voxels) {
  EXPECT_THROW(filtered(sphere_field().fields[0].field, Filter::smooth), std::invalid_argument);
  EXPECT_THROW(filtered(sphere_field(), Filter::trilinear), std::invalid_argument);
  EXPECT_THROW(filtered(FieldPtr{}, Filter::smooth), std::invalid_argument);
}

TEST(Filtered, what_is_derived_comes_from_the_voxels_whatever_the_filter) {
  const FieldPtr flow = sampled(*lamb_oseen_vortex(0.02, 0.01).fields[0].field, 33);
  const FieldPtr ball = sampled(*sphere_field().fields[0].field, 33);
  std::mt19937 random(7);
  for (const Filter filter : {Filter::smooth, Filter::cubic}) {
    for (const Derivation d : {Derivation::curl, Derivation::divergence, Derivation::q, Derivation::lambda2,
                               Derivation::gradient_magnitude, Derivation::smooth}) {
      const FieldPtr of = components_taken(d) == 3 ? flow : ball;
      const FieldPtr plain = derived(d, of), other = derived(d, filtered(of, filter));
      for (int n = 0; n < 100; ++n) {
        const Vec3 x = within(random, of->bounds_m());
        EXPECT_EQ(plain->scalar(x).value, other->scalar(x).value) << name_of(d);
        EXPECT_EQ(plain->scalar(x).gradient, other->scalar(x).gradient);
        EXPECT_EQ(plain->vector(x).value, other->vector(x).value);
      }
    }
    const FieldPtr u = filtered(flow, filter), size = derived(Derivation::magnitude, u);
    const FieldPtr part = derived(Derivation::component_y, u);
    EXPECT_EQ(size->value_ranges()[0].max, derived(Derivation::magnitude, flow)->value_ranges()[0].max);
    for (int n = 0; n < 100; ++n) {
      const Vec3 x = within(random, flow->bounds_m());
      EXPECT_EQ(size->scalar(x).value, norm(u->vector(x).value));
      EXPECT_EQ(part->scalar(x).value, u->vector(x).value.y);
    }
  }
}

// ---- Positions of levels

/// Distances of level 0 from a sphere along random directions, by bisection of the interpolant; sorted.
std::vector<double> distances(const Field& field, double radius_m, double expected_m, int directions) {
  std::mt19937 random(8);
  std::vector<double> found;
  for (int n = 0; n < directions; ++n) {
    const Vec3 out = normalized({uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)});
    const bool rises = field.scalar((radius_m - 2e-3) * out).value < field.scalar((radius_m + 2e-3) * out).value;
    double low = radius_m - 2e-3, high = radius_m + 2e-3;
    for (int step = 0; step < 45; ++step) {
      const double middle = 0.5 * (low + high);
      ((field.scalar(middle * out).value < 0.0) == rises ? low : high) = middle;
    }
    found.push_back(std::abs(0.5 * (low + high) - expected_m));
  }
  std::sort(found.begin(), found.end());
  return found;
}

TEST(Level, a_smooth_one_moves_inwards_by_its_curvature_whichever_side_is_solid) {
  constexpr double h_m = 1e-3, radius_m = 20e-3;
  const GridGeometry g{{61, 61, 61}, h_m * Mat3::identity(), {-30e-3, -30e-3, -30e-3}};
  const double shift_m = h_m * h_m * (2.0 / radius_m) / 6.0;
  for (const double sign : {1.0, -1.0}) {
    const FieldPtr smooth =
        smooth_grid_field(g, voxels_of(values_of<double>(g, [&](const Vec3& x) { return sign * (radius_m - norm(x)); })));
    EXPECT_LT(distances(*smooth, radius_m, radius_m - shift_m, 2000).back(), 0.03 * shift_m) << sign;
  }
}

TEST(Level, of_a_sphere_in_12_bits_lies_where_the_filters_promise) {
  // Voxels of 1 mm, 12 bits over an edge of ±3 voxels.
  constexpr double h_m = 1e-3, radius_m = 25.3e-3;
  const GridGeometry g{{65, 65, 65}, h_m * Mat3::identity(), {-31.87e-3, -32.11e-3, -31.95e-3}};
  const auto bits = values_of<float>(g, [&](const Vec3& x) {
    const double ramp = std::clamp((radius_m - norm(x)) / (3.0 * h_m), -1.0, 1.0);
    return std::round(2047.5 + 2047.5 * ramp);
  });
  const FieldPtr plain = grid_field(g, voxels_of(bits), 1.0, -2047.5);
  const double shift_m = h_m * h_m * (2.0 / radius_m) / 6.0;
  const auto p99_m = [&](Filter filter) {
    const std::vector<double> all = distances(*filtered(plain, filter), radius_m, radius_m, 10000);
    return all[all.size() * 99 / 100];
  };
  EXPECT_LT(p99_m(Filter::cubic), 3e-6);
  EXPECT_LT(p99_m(Filter::trilinear), 20e-6);
  EXPECT_LT(p99_m(Filter::smooth), shift_m + 7e-6);
  RecordProperty("cubic_um", std::to_string(1e6 * p99_m(Filter::cubic)));
  RecordProperty("trilinear_um", std::to_string(1e6 * p99_m(Filter::trilinear)));
  RecordProperty("smooth_um", std::to_string(1e6 * p99_m(Filter::smooth)));
}

}  // namespace filter_test
}  // namespace palpa
