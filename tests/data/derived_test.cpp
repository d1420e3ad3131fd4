#include "palpa/data/derived.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>

#include "palpa/data/analytic.h"
#include "palpa/data/sampled.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/timed_field.h"
#include "tests/data/test_fields.h"

namespace palpa {
namespace derived_test {

using namespace test;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

constexpr Derivation all[] = {Derivation::magnitude,   Derivation::gradient_magnitude,
                              Derivation::curl,        Derivation::divergence,
                              Derivation::q,           Derivation::lambda2,
                              Derivation::component_x, Derivation::component_y,
                              Derivation::component_z, Derivation::smooth};

/// Grids of a function of the world position, in double.
FieldPtr scalars(const GridGeometry& g, const std::function<double(const Vec3&)>& value) {
  std::vector<double> values;
  for (std::int64_t k = 0; k < g.dims[2]; ++k)
    for (std::int64_t j = 0; j < g.dims[1]; ++j)
      for (std::int64_t i = 0; i < g.dims[0]; ++i) values.push_back(value(g.to_world({double(i), double(j), double(k)})));
  return grid_field(g, voxels_of(std::move(values)));
}
FieldPtr vectors(const GridGeometry& g, const std::function<Vec3(const Vec3&)>& value) {
  std::vector<double> values;
  for (std::int64_t k = 0; k < g.dims[2]; ++k)
    for (std::int64_t j = 0; j < g.dims[1]; ++j)
      for (std::int64_t i = 0; i < g.dims[0]; ++i) {
        const Vec3 v = value(g.to_world({double(i), double(j), double(k)}));
        values.insert(values.end(), {v.x, v.y, v.z});
      }
  return grid_field(g, voxels_of(std::move(values), 3));
}

const Mat3 skew_steps{{{0.011, 0.002, -0.001}, {-0.003, 0.009, 0.002}, {0.001, 0.001, -0.014}}};
const GridGeometry small{{9, 8, 7}, skew_steps, {0.3, -0.2, 0.1}};
/// Wide enough that a Gaussian of 2 spacings does not see the border from the middle.
const GridGeometry wide{{41, 41, 41}, skew_steps, {0.3, -0.2, 0.1}};

Vec3 random_world(std::mt19937& random, const GridGeometry& g, double margin) {
  return g.to_world({uniform(random, margin, double(g.dims[0] - 1) - margin),
                     uniform(random, margin, double(g.dims[1] - 1) - margin),
                     uniform(random, margin, double(g.dims[2] - 1) - margin)});
}

TEST(Derived, names_are_those_of_the_scenes) {
  for (const Derivation d : all) {
    if (d == Derivation::smooth) continue;
    ASSERT_TRUE(derivation_named(name_of(d)).has_value());
    EXPECT_EQ(*derivation_named(name_of(d)), d);
  }
  for (const char* name : {"smooth", "", "Q", "vorticity", "magnitude "})
    EXPECT_FALSE(derivation_named(name).has_value()) << name;
  EXPECT_STREQ(name_of(Derivation::gradient_magnitude), "gradient_magnitude");
}

TEST(Derived, units_say_what_came_out) {
  EXPECT_EQ(unit_of(Derivation::magnitude, "cm/s"), "cm/s");
  EXPECT_EQ(unit_of(Derivation::component_y, "m/s"), "m/s");
  EXPECT_EQ(unit_of(Derivation::smooth, "HU"), "HU");
  EXPECT_EQ(unit_of(Derivation::curl, "m/s"), "1/s");
  EXPECT_EQ(unit_of(Derivation::divergence, "m/s"), "1/s");
  EXPECT_EQ(unit_of(Derivation::q, "m/s"), "1/s²");
  EXPECT_EQ(unit_of(Derivation::lambda2, "m/s"), "1/s²");
  EXPECT_EQ(unit_of(Derivation::gradient_magnitude, "HU"), "HU/m");
  EXPECT_EQ(unit_of(Derivation::curl, "cm/s"), "(cm/s)/m");
  EXPECT_EQ(unit_of(Derivation::q, "cm/s"), "(cm/s)²/m²");
  for (const Derivation d : all) EXPECT_EQ(unit_of(d, ""), "");
}

TEST(Derived, refuses_the_wrong_kind_and_the_wrong_smoothing) {
  const FieldPtr ball = sphere_field().fields[0].field, vortex = lamb_oseen_vortex().fields[0].field;
  for (const Derivation d : all) {
    EXPECT_THROW(derived(d, components_taken(d) == 3 ? ball : vortex), std::invalid_argument);
    EXPECT_THROW(derived(d, nullptr), std::invalid_argument);
    const FieldPtr right = components_taken(d) == 3 ? vortex : ball;
    for (const double bad : {-1.0, nan, std::numeric_limits<double>::infinity()}) {
      EXPECT_THROW(derived(d, right, bad), std::invalid_argument);
    }
  }
}

TEST(Derived, magnitude_and_components_have_the_derivative_of_the_interpolant) {
  std::mt19937 random(1);
  const FieldPtr formula = burgers_vortex().fields[0].field;
  const FieldPtr grid = grid_of_doubles(*formula, 12);
  const Similarity pose{rotation(random), 1.7, {0.1, -0.2, 0.3}};
  for (const FieldPtr& of : {formula, grid, posed(formula, pose), posed(grid, pose)}) {
    const FieldPtr magnitude = derived(Derivation::magnitude, of);
    const FieldPtr parts[3] = {derived(Derivation::component_x, of), derived(Derivation::component_y, of),
                               derived(Derivation::component_z, of)};
    EXPECT_NEAR(magnitude->spacing_m(), of->spacing_m(), 1e-15);
    EXPECT_LT(norm(magnitude->bounds_m().low_m - of->bounds_m().low_m), 1e-12);
    const ValueRange range = magnitude->value_ranges()[0];
    for (int n = 0; n < 500; ++n) {
      const Vec3 x = within(random, of->bounds_m());
      const VectorSample u = of->vector(x);
      const ScalarSample s = magnitude->scalar(x);
      ASSERT_EQ(s.inside, u.inside);
      EXPECT_NEAR(magnitude->depth_m(x), of->depth_m(x), 1e-12);
      if (!u.inside) {
        for (const FieldPtr& part : parts) expect_outside_and_finite(*part, x);
        continue;
      }
      EXPECT_NEAR(s.value, norm(u.value), 1e-13);
      EXPECT_LE(s.value, range.max + 1e-12);
      EXPECT_EQ(parts[0]->scalar(x).value, u.value.x);
      EXPECT_EQ(parts[1]->scalar(x).value, u.value.y);
      EXPECT_EQ(parts[2]->scalar(x).value, u.value.z);
      for (int a = 0; a < 3; ++a) EXPECT_EQ(parts[a]->scalar(x).gradient, u.jacobian.row[a]);
      // Along each axis: the slope of |u|, away from its kink and from the faces of cells.
      const double h = 1e-7;
      if (of->depth_m(x) < 2.0 * h || norm(u.value) < 1e-3) continue;
      if (largest_difference(of->vector(x + Vec3{h, h, h}).jacobian, of->vector(x - Vec3{h, h, h}).jacobian) > 1e-2) continue;
      EXPECT_LT(norm(s.gradient - numeric_gradient(*magnitude, x, 0.4 * h)), 2e-3 * (1.0 + norm(s.gradient)));
    }
    for (const Vec3& at : absurd_positions()) expect_outside_and_finite(*magnitude, at);
  }
  EXPECT_EQ(derived(Derivation::magnitude, formula)->scalar({}).value, 0.0);
  EXPECT_EQ(derived(Derivation::magnitude, formula)->scalar({}).gradient, Vec3{});
}

TEST(Derived, magnitude_of_a_grid_ranges_over_its_voxels) {
  const FieldPtr grid =
      grid_field({{2, 1, 1}, Mat3::identity(), {}}, voxels_of(std::vector<float>{3, 4, 0, float(nan), 1, 1}, 3));
  EXPECT_EQ(derived(Derivation::magnitude, grid)->value_ranges()[0].min, 5.0);
  EXPECT_EQ(derived(Derivation::magnitude, grid)->value_ranges()[0].max, 5.0);
}

TEST(Derived, linear_fields_are_exact_up_to_the_border) {
  std::mt19937 random(2);
  const Mat3 j{{{1, 2, -3}, {0.5, -1.5, 2}, {4, 0.25, 3}}};
  const FieldPtr flow = vectors(small, [&](const Vec3& x) { return j * x + Vec3{100, 200, -300}; });
  const FieldPtr slope = scalars(small, [&](const Vec3& x) { return dot({3, -4, 12}, x) + 1e4; });
  const FieldPtr curl = derived(Derivation::curl, flow), divergence = derived(Derivation::divergence, flow);
  const FieldPtr steepness = derived(Derivation::gradient_magnitude, slope);
  for (int n = 0; n < 500; ++n) {
    const Vec3 x = random_world(random, small, 0.0);
    ASSERT_TRUE(curl->vector(x).inside && divergence->scalar(x).inside && steepness->scalar(x).inside);
    EXPECT_LT(norm(curl->vector(x).value - Vec3{0.25 - 2, -3 - 4, 0.5 - 2}), 1e-4);
    EXPECT_NEAR(divergence->scalar(x).value, 1 - 1.5 + 3, 1e-4);
    EXPECT_NEAR(steepness->scalar(x).value, 13.0, 1e-4);  // floats per voxel step: 1e-7 of 0.1
    EXPECT_LT(norm(steepness->scalar(x).gradient), 1e-2);
  }
}

TEST(Derived, solid_rotation_is_a_vortex_and_pure_strain_is_none) {
  std::mt19937 random(3);
  const Vec3 rate{2, -1, 3};  // Ω
  const FieldPtr turning = vectors(wide, [&](const Vec3& x) { return cross(rate, x); });
  const FieldPtr q = derived(Derivation::q, turning), lambda2 = derived(Derivation::lambda2, turning);
  const FieldPtr curl = derived(Derivation::curl, turning);
  const Mat3 strain{{{1, 0.5, 0}, {0.5, -2, 0.25}, {0, 0.25, 1}}};
  const FieldPtr straining = vectors(wide, [&](const Vec3& x) { return strain * x; });
  const FieldPtr q_strain = derived(Derivation::q, straining), lambda2_strain = derived(Derivation::lambda2, straining);
  double s2 = 0.0;
  for (const Vec3& row : strain.row) s2 += norm_squared(row);
  for (int n = 0; n < 200; ++n) {
    const Vec3 x = random_world(random, wide, 14.0);
    EXPECT_LT(norm(curl->vector(x).value - 2.0 * rate), 1e-4);
    EXPECT_NEAR(q->scalar(x).value, norm_squared(rate), 1e-3);
    EXPECT_NEAR(lambda2->scalar(x).value, -norm_squared(rate), 1e-3);
    EXPECT_NEAR(q_strain->scalar(x).value, -0.5 * s2, 1e-3);
    EXPECT_GT(lambda2_strain->scalar(x).value, 0.0);
  }
}

Mat3 symmetric_part(const Mat3& m) {
  Mat3 half = 0.5 * m;
  const Mat3 other = 0.5 * transposed(m);
  for (int i = 0; i < 3; ++i) half.row[i] += other.row[i];
  return half;
}

/// How many eigenvalues of a symmetric matrix are below `t`: the negative pivots of its elimination (Sylvester).
int eigenvalues_below(const Mat3& m, double t) {
  const auto [xx, xy, xz] = m.row[0];
  const double first = xx - t;
  const double yy = m.row[1].y - t - xy * xy / first, yz = m.row[1].z - xy * xz / first;
  const double last = m.row[2].z - t - xz * xz / first - yz * yz / yy;
  return (first < 0.0) + (yy < 0.0) + (last < 0.0);
}

TEST(Derived, lambda2_is_the_middle_eigenvalue) {
  std::mt19937 random(8);
  for (int n = 0; n < 40; ++n) {
    Mat3 j;
    for (Vec3& row : j.row) row = {uniform(random, -3, 3), uniform(random, -3, 3), uniform(random, -3, 3)};
    if (n % 4 == 1) j = symmetric_part(j);                                      // strain only
    if (n % 4 == 2) j = {{{0, 0, 0}, {j.row[0].x, 0, 0}, {0, 0, j.row[2].z}}};  // shear
    if (n % 4 == 3) j = {{{j.row[0].x, 0, 0}, {0, j.row[0].x, 0}, j.row[2]}};   // two eigenvalues close together
    const FieldPtr lambda2 = derived(Derivation::lambda2, vectors(wide, [&](const Vec3& x) { return j * x; }));
    const Mat3 m = symmetric_part(j * j);
    double size = 0.0;
    for (const Vec3& row : j.row) size += norm_squared(row);
    const double value = lambda2->scalar(random_world(random, wide, 18.0)).value, tolerance = 1e-5 * size;
    EXPECT_LE(eigenvalues_below(m, value - tolerance), 1) << n;
    EXPECT_GE(eigenvalues_below(m, value + tolerance), 2) << n;
  }
}

TEST(Derived, smoothing_adds_half_its_variance_times_the_curvature) {
  std::mt19937 random(4);
  const GridGeometry g{{41, 31, 25}, {{{1e-3, 0, 0}, {0, 1.5e-3, 0}, {0, 0, 2e-3}}}, {-0.02, -0.02, -0.02}};
  const Vec3 curvature{2e3, -1e3, 3e3};
  const FieldPtr bowl = scalars(g, [&](const Vec3& x) {
    return 0.5 * (curvature.x * x.x * x.x + curvature.y * x.y * x.y + curvature.z * x.z * x.z) + 5.0;
  });
  for (const double sigma_m : {0.0, 2.5e-3}) {
    const FieldPtr smooth = derived(Derivation::smooth, bowl, sigma_m);
    const double used_m = sigma_m > 0.0 ? sigma_m : 2e-3;  // two spacings
    const Vec3 spline{1e-6 / 6.0, 2.25e-6 / 6.0, 4e-6 / 6.0};
    const double rise = 0.5 * used_m * used_m * (curvature.x + curvature.y + curvature.z) + dot(curvature, spline);
    for (int n = 0; n < 200; ++n) {
      const Vec3 x = random_world(random, g, 11.0);
      const double value = 0.5 * (curvature.x * x.x * x.x + curvature.y * x.y * x.y + curvature.z * x.z * x.z) + 5.0;
      EXPECT_NEAR(smooth->scalar(x).value - value, rise, 3e-3 * rise);  // the Gaussian ends at 4 sigma
      EXPECT_LT(norm(smooth->scalar(x).gradient - Vec3{curvature.x * x.x, curvature.y * x.y, curvature.z * x.z}), 1e-2);
      EXPECT_LT(largest_difference(smooth->hessian(x), {{{curvature.x, 0, 0}, {0, curvature.y, 0}, {0, 0, curvature.z}}}),
                10.0);
    }
  }
}

TEST(Derived, curl_converges_with_the_square_of_the_spacing) {
  std::mt19937 random(5);
  const FieldPtr vortex = lamb_oseen_vortex(0.02, 0.01).fields[0].field;
  std::vector<Vec3> places;
  for (int n = 0; n < 300; ++n) places.push_back(0.3 * within(random, vortex->bounds_m()));
  double error[3];
  for (int n = 0; n < 3; ++n) {
    const FieldPtr curl = derived(Derivation::curl, grid_of_doubles(*vortex, (24 << n) + 1));
    error[n] = 0.0;
    for (const Vec3& x : places) {
      const double r2 = (x.x * x.x + x.y * x.y) / 1e-4;
      const double exact = 0.02 / (std::numbers::pi * 1e-4) * std::exp(-r2);
      error[n] = std::max(error[n], norm(curl->vector(x).value - Vec3{0, 0, exact}));
    }
  }
  EXPECT_NEAR(std::log2(error[1] / error[2]), 2.0, 0.25);
  EXPECT_GT(error[0], error[1]);
}

TEST(Derived, derivatives_of_what_is_derived_are_those_of_its_value) {
  std::mt19937 random(6);
  const FieldPtr vortex = grid_of_doubles(*burgers_vortex().fields[0].field, 25);
  const FieldPtr head = sampled(*head_phantom().fields[0].field, 40);
  for (const Derivation d : {Derivation::divergence, Derivation::q, Derivation::lambda2, Derivation::gradient_magnitude,
                             Derivation::smooth, Derivation::curl}) {
    const FieldPtr field = derived(d, components_taken(d) == 3 ? vortex : head);
    const Box box = field->bounds_m();
    const ValueRange range = field->value_ranges()[0];
    const double size = std::max(std::abs(range.min), std::abs(range.max)), h = 1e-3 * field->spacing_m();
    for (int n = 0; n < 200; ++n) {
      const Vec3 x = box.centre_m() + 0.99 * (within(random, box) - box.centre_m());
      if (d == Derivation::curl) {
        EXPECT_LT(largest_difference(field->vector(x).jacobian, numeric_jacobian(*field, x, h)),
                  1e-6 * 300.0 / field->spacing_m());
        continue;
      }
      EXPECT_LT(norm(field->scalar(x).gradient - numeric_gradient(*field, x, h)), 1e-6 * size / field->spacing_m())
          << name_of(d);
      const Mat3 hessian = field->hessian(x);
      for (int a = 0; a < 3; ++a) {
        const Vec3 bend = (field->scalar(x + h * axis(a)).gradient - field->scalar(x - h * axis(a)).gradient) / (2.0 * h);
        EXPECT_LT(norm(hessian.row[a] - bend), 1e-2 * size / (field->spacing_m() * field->spacing_m())) << name_of(d);
      }
    }
  }
}

TEST(Derived, hessian_of_any_field_is_finite_symmetric_and_right_where_it_is_smooth) {
  std::mt19937 random(7);
  const FieldPtr ball = sphere_field(0.05).fields[0].field;
  const Similarity pose{rotation(random), 3.0, {1, 2, 3}};
  const FieldPtr moved = posed(ball, pose);
  for (int n = 0; n < 500; ++n) {
    const Vec3 x = within(random, ball->bounds_m());
    const double r = norm(x);
    if (r < 0.02) continue;
    Mat3 exact;  // of −|x|
    const double c[3] = {x.x / r, x.y / r, x.z / r};
    for (int a = 0; a < 3; ++a) exact.row[a] = -1.0 / r * (axis(a) - c[a] * (x / r));
    const Mat3 h = ball->hessian(x);
    EXPECT_TRUE(ball->depth_m(x) <= ball->spacing_m() || largest_difference(h, exact) < 1e-2 / r);
    EXPECT_LT(largest_difference(h, transposed(h)), 1e-9);
    const Mat3 turned = moved->hessian(pose.to_world(x));
    EXPECT_LT(largest_difference(9.0 * turned, pose.rotation * h * transposed(pose.rotation)), 1e-3);
  }
  EXPECT_EQ(ball->hessian({1, 0, 0}), Mat3{});
  EXPECT_EQ(lamb_oseen_vortex().fields[0].field->hessian({}), Mat3{});
  for (const Vec3& at : absurd_positions()) EXPECT_EQ(ball->hessian(at), Mat3{});
}

TEST(Derived, of_a_posed_field_is_that_of_the_grid_laid_there) {
  std::mt19937 random(8);
  const GridGeometry g{{23, 21, 25}, {{{0.9e-3, 1e-4, 0}, {0, 1.1e-3, 0}, {2e-4, 0, 1e-3}}}, {-0.01, -0.01, -0.012}};
  const auto flow = [](const Vec3& x) {
    return Vec3{std::sin(300 * x.y + 150 * x.x) + x.z * 20, std::cos(250 * x.z) - x.x * 30, std::sin(200 * x.x + 100 * x.y)};
  };
  const auto value = [](const Vec3& x) { return std::sin(250 * x.x) * std::cos(200 * x.y) + 100 * x.z; };
  const Similarity pose{rotation(random), 2.5, {0.4, -0.5, 0.6}};
  // The same voxels, laid into the world by their geometry, vectors turned.
  const GridGeometry laid{g.dims, pose.scale * (pose.rotation * g.index_to_world_m), pose.to_world(g.origin_m)};
  const FieldPtr posed_flow = posed(vectors(g, flow), pose), posed_value = posed(scalars(g, value), pose);
  const FieldPtr laid_flow = vectors(laid, [&](const Vec3& x) { return pose.rotation * flow(pose.to_hand(x)); });
  const FieldPtr laid_value = scalars(laid, [&](const Vec3& x) { return value(pose.to_hand(x)); });
  for (const Derivation d : all) {
    for (const double smoothing_m : {0.0, 4e-3}) {
      const bool of_vector = components_taken(d) == 3;
      const FieldPtr a = derived(d, of_vector ? posed_flow : posed_value, smoothing_m);
      const FieldPtr b = derived(d, of_vector ? laid_flow : laid_value, smoothing_m);
      EXPECT_NEAR(a->spacing_m(), b->spacing_m(), 1e-15);
      double largest = 0.0, size = 0.0;
      for (const ValueRange& e : b->value_ranges()) size = std::max({size, std::abs(e.min), std::abs(e.max)});
      for (int n = 0; n < 300; ++n) {
        const Vec3 x = random_world(random, laid, 0.01);
        const ScalarSample s = a->scalar(x), t = b->scalar(x);
        const VectorSample v = a->vector(x), w = b->vector(x);
        ASSERT_EQ(s.inside, t.inside);
        ASSERT_EQ(v.inside, w.inside);
        largest = std::max({largest, std::abs(t.value), norm(w.value)});
        EXPECT_NEAR(s.value, t.value, 1e-5 * size) << name_of(d);
        EXPECT_LT(norm(v.value - w.value), 1e-5 * size) << name_of(d);
        EXPECT_LT(norm(s.gradient - t.gradient), 2e-5 * size / a->spacing_m()) << name_of(d);
      }
      EXPECT_GT(largest, 0.1 * size) << name_of(d);
    }
  }
}

TEST(Derived, scaling_a_grid_by_a_power_of_two_changes_only_exponents) {
  std::mt19937 random(9);
  const auto flow = [](const Vec3& x) { return Vec3{std::sin(30 * x.y), std::cos(25 * x.z), std::sin(20 * x.x)}; };
  const FieldPtr plain = vectors(wide, flow);
  for (const int exponent : {-30, -3, 20}) {
    const double f = std::ldexp(1.0, exponent);
    const GridGeometry scaled{wide.dims, f * wide.index_to_world_m, f * wide.origin_m};
    const FieldPtr large = vectors(scaled, [&](const Vec3& x) { return flow(x / f); });
    const FieldPtr q = derived(Derivation::q, plain), q_large = derived(Derivation::q, large);
    for (int n = 0; n < 200; ++n) {
      const Vec3 x = random_world(random, wide, 0.1);
      EXPECT_EQ(q->scalar(x).value, f * f * q_large->scalar(f * x).value);
      EXPECT_EQ(q->scalar(x).gradient, f * f * f * q_large->scalar(f * x).gradient);
    }
  }
}

TEST(Derived, neither_an_offset_nor_the_unit_costs_digits) {
  std::mt19937 random(10);
  const auto flow = [](const Vec3& x) { return Vec3{std::sin(30 * x.y), std::cos(25 * x.z), std::sin(20 * x.x)}; };
  const FieldPtr q = derived(Derivation::q, vectors(wide, flow));
  const double size = q->value_ranges()[0].max;
  const FieldPtr far = derived(Derivation::q, vectors(wide, [&](const Vec3& x) { return flow(x) + Vec3{1e6, -1e6, 1e5}; }));
  const FieldPtr tiny = derived(Derivation::q, vectors(wide, [&](const Vec3& x) { return 1e-30 * flow(x); }));
  const FieldPtr huge = derived(Derivation::q, vectors(wide, [&](const Vec3& x) { return 1e40 * flow(x); }));
  for (int n = 0; n < 300; ++n) {
    const Vec3 x = random_world(random, wide, 0.1);
    const double value = q->scalar(x).value;
    EXPECT_NEAR(far->scalar(x).value, value, 1e-5 * size);
    EXPECT_NEAR(tiny->scalar(x).value / 1e-60, value, 1e-5 * size);
    EXPECT_NEAR(huge->scalar(x).value / 1e80, value, 1e-5 * size);
  }
}

/// Middle eigenvalue of (m + mᵀ)/2 by Jacobi's rotations.
double middle_of_symmetric_part(const Mat3& m) {
  const Mat3 t = transposed(m);
  double a[3][3];
  for (int i = 0; i < 3; ++i) {
    const Vec3 row = 0.5 * (m.row[i] + t.row[i]);
    a[i][0] = row.x, a[i][1] = row.y, a[i][2] = row.z;
  }
  for (int sweep = 0; sweep < 30; ++sweep) {
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        const double angle = 0.5 * std::atan2(2.0 * a[p][q], a[q][q] - a[p][p]);
        const double c = std::cos(angle), s = std::sin(angle);
        for (auto& row : a) {
          const double x = row[p], y = row[q];
          row[p] = c * x - s * y, row[q] = s * x + c * y;
        }
        for (int k = 0; k < 3; ++k) {
          const double x = a[p][k], y = a[q][k];
          a[p][k] = c * x - s * y, a[q][k] = s * x + c * y;
        }
      }
    }
  }
  double values[3] = {a[0][0], a[1][1], a[2][2]};
  std::sort(values, values + 3);
  return values[1];
}

/// What the header promises, in the plainest way and in double: Gaussian over the finite voxels within reach, then
/// differences; NaN where the voxel is.
struct Reference {
  GridGeometry g;
  std::vector<Vec3> u;

  std::int64_t at(std::int64_t i, std::int64_t j, std::int64_t k) const { return (k * g.dims[1] + j) * g.dims[0] + i; }

  std::vector<Vec3> smoothed(double sigma_m) const {
    const Mat3 steps = transposed(g.index_to_world_m);
    double sigma[3];
    for (int a = 0; a < 3; ++a) sigma[a] = sigma_m / norm(steps.row[a]);
    std::vector<Vec3> out(u.size(), Vec3{nan, nan, nan});
    for (std::int64_t k = 0; k < g.dims[2]; ++k)
      for (std::int64_t j = 0; j < g.dims[1]; ++j)
        for (std::int64_t i = 0; i < g.dims[0]; ++i) {
          if (!is_finite(u[at(i, j, k)])) continue;
          Vec3 sum;
          double total = 0.0;
          for (std::int64_t n = 0; n < g.dims[2]; ++n)
            for (std::int64_t m = 0; m < g.dims[1]; ++m)
              for (std::int64_t l = 0; l < g.dims[0]; ++l) {
                const double d[3] = {double(l - i) / sigma[0], double(m - j) / sigma[1], double(n - k) / sigma[2]};
                if (!is_finite(u[at(l, m, n)])) continue;
                const double w = std::exp(-0.5 * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
                sum += w * u[at(l, m, n)];
                total += w;
              }
          out[at(i, j, k)] = sum / total;
        }
    return out;
  }

  /// Jacobian at a voxel; false where it is not defined.
  bool jacobian(const std::vector<Vec3>& v, std::int64_t i, std::int64_t j, std::int64_t k, Mat3& out) const {
    const Vec3 here = v[at(i, j, k)];
    if (!is_finite(here)) return false;
    Mat3 along;  // row = axis of the grid
    for (int a = 0; a < 3; ++a) {
      const auto beside = [&](int step) {
        std::int64_t other[3] = {i, j, k};
        other[a] += step;
        if (other[a] < 0 || other[a] >= g.dims[a]) return Vec3{nan, nan, nan};
        return v[at(other[0], other[1], other[2])];
      };
      const Vec3 low = beside(-1), high = beside(1);
      if (g.dims[a] == 1) continue;
      if (is_finite(low) && is_finite(high)) {
        along.row[a] = 0.5 * (high - low);
      } else if (is_finite(high)) {
        along.row[a] = high - here;
      } else if (is_finite(low)) {
        along.row[a] = here - low;
      } else {
        return false;
      }
    }
    out = transposed(along) * inverse(g.index_to_world_m);
    return true;
  }
};

TEST(Derived, q_and_curl_agree_with_a_plain_reference_gaps_and_all) {
  std::mt19937 random(11);
  const Mat3 steps{{{1e-3, 2e-4, 0}, {0, 1.6e-3, 1e-4}, {0, 0, 2.2e-3}}};
  for (const std::array<std::int64_t, 3> dims : {std::array<std::int64_t, 3>{13, 11, 9}, {12, 1, 6}, {3, 2, 15}, {2, 2, 1}}) {
    for (const double gap_share : {0.0, 0.1, 0.5}) {
      Reference reference{{dims, steps, {}}, {}};
      std::vector<float> values;
      for (std::int64_t n = 0; n < reference.g.voxels(); ++n) {
        float v[3];
        for (float& c : v) c = static_cast<float>(uniform(random, -1, 1));
        if (uniform(random, 0, 1) < gap_share) v[random() % 3] = static_cast<float>(nan);
        reference.u.push_back({v[0], v[1], v[2]});
        values.insert(values.end(), v, v + 3);
      }
      const FieldPtr source = grid_field(reference.g, voxels_of(std::move(values), 3));
      const double sigma_m = 2e-3;
      const std::vector<Vec3> smoothed = reference.smoothed(sigma_m);
      for (const Derivation d : {Derivation::q, Derivation::lambda2, Derivation::curl}) {
        const FieldPtr field = derived(d, source, sigma_m);
        const GridView& found = *smooth_grid_of(*field);
        const auto* raw = static_cast<const float*>(found.voxels.data.get());
        for (std::int64_t k = 0; k < dims[2]; ++k)
          for (std::int64_t j = 0; j < dims[1]; ++j)
            for (std::int64_t i = 0; i < dims[0]; ++i) {
              Mat3 jac;
              const std::int64_t at = reference.at(i, j, k);
              const bool defined = reference.jacobian(d == Derivation::curl ? reference.u : smoothed, i, j, k, jac);
              if (d == Derivation::curl) {
                const Vec3 curl{jac.row[2].y - jac.row[1].z, jac.row[0].z - jac.row[2].x, jac.row[1].x - jac.row[0].y};
                const Vec3 is{raw[3 * at] * found.scale, raw[3 * at + 1] * found.scale, raw[3 * at + 2] * found.scale};
                ASSERT_EQ(is_finite(is), defined);
                EXPECT_TRUE(!defined || norm(is - curl) < 1e-3);
                continue;
              }
              const double is = raw[at] * found.scale + found.offset;
              ASSERT_EQ(std::isfinite(is), defined);
              if (!defined) continue;
              const Mat3 j2 = jac * jac;
              const double q = -0.5 * (j2.row[0].x + j2.row[1].y + j2.row[2].z);
              double j_norm = 0.0;
              for (const Vec3& row : jac.row) j_norm += norm_squared(row);
              if (d == Derivation::q) {
                EXPECT_NEAR(is, q, 2e-3 * j_norm + 1e-9);  // the Gaussian ends at 4 sigma
              } else {
                EXPECT_NEAR(is, middle_of_symmetric_part(j2), 4e-3 * j_norm + 1e-9);
              }
            }
      }
    }
  }
}

TEST(Derived, gaps_stay_gaps_and_smoothing_is_normalised_over_the_rest) {
  std::mt19937 random(12);
  const GridGeometry g{{15, 15, 15}, 1e-3 * Mat3::identity(), {}};
  const auto in_gap = [](const Vec3& x) { return x.x > 9.5e-3 || norm(x - Vec3{4e-3, 4e-3, 4e-3}) < 0.5e-3; };
  const FieldPtr constant = scalars(g, [&](const Vec3& x) { return in_gap(x) ? nan : 42.0; });
  const FieldPtr smooth = derived(Derivation::smooth, constant);
  const GridView& found = *smooth_grid_of(*smooth);
  const auto* raw = static_cast<const float*>(found.voxels.data.get());
  for (std::int64_t k = 0; k < 15; ++k)
    for (std::int64_t j = 0; j < 15; ++j)
      for (std::int64_t i = 0; i < 15; ++i) {
        const double is = raw[(k * 15 + j) * 15 + i] * found.scale + found.offset;
        if (in_gap(g.to_world({double(i), double(j), double(k)}))) {
          EXPECT_TRUE(std::isnan(is));
        } else {
          EXPECT_NEAR(is, 42.0, 1e-5);
        }
      }
  EXPECT_FALSE(smooth->scalar({4e-3, 4e-3, 4e-3}).inside);
  EXPECT_TRUE(smooth->scalar({7.5e-3, 8e-3, 8e-3}).inside);
  const FieldPtr nothing = scalars(g, [](const Vec3&) { return nan; });
  for (const Derivation d : {Derivation::smooth, Derivation::gradient_magnitude}) {
    const FieldPtr none = derived(d, nothing);
    for (int n = 0; n < 100; ++n) expect_outside_and_finite(*posed(none, {}), {-1, 0, 0});
    EXPECT_FALSE(none->scalar({7e-3, 7e-3, 7e-3}).inside);
  }
}

TEST(Derived, a_mark_for_no_data_spoils_only_its_neighbourhood) {
  const GridGeometry g{{40, 40, 40}, 1e-3 * Mat3::identity(), {}};
  const auto flow = [](const Vec3& x) { return Vec3{std::sin(300 * x.y), std::cos(250 * x.z), std::sin(200 * x.x)}; };
  const FieldPtr clean = derived(Derivation::q, vectors(g, flow));
  const FieldPtr marked = derived(Derivation::q, vectors(g, [&](const Vec3& x) {
                                    return norm(x) < 4e-3 ? Vec3{-9.97e36, -9.97e36, -9.97e36} : flow(x);
                                  }));
  std::mt19937 random(13);
  for (int n = 0; n < 300; ++n) {
    const Vec3 x = within(random, {{20e-3, 20e-3, 20e-3}, {38e-3, 38e-3, 38e-3}});
    EXPECT_NEAR(marked->scalar(x).value, clean->scalar(x).value, 1e-4 * clean->value_ranges()[0].max);
  }
  for (int n = 0; n < 1000; ++n) {
    const ScalarSample s = marked->scalar(within(random, g.dims[0] ? marked->bounds_m() : Box{}));
    EXPECT_TRUE(std::isfinite(s.value) && is_finite(s.gradient));
  }
}

TEST(Derived, of_a_formula_is_that_of_its_samples) {
  std::mt19937 random(14);
  const FieldPtr vortex = lamb_oseen_vortex().fields[0].field;
  const FieldPtr q = derived(Derivation::q, vortex), by_samples = derived(Derivation::q, sampled(*vortex, 97));
  EXPECT_NEAR(q->spacing_m(), vortex->spacing_m(), 1e-12);
  for (int n = 0; n < 300; ++n) {
    const Vec3 x = 0.9 * within(random, vortex->bounds_m());
    ASSERT_TRUE(q->scalar(x).inside);
    EXPECT_NEAR(q->scalar(x).value, by_samples->scalar(x).value, 1e-4 * q->value_ranges()[0].max);
  }
  // And of what was derived: the curl of a curl of a flow without divergence is minus its Laplacian.
  const FieldPtr twice = derived(Derivation::curl, derived(Derivation::curl, vortex));
  EXPECT_EQ(smooth_grid_of(*twice)->geometry.dims[0], 97);
  const FieldPtr steepness = derived(Derivation::gradient_magnitude, derived(Derivation::magnitude, sampled(*vortex, 49)));
  EXPECT_EQ(smooth_grid_of(*steepness)->geometry.dims[0], 49);
}

TEST(Derived, signs_tell_a_vortex_core_from_its_surroundings) {
  const FieldPtr vortex = sampled(*lamb_oseen_vortex(0.02, 0.01).fields[0].field, 97);
  const FieldPtr q = derived(Derivation::q, vortex), lambda2 = derived(Derivation::lambda2, vortex);
  for (const double angle : {0.0, 1.0, 2.5, 4.0}) {
    for (const double z : {-0.02, 0.0, 0.03}) {
      const auto at = [&](double r) { return Vec3{r * std::cos(angle), r * std::sin(angle), z}; };
      for (const double r : {0.0, 0.004, 0.008}) {
        EXPECT_GT(q->scalar(at(r)).value, 0.0);
        EXPECT_LT(lambda2->scalar(at(r)).value, 0.0);
      }
      for (const double r : {0.018, 0.025, 0.04}) {
        EXPECT_LT(q->scalar(at(r)).value, 0.0);
        EXPECT_GT(lambda2->scalar(at(r)).value, 0.0);
      }
    }
  }
}

/// Findings 9: sampled vortices with cores of 3 voxels and more, across any grid, with a uniform flow across
/// them or not: ∇Q points to the core within 2° at p99, wherever Q is above 5 % of its largest and r >= 0.3 r_c.
TEST(Derived, gradient_of_q_points_to_the_core_of_a_vortex) {
  std::mt19937 random(15);
  constexpr double core_m = 0.01, rate_per_s = 30.0;
  double worst = 0.0;
  for (const double voxels_per_core : {3.0, 4.0, 6.0}) {
    for (const double strain_per_s : {0.0, 0.05 * rate_per_s}) {
      for (const double cross_flow : {0.0, 0.5, 1.0}) {
        for (int orientation = 0; orientation < 3; ++orientation) {
          const Mat3 turn = orientation == 0 ? Mat3::identity() : rotation(random);  // grid → vortex
          const double step_m = core_m / voxels_per_core;
          const auto n = static_cast<std::int64_t>(2.0 * std::ceil(4.5 * voxels_per_core)) + 1;
          const Vec3 shift{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
          const GridGeometry g{
              {n, n, n}, step_m * turn, turn * (-0.5 * step_m * (Vec3{double(n - 1), double(n - 1), double(n - 1)} + shift))};
          const Vec3 across = cross_flow * 0.6382 * rate_per_s * core_m *
                              normalized({uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)});
          const FieldPtr flow = vectors(g, [&](const Vec3& x) {
            const double s = (x.x * x.x + x.y * x.y) / (core_m * core_m);
            const double w = rate_per_s * (s > 1e-12 ? -std::expm1(-s) / s : 1.0);
            return Vec3{-w * x.y - 0.5 * strain_per_s * x.x, w * x.x - 0.5 * strain_per_s * x.y, strain_per_s * x.z} + across;
          });
          const FieldPtr q = derived(Derivation::q, flow);
          const double largest = q->value_ranges()[0].max;
          std::vector<double> angles;
          for (int m = 0; m < 4000; ++m) {
            const double r = uniform(random, 0.3, 2.0) * core_m, angle = uniform(random, 0, 2.0 * std::numbers::pi);
            const Vec3 x{r * std::cos(angle), r * std::sin(angle), uniform(random, -1, 1) * core_m};
            const ScalarSample s = q->scalar(x);
            if (!s.inside || s.value < 0.05 * largest) continue;
            const Vec3 to_core{-std::cos(angle), -std::sin(angle), 0.0};
            const Vec3 felt = normalized(s.gradient);
            angles.push_back(std::atan2(norm(cross(felt, to_core)), dot(felt, to_core)) * 180.0 / std::numbers::pi);
          }
          ASSERT_GT(angles.size(), 1000u);
          std::sort(angles.begin(), angles.end());
          const double p99 = angles[angles.size() * 99 / 100];
          worst = std::max(worst, p99);
          EXPECT_LE(p99, 2.0) << voxels_per_core << " voxels, strain " << strain_per_s << ", cross-flow " << cross_flow;
        }
      }
    }
  }
  RecordProperty("worst_p99_deg", std::to_string(worst));
}

}  // namespace derived_test
}  // namespace palpa
