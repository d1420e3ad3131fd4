// Tools: their feet, options and motions (tool.h).
#include "palpa/solver/tool.h"

#include <gmock/gmock.h>

#include <limits>
#include <numbers>
#include <stdexcept>

#include "tests/solver/pose_problems.h"

namespace palpa::test {
namespace tool_test {

using Shape = ToolOptions::Shape;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

ToolOptions rod(double length_m, int points, double radius_m = 0.0) {
  ToolOptions options;
  options.shape = Shape::rod, options.length_m = length_m, options.points = points, options.radius_m = radius_m;
  return options;
}
ToolOptions round(Shape shape, double radius_m, int points) {
  ToolOptions options;
  options.shape = shape, options.radius_m = radius_m, options.points = points;
  return options;
}
std::vector<Vec3> feet_of(const Tool& tool) {
  std::vector<Vec3> feet_m;
  for (std::size_t i = 0; i < tool.feet(); ++i) feet_m.push_back(tool.lever_m({}, i));
  return feet_m;
}
Tool some_tool(Random& random) {
  ToolOptions options;
  switch (random.below(4)) {
    case 0: options = rod(random.uniform(0.01, 0.3), 1 + random.below(40), random.below(2) * 0.01); break;
    case 1: options = round(Shape::pad, random.uniform(0.001, 0.1), 1 + random.below(256)); break;
    case 2: options = round(Shape::ball, random.uniform(0.001, 0.1), 1 + random.below(256)); break;
    default:
      options.shape = Shape::points;
      for (int i = 0; i < 1 + random.below(20); ++i) options.points_m.push_back(random.in_cube(0.1));
  }
  options.centre_m = random.in_cube(0.05);
  if (random.below(2) == 0) options.turning_radius_m = random.uniform(0.001, 0.2);
  return Tool(options, {});
}

TEST(Tool, WithoutOptionsIsAPoint) {
  const Tool tool, of_options({}, {});
  for (const Tool* one : {&tool, &of_options}) {
    EXPECT_TRUE(one->is_point());
    EXPECT_EQ(one->feet(), 1u);
    EXPECT_EQ(one->reach_m(), 0.0);
    const Pose pose{{1, 2, 3}, turn_by({0.1, 0.2, 0.3})};
    EXPECT_EQ(one->foot_m(pose, 0), pose.position_m);
    const Motion motion = one->motion({}, pose);
    EXPECT_EQ(motion.arc_m, Vec3{});
    EXPECT_EQ(one->way_m(motion), norm(pose.position_m));
    EXPECT_EQ(one->moved({}, motion).turn, Turn{});
  }
}

TEST(Tool, OfOneFootAwayFromTheCentreIsNoPoint) {
  ToolOptions options;
  options.centre_m = {0, 0, 0.1};
  const Tool tool(options, {});
  EXPECT_FALSE(tool.is_point());
  EXPECT_EQ(tool.lever_m({}, 0), (Vec3{0, 0, -0.1}));
  EXPECT_EQ(tool.reach_m(), 0.1);
}

TEST(Tool, AsARodHasItsFeetEvenlyAlongItsAxis) {
  const std::vector<Vec3> feet_m = feet_of(Tool(rod(0.2, 5), {}));
  ASSERT_EQ(feet_m.size(), 5u);
  for (int i = 0; i < 5; ++i) EXPECT_LE(distance(feet_m[i], {0, 0, -0.1 + 0.05 * i}), 1e-16);
  EXPECT_EQ(feet_of(Tool(rod(0.2, 1), {})), std::vector<Vec3>{{}}) << "a single foot in the middle";

  const std::vector<Vec3> rings_m = feet_of(Tool(rod(0.2, 24, 0.01), {}));
  ASSERT_EQ(rings_m.size(), 24u);
  for (int i = 0; i < 24; ++i) {
    EXPECT_NEAR(std::hypot(rings_m[i].x, rings_m[i].y), 0.01, 1e-16);
    EXPECT_NEAR(rings_m[i].z, -0.1 + 0.1 * (i / 8), 1e-16);
  }
}

// The mean square of the distance from the middle is half the radius' square on a disc, and all of it on a sphere.
TEST(Tool, AsAPadOrBallHasItsFeetEvenlySpread) {
  for (const int points : {16, 64, 256}) {
    Vec3 middle_m;
    double squares_m2 = 0.0;
    for (const Vec3& foot_m : feet_of(Tool(round(Shape::pad, 0.02, points), {}))) {
      EXPECT_EQ(foot_m.z, 0.0);
      EXPECT_LE(norm(foot_m), 0.02);
      middle_m += foot_m / points;
      squares_m2 += norm_squared(foot_m) / points;
    }
    EXPECT_LE(norm(middle_m), 0.02 / points);
    EXPECT_NEAR(squares_m2, 0.5 * 0.02 * 0.02, 1e-15);
    middle_m = {};
    for (const Vec3& foot_m : feet_of(Tool(round(Shape::ball, 0.02, points), {}))) {
      EXPECT_NEAR(norm(foot_m), 0.02, 1e-16);
      middle_m += foot_m / points;
    }
    EXPECT_LE(norm(middle_m), 0.02 / points);
  }
}

TEST(Tool, IsAboutItsCentre) {
  ToolOptions options = rod(0.2, 3);
  options.centre_m = {0.01, 0, 0.1};
  const Tool tool(options, {});
  EXPECT_LE(distance(tool.lever_m({}, 2), {-0.01, 0, 0}), 1e-16);
  EXPECT_NEAR(tool.reach_m(), std::hypot(0.2, 0.01), 1e-16);
}

// docs/theory.md 10.7
TEST(Tool, TurnsAsSoftAsItsLeversYieldAndStandsTheLargestForce) {
  CouplingOptions coupling;
  coupling.stiffness_n_per_m = 400, coupling.max_force_n = 3;
  const ToolOptions options = rod(0.2, 3);
  const Tool tool(options, coupling);
  const double mean_m2 = 2.0 / 3.0 * 0.1 * 0.1, steady_m2 = 2.0 * 3 * 0.1 / 400;
  EXPECT_NEAR(tool.turning_radius_m(), std::sqrt(std::max(mean_m2, steady_m2)), 1e-15);
  EXPECT_GE(400 * tool.turning_radius_m() * tool.turning_radius_m(), 2.0 * 3 * tool.reach_m());
  coupling.max_force_n = 30;
  EXPECT_NEAR(Tool(options, coupling).turning_radius_m(), std::sqrt(10 * steady_m2), 1e-15);
  ToolOptions given = options;
  given.turning_radius_m = 0.02;
  EXPECT_EQ(Tool(given, coupling).turning_radius_m(), 0.02);
}

TEST(Tool, ComesBackFromAMotion) {
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const Tool tool = some_tool(random);
    if (tool.is_point()) continue;
    const Pose from{random.in_cube(0.1), random_turn(random, 3.0)}, to{random.in_cube(0.1), random_turn(random, 3.0)};
    const Motion motion = tool.motion(from, to);
    const Pose moved = tool.moved(from, motion);
    EXPECT_LE(distance(moved.position_m, to.position_m), 1e-16);
    EXPECT_LE(norm(rotation_between_rad(moved.turn, to.turn)), 4e-15);
    EXPECT_LE(length(tool.motion(moved, to)), 1e-15);
    EXPECT_EQ(tool.moved(from, {}), from);
    EXPECT_EQ(length(tool.motion(from, from)), 0.0);
    for (std::size_t foot = 0; foot < tool.feet(); ++foot)
      EXPECT_LE(distance(tool.foot_m(moved, foot), tool.foot_m(to, foot)), 1e-15);
  }
}

// Along the whole arc, in any steps.
TEST(Tool, HasAnUpperBoundOfTheWayOfAnyFoot) {
  Random random(2);
  double largest = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const Tool tool = some_tool(random);
    const Pose from{random.in_cube(0.1), random_turn(random, 3.0)};
    const double rho = tool.turning_radius_m();
    const Motion motion{random.below(2) * random.in_cube(0.01), rho * random.uniform(0, 1) * random.direction()};
    const double bound_m = tool.way_m(motion);
    EXPECT_EQ(tool.way_m(from, from), 0.0);
    for (std::size_t foot = 0; foot < tool.feet(); ++foot) {
      double way_m = 0.0;
      Vec3 last_m = tool.foot_m(from, foot);
      for (int step = 1; step <= 10; ++step) {
        const Vec3 at_m = tool.foot_m(tool.moved(from, 0.1 * step * motion), foot);
        way_m += distance(at_m, last_m);
        last_m = at_m;
      }
      EXPECT_LE(way_m, bound_m * (1 + 1e-12) + 1e-15);
      if (bound_m > 0.0) largest = std::max(largest, way_m / bound_m);
    }
  }
  EXPECT_GE(largest, 0.99) << "the bound is near the way of some foot";
}

TEST(ToolOptions, AreRefusedInOneSentence) {
  ToolOptions options;
  EXPECT_EQ(problem_with(options), nullptr);
  EXPECT_EQ(problem_with(rod(0.2, 256)), nullptr);
  EXPECT_EQ(problem_with(round(Shape::pad, 0.02, 1)), nullptr);
  EXPECT_STREQ(problem_with(rod(0.2, 257)), "points must be between 1 and 256");
  EXPECT_STREQ(problem_with(rod(0.2, 0)), "points must be between 1 and 256");
  for (const double length_m : {0.0, -0.1, 1.1, nan})
    EXPECT_STREQ(problem_with(rod(length_m, 3)), "length_m of a rod must be above 0 and at most 1");
  for (const double radius_m : {-0.1, 0.6, nan})
    EXPECT_STREQ(problem_with(rod(0.1, 3, radius_m)), "radius_m of a rod must be between 0 and 0.5");
  for (const double radius_m : {0.0, -0.1, 0.6, nan}) {
    EXPECT_STREQ(problem_with(round(Shape::pad, radius_m, 3)), "radius_m must be above 0 and at most 0.5");
    EXPECT_STREQ(problem_with(round(Shape::ball, radius_m, 3)), "radius_m must be above 0 and at most 0.5");
  }
  options = {};
  options.length_m = 0.1;
  EXPECT_STREQ(problem_with(options), "length_m is of a rod");
  options = {};
  options.radius_m = 0.1;
  EXPECT_STREQ(problem_with(options), "radius_m is of a rod, pad or ball");
  for (const double share : {0.0, -0.5, 1.1, nan}) {
    options = {};
    options.share = share;
    EXPECT_STREQ(problem_with(options), "share must be above 0 and at most 1");
  }
  for (const Vec3& centre_m : {Vec3{2, 0, 0}, Vec3{nan, 0, 0}}) {
    options = {};
    options.centre_m = centre_m;
    EXPECT_STREQ(problem_with(options), "centre_m must be finite and within 1 m");
  }
  for (const double radius_m : {0.0, -1.0, 1.5, nan}) {
    options = {};
    options.turning_radius_m = radius_m;
    EXPECT_STREQ(problem_with(options), "turning_radius_m must be above 0 and at most 1");
  }
}

TEST(ToolOptions, OfPointsAreRefusedInOneSentence) {
  ToolOptions options;
  options.points_m = {{}};
  EXPECT_STREQ(problem_with(options), "points_m needs no shape");
  options.shape = Shape::points;
  EXPECT_EQ(problem_with(options), nullptr);
  options.points_m.clear();
  EXPECT_STREQ(problem_with(options), "points_m needs at least one point");
  options.points_m.assign(256, {});
  EXPECT_EQ(problem_with(options), nullptr);
  options.points_m.assign(257, {});
  EXPECT_STREQ(problem_with(options), "points_m has more than 256 points");
  options.points_m = {{0, nan, 0}};
  EXPECT_STREQ(problem_with(options), "points_m must be finite and within 1 m");
  EXPECT_THROW(Tool(options, {}), std::invalid_argument);
  EXPECT_THROW(Tool({}, {.stiffness_n_per_m = nan}), std::invalid_argument);
}

}  // namespace tool_test
}  // namespace palpa::test
