// PoseSolver against the certified reference over every family of a tool's problems. PALPA_PROBLEMS_TIMES=215 in the
// environment takes 215 times as many problems, about a million.
#include "tests/solver/pose_reference.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace palpa::test {
namespace pose_reference_test {

int times() {
  const char* asked = std::getenv("PALPA_PROBLEMS_TIMES");
  return asked ? std::max(1, std::atoi(asked)) : 1;
}

// A problem that can be made again.
struct Recipe {
  const PoseFamily& family;
  int feet;
  std::uint64_t seed;
  PoseProblem problem() const {
    Random random(seed);
    return family.make(random, feet);
  }
  friend std::ostream& operator<<(std::ostream& out, const Recipe& r) {
    return out << r.family.name << ", " << r.feet << " feet, seed " << r.seed;
  }
};

class PoseAccuracy : public testing::TestWithParam<std::size_t> {
 protected:
  const PoseFamily& family() const { return pose_families()[GetParam()]; }

  template <class Check>
  void over(std::initializer_list<int> sizes, int repetitions, Check check) {
    for (const int feet : sizes) {
      for (int i = 0; i < repetitions; ++i)
        check(Recipe{family(), feet,
                     static_cast<std::uint64_t>(7'000'003) * static_cast<std::uint64_t>(feet) + static_cast<std::uint64_t>(i)});
    }
  }

  void check(const Recipe& recipe) {
    const PoseProblem problem = recipe.problem();
    const std::size_t capacity = std::max<std::size_t>(2, problem.primitives.size());
    PoseSolver solver(capacity, problem.levers_m.size());
    PrimitiveSet set(capacity);
    const PoseSolved result = solved(problem, solver, set);
    ASSERT_EQ(set.dropped(), 0) << recipe;
    const Balance& balance = result.balance;
    ++problems_;
    ASSERT_TRUE(is_finite(balance.position_m) && is_finite(balance.turn_rad) && std::isfinite(balance.error_bound_m)) << recipe;
    ASSERT_NE(balance.status, BalanceStatus::bad_input) << recipe;
    EXPECT_EQ(balance.status == BalanceStatus::exact, balance.error_bound_m <= exact_bound_m) << recipe;
    const double bound_m = balance.error_bound_m;
    worst_bound_m_ = std::max(worst_bound_m_, bound_m);
    if (bound_m > target_m(recipe)) {
      ++above_;
      std::printf("bound %.2e m: %s, %d feet, seed %llu\n", bound_m, family().name, recipe.feet,
                  static_cast<unsigned long long>(recipe.seed));
    }

    const PoseReference reference = reference_pose(problem);
    if (!reference.certified) {
      ++uncertified_;
      std::printf("reference not certified: %s, %d feet, seed %llu: %.1e m\n", family().name, recipe.feet,
                  static_cast<unsigned long long>(recipe.seed), static_cast<double>(reference.bound_m));
      return;
    }
    const double slack = static_cast<double>(reference.bound_m);
    const double error = error_m(reference, problem, balance);
    worst_error_m_ = std::max(worst_error_m_, error);
    EXPECT_LE(error, bound_m + slack) << recipe;
    if (balance.status == BalanceStatus::exact || !family().is_extreme) {
      EXPECT_LE(error, target_m(recipe) + slack) << recipe << ", bound " << bound_m;
    }
    for (const std::size_t foot : {std::size_t{0}, problem.levers_m.size() - 1}) {
      const Balance at = balance_at_foot(balance, problem.levers_m[foot], problem.turning_radius_m);
      EXPECT_LE(foot_error_m(reference, problem, foot, at.position_m), at.error_bound_m + 2.0 * slack) << recipe;
    }
    check_certificate(recipe, problem, set, result, reference);
  }

 private:
  static double target_m(const Recipe& recipe) { return recipe.feet > 64 ? 3e-9 : 1e-9; }

  // The certificate holds for the balance's own forces, where it is near the solver's bound, and for any others at any pose.
  void check_certificate(const Recipe& recipe, const PoseProblem& problem, const PrimitiveSet& set, const PoseSolved& result,
                         const PoseReference& reference) {
    const double slack = static_cast<double>(reference.bound_m);
    const double own_m = PoseSolver::error_bound_m(set, result.forces_n, problem.step(), result.balance);
    EXPECT_GE(own_m + slack, error_m(reference, problem, result.balance)) << recipe;
    worst_own_m_ = std::max(worst_own_m_, own_m);
    // Where springs are soft, the rounding of the pose to doubles shows in the bound, with its root.
    if (!family().is_extreme) {
      EXPECT_LE(own_m, target_m(recipe)) << recipe;
    }
    Random random(recipe.seed + 5);
    for (const double share : {1.0, 1e-4, 1e-9}) {
      Balance at = result.balance;
      at.position_m += share * random.in_cube(0.003);
      at.turn_rad += share * random.in_cube(0.1);
      std::vector<Vec3> forces = result.forces_n;
      for (Vec3& force : forces) force += share * random.in_cube(3.0);
      EXPECT_GE(PoseSolver::error_bound_m(set, forces, problem.step(), at) + slack, error_m(reference, problem, at))
          << recipe << ", share " << share;
    }
  }

 protected:
  int problems_ = 0, above_ = 0, uncertified_ = 0;
  double worst_error_m_ = 0.0, worst_bound_m_ = 0.0, worst_own_m_ = 0.0;
};

TEST_P(PoseAccuracy, NeverExceedsTheBound) {
  const int n = times();
  over({1, 2, 3, 4}, 60 * n, [&](const Recipe& recipe) { check(recipe); });
  over({8}, 30 * n, [&](const Recipe& recipe) { check(recipe); });
  over({16}, 20 * n, [&](const Recipe& recipe) { check(recipe); });
  over({64}, 2 + n / 2, [&](const Recipe& recipe) { check(recipe); });
  over({256}, 1 + n / 20, [&](const Recipe& recipe) { check(recipe); });
  EXPECT_LE(above_, family().is_extreme ? 0.005 * problems_ + 2.0 : 1e-4 * problems_ + 1.0) << "above 1e-9 m";
  std::printf("%d problems: error <= %.1e m, bound <= %.1e m, certificate <= %.1e m, above the target %d, not certified %d\n",
              problems_, worst_error_m_, worst_bound_m_, worst_own_m_, above_, uncertified_);
}

TEST_P(PoseAccuracy, IsKeptAlongAWarmPath) {
  over({1, 2, 4, 16}, 4, [&](const Recipe& recipe) {
    PoseProblem problem = recipe.problem();
    Random random(recipe.seed + 1);
    const std::size_t capacity = std::max<std::size_t>(2, problem.primitives.size());
    PoseSolver solver(capacity, problem.levers_m.size());
    PrimitiveSet set(capacity);
    for (int tick = 0; tick < 6; ++tick) {
      const PoseSolved result = solved(problem, solver, set);
      const PoseReference reference = reference_pose(problem);
      ASSERT_TRUE(reference.certified) << recipe << ", tick " << tick;
      EXPECT_LE(error_m(reference, problem, result.balance),
                result.balance.error_bound_m + static_cast<double>(reference.bound_m))
          << recipe << ", tick " << tick;
      const double far = tick % 2 == 0 ? 1e-6 : 1e-4;
      problem.probe.position_m += random.in_cube(far);
      problem.probe.turn = turned_further(problem.probe.turn, 30.0 * random.in_cube(far));
    }
  });
}

INSTANTIATE_TEST_SUITE_P(Over, PoseAccuracy, testing::Range<std::size_t>(0, pose_families().size()),
                         [](const auto& test) { return std::string(pose_families()[test.param].name); });

// The reference's own proof against closed forms: one point at a foot, and turns alone.
TEST(PoseReference, IsTheClosedFormOfOneFoot) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    PoseProblem problem;
    problem.start = problem.probe = {random.in_cube(0.05), random_turn(random, 3.0)};
    problem.levers_m = {random.in_cube(0.05)};
    const Vec3 q = random.direction();
    const double depth_m = random.uniform(0.0, 0.004);
    Primitive plane{PrimitiveKind::plane, {}, problem.step().foot_m(0) + depth_m * q, q, 1e3};
    problem.primitives = {plane};
    const PoseReference reference = reference_pose(problem);
    ASSERT_TRUE(reference.certified);
    const double rho = problem.turning_radius_m;
    const Vec3 turning = cross(problem.levers_m[0] / rho, q);
    const double force_n = problem.stiffness_n_per_m * depth_m / (1.0 + norm_squared(turning));
    Balance expected;
    expected.position_m = problem.start.position_m + force_n / problem.stiffness_n_per_m * q;
    expected.turn_rad = force_n / problem.stiffness_n_per_m / rho * turning;
    EXPECT_LE(error_m(reference, problem, expected), 1e-16);
  }
}

TEST(PoseReference, TurnsAsTheDeviceDoesInFreeSpace) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    PoseProblem problem;
    problem.levers_m = {random.in_cube(0.05)};
    problem.start.turn = random_turn(random, 3.0);
    const Vec3 turn_rad = std::pow(10.0, random.uniform(-9, 0)) * random.uniform(0, 3.1) * random.direction();
    problem.probe.turn = turned_further(problem.start.turn, turn_rad);
    Balance expected;
    expected.turn_rad = turn_rad;
    EXPECT_LE(error_m(reference_pose(problem), problem, expected), 2e-15 * problem.turning_radius_m);
  }
}

TEST(PoseReference, TakesNoWrongPoseForTheBalance) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    const PoseProblem problem = pose_families()[seed % 14].make(random, 4);
    Balance at = solved(problem).balance;
    const Vec3 way_m = random.in_cube(1e-5), turn_rad = random.in_cube(1e-4);
    at.position_m += way_m, at.turn_rad += turn_rad;
    const double off_m = std::hypot(norm(way_m), problem.turning_radius_m * norm(turn_rad));
    EXPECT_NEAR(error_m(reference_pose(problem), problem, at), off_m, at.error_bound_m + 1e-14);
  }
}

}  // namespace pose_reference_test
}  // namespace palpa::test
