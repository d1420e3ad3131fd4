// Axis fields: sign-independent bits; a direction and its weight.
#include "palpa/data/axis_grid.h"

#include <cmath>
#include <functional>

#include "palpa/data/analytic.h"
#include "palpa/data/derived.h"
#include "palpa/data/filter.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/volume.h"
#include "tests/data/test_fields.h"

namespace palpa {
namespace axis_grid_test {

using namespace test;

constexpr Filter filters[] = {Filter::trilinear, Filter::smooth};

const GridGeometry sheared{
    {9, 8, 7}, {{{0.011, 0.002, -0.001}, {-0.003, 0.009, 0.002}, {0.001, 0.001, -0.014}}}, {0.3, -0.2, 0.1}};

std::vector<double> values_of(const GridGeometry& g, const std::function<Vec3(const Vec3&)>& value) {
  std::vector<double> values;
  for (std::int64_t k = 0; k < g.dims[2]; ++k)
    for (std::int64_t j = 0; j < g.dims[1]; ++j)
      for (std::int64_t i = 0; i < g.dims[0]; ++i) {
        const Vec3 v = value(g.to_world({double(i), double(j), double(k)}));
        values.insert(values.end(), {v.x, v.y, v.z});
      }
  return values;
}
std::vector<double> random_values(std::mt19937& random, const GridGeometry& g) {
  return values_of(g, [&](const Vec3&) {
    return Vec3{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
  });
}
std::vector<double> with_random_signs(std::mt19937& random, std::vector<double> values) {
  for (std::size_t v = 0; v < values.size(); v += 3) {
    if (random() & 1) continue;
    for (std::size_t c = v; c < v + 3; ++c) values[c] = -values[c];
  }
  return values;
}
Vec3 inside_of(std::mt19937& random, const GridGeometry& g) {
  return g.to_world({uniform(random, 0.0, double(g.dims[0] - 1)), uniform(random, 0.0, double(g.dims[1] - 1)),
                     uniform(random, 0.0, double(g.dims[2] - 1))});
}
/// `v` or −v, nearer to `to`.
Vec3 like(const Vec3& to, const Vec3& v) { return dot(to, v) < 0.0 ? -v : v; }

TEST(AxisGrid, no_bit_depends_on_the_signs_of_voxels) {
  std::mt19937 random(1);
  const std::vector<double> values = random_values(random, sheared);
  for (const Filter filter : filters) {
    const FieldPtr field = axis_grid_field(sheared, voxels_of(values, 3), 2.5, 0.0, filter);
    for (int turn = 0; turn < 5; ++turn) {
      const FieldPtr flipped = axis_grid_field(sheared, voxels_of(with_random_signs(random, values), 3), 2.5, 0.0, filter);
      EXPECT_EQ(field->value_ranges()[0].max, flipped->value_ranges()[0].max);
      for (int n = 0; n < 500; ++n) {
        const Vec3 x = inside_of(random, sheared);
        const VectorSample a = field->vector(x), b = flipped->vector(x);
        ASSERT_EQ(a.inside, b.inside);
        EXPECT_EQ(a.value, b.value);
        EXPECT_EQ(a.jacobian, b.jacobian);
      }
    }
  }
}

TEST(AxisGrid, is_the_vector_field_where_directions_agree) {
  std::mt19937 random(2);
  const Vec3 direction = normalized({0.3, 0.8, -0.5});
  const auto values =
      values_of(sheared, [&](const Vec3& x) { return (2.0 + std::sin(300.0 * x.x) * std::cos(200.0 * x.y)) * direction; });
  const FieldPtr plain[] = {grid_field(sheared, voxels_of(values, 3)), smooth_grid_field(sheared, voxels_of(values, 3))};
  for (int f = 0; f < 2; ++f) {
    const FieldPtr axes = axis_grid_field(sheared, voxels_of(with_random_signs(random, values), 3), 1.0, 0.0, filters[f]);
    const FieldPtr length = derived(Derivation::magnitude, axes);
    for (int n = 0; n < 500; ++n) {
      const Vec3 x = inside_of(random, sheared);
      const VectorSample wanted = plain[f]->vector(x), found = axes->vector(x);
      EXPECT_LT(norm(found.value - wanted.value), 1e-12);
      EXPECT_GT(found.value.y, 0.0);  // the largest component
      EXPECT_LT(largest_difference(found.jacobian, wanted.jacobian), 1e-9);
      EXPECT_NEAR(length->scalar(x).value, norm(wanted.value), 1e-12);
    }
  }
}

TEST(AxisGrid, jacobian_is_the_derivative_of_the_value) {
  std::mt19937 random(3);
  for (const Filter filter : filters) {
    const FieldPtr field = axis_grid_field(sheared, voxels_of(random_values(random, sheared), 3), 1.0, 0.0, filter);
    constexpr double h = 1e-7;
    int compared = 0;
    for (int n = 0; n < 2000; ++n) {
      // Away from faces of cells, where trilinear derivatives jump.
      GridPoint p{std::floor(uniform(random, 0, 8)), std::floor(uniform(random, 0, 7)), std::floor(uniform(random, 0, 6))};
      p = {p.i + uniform(random, 0.01, 0.99), p.j + uniform(random, 0.01, 0.99), p.k + uniform(random, 0.01, 0.99)};
      const Vec3 x = sheared.to_world(p);
      const VectorSample here = field->vector(x);
      ASSERT_TRUE(here.inside);
      if (norm(here.value) < 0.02) continue;  // a difference would step over a closing gap
      ++compared;
      Mat3 columns;
      for (int a = 0; a < 3; ++a) {
        const auto f = [&](double steps) { return like(here.value, field->vector(x + steps * h * axis(a)).value); };
        columns.row[a] = (f(1) - f(-1)) / (2.0 * h);
      }
      const double size = largest_difference(here.jacobian, {});
      EXPECT_LT(largest_difference(here.jacobian, transposed(columns)), 1e-5 * size + 1e-4);
    }
    EXPECT_GT(compared, 1000);
  }
}

TEST(AxisGrid, error_on_directions_that_turn_is_of_second_order) {
  const auto direction = [](const Vec3& x) {
    const double a = 2.0 * x.x + std::sin(1.5 * x.y), b = x.z + 0.5 * x.x * x.y;
    return Vec3{std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b)};
  };
  for (const Filter filter : filters) {
    double before = 0.0;
    for (const int n : {11, 21, 41}) {
      std::mt19937 random(4);
      const double h = 1.0 / (n - 1);
      const GridGeometry g{{n, n, n}, h * Mat3::identity(), {}};
      const FieldPtr field =
          axis_grid_field(g, voxels_of(with_random_signs(random, values_of(g, direction)), 3), 1.0, 0.0, filter);
      double worst = 0.0;
      for (int m = 0; m < 3000; ++m) {
        const Vec3 x = within(random, {{0.25, 0.25, 0.25}, {0.75, 0.75, 0.75}}), wanted = direction(x);
        worst = std::max(worst, norm(like(wanted, field->vector(x).value) - wanted));
      }
      if (before > 0.0) {
        EXPECT_GT(before / worst, 3.4) << n;
        EXPECT_LT(before / worst, 4.6) << n;
      }
      before = worst;
    }
  }
}

TEST(AxisGrid, is_zero_where_no_direction_is_preferred) {
  const GridGeometry g{{2, 1, 1}, Mat3::identity(), {}};
  const FieldPtr crossed = axis_grid_field(g, voxels_of(std::vector<double>{1, 0, 0, 0, 1, 0}, 3));
  const VectorSample middle = crossed->vector({0.5, 0, 0});
  EXPECT_TRUE(middle.inside);
  EXPECT_EQ(middle.value, Vec3{});
  EXPECT_EQ(middle.jacobian, Mat3{});
  // Weights 1 − t and t: the gap is 1 − t/(1 − t).
  EXPECT_LT(norm(crossed->vector({0.25, 0, 0}).value - Vec3{2.0 / 3.0, 0, 0}), 1e-12);
  EXPECT_LT(norm(crossed->vector({0.75, 0, 0}).value - Vec3{0, 2.0 / 3.0, 0}), 1e-12);
  const FieldPtr nothing = axis_grid_field(g, voxels_of(std::vector<double>(6, 0.0), 3));
  EXPECT_TRUE(nothing->vector({0.3, 0, 0}).inside);
  EXPECT_EQ(nothing->vector({0.3, 0, 0}).value, Vec3{});
  EXPECT_EQ(nothing->vector({0.3, 0, 0}).jacobian, Mat3{});
}

TEST(AxisGrid, has_data_where_a_grid_of_its_filter_has_and_is_finite_everywhere) {
  std::mt19937 random(5);
  std::vector<double> values = random_values(random, sheared);
  for (int n = 0; n < 6; ++n) {
    values[random() % values.size()] =
        n % 2 ? std::numeric_limits<double>::quiet_NaN() : std::numeric_limits<double>::infinity();
  }
  const FieldPtr plain[] = {grid_field(sheared, voxels_of(values, 3)), smooth_grid_field(sheared, voxels_of(values, 3))};
  for (int f = 0; f < 2; ++f) {
    const FieldPtr axes = axis_grid_field(sheared, voxels_of(values, 3), 1.0, 0.0, filters[f]);
    EXPECT_EQ(axes->spacing_m(), plain[f]->spacing_m());
    EXPECT_EQ(axes->bounds_m().high_m, plain[f]->bounds_m().high_m);
    const Box around{axes->bounds_m().low_m - Vec3{0.01, 0.01, 0.01}, axes->bounds_m().high_m + Vec3{0.01, 0.01, 0.01}};
    for (int n = 0; n < 5000; ++n) {
      const Vec3 x = within(random, around);
      const VectorSample s = axes->vector(x);
      ASSERT_EQ(s.inside, plain[f]->vector(x).inside);
      EXPECT_FALSE(axes->scalar(x).inside);
      if (!s.inside) {
        EXPECT_EQ(s.value, Vec3{});
        EXPECT_EQ(s.jacobian, Mat3{});
      }
    }
    for (const Vec3& at : absurd_positions()) expect_outside_and_finite(*axes, at);
  }
  // Squares above and below the range of a double, and both together.
  for (const double size : {1e-300, 1e-160, 1.0, 1e150, 1e300}) {
    std::vector<double> extreme = random_values(random, sheared);
    for (double& v : extreme) v *= size * (random() % 4 ? 1.0 : 1e-8);
    const FieldPtr plain_field = axis_grid_field(sheared, voxels_of(extreme, 3));
    for (int n = 0; n < 500; ++n) {
      const VectorSample s = plain_field->vector(inside_of(random, sheared));
      EXPECT_TRUE(is_finite(s.value) && is_finite(s.jacobian));
      if (size <= 1e150) {
        EXPECT_TRUE(s.inside);
      }
    }
  }
}

TEST(AxisGrid, scaling_by_powers_of_two_changes_no_bit_of_a_mantissa) {
  std::mt19937 random(6);
  const std::vector<double> values = random_values(random, sheared);
  const FieldPtr field = axis_grid_field(sheared, voxels_of(values, 3));
  for (const double factor : {0x1p-200, 0x1p-3, 0x1p200}) {
    const FieldPtr scaled = axis_grid_field(sheared, voxels_of(values, 3), factor);
    for (int n = 0; n < 200; ++n) {
      const Vec3 x = inside_of(random, sheared);
      EXPECT_EQ(scaled->vector(x).value, factor * field->vector(x).value);
      EXPECT_EQ(scaled->vector(x).jacobian, factor * field->vector(x).jacobian);
    }
  }
}

TEST(AxisGrid, turns_with_its_data) {
  std::mt19937 random(7);
  const std::vector<double> values = random_values(random, sheared);
  const Mat3 r = rotation(random);
  std::vector<double> turned;
  for (std::size_t v = 0; v < values.size(); v += 3) {
    const Vec3 u = r * Vec3{values[v], values[v + 1], values[v + 2]};
    turned.insert(turned.end(), {u.x, u.y, u.z});
  }
  const GridGeometry g{sheared.dims, r * sheared.index_to_world_m, r * sheared.origin_m};
  for (const Filter filter : filters) {
    const FieldPtr field = axis_grid_field(sheared, voxels_of(values, 3), 1.0, 0.0, filter);
    const FieldPtr other = axis_grid_field(g, voxels_of(turned, 3), 1.0, 0.0, filter);
    for (int n = 0; n < 300; ++n) {
      const Vec3 x = inside_of(random, sheared);
      if (field->depth_m(x) < 1e-6) continue;
      const VectorSample a = field->vector(x), b = other->vector(r * x);
      const double sign = dot(r * a.value, b.value) < 0.0 ? -1.0 : 1.0;
      EXPECT_LT(norm(r * a.value - sign * b.value), 1e-9);
      EXPECT_LT(largest_difference(r * a.jacobian * transposed(r), sign * b.jacobian), 1e-6);
    }
  }
}

TEST(AxisGrid, only_its_magnitude_can_be_derived) {
  std::mt19937 random(8);
  const FieldPtr axes = axis_grid_field(sheared, voxels_of(random_values(random, sheared), 3));
  const FieldPtr moved = posed(axes, {rotation(random), 2.0, {0.1, 0.2, 0.3}});
  EXPECT_TRUE(is_axis_field(*axes));
  EXPECT_TRUE(is_axis_field(*moved));
  EXPECT_FALSE(is_axis_field(*grid_field(sheared, voxels_of(random_values(random, sheared), 3))));
  const FieldPtr length = derived(Derivation::magnitude, moved);
  for (int n = 0; n < 100; ++n) {
    const Vec3 x = within(random, moved->bounds_m());
    EXPECT_NEAR(length->scalar(x).value, norm(moved->vector(x).value), 1e-12);
  }
  for (const FieldPtr& of : {axes, moved}) {
    for (const Derivation d : {Derivation::curl, Derivation::divergence, Derivation::q, Derivation::component_x}) {
      EXPECT_THROW(derived(d, of), std::invalid_argument);
    }
  }
}

TEST(AxisGrid, is_made_of_vector_grids_and_keeps_filter_and_pose) {
  std::mt19937 random(9);
  const Voxels voxels = voxels_of(random_values(random, sheared), 3);
  const Similarity pose{rotation(random), 2.0, {0.1, 0.2, 0.3}};
  const FieldPtr plain = grid_field(sheared, voxels);
  const FieldPtr smooth = signless(posed(smooth_grid_field(sheared, voxels), pose));
  EXPECT_EQ(grid_below(*smooth)->filter, Filter::smooth);
  EXPECT_EQ(grid_below(*smooth)->voxels.data, voxels.data);
  EXPECT_EQ(grid_behind(*signless(cubic_grid_field(sheared, voxels)))->filter, Filter::smooth);
  EXPECT_EQ(grid_behind(*filtered(signless(plain), Filter::smooth))->filter, Filter::smooth);
  EXPECT_TRUE(is_axis_field(*filtered(signless(plain), Filter::smooth)));
  EXPECT_EQ(grid_of(*signless(plain)), nullptr);
  EXPECT_EQ(signless(smooth), smooth);
  EXPECT_THROW(filtered(signless(plain), Filter::cubic), std::invalid_argument);
  EXPECT_THROW(signless(sampled(sphere_field(), 8)), std::invalid_argument);
  EXPECT_THROW(signless(lamb_oseen_vortex().fields[0].field), std::invalid_argument);
  Volume two = sampled(sphere_field(), 8);
  two.fields.push_back({"axes", "", plain});
  const Volume without = signless(two);
  EXPECT_EQ(without.fields[0].field, two.fields[0].field);
  EXPECT_TRUE(is_axis_field(*without.fields[1].field));
}

}  // namespace axis_grid_test
}  // namespace palpa
