#include "palpa/data/derived.h"

#include <cmath>
#include <stdexcept>

#include "palpa/data/analytic.h"
#include "palpa/data/sampled.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/data/timed_field.h"
#include "tests/data/derived_grids.h"

namespace palpa {
namespace derived_test {

using namespace test;
using namespace test::derived_grids;

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

TEST(Derived, smoothing_adds_half_its_variance_times_the_curvature) {
  std::mt19937 random(4);
  const GridGeometry g{{41, 31, 25}, {{{1e-3, 0, 0}, {0, 1.5e-3, 0}, {0, 0, 2e-3}}}, {-0.02, -0.02, -0.02}};
  const Vec3 curvature{2e3, -1e3, 3e3};
  const FieldPtr bowl = scalars(g, [&](const Vec3& x) {
    return 0.5 * (curvature.x * x.x * x.x + curvature.y * x.y * x.y + curvature.z * x.z * x.z) + 5.0;
  });
  for (const double sigma_m : {0.0, 2.5e-3}) {
    const FieldPtr smooth = derived(Derivation::smooth, bowl, sigma_m);
    const double used_m = sigma_m > 0.0 ? sigma_m : 2e-3;
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
    Mat3 exact;
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
  // The voxels placed into the world by their geometry, with turned vectors.
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
  // Derived twice: the curl of a curl of a flow without divergence is minus its Laplacian.
  const FieldPtr twice = derived(Derivation::curl, derived(Derivation::curl, vortex));
  EXPECT_EQ(smooth_grid_of(*twice)->geometry.dims[0], 97);
  const FieldPtr steepness = derived(Derivation::gradient_magnitude, derived(Derivation::magnitude, sampled(*vortex, 49)));
  EXPECT_EQ(smooth_grid_of(*steepness)->geometry.dims[0], 49);
}

}  // namespace derived_test
}  // namespace palpa
