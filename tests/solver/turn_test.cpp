// Turns, and motions in the metric (pose.h).
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/solver/pose_problems.h"

namespace palpa::test {
namespace turn_test {

constexpr double pi = std::numbers::pi;

// Lengths from 1e-300 to nearly π, also a few roundings before π.
Vec3 some_rotation_rad(Random& random) {
  switch (random.below(4)) {
    case 0: return random.log_uniform(1e-300, 1.0) * random.direction();
    case 1: return (pi - random.log_uniform(1e-15, 1e-2)) * random.direction();
    case 2: return random.log_uniform(0.5e-4, 2e-4) * random.direction();  // where the series end
    default: return random.uniform(0, 3.14) * random.direction();
  }
}

double apart(const Turn& a, const Turn& b) {
  return std::sqrt((a.w - b.w) * (a.w - b.w) + (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y) +
                   (a.z - b.z) * (a.z - b.z));
}

TEST(Turn, ComesBackFromItsRotationVector) {
  Random random(1);
  for (int i = 0; i < 100000; ++i) {
    const Vec3 turn_rad = some_rotation_rad(random);
    const Turn turn = turn_by(turn_rad);
    EXPECT_TRUE(is_unit(turn, 1e-15));
    EXPECT_LE(distance(rotation_rad(turn), turn_rad), 1e-15 * std::max(1.0, norm(turn_rad))) << norm(turn_rad);
    EXPECT_LE(distance(rotation_rad(turn), turn_rad), 4e-15 * norm(turn_rad)) << norm(turn_rad);
    EXPECT_LE(distance(rotation_rad({-turn.w, -turn.x, -turn.y, -turn.z}), turn_rad), 1e-15 * std::max(1.0, norm(turn_rad)))
        << "the same rotation by the other quaternion";
  }
}

TEST(Turn, HasARotationVectorOfAtMostHalfATurn) {
  Random random(2);
  for (int i = 0; i < 10000; ++i) {
    const double angle_rad = random.uniform(0, 20);
    const Vec3 axis = random.direction();
    const double nearest_rad = std::remainder(angle_rad, 2 * pi);
    EXPECT_LE(distance(rotation_rad(turn_by(angle_rad * axis)), nearest_rad * axis), 1e-13);
  }
  EXPECT_EQ(rotation_rad({}), Vec3{});
  EXPECT_NEAR(norm(rotation_rad({0, 1, 0, 0})), pi, 1e-15);
}

TEST(Turn, RotatesAsItsMatrixAndByItsAngle) {
  Random random(3);
  for (int i = 0; i < 10000; ++i) {
    const Vec3 turn_rad = some_rotation_rad(random), v = random.in_cube(1.0);
    const Turn turn = turn_by(turn_rad);
    const Vec3 to = rotated(turn, v);
    EXPECT_LE(distance(to, matrix_of(turn) * v), 4e-15);
    EXPECT_LE(distance(rotated(inverse(turn), to), v), 4e-15);
    const double angle_rad = norm(turn_rad);
    if (angle_rad == 0.0) continue;
    const Vec3 axis = turn_rad / angle_rad, along = dot(axis, v) * axis, across = v - along;
    EXPECT_LE(distance(to, along + std::cos(angle_rad) * across + std::sin(angle_rad) * cross(axis, across)), 4e-15);
  }
}

TEST(Turn, ByTheProductIsByOneAfterTheOther) {
  Random random(4);
  for (int i = 0; i < 10000; ++i) {
    const Turn a = random_turn(random, 3.1), b = random_turn(random, 3.1);
    const Vec3 v = random.in_cube(1.0);
    EXPECT_LE(distance(rotated(a * b, v), rotated(a, rotated(b, v))), 4e-15);
    EXPECT_LE(apart(a * inverse(a), {}), 1e-15);
  }
}

TEST(Turn, LeadsFromOneToTheOther) {
  Random random(5);
  for (int i = 0; i < 10000; ++i) {
    const Turn from = random_turn(random, 3.1), to = random_turn(random, 3.1);
    const Turn led = turned_further(from, rotation_between_rad(from, to));
    EXPECT_LE(std::min(apart(led, to), apart({-led.w, -led.x, -led.y, -led.z}, to)), 1e-15);
    EXPECT_EQ(rotation_between_rad(from, from), Vec3{});
    EXPECT_EQ(turned_further(from, {}), from);
    EXPECT_LE(distance(rotation_between_rad(to, from), -rotation_between_rad(from, to)), 1e-14);
  }
}

TEST(Turn, OfAThousandStepsStaysOfUnitLength) {
  Random random(6);
  Turn turn;
  for (int i = 0; i < 100000; ++i) turn = turned_further(turn, random.in_cube(0.3));
  EXPECT_TRUE(is_unit(turn, 1e-15));
  EXPECT_FALSE(is_unit({1, 1, 0, 0}, 1e-9));
  EXPECT_FALSE(is_unit({NAN, 0, 0, 0}, 1e-9));
}

TEST(Motion, HasALengthInTheMetricOfWayAndArc) {
  Random random(7);
  for (int i = 0; i < 1000; ++i) {
    const Motion a{random.in_cube(1.0), random.in_cube(1.0)}, b{random.in_cube(1.0), random.in_cube(1.0)};
    EXPECT_NEAR(length(a) * length(a), dot(a, a), 1e-15 * dot(a, a) + 1e-15);
    EXPECT_LE(length(a + b), length(a) + length(b));
    EXPECT_EQ(length(Motion{a.way_m, {}}), norm(a.way_m)) << "without arc to the bit";
    EXPECT_NEAR(length(shortened(a, 0.1)), std::min(0.1, length(a)), 1e-16);
    EXPECT_EQ(shortened(a, 10.0), a);
    EXPECT_EQ(shortened(a, 0.0), Motion{});
  }
}

}  // namespace turn_test
}  // namespace palpa::test
