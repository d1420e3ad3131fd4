#include <stdexcept>

#include "palpa/data/analytic.h"
#include "palpa/data/volume.h"
#include "tests/data/test_fields.h"

namespace palpa {
namespace posed_test {

using namespace test;

Similarity some_pose(std::mt19937& random) {
  return {rotation(random), uniform(random, 0.3, 3), {uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)}};
}

TEST(Posed, values_are_those_of_the_point_that_was_moved_and_derivatives_turn_with_it) {
  std::mt19937 random(1);
  const FieldPtr head = head_phantom().fields[0].field;
  const FieldPtr vortex = burgers_vortex().fields[0].field;
  for (int n = 0; n < 20; ++n) {
    const Similarity pose = some_pose(random);
    const FieldPtr moved_head = posed(head, pose), moved_vortex = posed(vortex, pose);
    EXPECT_NEAR(moved_head->spacing_m(), pose.scale * head->spacing_m(), 1e-15);
    for (int m = 0; m < 200; ++m) {
      const Vec3 x = within(random, head->bounds_m());
      const ScalarSample still = head->scalar(x), moved = moved_head->scalar(pose.to_world(x));
      ASSERT_EQ(still.inside, moved.inside);
      EXPECT_NEAR(moved.value, still.value, 1e-6);  // 1e-15 m across an edge of 10⁶ HU/m
      EXPECT_LT(norm(moved.gradient - pose.rotation * still.gradient / pose.scale), 1e-2);
      EXPECT_NEAR(moved_head->depth_m(pose.to_world(x)), pose.scale * head->depth_m(x), 1e-12);

      const Vec3 y = within(random, vortex->bounds_m());
      const VectorSample a = vortex->vector(y), b = moved_vortex->vector(pose.to_world(y));
      ASSERT_TRUE(a.inside && b.inside);
      EXPECT_LT(norm(b.value - pose.rotation * a.value), 1e-12);
      EXPECT_NEAR(b.jacobian.row[0].x + b.jacobian.row[1].y + b.jacobian.row[2].z, 0.0, 1e-10);  // no divergence, turned or not
    }
  }
}

TEST(Posed, derivatives_are_those_of_the_posed_values) {
  std::mt19937 random(2);
  const FieldPtr ball = sphere_field().fields[0].field;
  const FieldPtr vortex = lamb_oseen_vortex().fields[0].field;
  for (int n = 0; n < 200; ++n) {
    const Similarity pose = some_pose(random);
    const Vec3 x = pose.to_world(0.9 * within(random, vortex->bounds_m()));
    const FieldPtr moved_ball = posed(ball, pose), moved_vortex = posed(vortex, pose);
    if (norm(pose.to_hand(x)) > 0.01) {
      EXPECT_LT(norm(moved_ball->scalar(x).gradient - numeric_gradient(*moved_ball, x, 1e-4)), 1e-6);
    }
    EXPECT_LT(largest_difference(moved_vortex->vector(x).jacobian, numeric_jacobian(*moved_vortex, x, 1e-4)), 1e-4);
  }
}

TEST(Posed, poses_follow_one_another) {
  std::mt19937 random(3);
  const Similarity first = some_pose(random), second = some_pose(random);
  const Similarity both{second.rotation * first.rotation, first.scale * second.scale, second.to_world(first.translation_m)};
  const FieldPtr ball = sphere_field().fields[0].field;
  const FieldPtr twice = posed(posed(ball, first), second), once = posed(ball, both);
  for (int n = 0; n < 500; ++n) {
    const Vec3 at = both.to_world(0.99 * within(random, ball->bounds_m()));
    EXPECT_NEAR(twice->scalar(at).value, once->scalar(at).value, 1e-12);
    EXPECT_LT(norm(twice->scalar(at).gradient - once->scalar(at).gradient), 1e-9);
  }
}

TEST(Posed, box_and_range_hold_the_data) {
  std::mt19937 random(4);
  for (int n = 0; n < 20; ++n) {
    const Similarity pose = some_pose(random);
    const FieldPtr vortex = burgers_vortex().fields[0].field;
    const FieldPtr moved = posed(vortex, pose);
    const Box box = moved->bounds_m();
    const std::vector<ValueRange> range = moved->value_ranges();
    ASSERT_EQ(range.size(), 3u);
    for (int m = 0; m < 300; ++m) {
      const Vec3 x = pose.to_world(within(random, vortex->bounds_m()));
      EXPECT_TRUE(x.x >= box.low_m.x && x.y >= box.low_m.y && x.z >= box.low_m.z);
      EXPECT_TRUE(x.x <= box.high_m.x && x.y <= box.high_m.y && x.z <= box.high_m.z);
      const Vec3 v = moved->vector(x).value;
      const double values[3] = {v.x, v.y, v.z};
      for (int c = 0; c < 3; ++c) {
        EXPECT_GE(values[c], range[c].min);
        EXPECT_LE(values[c], range[c].max);
      }
    }
  }
  const FieldPtr head = head_phantom().fields[0].field;
  EXPECT_EQ(posed(head, some_pose(random))->value_ranges()[0].max, head->value_ranges()[0].max);
}

TEST(Posed, by_nothing_is_the_field_itself) {
  const FieldPtr ball = sphere_field().fields[0].field;
  EXPECT_EQ(posed(ball, {}), ball);
}

TEST(Posed, scaling_everything_by_a_power_of_two_changes_no_bit) {
  std::mt19937 random(5);
  const FieldPtr head = head_phantom().fields[0].field;
  const FieldPtr vortex = burgers_vortex().fields[0].field;
  for (const int exponent : {-30, -3, 5, 23}) {
    const double factor = std::ldexp(1.0, exponent);
    const Similarity pose = some_pose(random);
    const Similarity scaled{pose.rotation, factor * pose.scale, factor * pose.translation_m};
    const FieldPtr a = posed(head, pose), b = posed(head, scaled);
    const FieldPtr va = posed(vortex, pose), vb = posed(vortex, scaled);
    for (int n = 0; n < 2000; ++n) {
      const Vec3 at = within(random, a->bounds_m());
      const ScalarSample s = a->scalar(at), t = b->scalar(factor * at);
      ASSERT_EQ(s.inside, t.inside);
      ASSERT_EQ(s.value, t.value);
      ASSERT_EQ(s.gradient, factor * t.gradient);
      ASSERT_EQ(factor * a->depth_m(at), b->depth_m(factor * at));
      const Vec3 in_vortex = within(random, va->bounds_m());
      const VectorSample v = va->vector(in_vortex), w = vb->vector(factor * in_vortex);
      ASSERT_EQ(v.value, w.value);
      ASSERT_EQ(v.jacobian, factor * w.jacobian);
    }
  }
}

TEST(Posed, absurd_positions_and_scales_are_outside_and_finite) {
  std::mt19937 random(6);
  for (const Volume& volume : {head_phantom(), burgers_vortex(), sampled(burgers_vortex(), 8)}) {
    const Volume moved = posed(volume, some_pose(random));
    EXPECT_EQ(moved.fields.size(), volume.fields.size());
    for (const Vec3& at : absurd_positions()) expect_outside_and_finite(*moved.fields[0].field, at);
  }
  // Slope per metre beyond the range of a double.
  const FieldPtr speck = posed(head_phantom().fields[0].field, {.scale = 1e-306});
  for (int n = 0; n < 2000; ++n) {
    const ScalarSample s = speck->scalar(within(random, speck->bounds_m()));
    EXPECT_TRUE(std::isfinite(s.value) && is_finite(s.gradient));
  }
}

TEST(Posed, refuses_what_is_no_pose) {
  const FieldPtr ball = sphere_field().fields[0].field;
  const Mat3 mirror{{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  EXPECT_THROW(posed(ball, {.rotation = mirror}), std::invalid_argument);
  EXPECT_THROW(posed(ball, {.scale = 0}), std::invalid_argument);
  EXPECT_THROW(posed(ball, {.scale = -1}), std::invalid_argument);
  EXPECT_THROW(posed(ball, {.translation_m = {std::numeric_limits<double>::infinity(), 0, 0}}), std::invalid_argument);
  EXPECT_THROW(posed(FieldPtr(), {}), std::invalid_argument);
}

}  // namespace posed_test
}  // namespace palpa
