#include "palpa/data/analytic.h"

#include <array>
#include <numbers>
#include <set>
#include <stdexcept>
#include <vector>

#include "palpa/data/volume.h"
#include "tests/data/test_fields.h"

namespace palpa {
namespace analytic_test {

using namespace test;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(Analytic, every_volume_is_a_whole_one) {
  std::mt19937 random(1);
  std::set<std::string_view> names;
  for (const AnalyticVolume& a : analytic_volumes()) {
    EXPECT_TRUE(names.insert(a.name).second);
    EXPECT_FALSE(a.sentence.empty());
    const Volume volume = a.make();
    EXPECT_EQ(volume.format, "formula");
    EXPECT_TRUE(volume.files.empty());
    EXPECT_EQ(volume.medical_frame, a.name == "head_phantom");
    ASSERT_EQ(volume.fields.size(), a.name == "ring_vortex" || a.name == "wing_wake" ? 2u : 1u);
    for (const VolumeField& named : volume.fields) {
      EXPECT_FALSE(named.name.empty() || named.unit.empty());
      const Field& field = *named.field;
      EXPECT_GT(field.spacing_m(), 0.0);
      EXPECT_LT(field.spacing_m(), 0.05 * norm(field.bounds_m().size_m()));

      // Data in the box only, within the declared range; depth is the distance to the box.
      const Box box = field.bounds_m();
      const std::vector<ValueRange> range = field.value_ranges();
      ASSERT_EQ(range.size(), static_cast<std::size_t>(field.components()));
      const Box around{box.low_m - 0.3 * box.size_m(), box.high_m + 0.3 * box.size_m()};
      for (int n = 0; n < 20000; ++n) {
        const Vec3 at = within(random, around);
        const Vec3 low = at - box.low_m, high = box.high_m - at;
        const double depth = std::min({low.x, low.y, low.z, high.x, high.y, high.z});
        EXPECT_EQ(field.depth_m(at), depth);
        if (depth < 0.0) {
          expect_outside_and_finite(field, at);
          continue;
        }
        const ScalarSample s = field.scalar(at);
        const VectorSample v = field.vector(at);
        ASSERT_EQ(s.inside, field.components() == 1);
        ASSERT_EQ(v.inside, field.components() == 3);
        const double values[3] = {s.inside ? s.value : v.value.x, v.value.y, v.value.z};
        for (int c = 0; c < field.components(); ++c) {
          EXPECT_GE(values[c], range[c].min - 1e-12 * std::abs(range[c].min));
          EXPECT_LE(values[c], range[c].max + 1e-12 * std::abs(range[c].max));
        }
      }
      for (const Vec3& at : absurd_positions()) expect_outside_and_finite(field, at);
    }
  }
  EXPECT_EQ(names, (std::set<std::string_view>{"plane", "sphere", "bored_block", "head_phantom", "lamb_oseen_vortex",
                                               "burgers_vortex", "ring_vortex", "wing_wake"}));
}

TEST(Analytic, plane_is_depth_below_zero) {
  const FieldPtr plane = plane_field(0.3).fields[0].field;
  const ScalarSample s = plane->scalar({0.1, -0.05, -0.02});
  EXPECT_EQ(s.value, 0.02);
  EXPECT_EQ(s.gradient, (Vec3{0, 0, -1}));
  EXPECT_EQ(plane->bounds_m().size_m(), (Vec3{0.3, 0.3, 0.3}));
}

TEST(Analytic, sphere_is_depth_below_its_surface) {
  std::mt19937 random(2);
  const double radius = 0.04;
  const FieldPtr ball = sphere_field(radius).fields[0].field;
  EXPECT_NEAR(ball->bounds_m().size_m().x, 3 * radius, 1e-15);
  for (int n = 0; n < 1000; ++n) {
    const Vec3 at = within(random, ball->bounds_m());
    const ScalarSample s = ball->scalar(at);
    EXPECT_NEAR(s.value, radius - norm(at), 1e-16);
    EXPECT_NEAR(norm(s.gradient), 1.0, 1e-14);
    EXPECT_LT(norm(s.gradient + at / norm(at)), 1e-14);
  }
  EXPECT_EQ(ball->scalar({}).value, radius);
  EXPECT_EQ(ball->scalar({}).gradient, Vec3{});
}

TEST(Analytic, bored_block_is_distance_to_its_surface) {
  std::mt19937 random(18);
  const double radius = 5.5e-3, depth = 30e-3, rim = 1.5e-3;
  const FieldPtr block = bored_block(radius, depth, rim).fields[0].field;
  // Points of the surface in the half plane of radius and height, dense beside the distances below.
  std::vector<std::array<double, 2>> surface;
  const auto line = [&](double r0, double z0, double r1, double z1) {
    for (int n = 0; n <= 4000; ++n) surface.push_back({r0 + (r1 - r0) * n / 4000, z0 + (z1 - z0) * n / 4000});
  };
  line(0, -depth, radius, -depth);
  line(radius, -depth, radius, -rim);
  line(radius + rim, 0, 0.06, 0);
  for (int n = 0; n <= 4000; ++n) {
    const double angle = std::numbers::pi / 2 * n / 4000;
    surface.push_back({radius + rim - rim * std::cos(angle), -rim + rim * std::sin(angle)});
  }
  for (int n = 0; n < 2000; ++n) {
    const Vec3 at = within(random, block->bounds_m());
    const double r = std::hypot(at.x, at.y);
    double nearest = 1.0;
    for (const auto& point : surface) nearest = std::min(nearest, std::hypot(r - point[0], at.z - point[1]));
    const ScalarSample s = block->scalar(at);
    EXPECT_NEAR(std::abs(s.value), nearest, 2e-5);
    EXPECT_LT(norm(s.gradient - numeric_gradient(*block, at, 1e-9)), 1e-4) << at.x << ' ' << at.y << ' ' << at.z;
    EXPECT_NEAR(norm(s.gradient), 1.0, 1e-12);
    // The gradient leads to the surface, and the depth is the same all round the axis.
    EXPECT_NEAR(block->scalar(at - s.value * s.gradient).value, 0.0, 1e-15);
    const double inside_m = std::min(r, block->bounds_m().high_m.x);
    EXPECT_NEAR(block->scalar({inside_m, 0, at.z}).value, block->scalar({0, -inside_m, at.z}).value, 1e-16);
  }
  const auto solid = [&](double r, double z) { return block->scalar({0, r, z}).value > 0.0; };
  EXPECT_FALSE(solid(0.0, 0.01));
  EXPECT_FALSE(solid(0.0, -0.029));
  EXPECT_TRUE(solid(0.0, -0.031));
  EXPECT_FALSE(solid(0.0054, -0.01));
  EXPECT_TRUE(solid(0.0056, -0.01));
  EXPECT_FALSE(solid(0.0056, -0.0005));  // within the rounded rim
  EXPECT_TRUE(solid(0.0075, -0.0001));
  EXPECT_EQ(block->scalar({0, 0, -0.02}).gradient.x, 0.0);
}

TEST(Analytic, lamb_oseen_turns_as_its_formula_says) {
  std::mt19937 random(3);
  const double circulation = 0.03, core = 0.008;
  const FieldPtr vortex = lamb_oseen_vortex(circulation, core).fields[0].field;
  for (int n = 0; n < 2000; ++n) {
    const Vec3 at = within(random, vortex->bounds_m());
    const double r = std::hypot(at.x, at.y);
    const double swirl = -circulation / (2 * std::numbers::pi * r) * std::expm1(-r * r / (core * core));
    const Vec3 expected = swirl * Vec3{-at.y / r, at.x / r, 0};
    EXPECT_LT(norm(vortex->vector(at).value - expected), 1e-13 * norm(expected));
  }
}

TEST(Analytic, a_vortex_is_smooth_on_its_axis_and_where_the_series_takes_over) {
  const double circulation = 0.03, core = 0.008, strain = 0.7;
  const FieldPtr vortex = burgers_vortex(circulation, core, strain).fields[0].field;
  const double axis_rate = circulation / (2 * std::numbers::pi * core * core);
  const VectorSample on_axis = vortex->vector({0, 0, 0.01});
  EXPECT_EQ(on_axis.value, (Vec3{0, 0, 0.01 * strain}));
  EXPECT_LT(largest_difference(on_axis.jacobian, {{{-strain / 2, -axis_rate, 0}, {axis_rate, -strain / 2, 0}, {0, 0, strain}}}),
            1e-12);

  // φ(s) and its slope against the definition in long double, from the axis outwards.
  for (double s = 1e-12; s < 30; s *= 1.07) {
    const double r = core * std::sqrt(s);
    const VectorSample v = vortex->vector({r, 0, 0});
    const long double t = s;
    const long double phi = -std::expm1(-t) / t;
    const long double slope = s < 1e-3 ? -0.5L + t / 3 - t * t / 8 + t * t * t / 30 : (std::exp(-t) * (1 + t) - 1) / (t * t);
    EXPECT_NEAR(v.value.y, double(phi) * axis_rate * r, 1e-14 * axis_rate * r) << s;
    EXPECT_NEAR(v.jacobian.row[1].x, axis_rate * double(phi + 2 * t * slope), 1e-13 * axis_rate) << s;
    EXPECT_NEAR(v.jacobian.row[0].y, -axis_rate * double(phi), 1e-14 * axis_rate) << s;
  }
  for (const double tiny : {1e-300, 1e-170, 5e-324}) {
    EXPECT_LT(largest_difference(vortex->vector({tiny, -tiny, 0}).jacobian, vortex->vector({}).jacobian), 1e-12);
  }
}

TEST(Analytic, vortices_have_no_divergence_and_know_their_jacobian) {
  std::mt19937 random(4);
  for (const Volume& volume : {lamb_oseen_vortex(), burgers_vortex(), burgers_vortex(-0.05, 0.3, 2.0)}) {
    const Field& vortex = *volume.fields[0].field;
    const double core = 8.0 * vortex.spacing_m();
    const double rate = largest_component(vortex.vector({}).jacobian.row[0]);
    for (int n = 0; n < 1000; ++n) {
      const Vec3 at = 0.9 * within(random, vortex.bounds_m());
      const Mat3 j = vortex.vector(at).jacobian;
      EXPECT_NEAR(j.row[0].x + j.row[1].y + j.row[2].z, 0.0, 1e-14 * rate);
      EXPECT_LT(largest_difference(j, numeric_jacobian(vortex, at, 3e-3 * core)), 1e-8 * rate);
    }
  }
}

TEST(Analytic, burgers_is_lamb_oseen_under_strain) {
  std::mt19937 random(5);
  const FieldPtr lamb = lamb_oseen_vortex(0.02, 0.01).fields[0].field;
  const FieldPtr burgers = burgers_vortex(0.02, 0.01, 0.6).fields[0].field;
  for (int n = 0; n < 500; ++n) {
    const Vec3 at = within(random, lamb->bounds_m());
    const Vec3 strain{-0.3 * at.x, -0.3 * at.y, 0.6 * at.z};
    EXPECT_LT(norm(burgers->vector(at).value - lamb->vector(at).value - strain), 1e-15);
  }
}

TEST(Analytic, scaling_by_a_power_of_two_changes_no_bit) {
  std::mt19937 random(6);
  for (const int exponent : {-30, 23}) {
    const double f = std::ldexp(1.0, exponent);
    const FieldPtr ball = sphere_field(0.05).fields[0].field, scaled_ball = sphere_field(0.05 * f).fields[0].field;
    const FieldPtr vortex = burgers_vortex(0.02, 0.01, 0.2).fields[0].field;
    const FieldPtr scaled_vortex = burgers_vortex(0.02 * f * f, 0.01 * f, 0.2).fields[0].field;
    for (int n = 0; n < 1000; ++n) {
      const Vec3 at = within(random, ball->bounds_m());
      EXPECT_EQ(f * ball->scalar(at).value, scaled_ball->scalar(f * at).value);
      EXPECT_EQ(ball->scalar(at).gradient, scaled_ball->scalar(f * at).gradient);
      const Vec3 in_vortex = within(random, vortex->bounds_m());
      EXPECT_EQ(f * vortex->vector(in_vortex).value, scaled_vortex->vector(f * in_vortex).value);
      EXPECT_EQ(vortex->vector(in_vortex).jacobian, scaled_vortex->vector(f * in_vortex).jacobian);
    }
  }
}

TEST(Analytic, refuses_sizes_that_are_none) {
  for (const double bad : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(plane_field(bad), std::invalid_argument);
    EXPECT_THROW(sphere_field(bad), std::invalid_argument);
    EXPECT_THROW(bored_block(bad), std::invalid_argument);
    EXPECT_THROW(bored_block(5e-3, bad), std::invalid_argument);
    EXPECT_THROW(bored_block(5e-3, 0.03, bad), std::invalid_argument);
    EXPECT_THROW(lamb_oseen_vortex(0.02, bad), std::invalid_argument);
    EXPECT_THROW(burgers_vortex(0.02, bad, 0.2), std::invalid_argument);
  }
  EXPECT_THROW(bored_block(5e-3, 0.03, 0.031), std::invalid_argument);
  EXPECT_THROW(lamb_oseen_vortex(nan, 0.01), std::invalid_argument);
  EXPECT_THROW(lamb_oseen_vortex(1e300, 1e-100), std::invalid_argument);
  EXPECT_THROW(burgers_vortex(0.02, 0.01, -0.1), std::invalid_argument);
  EXPECT_THROW(burgers_vortex(0.02, 0.01, nan), std::invalid_argument);
}

// ---- the head

FieldPtr head() { return head_phantom().fields[0].field; }

/// First distance [m] along a ray at which the value reaches a level; a large number without one.
double first_reach(const Field& field, const Vec3& from, const Vec3& way, double level) {
  for (double t = 0.0; t < 0.3; t += 1e-4) {
    const ScalarSample s = field.scalar(from + t * way);
    if (s.inside && s.value >= level) return t;
  }
  return 1e9;
}

TEST(HeadPhantom, gradient_is_the_derivative_of_the_value) {
  std::mt19937 random(7);
  const FieldPtr field = head();
  int steep = 0;
  for (int n = 0; n < 20000; ++n) {
    const Vec3 at = 0.98 * within(random, field->bounds_m());
    const ScalarSample s = field->scalar(at);
    // An edge is 10⁶ HU/m; its curvature jumps, so the difference has an error of its own.
    EXPECT_LT(norm(s.gradient - numeric_gradient(*field, at, 1e-6)), 200.0) << at.x << ' ' << at.y << ' ' << at.z;
    steep += norm(s.gradient) > 1e4;
  }
  EXPECT_GT(steep, 1000);
}

TEST(HeadPhantom, value_and_gradient_are_continuous) {
  std::mt19937 random(8);
  const FieldPtr field = head();
  for (int n = 0; n < 20000; ++n) {
    const Vec3 at = 0.98 * within(random, field->bounds_m());
    const Vec3 step = 1e-8 * normalized({uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)});
    const ScalarSample a = field->scalar(at), b = field->scalar(at + step);
    EXPECT_LT(std::abs(a.value - b.value), 0.1);      // 3·10⁶ HU/m at most
    EXPECT_LT(norm(a.gradient - b.gradient), 300.0);  // 3·10¹⁰ HU/m² at most
  }
  // Across the plane of symmetry too.
  for (int n = 0; n < 2000; ++n) {
    Vec3 at = 0.98 * within(random, field->bounds_m());
    at.x = 0.0;
    EXPECT_LT(std::abs(field->scalar(at).gradient.x), 1e-6);
  }
}

TEST(HeadPhantom, is_the_same_on_both_sides) {
  std::mt19937 random(9);
  const FieldPtr field = head();
  for (int n = 0; n < 2000; ++n) {
    const Vec3 at = within(random, field->bounds_m());
    const ScalarSample left = field->scalar(at), right = field->scalar({-at.x, at.y, at.z});
    EXPECT_EQ(left.value, right.value);
    EXPECT_EQ(left.gradient, (Vec3{-right.gradient.x, right.gradient.y, right.gradient.z}));
  }
}

TEST(HeadPhantom, has_skin_skull_brain_and_air_where_a_head_has_them) {
  const FieldPtr field = head();
  const auto hu = [&](double x_mm, double y_mm, double z_mm) { return field->scalar(1e-3 * Vec3{x_mm, y_mm, z_mm}).value; };
  EXPECT_EQ(hu(0, 0, 50), 35);          // brain
  EXPECT_EQ(hu(80, -100, 100), -1000);  // air outside
  EXPECT_EQ(hu(0, 8, 109), 1000);       // top of the skull
  EXPECT_EQ(hu(0, -101, -30), 40);      // nose
  EXPECT_EQ(hu(8, -54, -24), -1000);    // nasal cavity
  EXPECT_EQ(hu(0, -54, -24), 1000);     // its septum
  EXPECT_EQ(hu(31, -53, -38), -1000);   // sinus
  EXPECT_EQ(hu(76, 14, 20), 40);        // ear
  EXPECT_EQ(hu(0, 12, -100), -1000);    // windpipe
  EXPECT_EQ(hu(0, 42, -90), 1000);      // spine

  // The nose is the foremost part; the face is at −y.
  double foremost = 0.0;
  for (double z = -0.12; z < 0.12; z += 1e-3) {
    for (double y = -0.115; y < foremost; y += 1e-3) {
      if (field->scalar({0, y, z}).value > -300) foremost = y;
    }
  }
  EXPECT_NEAR(foremost, -0.105, 2e-3);
}

TEST(HeadPhantom, skull_lies_five_to_eight_millimetres_below_the_skin) {
  std::mt19937 random(10);
  const FieldPtr field = head();
  const Vec3 middle{0, 0.008, 0.045};
  int rays = 0;
  for (int n = 0; n < 500; ++n) {
    const Vec3 way = normalized({uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, 0.1, 1)});
    const Vec3 from = middle + 0.2 * way;
    const double skin = first_reach(*field, from, -way, -300);
    const Vec3 met = from - skin * way;
    if (std::abs(met.x) > 0.066 && met.z < 0.06) continue;  // an ear is thicker
    const Vec3 inward = normalized(field->scalar(met).gradient);
    const double bone = first_reach(*field, met, inward, 300);
    EXPECT_GT(bone, 0.005);
    EXPECT_LT(bone, 0.008);
    ++rays;
  }
  EXPECT_GT(rays, 300);
}

TEST(HeadPhantom, edges_are_about_two_millimetres_wide) {
  const FieldPtr field = head();
  for (const Vec3& way : {Vec3{0, 0, 1}, Vec3{0, 1, 0}, normalized({0.3, -0.5, 1})}) {
    const Vec3 from = Vec3{0, 0.008, 0.045} + 0.15 * way;
    const double begins = first_reach(*field, from, -way, -999.999), ends = first_reach(*field, from, -way, 39.999);
    EXPECT_GT(ends - begins, 0.0015);
    EXPECT_LT(ends - begins, 0.0025);
  }
}

double divergence(const Mat3& j) { return j.row[0].x + j.row[1].y + j.row[2].z; }

/// Derivatives against differences of the values, at random points well within the box.
void expect_derivatives_of_values(const Field& field, std::uint32_t seed, double step_m, double error) {
  std::mt19937 random(seed);
  const Vec3 centre = field.bounds_m().centre_m();
  for (int n = 0; n < 2000; ++n) {
    const Vec3 x = centre + 0.98 * (within(random, field.bounds_m()) - centre);
    if (field.components() == 3) {
      EXPECT_LT(largest_difference(field.vector(x).jacobian, numeric_jacobian(field, x, step_m)), error);
    } else {
      EXPECT_LT(norm(field.scalar(x).gradient - numeric_gradient(field, x, step_m)), error);
    }
  }
}

TEST(Analytic, ring_in_a_chamber_is_free_of_divergence_and_still_at_the_wall) {
  std::mt19937 random(11);
  for (const double beat : {0.0, 0.1, 0.25, 0.6, 0.9}) {
    const Volume heart = ring_vortex(beat);
    const Field& velocity = *heart.fields[0].field;
    const Field& signal = *heart.fields[1].field;
    EXPECT_EQ(heart.fields[0].name, "velocity");
    EXPECT_EQ(heart.fields[1].name, "signal");
    double fastest = 0.0;
    for (int n = 0; n < 20000; ++n) {
      const Vec3 x = within(random, velocity.bounds_m());
      const VectorSample u = velocity.vector(x);
      fastest = std::max(fastest, norm(u.value));
      EXPECT_NEAR(divergence(u.jacobian), 0.0, 1e-11);
      // On the wall and beyond: no motion and no shear.
      const Vec3 way = normalized({uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)});
      const Vec3 wall{27e-3 * way.x, 27e-3 * way.y, 32e-3 * way.z};
      const VectorSample at_wall = velocity.vector(wall);
      EXPECT_LT(norm(at_wall.value), 1e-15);
      EXPECT_LT(largest_difference(at_wall.jacobian, {}), 1e-9);
      const VectorSample beyond = velocity.vector(1.02 * wall);
      EXPECT_TRUE(beyond.inside);
      EXPECT_EQ(beyond.value, Vec3{});
      EXPECT_EQ(beyond.jacobian, Mat3{});
      EXPECT_NEAR(signal.scalar(wall).value, 0.5, 1e-6);
      EXPECT_EQ(signal.scalar(0.95 * wall).value, 1.0);
      EXPECT_EQ(signal.scalar(1.05 * wall).value, 0.0);
    }
    EXPECT_LE(fastest, velocity.value_ranges()[2].max);
    EXPECT_GT(fastest, 0.5 * velocity.value_ranges()[2].max);
    EXPECT_GT(velocity.vector({}).value.z, 0.0);             // the jet
    EXPECT_LT(velocity.vector({0.023, 0, 0}).value.z, 0.0);  // and back along the wall
    expect_derivatives_of_values(velocity, 12, 1e-5, 1e-3);
    expect_derivatives_of_values(signal, 13, 1e-6, 1e-1);
  }
}

TEST(Analytic, ring_beats_periodically) {
  std::mt19937 random(14);
  const FieldPtr now = ring_vortex(0.375).fields[0].field, next = ring_vortex(1.375).fields[0].field,
                 before = ring_vortex(-2.625).fields[0].field, other = ring_vortex(0.5).fields[0].field;
  double change = 0.0;
  for (int n = 0; n < 1000; ++n) {
    const Vec3 x = within(random, now->bounds_m());
    EXPECT_EQ(now->vector(x).value, next->vector(x).value);
    EXPECT_EQ(now->vector(x).value, before->vector(x).value);
    change = std::max(change, norm(now->vector(x).value - other->vector(x).value));
  }
  EXPECT_GT(change, 0.05);
  EXPECT_EQ(ring_vortex().fields[0].field->vector({}).value, ring_vortex(0.25).fields[0].field->vector({}).value);
  EXPECT_THROW(ring_vortex(nan), std::invalid_argument);
  EXPECT_THROW(ring_vortex(std::numeric_limits<double>::infinity()), std::invalid_argument);
}

TEST(Analytic, wake_of_a_wing_has_two_counter_rotating_tip_vortices) {
  const Volume wake = wing_wake();
  const Field& velocity = *wake.fields[0].field;
  const Field& pressure = *wake.fields[1].field;
  EXPECT_EQ(wake.fields[0].name, "velocity");
  EXPECT_EQ(wake.fields[1].name, "pressure");
  std::mt19937 random(15);
  for (int n = 0; n < 20000; ++n) {
    EXPECT_NEAR(divergence(velocity.vector(within(random, velocity.bounds_m())).jacobian), 0.0, 1e-13);
  }
  expect_derivatives_of_values(velocity, 16, 1e-3, 1e-6);
  expect_derivatives_of_values(pressure, 17, 1e-3, 1e-6);
  // Far downstream a leg is an endless straight line: twice the vorticity of a half-line.
  const Vec3 left{2.9, -1.4, 0}, right{2.9, 1.4, 0};
  const auto vorticity_x = [&](const Vec3& x) {
    const Mat3 j = velocity.vector(x).jacobian;
    return j.row[2].y - j.row[1].z;
  };
  const double of_a_line = 0.4 / (std::numbers::pi * 0.12 * 0.12);
  EXPECT_NEAR(vorticity_x(right), of_a_line, 0.01 * of_a_line);
  EXPECT_NEAR(vorticity_x(left), -of_a_line, 0.01 * of_a_line);
  EXPECT_LT(velocity.vector({2, 0, 0}).value.z, 0.0);    // downwash between them
  EXPECT_GT(velocity.vector({2, 1.8, 0}).value.z, 0.0);  // upwash outside
  // Lowest pressure in the cores, suction above the wing and pressure below it.
  const double core = 0.5 * std::pow(0.4 / (2 * std::numbers::pi * 0.12), 2);
  EXPECT_NEAR(pressure.scalar(right).value, -core, 0.02 * core);
  EXPECT_NEAR(pressure.scalar(left).value, -core, 0.02 * core);
  for (const double angle : {0.0, 1.0, 2.0, 3.0, 4.0, 5.0}) {
    EXPECT_GT(pressure.scalar(right + 0.12 * Vec3{0, std::cos(angle), std::sin(angle)}).value, 0.7 * -core);
  }
  EXPECT_LT(pressure.scalar({0.25, 0, 0.12}).value, 0.0);
  EXPECT_GT(pressure.scalar({0.25, 0, -0.12}).value, 0.0);
}

}  // namespace analytic_test
}  // namespace palpa
